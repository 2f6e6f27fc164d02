"""Large contact problems packed and solved within a budget, in the plane and in space; the best point of all is judged.

Rows of a scene become units of an island, each measured by its own diagonal:

    D_k = max of the diagonal of J_k J_k^T,   q = p sqrt(D),   y = v / sqrt(D)
"""

from __future__ import annotations

import numpy as np

from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.solvers.balance import DEAD, contact_units
from lcpflex.solvers.contact.algebra import Vector
from lcpflex.solvers.contact.best import copy_forces, forget_best, keep_best
from lcpflex.solvers.contact.judging import FLOOR, is_enough, is_good, judge, lags, measure_loads
from lcpflex.solvers.contact.large.memory import BodyContacts, LargeMemory
from lcpflex.solvers.contact.laws import BILATERAL, COULOMB, HALF_LINE
from lcpflex.solvers.contact.operators import prepare
from lcpflex.solvers.contact.proximal_newton import proximal_newton
from lcpflex.solvers.contact.strategy import NONE, ROOM, SETTLED, conclude, find, serve_lagging
from lcpflex.solvers.status import ITERATION_LIMIT, SOLVED

__all__ = ["ROOM", "pack", "solve_large", "take_impulses", "unpack"]

USUAL = 1e-6  # strict residual of the problem before up to which no better one is sought by all means
SETTLING_EPS, MORE, CHEAP = 1e-8, 12, 1e7  # for that: factors at most, and the operations that each may cost


@kernel
def pack(problem: BodyContacts, memory: LargeMemory, like: Vector) -> None:
    """The problem in units: rows, their velocities and forces scaled by the diagonal of each unit."""
    bodies, dof, local, op, group = problem.bodies, problem.dof, memory.local, memory.op, memory.group
    end = 0
    for b in range(problem.n_bodies):
        local[bodies[b]] = b
        op.pos[b] = end
        end += dof[bodies[b] + 1] - dof[bodies[b]]
    op.pos[problem.n_bodies] = end
    op.n_bodies, op.n_unknowns = problem.n_bodies, end
    for k in range(problem.n_contacts):
        list_contact(problem, memory, k, like)
    group.n = list_joints(problem, memory, problem.n_contacts, like)
    for k in range(group.n):
        pack_unit(problem, memory, k, like)
    contact_units(memory.scale, group.n, DEAD)
    for k in range(group.n):
        scale_unit(problem, memory, k, like)
    measure_loads(group, memory.judged)
    for b in range(problem.n_bodies):
        local[bodies[b]] = -1


@kernel
def list_contact(problem: BodyContacts, memory: LargeMemory, k: int, like: Vector) -> None:
    """Rows and law of contact k."""
    first, row, group = problem.tangent_row[k], memory.row, memory.group
    row[k, 0] = problem.normal_row[k]
    for e in range(1, len(like)):
        row[k, e] = first + e - 1 if first >= 0 else -1
    group.law[k] = COULOMB if first >= 0 else HALF_LINE
    group.mu[k] = problem.friction[k] if first >= 0 else 0.0
    group.floor[k] = 0.0


@kernel
def list_joints(problem: BodyContacts, memory: LargeMemory, count: int, like: Vector) -> int:
    """Joint rows behind ``count`` contacts, up to S in a row of the same bodies in one unit; how many units."""
    listed, row_body, j = problem.joint_row, problem.row_body, 0
    while j < problem.n_joints:
        r, together = listed[j], 0
        memory.group.law[count], memory.group.mu[count] = BILATERAL, 0.0
        for e in range(len(like)):
            memory.row[count, e] = -1
            if together == e and j < problem.n_joints:
                s = listed[j]
                if row_body[s, 0] == row_body[r, 0] and row_body[s, 1] == row_body[r, 1]:
                    memory.row[count, e] = s
                    together += 1
                    j += 1
        count += 1
    return count


@kernel
def pack_unit(problem: BodyContacts, memory: LargeMemory, k: int, like: Vector) -> None:
    """Rows of unit k as they are, and its own block of J J^T, the largest diagonal entry of it in ``scale``."""
    dof, white, row_body, row = problem.dof, problem.white, problem.row_body, memory.row
    J, body, own = memory.op.J, memory.op.body, memory.group.own
    first = row[k, 0]
    for i in range(2):
        b = row_body[first, i]
        body[k, i] = memory.local[b] if b >= 0 else -1
    same = body[k, 0] >= 0 and body[k, 0] == body[k, 1]
    for i in range(2):
        if body[k, i] < 0:
            continue
        b = row_body[first, i]
        for e in range(len(like)):
            r = row[k, e]
            for j in range(dof[b + 1] - dof[b]):
                entry = white[r, i, j] if r >= 0 else 0.0
                J[k, i, e, j] = entry
                if same and i == 1:  # a body that touches itself: both blocks in the first
                    J[k, 0, e, j] += entry
    if same:
        body[k, 1] = -1
    largest = 0.0
    for e in range(len(like)):
        for f in range(e + 1):
            total = own_entry(memory, k, e, f)
            own[k, len(like) * e + f] = total
            own[k, len(like) * f + e] = total
        largest = max(largest, own[k, len(like) * e + e])
    memory.scale[k] = largest


