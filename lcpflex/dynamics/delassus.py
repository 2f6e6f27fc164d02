"""Contact matrices in velocity space: the Delassus operator with bilateral joints condensed.

Rows r of W^T and of the joint Jacobian are stored by body block (see :mod:`lcpflex.model.arrays`). With the
factorised matrix A of the step (the mass matrix, or M + theta h C + (theta h)^2 K),

    G = W^T A^-1 W,   condensed over the joints J:   G_c = G_WW - G_WJ G_JJ^-1 G_JW

Joint rows come first. Redundant joints leave G_JJ singular: their dependent rows get no multiplier (a basic
solution), which changes no motion.
"""

from __future__ import annotations

import numpy as np

from lcpflex.jit.kernel import FloatArray, IntArray, kernel
from lcpflex.solvers.semidefinite import cholesky_solve, dot

__all__ = [
    "apply_impulses",
    "condense",
    "delassus",
    "free_velocities",
    "joint_impulses",
    "row_velocity",
]


@kernel
def delassus(rows: FloatArray, solved: FloatArray, row_body: IntArray, n: int, G: FloatArray) -> None:
    """G[r, s] = rows_r . A^-1 rows_s for the first n rows; the blocks of equal bodies only."""
    width = rows.shape[2]
    start = int(np.int64(0))  # a literal would have dot compiled once more
    for r in range(n):
        for s in range(r + 1):
            total = 0.0
            for i in range(2):
                if row_body[r, i] < 0:
                    continue
                for j in range(2):
                    if row_body[r, i] == row_body[s, j]:
                        total += dot(rows[r, i], solved[s, j], start, width)
            G[r, s] = total
            G[s, r] = total


@kernel
def row_velocity(rows: FloatArray, row_body: IntArray, r: int, dof: IntArray, u: FloatArray) -> float:
    """rows_r . u [m/s or rad/s]."""
    total = 0.0
    for i in range(2):
        b = row_body[r, i]
        if b >= 0:
            total += dot(rows[r, i], u, dof[b], dof[b + 1] - dof[b])
    return total


@kernel
def free_velocities(
    rows: FloatArray,
    row_body: IntArray,
    n_joint: int,
    n: int,
    dof: IntArray,
    u: FloatArray,
    free: FloatArray,
    terms: FloatArray,
) -> None:
    """free[r] = rows_r . u of the first n rows; of those of contacts, r >= n_joint, terms[r - n_joint] = |rows_r| |u|.

    What is left of terms that cancel may be rounding: a residual is measured against both.
    """
    for r in range(n_joint):
        free[r] = row_velocity(rows, row_body, r, dof, u)
    for r in range(n_joint, n):
        total, size = 0.0, 0.0
        for i in range(2):
            b = row_body[r, i]
            if b >= 0:
                row, d, width = rows[r, i], dof[b], dof[b + 1] - dof[b]
                total += dot(row, u, d, width)
                for k in range(width):
                    size += abs(row[k] * u[d + k])
        free[r] = total
        terms[r - n_joint] = size


@kernel
def apply_impulses(
    solved: FloatArray, row_body: IntArray, first: int, last: int, p: FloatArray, dof: IntArray, u: FloatArray
) -> None:
    """u += A^-1 rows_r p_r for the rows first <= r < last."""
    for r in range(first, last):
        if p[r] != 0.0:
            for i in range(2):
                b = row_body[r, i]
                if b >= 0:
                    d = dof[b]
                    for k in range(dof[b + 1] - d):
                        u[d + k] += solved[r, i, k] * p[r]


@kernel
def condense(
    G: FloatArray,
    free: FloatArray,
    n_joint: int,
    n: int,
    lower: FloatArray,
    share: FloatArray,
    Gc: FloatArray,
    bc: FloatArray,
) -> None:
    """Condense the joints: Gc, bc of the n - n_joint contact rows; share[c] = G_JJ^-1 G_J,c for joint_impulses."""
    m = n - n_joint
    for c in range(m):
        for j in range(n_joint):
            share[c, j] = G[j, n_joint + c]
        cholesky_solve(lower, n_joint, share[c])
    for c in range(m):
        total = free[n_joint + c]
        for j in range(n_joint):
            total -= share[c, j] * free[j]
        bc[c] = total
        for e in range(m):
            value = G[n_joint + c, n_joint + e]
            for j in range(n_joint):
                value -= share[c, j] * G[j, n_joint + e]
            Gc[c, e] = value


@kernel
def joint_impulses(free: FloatArray, n_joint: int, n: int, lower: FloatArray, share: FloatArray, p: FloatArray) -> None:
    """p[:n_joint] = -G_JJ^-1 (free_J + G_JW p_W) for the contact impulses p[n_joint:n]."""
    for j in range(n_joint):
        p[j] = free[j]
    cholesky_solve(lower, n_joint, p)
    for j in range(n_joint):
        total = p[j]
        for c in range(n - n_joint):
            total += share[c, j] * p[n_joint + c]
        p[j] = -total
