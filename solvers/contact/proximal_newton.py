"""The proximal Newton method: laws regularised about the last forces c, which then follow.

    y = base + effect of x,   a = c - y / eps,   q = answer of the law to a      (:mod:`lcpflex.solvers.contact.laws`)
    F(x) = x - what q - c comes to = 0,   J dx = -F,   J of C = -dq/dy

The centre c goes to q once F is zero: eps is in the way, not in the limit. The unknown x is the change against the
centre, and what is judged the velocities by q itself: so eps may be small, and no digits are lost in the difference of
large numbers. Where slips turn C changes with them; a factor serves as long as no unit changes its state and F falls
well. Sources: Alart & Curnier 1991 (the mapping), Rockafellar 1976 (the proximal point algorithm), De Saxce & Feng 1998
(the convex law).
"""

from __future__ import annotations

import math

import numpy as np

from lcpflex.jit.kernel import FloatArray, IntArray, kernel
from lcpflex.jit.struct import array, struct
from lcpflex.solvers.contact.algebra import Vector, along, dot, less, lifted, put, taken
from lcpflex.solvers.contact.best import Best, copy_forces, keep_best
from lcpflex.solvers.contact.group import Group
from lcpflex.solvers.contact.judging import Judged, is_enough, is_exact, judge, term_size
from lcpflex.solvers.contact.laws import COULOMB, answer, derivative, room, soft
from lcpflex.solvers.contact.operators import Operator, add_effect, defect, factorise, norm, product, solve, unknowns

__all__ = ["LEAST_EPS", "NewtonWork", "answers_at", "convex_start", "linearise", "proximal_newton"]

INNER_LIMIT = 25  # Newton steps for one centre
CONVEX_LIMIT = 100  # of them where the law is convex, and each is one downhill
INNER = 1e-3  # of the residual: what is left of F when the centre moves on
ROUNDING = 2e-16
SHRINK = 0.4  # of a step that does not make F smaller
SHORTEST, SHORTEST_CONVEX = 0.02, 1e-7
WELL = 0.4  # of F left by a step: its factor serves again
POLISH = 12  # factors for a residual that is within the tolerance of the free velocities themselves
LEAST_EPS, LARGEST_EPS = 1e-12, 1e3
CONVEX_EPS, CONVEX_LOOK = 0.1, 1e-3  # to begin with, and where too much slides if that was of no use
SHORT, FAR = 1e-3, 1e6  # how far forces are taken on at once, at least and at most


@struct
class NewtonWork:
    """What is known of a search by Newton's method, and room to work in. Sizes: units, rows, block, unknowns."""

    factors: int  # made so far
    floor: float  # eps goes no lower
    convex: int  # 1: forces follow the convex law, see convex_start
    cost: float  # what F is the slope of under it
    terms: float  # size of what cancels in velocities
    centre: FloatArray = array("units", "rows")
    base: FloatArray = array("units", "rows")
    change: FloatArray = array("units", "rows")  # of the forces against the centre
    speed: FloatArray = array("units", "rows")
    trial: FloatArray = array("units", "rows")  # forces
    state: IntArray = array("units")
    factored: IntArray = array("units")  # states of the last factor
    C: FloatArray = array("units", "block")
    rest: FloatArray = array("unknowns")  # F
    step: FloatArray = array("unknowns")
    point: FloatArray = array("unknowns")
    x: FloatArray = array("unknowns")
    lift: FloatArray = array("units", "rows")  # of paths: what is added to the velocities, and how these go on
    slope: FloatArray = array("units", "rows")


@kernel(inline=True)
def stiffness(group: Group, k: int, eps: float) -> float:
    """rho of unit k: 1 / eps in its own unit."""
    return float(group.unit[k] * group.unit[k] / soft(group.law[k], eps))


