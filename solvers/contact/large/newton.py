"""Proximal Newton in the velocities of bodies: Coulomb's law regularised about the last impulses, which then follow.

    y = y_c + J x,   y_c = free + J J^T c
    a = c_N - y_N / eps,  t = c_T - y_T / eps:   open (a <= 0) q = 0;  sticking (|t| <= mu a) q = (a, t);
    sliding q = (a, +-mu a);   joints q = c - y / eps
    F(x) = x - J^T (q(x) - c) = 0,   (I + J^T C J) dx = -F,   C = -dq/dy

The centre c goes to q once F is zero: eps is in the way, not in the limit. The unknown x is the change against the
centre, and y_c what is judged: so eps may be small, and no digits are lost in the difference of large numbers.
Sources: Alart & Curnier 1991 (the mapping), Rockafellar 1976 (the proximal point algorithm).
"""

from __future__ import annotations

import math

from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.solvers.contact.large.fronts import factorise, solve
from lcpflex.solvers.contact.large.judging import is_enough, is_exact, judge, keep_best
from lcpflex.solvers.contact.large.memory import FRICTIONAL, NORMAL, LargeMemory
from lcpflex.solvers.contact.large.packing import add_impulses, velocities

__all__ = ["convex_start", "impulses_in_states", "linearise", "proximal_newton"]

OPEN, STICKING, FORTH, BACK = 0, 1, 2, 3  # state of a unit; joint rows stick
EDGE_FORTH, EDGE_BACK = 4, 5  # on the edge of its cone, under the convex law
JOINT_EPS = 1e-6  # of joint rows at most: they are linear, and nothing cycles
INNER_LIMIT = 20  # Newton steps for one centre
CONVEX_LIMIT = 100  # of them where the law is convex, and each is one downhill
INNER = 1e-3  # of the residual: what is left of F when the centre moves on
ROUNDING = 2e-16
SHRINK = 0.4  # of a step that does not make F smaller
SHORTEST, SHORTEST_CONVEX = 1e-3, 1e-7
POLISH = 12  # factors for a residual that is within the tolerance of the free velocities themselves
LEAST_EPS, LARGEST_EPS = 1e-12, 1e3
CONVEX_EPS, CONVEX_LOOK = 0.1, 1e-3  # to begin with, and where too much slides if that was of no use
FAR = 1e6  # how far impulses may be taken on at once


@kernel
def impulses_at(memory: LargeMemory, x: FloatArray, eps: float, q: FloatArray, y: FloatArray) -> float:
    """q(x), the state of all units, F in ``rest``; returns |F|."""
    velocities(memory, memory.base, x, y)
    kind, mu, centre, state, rest = memory.kind, memory.mu, memory.centre, memory.state, memory.rest
    rho, held, convex = 1.0 / eps, 1.0 / min(eps, JOINT_EPS), memory.convex == 1
    for k in range(memory.n_units):
        if kind[k] > FRICTIONAL:
            q[k, 0], q[k, 1], state[k] = centre[k, 0] - held * y[k, 0], centre[k, 1] - held * y[k, 1], STICKING
            continue
        a, t = centre[k, 0] - rho * y[k, 0], centre[k, 1] - rho * y[k, 1]
        if convex and kind[k] == FRICTIONAL:
            along = (a + mu[k] * abs(t)) / (1.0 + mu[k] * mu[k])
            if abs(t) <= mu[k] * a:
                q[k, 0], q[k, 1], state[k] = a, t, STICKING
            elif along <= 0.0:
                q[k, 0], q[k, 1], state[k] = 0.0, 0.0, OPEN
            else:
                state[k] = EDGE_FORTH if t > 0.0 else EDGE_BACK
                q[k, 0], q[k, 1] = along, (mu[k] if t > 0.0 else -mu[k]) * along
        elif a <= 0.0:
            q[k, 0], q[k, 1], state[k] = 0.0, 0.0, OPEN
        elif kind[k] == NORMAL:
            q[k, 0], q[k, 1], state[k] = a, 0.0, STICKING
        elif abs(t) <= mu[k] * a:
            q[k, 0], q[k, 1], state[k] = a, t, STICKING
        elif t > 0.0:
            q[k, 0], q[k, 1], state[k] = a, mu[k] * a, FORTH
        else:
            q[k, 0], q[k, 1], state[k] = a, -mu[k] * a, BACK
    n = memory.n_unknowns
    for i in range(n):
        rest[i] = x[i]
    change = memory.change
    for k in range(memory.n_units):
        change[k, 0], change[k, 1] = q[k, 0] - centre[k, 0], q[k, 1] - centre[k, 1]
    add_impulses(memory, -1.0, change, rest)
    total = 0.0
    for i in range(n):
        total += rest[i] * rest[i]
    if convex:
        memory.cost = convex_cost(memory, x, eps, q, y)
    return math.sqrt(total)


