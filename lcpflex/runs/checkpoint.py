"""Checkpoints: a run on disk, from which it goes on bit for bit. Reading and writing are both here.

One npz file of named arrays, never unpickled: ``format`` ("lcpflex checkpoint 1"), ``structure`` (a JSON text), and the
arrays that it names (:mod:`lcpflex.runs.object_tree`). The structure holds

    made        versions of lcpflex and its sources, and of what else the last bits depend on
    options     duration, interval, and so on
    scene       what the scene was compiled to, but for functions; of a user's own system its numbers
    stepper     its class and fields; null where one of them is a function
    missing     what the file cannot hold, and has to be given again: of the scene, of the stepper; empty where nothing
    stamp       texts and code of the functions that have to be given again, to tell others from them
    run         the state of the run: all that is recorded, and all that its stepper remembers
    recorder, calls, spent, at    contact problems kept, calls of Python functions, wall time [s], (time [s], duration)
"""

from __future__ import annotations

import json
import logging
import os
import signal
import threading
import time
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from lcpflex.basics.archives import load_arrays
from lcpflex.basics.progress import tell
from lcpflex.basics.whole_file import whole_file
from lcpflex.errors import ModelError, in_range, shown, writable_path
from lcpflex.runs.object_tree import Arrays, Unkept, freeze, thaw
from lcpflex.runs.stamp import described

if TYPE_CHECKING:
    from types import FrameType

    from lcpflex.basics.stopwatch import Stopwatch
    from lcpflex.runs.setup import Run, Setup

__all__ = ["Checkpoint", "Checkpoints", "read"]

FORMAT = "lcpflex checkpoint 1"
SHARE = 0.02  # of the wall time that writing may take


@dataclass(frozen=True, slots=True)
class Checkpoint:
    """What a file holds."""

    path: str
    structure: Mapping[str, Any]
    arrays: Mapping[str, Any]

    @property
    def finished(self) -> bool:
        """Whether the run had come to its end."""
        return bool(self.structure["at"][0] >= self.structure["at"][1])

    def check(self) -> None:
        """Raise ValueError or KeyError where an entry that is read as it is has another form."""
        texts = [self.structure["made"], self.structure["missing"], self.structure["stamp"]["functions"]]
        texts.append({"stepper": self.structure["stamp"]["stepper"]})
        if not all(isinstance(one, dict) and all(isinstance(text, str) for text in one.values()) for one in texts):
            raise ValueError("other entries than expected")
        at, duration = self.structure["at"]
        if not 0.0 <= float(at) <= float(duration):
            raise ValueError("a time that cannot be")

    def thawed(self, name: str, live: Any = None) -> Any:
        """An entry of the structure."""
        try:
            return thaw(self.structure[name], self.arrays, live, name, {})
        except Exception as error:  # entries of a damaged file may be anything
            raise self.damaged(error) from error

    def restore(self, setup: Setup, run: Run) -> tuple[float, float]:
        """Put the state of the run back into ``run``, at its beginning; the wall time so far, as a Stopwatch tells."""
        begin_again = getattr(getattr(run, "method", None), "begin_again", None)
        if begin_again is not None:
            begin_again()
        self.thawed("run", run)
        run.records.restored()
        if setup.problem_log is not None:
            setup.problem_log.seen, setup.problem_log.stride, setup.problem_log.kept = self.thawed("recorder")
        if setup.system.calls is not None:
            setup.system.calls.number, setup.system.calls.time = self.thawed("calls")
        computing, loading = self.thawed("spent")
        return float(computing), float(loading)

    def damaged(self, error: Exception) -> ModelError:
        """What to raise where the file does not hold what it should."""
        return _no_checkpoint(self.path, error)


def _no_checkpoint(path: str, error: Exception) -> ModelError:
    words = str(error)
    short = words if len(words) <= 160 else words[:157] + "..."
    return ModelError(
        f"path: {shown(path)} is no complete checkpoint of lcpflex ({type(error).__name__}: {short}), expected a file "
        "that simulate(..., checkpoint=path) wrote"
    )


def read(path: str | os.PathLike[str]) -> Checkpoint:
    """Read a checkpoint. Raises ModelError, with the path, for what is none, or is damaged."""
    try:
        target = os.fspath(path)
        with Path(target).open("rb") as opened, load_arrays(opened) as file:
            if not isinstance(file, np.lib.npyio.NpzFile):
                raise ValueError("an array alone")
            found = str(file["format"])[:60] if "format" in file else "no such entry"
            if found != FORMAT:
                raise ModelError(f"path: {shown(target)} has the format {shown(found)}, expected {FORMAT!r}")
            entries = [] if file.zip is None else file.zip.infolist()
            if any(entry.compress_type != zipfile.ZIP_STORED for entry in entries):
                raise ValueError("it is compressed, and may be larger than it looks")
            structure = json.loads(str(file["structure"]))
            arrays = {name: file[name] for name in file.files if name not in ("format", "structure")}
            kept = Checkpoint(str(target), {name: structure[name] for name in ENTRIES}, arrays)
            kept.check()
            return kept
    except ModelError:
        raise
    except OSError as error:
        words = f"cannot read {shown(str(path))} ({error.strerror or error})"
        raise ModelError(f"path: {words}, expected a file that simulate(..., checkpoint=path) wrote") from error
    except Exception as error:  # whatever zipfile, its codecs, numpy and json stumble over
        if isinstance(error, TypeError) and not isinstance(path, str | os.PathLike):
            raise ModelError(f"path: {shown(path)} was given, expected the name of a file") from None
        raise _no_checkpoint(str(path), error) from error


