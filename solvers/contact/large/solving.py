"""Large contact problems solved within a budget, in the plane and in space; the best point of all is judged."""

from __future__ import annotations

import numpy as np

from lcpflex.jit.kernel import kernel
from lcpflex.solvers.contact.algebra import Vector
from lcpflex.solvers.contact.best import copy_forces, forget_best, keep_best
from lcpflex.solvers.contact.judging import is_enough, is_good, judge, lags
from lcpflex.solvers.contact.large.memory import BodyContacts, LargeMemory
from lcpflex.solvers.contact.large.packing import pack, unpack
from lcpflex.solvers.contact.operators import prepare
from lcpflex.solvers.contact.proximal_newton import proximal_newton
from lcpflex.solvers.contact.strategy import NONE, ROOM, SETTLED, conclude, find, serve_lagging
from lcpflex.solvers.status import ITERATION_LIMIT, SOLVED

__all__ = ["ROOM", "solve_large", "take_impulses"]

USUAL = 1e-6  # strict residual of the problem before up to which no better one is sought by all means
SETTLING_EPS, MORE, CHEAP = 1e-8, 12, 1e7  # for that: factors at most, and the operations that each may cost


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
