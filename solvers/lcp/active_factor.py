"""The Cholesky factor of an active block of a symmetric matrix, kept up to date as indices join and leave.

    R^T R = M_AA,   R upper triangular, A an ordered set of indices

r joins A by the column R^{-T} M_Ar and the diagonal sqrt(M_rr - |R^{-T} M_Ar|^2); an index that leaves takes a
column with it, and plane rotations of rows restore the triangle (Gill, Golub, Murray & Saunders 1974): O(m^2)
operations instead of m^3 / 6. Rows are stored as rows, so that every inner loop runs along memory.

Arrays of all kernels: M (cap, cap), its leading n x n block counts; R with rows of length cap; basis (2 cap,) at least:
basis[:n] is 1 on A, basis[n:n + m] is A in the order of the columns of R, m its size; the last
entry of basis tells of a signal.
"""

from __future__ import annotations

import numpy as np

from lcpflex.jit.kernel import FloatArray, IntArray, kernel
from lcpflex.solvers.attention import is_called

__all__ = ["backward", "factorise", "forward", "join", "leave", "new_column"]

DEPENDENT = 1e-13  # a pivot below this fraction of the diagonal it came from is rounding


@kernel
def factorise(M: FloatArray, n: int, R: FloatArray, basis: IntArray) -> int:
    """R of M_AA for the indices with basis[:n] = 1; dependent ones are taken out of A. Returns the order of R.

    Row i of R is row i of M_AA less its part along the rows above.
    """
    m = 0
    for i in range(n):
        if basis[i] == 1:
            basis[n + m] = i
            m += 1
    i = 0
    while i < m:
        if is_called(basis):
            return i
        k = basis[n + i]
        source, row = M[k], R[i]
        for j in range(i, m):
            row[j] = source[basis[n + j]]
        for p in range(0, i, 4):
            # Four at once, so that the row is loaded and stored a quarter as often; beyond the last row its like is
            # taken with the factor zero.
            a, b, c, d = R[p], R[min(p + 1, i - 1)], R[min(p + 2, i - 1)], R[min(p + 3, i - 1)]
            fa, fb = a[i], b[i] if p + 1 < i else 0.0
            fc, fd = c[i] if p + 2 < i else 0.0, d[i] if p + 3 < i else 0.0
            for j in range(i, m):
                row[j] -= (fa * a[j] + fb * b[j]) + (fc * c[j] + fd * d[j])
        if row[i] > DEPENDENT * abs(M[k, k]):
            inverse = 1.0 / np.sqrt(row[i])
            for j in range(i, m):
                row[j] *= inverse
            i += 1
        else:
            m -= 1
            basis[k] = 0
            basis[n + i] = basis[n + m]
            for p in range(i):
                R[p, i] = R[p, m]
    return m


@kernel
def forward(R: FloatArray, m: int, x: FloatArray) -> float:
    """x = R^{-T} x in place; returns x.x."""
    total = 0.0
    for k in range(m):
        row = R[k]
        value = x[k] / row[k]
        total += value * value
        for j in range(k + 1, m):
            x[j] -= value * row[j]
        x[k] = value
    return total


@kernel
def backward(R: FloatArray, m: int, x: FloatArray) -> None:
    """x = R^{-1} x in place; four sums side by side."""
    for k in range(m - 1, -1, -1):
        row = R[k]
        s0, s1, s2, s3 = 0.0, 0.0, 0.0, 0.0
        whole = m - (m - k - 1) % 4
        for j in range(k + 1, whole, 4):
            s0 += row[j] * x[j]
            s1 += row[j + 1] * x[j + 1]
            s2 += row[j + 2] * x[j + 2]
            s3 += row[j + 3] * x[j + 3]
        for j in range(whole, m):
            s0 += row[j] * x[j]
        x[k] = (x[k] - ((s0 + s1) + (s2 + s3))) / row[k]


@kernel
def new_column(M: FloatArray, n: int, R: FloatArray, basis: IntArray, m: int, r: int, y: FloatArray) -> float:
    """y = R^{-T} M_Ar, the column of R if r joins; returns the square of its diagonal entry, 0 if that is rounding."""
    source = M[r]
    for j in range(m):
        y[j] = source[basis[n + j]]
    pivot = M[r, r] - forward(R, m, y)
    return pivot if not abs(pivot) <= DEPENDENT * abs(M[r, r]) else 0.0


@kernel
def join(n: int, R: FloatArray, basis: IntArray, m: int, r: int, y: FloatArray, pivot: float) -> None:
    """Append index r to R of order m by the column y and its diagonal."""
    for k in range(m):
        R[k, m] = y[k]
    R[m, m] = np.sqrt(pivot)
    basis[n + m] = r
    basis[r] = 1


@kernel
def leave(n: int, R: FloatArray, basis: IntArray, m: int, p: int, carry: FloatArray) -> None:
    """Take the index at place p out of R of order m: a column goes, rotations of rows restore the triangle."""
    basis[basis[n + p]] = 0
    for j in range(p, m - 1):
        basis[n + j] = basis[n + j + 1]
    for k in range(p):
        row = R[k]
        for j in range(p, m - 1):
            row[j] = row[j + 1]
    for j in range(p + 1, m):
        carry[j] = R[p, j]
    for k in range(p, m - 1):
        row, below = R[k], R[k + 1]
        length = np.hypot(below[k + 1], carry[k + 1])
        c, s = below[k + 1] / length, carry[k + 1] / length
        for j in range(k + 1, m):
            row[j - 1] = c * below[j] + s * carry[j]
            carry[j] = c * carry[j] - s * below[j]
