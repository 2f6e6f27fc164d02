"""What may end a run before its duration: energy that contact impulses create, and a budget of computing time."""

from __future__ import annotations

from lcpflex.basics.stopwatch import Budget
from lcpflex.results.energy_balance import GROWTH, created
from lcpflex.runs.setup import Run
from lcpflex.steppers.user_functions import advance

__all__ = ["TOO_LATE", "Limits"]

TOO_LATE = "the budget of"  # begins the message of a run that has computed for too long


class Limits:
    """Ends a run where it has created more energy than rounding explains, or has computed for too long.

    Parameters
    ----------
    growth
        What lets contact impulses of the run create energy, for the message; empty where they may.
    budget
        Of computing.
    """

    def __init__(self, growth: str, budget: Budget) -> None:
        self._growth, self._budget = growth, budget
        self._known = 0.0  # energy created so far that has been found to be rounding [J]
        self.late = False  # whether the budget has ended the run

    def advance(self, run: Run, n_steps: int) -> str:
        """Make up to n_steps steps of the run; empty, or why it cannot go on."""
        if not self._growth:
            return advance(run, n_steps)
        message = advance(run, 0)
        for _ in range(n_steps):  # one by one
            if message or run.finished:
                break
            message = advance(run, 1) or self._grown(run)
        return message

    def spent(self, run: Run) -> str:
        """That the run has computed for too long; empty where it has not, or has come to its end."""
        self.late = not run.finished and self._budget.is_spent
        return f"{TOO_LATE} {self._budget.seconds:g} s of computing is spent" if self.late else ""

    def _grown(self, run: Run) -> str:
        """Why the energy created so far is too much; empty if it is not."""
        gain = run.records.gain
        if gain[0] <= 2.0 * self._known:
            return ""
        self._known = gain[0]
        if gain[0] <= GROWTH * run.records.energy_scale():
            return ""
        return created(gain, self._growth) + "; energy_growth=EnergyGrowth.WARN goes on"
