"""Who is tried when on a contact problem: one table of attempts, read from the top until the problem is solved.

Every attempt goes on from the best point so far, is judged, and cannot lose it. Rows differ in what they are for: in
the plane there are paths, on which contacts change their states one after the other; where factors are dear, sweeps
are the better use of a budget. What was tried last is ``Search.route``, a place in the table; :func:`route_names` has
its words.
"""

from __future__ import annotations

from dataclasses import astuple, dataclass, fields
from typing import Any, TypeAlias

import numpy as np

from lcpflex.jit.kernel import FloatArray, IntArray, kernel
from lcpflex.jit.struct import allocate, array, struct
from lcpflex.solvers.contact.alart_curnier import alart_curnier
from lcpflex.solvers.contact.algebra import Vector
from lcpflex.solvers.contact.best import NOTHING, Best, copy_forces, forget_best, keep_best
from lcpflex.solvers.contact.group import Group
from lcpflex.solvers.contact.judging import Judged, is_enough, is_exact, is_good, judge, term_size, weigh
from lcpflex.solvers.contact.operators import Operator, factor_work, moves_centre, prepare, sweep_work
from lcpflex.solvers.contact.proximal_newton import LEAST_EPS, NewtonWork, convex_start, proximal_newton
from lcpflex.solvers.contact.sweeping import Sweeping, sweep_on
from lcpflex.solvers.contact.tracing import trace

__all__ = [
    "AFRESH", "ALART_CURNIER", "ALWAYS", "DEAR", "LAST_DIGITS", "MANY_CONTACTS", "NEWTON", "NONE", "POSED_CONTACTS",
    "ROOM", "SETTLED", "SPATIAL_CONTACTS", "SWEEPS", "USER_CONTACTS", "Attempt", "Attempts", "Search", "attempts_for",
    "conclude", "find", "route_names", "search_for", "search_parts", "serve_lagging",
]  # fmt: skip

ROOM = 100  # status: the memory of a factor is to grow first
AT_ONCE, NONE = -1, -2  # routes: as it was; nothing solved it

SWEEPS, NEWTON, CONVEX, PATH, AFRESH, ALART_CURNIER = range(6)  # methods
NAMES = ("sweeps", "Newton", "convex law", "path", "from nothing", "Alart-Curnier")
ALWAYS, CHEAP, DEAR = range(3)  # when: whatever a factor costs, unless or where it takes as long as many sweeps

FACTORS, SWEEPS_LIMIT = 600, 1_000_000  # that one problem may take
LEAST_FACTORS, FEW_FACTORS = 100, 10  # of a budget: for Newton's method and one path; where factors are dear
ASTRAY = 1e3  # residual, relative to the free velocities, from which a start is not worth having
WEDGED = 1e3  # terms, relative to the free velocities, from which bodies are wedged: Newton's method then cycles
LOOK = 10  # sweeps between two looks at the residual
CRAWLING = 0.7  # of the residual left by so many sweeps: too much to go on for its sake
BESIDES = 10.0  # sweeps that take as long as what goes with a factor
MANY_SWEEPS = 40.0  # that take as long as a factor which is dear: from there on they are the better use of a budget
LEAST_PATH = 1e-10  # eps of a path
SETTLED = 1e-14  # of the free velocities: what may be left where nothing creeps


@dataclass(frozen=True)
class Attempt:
    """One row of the table.

    Attributes
    ----------
    method
        SWEEPS, NEWTON, CONVEX (start), PATH, ALART_CURNIER, where an operator has the factors, or AFRESH: what follows
        begins from no forces at all.
    count
        Sweeps, or factors of the sparse matrix, at most.
    eps
        Of the regularised laws, to begin with.
    share
        Of the budget, instead of a count: sweeps that take as long as so many of its factors.
    patient
        Whether sweeps go on though they crawl.
    exact
        Whether the tolerance is to be met beside the free velocities, as it usually is where this row comes first.
    above, below
        Only while the best point misses more, or less, than this part of the free velocities.
    each, ratio
        Of paths: factors of one, and how eps falls from one to the next.
    wedged
        Only where forces cancel that are far larger than what moves.
    rows
        S of the problems that it is for; 0: of all.
    when
        ALWAYS, CHEAP or DEAR, as factors are.
    """

    method: int
    count: int = 0
    eps: float = 0.0
    share: float = 0.0
    patient: bool = True
    exact: bool = False
    above: float = 0.0
    below: float = np.inf
    each: int = 0
    ratio: float = 0.0
    wedged: bool = False
    rows: int = 0
    when: int = CHEAP


