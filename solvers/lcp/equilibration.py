"""Symmetric scaling of a matrix, by which the rows and columns of s_i M_ij s_j are alike in size.

Ruiz 2001: both are divided by the square roots of their largest entries, again and again.
"""

from __future__ import annotations

import numpy as np

from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.solvers.lcp.tableau import CANDIDATE, DIRECTION, SCALE

__all__ = ["equilibrate"]


@kernel
def equilibrate(M: FloatArray, n: int, sweeps: int, table: FloatArray) -> None:
    """s, in its row of the table, such that the rows and columns of s_i M_ij s_j have maxima near 1.

    M (cap, cap): its leading n x n block; table: of :mod:`lcpflex.solvers.lcp.tableau`. sweeps: over the matrix; with 0
    all s are alike, by its largest entry.
    """
    scale, rows, columns = table[n + SCALE], table[n + DIRECTION], table[n + CANDIDATE]
    for j in range(n):
        scale[j] = 1.0
    for _ in range(max(sweeps, 1)):
        for j in range(n):
            columns[j] = 0.0
        largest = 0.0
        for i in range(n):
            row, own = M[i], scale[i]
            for j in range(n):
                columns[j] = max(columns[j], abs(row[j]) * own)
            rows[i] = _peak(row, scale, n)
            largest = max(largest, rows[i])
        for i in range(n):
            peak = largest if sweeps == 0 else scale[i] * max(columns[i], rows[i])
            if peak > 0.0:
                scale[i] /= np.sqrt(peak)


@kernel
def _peak(row: FloatArray, scale: FloatArray, n: int) -> float:
    """max |row_j| scale_j; four side by side, or each would wait for the one before."""
    a, b, c, d = 0.0, 0.0, 0.0, 0.0
    whole = n - n % 4
    for j in range(0, whole, 4):
        a = max(a, abs(row[j]) * scale[j])
        b = max(b, abs(row[j + 1]) * scale[j + 1])
        c = max(c, abs(row[j + 2]) * scale[j + 2])
        d = max(d, abs(row[j + 3]) * scale[j + 3])
    for j in range(whole, n):
        a = max(a, abs(row[j]) * scale[j])
    return max(max(a, b), max(c, d))
