"""From rows of a scene to units of an island, and the products with J that everything is made of."""

from __future__ import annotations

from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.solvers.balance import DEAD, contact_units
from lcpflex.solvers.contact.large.memory import FRICTIONAL, HINGE, JOINT_ROW, NORMAL, BodyContacts, LargeMemory

__all__ = ["add_impulses", "pack", "unpack", "velocities"]

FLOOR = 1e-3  # of the terms of which free velocities are made: less of them is no measure of a residual


@kernel
def pack(problem: BodyContacts, memory: LargeMemory) -> None:
    """The problem in units: rows, their velocities and impulses scaled by the diagonal of each unit."""
    bodies, dof, local, pos = problem.bodies, problem.dof, memory.local, memory.pos
    n, m = problem.n_contacts, problem.n_bodies
    end = 0
    for b in range(m):
        body = bodies[b]
        local[body] = b
        pos[b] = end
        end += dof[body + 1] - dof[body]
    pos[m] = end
    memory.n_bodies, memory.n_unknowns = m, end
    for k in range(n):
        memory.rows[k, 0], memory.rows[k, 1] = problem.normal_row[k], problem.tangent_row[k]
        memory.kind[k] = FRICTIONAL if problem.tangent_row[k] >= 0 else NORMAL
        memory.mu[k] = problem.friction[k] if problem.tangent_row[k] >= 0 else 0.0
    memory.n_units = list_joints(problem, memory, n)
    for k in range(memory.n_units):
        pack_unit(problem, memory, k)
    contact_units(memory.scale, memory.n_units, DEAD)
    load = 0.0
    for k in range(memory.n_units):
        memory.own[k] = scale_unit(problem, memory, k)
        load = max(load, memory.own[k])
    memory.load = load
    for b in range(m):
        local[bodies[b]] = -1


@kernel
def list_joints(problem: BodyContacts, memory: LargeMemory, count: int) -> int:
    """Joint rows behind ``count`` contacts, two in a row of the same bodies in one unit; returns how many units."""
    rows, row_body = problem.joint_row, problem.row_body
    j = 0
    while j < problem.n_joints:
        r = rows[j]
        memory.rows[count, 0], memory.rows[count, 1] = r, -1
        memory.kind[count] = JOINT_ROW
        memory.mu[count] = 0.0
        j += 1
        if j < problem.n_joints:
            s = rows[j]
            if row_body[s, 0] == row_body[r, 0] and row_body[s, 1] == row_body[r, 1]:
                memory.rows[count, 1] = s
                memory.kind[count] = HINGE
                j += 1
        count += 1
    return count


@kernel
def pack_unit(problem: BodyContacts, memory: LargeMemory, k: int) -> None:
    """Rows of unit k as they are, and its own block of J J^T, the larger diagonal entry of it in ``scale``."""
    dof, white, row_body = problem.dof, problem.white, problem.row_body
    normal, tangent = memory.rows[k, 0], memory.rows[k, 1]
    a, b, d = 0.0, 0.0, 0.0
    first, second = row_body[normal, 0], row_body[normal, 1]
    memory.body[k, 0] = memory.local[first] if first >= 0 else -1
    memory.body[k, 1] = memory.local[second] if second >= 0 else -1
    same = memory.body[k, 0] >= 0 and memory.body[k, 0] == memory.body[k, 1]
    for i in range(2):
        side, along = memory.J[k, 0, i], memory.J[k, 1, i]
        if memory.body[k, i] < 0:
            continue
        body = row_body[normal, i]
        for j in range(dof[body + 1] - dof[body]):
            side[j] = white[normal, i, j]
            along[j] = white[tangent, i, j] if tangent >= 0 else 0.0
            if same and i == 1:  # a body that touches itself: both blocks in the first
                memory.J[k, 0, 0, j] += side[j]
                memory.J[k, 1, 0, j] += along[j]
    if same:
        memory.body[k, 1] = -1
    for i in range(2):
        if memory.body[k, i] >= 0:
            side, along = memory.J[k, 0, i], memory.J[k, 1, i]
            for j in range(memory.pos[memory.body[k, i] + 1] - memory.pos[memory.body[k, i]]):
                a += side[j] * side[j]
                b += side[j] * along[j]
                d += along[j] * along[j]
    memory.W[k, 0], memory.W[k, 1], memory.W[k, 2] = a, b, d
    memory.scale[k] = max(a, d)


@kernel
def scale_unit(problem: BodyContacts, memory: LargeMemory, k: int) -> float:
    """Unit k in its own units; the size of its free velocities."""
    s, load = memory.scale[k], 0.0
    for r in range(3):
        memory.W[k, r] *= s * s
    for i in range(2):
        if memory.body[k, i] >= 0:
            for r in range(2):
                row = memory.J[k, r, i]
                for j in range(memory.pos[memory.body[k, i] + 1] - memory.pos[memory.body[k, i]]):
                    row[j] *= s
    for r in range(2):
        row_of = memory.rows[k, r]
        memory.q[k, r] = problem.p[row_of] / s if row_of >= 0 else 0.0
        memory.free[k, r] = problem.free[row_of] * s if row_of >= 0 else 0.0
        load = max(load, abs(memory.free[k, r]))
        if row_of >= 0 and memory.kind[k] <= FRICTIONAL:
            load = max(load, FLOOR * s * problem.terms[row_of - problem.first_contact])
    return load


@kernel
def unpack(problem: BodyContacts, memory: LargeMemory, q: FloatArray) -> None:
    """Impulses of the rows from those of the units."""
    for k in range(memory.n_units):
        for r in range(2):
            if memory.rows[k, r] >= 0:
                problem.p[memory.rows[k, r]] = q[k, r] * memory.scale[k]


@kernel
def velocities(memory: LargeMemory, free: FloatArray, x: FloatArray, y: FloatArray) -> None:
    """y = free + J x of all units."""
    pos, body, J = memory.pos, memory.body, memory.J
    for k in range(memory.n_units):
        normal, tangent = free[k, 0], free[k, 1]
        for i in range(2):
            b = body[k, i]
            if b >= 0:
                o, size = pos[b], pos[b + 1] - pos[b]
                side, along = J[k, 0, i], J[k, 1, i]
                for j in range(size):
                    normal += side[j] * x[o + j]
                    tangent += along[j] * x[o + j]
        y[k, 0], y[k, 1] = normal, tangent


@kernel
def add_impulses(memory: LargeMemory, factor: float, q: FloatArray, x: FloatArray) -> None:
    """x += factor J^T q."""
    pos, body, J = memory.pos, memory.body, memory.J
    for k in range(memory.n_units):
        normal, tangent = factor * q[k, 0], factor * q[k, 1]
        if normal != 0.0 or tangent != 0.0:
            for i in range(2):
                b = body[k, i]
                if b >= 0:
                    o, size = pos[b], pos[b + 1] - pos[b]
                    side, along = J[k, 0, i], J[k, 1, i]
                    for j in range(size):
                        x[o + j] += side[j] * normal + along[j] * tangent