Table: TypeAlias = tuple[Attempt, ...]

MANY_CONTACTS = (
    Attempt(SWEEPS, 40, patient=False, when=ALWAYS),
    Attempt(NEWTON, eps=1e-2, share=0.5, below=1e-4, rows=3, when=DEAR),
    Attempt(SWEEPS, share=1.0, rows=3, when=DEAR),
    Attempt(SWEEPS, 40, share=0.5, rows=3),
    Attempt(NEWTON, 6, eps=1e-6, exact=True),
    Attempt(CONVEX, 100, above=0.1),
    Attempt(NEWTON, 100, eps=1e-2, exact=True),
    Attempt(PATH, 530, eps=1e-5, each=400, ratio=0.1, wedged=True, rows=2),
    Attempt(SWEEPS, 20),
    Attempt(NEWTON, 150, eps=0.1, exact=True),
    Attempt(SWEEPS, 20),
    Attempt(NEWTON, 100, eps=1e-3),
    Attempt(PATH, 150, eps=1e-3, each=100, ratio=0.3, rows=2),
    Attempt(SWEEPS, 100),
    Attempt(NEWTON, 60, eps=0.1),
    Attempt(PATH, 300, eps=1e-3, each=200, ratio=0.3, rows=2),
    Attempt(AFRESH),
    Attempt(SWEEPS, 40, patient=False),
    Attempt(NEWTON, 60, eps=1e-2),
    Attempt(PATH, 150, eps=1e-3, each=100, ratio=0.3, rows=2),
)
"""For steppers, in the velocities of bodies."""

_HARD = tuple(
    attempt
    for eps in (1.0, 0.3, 0.1, 0.03, 0.01)
    for attempt in (
        Attempt(SWEEPS, 100),
        Attempt(NEWTON, 400, eps=eps, exact=True),
        Attempt(ALART_CURNIER, 40),
    )
)
_AFRESH = [attempt.method for attempt in MANY_CONTACTS].index(AFRESH)
USER_CONTACTS = MANY_CONTACTS[:_AFRESH] + _HARD + MANY_CONTACTS[_AFRESH:]
"""For solvers of users, who have more time: softer laws, which are nearer to a solution before they are harder."""

SPATIAL_CONTACTS = (
    *(
        attempt
        for sweeps, factors in ((30, 20), (200, 40), (1000, 60))
        for attempt in (Attempt(SWEEPS, sweeps), Attempt(ALART_CURNIER, factors))
    ),
    *USER_CONTACTS,
)
"""For users in space: Alart and Curnier's method first, from better and better points."""

LAST_DIGITS = (Attempt(ALART_CURNIER, 20), *_HARD)
"""From a point within the tolerance by its terms, to one that is so by the velocities."""

POSED_CONTACTS = (Attempt(ALART_CURNIER, 40), *MANY_CONTACTS[1:])
"""For steppers, of problems that are posed with their matrix and that sweeps have not solved."""


@struct
class Attempts:
    """The table for problems of one S; columns as of :class:`Attempt`."""

    n: int
    method: IntArray = array("attempts")
    count: IntArray = array("attempts")
    each: IntArray = array("attempts")
    patient: IntArray = array("attempts")
    exact: IntArray = array("attempts")
    wedged: IntArray = array("attempts")
    when: IntArray = array("attempts")
    rows: IntArray = array("attempts")
    eps: FloatArray = array("attempts")
    share: FloatArray = array("attempts")
    above: FloatArray = array("attempts")
    below: FloatArray = array("attempts")
    ratio: FloatArray = array("attempts")


@struct
class Search:
    """Limits of a search, and how it went."""

    factor_limit: int  # sparse factors at most
    sweep_limit: int  # sweeps at most
    operation_limit: float  # of all factors, in multiplications
    usual: float  # strict residual up to which no better one is sought by all means: that of the problem before
    sweeps: int
    allowed: int  # factors that the limits come to
    route: int  # place in the table of what solved the problem; AT_ONCE, NONE
    sweeping: Sweeping  # how sweeps look, until they are exact
    tried: IntArray = array("attempts")  # 1: attempts made


def attempts_for(rows: int, table: Table = MANY_CONTACTS) -> Attempts:
    """The rows of a table that are for problems of S = ``rows``."""
    chosen = [attempt for attempt in table if attempt.rows in (0, rows)]
    attempts = allocate(Attempts, {"attempts": len(chosen)})
    attempts.n = len(chosen)
    for field, column in zip(fields(Attempt), zip(*map(astuple, chosen), strict=True), strict=True):
        getattr(attempts, field.name)[:] = column
    return attempts


