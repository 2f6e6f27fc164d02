"""Who is tried when on a large contact problem, within a budget; the best point of all is kept and judged."""

from __future__ import annotations

from lcpflex.jit.kernel import kernel
from lcpflex.solvers.contact.large.fronts import has_room
from lcpflex.solvers.contact.large.judging import (
    conclude,
    is_enough,
    is_exact,
    is_good,
    judge,
    keep_best,
    lags,
    term_size,
)
from lcpflex.solvers.contact.large.memory import BodyContacts, LargeMemory
from lcpflex.solvers.contact.large.newton import convex_start, proximal_newton
from lcpflex.solvers.contact.large.ordering import make_pattern
from lcpflex.solvers.contact.large.packing import pack, unpack
from lcpflex.solvers.contact.large.sweeping import sweep
from lcpflex.solvers.contact.large.tracing import trace
from lcpflex.solvers.status import ITERATION_LIMIT, SOLVED

__all__ = ["ROOM", "ROUTES", "solve_large", "take_impulses"]

ROOM = 100  # status: the memory is to grow first, see lcpflex.solvers.contact.large.memory.grown
AT_ONCE, SWEPT, CONVEX, NEWTON, TRACED, LATER, AFRESH, NONE = range(8)
ROUTES = (
    "as it was",
    "sweeps",
    "convex law, Newton",
    "Newton",
    "Newton, path",
    "Newton, path, sweeps, path",
    "from nothing",
    "best point of all",
)
SWEEPS = 40  # before anything else
LEAST_FACTORS = 100
ASTRAY = 1e3  # residual, relative to that of no impulses at all, from which a start is not worth having
USUAL = 1e-6  # strict residual of the problem before up to which no better one is sought by all means
WEDGED = 1e3  # terms, relative to the free velocities, from which bodies are wedged
FAR, FOUND = 0.1, 1e-3  # residual of a start from nothing, and the one below which the convex law was of use
LOOK = 10  # sweeps between two looks at the residual
SETTLED = 1e-14  # of the free velocities: what may be left where contacts lag, so that those of the next step do not


@kernel
def sweep_and_look(memory: LargeMemory, count: int, patient: bool) -> bool:
    """``count`` sweeps from q, less where they crawl and one is not ``patient``; whether the best point is exact."""
    worst = judge(memory, memory.q)
    done = 0
    while done < count and memory.sweeps < memory.sweep_limit:
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
def take_best(memory: LargeMemory) -> None:
    """Go on from the best point."""
    for k in range(memory.n_units):
        memory.q[k, 0], memory.q[k, 1] = memory.best[k, 0], memory.best[k, 1]


@kernel
def bound_factors(memory: LargeMemory) -> None:
    """How many factors the budget is worth: no fewer than for Newton's method and one path."""
    worth = memory.operation_limit / max(memory.factor.work, 1.0)
    memory.allowed = min(memory.factor_limit, max(LEAST_FACTORS, int(min(worth, 1e9))))


@kernel
def newton(memory: LargeMemory, eps: float, factors: int) -> bool:
    """Newton's method from the best point, within what is left of the budget."""
    take_best(memory)
    return proximal_newton(memory, eps, min(factors, memory.allowed - memory.factors))


@kernel
def follow(memory: LargeMemory, eps: float, ratio: float, each: int, factors: int) -> bool:
    """Paths from the best point, each with ``ratio`` times the last ``eps``; whether one ended well enough."""
    limit = min(memory.factors + factors, memory.allowed)
    while eps > 1e-10 and memory.factors < limit:
        take_best(memory)
        if not trace(memory, eps, min(each, limit - memory.factors)):
            return False
        if is_enough(memory):
            return newton(memory, 1e-6, 6) or is_enough(memory)
        eps *= ratio
    return False


@kernel
def start_afresh(memory: LargeMemory) -> bool:
    """The same from no impulses at all, in case those of the last step lead astray: wedged bodies keep any.

    Of the two best points the better one is kept.
    """
    kept, worst = memory.kept, memory.worst
    for k in range(memory.n_units):
        for r in range(2):
            kept[k, r], memory.best[k, r], memory.q[k, r] = memory.best[k, r], 0.0, 0.0
    memory.worst = judge(memory, memory.q)
    if sweep_and_look(memory, SWEEPS, False) or newton(memory, 1e-2, 60) or follow(memory, 1e-3, 0.3, 100, 150):
        return True
    keep_best(memory, kept, worst)
    return False


