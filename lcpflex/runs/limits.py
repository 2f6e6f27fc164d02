"""What may end a run before its duration: energy that contacts create, a budget of time, and one of counted work."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from lcpflex.basics.stopwatch import Budget
from lcpflex.results.energy_balance import GROWTH, created
from lcpflex.runs.setup import Run
from lcpflex.steppers.user_functions import advance

if TYPE_CHECKING:
    from lcpflex.runs.default_stepper import Choice

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
    choice
        How the stepper was chosen, and how much work it may take; None where it was given.
    most
        Steps and events, after which the run ends.
    """

    def __init__(self, growth: str, budget: Budget, choice: Choice | None = None, most: float = math.inf) -> None:
        self._growth, self._budget, self._choice, self._most = growth, budget, choice, most
        self._known = 0.0  # energy created so far that has been found to be rounding [J]
        self.late = False  # whether the budget has ended the run
        self.grown = False  # whether energy has

    def advance(self, run: Run, n_steps: int) -> str:
        """Make up to n_steps steps of the run; empty, or why it cannot go on."""
        n_steps = int(min(n_steps, max(self._most - run.steps, 0)))
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
        many = run.steps + len(run.events) >= self._most
        self.late = not run.finished and (many or self._budget.is_spent)
        if self.late and many:
            return f"{TOO_LATE} {self._most:,.0f} steps and events is spent"
        return f"{TOO_LATE} {self._budget.seconds:g} s of computing is spent" if self.late else ""

    def overworked(self, run: Run) -> str:
        """That the run has taken more work than a stepper that was chosen may take; also of one at its end."""
        return "" if self._choice is None else self._choice.overworked(run)

    def _grown(self, run: Run) -> str:
        """Why the energy created so far is too much; empty if it is not."""
        gain = run.records.gain
        if gain[0] <= 2.0 * self._known:
            return ""
        self._known = gain[0]
        if gain[0] <= GROWTH * run.records.energy_scale():
            return ""
        self.grown = True
        return created(gain, self._growth) + "; energy_growth=EnergyGrowth.WARN goes on"
