"""From rows of a scene to units of an island, and the products with J that everything is made of."""

from __future__ import annotations

from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.solvers.balance import DEAD, contact_units
from lcpflex.solvers.contact.cones.large.memory import FRICTIONAL, JOINT_ROWS, NORMAL, SpatialLargeMemory
from lcpflex.solvers.contact.large.memory import BodyContacts

__all__ = ["add_forces", "pack", "take_over", "unpack", "velocities"]

FLOOR = 1e-3  # of the terms of which free velocities are made: less of them is no measure of a residual


@kernel
def pack(problem: BodyContacts, memory: SpatialLargeMemory) -> None:
    """The problem in units: rows, their velocities and forces scaled by the diagonal of each unit."""
    bodies, dof, local, pos = problem.bodies, problem.dof, memory.local, memory.pos
    n, m, end = problem.n_contacts, problem.n_bodies, 0
    for b in range(m):
        body = bodies[b]
        local[body] = b
        pos[b] = end
        end += dof[body + 1] - dof[body]
    pos[m] = end
    memory.n_bodies, memory.n_unknowns = m, end
    for k in range(n):
        s = problem.tangent_row[k]
        memory.rows[k, 0] = problem.normal_row[k]
        memory.rows[k, 1] = s
        memory.rows[k, 2] = s + 1 if s >= 0 else -1
        memory.kind[k] = FRICTIONAL if s >= 0 else NORMAL
        memory.mu[k] = problem.friction[k] if s >= 0 else 0.0
    memory.n_units = list_joints(problem, memory, n)
    for k in range(memory.n_units):
        pack_unit(problem, memory, k)
    contact_units(memory.scale, memory.n_units, DEAD)
    load = 0.0
    for k in range(memory.n_units):
        load = max(load, scale_unit(problem, memory, k))
    memory.load = load
    for b in range(m):
        local[bodies[b]] = -1


@kernel
def list_joints(problem: BodyContacts, memory: SpatialLargeMemory, count: int) -> int:
    """Joint rows behind ``count`` contacts, up to three in a row of the same bodies in one unit; how many units."""
    listed, row_body = problem.joint_row, problem.row_body
    j = 0
    while j < problem.n_joints:
        r = listed[j]
        memory.kind[count] = JOINT_ROWS
        memory.mu[count] = 0.0
        together = 0
        for e in range(3):
            memory.rows[count, e] = -1
            if together == e and j < problem.n_joints:
                s = listed[j]
                if row_body[s, 0] == row_body[r, 0] and row_body[s, 1] == row_body[r, 1]:
                    memory.rows[count, e] = s
                    together += 1
                    j += 1
        count += 1
    return count


@kernel
def pack_unit(problem: BodyContacts, memory: SpatialLargeMemory, k: int) -> None:
    """Rows of unit k as they are, and its own block of J J^T, the largest diagonal entry of it in ``scale``."""
    dof, white, row_body, rows, J, body, W = (
        problem.dof, problem.white, problem.row_body, memory.rows, memory.J, memory.body, memory.W,
    )  # fmt: skip
    first = rows[k, 0]
    for i in range(2):
        b = row_body[first, i]
        body[k, i] = memory.local[b] if b >= 0 else -1
    same = body[k, 0] >= 0 and body[k, 0] == body[k, 1]
    for i in range(2):
        if body[k, i] < 0:
            continue
        b = row_body[first, i]
        for e in range(3):
            r = rows[k, e]
            for j in range(dof[b + 1] - dof[b]):
                entry = white[r, i, j] if r >= 0 else 0.0
                J[k, i, e, j] = entry
                if same and i == 1:  # a body that touches itself: both blocks in the first
                    J[k, 0, e, j] += entry
    if same:
        body[k, 1] = -1
    for e in range(6):
        W[k, e] = 0.0
    for i in range(2):
        b = body[k, i]
        if b >= 0:
            for j in range(memory.pos[b + 1] - memory.pos[b]):
                n, t, s = J[k, i, 0, j], J[k, i, 1, j], J[k, i, 2, j]
                W[k, 0] += n * n
                W[k, 1] += n * t
                W[k, 2] += n * s
                W[k, 3] += t * t
                W[k, 4] += t * s
                W[k, 5] += s * s
    memory.scale[k] = max(W[k, 0], max(W[k, 3], W[k, 5]))


@kernel
def scale_unit(problem: BodyContacts, memory: SpatialLargeMemory, k: int) -> float:
    """Unit k in its own units; the size of its free velocities."""
    s, load, J, rows = memory.scale[k], 0.0, memory.J, memory.rows
    for e in range(6):
        memory.W[k, e] *= s * s
    for i in range(2):
        b = memory.body[k, i]
        if b >= 0:
            width = memory.pos[b + 1] - memory.pos[b]
            for e in range(3):
                for j in range(width):
                    J[k, i, e, j] *= s
    for e in range(3):
        r = rows[k, e]
        memory.q[k, e] = problem.p[r] / s if r >= 0 else 0.0
        memory.free[k, e] = problem.free[r] * s if r >= 0 else 0.0
        load = max(load, abs(memory.free[k, e]))
        if r >= 0 and memory.kind[k] <= FRICTIONAL:
            load = max(load, FLOOR * s * problem.terms[r - problem.first_contact])
    return load


@kernel
def unpack(problem: BodyContacts, memory: SpatialLargeMemory, q: FloatArray) -> None:
    """Forces of the rows from those of the units."""
    for k in range(memory.n_units):
        for e in range(3):
            if memory.rows[k, e] >= 0:
                problem.p[memory.rows[k, e]] = q[k, e] * memory.scale[k]


@kernel
def take_over(memory: SpatialLargeMemory, source: FloatArray, target: FloatArray) -> None:
    """target = source, both (units, 3)."""
    for k in range(memory.n_units):
        target[k, 0], target[k, 1], target[k, 2] = source[k, 0], source[k, 1], source[k, 2]


@kernel
def velocities(memory: SpatialLargeMemory, free: FloatArray, x: FloatArray, y: FloatArray) -> None:
    """y = free + J x of all units."""
    pos, body, J = memory.pos, memory.body, memory.J
    for k in range(memory.n_units):
        n, t, s = free[k, 0], free[k, 1], free[k, 2]
        for i in range(2):
            b = body[k, i]
            if b >= 0:
                o = pos[b]
                for j in range(pos[b + 1] - o):
                    v = x[o + j]
                    n += J[k, i, 0, j] * v
                    t += J[k, i, 1, j] * v
                    s += J[k, i, 2, j] * v
        y[k, 0], y[k, 1], y[k, 2] = n, t, s


@kernel
def add_forces(memory: SpatialLargeMemory, factor: float, q: FloatArray, x: FloatArray) -> None:
    """x += factor J^T q."""
    pos, body, J = memory.pos, memory.body, memory.J
    for k in range(memory.n_units):
        n, t, s = factor * q[k, 0], factor * q[k, 1], factor * q[k, 2]
        if n != 0.0 or t != 0.0 or s != 0.0:
            for i in range(2):
                b = body[k, i]
                if b >= 0:
                    o = pos[b]
                    for j in range(pos[b + 1] - o):
                        x[o + j] += J[k, i, 0, j] * n + J[k, i, 1, j] * t + J[k, i, 2, j] * s
