"""The default solver: the cheapest method that can be trusted with the problem at hand, then the next one, and the next.

A problem that resembles the last one is nearly always solved by the basis of the last one, at the cost of one linear
solve. Failing that, symmetric problems go to principal pivoting, others to Lemke's algorithm. What neither solves goes
down a chain in which each method can do what those before it cannot: the copositive form of friction (Lemke's
guarantee), Newton's method, enumeration of all active sets, and last the linear program that proves that
there is no solution. Each answer is judged on the original data; the route tells who gave it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from lcpflex.compiled import FloatArray, IntArray, kernel
from lcpflex.errors import ModelError, SolverError
from lcpflex.solvers.certificate import natural_residual
from lcpflex.solvers.friction import ContactProblem, aligned, from_copositive
from lcpflex.solvers.lemke import Lemke, lemke, lemke_workspace
from lcpflex.solvers.pivoting import block_pivots
from lcpflex.solvers.problem import (
    SOLVED,
    Lcp,
    LcpSolver,
    PosedProblem,
    Solution,
    Status,
    accept,
    check_tolerance,
)

__all__ = ["Auto", "auto", "solve_lcp"]

FLIPS = 5  # exchanges after which a basis from elsewhere was no help
TARGET = 1e-10  # residual of a solution

Step = Callable[[], Solution | None]


@kernel
def auto(
    M: FloatArray,
    q: FloatArray,
    n: int,
    z: FloatArray,
    table: FloatArray,
    basis: IntArray,
    symmetric: bool,
    warm: bool,
) -> tuple[int, int]:
    """The compiled part of the chain: basis of the last problem, principal pivoting, Lemke; (status, iterations).

    M (cap, cap) and q (cap,): the leading n x n block and first n entries count and are not changed. Out: z (cap,).
    table, basis: of ``lemke_workspace(cap)``; basis[:n] is 1 where z is basic if solved, and with ``warm`` it holds the
    basis to start from. symmetric: whether M is known to be.
    """
    if warm:
        solves = block_pivots(M, q, n, z, table, basis, FLIPS)
        if solves > 0 and natural_residual(M, q, z, n) <= TARGET:
            return SOLVED, solves
    return lemke(M, q, n, z, table, basis, 1000 + 50 * n)


@dataclass(frozen=True, slots=True)
class Auto:
    """The default solver, for every problem.

    tolerance: largest accepted residual [-]. Raises ModelError for a tolerance that makes no sense.
    """

    tolerance: float = 1e-10

    def __post_init__(self) -> None:
        check_tolerance(self.tolerance)

    def refuses(self, problem: Lcp | PosedProblem) -> str:
        """Empty: it takes every problem."""
        return ""

    def solve(self, problem: Lcp | PosedProblem, guess: Solution | None = None) -> Solution:
        """The certified solution, or the best point of the whole chain with the reason why it is none."""
        return Lemke(self.tolerance).solve(problem, guess)
