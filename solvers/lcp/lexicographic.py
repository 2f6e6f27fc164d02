"""Lemke's path by the lexicographic rule: no perturbation, and ties broken as an infinitely small one would.

Where much is redundant many rows tie at each pivot, and a path on perturbed data wanders through all of them: 19,000
pivots on a pile of 118 contacts where this rule needs 93. Its comparisons need signs that rounding decides, so it is
one attempt among others. Source: Cottle, Pang & Stone, sections 4.4 and 4.9.
"""

from __future__ import annotations

import numpy as np

from lcpflex.jit.kernel import FloatArray, IntArray, kernel
from lcpflex.solvers.attention import is_called
from lcpflex.solvers.lcp.tableau import COLUMNS, PIVOT, TRUE
from lcpflex.solvers.status import ITERATION_LIMIT, RAY, SOLVED

__all__ = ["lexicographic_path"]

TIE = 1e-11  # difference of two ratios, relative to the larger, below which they count as equal
FIRM = 1e-9  # smallest pivot, relative to the largest entry of its column


@kernel
def pivot(table: FloatArray, n: int, r: int, s: int) -> None:
    """Exchange the basic variable of row r with the nonbasic one of column s: x_B = b + T x_N, b the row TRUE."""
    b, row = table[n + TRUE], table[r]
    inverse = 1.0 / row[s]
    for j in range(n + 1):
        row[j] *= -inverse
    row[s] = inverse
    step = -inverse * b[r]
    for i in range(n):
        if i != r:
            other = table[i]
            factor = other[s]
            if factor != 0.0:
                other[s] = 0.0
                for j in range(n + 1):
                    other[j] += factor * row[j]
                b[i] += factor * step
    b[r] = step


@kernel
def rate(table: FloatArray, basis: IntArray, n: int, i: int, k: int) -> float:
    """How fast the basic variable of row i grows with q_k."""
    column = basis[2 * n + 1 + k]
    if column < 0:
        return 1.0 if basis[i] == k else 0.0
    fall: float = table[i, column]
    return -fall


@kernel
def first_to_fall(table: FloatArray, basis: IntArray, n: int, s: int) -> int:
    """Row whose variable first falls to zero as that of column s grows, -1 if none does.

    Of rows that tie, the artificial variable 2 n, else the one that an infinitely small perturbation of q, falling from
    row to row, lets fall first. Rows that still tie are marked in the row COLUMNS of the table.
    """
    b, tied = table[n + TRUE], table[n + COLUMNS + 1]
    steepest, best = 0.0, np.inf
    for i in range(n):
        steepest = max(steepest, -table[i, s])
    if steepest <= PIVOT:
        return -1
    least = max(PIVOT, FIRM * steepest)
    for i in range(n):
        slope = -table[i, s]
        tied[i] = 0.0
        if slope > least:
            best = min(best, max(b[i], 0.0) / slope)
    count, last = 0, -1
    for i in range(n):
        slope = -table[i, s]
        if slope > least and max(b[i], 0.0) / slope <= best + TIE * max(best, 1.0):
            if basis[i] == 2 * n:
                return i
            tied[i] = 1.0
            count, last = count + 1, i
    k = 0
    while count > 1 and k < n:
        best = np.inf
        for i in range(n):
            if tied[i] == 1.0:
                best = min(best, rate(table, basis, n, i, k) / -table[i, s])
        count = 0
        for i in range(n):
            if tied[i] == 1.0:
                if rate(table, basis, n, i, k) / -table[i, s] <= best + TIE * max(abs(best), 1.0):
                    count, last = count + 1, i
                else:
                    tied[i] = 0.0
        k += 1
    return last


@kernel
def lexicographic_path(table: FloatArray, basis: IntArray, n: int, pivot_limit: int) -> tuple[int, int, int]:
    """Complementary pivots until the artificial variable leaves; (status, pivots, the column entered last).

    In: T[:n, :n] and b of the scaled problem, its covering vector in the row COLUMNS, labels as of Lemke's method: w_i
    is i, z_i n + i, the artificial variable 2 n. Out: the final tableau; its last column in the row COLUMNS.
    """
    b, cover = table[n + TRUE], table[n + COLUMNS]
    r, lowest = 0, np.inf
    for i in range(n):
        table[i, n] = cover[i]
        basis[2 * n + 1 + i] = -1  # column of w_i: it is basic
        if b[i] / cover[i] <= lowest:  # of equal ones the last: its own perturbation is the smallest
            r, lowest = i, b[i] / cover[i]
    s, pivots, status = n, 0, ITERATION_LIMIT
    while pivots < pivot_limit and not is_called(basis):
        pivot(table, n, r, s)
        pivots += 1
        left = basis[r]
        basis[r], basis[n + s] = basis[n + s], left
        if basis[r] < n:
            basis[2 * n + 1 + basis[r]] = -1
        if left == 2 * n:
            status = SOLVED
            break
        if left < n:
            basis[2 * n + 1 + left] = s
        wanted = left + n if left < n else left - n
        s = 0
        while basis[n + s] != wanted:
            s += 1
        r = first_to_fall(table, basis, n, s)
        if r < 0:
            status = RAY
            break
    for i in range(n):
        cover[i] = table[i, s]
    return status, pivots, s
