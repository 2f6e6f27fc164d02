"""Rows of contacts by a continuous force law, one contact at a time, and of joints beside them."""

from __future__ import annotations

from lcpflex.contact.detection import detect
from lcpflex.contact.rows import contact_rows
from lcpflex.dynamics.delassus import cholesky, cholesky_solve, delassus, dot
from lcpflex.dynamics.inertia import solve_block
from lcpflex.dynamics.law_memory import LawContacts
from lcpflex.dynamics.workspace import Workspace
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.kinematics.joint_rows import joint_rows
from lcpflex.model.arrays import Model

__all__ = ["couple_joints", "factor_joints", "lay", "look", "mobility", "push"]


@kernel
def look(model: Model, q: FloatArray, margin: float, laws: LawContacts) -> int:
    """Contacts by law with gap <= margin [m] into their table; returns how many."""
    n = detect(model, q, margin, laws.table)
    if n > len(laws.table.key):
        laws.too_small = 1
        n = 0
    laws.n_touching = n
    return n


@kernel
def lay(model: Model, q: FloatArray, k: int, laws: LawContacts) -> int:
    """Rows of entry k at q; the number of the normal one. The tangential one is that of a place both bodies share."""
    r = len(laws.joint)
    contact_rows(model, q, laws.table, k, laws.rows[r], laws.rows[r + 1])
    for i in range(2):
        body = laws.table.body[k, i]
        laws.row_body[r, i] = body
        laws.row_body[r + 1, i] = body
        if body >= 0:
            laws.rows[r + 1, i, 2] += 0.5 * laws.table.gap[k]
    return r


@kernel
def push(model: Model, laws: LawContacts, rows: FloatArray, r: int, force: float, out: FloatArray) -> None:
    """out += row r of ``rows`` times a force."""
    dof = model.bodies.dof
    for i in range(2):
        b = laws.row_body[r, i]
        if b >= 0:
            for k in range(dof[b + 1] - dof[b]):
                out[dof[b] + k] += rows[r, i, k] * force


@kernel
def mobility(model: Model, laws: LawContacts, r: int, work: Workspace) -> float:
    """G_NN of row r [1/kg] without joints, with the mass matrix that was factorised last: not less than with them."""
    total = 0.0
    dof = model.bodies.dof
    for i in range(2):
        b = laws.row_body[r, i]
        if b >= 0:
            solve_block(model.bodies, work.arrow, b, laws.rows[r, i], laws.solved[r, i])
            for k in range(dof[b + 1] - dof[b]):
                total += laws.rows[r, i, k] * laws.solved[r, i, k]
    return total


@kernel
def factor_joints(model: Model, t: float, q: FloatArray, u: FloatArray, work: Workspace) -> None:
    """Rows of the joints at q, M^-1 times them, and the factor of J M^-1 J^T; M as it was factorised last."""
    laws = work.laws
    n_joint = len(laws.joint)
    joint_rows(model, t, q, u, work.external, laws.rows, laws.row_body, laws.bias[0], laws.bias[1])
    for r in range(n_joint):
        for i in range(2):
            b = laws.row_body[r, i]
            if b >= 0:
                solve_block(model.bodies, work.arrow, b, laws.rows[r, i], laws.solved[r, i])
    delassus(laws.rows, laws.solved, laws.row_body, n_joint, laws.G)
    cholesky(laws.G, n_joint, laws.lower)


@kernel
def couple_joints(laws: LawContacts, r: int) -> float:
    """What joints take of the mobility of row r, after ``mobility``; laws.joint: their impulses to a unit one of it."""
    n_joint = len(laws.joint)
    first = 0 * r  # a literal would have dot compiled once more
    for j in range(n_joint):
        total = 0.0
        for i in range(2):
            for k in range(2):
                if laws.row_body[j, i] >= 0 and laws.row_body[j, i] == laws.row_body[r, k]:
                    total += dot(laws.rows[j, i], laws.solved[r, k], first, laws.rows.shape[2])
        laws.joint[j] = total
        laws.G[n_joint, j] = total
    cholesky_solve(laws.lower, n_joint, laws.joint)
    taken = 0.0
    for j in range(n_joint):
        taken += laws.joint[j] * laws.G[n_joint, j]
        laws.joint[j] = -laws.joint[j]
    return taken
