"""Whether the active set that a point of an LCP stands on gives a solution: its equations and signs in fractions.

A point may fulfil every row to its last digit, and stand on an active set whose equations are so nearly singular that
their exact solution is another one, or has a wrong sign: then the last digits of the data decide, and floats do not
know them. That happens where the entries of M differ by many orders.
"""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING

import numpy as np

from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.solvers.lcp.exact_systems import Row, fractions

if TYPE_CHECKING:
    from lcpflex.solvers.problem import Lcp

__all__ = ["is_wide", "off_in_fractions"]

LARGEST = 16  # unknowns up to which it is looked at: one elimination in fractions, a few milliseconds
ROUNDED = Fraction(1, 2**50)  # of the terms of a row: what their sum in floats may lose
WIDE = 1e8  # ratio of the entries of M, in units, from which it is


@kernel
def is_wide(M: FloatArray, n: int) -> bool:
    """Whether the entries of M (n, n) that are not zero differ by so many orders that it is to be looked at."""
    if n > LARGEST:
        return False
    low, high = np.inf, 0.0
    for i in range(n):
        for j in range(n):
            size = abs(M[i, j])
            high = max(high, size)
            if size > 0.0:
                low = min(low, size)
    return high > WIDE * low


def off_in_fractions(problem: Lcp, z: FloatArray, active: FloatArray) -> float:
    """How far a component of z (n,) is from the exact solution on its active set, relative; 1 where that is none.

    active (n,): whether each z is basic. 0 where the equations are singular, which leaves z to be judged by its rows,
    and of a component whose difference no row feels beyond its rounding.
    """
    n = problem.size
    rows = problem.exact_system().rows(range(n))
    chosen = np.flatnonzero(active).tolist()
    x = _solved([[rows[i][j] for j in chosen] + [-rows[i][n]] for i in chosen])
    if x is None:
        return 0.0
    if any(value < 0 for value in x):
        return 1.0
    for i in range(n):
        if not active[i] and sum((rows[i][j] * v for j, v in zip(chosen, x, strict=True)), rows[i][n]) < 0:
            return 1.0
    point = fractions(z.tolist())
    terms = [sum((abs(a * b) for a, b in zip(row, point, strict=False)), abs(row[n])) for row in rows]
    off = 0.0
    for j, value in zip(chosen, x, strict=True):
        apart = abs(point[j] - value)
        if any(abs(row[j]) * apart > ROUNDED * size for row, size in zip(rows, terms, strict=True)):
            off = max(off, float(apart / value) if value else 1.0)
    return min(off, 1.0)


def _solved(rows: list[Row]) -> Row | None:
    """x of [A, b] with A x = b, None where A is singular."""
    m = len(rows)
    for k in range(m):
        pivot = next((i for i in range(k, m) if rows[i][k]), None)
        if pivot is None:
            return None
        rows[k], rows[pivot] = rows[pivot], rows[k]
        above = rows[k] = [value / rows[k][k] for value in rows[k]]
        for i in range(m):
            if i != k and rows[i][k]:
                factor = rows[i][k]
                rows[i] = [a - factor * b for a, b in zip(rows[i], above, strict=True)]
    return [row[m] for row in rows]
