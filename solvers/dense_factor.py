"""Dense linear systems without symmetry, inside kernels: LU factors with exchanged rows."""

from __future__ import annotations

import numpy as np

from lcpflex.jit.kernel import FloatArray, IntArray, kernel

__all__ = ["factorise_rows", "solve_rows"]


@kernel
def factorise_rows(A: FloatArray, n: int, pivots: IntArray) -> bool:
    """In place A = L U, row k of both in A[pivots[k]]; False where A is singular or not finite.

    A (cap, cap): the leading n x n block counts. Out: pivots (n,). Rows are not moved: the largest entry left in each
    column chooses the next one.
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
            return False
        pivots[k], pivots[best] = pivots[best], pivots[k]
        row = A[pivots[k]]
        scale = 1.0 / row[k]
        for i in range(k + 1, n):
            other = A[pivots[i]]
            factor = other[k] * scale
            other[k] = factor
            if factor != 0.0:
                for j in range(k + 1, n):
                    other[j] -= factor * row[j]
    return True


@kernel
def solve_rows(A: FloatArray, n: int, pivots: IntArray, b: FloatArray, x: FloatArray) -> None:
    """b := A^-1 b by the factors of :func:`factorise_rows`. Work: x (n,)."""
    for k in range(n):
        row, total = A[pivots[k]], b[pivots[k]]
        for j in range(k):
            total -= row[j] * x[j]
        x[k] = total
    for k in range(n - 1, -1, -1):
        row, total = A[pivots[k]], x[k]
        for j in range(k + 1, n):
            total -= row[j] * x[j]
        x[k] = total / row[k]
    for k in range(n):
        b[k] = x[k]
