"""What the methods of problems and solvers are given: checked, so that each refusal names its argument."""

from __future__ import annotations

from typing import Any

from lcpflex.errors import ModelError, as_number, shown
from lcpflex.solvers.limits import check_limit, check_tolerance
from lcpflex.solvers.solution import PosedProblem, Solution

__all__ = ["check_guess", "check_options", "check_problem", "check_repeats", "check_solver", "posed"]


MOST_REPEATS = 1_000_000
_WAYS = ("lcp", "solve_by", "residual", "slack")
_POSED: set[type] = set()  # types that are known to have them


def posed(problem: Any) -> PosedProblem:
    """A problem that an LCP solver takes by way of its :meth:`lcp`. Raises ModelError for anything else."""
    if type(problem) in _POSED:
        return problem  # type: ignore[no-any-return]
    ways = (getattr(problem, name, None) for name in _WAYS)
    if not isinstance(problem, type) and all(callable(way) for way in ways):
        if all(callable(getattr(type(problem), name, None)) for name in _WAYS):
            _POSED.add(type(problem))
        sound: PosedProblem = problem
        return sound
    raise ModelError(f"problem is {shown(problem)}: expected an Lcp, a ContactProblem, or another posed problem")


def check_guess(guess: Any) -> None:
    """Raise ModelError for a guess that is neither None nor a :class:`Solution`."""
    if guess is not None and not isinstance(guess, Solution):
        raise ModelError(f"guess is {shown(guess)}: expected the Solution of a similar problem, or None")


def check_solver(solver: Any) -> None:
    """Raise ModelError for what cannot solve an LCP."""
    if isinstance(solver, type) or not callable(getattr(solver, "solve", None)):
        raise ModelError(f"solver is {shown(solver)}: expected a solver such as Auto()")


def check_repeats(repeats: int) -> None:
    """Raise ModelError for what is no integer from 1 to a million."""
    if repeats is None or not as_number(repeats) <= MOST_REPEATS:
        raise ModelError(f"repeats is {shown(repeats)}: expected a positive integer up to {MOST_REPEATS}")
    check_limit("repeats", repeats)


def check_options(repeats: int, tolerance: float | None) -> None:
    """Raise ModelError for repeats < 1, and for a tolerance that is none."""
    check_repeats(repeats)
    if tolerance is not None:
        check_tolerance(tolerance)


def check_problem(name: str, problem: Any) -> None:
    """Raise ModelError for problems that no solver takes."""
    if isinstance(problem, type) or not all(hasattr(problem, part) for part in ("size", "slack", "residual")):
        kind = type(problem).__name__
        raise ModelError(f"{name} is a {kind}, which no solver takes: expected Lcp, ContactProblem, or a posed one")