@kernel
def is_wedged(memory: LargeMemory) -> bool:
    """Whether impulses of the best point cancel that are far larger than what moves: Newton's method then cycles."""
    return bool(term_size(memory, memory.best) > WEDGED * memory.load)


@kernel
def swept_newton(memory: LargeMemory, sweeps: int, eps: float, factors: int) -> bool:
    """Sweeps from the best point, which find states that Newton's method does not, and that one again."""
    take_best(memory)
    return sweep_and_look(memory, sweeps, True) or newton(memory, eps, factors)


@kernel
def find(memory: LargeMemory) -> int:
    """The best point to ``best``; returns the route, or ROOM."""
    worst = judge(memory, memory.q)
    if not worst <= ASTRAY * memory.load:
        memory.q[: memory.n_units] = 0.0
        worst = judge(memory, memory.q)
    keep_best(memory, memory.q, worst)
    if is_exact(memory):
        return AT_ONCE
    if sweep_and_look(memory, SWEEPS, False):
        return SWEPT
    if not make_pattern(memory, memory.factor) or not has_room(memory.factor):
        return ROOM
    bound_factors(memory)
    if newton(memory, 1e-6, 6) and (is_exact(memory) or memory.worst <= 2.0 * memory.usual * memory.load):
        return NEWTON
    if memory.worst > FAR * memory.load:
        take_best(memory)
        convex_start(memory, min(100, memory.allowed - memory.factors))
        if memory.worst <= FOUND * memory.load and newton(memory, 1e-2, 60):
            return CONVEX
    if newton(memory, 1e-2, 60):
        return NEWTON
    if is_wedged(memory) and follow(memory, 1e-5, 0.1, 400, 530):
        return TRACED
    if swept_newton(memory, 20, 0.1, 150) or swept_newton(memory, 20, 1e-3, 100):
        return NEWTON
    if follow(memory, 1e-3, 0.3, 100, 150):
        return TRACED
    if swept_newton(memory, 100, 0.1, 60) or follow(memory, 1e-3, 0.3, 200, 300):
        return LATER
    return AFRESH if start_afresh(memory) else NONE


@kernel
def serve_lagging(memory: LargeMemory) -> bool:
    """Newton's method to rounding, for contacts that are far from the tolerance of their own load; False: lacks room.

    The best point is within the tolerance as a whole, which says nothing of light bodies beside heavy ones.
    """
    if not make_pattern(memory, memory.factor) or not has_room(memory.factor):
        return False
    bound_factors(memory)
    tolerance = memory.tolerance
    for eps in (1e-6, 1e-2):
        memory.tolerance = min(tolerance, SETTLED)
        newton(memory, eps, 60)
        memory.tolerance = tolerance
        conclude(memory)
        if not lags(memory):
            break
    return True


@kernel
def begin(problem: BodyContacts, memory: LargeMemory) -> None:
    """The problem in units; the best point is none yet, and no impulses until there is one that is finite."""
    memory.worst = 1e300
    pack(problem, memory)
    for k in range(memory.n_units):
        memory.best[k, 0], memory.best[k, 1] = 0.0, 0.0


@kernel
def take_impulses(problem: BodyContacts, memory: LargeMemory) -> bool:
    """Take the impulses p as they are for the answer; whether they are within the tolerance."""
    begin(problem, memory)
    keep_best(memory, memory.q, judge(memory, memory.q))
    conclude(memory)
    return is_enough(memory)


@kernel
def solve_large(problem: BodyContacts, memory: LargeMemory) -> int:
    """Solve a large contact problem from the impulses p, which are replaced; SOLVED, ITERATION_LIMIT or ROOM.

    After ROOM nothing is changed but what is wanting in ``memory.factor``.
    """
    memory.factors, memory.sweeps = 0, 0
    memory.usual = memory.strict if memory.tolerance < memory.strict <= USUAL else 0.0
    begin(problem, memory)
    route = find(memory)
    if route == ROOM:
        return ROOM
    memory.route = route
    conclude(memory)
    if lags(memory) and not serve_lagging(memory):
        return ROOM
    unpack(problem, memory, memory.best)
    return SOLVED if is_good(memory) else ITERATION_LIMIT
