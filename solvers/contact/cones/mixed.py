"""Contact problems in space with cones and known slip side by side, solved: see :mod:`.mixed_problem`.

W is one matrix, which known slip makes unsymmetric. A contact alone is solved by its law, others by the attempts of
:data:`MIXED`, one after the other. What the problem is solved to is rounding where a few systems more come to that:
events are found by differences of forces.
"""

from __future__ import annotations

from lcpflex.jit.kernel import FloatArray, kernel, late_kernel
from lcpflex.jit.struct import allocate, struct
from lcpflex.solvers.contact.alart_curnier import alart_curnier
from lcpflex.solvers.contact.algebra import IN_SPACE, put, put_at, taken, taken_at
from lcpflex.solvers.contact.best import Best, copy_forces, forget_best, keep_best
from lcpflex.solvers.contact.cones.mixed_problem import MixedProblem, fill_units
from lcpflex.solvers.contact.group import Group
from lcpflex.solvers.contact.judging import FLOOR, Judged, judge, measure_loads, weigh
from lcpflex.solvers.contact.laws import COULOMB, HALF_LINE, LOADED
from lcpflex.solvers.contact.operators import begin
from lcpflex.solvers.contact.operators.dense import Dense
from lcpflex.solvers.contact.proximal_newton import NewtonWork
from lcpflex.solvers.contact.strategy import (
    AFRESH,
    ALART_CURNIER,
    ALWAYS,
    DEAR,
    NEWTON,
    SWEEPS,
    Attempt,
    Attempts,
    Search,
    find,
    search_parts,
)
from lcpflex.solvers.contact.sweeping import sweep

__all__ = ["MixedMemory", "judge_mixed", "mixed_memory", "polish_mixed", "solve_mixed"]

EXACT = 1e-14  # residual: nothing is gained below
SETTLING = 12  # systems for that, at most
AT_ONCE = 2  # sweeps: a contact alone needs one

MIXED = (
    Attempt(SWEEPS, 20, when=ALWAYS),
    Attempt(ALART_CURNIER, 40),
    Attempt(NEWTON, 40, eps=1e-6),
    Attempt(NEWTON, 100, eps=1e-2),
    Attempt(NEWTON, 200, eps=1e-2, when=DEAR),
    Attempt(SWEEPS, 100, when=ALWAYS),
    Attempt(NEWTON, 200, eps=0.1),
    Attempt(ALART_CURNIER, 100),
    Attempt(SWEEPS, 2000, when=ALWAYS),
    Attempt(NEWTON, 200, eps=1e-3),
    Attempt(NEWTON, 200, eps=1e-3, when=DEAR),
    Attempt(AFRESH),
    Attempt(ALART_CURNIER, 200),
)
"""W may be indefinite: solutions that sweeps and proximal points move away from are found as roots."""


@struct
class MixedMemory:
    """The problem by its contacts, and what is needed on the way."""

    judged: Judged
    search: Search
    attempts: Attempts
    group: Group
    op: Dense
    best: Best
    newton: NewtonWork


def mixed_memory(contacts: int) -> MixedMemory:
    """Room for problems of so many contacts."""
    sizes = {"units": contacts, "rows": 3, "block": 9, "matrix": 3 * contacts, "unknowns": 3 * contacts}
    group, op = allocate(Group, sizes), allocate(Dense, sizes)
    return allocate(MixedMemory, {}, group=group, op=op, **search_parts(sizes, MIXED))


@kernel
def pose(p: MixedProblem, memory: MixedMemory) -> None:
    """Rows, laws and W of all contacts. F is measured by its length, whatever W is: it may be indefinite."""
    group, op = memory.group, memory.op
    fill_units(p)
    group.n, op.m, op.symmetric = p.n, p.m, 0
    for i in range(p.m):
        op.free[i] = p.q[i]
        for j in range(p.m):
            op.columns[j, i] = p.W[i, j]
    for c in range(p.n):
        pose_contact(p, memory, c)
    measure_loads(group, memory.judged)