ENTRIES = ("made", "options", "scene", "stepper", "missing", "stamp", "run", "recorder", "calls", "spent", "at")


class Checkpoints:
    """Writes checkpoints of a run to ``path``, about every ``every`` [s] of wall time."""

    def __init__(self, path: str | os.PathLike[str], every: float) -> None:
        self._path = writable_path("checkpoint", path)
        self._every = in_range("every", every, 0.0, float("inf"))
        self._failed = self._stretched = self._whole = False
        self._asked = 0
        self._handler: Any = None

    def refuse_others(self) -> None:
        """Raise ModelError where the file is there, and holds anything but the checkpoint of a run that has ended."""
        if not self._path.exists():
            return
        try:
            there = read(self._path)
        except ModelError:
            raise ModelError(
                f"checkpoint: {str(self._path)!r} is there, and no checkpoint that this lcpflex reads, expected a new "
                "name"
            ) from None
        if not there.finished:
            at, duration = there.structure["at"]
            raise ModelError(
                f"checkpoint: {str(self._path)!r} holds a run that has come to t = {at:.6g} s of {duration:.6g} s; "
                "lf.resume(path) goes on with it, or remove the file to begin anew"
            )

    def begin(self, setup: Setup, run: Run, clock: Stopwatch, spent: tuple[float, float], kept: bool) -> None:
        """The run begins, or goes on from what is ``kept``. Raises ModelError where it cannot be written."""
        self._setup, self._run, self._clock, self._spent = setup, run, clock, spent
        self._fixed: Arrays = {}
        self._head = described(setup, self._fixed)
        self._next = time.perf_counter() + self._every
        self._whole = True
        if not kept:
            self._write()

    def chunk_begins(self) -> None:
        """The run is on its way, and what it holds is not whole; Ctrl-C waits until it is, a second one does not."""
        self._whole = False
        if threading.current_thread() is threading.main_thread():
            present = signal.getsignal(signal.SIGINT)
            if present is signal.default_int_handler:
                self._handler = present
                signal.signal(signal.SIGINT, self._interrupt)

    def chunk_ends(self) -> None:
        """The run is whole; write what is due. Raises KeyboardInterrupt where that was asked for in between."""
        self._whole = True
        self._release()
        if self._asked:
            raise KeyboardInterrupt
        if time.perf_counter() >= self._next:
            self._try()

    def end(self, run_is_right: bool) -> None:
        """The run has ended, or was interrupted: write where it is, unless it was in the midst of something."""
        self._release()
        if run_is_right and self._whole:
            self._try()
        self._fixed = {}

    def _interrupt(self, number: int, frame: FrameType | None) -> None:
        self._asked += 1
        if self._asked > 1:
            raise KeyboardInterrupt

    def _release(self) -> None:
        if self._handler is not None:
            signal.signal(signal.SIGINT, self._handler)
            self._handler = None

    def _try(self) -> None:
        """Write a checkpoint; where that fails, say so once and go on: a warning that is an error would end the run."""
        began = time.perf_counter()
        try:
            self._write()
        except (ModelError, MemoryError) as error:
            if not self._failed:
                tell(f"a checkpoint was not written, the run goes on: {error}", logging.WARNING)
            self._failed = True
        now = time.perf_counter()
        pause = max(self._every, (now - began) / SHARE)
        if pause > 1.5 * self._every > 0.0 and not self._stretched and not self._failed:
            self._stretched = True
            tell(
                f"a checkpoint takes {now - began:.3g} s: from now on one is written every {pause:.3g} s, not every "
                f"{self._every:.3g} s, for at most {100.0 * SHARE:g} % of the time",
                logging.WARNING,
            )
        self._next = now + pause

    def _write(self) -> None:
        run, setup, problem_log = self._run, self._setup, self._setup.problem_log
        arrays = dict(self._fixed)
        run.records.merge()
        calls = setup.system.calls
        spent = [before + now for before, now in zip(self._spent, self._clock.so_far(), strict=True)]
        kept = None if problem_log is None else [problem_log.seen, problem_log.stride, problem_log.kept]
        try:
            structure = {
                **self._head,
                "run": freeze(run, "run", arrays, {}),
                "recorder": freeze(kept, "recorder", arrays),
                "calls": {"list": [0, 0.0] if calls is None else [calls.number, calls.time]},
                "spent": {"list": spent},
                "at": [setup.options.duration if run.finished else run.time, setup.options.duration],
            }
        except Unkept as error:
            raise ModelError(
                f"stepper: {shown(setup.stepper)} was given, expected one of lcpflex: of others no checkpoint can be "
                f"made ({error})"
            ) from error
        with whole_file("checkpoint", self._path) as part, part.open("wb") as file:
            np.savez(file, format=np.array(FORMAT), structure=np.array(json.dumps(structure)), **arrays)  # type: ignore[arg-type]


def given_again(missing: Mapping[str, str], path: str, what: str) -> ModelError:
    """What to raise where the scene or the stepper has to be given again."""
    return ModelError(
        f"{what}: none was given, and {shown(path)} holds none: {missing[what]}; expected lf.resume(path, {what}=...) "
        "with the one that the run began with"
    )
