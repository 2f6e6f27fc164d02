"""The Cholesky factor of an active block of a symmetric matrix, kept up to date as indices join and leave.

    R^T R = M_AA,   R upper triangular, A an ordered set of indices

r joins A by the column R^{-T} M_Ar and the diagonal sqrt(M_rr - |R^{-T} M_Ar|^2); an index that leaves takes a
column with it, and plane rotations of rows restore the triangle (Gill, Golub, Murray & Saunders 1974): O(m^2)
operations instead of m^3 / 6. Rows are stored as rows, so that every inner loop runs along memory.

Arrays of all kernels: M (cap, cap), its leading n x n block counts; R with rows of length cap; basis (2 cap,) at least:
basis[:n] is 1 on A, basis[n:n + m] is A in the order of the columns of R, m its size.
"""

from __future__ import annotations

import numpy as np

from lcpflex.compiled import FloatArray, IntArray, kernel

__all__ = ["backward", "factorise", "forward", "join", "leave", "new_column", "subtract_four"]

DEPENDENT = 1e-13  # a pivot below this fraction of the diagonal it came from is rounding


@kernel
def subtract_four(
    row: FloatArray,
    a: FloatArray,
    b: FloatArray,
    c: FloatArray,
    d: FloatArray,
    fa: float,
    fb: float,
    fc: float,
    fd: float,
) -> None:
    """row -= fa a + fb b + fc c + fd d: four at once, so that ``row`` is loaded and stored a quarter as often."""
    for j in range(len(row)):
        row[j] -= (fa * a[j] + fb * b[j]) + (fc * c[j] + fd * d[j])


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
        k = basis[n + i]
        source, row = M[k], R[i]
        for j in range(i, m):
            row[j] = source[basis[n + j]]
        tail = row[i:m]
        for p in range(0, i, 4):
            # Beyond the last row its like is taken with the factor zero.
            p1, p2, p3 = min(p + 1, i - 1), min(p + 2, i - 1), min(p + 3, i - 1)
            f1 = R[p1, i] if p + 1 < i else 0.0
            f2 = R[p2, i] if p + 2 < i else 0.0
            f3 = R[p3, i] if p + 3 < i else 0.0
            subtract_four(tail, R[p, i:m], R[p1, i:m], R[p2, i:m], R[p3, i:m], R[p, i], f1, f2, f3)
        if tail[0] > DEPENDENT * abs(M[k, k]):
            inverse = 1.0 / np.sqrt(tail[0])
            for j in range(len(tail)):
                tail[j] *= inverse
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
        row, rest = R[k, k:m], x[k:m]
        value = rest[0] / row[0]
        total += value * value
        for j in range(len(rest)):
            rest[j] -= value * row[j]
        rest[0] = value
    return total


@kernel
def backward(R: FloatArray, m: int, x: FloatArray) -> None:
    """x = R^{-1} x in place; four sums side by side."""
    for k in range(m - 1, -1, -1):
        row, rest = R[k, k + 1 : m], x[k + 1 : m]
        size = len(rest)
        s0, s1, s2, s3 = 0.0, 0.0, 0.0, 0.0
        whole = size - size % 4
        for j in range(0, whole, 4):
            s0 += row[j] * rest[j]
            s1 += row[j + 1] * rest[j + 1]
            s2 += row[j + 2] * rest[j + 2]
            s3 += row[j + 3] * rest[j + 3]
        for j in range(whole, size):
            s0 += row[j] * rest[j]
        x[k] = (x[k] - ((s0 + s1) + (s2 + s3))) / R[k, k]


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
        row, rest = R[k, p : m - 1], R[k, p + 1 : m]
        for j in range(len(row)):
            row[j] = rest[j]
    for j in range(p + 1, m):
        carry[j] = R[p, j]
    for k in range(p, m - 1):
        row, below, rest = R[k, k : m - 1], R[k + 1, k + 1 : m], carry[k + 1 : m]
        length = np.hypot(below[0], rest[0])
        c, s = below[0] / length, rest[0] / length
        for j in range(len(row)):
            row[j] = c * below[j] + s * rest[j]
            rest[j] = c * rest[j] - s * below[j]
