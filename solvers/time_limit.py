"""A solver that is given so much time for each solve."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from lcpflex.errors import ModelError
from lcpflex.solvers.clock import check_time_limit, within
from lcpflex.solvers.solution import LcpSolver, PosedProblem, Problem, Solution
from lcpflex.solvers.user_solver import UserSolver, as_solver

__all__ = ["TimeLimit"]


@dataclass(frozen=True, slots=True)
class TimeLimit:
    """A solver that is given so much time for each solve.

    A solver of this package looks at the clock between its iterations and returns the best point it has, with the
    status TIME_LIMIT; it may take a little longer, for an iteration is not cut short, and compiling counts. Any other
    solver (see :class:`lcpflex.solvers.UserSolver`) runs in a process of its own, which is killed when the time is up.

    solver: the solver, or a callable. seconds [s]: > 0. Raises ModelError for anything else.
    """

    solver: Any
    seconds: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "seconds", check_time_limit("seconds", self.seconds))
        if self.seconds is None:
            raise ModelError("seconds is None: expected a number of seconds > 0")
        solver = as_solver(self.solver)
        if isinstance(solver, UserSolver):
            least = min(self.seconds, solver.time_limit or self.seconds)
            solver = replace(solver, time_limit=least)
        object.__setattr__(self, "solver", solver)

    @property
    def tolerance(self) -> float:
        """That of the solver."""
        return float(getattr(self.solver, "tolerance", 1e-10))

    @property
    def model(self) -> str:
        """What the solver solves instead of the problem, if it does."""
        return str(getattr(self.solver, "model", ""))

    def refuses(self, problem: Problem | PosedProblem) -> str:
        """Why the solver cannot take the problem; empty if it can."""
        inner: LcpSolver = self.solver
        return inner.refuses(problem)  # type: ignore[arg-type]

    def solve(self, problem: Problem | PosedProblem, guess: Solution | None = None) -> Solution:
        """What the solver finds in its time.

        problem: an :class:`Lcp`, a :class:`ContactProblem` or another problem that is posed as one. guess: the
        solution of a similar problem to start from, or None.
        """
        inner: LcpSolver = self.solver
        with within(self.seconds):
            return inner.solve(problem, guess)  # type: ignore[arg-type]