@kernel
def own_entry(memory: LargeMemory, k: int, e: int, f: int) -> float:
    """Row e of unit k with its row f."""
    op, total = memory.op, 0.0
    for i in range(2):
        b = op.body[k, i]
        if b >= 0:
            for j in range(op.pos[b + 1] - op.pos[b]):
                total += op.J[k, i, e, j] * op.J[k, i, f, j]
    return total


@kernel
def scale_unit(problem: BodyContacts, memory: LargeMemory, k: int, like: Vector) -> None:
    """Unit k in its own units, and the size of its free velocities."""
    s, group, op, row = memory.scale[k], memory.group, memory.op, memory.row
    for e in range(len(like) * len(like)):
        group.own[k, e] *= s * s
    for i in range(2):
        b = op.body[k, i]
        if b >= 0:
            for e in range(len(like)):
                for j in range(op.pos[b + 1] - op.pos[b]):
                    op.J[k, i, e, j] *= s
    load = 0.0
    for e in range(len(like)):
        r = row[k, e]
        group.p[k, e] = problem.p[r] / s if r >= 0 else 0.0
        group.free[k, e] = problem.free[r] * s if r >= 0 else 0.0
        load = max(load, abs(group.free[k, e]))
        if r >= 0 and group.law[k] != BILATERAL:
            load = max(load, FLOOR * s * problem.terms[r - problem.first_contact])
    group.load[k], group.unit[k], group.slip[k] = load, 1.0, 0.0
    if k < len(problem.slip):
        group.slip[k] = problem.slip[k] * s * s


@kernel
def unpack(problem: BodyContacts, memory: LargeMemory, p: FloatArray, like: Vector) -> None:
    """Forces of the rows from those of the units."""
    for k in range(memory.group.n):
        for e in range(len(like)):
            if memory.row[k, e] >= 0:
                problem.p[memory.row[k, e]] = p[k, e] * memory.scale[k]
    for k in range(min(problem.n_contacts, len(problem.slip))):
        problem.slip[k] = memory.group.slip[k] / (memory.scale[k] * memory.scale[k])


@kernel
def settle(memory: LargeMemory, like: Vector) -> None:
    """Where nothing slips, a few factors more for a residual of rounding: what rests does not creep."""
    op, group, judged, best, work = memory.op, memory.group, memory.judged, memory.best, memory.newton
    if judged.sliding == 0 and prepare(op, group) and op.factor.work <= CHEAP:
        tolerance, floor = judged.tolerance, work.floor
        judged.tolerance, work.floor = SETTLED, SETTLING_EPS  # which stays: one factor serves
        copy_forces(group, best.p, group.p, like)
        proximal_newton(op, group, judged, best, work, SETTLING_EPS, MORE, like)
        judged.tolerance, work.floor = tolerance, floor
        conclude(op, group, judged, best, like)


@kernel
def take_impulses(problem: BodyContacts, memory: LargeMemory, like: Vector) -> bool:
    """Take the impulses p as they are for the answer; whether they are within the tolerance."""
    op, group, judged, best = memory.op, memory.group, memory.judged, memory.best
    pack(problem, memory, like)
    forget_best(group, best, like)
    keep_best(group, best, group.p, judge(op, group, judged, group.p, like), like)
    conclude(op, group, judged, best, like)
    return is_enough(op, group, judged, best, like)


@kernel
def solve_large(problem: BodyContacts, memory: LargeMemory, like: Vector) -> int:
    """Solve a large contact problem from the impulses p, which are replaced; SOLVED, ITERATION_LIMIT or ROOM.

    After ROOM nothing is changed but what is wanting in ``memory.op.factor``.
    """
    op, group, judged, best, search = memory.op, memory.group, memory.judged, memory.best, memory.search
    search.usual = judged.strict if judged.tolerance < judged.strict <= USUAL else 0.0
    pack(problem, memory, like)
    if not find(op, group, judged, best, memory.newton, search, memory.attempts, like):
        return ROOM
    conclude(op, group, judged, best, like)
    if len(like) == 3 and search.route != NONE:
        settle(memory, like)
    if lags(judged) and not serve_lagging(op, group, judged, best, memory.newton, search, like):
        return ROOM
    unpack(problem, memory, best.p, like)
    # Where the rounding of the velocities is a part of the free ones, no residual says anything: it is inf.
    return SOLVED if is_good(judged) and judged.residual < np.inf else ITERATION_LIMIT
