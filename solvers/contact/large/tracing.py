"""From a point that is nearly a solution to one, along a path: contacts change their states one after the other.

Free velocities are changed by ``lift`` so that the point solves the problem of :mod:`newton` exactly, and what was
added is taken away: with t from 0 to 1,

    y = y_c + J x + (1 - t) lift,   F(x, t) = x - J^T (q(y) - c) = 0,   (I + J^T C J) dx = J^T C lift dt.

F is linear until a contact changes its state; there the path goes on, forwards or back, on the side where the contact
is in its new state. This is Lemke's idea, from a start as good as one has. Source: Eaves 1976 (paths of
piecewise linear equations).
"""

from __future__ import annotations

import numpy as np

from lcpflex.jit.kernel import kernel
from lcpflex.solvers.contact.large.fronts import factorise, solve
from lcpflex.solvers.contact.large.judging import judge, keep_best
from lcpflex.solvers.contact.large.memory import FRICTIONAL, NORMAL, LargeMemory
from lcpflex.solvers.contact.large.newton import BACK, FORTH, OPEN, STICKING, impulses_in_states, linearise
from lcpflex.solvers.contact.large.packing import add_impulses, velocities

__all__ = ["trace"]

EDGE = 1e-9  # relative distance to the edge of its cone at which a contact slides
APART = 1e-3  # of the residual: by so much contacts are kept from changing their states together
GOLDEN = 0.6180339887498949
PARALLEL = 1e-13  # of its size: a slower approach to a change of state is none


@kernel
def lift(memory: LargeMemory, residual: float) -> None:
    """States of all units at the centre, and what to add to their velocities for these to fit."""
    centre, base, state, kind, mu = memory.centre, memory.base, memory.state, memory.kind, memory.mu
    added = memory.lift
    for k in range(memory.n_units):
        apart = APART * residual * (1.0 + (k * GOLDEN) % 1.0)
        v, w = base[k, 0], base[k, 1]
        added[k, 0], added[k, 1], state[k] = -v, -w, STICKING
        if kind[k] > FRICTIONAL:
            continue
        if centre[k, 0] <= 0.0:
            centre[k, 0], centre[k, 1], state[k] = 0.0, 0.0, OPEN
            added[k, 0], added[k, 1] = max(v, apart) - v, 0.0
        elif kind[k] == NORMAL:
            added[k, 1] = 0.0
        else:
            bound = mu[k] * centre[k, 0]
            if centre[k, 1] >= bound * (1.0 - EDGE) and w < 0.0:
                centre[k, 1], state[k] = bound, FORTH
                added[k, 1] = min(w, -apart) - w
            elif centre[k, 1] <= -bound * (1.0 - EDGE) and w > 0.0:
                centre[k, 1], state[k] = -bound, BACK
                added[k, 1] = max(w, apart) - w


@kernel
def direction(memory: LargeMemory) -> None:
    """dx/dt to ``step``, and dy/dt to ``slope``."""
    step, added, C, push = memory.step, memory.lift, memory.C, memory.change
    for k in range(memory.n_units):
        push[k, 0] = C[k, 0] * added[k, 0] + C[k, 1] * added[k, 1]
        push[k, 1] = C[k, 2] * added[k, 0] + C[k, 3] * added[k, 1]
    for i in range(memory.n_unknowns):
        step[i] = 0.0
    add_impulses(memory, 1.0, push, step)
    solve(memory, memory.factor, step)
    velocities(memory, added, step, memory.slope)  # added + J dx: less 2 added is dy/dt
    for k in range(memory.n_units):
        memory.slope[k, 0] -= 2.0 * added[k, 0]
        memory.slope[k, 1] -= 2.0 * added[k, 1]


@kernel
def margins(memory: LargeMemory, k: int, which: int, rho: float) -> tuple[float, float]:
    """What must stay positive for unit k to stay in its state, and its rate: 0 the normal, 1 and 2 the edges."""
    centre, slip, slope, state, mu = memory.centre, memory.slip, memory.slope, memory.state[k], memory.mu[k]
    a, da = centre[k, 0] - rho * slip[k, 0], -rho * slope[k, 0]
    if which == 0:
        return (-a, -da) if state == OPEN else (a, da)
    t, dt = centre[k, 1] - rho * slip[k, 1], -rho * slope[k, 1]
    sign = -1.0 if which == 1 else 1.0
    if state == STICKING:
        return mu * a + sign * t, mu * da + sign * dt
    return -mu * a - sign * t, -mu * da - sign * dt  # sliding: beyond its edge


