"""Proximal Newton in the velocities of bodies: the law regularised about the last forces, which then follow.

    F(x) = x - J^T (q(x) - c) = 0,   (I + J^T C J) dx = -F,   C = -dq/dy        (:mod:`laws`)

The centre c goes to q once F is zero: eps is in the way, not in the limit. The unknown x is the change against the
centre, and what is judged the velocities by q itself. Where slips turn C changes with them; a factor serves as long as
no contact changes its state and F falls well. Sources: Alart & Curnier 1991 (the mapping), Rockafellar 1976 (the
proximal point algorithm), De Saxce & Feng 1998 (the convex law).
"""

from __future__ import annotations

import math

from lcpflex.jit.kernel import kernel
from lcpflex.solvers.contact.cones.large.judging import is_enough, is_exact, judge, keep_best, term_size
from lcpflex.solvers.contact.cones.large.laws import forces_at, linearise, same_states
from lcpflex.solvers.contact.cones.large.memory import FRICTIONAL, LargeCones, SpatialLargeMemory
from lcpflex.solvers.contact.cones.large.packing import take_over
from lcpflex.solvers.contact.large.fronts import factorise, solve

__all__ = ["convex_start", "proximal_newton"]

INNER_LIMIT = 25  # Newton steps for one centre
CONVEX_LIMIT = 60  # of them where the law is convex, and each is one downhill
INNER = 1e-3  # of the residual: what is left of F when the centre moves on
ROUNDING = 2e-16
SHRINK = 0.4  # of a step that does not make F smaller
SHORTEST, SHORTEST_CONVEX = 0.02, 1e-7
WELL = 0.4  # of F left by a step: its factor serves again
POLISH = 12  # factors for a residual that is within the tolerance of the free velocities themselves
LARGEST_EPS = 1e3
CONVEX_EPS, CONVEX_LOOK = 0.1, 1e-3  # to begin with, and where too much slides if that was of no use
FAR = 1e6  # how far forces may be taken on at once


@kernel
def has_factor(memory: LargeCones, eps: float) -> bool:
    """A factor for the states and slips at hand; False where there is none."""
    linearise(memory, eps)
    return factorise(memory, memory.factor)


@kernel
def direction(memory: LargeCones) -> float:
    """``step`` = -H^-1 F; the slope of the cost along it."""
    step, rest, slope = memory.step, memory.rest, 0.0
    for i in range(memory.n_unknowns):
        step[i] = -rest[i]
    solve(memory, memory.factor, step)
    for i in range(memory.n_unknowns):
        slope += rest[i] * step[i]
    return slope


@kernel
def solve_inner(memory: SpatialLargeMemory, eps: float, residual: float, limit: int, fresh: bool) -> int:
    """Newton's method for one centre from x = 0: 1 where F is zero, 0 where it is not, -1 without more factors.

    fresh: nothing is known of the last factor.
    """
    point, x, step, n = memory.point, memory.x, memory.step, memory.n_unknowns
    for i in range(n):
        point[i] = 0.0
    size, largest = forces_at(memory, point, eps, memory.trial, memory.speed), 0.0
    convex, well = memory.convex == 1, not fresh
    for _ in range(CONVEX_LIMIT if convex else INNER_LIMIT):
        if size <= max(INNER * residual, ROUNDING * (largest + (residual + memory.terms) * math.sqrt(n)) / eps):
            return 1
        same = same_states(memory)
        if not (well and same):
            if memory.factors >= limit:
                return -1
            if not has_factor(memory, eps):
                return 0
        cost, slope, length = memory.cost, direction(memory), 1.0
        while True:
            largest = 0.0
            for i in range(n):
                x[i] = point[i] + length * step[i]
                largest += x[i] * x[i]
            largest = math.sqrt(largest)
            now = forces_at(memory, x, eps, memory.trial, memory.speed)
            if now <= (1.0 - 1e-4 * length) * size or (convex and memory.cost <= cost + 1e-4 * length * slope):
                break
            length *= SHRINK
            if length < (SHORTEST_CONVEX if convex else SHORTEST):
                return 0
        for i in range(n):
            point[i] = x[i]
        well = now <= WELL * size
        size = now
    return 0


@kernel
def way_to_edge(f: float, g: float, h: float, d: float, d1: float, d2: float, mu: float) -> float:
    """The least t > 0 at which (f, g, h) + t (d, d1, d2), inside |q_T| <= mu q_N at t = 0, leaves that cone."""
    a = d1 * d1 + d2 * d2 - mu * mu * d * d
    b = g * d1 + h * d2 - mu * mu * f * d
    c = min(g * g + h * h - mu * mu * f * f, 0.0)
    root = b * b - a * c
    if root < 0.0:
        return FAR
    root = math.sqrt(root)
    if b + root > 0.0:  # a t^2 + 2 b t + c = 0, without the difference of two large numbers
        return -c / (b + root)
    return (-b + root) / a if a > 0.0 else FAR