@kernel
def answers_at(op: Operator, group: Group, work: NewtonWork, x: FloatArray, eps: float, like: Vector) -> float:
    """Forces ``trial`` and velocities ``speed`` at x, the state of all units, F in ``rest``; the size of F."""
    centre, convex, cost = work.centre, work.convex == 1, 0.0
    add_effect(op, group, x, work.base, work.speed, like)
    for k in range(group.n):
        rho = stiffness(group, k, eps)
        c, y = taken(centre, k, like), taken(work.speed, k, like)
        q, state = answer(group, k, along(c, -rho, y), convex)
        d = less(q, c)
        put(work.trial, k, q)
        put(work.change, k, d)
        work.state[k] = state
        if convex:
            cost += 0.5 / rho * dot(d, along(q, 1.0, c)) + dot(c, less(y, taken(work.base, k, like)))
    if convex:
        work.cost = cost + 0.5 * product(op, group, x, x, like)
    return defect(op, group, x, work.change, work.rest, like)


@kernel
def linearise(group: Group, work: NewtonWork, eps: float, like: Vector) -> None:
    """C = -dq/dy of all units in their states, at the velocities ``speed``."""
    for k in range(group.n):
        rho = stiffness(group, k, eps)
        a = along(taken(work.centre, k, like), -rho, taken(work.speed, k, like))
        derivative(group, k, a, work.state[k], rho, work.C)


@kernel
def same_states(group: Group, work: NewtonWork) -> bool:
    """Whether all units are in the states of the last factor, which has then aged by turned slips alone; now kept."""
    same = True
    for k in range(group.n):
        same = same and work.state[k] == work.factored[k]
        work.factored[k] = work.state[k]
    return same


@kernel
def direction(op: Operator, group: Group, work: NewtonWork, n: int, like: Vector) -> float:
    """``step`` = -J^-1 F; the slope of the cost along it, where laws are convex."""
    step, rest = work.step, work.rest
    for i in range(n):
        step[i] = -rest[i]
    solve(op, group, step)
    return product(op, group, rest, step, like) if work.convex == 1 else 0.0


@kernel
def advance(point: FloatArray, length: float, step: FloatArray, x: FloatArray, n: int) -> None:
    """x = point + length step, which may be the point itself."""
    for i in range(n):
        x[i] = point[i] + length * step[i]


@kernel
def clear(point: FloatArray, n: int) -> None:
    """The point x = 0."""
    for i in range(n):
        point[i] = 0.0


@kernel
def solve_inner(
    op: Operator, group: Group, work: NewtonWork, eps: float, residual: float, limit: int, fresh: bool, like: Vector
) -> int:
    """Newton's method for one centre from x = 0: 1 where F is zero, 0 where it is not, -1 without more factors.

    fresh: nothing is known of the last factor.
    """
    point, x, step, n = work.point, work.x, work.step, unknowns(op, group)
    clear(point, n)
    size, largest = answers_at(op, group, work, point, eps, like), 0.0
    convex, well = work.convex == 1, True
    for _ in range(CONVEX_LIMIT if convex else INNER_LIMIT):
        if size <= max(INNER * residual, ROUNDING * (largest + (residual + work.terms) * math.sqrt(n)) / eps):
            return 1
        same = same_states(group, work)
        if fresh or not (same and (well or len(like) == 2)):  # in the plane no slip turns within a state
            fresh = False
            if work.factors >= limit:
                return -1
            linearise(group, work, eps, like)
            work.factors += 1
            if not factorise(op, group, work.C, like):
                return 0
        cost, slope, length = work.cost, direction(op, group, work, n, like), 1.0
        while True:
            advance(point, length, step, x, n)
            largest = norm(op, group, x)
            now = answers_at(op, group, work, x, eps, like)
            if now <= (1.0 - 1e-4 * length) * size or (convex and work.cost <= cost + 1e-4 * length * slope):
                break
            length *= SHRINK
            if length < (SHORTEST_CONVEX if convex else SHORTEST):
                return 0
        advance(point, length, step, point, n)
        well = now <= WELL * size
        size = now
    return 0


