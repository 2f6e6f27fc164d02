"""Who is tried when on a large contact problem in space, within a budget; the best point of all is kept and judged."""

from __future__ import annotations

import numpy as np

from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.solvers.contact.cones.large.judging import conclude, is_enough, is_exact, judge, keep_best
from lcpflex.solvers.contact.cones.large.memory import FRICTIONAL, LargeCones, SpatialLargeMemory
from lcpflex.solvers.contact.cones.large.newton import convex_start, proximal_newton
from lcpflex.solvers.contact.cones.large.packing import pack, take_over, unpack
from lcpflex.solvers.contact.cones.large.sweeping import sweep
from lcpflex.solvers.contact.large.fronts import has_room
from lcpflex.solvers.contact.large.memory import BodyContacts
from lcpflex.solvers.contact.large.ordering import make_pattern
from lcpflex.solvers.status import ITERATION_LIMIT, SOLVED

__all__ = ["ROOM", "ROUTES", "solve_large_cones"]

ROOM = 100  # status: the memory is to grow first
AT_ONCE, SWEPT, CONVEX, NEWTON, LATER, AFRESH, NONE = range(7)
ROUTES = ("as it was", "sweeps", "convex law, Newton", "Newton", "Newton, sweeps", "from nothing", "best point of all")
SWEEPS = 40  # before anything else
LEAST_FACTORS = 100
ASTRAY = 1e3  # residual, relative to the free velocities, from which a start is not worth having
FAR, FOUND = 0.1, 1e-3  # residual of a start from nothing, and the one below which the convex law was of use
LEAST_EPS = 1e-12
SLIDING = 1e-6  # of the free velocities: a contact that slips by more is no resting one
SETTLED = 1e-14  # what is left where nothing creeps
SETTLING_EPS, MORE, CHEAP = 1e-8, 12, 1e7  # for that: factors at most, and the operations that each may cost
LOOK = 10  # sweeps between two looks at the residual
UNIT_WORK = 900.0  # multiplications of a factor that take as long as a sweep over one unit
BESIDES = 10.0  # sweeps that take as long as what goes with a factor
DEAR = 40.0  # sweeps that take as long as a factor: from there on they are the better use of a budget
FEW, SHARE = 10, 40  # factors: of a budget that is spent on sweeps alone, and what of another is, at most
CLOSE = 1e-4  # residual of a point from which a few factors may do, relative to the free velocity


@kernel
def sweep_and_look(memory: SpatialLargeMemory, count: int, patient: bool) -> bool:
    """``count`` sweeps from q, less where they crawl and one is not ``patient``; whether the best point is exact."""
    worst = judge(memory, memory.q)
    done = 0
    while done < count:
        sweep(memory, LOOK)
        done += LOOK
        before = worst
        worst = judge(memory, memory.q)
        keep_best(memory, memory.q, worst)
        if is_exact(memory):
            return True
        if worst > 0.7 * before and not patient:
            break
    return False


@kernel
def sweep_work(memory: SpatialLargeMemory) -> float:
    """What a sweep takes, in multiplications of a factor."""
    return UNIT_WORK * max(memory.n_units, 1)


@kernel
def is_dear(memory: SpatialLargeMemory) -> bool:
    """Whether a factor takes as long as many sweeps."""
    return bool(memory.factor.work > DEAR * sweep_work(memory))


@kernel
def bound_factors(memory: SpatialLargeMemory) -> None:
    """How many factors the budget is worth: no fewer than for Newton's method, where they are not dear."""
    worth = memory.operation_limit / max(memory.factor.work, 1.0)
    least = FEW if is_dear(memory) else LEAST_FACTORS
    memory.allowed = min(memory.factor_limit, max(least, int(min(worth, 1e9))))


@kernel
def newton(memory: SpatialLargeMemory, eps: float, factors: int) -> bool:
    """Newton's method from the best point, within what is left of the budget."""
    take_over(memory, memory.best, memory.q)
    return proximal_newton(memory, eps, min(factors, memory.allowed - memory.factors))


@kernel
def swept_newton(memory: SpatialLargeMemory, sweeps: int, eps: float, factors: int) -> bool:
    """Sweeps from the best point, which find states that Newton's method does not, and that one again."""
    if memory.factors >= memory.allowed:
        return False
    take_over(memory, memory.best, memory.q)
    return sweep_and_look(memory, sweeps, True) or newton(memory, eps, factors)


