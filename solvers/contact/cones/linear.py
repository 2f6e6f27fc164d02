"""Dense linear systems without symmetry, inside kernels."""

from __future__ import annotations

import numpy as np

from lcpflex.jit.kernel import FloatArray, IntArray, kernel

__all__ = ["solve_general"]


@kernel
def solve_general(A: FloatArray, b: FloatArray, n: int, pivots: IntArray) -> float:
    """b := A^-1 b by Gaussian elimination with row pivoting; its largest entry, inf where A is singular.

    A (cap, cap), b (cap,): the leading n x n block and n entries count; A is destroyed. Work: pivots (n,), the row of A
    in which each row of the triangle is.
    """
    for i in range(n):
        pivots[i] = i
    for k in range(n):
        best, most = k, abs(A[pivots[k], k])
        for i in range(k + 1, n):
            size = abs(A[pivots[i], k])
            if size > most:
                best, most = i, size
        if not 0.0 < most < np.inf:
            return np.inf
        pivots[k], pivots[best] = pivots[best], pivots[k]
        row = A[pivots[k]]
        scale, load = 1.0 / row[k], b[pivots[k]]
        for i in range(k + 1, n):
            other = A[pivots[i]]
            factor = other[k] * scale
            if factor != 0.0:
                for j in range(k + 1, n):
                    other[j] -= factor * row[j]
                b[pivots[i]] -= factor * load
    return _back(A, b, n, pivots)


@kernel
def _back(A: FloatArray, b: FloatArray, n: int, pivots: IntArray) -> float:
    """b := U^-1 b, with row k of U in A[pivots[k]], whose first column then holds the answer meanwhile."""
    largest = 0.0
    for i in range(n):
        k = n - 1 - i
        row, total = A[pivots[k]], b[pivots[k]]
        for j in range(k + 1, n):
            total -= row[j] * A[pivots[j], 0]
        value = total / row[k]
        row[0] = value  # row 0 of U is used last, and its first entry only here
        if not abs(value) < np.inf:
            return np.inf
        largest = max(largest, abs(value))
    for k in range(n):
        b[k] = A[pivots[k], 0]
    return largest