@kernel
def first_change(memory: LargeMemory, rho: float, sense: float, last: int) -> tuple[float, int, int]:
    """How far until a unit changes its state, which unit, and how; inf, -1, 0 if none does."""
    far, unit, how = np.inf, -1, 0
    kind, state = memory.kind, memory.state
    for k in range(memory.n_units):
        if kind[k] > FRICTIONAL:
            continue
        for which in range(3):
            if which > 0 and (kind[k] == NORMAL or state[k] == OPEN):
                break
            if (which == 1 and state[k] == BACK) or (which == 2 and state[k] == FORTH):
                continue
            margin, rate = margins(memory, k, which, rho)
            rate *= sense
            if rate < 0.0 and 3 * k + which != last:
                reach = max(margin, 0.0) / -rate
                if reach < far:
                    far, unit, how = reach, k, which
    return far, unit, how


@kernel
def change_state(memory: LargeMemory, k: int, which: int, rho: float) -> int:
    """Put unit k in its new state; returns which of its margins is now zero."""
    state, kind = memory.state, memory.kind
    if which == 0:
        if state[k] != OPEN:
            state[k] = OPEN
        elif kind[k] == NORMAL:
            state[k] = STICKING
        else:
            state[k] = FORTH if memory.centre[k, 1] - rho * memory.slip[k, 1] > 0.0 else BACK
        return 0
    if state[k] == STICKING:
        state[k] = FORTH if which == 1 else BACK
    else:
        state[k] = STICKING
    return which


@kernel
def trace(memory: LargeMemory, eps: float, limit: int) -> bool:
    """Follow the path from q, with up to ``limit`` factors; whether its end was reached. The end goes to q."""
    q, point, step, rest = memory.q, memory.point, memory.step, memory.rest
    n, rho = memory.n_unknowns, 1.0 / eps
    residual = judge(memory, q)
    for k in range(memory.n_units):
        for r in range(2):
            memory.centre[k, r], memory.base[k, r] = q[k, r], memory.y[k, r]
    lift(memory, residual)
    for i in range(n):
        point[i] = 0.0
    t, sense, last, unit = 0.0, 1.0, -1, -1
    limit += memory.factors
    while memory.factors < limit:
        linearise(memory, eps)
        if not factorise(memory, memory.factor):
            return False
        for _ in range(2):  # what was lost on the way
            size = impulses_in_states(memory, t, point, eps)
            if size <= 1e-9 * residual:
                break
            for i in range(n):
                step[i] = -rest[i]
            solve(memory, memory.factor, step)
            for i in range(n):
                point[i] += step[i]
        size = impulses_in_states(memory, t, point, eps)
        direction(memory)
        if unit >= 0:
            _, rate = margins(memory, unit, last % 3, rho)
            if rate * sense < 0.0:
                sense = -sense
        far, unit, which = first_change(memory, rho, sense, last)
        if sense > 0.0 and far >= 1.0 - t:
            far, unit = 1.0 - t, -1
        if not far < np.inf:
            return False
        for i in range(n):
            point[i] += far * sense * step[i]
        t += far * sense
        if unit < 0:
            impulses_in_states(memory, 1.0, point, eps)
            for k in range(memory.n_units):
                q[k, 0], q[k, 1] = memory.trial[k, 0], memory.trial[k, 1]
                if memory.kind[k] <= FRICTIONAL:
                    q[k, 0] = max(q[k, 0], 0.0)
                    bound = memory.mu[k] * q[k, 0]
                    q[k, 1] = min(max(q[k, 1], -bound), bound)
            keep_best(memory, q, judge(memory, q))
            return True
        if not abs(t) < 10.0:
            return False
        impulses_in_states(memory, t, point, eps)
        last = 3 * unit + change_state(memory, unit, which, rho)
    return False