def search_for(attempts: Attempts, operations: float = np.inf) -> Search:
    """The limits of a search by a table; operations: multiplications that all its factors may take."""
    sweeping = allocate(Sweeping, {}, look=LOOK, crawling=CRAWLING, exact=1)
    limits = {"factor_limit": FACTORS, "sweep_limit": SWEEPS_LIMIT, "operation_limit": operations}
    return allocate(Search, {"attempts": int(attempts.n)}, sweeping=sweeping, **limits)


def search_parts(sizes: dict[str, int], table: Table = MANY_CONTACTS, operations: float = np.inf) -> dict[str, Any]:
    """What a search needs beside group and operator, by the names of the fields that memories have for it."""
    parts = {"judged": allocate(Judged, {}), "best": allocate(Best, sizes), "newton": allocate(NewtonWork, sizes)}
    attempts = attempts_for(sizes["rows"], table)
    return {**parts, "attempts": attempts, "search": search_for(attempts, operations)}


def route_names(search: Search, attempts: Attempts) -> str:
    """What was tried, in words: ``sweeps > Newton > sweeps``."""
    if search.route == AT_ONCE:
        return "as it was"
    names = [NAMES[method] for method in attempts.method[search.tried[: attempts.n] == 1]]
    told = [name for i, name in enumerate(names) if i == 0 or name != names[i - 1]]
    return " > ".join([*told, "best point of all"] if search.route == NONE else told)


@kernel
def sweep_from_best(
    op: Operator, group: Group, judged: Judged, best: Best, search: Search, count: int, patient: bool, like: Vector
) -> bool:
    """``count`` sweeps from p, fewer where they crawl and one is not ``patient``; whether ``best`` is exact."""
    sweeping = search.sweeping
    sweeping.iterations = 0
    judge(op, group, judged, group.p, like)
    found = sweep_on(op, group, judged, sweeping, best, like, min(count, search.sweep_limit - search.sweeps), patient)
    search.sweeps += sweeping.iterations
    return found


@kernel
def follow_paths(
    op: Operator, group: Group, judged: Judged, best: Best, work: NewtonWork, search: Search, attempts: Attempts,
    a: int, like: Vector,
) -> bool:  # fmt: skip
    """Paths from the best point, each with a smaller eps; whether one ended well enough."""
    limit, eps = min(work.factors + attempts.count[a], search.allowed), attempts.eps[a]
    while eps > LEAST_PATH and work.factors < limit:
        copy_forces(group, best.p, group.p, like)
        each = min(attempts.each[a], limit - work.factors)
        if not trace(op, group, judged, best, work, eps, each, like):
            return False
        if is_enough(op, group, judged, best, like):
            copy_forces(group, best.p, group.p, like)
            few = min(6, search.allowed - work.factors)
            proximal_newton(op, group, judged, best, work, 1e-6, few, like)
            return True
        eps *= attempts.ratio[a]
    return False


@kernel
def is_dear(op: Operator, group: Group) -> bool:
    """Whether a factor takes as long as many sweeps."""
    return bool(factor_work(op, group) > MANY_SWEEPS * sweep_work(op, group))


@kernel
def bound_factors(op: Operator, group: Group, search: Search) -> None:
    """How many factors the budget is worth: no fewer than for Newton's method, where they are not dear."""
    worth = search.operation_limit / max(factor_work(op, group), 1.0)
    least = FEW_FACTORS if is_dear(op, group) else LEAST_FACTORS
    search.allowed = min(search.factor_limit, max(least, int(min(worth, 1e9))))


@kernel
def is_for(
    op: Operator, group: Group, judged: Judged, best: Best, search: Search, attempts: Attempts, a: int, like: Vector
) -> bool:  # fmt: skip
    """Whether attempt a is for the problem, and for the point at hand."""
    when, load = attempts.when[a], judged.load
    if when != ALWAYS and (when == DEAR) != (is_dear(op, group) or search.allowed < FEW_FACTORS):
        return False
    if not attempts.above[a] * load <= best.worst <= attempts.below[a] * load:
        return False
    if attempts.method[a] == ALART_CURNIER and not moves_centre(op):
        return False
    return attempts.wedged[a] == 0 or term_size(op, group, judged, best.p, like) > WEDGED * load