@kernel
def convex_cost(memory: LargeMemory, x: FloatArray, eps: float, q: FloatArray, y: FloatArray) -> float:
    """What F is the slope of under the convex law: |x|^2 / 2 + sum eps (|q|^2 - |c|^2) / 2 + c . J x."""
    centre, base, cost = memory.centre, memory.base, 0.0
    for i in range(memory.n_unknowns):
        cost += 0.5 * x[i] * x[i]
    for k in range(memory.n_units):
        half = 0.5 * (min(eps, JOINT_EPS) if memory.kind[k] > FRICTIONAL else eps)
        for r in range(2):
            cost += half * (q[k, r] - centre[k, r]) * (q[k, r] + centre[k, r]) + centre[k, r] * (y[k, r] - base[k, r])
    return cost


@kernel
def impulses_in_states(memory: LargeMemory, t: float, x: FloatArray, eps: float) -> float:
    """q(x) of all units as if they stayed in their states, y with (1 - t) lift in ``slip``, F in ``rest``; |F|."""
    velocities(memory, memory.base, x, memory.slip)
    q, y, mu, centre, state = memory.trial, memory.slip, memory.mu, memory.centre, memory.state
    rho, held, change = 1.0 / eps, 1.0 / min(eps, JOINT_EPS), memory.change
    for k in range(memory.n_units):
        y[k, 0] += (1.0 - t) * memory.lift[k, 0]
        y[k, 1] += (1.0 - t) * memory.lift[k, 1]
        own = held if memory.kind[k] > FRICTIONAL else rho
        a, along = centre[k, 0] - own * y[k, 0], centre[k, 1] - own * y[k, 1]
        q[k, 0], q[k, 1] = a, along
        if state[k] == OPEN:
            q[k, 0], q[k, 1] = 0.0, 0.0
        elif state[k] == FORTH:
            q[k, 1] = mu[k] * a
        elif state[k] == BACK:
            q[k, 1] = -mu[k] * a
        elif memory.kind[k] == NORMAL:
            q[k, 1] = 0.0
        change[k, 0], change[k, 1] = q[k, 0] - centre[k, 0], q[k, 1] - centre[k, 1]
    rest = memory.rest
    for i in range(memory.n_unknowns):
        rest[i] = x[i]
    add_impulses(memory, -1.0, change, rest)
    total = 0.0
    for i in range(memory.n_unknowns):
        total += rest[i] * rest[i]
    return math.sqrt(total)


@kernel
def linearise(memory: LargeMemory, eps: float) -> None:
    """C of all units in their states."""
    C, state, mu = memory.C, memory.state, memory.mu
    for k in range(memory.n_units):
        rho = 1.0 / (min(eps, JOINT_EPS) if memory.kind[k] > FRICTIONAL else eps)
        C[k, 0] = 0.0 if state[k] == OPEN else rho
        C[k, 1] = 0.0
        C[k, 2] = 0.0
        C[k, 3] = rho if state[k] == STICKING else 0.0
        if state[k] == FORTH:
            C[k, 2] = mu[k] * rho
        elif state[k] == BACK:
            C[k, 2] = -mu[k] * rho
        elif state[k] >= EDGE_FORTH:
            side = mu[k] if state[k] == EDGE_FORTH else -mu[k]
            part = rho / (1.0 + side * side)
            C[k, 0], C[k, 1], C[k, 2], C[k, 3] = part, side * part, side * part, side * side * part


@kernel
def same_states(memory: LargeMemory) -> bool:
    """Whether all units are in the states of the last factor; they are kept."""
    same = True
    state, factored = memory.state, memory.factored
    for k in range(memory.n_units):
        same = same and state[k] == factored[k]
        factored[k] = state[k]
    return same


@kernel
def solve_inner(memory: LargeMemory, eps: float, residual: float, limit: int, fresh: bool) -> int:
    """Newton's method for one centre from x = 0: 1 where F is zero, 0 where it is not, -1 without more factors.

    fresh: nothing is known of the last factor.
    """
    point, x, step, rest = memory.point, memory.x, memory.step, memory.rest
    n = memory.n_unknowns
    for i in range(n):
        point[i] = 0.0
    size, largest = impulses_at(memory, point, eps, memory.trial, memory.slip), 0.0
    convex = memory.convex == 1
    for _ in range(CONVEX_LIMIT if convex else INNER_LIMIT):
        if size <= max(INNER * residual, ROUNDING * (largest + residual * math.sqrt(n)) / eps):
            return 1
        same = same_states(memory)
        if fresh or not same:
            if memory.factors >= limit:
                return -1
            linearise(memory, eps)
            if not factorise(memory, memory.factor):
                return 0
            fresh = False
        for i in range(n):
            step[i] = -rest[i]
        solve(memory, memory.factor, step)
        cost, slope, length = memory.cost, 0.0, 1.0
        for i in range(n):
            slope += rest[i] * step[i]
        while True:
            largest = 0.0
            for i in range(n):
                x[i] = point[i] + length * step[i]
                largest += x[i] * x[i]
            largest = math.sqrt(largest)
            now = impulses_at(memory, x, eps, memory.trial, memory.slip)
            if now <= (1.0 - 1e-4 * length) * size or (convex and memory.cost <= cost + 1e-4 * length * slope):
                break
            length *= SHRINK
            if length < (SHORTEST_CONVEX if convex else SHORTEST):
                return 0
        for i in range(n):
            point[i] = x[i]
        size = now
    return 0


