"""What may end a run before its duration: energy that contact impulses create, and the time of computing."""

from __future__ import annotations

import time

from lcpflex.results.energy_balance import GROWTH, created
from lcpflex.runs.setup import Run
from lcpflex.steppers.user_functions import advance

__all__ = ["TOO_LATE", "Limits"]

TOO_LATE = "the time limit of"  # begins the message of a run that was given up


class Limits:
    """Ends a run where it has created more energy than rounding explains, or has computed for too long.

    Parameters
    ----------
    growth
        What lets contact impulses of the run create energy, for the message; empty where they may.
    seconds
        Of computing, compilation not counted; None for any.
    """

    def __init__(self, growth: str = "", seconds: float | None = None) -> None:
        self._growth = growth
        self._seconds = seconds
        self._known = 0.0  # energy created so far that has been found to be rounding [J]
        self._began = time.perf_counter()

    def begin(self) -> None:
        """Compiling has ended, and computing begins."""
        self._began = time.perf_counter()

    def advance(self, run: Run, n_steps: int) -> str:
        """Make up to n_steps steps of the run; empty, or why it cannot go on."""
        if n_steps and self._seconds is not None and time.perf_counter() - self._began > self._seconds:
            return f"{TOO_LATE} {self._seconds:g} s is over"
        if not self._growth:
            return advance(run, n_steps)
        message = advance(run, 0)
        for _ in range(n_steps):  # one by one
            if message or run.finished:
                break
            message = advance(run, 1) or self._grown(run)
        return message

    def _grown(self, run: Run) -> str:
        """Why the energy created so far is too much; empty if it is not."""
        gain = run.records.gain
        if gain[0] <= 2.0 * self._known:
            return ""
        self._known = gain[0]
        if gain[0] <= GROWTH * run.records.energy_scale():
            return ""
        return created(gain, self._growth) + "; energy_growth=EnergyGrowth.WARN goes on"
