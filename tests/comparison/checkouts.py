"""The processes that run scenes: one after the other for a list of runs, so that none takes another with it."""

from __future__ import annotations

import contextlib
import json
import os
import queue
import subprocess
import tempfile
import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import IO

from tests.comparison.record import died, file_of, save
from tests.comparison.worker import BEGINS, FINISHED, SCENES

__all__ = ["Checkout", "NoWorkerError", "Run"]

SCRIPT = Path(__file__).resolve().parents[1] / "compare.py"
ONE_THREAD = dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"), "1")
STARTS = 120.0  # a process is given for imports, at least [s]
SAID = 2000  # characters of what a dead worker wrote last

Run = tuple[str, str]  # scene and stepper


class NoWorkerError(Exception):
    """A checkout that cannot be run at all."""


@dataclass(frozen=True, slots=True)
class Checkout:
    """A folder with lcpflex in it, the python to run it with, and where its runs are kept.

    Attributes
    ----------
    name
        What it is called in what is told.
    folder, python
        Of the checkout, and the interpreter.
    runs
        Folder in which each run is kept.
    seconds
        Time after which a run without an end is given up, and its process killed [s].
    """

    name: str
    folder: Path
    python: str
    runs: Path
    seconds: float

    def scenes(self) -> tuple[str, ...]:
        """Names of the scenes of its gallery. Raises NoWorkerError with what its process said."""
        with tempfile.TemporaryFile("w+") as errors, self._worker(None, errors) as process:
            told, _ = process.communicate()
            lines = [line.partition("\t")[2] for line in told.splitlines() if line.startswith(f"{SCENES}\t")]
            if process.returncode or not lines:
                raise NoWorkerError(f"{self.name}: {self.folder} cannot be run:\n{_last(errors)}")
        return tuple(json.loads(lines[0]))

    def make(self, runs: Sequence[Run], tell: Callable[[str], None]) -> None:
        """Make the runs; one that hangs or ends its process is kept as died, and a new process makes the others."""
        left = list(runs)
        while left:
            made, hurt, why = self._made(left, tell)
            left = left[len(made) :]
            if hurt is None and left:  # it died between two runs
                hurt = left[0]
            if hurt is not None:
                save(died(why), file_of(self.runs, *hurt))
                tell(f"{self.name}: {hurt[0]}, {hurt[1]}: died ({why.splitlines()[0]})")
                left.remove(hurt)

    def _made(self, runs: Sequence[Run], tell: Callable[[str], None]) -> tuple[list[Run], Run | None, str]:
        """The runs that one process has made, the one that it died in, and why."""
        made: list[Run] = []
        with tempfile.TemporaryFile("w+") as errors, self._worker(self.runs, errors) as process:
            try:
                _give(process, runs)
                current, why = self._follow(_lines_of(process), made, tell)
            except BaseException:
                process.kill()
                raise
            if why:
                process.kill()
            process.wait()
            if process.returncode and ((not made and current is None) or len(made) == len(runs)):
                raise NoWorkerError(f"{self.name}: {self.folder} cannot be run: {why}\n{_last(errors)}")
            return made, current, why or f"its process ended with {process.returncode}: {_last(errors)}"

    def _follow(
        self, lines: queue.Queue[list[str] | None], made: list[Run], tell: Callable[[str], None]
    ) -> tuple[Run | None, str]:
        """Read what a process writes to its end; the run that it has begun and not ended, and why it is to be killed.

        made: gets the runs that were made.
        """
        current: Run | None = None
        until = time.monotonic() + max(self.seconds, STARTS)
        while True:
            try:
                words = lines.get(timeout=max(0.0, until - time.monotonic()))
            except queue.Empty:
                return current, f"no end after {self.seconds:g} s"
            if words is None:
                return current, ""
            if words[0] == BEGINS:
                current, until = (words[1], words[2]), time.monotonic() + self.seconds
            elif words[0] == FINISHED and current is not None:
                made.append(current)
                tell(f"{self.name}: {current[0]}, {current[1]}: {words[3]} s")
                current = None

    def _worker(self, runs: Path | None, errors: IO[str]) -> subprocess.Popen[str]:
        command = [self.python, str(SCRIPT), "--worker", str(self.folder)]
        command += [] if runs is None else [str(runs)]
        return subprocess.Popen(
            command,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=errors,
            text=True,
            cwd=tempfile.gettempdir(),
            env=os.environ | ONE_THREAD | {"PYTHONHASHSEED": "0", "MPLBACKEND": "Agg"},
        )


def _give(process: subprocess.Popen[str], runs: Sequence[Run]) -> None:
    assert process.stdin is not None
    for act in (lambda: process.stdin.write(json.dumps(runs)), process.stdin.close):
        with contextlib.suppress(BrokenPipeError):  # it is dead already, which the end of its lines tells
            act()


def _lines_of(process: subprocess.Popen[str]) -> queue.Queue[list[str] | None]:
    """What the process writes, line by line, its words apart; None at its end."""
    lines: queue.Queue[list[str] | None] = queue.Queue()

    def read() -> None:
        assert process.stdout is not None
        for line in process.stdout:
            lines.put(line.rstrip("\n").split("\t"))
        lines.put(None)

    threading.Thread(target=read, daemon=True).start()
    return lines


def _last(errors: IO[str]) -> str:
    """The end of what a process wrote to stderr."""
    errors.seek(0)
    return errors.read()[-SAID:].strip() or "it said nothing"
