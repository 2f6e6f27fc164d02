"""The columns of a tangent stiffness: differences of all forces, one coordinate after the other, in one loop.

Only what a coordinate may change is told anew: contacts of its own body, all joints and the forces of bodies and loads.
"""

from __future__ import annotations

from lcpflex.contact.narrow_phase.feature import refresh
from lcpflex.contact.rows import contact_rows
from lcpflex.dynamics.mechanics import fill_contact_rows, fill_joint_rows, forces
from lcpflex.dynamics.rows import Rows
from lcpflex.dynamics.workspace import Workspace
from lcpflex.jit.kernel import FloatArray, IntArray, late_kernel
from lcpflex.kinematics.configuration import advance, difference
from lcpflex.model.arrays import Model

__all__ = ["lay_contacts", "stiffness_columns"]


@late_kernel
def lay_contacts(model: Model, q: FloatArray, n: int, n_joint: int, rows: Rows) -> int:
    """Measure the first n contacts of the table at q and lay their rows; how many tangential rows there are."""
    for k in range(n):
        refresh(model, q, rows.table, k)
    return fill_contact_rows(model, q, n, n_joint, rows)


@late_kernel
def stiffness_columns(
    model: Model,
    t: float,
    q: FloatArray,
    still: FloatArray,
    step: FloatArray,
    p: FloatArray,
    first_tangent: IntArray,
    moved: FloatArray,
    way: FloatArray,
    work: Workspace,
    K: FloatArray,
) -> None:
    """K (ndof, ndof) = -d(h + rows^T p)/dq by central differences of ``step`` (ndof,).

    p: multipliers of the joints and of the contacts in the table; first_tangent (n,): that of the first tangential row
    of each contact among p, -1 where it has none. still (ndof,) zeros; moved (2, nq), way (ndof,): room.
    """
    dof = model.bodies.dof
    way[:] = 0.0
    for b in range(len(dof) - 1):
        for i in range(dof[b], dof[b + 1]):
            for side in range(2):
                way[i] = step[i] if side == 0 else -step[i]
                advance(model, q, way, 1.0, moved[side])
                way[i] = 0.0
            difference(model, moved[1], moved[0], way)
            apart = way[i]  # which rounding of q makes another length than 2 steps
            way[:] = 0.0
            for side in range(2):
                sign = (1.0 if side == 1 else -1.0) / apart
                _add_forces(model, t, moved[side], still, b, p, first_tangent, sign, work, K[:, i])
        for k in range(len(first_tangent)):
            if _of_body(work.rows, k, b):
                refresh(model, q, work.rows.table, k)


@late_kernel
def _add_forces(
    model: Model,
    t: float,
    q: FloatArray,
    still: FloatArray,
    b: int,
    p: FloatArray,
    first_tangent: IntArray,
    sign: float,
    work: Workspace,
    out: FloatArray,
) -> None:
    """out += sign times all forces at q but those of contacts without body b."""
    rows, free = work.rows, work.free
    forces(model, t, q, still, work)
    for i in range(len(out)):
        out[i] += sign * free.total[i]
    n_joint = len(work.scratch.residual)
    if n_joint > 0:
        fill_joint_rows(model, t, q, still, free.external, rows)
        for r in range(n_joint):
            _add_row(rows, r, rows.body[r, 0], rows.body[r, 1], sign * p[r], out)
    scratch = len(rows.J) - rows.across
    for k in range(len(first_tangent)):
        if not _of_body(rows, k, b):
            continue
        refresh(model, q, rows.table, k)
        r, s = n_joint + k, first_tangent[k]
        end = scratch + rows.across if s >= 0 or rows.across == 1 else scratch
        contact_rows(model, q, rows.table, k, rows.J[r], rows.J[scratch:end])
        one, other = rows.table.body[k, 0], rows.table.body[k, 1]
        _add_row(rows, r, one, other, sign * p[r], out)
        if s >= 0:
            for a in range(rows.across):
                _add_row(rows, scratch + a, one, other, sign * p[s + a], out)


@late_kernel
def _of_body(rows: Rows, k: int, b: int) -> bool:
    """Whether contact k is one of body b."""
    return bool(rows.table.body[k, 0] == b or rows.table.body[k, 1] == b)


@late_kernel
def _add_row(rows: Rows, r: int, one: int, other: int, size: float, out: FloatArray) -> None:
    """out += size times row r, which acts on these two bodies (-1: none)."""
    if size == 0.0:
        return
    for i in range(2):
        b = one if i == 0 else other
        if b >= 0:
            first = rows.dof[b]
            for j in range(rows.dof[b + 1] - first):
                out[first + j] += size * rows.J[r, i, j]
