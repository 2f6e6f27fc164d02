"""Contact matrices in velocity space: the Delassus operator and what impulses do.

Rows r of W^T and of the joint Jacobian are stored by body block (see :mod:`lcpflex.model.arrays`), joint rows first.
With the factorised matrix A of the step (the mass matrix, or M + theta h C + (theta h)^2 K),

    G = W^T A^-1 W

Joints are condensed by :mod:`lcpflex.dynamics.joint_response`.
"""

from __future__ import annotations

from typing import Any

from lcpflex.jit.kernel import FloatArray, IntArray, kernel
from lcpflex.solvers.semidefinite import dot, four_dots

__all__ = [
    "apply_impulses",
    "delassus",
    "free_velocities",
    "row_velocity",
    "spread",
]


@kernel
def alike(row_body: IntArray, part: IntArray, b: int) -> bool:
    """Whether the rows part[b] and the three behind it are all of the same bodies; from the last, which tells first."""
    s = part[b]
    for c in range(3, 0, -1):
        t = part[b + c]
        if t < 0 or row_body[t, 0] != row_body[s, 0] or row_body[t, 1] != row_body[s, 1]:
            return False
    return True


@kernel
def are_joined(row_body: IntArray, r: int, s: int) -> bool:
    """Whether rows r and s have a body in common."""
    if r < 0 or s < 0:
        return False
    i, j, k, m = row_body[r, 0], row_body[r, 1], row_body[s, 0], row_body[s, 1]
    return bool((i >= 0 and i in (k, m)) or (j >= 0 and j in (k, m)))


@kernel
def fill_four(
    rows: FloatArray, solved: FloatArray, row_body: IntArray, part: IntArray, a: int, b: int, G: FloatArray
) -> None:
    """G[a, b] to G[a, b + 3], and what mirrors them, of rows of the same bodies: to the bit as one by one."""
    width, r, s, t, u, v = rows.shape[2], part[a], part[b], part[b + 1], part[b + 2], part[b + 3]
    first = second = third = fourth = 0.0
    for i in range(2):
        if row_body[r, i] < 0:
            continue
        for j in range(2):
            if row_body[r, i] == row_body[s, j]:
                w, x, y, z = four_dots(rows[r, i], solved[s, j], solved[t, j], solved[u, j], solved[v, j], width)
                first, second, third, fourth = first + w, second + x, third + y, fourth + z
    G[a, b], G[a, b + 1], G[a, b + 2], G[a, b + 3] = first, second, third, fourth
    G[b, a], G[b + 1, a], G[b + 2, a], G[b + 3, a] = first, second, third, fourth


@kernel
def fill_one(
    rows: FloatArray, solved: FloatArray, row_body: IntArray, part: IntArray, a: int, b: int, G: FloatArray
) -> None:
    """G[a, b] and what mirrors it, of rows that are joined."""
    width, r, s, total = rows.shape[2], part[a], part[b], 0.0
    for i in range(2):
        if row_body[r, i] < 0:
            continue
        for j in range(2):
            if row_body[r, i] == row_body[s, j]:
                total += dot(rows[r, i], solved[s, j], 0, width)
    G[a, b] = total
    G[b, a] = total


@kernel
def delassus(rows: FloatArray, solved: FloatArray, row_body: IntArray, part: IntArray, n: int, G: FloatArray) -> None:
    """G[a, b] = rows_r . A^-1 rows_s for r, s = part[a], part[b] and a, b < n; the blocks of equal bodies only.

    0 where r or s is none, -1. Four columns at a time: sums of one wait for each other, those of four do not.
    """
    for a in range(n):
        b = 0
        while b <= a:
            if not are_joined(row_body, part[a], part[b]):
                G[a, b] = G[b, a] = 0.0
                b += 1
            elif b + 3 <= a and alike(row_body, part, b):
                fill_four(rows, solved, row_body, part, a, b, G)
                b += 4
            else:
                fill_one(rows, solved, row_body, part, a, b, G)
                b += 1


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
def spread(work: Any, flexibility: FloatArray, first: int, last: int) -> None:
    """solved[r] <- displacement by a unit force on row r as each coordinate gives way, for first <= r < last."""
    for r in range(first, last):
        for i in range(2):
            b = work.rows.body[r, i]
            if b >= 0:
                d = work.rows.dof[b]
                for k in range(work.rows.dof[b + 1] - d):
                    work.rows.solved[r, i, k] = flexibility[d + k] * work.rows.J[r, i, k]