@kernel
def go_on(memory: LargeMemory, residual: float) -> float:
    """Take q on along its last change, q - c, until a unit changes its state, unless that doubles the residual.

    In a soft direction impulses have far to go before a contact opens or slips. Returns the residual.
    """
    q, centre, mu, kind = memory.q, memory.centre, memory.mu, memory.kind
    far = FAR
    for k in range(memory.n_units):
        if kind[k] > FRICTIONAL:
            continue
        normal, change = q[k, 0], q[k, 0] - centre[k, 0]
        if normal > 0.0 and change < 0.0:
            far = min(far, -normal / change)
        if kind[k] == FRICTIONAL and normal > 0.0:
            more = q[k, 1] - centre[k, 1]
            for sign in (-1.0, 1.0):
                room = mu[k] * normal - sign * q[k, 1]
                rate = sign * more - mu[k] * change
                if rate > 0.0 and room > 1e-12 * mu[k] * normal:
                    far = min(far, room / rate)
    if far < 1e-3 or far >= FAR:
        return residual
    trial = memory.trial
    for k in range(memory.n_units):
        for r in range(2):
            trial[k, r] = q[k, r] + far * (q[k, r] - centre[k, r])
        if kind[k] <= FRICTIONAL:
            trial[k, 0] = max(trial[k, 0], 0.0)
            trial[k, 1] = min(max(trial[k, 1], -mu[k] * trial[k, 0]), mu[k] * trial[k, 0])
    now = judge(memory, trial)
    if now > 2.0 * residual:
        return judge(memory, q)
    for k in range(memory.n_units):
        q[k, 0], q[k, 1] = trial[k, 0], trial[k, 1]
    return now


@kernel
def proximal_newton(memory: LargeMemory, eps: float, limit: int) -> bool:
    """From q, with a first ``eps`` and up to ``limit`` factors; whether ``best`` is then good enough.

    It goes on for a few factors until the residual is small beside the free velocities, too. eps goes down where few
    factors were needed, and up where F could not be made zero.
    """
    q, centre, trial, base = memory.q, memory.centre, memory.trial, memory.base
    limit += memory.factors
    residual = judge(memory, q)
    keep_best(memory, q, residual)
    failed, fresh, enough = 0.0, True, is_enough(memory)
    if enough:
        limit = min(limit, memory.factors + POLISH)
    for _ in range(limit - memory.factors):  # centres: one may need no factor
        for k in range(memory.n_units):
            centre[k, 0], centre[k, 1] = q[k, 0], q[k, 1]
            base[k, 0], base[k, 1] = memory.y[k, 0], memory.y[k, 1]
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
        for k in range(memory.n_units):
            for r in range(2):
                q[k, r] = trial[k, r]
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
        wanted = max(wanted, LEAST_EPS)
        if spent == 0 and wanted == eps and now > 0.9 * residual:
            break  # nothing moves any more
        residual = now
        fresh = wanted != eps
        eps = wanted
    return enough


@kernel
def convex_start(memory: LargeMemory, limit: int) -> bool:
    """As if contacts that slide lifted off at the rate mu |v_T|, less that of the last pass: right where all stick.

    K* is then the cone of velocities, the problem convex, and Newton's method needs no care; up to ``limit`` factors.
    Whether ``best`` is good enough. Source: De Saxce & Feng 1998.
    """
    q, centre, trial, base, y = memory.q, memory.centre, memory.trial, memory.base, memory.y
    limit += memory.factors
    residual = judge(memory, q)
    eps, found, first = CONVEX_EPS, False, memory.worst
    memory.convex = 1
    while memory.factors < limit and not found:
        for k in range(memory.n_units):
            centre[k, 0], centre[k, 1] = q[k, 0], q[k, 1]
            base[k, 0], base[k, 1] = y[k, 0], y[k, 1]
            if memory.kind[k] == FRICTIONAL:
                base[k, 0] += memory.mu[k] * abs(y[k, 1])
        ended = solve_inner(memory, eps, residual, limit, True)
        if ended != 1:
            break
        for k in range(memory.n_units):
            q[k, 0], q[k, 1] = trial[k, 0], trial[k, 1]
        residual = judge(memory, q)
        keep_best(memory, q, residual)
        found = is_enough(memory)
        if eps == LEAST_EPS or (eps <= CONVEX_LOOK and memory.worst > 0.3 * first):
            break
        eps = max(0.1 * eps, LEAST_EPS)
    memory.convex = 0
    return found