@kernel
def go_on(
    op: Operator, group: Group, judged: Judged, work: NewtonWork, residual: float, like: Vector
) -> float:  # fmt: skip
    """Take the forces on along their last change until a unit changes its state, unless that doubles the residual.

    In a soft direction forces have far to go before a contact opens or slips. Returns the residual.
    """
    p, centre, trial, far = group.p, work.centre, work.trial, np.inf
    for k in range(group.n):
        q = taken(p, k, like)
        far = min(far, room(group, k, q, less(q, taken(centre, k, like))))
    if not SHORT <= far < FAR:
        return residual
    for k in range(group.n):
        q = taken(p, k, like)
        ahead, _ = answer(group, k, along(q, far, less(q, taken(centre, k, like))), False)  # the law as it is
        put(trial, k, ahead)
    now = judge(op, group, judged, trial, like)
    if now > 2.0 * residual:
        return judge(op, group, judged, p, like)
    copy_forces(group, trial, p, like)
    return now


@kernel
def next_eps(eps: float, spent: int, failed: float, floor: float) -> float:
    """Down where few factors were ``spent``, more slowly near the one that ``failed``."""
    wanted = 0.2 * eps if spent <= 4 else (0.5 * eps if spent <= 8 else eps)
    if failed > 0.0 and wanted < 2.0 * failed:
        wanted = max(wanted, 0.6 * eps)
    return max(wanted, floor)


@kernel
def proximal_newton(
    op: Operator, group: Group, judged: Judged, best: Best, work: NewtonWork, eps: float, count: int, like: Vector
) -> bool:
    """From the forces p, with a first ``eps`` and up to ``count`` factors; whether ``best`` is then good enough.

    It goes on for a few factors until the residual is small beside the free velocities, too. eps goes down where few
    factors were needed, and up where F could not be made zero.
    """
    p, limit = group.p, work.factors + count
    residual = judge(op, group, judged, p, like)
    keep_best(group, best, p, residual, like)
    work.terms = term_size(op, group, judged, p, like)
    failed, fresh, enough = 0.0, True, is_enough(op, group, judged, best, like)
    if enough:
        limit = min(limit, work.factors + POLISH)
    for _ in range(count):  # centres: one may need no factor
        copy_forces(group, p, work.centre, like)
        copy_forces(group, group.y, work.base, like)
        before = work.factors
        ended = solve_inner(op, group, work, eps, residual, limit, fresh, like)
        fresh = True
        if ended == -1:
            break
        if ended == 0:
            failed = eps
            eps *= 10.0
            if eps > LARGEST_EPS:
                break
            continue
        copy_forces(group, work.trial, p, like)
        now = judge(op, group, judged, p, like)
        keep_best(group, best, p, now, like)
        if is_exact(judged, best.worst):
            return True
        if not enough and is_enough(op, group, judged, best, like):
            enough = True
            limit = min(limit, work.factors + POLISH)
        if now > 0.5 * residual:
            now = go_on(op, group, judged, work, now, like)
            keep_best(group, best, p, now, like)
        spent = work.factors - before
        wanted = next_eps(eps, spent, failed, work.floor)
        if spent == 0 and wanted == eps and now > 0.9 * residual:
            break  # nothing moves any more
        residual, fresh, eps = now, wanted != eps, wanted
    return enough


@kernel
def convex_start(
    op: Operator, group: Group, judged: Judged, best: Best, work: NewtonWork, count: int, like: Vector
) -> bool:  # fmt: skip
    """As if contacts that slide lifted off at the rate mu |v_T|, less that of the last pass: right where all stick.

    The problem is then convex, and Newton's method needs no care; up to ``count`` factors. Whether ``best`` is good
    enough.
    """
    p, base, limit = group.p, work.base, work.factors + count
    residual = judge(op, group, judged, p, like)
    work.terms = term_size(op, group, judged, p, like)
    eps, found, first = CONVEX_EPS, False, best.worst
    work.convex = 1
    while work.factors < limit and not found:
        copy_forces(group, p, work.centre, like)
        for k in range(group.n):
            y = taken(group.y, k, like)
            put(base, k, lifted(y, group.mu[k]) if group.law[k] == COULOMB else y)
        if solve_inner(op, group, work, eps, residual, limit, True, like) != 1:
            break
        copy_forces(group, work.trial, p, like)
        residual = judge(op, group, judged, p, like)
        keep_best(group, best, p, residual, like)
        found = is_enough(op, group, judged, best, like)
        if eps == work.floor or (eps <= CONVEX_LOOK and best.worst > 0.3 * first):
            break
        eps = max(0.1 * eps, work.floor)
    work.convex = 0
    return found