@kernel
def go_on(memory: SpatialLargeMemory, residual: float) -> float:
    """Take q on along its last change, q - c, until a unit changes its state, unless that doubles the residual.

    In a soft direction forces have far to go before a contact opens or slips. Returns the residual.
    """
    q, centre, mu, kind, trial = memory.q, memory.centre, memory.mu, memory.kind, memory.trial
    far = FAR
    for k in range(memory.n_units):
        if kind[k] > FRICTIONAL or not q[k, 0] > 0.0:
            continue
        d, d1, d2 = q[k, 0] - centre[k, 0], q[k, 1] - centre[k, 1], q[k, 2] - centre[k, 2]
        if d < 0.0:
            far = min(far, -q[k, 0] / d)
        bound = mu[k] * q[k, 0]
        if kind[k] == FRICTIONAL and math.sqrt(q[k, 1] ** 2 + q[k, 2] ** 2) < bound * (1.0 - 1e-12):
            far = min(far, way_to_edge(q[k, 0], q[k, 1], q[k, 2], d, d1, d2, mu[k]))
    if far < 1e-3 or far >= FAR:
        return residual
    for k in range(memory.n_units):
        for e in range(3):
            trial[k, e] = q[k, e] + far * (q[k, e] - centre[k, e])
        if kind[k] <= FRICTIONAL:
            trial[k, 0] = max(trial[k, 0], 0.0)
            size, bound = math.sqrt(trial[k, 1] ** 2 + trial[k, 2] ** 2), mu[k] * trial[k, 0]
            if size > bound:
                trial[k, 1] *= bound / size
                trial[k, 2] *= bound / size
    now = judge(memory, trial)
    if now > 2.0 * residual:
        return judge(memory, q)
    take_over(memory, trial, q)
    return now


@kernel
def proximal_newton(memory: SpatialLargeMemory, eps: float, limit: int) -> bool:
    """From q, with a first ``eps`` and up to ``limit`` factors; whether ``best`` is then good enough.

    It goes on for a few factors until the residual is small beside the free velocities, too. eps goes down where few
    factors were needed, and up where F could not be made zero.
    """
    q = memory.q
    limit += memory.factors
    residual = judge(memory, q)
    keep_best(memory, q, residual)
    memory.terms = term_size(memory, q)
    failed, fresh, enough = 0.0, True, is_enough(memory)
    if enough:
        limit = min(limit, memory.factors + POLISH)
    for _ in range(limit - memory.factors):  # centres: one may need no factor
        take_over(memory, q, memory.centre)
        take_over(memory, memory.y, memory.base)
        before = memory.factors
        ended = solve_inner(memory, eps, residual, limit, fresh)
        fresh = True
        if ended == -1:
            break
        if ended == 0:
            failed = eps
            eps *= 10.0
            if eps > LARGEST_EPS:
                break
            continue
        take_over(memory, memory.trial, q)
        now = judge(memory, q)
        keep_best(memory, q, now)
        if is_exact(memory):
            return True
        if not enough and is_enough(memory):
            enough = True
            limit = min(limit, memory.factors + POLISH)
        if now > 0.5 * residual:
            now = go_on(memory, now)
            keep_best(memory, q, now)
        spent = memory.factors - before
        wanted = 0.2 * eps if spent <= 4 else (0.5 * eps if spent <= 8 else eps)
        if failed > 0.0 and wanted < 2.0 * failed:
            wanted = max(wanted, 0.6 * eps)
        wanted = max(wanted, memory.floor)
        if spent == 0 and wanted == eps and now > 0.9 * residual:
            break  # nothing moves any more
        residual = now
        fresh = wanted != eps
        eps = wanted
    return enough


@kernel
def convex_start(memory: SpatialLargeMemory, limit: int) -> bool:
    """As if contacts that slide lifted off at the rate mu |v_T|, less that of the last pass: right where all stick.

    K* is then the cone of velocities, the problem convex, and Newton's method needs no care; up to ``limit`` factors.
    Whether ``best`` is good enough.
    """
    q, base, y = memory.q, memory.base, memory.y
    limit += memory.factors
    residual = judge(memory, q)
    memory.terms = term_size(memory, q)
    eps, found, first = CONVEX_EPS, False, memory.worst
    memory.convex = 1
    while memory.factors < limit and not found:
        take_over(memory, q, memory.centre)
        take_over(memory, y, base)
        for k in range(memory.n_units):
            if memory.kind[k] == FRICTIONAL:
                base[k, 0] += memory.mu[k] * math.hypot(y[k, 1], y[k, 2])
        if solve_inner(memory, eps, residual, limit, found == found) != 1:
            break
        take_over(memory, memory.trial, q)
        residual = judge(memory, q)
        keep_best(memory, q, residual)
        found = is_enough(memory)
        if eps == memory.floor or (eps <= CONVEX_LOOK and memory.worst > 0.3 * first):
            break
        eps = max(0.1 * eps, memory.floor)
    memory.convex = 0
    return found
