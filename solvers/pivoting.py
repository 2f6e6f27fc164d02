"""Block principal pivoting: solve on a guessed active set, exchange what has the wrong sign, again.

Two uses: repair and warm start of Lemke's algorithm (one linear solve if the active set is right), and P-matrices
on which Lemke needs exponentially many pivots (Murty's). Steps exchange all wrong signs while their number falls, then,
as a safeguard, only the last one (Murty's least-index rule read backwards), which is finite for P-matrices.
"""

from __future__ import annotations

from lcpflex.compiled import FloatArray, IntArray, kernel
from lcpflex.solvers.certificate import residual_parts

__all__ = ["block_pivots", "solve_active"]

SINGULAR = 1e-14  # smallest pivot of rows scaled to 1
WRONG = 1e-13  # a sign counts as wrong beyond this fraction of the terms it is made of
PATIENCE = 3  # block exchanges without fewer wrong signs before single ones


@kernel
def solve_active(M: FloatArray, q: FloatArray, n: int, z: FloatArray, table: FloatArray, basis: IntArray) -> None:
    """z_A from M_AA z_A = -q_A by elimination with complete pivoting, z = 0 elsewhere.

    basis[:n] is 1 on A, else 0. Unknowns in excess of the rank of M_AA are set to zero and taken out of A. Overwrites
    basis[n:2n] and the block table[:n, :n + 1].
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
        lift = 1.0 / largest if largest > 0.0 else 1.0
        for c in range(m):
            table[k, c] *= lift
        table[k, m] = -q[i] * lift
    rank = _eliminate(table, basis, n, m)
    for k in range(rank, m):
        basis[basis[n + k]] = 0
    for k in range(rank - 1, -1, -1):
        value = table[k, m]
        for c in range(k + 1, rank):
            value -= table[k, c] * z[basis[n + c]]
        z[basis[n + k]] = value / table[k, k]


@kernel
def _eliminate(table: FloatArray, basis: IntArray, n: int, m: int) -> int:
    """Upper triangle of the first m rows and columns, right-hand side in column m; returns the rank.

    basis[n:n + m], the unknowns of the columns, is permuted with them.
    """
    for k in range(m):
        r, s = k, k
        for i in range(k, m):
            for c in range(k, m):
                if abs(table[i, c]) > abs(table[r, s]):
                    r, s = i, c
        if not abs(table[r, s]) > SINGULAR:
            return k
        if r != k:
            for c in range(k, m + 1):
                table[k, c], table[r, c] = table[r, c], table[k, c]
        if s != k:
            for i in range(m):
                table[i, k], table[i, s] = table[i, s], table[i, k]
            basis[n + k], basis[n + s] = basis[n + s], basis[n + k]
        for i in range(k + 1, m):
            factor = table[i, k] / table[k, k]
            if factor != 0.0:
                for c in range(k + 1, m + 1):
                    table[i, c] -= factor * table[k, c]
    return m


@kernel
def block_pivots(
    M: FloatArray, q: FloatArray, n: int, z: FloatArray, table: FloatArray, basis: IntArray, limit: int
) -> int:
    """Exchange wrong signs from the active set basis[:n] on; returns the number of solves, or -1 without a solution.

    In: M (cap, cap), q (cap,), both as for ``lemke``, whose work arrays table and basis serve here too. Out: z (cap,),
    basis[:n]. The signs are right to 1e-13 of the terms of w; the residual is for the caller to judge.
    """
    fewest, patience = n + 1, PATIENCE
    for count in range(1, limit + 1):
        solve_active(M, q, n, z, table, basis)
        size = residual_parts(M, q, z, n)[1]
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
