"""Nonsmooth Gauss-Seidel iteration for friction in space: what :class:`BlockGaussSeidel` does with cones.

Sources: Jean 1999 (nonsmooth contact dynamics); Bonnefon & Daviet 2011 (the exact solution of one contact).
"""

from __future__ import annotations

from lcpflex.solvers.contact.cones.runs import ConeRun, own_units, start_of
from lcpflex.solvers.contact.looks import SWEPT, by_looks
from lcpflex.solvers.contact.spatial import SpatialContactProblem
from lcpflex.solvers.guard import guarded
from lcpflex.solvers.problem import Solution

__all__ = ["sweep_to_solution"]


def sweep_to_solution(
    problem: SpatialContactProblem, guess: Solution | None, tolerance: float, sweep_limit: int
) -> Solution:
    """Sweeps until the residual is within the tolerance, from the forces of the guess."""
    alike, start = problem.balanced(), start_of(problem, guess)

    def solve() -> Solution:
        return by_looks(ConeRun(alike, start), tolerance, sweep_limit)

    return own_units(problem, guarded(SWEPT, alike, tolerance, solve), tolerance)