@kernel
def pose_contact(p: MixedProblem, memory: MixedMemory, c: int) -> None:
    """Rows and law of contact c, its own block, and the size of what it is to undo: floors are a part of that."""
    group, row, t = memory.group, memory.op.row, p.at[c]
    row[c, 0], row[c, 1], row[c, 2] = c, t, t + 1 if t >= 0 else -1
    law = COULOMB if p.floor[c] == 0.0 else LOADED
    group.law[c] = HALF_LINE if t < 0 else law
    group.mu[c], group.floor[c], group.unit[c], group.slip[c] = p.friction[c], p.floor[c], p.unit[c], 0.0
    load = 0.0
    for e in range(3):
        r = row[c, e]
        group.free[c, e] = p.q[r] if r >= 0 else 0.0
        if r >= 0:
            posed = max(abs(p.q[r]), FLOOR * p.terms[r])
            for b in range(p.n):
                posed += abs(p.W[r, b]) * p.floor[b]
            load = max(load, posed)
        for f in range(3):
            s = row[c, f]
            group.own[c, 3 * e + f] = p.W[r, s] if r >= 0 and s >= 0 else 0.0
    group.load[c] = p.unit[c] * load


@kernel
def take_forces(p: MixedProblem, memory: MixedMemory, r: FloatArray, forces: FloatArray) -> None:
    """The forces r, by rows, by contact."""
    for c in range(p.n):
        put(forces, c, taken_at(r, memory.op.row, c, IN_SPACE))


@kernel
def put_forces(p: MixedProblem, memory: MixedMemory, forces: FloatArray) -> None:
    """``p.r`` from forces by contact."""
    for c in range(p.n):
        put_at(p.r, memory.op.row, c, taken(forces, c, IN_SPACE))


@kernel
def judge_mixed(p: MixedProblem, memory: MixedMemory, r: FloatArray) -> float:
    """Residual of r for the problem posed last, and its velocities ``p.u``; ``p.strict``: relative to the load."""
    group, forces = memory.group, memory.newton.trial
    take_forces(p, memory, r, forces)
    weigh(memory.op, group, memory.judged, forces, IN_SPACE)
    for c in range(p.n):
        put_at(p.u, memory.op.row, c, taken(group.y, c, IN_SPACE))
    p.strict = memory.judged.strict
    return memory.judged.residual


@kernel
def settle(memory: MixedMemory) -> None:
    """Newton's method from the best point, to rounding."""
    group, judged, best, work = memory.group, memory.judged, memory.best, memory.newton
    judged.tolerance = EXACT
    copy_forces(group, best.p, group.p, IN_SPACE)
    alart_curnier(memory.op, group, judged, best, work, SETTLING, IN_SPACE)


@late_kernel
def search(memory: MixedMemory, tolerance: float) -> None:
    """From the forces of the group to the best point of all attempts."""
    memory.judged.tolerance = tolerance
    find(
        memory.op, memory.group, memory.judged, memory.best, memory.newton, memory.search, memory.attempts, IN_SPACE
    )  # fmt: skip
    settle(memory)


@kernel
def solve_mixed(p: MixedProblem, memory: MixedMemory, tolerance: float) -> float:
    """The forces p.r from nothing; their residual, as far below ``tolerance`` as it comes without much more."""
    group, judged = memory.group, memory.judged
    pose(p, memory)
    for c in range(p.n):
        group.p[c, 0], group.p[c, 1], group.p[c, 2] = group.floor[c], 0.0, 0.0
    begin(memory.op, group, group.p, IN_SPACE)
    p.iterations, _ = sweep(memory.op, group, IN_SPACE, AT_ONCE, EXACT * judged.load)
    weigh(memory.op, group, judged, group.p, IN_SPACE)
    if judged.residual <= EXACT:
        put_forces(p, memory, group.p)
    else:
        search(memory, tolerance)
        p.iterations += memory.search.sweeps + memory.newton.factors
        put_forces(p, memory, memory.best.p)
    return judge_mixed(p, memory, p.r)


@late_kernel
def polish_mixed(p: MixedProblem, memory: MixedMemory) -> float:
    """Newton's method from the forces p.r; their residual."""
    group, best = memory.group, memory.best
    take_forces(p, memory, p.r, group.p)
    forget_best(group, best, IN_SPACE)
    memory.newton.factors = 0
    keep_best(group, best, group.p, judge(memory.op, group, memory.judged, group.p, IN_SPACE), IN_SPACE)
    settle(memory)
    put_forces(p, memory, best.p)
    return judge_mixed(p, memory, p.r)
