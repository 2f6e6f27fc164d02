"""From the command line to the table."""

from __future__ import annotations

import contextlib
import sys
import tempfile
import threading
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path

from tests.comparison.checkouts import Checkout, NoWorkerError, Run
from tests.comparison.difference import Outcome, compared
from tests.comparison.options import BadArgumentError, chosen, parser
from tests.comparison.record import file_of, load
from tests.comparison.table import exit_code, table
from tests.comparison.worker import work

__all__ = ["main"]

WORKER = "--worker"


def main(arguments: Sequence[str]) -> int:
    """The exit code; the table goes to stdout, progress and errors to stderr."""
    if arguments[:1] == [WORKER]:
        work(Path(arguments[1]), Path(arguments[2]) if len(arguments) > 2 else None)
        return 0
    line = parser()
    try:
        asked = line.parse_args(arguments)
    except SystemExit as end:
        return int(end.code or 0)
    try:
        with _folder(asked.keep) as kept:
            old = Checkout("old", asked.old, asked.old_python, kept / "old", asked.seconds)
            new = Checkout("new", asked.new, asked.new_python, kept / "new", asked.seconds)
            return _compare(old, new, asked.scenes, asked.steppers, asked.jobs, asked.list)
    except (BadArgumentError, NoWorkerError) as error:
        print(f"compare.py: error: {error}", file=sys.stderr)
        return 2


def _compare(
    old: Checkout, new: Checkout, scenes: Sequence[str] | None, steppers: Sequence[str] | None, jobs: int, lists: bool
) -> int:
    there = {side.name: side.scenes() for side in (old, new)}
    either = tuple(dict.fromkeys((*there["old"], *there["new"])))
    asked = chosen(scenes, steppers, either)
    both = tuple(run for run in asked if run[0] in there["old"] and run[0] in there["new"])
    wanted = dict.fromkeys(scene for scene, _ in asked)
    alone = {
        side: [scene for scene in wanted if scene in there[side] and scene not in there[other]]
        for side, other in (("old", "new"), ("new", "old"))
    }
    if lists:
        print("\n".join(f"{scene}  {stepper}" for scene, stepper in both))
        return 0
    _run_all((old, new), both, jobs)
    outcomes: dict[Run, Outcome] = {
        run: compared(load(file_of(old.runs, *run)), load(file_of(new.runs, *run))) for run in both
    }
    print(table(outcomes, alone))
    return exit_code(outcomes)


def _run_all(sides: Sequence[Checkout], runs: Sequence[Run], jobs: int) -> None:
    """Make all runs of both, with so many processes at a time; scenes stay together, for what they share."""
    shares = max(1, jobs // 2)
    scenes = list(dict.fromkeys(scene for scene, _ in runs))
    progress = Progress(2 * len(runs))
    with ThreadPoolExecutor(jobs) as pool:
        parts = [
            pool.submit(side.make, [run for run in runs if scenes.index(run[0]) % shares == k], progress.tell)
            for k in range(shares)
            for side in sides
        ]
        for part in parts:
            part.result()


@dataclass(slots=True)
class Progress:
    """A line on stderr for each of ``total`` runs."""

    total: int
    made: int = 0
    lock: threading.Lock = field(default_factory=threading.Lock)

    def tell(self, line: str) -> None:
        """That a run has ended."""
        with self.lock:
            self.made += 1
            print(f"[{self.made}/{self.total}] {line}", file=sys.stderr, flush=True)


@contextlib.contextmanager
def _folder(asked: Path | None) -> Iterator[Path]:
    """The folder to keep runs in, with one for each checkout; one that goes if none is asked for."""
    with contextlib.ExitStack() as stack:
        kept = Path(stack.enter_context(tempfile.TemporaryDirectory())) if asked is None else asked.resolve()
        for side in ("old", "new"):
            folder = kept / side
            try:
                folder.mkdir(parents=True, exist_ok=True)
                for former in folder.glob("*@*.npz"):
                    former.unlink()
            except OSError as error:
                raise BadArgumentError(
                    f"--keep: {str(asked)!r} was given; expected a folder to write to ({error.strerror})"
                ) from error
        yield kept
