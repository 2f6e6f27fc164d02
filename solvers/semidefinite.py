"""Sums of products, and the Cholesky factor of a matrix that may be singular: dependent rows get nothing.

Of an operator J A^-1 J^T with redundant rows the factor gives a basic solution: the unknowns of dependent rows are 0.
"""

from __future__ import annotations

import math

from lcpflex.jit.kernel import FloatArray, kernel

__all__ = ["backward", "cholesky", "cholesky_solve", "dot", "forward", "four_dots"]

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
def four_dots(
    x: FloatArray, s: FloatArray, t: FloatArray, u: FloatArray, v: FloatArray, n: int
) -> tuple[float, float, float, float]:
    """:func:`dot` of x with each of four, to the bit: it takes little longer than one."""
    a = b = c = d = 0.0
    e = f = g = h = 0.0
    i = j = k = r = 0.0
    m = o = p = q = 0.0
    whole = n - n % 4
    for z in range(0, whole, 4):
        x0, x1, x2, x3 = x[z], x[z + 1], x[z + 2], x[z + 3]
        a += x0 * s[z]
        b += x1 * s[z + 1]
        c += x2 * s[z + 2]
        d += x3 * s[z + 3]
        e += x0 * t[z]
        f += x1 * t[z + 1]
        g += x2 * t[z + 2]
        h += x3 * t[z + 3]
        i += x0 * u[z]
        j += x1 * u[z + 1]
        k += x2 * u[z + 2]
        r += x3 * u[z + 3]
        m += x0 * v[z]
        o += x1 * v[z + 1]
        p += x2 * v[z + 2]
        q += x3 * v[z + 3]
    for z in range(whole, n):
        a += x[z] * s[z]
        e += x[z] * t[z]
        i += x[z] * u[z]
        m += x[z] * v[z]
    return (a + b) + (c + d), (e + f) + (g + h), (i + j) + (k + r), (m + o) + (p + q)


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
def forward(lower: FloatArray, n: int, x: FloatArray) -> None:
    """x <- L^-1 x in place, with the factor of :func:`cholesky`; 0 for dependent rows."""
    for i in range(n):
        total = x[i]
        for k in range(i):
            total -= lower[i, k] * x[k]
        x[i] = total / lower[i, i] if lower[i, i] > 0.0 else 0.0


@kernel
def backward(lower: FloatArray, n: int, x: FloatArray) -> None:
    """x <- L^-T x in place; 0 for dependent rows."""
    for i in range(n - 1, -1, -1):
        total = x[i]
        for k in range(i + 1, n):
            total -= lower[k, i] * x[k]
        x[i] = total / lower[i, i] if lower[i, i] > 0.0 else 0.0


@kernel
def cholesky_solve(lower: FloatArray, n: int, x: FloatArray) -> None:
    """x <- G^-1 x in place from the factor of :func:`cholesky`; 0 for dependent rows."""
    forward(lower, n, x)
    backward(lower, n, x)