@kernel
def try_one(
    op: Operator, group: Group, judged: Judged, best: Best, work: NewtonWork, search: Search, attempts: Attempts,
    a: int, like: Vector,
) -> bool:  # fmt: skip
    """Attempt a from the best point; whether that is good enough now."""
    method, count, left = attempts.method[a], attempts.count[a], search.allowed - work.factors
    copy_forces(group, best.p, group.p, like)
    if method == SWEEPS:
        if attempts.share[a] > 0.0:
            most = int(attempts.share[a] * search.allowed)
            share = most if count == 0 else min(most, count)
            count = int(min(share * (factor_work(op, group) / sweep_work(op, group) + BESIDES), 1e6))
            search.allowed -= share
        return sweep_from_best(op, group, judged, best, search, count, attempts.patient[a] == 1, like)
    if method == NEWTON:
        if attempts.share[a] > 0.0:
            count = int(attempts.share[a] * search.allowed)
        enough = proximal_newton(op, group, judged, best, work, attempts.eps[a], min(count, left), like)
        usual = best.worst <= 2.0 * search.usual * judged.load
        return enough and (attempts.exact[a] == 0 or is_exact(judged, best.worst) or usual)
    if method == ALART_CURNIER:
        return alart_curnier(op, group, judged, best, work, min(count, left), like)
    if method == CONVEX:
        convex_start(op, group, judged, best, work, min(count, left), like)
        return False  # Newton's method is to confirm it
    if method == PATH:
        return follow_paths(op, group, judged, best, work, search, attempts, a, like)
    best.kept = best.worst
    copy_forces(group, best.p, best.aside, like)
    forget_best(group, best, like)
    keep_best(group, best, best.p, judge(op, group, judged, best.p, like), like)
    return False


@kernel
def begin_search(op: Operator, group: Group, judged: Judged, best: Best, like: Vector) -> None:
    """Judge the forces p; those that are no start worth having are none."""
    forget_best(group, best, like)
    best.kept = NOTHING
    worst = judge(op, group, judged, group.p, like)
    if not worst <= ASTRAY * judged.load:
        copy_forces(group, best.p, group.p, like)
        worst = judge(op, group, judged, group.p, like)
    keep_best(group, best, group.p, worst, like)


@kernel
def find(
    op: Operator, group: Group, judged: Judged, best: Best, work: NewtonWork, search: Search, attempts: Attempts,
    like: Vector,
) -> bool:  # fmt: skip
    """From the forces p, one attempt after the other, to ``best``; False where a factor lacks room.

    ``search.route`` tells what solved the problem, or that nothing did.
    """
    work.factors, work.convex, work.floor, search.sweeps, search.route = 0, 0, LEAST_EPS, 0, AT_ONCE
    for a in range(attempts.n):
        search.tried[a] = 0
    begin_search(op, group, judged, best, like)
    if is_exact(judged, best.worst):
        return True
    prepared = False
    for a in range(attempts.n):
        if not prepared and attempts.when[a] != ALWAYS:
            if not prepare(op, group):
                return False
            bound_factors(op, group, search)
            prepared = True
        if is_for(op, group, judged, best, search, attempts, a, like):
            search.route, search.tried[a] = a, 1
            if try_one(op, group, judged, best, work, search, attempts, a, like):
                return True
    search.route = NONE
    keep_best(group, best, best.aside, best.kept, like)
    return True


@kernel
def conclude(op: Operator, group: Group, judged: Judged, best: Best, like: Vector) -> None:
    """The sizes of what the best point misses, its velocities made anew."""
    weigh(op, group, judged, best.p, like)
    best.worst = judged.worst


@kernel
def serve_lagging(
    op: Operator, group: Group, judged: Judged, best: Best, work: NewtonWork, search: Search, like: Vector
) -> bool:
    """Newton's method to rounding, for contacts that are far from the tolerance of their own load; False: lacks room.

    The best point is within the tolerance as a whole, which says nothing of light bodies beside heavy ones.
    """
    if not prepare(op, group):
        return False
    bound_factors(op, group, search)
    tolerance, forces = judged.tolerance, moves_centre(op)
    for eps in (1e-6, 1e-2):
        copy_forces(group, best.p, group.p, like)
        left, judged.tolerance = min(60, search.allowed - work.factors), min(tolerance, SETTLED)
        if forces:
            alart_curnier(op, group, judged, best, work, left, like)
        else:
            proximal_newton(op, group, judged, best, work, eps, left, like)
        judged.tolerance = tolerance
        weigh(op, group, judged, group.p, like)
        if is_good(judged):
            best.worst = judged.worst
            copy_forces(group, group.p, best.p, like)
            break
        conclude(op, group, judged, best, like)
        if is_good(judged):
            break
        forces = False
    return True
