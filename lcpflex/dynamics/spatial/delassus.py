"""Velocities of contact rows in space, and what impulses on them do: the three rows of a contact in one walk.

A row of a rigid body has six numbers there, and each addition of a product waits for the one before: of three rows
side by side they wait together. See :mod:`lcpflex.dynamics.delassus` for the plane.
"""

from __future__ import annotations

from lcpflex.dynamics.delassus import apply_impulses, row_velocity
from lcpflex.dynamics.spatial.inertia import SpatialWork
from lcpflex.jit.kernel import FloatArray, IntArray, kernel
from lcpflex.solvers.contact.operators.scene import push_rows

__all__ = ["add_impulses", "measure_free"]


@kernel
def measure_free(work: SpatialWork) -> None:
    """``work.free.v`` and ``work.free.terms`` of the rows laid at ``work.free.u``."""
    rows, row_body, dof = work.rows.J, work.rows.body, work.rows.dof
    u, n_joint, free = work.free.u, work.rows.n_joint, work.free.v
    for r in range(n_joint):
        free[r] = row_velocity(rows, row_body, r, dof, u)
    tangent = 0
    for k in range(work.rows.n_contacts):
        s = -1
        if tangent < work.rows.n_tangents and work.rows.tangent[tangent] == k:
            s = n_joint + work.rows.n_contacts + tangent
            tangent += 2
        measure_contact(rows, row_body, dof, n_joint, n_joint + k, s, u, free, work.free.terms)


@kernel
def measure_contact(
    rows: FloatArray, row_body: IntArray, dof: IntArray, n_joint: int, r: int, s: int, u: FloatArray,
    free: FloatArray, terms: FloatArray,
) -> None:  # fmt: skip
    """free and terms = |row| |u| of the normal row r of a contact and, unless s < 0, of its rows s and s + 1."""
    v, v1, v2, size, size1, size2 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(2):
        b = row_body[r, i]
        if b < 0:
            continue
        d = dof[b]
        for c in range(dof[b + 1] - d):
            y = u[d + c]
            x = rows[r, i, c] * y
            v += x
            size += abs(x)
            if s >= 0:
                x1, x2 = rows[s, i, c] * y, rows[s + 1, i, c] * y
                v1 += x1
                v2 += x2
                size1 += abs(x1)
                size2 += abs(x2)
    free[r], terms[r - n_joint] = v, size
    if s >= 0:
        free[s], terms[s - n_joint] = v1, size1
        free[s + 1], terms[s + 1 - n_joint] = v2, size2


@kernel
def add_impulses(work: SpatialWork, u: FloatArray) -> None:
    """u += A^-1 W p of all rows laid and their impulses ``work.impulses.p``."""
    n_joint, solved = work.rows.n_joint, work.rows.solved
    row_body, dof, p = work.rows.body, work.rows.dof, work.impulses.p
    apply_impulses(solved, row_body, 0, n_joint, p, dof, u)
    for k in range(work.rows.n_contacts):
        r, j = n_joint + k, work.posed.tangent_of[k]
        if j < 0:
            push_rows(solved, row_body, dof, r, j, p[r], 0.0, 0.0, u)
        else:
            s = n_joint + work.rows.n_contacts + j
            push_rows(solved, row_body, dof, r, s, p[r], p[s], p[s + 1], u)
