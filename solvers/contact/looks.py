"""Sweeps over contacts, and a look at the residual each time that twice as many are made: in the plane and in space."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, Protocol

import numpy as np

from lcpflex.jit.kernel import FloatArray
from lcpflex.solvers.clock import remaining
from lcpflex.solvers.contact.sweeps import FIRST_LOOK, LAST_DIGIT, RUNAWAY
from lcpflex.solvers.problem import Solution, Status, accept

__all__ = ["SWEPT", "Sweeping", "by_looks"]

SWEPT = "block Gauss-Seidel"


class Sweeping(Protocol):
    """An iteration of sweeps on a problem."""

    @property
    def problem(self) -> Any: ...

    @property
    def start(self) -> FloatArray:
        """The point that is kept if no other is better."""

    def sweep(self, sweeps: int, target: float) -> tuple[int, float]:
        """Up to so many sweeps; how many were made, and the largest change of a velocity in the last one."""

    def points(self) -> Iterable[tuple[FloatArray, str]]:
        """The points to be looked at, in turn until one is a solution, with what is added to the route then."""


def by_looks(run: Sweeping, tolerance: float, sweep_limit: int) -> Solution:
    """Sweep, look, sweep twice as often; the best point seen, judged."""
    problem = run.problem
    load = float(np.abs(problem.free).max(initial=0.0))
    target, look, sweeps = 0.1 * tolerance * load, FIRST_LOOK, 0
    best, least = run.start, problem.residual(run.start)
    route, status = SWEPT, Status.ITERATION_LIMIT
    while least > tolerance and sweeps < sweep_limit:
        if remaining() <= 0.0:
            status = Status.TIME_LIMIT
            break
        made, change = run.sweep(min(look, sweep_limit) - sweeps, target)
        sweeps, look = sweeps + made, 2 * look
        if not change < RUNAWAY * load:
            status = Status.NUMERICAL_FAILURE
            break
        for z, finished in run.points():
            residual = problem.residual(z)
            if residual < least:
                best, least = z, residual
            if least <= tolerance:
                route += finished
                break
        if change <= target:
            target *= 0.1
            if target < LAST_DIGIT * load:
                status = Status.NUMERICAL_FAILURE
                break
    return accept(problem, best, tolerance=tolerance, status=status, iterations=sweeps, route=route)
