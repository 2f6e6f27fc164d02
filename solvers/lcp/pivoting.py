"""Block principal pivoting: solve on a guessed active set, exchange what has the wrong sign, again.

Two uses: repair and warm start of Lemke's algorithm (one linear solve if the active set is right), and P-matrices
on which Lemke needs exponentially many pivots (Murty's). Steps exchange all wrong signs while their number falls, then,
as a safeguard, only the last one (Murty's least-index rule read backwards), which is finite for P-matrices.
"""

from __future__ import annotations

import numpy as np

from lcpflex.jit.kernel import FloatArray, IntArray, kernel
from lcpflex.solvers.attention import is_called
from lcpflex.solvers.certificate import guarded_residual, row_parts
from lcpflex.solvers.lcp.active_factor import backward

__all__ = ["block_pivots", "eliminate", "load_block", "solve_active"]

SINGULAR = 1e-14  # smallest pivot of rows scaled to 1
DOUBTFUL = 1e-9  # pivot of rows scaled to 1 below which rows and columns are searched for a better one
WRONG = 1e-13  # a sign counts as wrong beyond this fraction of the terms it is made of
PATIENCE = 3  # block exchanges without fewer wrong signs before single ones


@kernel
def solve_active(M: FloatArray, q: FloatArray, n: int, z: FloatArray, table: FloatArray, basis: IntArray) -> None:
    """z_A from M_AA z_A = -q_A by elimination, z = 0 elsewhere.

    basis[:n] is 1 on A, else 0. Unknowns in excess of the rank of M_AA are set to zero and taken out of A. Overwrites
    basis[n:2n] and table[:n + 1, :n + 1].
    """
    m, rank = 0, 0
    for complete in (False, True):
        m = 0
        for i in range(n):
            z[i] = 0.0
            if basis[i] == 1:
                basis[n + m] = i
                m += 1
        load_block(M, q, basis[n:], m, table)
        rank = eliminate(table, basis[n:], m, complete, SINGULAR if complete else DOUBTFUL)
        if rank == m:
            break
    for k in range(rank, m):
        basis[basis[n + k]] = 0
    x = table[n]
    for k in range(rank):
        x[k] = table[k, m]
    backward(table, rank, x)
    for k in range(rank):
        z[basis[n + k]] = x[k]


@kernel
def load_block(M: FloatArray, q: FloatArray, order: IntArray, m: int, table: FloatArray) -> None:
    """M_AA for the m unknowns of A in this order, with -q_A in column m, rows scaled to 1."""
    for k in range(m):
        source, row = M[order[k]], table[k]
        largest = 0.0
        for c in range(m):
            row[c] = source[order[c]]
            largest = max(largest, abs(row[c]))
        lift = 1.0 / largest if largest > 0.0 else 1.0
        for c in range(m):
            row[c] *= lift
        row[m] = -q[order[k]] * lift


@kernel
def eliminate(table: FloatArray, order: IntArray, m: int, complete: bool, least: float) -> int:
    """Upper triangle of the first m rows and columns, the right-hand side in column m; returns the rank.

    The pivot is the largest entry of the row or, with ``complete``, of all that is left; the order falls short of m at
    the first one that is not above ``least``, or where a signal has come. order[:m], the unknowns of the columns, is
    permuted with them; its last entry is 0 else (:mod:`lcpflex.solvers.attention`).
    """
    for k in range(m):
        if is_called(order):
            return k
        r, s = k, k
        for i in range(k, m if complete else k + 1):
            for c in range(k, m):
                if abs(table[i, c]) > abs(table[r, s]):
                    r, s = i, c
        if not abs(table[r, s]) > least:
            return k
        if r != k:
            for c in range(k, m + 1):
                table[k, c], table[r, c] = table[r, c], table[k, c]
        if s != k:
            for i in range(m):
                table[i, k], table[i, s] = table[i, s], table[i, k]
            order[k], order[s] = order[s], order[k]
        above, inverse = table[k], 1.0 / table[k, k]
        for i in range(k + 1, m):
            row = table[i]
            factor = row[k] * inverse
            if factor != 0.0:
                for c in range(k + 1, m + 1):
                    row[c] -= factor * above[c]
    return m


@kernel
def block_pivots(
    M: FloatArray, q: FloatArray, n: int, z: FloatArray, table: FloatArray, basis: IntArray, limit: int
) -> tuple[int, float]:
    """Exchange wrong signs from the active set basis[:n] on; (number of solves, -1 without a solution, residual).

    In: M (cap, cap), q (cap,), both as for ``lemke``, whose work arrays table and basis serve here too. Out: z (cap,),
    basis[:n]. The signs are right to 1e-13 of the terms of w; the residual is for the caller to judge.
    """
    fewest, patience = n + 1, PATIENCE
    sign = table[n]
    for count in range(1, limit + 1):
        if is_called(basis):
            break
        solve_active(M, q, n, z, table, basis)
        worst, size, load = 0.0, 0.0, 0.0
        for i in range(n):
            product, terms, row = row_parts(M[i], z, n)
            slack, lifted = product + q[i], row * z[i] if row > 0.0 else z[i]
            sign[i] = lifted if basis[i] == 1 else slack
            worst = max(worst, abs(min(lifted, slack)))
            size = max(size, terms + abs(q[i]))
            load = max(load, abs(q[i]))
        wrong, last = 0, -1
        for i in range(n):
            basis[n + i] = 0
            if not sign[i] >= -WRONG * size:
                basis[n + i] = 1
                wrong += 1
                last = i
        if wrong == 0:
            for i in range(n):
                z[i] = max(z[i], 0.0)
            return count, guarded_residual(worst, size, load)
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
    return -1, np.inf
