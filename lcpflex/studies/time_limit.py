"""A stepper that gives up after some seconds of computing."""

from __future__ import annotations

import time
from typing import Any

__all__ = ["TOO_LATE", "TimeLimit"]

TOO_LATE = "the time limit of"  # begins the message of a run that was given up


class TimeLimit:
    """Any ``stepper``, whose runs stop with a message after ``seconds`` of computing, compilation not counted."""

    def __init__(self, stepper: Any, seconds: float) -> None:
        self.stepper = stepper
        self.seconds = seconds

    def __repr__(self) -> str:
        return repr(self.stepper)

    def __getattr__(self, name: str) -> Any:
        """The driver asks a stepper for its solver."""
        return getattr(self.stepper, name)

    def start(self, system: Any, duration: float, interval: float) -> _LimitedRun:
        """A run over ``duration`` [s] that stores an instant about every ``interval`` [s]."""
        return _LimitedRun(self.stepper.start(system, duration, interval), self.seconds)


class _LimitedRun:
    """A run that looks at the clock before each call."""

    def __init__(self, run: Any, seconds: float) -> None:
        self._run = run
        self._seconds = seconds
        self._began = time.perf_counter()

    def __getattr__(self, name: str) -> Any:
        return getattr(self._run, name)

    def advance(self, n_steps: int) -> str:
        """Make up to n_steps steps; empty, or why the run cannot go on."""
        late = n_steps > 0 and time.perf_counter() - self._began > self._seconds
        message: str = f"{TOO_LATE} {self._seconds:g} s is over" if late else self._run.advance(n_steps)
        if n_steps == 0:  # the call that compiles
            self._began = time.perf_counter()
        return message
