"""From a point that is nearly a solution to one, along a path: contacts change their states one after the other.

In the plane, where answers are linear in each state. Free velocities are changed by ``lift`` so that the point solves
the problem of :mod:`.proximal_newton` exactly, and what was added is taken away: with t from 0 to 1,

    y = base + effect of x + (1 - t) lift,   F(x, t) = x - what q(y) - c comes to = 0,   J dx/dt = what C lift comes to

F is linear until a contact changes its state; there the path goes on, forwards or back, on the side where the contact
is in its new state. This is Lemke's idea, from a start as good as one has. Source: Eaves 1976 (paths of
piecewise linear equations).
"""

from __future__ import annotations

import numpy as np

from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.jit.leaf import leaf
from lcpflex.solvers.contact.algebra import Vector
from lcpflex.solvers.contact.best import Best, copy_forces, keep_best
from lcpflex.solvers.contact.group import Group
from lcpflex.solvers.contact.judging import Judged, judge
from lcpflex.solvers.contact.laws import BILATERAL, COULOMB, HALF_LINE, answer, soft
from lcpflex.solvers.contact.laws.states import BACK, FORTH, OPEN, STICKING
from lcpflex.solvers.contact.operators import Operator, add_effect, defect, factorise, solve, unknowns
from lcpflex.solvers.contact.proximal_newton import NewtonWork, linearise

__all__ = ["trace"]

EDGE = 1e-9  # relative distance to the edge of its cone at which a contact slides
APART = 1e-3  # of the residual: by so much contacts are kept from changing their states together
GOLDEN = 0.6180339887498949
LOST = 1e-9  # of the residual: what the corrections on the way may leave of F
BACKWARDS = 10.0  # t so far from 0 that the path does not come back


@leaf
def trace(
    op: Operator, group: Group, judged: Judged, best: Best, work: NewtonWork, eps: float, count: int, like: Vector
) -> bool:
    """Follow the path from the forces p, with up to ``count`` factors; whether its end was reached. It goes to p."""
    raise NotImplementedError


@trace.of(3)
@kernel
def no_path(
    op: Operator, group: Group, judged: Judged, best: Best, work: NewtonWork, eps: float, count: int, like: Vector
) -> bool:
    """In space answers are not linear in a state."""
    return False


@kernel
def has_path(group: Group) -> bool:
    """Whether all laws are those whose margins are known here: paths are of Coulomb's, of a half line and of joints."""
    for k in range(group.n):
        law = group.law[k]
        if law != COULOMB and law != BILATERAL and not (law == HALF_LINE and group.floor[k] == 0.0):
            return False
    return True


@kernel
def lift(group: Group, work: NewtonWork, residual: float) -> None:
    """States of all units at the centre, and what to add to their velocities for these to fit."""
    centre, base, state, law, mu, added = work.centre, work.base, work.state, group.law, group.mu, work.lift
    for k in range(group.n):
        apart = APART * residual * (1.0 + (k * GOLDEN) % 1.0)
        v, w = base[k, 0], base[k, 1]
        added[k, 0], added[k, 1], state[k] = -v, -w, STICKING
        if law[k] == BILATERAL:
            continue
        if centre[k, 0] <= 0.0:
            centre[k, 0], centre[k, 1], state[k] = 0.0, 0.0, OPEN
            added[k, 0], added[k, 1] = max(v, apart) - v, 0.0
        elif law[k] == HALF_LINE:
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
def forces_in_states(
    op: Operator, group: Group, work: NewtonWork, t: float, x: FloatArray, eps: float, like: Vector
) -> float:  # fmt: skip
    """Forces ``trial`` at x as if units stayed in their states, ``speed`` with (1 - t) lift, F in ``rest``; |F|."""
    q, y, centre, state, mu = work.trial, work.speed, work.centre, work.state, group.mu
    add_effect(op, group, x, work.base, y, like)
    for k in range(group.n):
        rho = 1.0 / soft(group.law[k], eps)
        y[k, 0] += (1.0 - t) * work.lift[k, 0]
        y[k, 1] += (1.0 - t) * work.lift[k, 1]
        a, along = centre[k, 0] - rho * y[k, 0], centre[k, 1] - rho * y[k, 1]
        q[k, 0], q[k, 1] = a, along
        if state[k] == OPEN:
            q[k, 0], q[k, 1] = 0.0, 0.0
        elif state[k] == FORTH:
            q[k, 1] = mu[k] * a
        elif state[k] == BACK:
            q[k, 1] = -mu[k] * a
        elif group.law[k] == HALF_LINE:
            q[k, 1] = 0.0
        work.change[k, 0], work.change[k, 1] = q[k, 0] - centre[k, 0], q[k, 1] - centre[k, 1]
    return defect(op, group, x, work.change, work.rest, like)


@kernel
def direction(op: Operator, group: Group, work: NewtonWork, like: Vector) -> None:
    """dx/dt to ``step``, and dy/dt to ``slope``."""
    added, C, push = work.lift, work.C, work.change
    for k in range(group.n):
        push[k, 0] = -(C[k, 0] * added[k, 0] + C[k, 1] * added[k, 1])
        push[k, 1] = -(C[k, 2] * added[k, 0] + C[k, 3] * added[k, 1])
    for i in range(unknowns(op, group)):
        work.x[i] = 0.0
    defect(op, group, work.x, push, work.step, like)
    solve(op, group, work.step)
    add_effect(op, group, work.step, added, work.slope, like)  # lift and what dx does: less 2 lift is dy/dt
    for k in range(group.n):
        work.slope[k, 0] -= 2.0 * added[k, 0]
        work.slope[k, 1] -= 2.0 * added[k, 1]


