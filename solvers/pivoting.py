"""Block principal pivoting: solve on a guessed active set, exchange what has the wrong sign, again.

Two uses: repair and warm start of Lemke's algorithm (one linear solve if the active set is right), and P-matrices
on which Lemke needs exponentially many pivots (Murty's). Steps exchange all wrong signs while their number falls, then,
as a safeguard, only the last one (Murty's least-index rule read backwards), which is finite for P-matrices.
"""

from __future__ import annotations

from lcpflex.compiled import FloatArray, IntArray, kernel

__all__ = ["block_pivots", "solve_active"]

SINGULAR = 1e-14  # smallest pivot of rows scaled to 1
WRONG = 1e-13  # a sign counts as wrong beyond this fraction of the terms it is made of
PATIENCE = 3  # block exchanges without fewer wrong signs before single ones


@kernel
def solve_active(M: FloatArray, q: FloatArray, n: int, z: FloatArray, table: FloatArray, basis: IntArray) -> bool:
    """z_A from M_AA z_A = -q_A by elimination with row pivoting, z = 0 elsewhere; False if M_AA is singular.

    basis[:n] is 1 on A, else 0; basis[n:2n] is overwritten, and so is the block table[:n, :n + 1].
    """
    m = 0
    for i in range(n):
        z[i] = 0.0
        if basis[i] == 1:
            basis[n + m] = i
            m += 1
    for k in range(m):
        i = basis[n + k]
        largest = 0.0
        for c in range(m):
            table[k, c] = M[i, basis[n + c]]
            largest = max(largest, abs(table[k, c]))
        if not largest > 0.0:
            return False
        for c in range(m):
            table[k, c] /= largest
        table[k, m] = -q[i] / largest
    for k in range(m):
        r = k
        for i in range(k + 1, m):
            if abs(table[i, k]) > abs(table[r, k]):
                r = i
        if not abs(table[r, k]) > SINGULAR:
            return False
        if r != k:
            for c in range(k, m + 1):
                table[k, c], table[r, c] = table[r, c], table[k, c]
        for i in range(k + 1, m):
            factor = table[i, k] / table[k, k]
            if factor != 0.0:
                for c in range(k + 1, m + 1):
                    table[i, c] -= factor * table[k, c]
    for k in range(m - 1, -1, -1):
        value = table[k, m]
        for c in range(k + 1, m):
            value -= table[k, c] * z[basis[n + c]]
        z[basis[n + k]] = value / table[k, k]
    return True


@kernel
def block_pivots(
    M: FloatArray, q: FloatArray, n: int, z: FloatArray, table: FloatArray, basis: IntArray, limit: int
) -> int:
    """Exchange wrong signs from the active set basis[:n] on; returns the number of solves, or -1 without a solution.

    In: M (cap, cap), q (cap,). Out: z (cap,), basis[:n]. Work: table, basis of :func:`lcpflex.solvers.lemke.lemke_workspace`.
    """
    fewest, patience = n + 1, PATIENCE
    for count in range(1, limit + 1):
        if not solve_active(M, q, n, z, table, basis):
            return -1
        size = 0.0
        for i in range(n):
            size = max(size, abs(q[i]))
        wrong, last = 0, -1
        for i in range(n):
            w, row = q[i], 0.0
            for j in range(n):
                w += M[i, j] * z[j]
                row = max(row, abs(M[i, j]))
            sign = row * z[i] if basis[i] == 1 else w
            basis[n + i] = 0
            if not sign >= -WRONG * size:
                basis[n + i] = 1
                wrong += 1
                last = i
        if wrong == 0:
            for i in range(n):
                z[i] = max(z[i], 0.0)
            return count
        if wrong < fewest:
            fewest, patience = wrong, PATIENCE
        else:
            patience -= 1
        if patience >= 0:
            for i in range(n):
                if basis[n + i] == 1:
                    basis[i] = 1 - basis[i]
        else:
            basis[last] = 1 - basis[last]
    return -1
