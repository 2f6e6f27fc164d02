"""Sums of products, and the Cholesky factor of a matrix that may be singular: dependent rows get nothing.

Of an operator J A^-1 J^T with redundant rows the factor gives a basic solution: the unknowns of dependent rows are 0.
"""

from __future__ import annotations

import math

from lcpflex.jit.kernel import FloatArray, kernel

__all__ = ["cholesky", "cholesky_solve", "dot"]

REDUNDANT = 1e-12  # a pivot below this part of its row's diagonal is a dependent row


@kernel
def dot(x: FloatArray, y: FloatArray, first: int, n: int) -> float:
    """Sum of x[k] y[first + k] over k < n, in four sums side by side: one would wait for its own last addition."""
    a = 0.0
    b = 0.0
    c = 0.0
    d = 0.0
    whole = n - n % 4
    for k in range(0, whole, 4):
        a += x[k] * y[first + k]
        b += x[k + 1] * y[first + k + 1]
        c += x[k + 2] * y[first + k + 2]
        d += x[k + 3] * y[first + k + 3]
    for k in range(whole, n):
        a += x[k] * y[first + k]
    return (a + b) + (c + d)


@kernel
def cholesky(G: FloatArray, n: int, lower: FloatArray) -> None:
    """Lower Cholesky factor of the positive semidefinite G[:n, :n]; a zero on its diagonal marks a dependent row."""
    for i in range(n):
        for j in range(i + 1):
            total = G[i, j]
            for k in range(j):
                total -= lower[i, k] * lower[j, k]
            if j < i:
                lower[i, j] = total / lower[j, j] if lower[j, j] > 0.0 else 0.0
            else:
                lower[i, i] = math.sqrt(total) if total > REDUNDANT * G[i, i] else 0.0


@kernel
def cholesky_solve(lower: FloatArray, n: int, x: FloatArray) -> None:
    """x <- G^-1 x in place from the factor of :func:`cholesky`; 0 for dependent rows."""
    for i in range(n):
        total = x[i]
        for k in range(i):
            total -= lower[i, k] * x[k]
        x[i] = total / lower[i, i] if lower[i, i] > 0.0 else 0.0
    for i in range(n - 1, -1, -1):
        total = x[i]
        for k in range(i + 1, n):
            total -= lower[k, i] * x[k]
        x[i] = total / lower[i, i] if lower[i, i] > 0.0 else 0.0