@kernel
def margins(group: Group, work: NewtonWork, k: int, which: int, rho: float) -> tuple[float, float]:
    """What must stay positive for unit k to stay in its state, and its rate: 0 the normal, 1 and 2 the edges."""
    centre, slip, slope, state, mu = work.centre, work.speed, work.slope, work.state[k], group.mu[k]
    a, da = centre[k, 0] - rho * slip[k, 0], -rho * slope[k, 0]
    if which == 0:
        return (-a, -da) if state == OPEN else (a, da)
    t, dt = centre[k, 1] - rho * slip[k, 1], -rho * slope[k, 1]
    sign = -1.0 if which == 1 else 1.0
    if state == STICKING:
        return mu * a + sign * t, mu * da + sign * dt
    return -mu * a - sign * t, -mu * da - sign * dt  # sliding: beyond its edge


@kernel
def first_change(group: Group, work: NewtonWork, rho: float, sense: float, last: int) -> tuple[float, int, int]:
    """How far until a unit changes its state, which unit, and how; inf, -1, 0 if none does."""
    far, unit, how = np.inf, -1, 0
    law, state = group.law, work.state
    for k in range(group.n):
        if law[k] == BILATERAL:
            continue
        for which in range(3):
            if which > 0 and (law[k] != COULOMB or state[k] == OPEN):
                break
            if (which == 1 and state[k] == BACK) or (which == 2 and state[k] == FORTH):
                continue
            margin, rate = margins(group, work, k, which, rho)
            rate *= sense
            if rate < 0.0 and 3 * k + which != last:
                reach = max(margin, 0.0) / -rate
                if reach < far:
                    far, unit, how = reach, k, which
    return far, unit, how


@kernel
def change_state(group: Group, work: NewtonWork, k: int, which: int, rho: float) -> int:
    """Put unit k in its new state; returns which of its margins is now zero."""
    state = work.state
    if which == 0:
        if state[k] != OPEN:
            state[k] = OPEN
        elif group.law[k] == HALF_LINE:
            state[k] = STICKING
        else:
            state[k] = FORTH if work.centre[k, 1] - rho * work.speed[k, 1] > 0.0 else BACK
        return 0
    if state[k] == STICKING:
        state[k] = FORTH if which == 1 else BACK
    else:
        state[k] = STICKING
    return which


@kernel
def correct(op: Operator, group: Group, work: NewtonWork, t: float, eps: float, goal: float, like: Vector) -> None:
    """Take out of ``point`` what was lost on the way, twice at most."""
    for _ in range(2):
        if forces_in_states(op, group, work, t, work.point, eps, like) <= goal:
            return
        for i in range(unknowns(op, group)):
            work.step[i] = -work.rest[i]
        solve(op, group, work.step)
        for i in range(unknowns(op, group)):
            work.point[i] += work.step[i]
    forces_in_states(op, group, work, t, work.point, eps, like)


@trace.of(2)
@kernel
def trace_in_plane(
    op: Operator, group: Group, judged: Judged, best: Best, work: NewtonWork, eps: float, count: int, like: Vector
) -> bool:
    """One factor for each change of a state."""
    if not has_path(group):
        return False
    p, point, n, rho = group.p, work.point, unknowns(op, group), 1.0 / eps  # units are scaled in the plane
    residual = judge(op, group, judged, p, like)
    copy_forces(group, p, work.centre, like)
    copy_forces(group, group.y, work.base, like)
    lift(group, work, residual)
    for i in range(n):
        point[i] = 0.0
    t, sense, last, unit, limit = 0.0, 1.0, -1, -1, work.factors + count
    while work.factors < limit:
        linearise(group, work, eps, like)
        work.factors += 1
        if not factorise(op, group, work.C, like):
            return False
        correct(op, group, work, t, eps, LOST * residual, like)
        direction(op, group, work, like)
        if unit >= 0:
            _, rate = margins(group, work, unit, last % 3, rho)
            if rate * sense < 0.0:
                sense = -sense
        far, unit, which = first_change(group, work, rho, sense, last)
        if sense > 0.0 and far >= 1.0 - t:
            far, unit = 1.0 - t, -1
        if not far < np.inf:
            return False
        for i in range(n):
            point[i] += far * sense * work.step[i]
        t += far * sense
        if unit < 0:
            end_path(op, group, judged, best, work, eps, like)
            return True
        if not abs(t) < BACKWARDS:
            return False
        forces_in_states(op, group, work, t, point, eps, like)
        last = 3 * unit + change_state(group, work, unit, which, rho)
    return False


@kernel
def end_path(
    op: Operator, group: Group, judged: Judged, best: Best, work: NewtonWork, eps: float, like: Vector
) -> None:  # fmt: skip
    """The forces at the end of the path, as the laws allow them, to p; kept where they are the best so far."""
    p = group.p
    forces_in_states(op, group, work, 1.0, work.point, eps, like)
    for k in range(group.n):
        allowed, _ = answer(group, k, (work.trial[k, 0], work.trial[k, 1]), False)
        p[k, 0], p[k, 1] = allowed
    keep_best(group, best, p, judge(op, group, judged, p, like), like)