@kernel
def rests(memory: SpatialLargeMemory) -> bool:
    """Whether no contact that presses slips at the forces judged last."""
    q, y = memory.q, memory.y
    for k in range(memory.n_units):
        if memory.kind[k] <= FRICTIONAL and q[k, 0] > 0.0 and abs(y[k, 1]) + abs(y[k, 2]) > SLIDING * memory.load:
            return False
    return True


@kernel
def sweep_share(memory: SpatialLargeMemory, share: int) -> bool:
    """Sweeps from the best point that take as long as ``share`` factors, which the budget then lacks."""
    count = int(min(share * (memory.factor.work / sweep_work(memory) + BESIDES), 1e6))
    take_over(memory, memory.best, memory.q)
    memory.allowed -= share
    return sweep_and_look(memory, count, True)


@kernel
def spend_on_sweeps(memory: SpatialLargeMemory, dear: bool) -> int:
    """The whole budget: on sweeps, but where factors are dear and the best point is close, half of it on them."""
    if dear and memory.worst <= CLOSE * memory.load:
        if newton(memory, 1e-2, memory.allowed // 2):
            return NEWTON
        memory.allowed -= memory.factors
    return SWEPT if sweep_share(memory, memory.allowed) else NONE


@kernel
def settle(memory: LargeCones) -> None:
    """Where nothing slips, a few factors more for a residual of rounding: what rests does not creep."""
    take_over(memory, memory.best, memory.q)
    judge(memory, memory.q)
    if not rests(memory) or not make_pattern(memory, memory.factor) or not has_room(memory.factor):
        return
    if memory.factor.work <= CHEAP:
        tolerance = memory.tolerance
        memory.tolerance, memory.floor = SETTLED, SETTLING_EPS  # which stays: one factor serves
        proximal_newton(memory, SETTLING_EPS, MORE)
        memory.tolerance = tolerance


@kernel
def find(memory: LargeCones) -> int:
    """The best point to ``best``; returns the route, or ROOM."""
    worst = judge(memory, memory.q)
    if not worst <= ASTRAY * memory.load:
        for k in range(memory.n_units):
            memory.q[k, 0], memory.q[k, 1], memory.q[k, 2] = 0.0, 0.0, 0.0
        worst = judge(memory, memory.q)
    keep_best(memory, memory.q, worst)
    if is_exact(memory):
        return AT_ONCE
    no = not worst >= 0.0
    if sweep_and_look(memory, SWEEPS, no):
        return SWEPT
    if not make_pattern(memory, memory.factor) or not has_room(memory.factor):
        return ROOM
    bound_factors(memory)
    dear = is_dear(memory)
    if dear or memory.allowed < FEW:
        return spend_on_sweeps(memory, dear)
    if sweep_share(memory, min(memory.allowed // 2, SHARE)):
        return SWEPT
    if newton(memory, 1e-6, 6):
        return NEWTON
    if memory.worst > FAR * memory.load:
        take_over(memory, memory.best, memory.q)
        convex_start(memory, min(100, memory.allowed - memory.factors))
        if memory.worst <= FOUND * memory.load and newton(memory, 1e-2, 60):
            return CONVEX
    if newton(memory, 1e-2, 150):
        return NEWTON
    if swept_newton(memory, 20, 0.1, 150) or swept_newton(memory, 20, 1e-3, 100) or swept_newton(memory, 100, 0.1, 60):
        return LATER
    return NONE


@kernel
def solve_large_cones(problem: BodyContacts, slip: FloatArray, memory: SpatialLargeMemory) -> int:
    """Solve a large contact problem from the forces p, which are replaced; SOLVED, ITERATION_LIMIT or ROOM.

    slip (contacts,): |u_T| / |r_T| of each contact, where to start and out. After ROOM nothing is changed but what is
    wanting in ``memory.factor``.
    """
    memory.factors, memory.sweeps, memory.worst, memory.convex, memory.floor = 0, 0, 1e300, 0, LEAST_EPS
    pack(problem, memory)
    for k in range(memory.n_units):
        unit = memory.scale[k]
        memory.slip[k] = slip[k] * unit * unit if k < problem.n_contacts else 0.0
        memory.best[k, 0], memory.best[k, 1], memory.best[k, 2] = 0.0, 0.0, 0.0
    route = find(memory)
    if route == ROOM:
        return ROOM
    memory.route = route
    if route != NONE:
        settle(memory)
    conclude(memory)
    unpack(problem, memory, memory.best)
    for k in range(problem.n_contacts):
        unit = memory.scale[k]
        slip[k] = memory.slip[k] / (unit * unit)
    # Where the rounding of the velocities is a part of the free ones, no residual says anything: it is inf.
    return SOLVED if is_enough(memory) and memory.residual < np.inf else ITERATION_LIMIT
