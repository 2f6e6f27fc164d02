"""Of all impulses with the same effect the least, without null vectors: what redundant contacts carry is then told.

    min |p|^2 / 2   with   J^T p = J^T p_0,   p in K

where K holds what each contact may do in the motion found: nothing where it opens, p_T = -+mu p_N where it slides, its
cone where it sticks. With multipliers z of the effect, p = P_K(J z) is the nearest point of K, and

    F(z) = J^T (P_K(J z) - p_0) + delta (z - z_last) = 0

is solved by Newton's method with the sparse factor of :mod:`lcpflex.solvers.contact.operators.fronts` (the proximal
point algorithm of the dual problem). Joint rows cost next to nothing: least are the impulses of contacts. As
:mod:`lcpflex.solvers.contact.least_forces`, in memory linear in contacts, in the plane. Source: Qi & Sun 2006 (Newton's
method for best approximation).
"""

from __future__ import annotations

from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.solvers.contact.algebra import PLANAR
from lcpflex.solvers.contact.best import copy_forces
from lcpflex.solvers.contact.judging import judge
from lcpflex.solvers.contact.large.memory import BodyContacts, LargeMemory
from lcpflex.solvers.contact.large.solving import ROOM, unpack
from lcpflex.solvers.contact.laws import BILATERAL, COULOMB, HALF_LINE
from lcpflex.solvers.contact.laws.states import BACK, FORTH, OPEN, STICKING
from lcpflex.solvers.contact.operators import add_effect, defect, product
from lcpflex.solvers.contact.operators.fronts import factorise, has_room, solve
from lcpflex.solvers.contact.operators.ordering import make_pattern
from lcpflex.solvers.status import ITERATION_LIMIT, SOLVED

__all__ = ["least_impulses"]

SLIPS = 10.0  # times the residual: a faster contact slides or opens
CENTRES, STEPS = 12, 30  # at most
SHORTEST = 1e-4  # part of a Newton step
FIRST, LEAST = 1e-3, 1e-8  # delta, relative to the mean of J J^T
FREE = 1e3  # how much cheaper an impulse of a joint is than one of a contact
CLOSE = 1e-10  # of the effect: what is left of F


@kernel
def read_states(memory: LargeMemory, residual: float) -> None:
    """What each unit does: OPEN, STICKING, or the sense of its friction, from ``best`` and its velocities ``y``."""
    group, p, y, state = memory.group, memory.best.p, memory.group.y, memory.newton.state
    still = SLIPS * max(residual, 1e-10 * memory.judged.load)
    for k in range(group.n):
        state[k] = STICKING
        if group.law[k] != BILATERAL and p[k, 0] <= 0.0 and y[k, 0] > still:
            state[k] = OPEN
        elif group.law[k] == COULOMB and abs(y[k, 1]) > still:
            state[k] = BACK if y[k, 1] > 0.0 else FORTH


@kernel
def nearest(memory: LargeMemory, k: int, normal: float, tangent: float) -> tuple[float, float, float, float, float]:
    """P_K of an impulse of contact k, and its derivative: NN, NT = TN, TT."""
    mu, state = memory.group.mu[k], memory.newton.state[k]
    if state == OPEN:
        return 0.0, 0.0, 0.0, 0.0, 0.0
    if memory.group.law[k] == HALF_LINE:
        return (normal, 0.0, 1.0, 0.0, 0.0) if normal > 0.0 else (0.0, 0.0, 0.0, 0.0, 0.0)
    sign = 1.0 if tangent > 0.0 else -1.0
    if state == STICKING:
        if abs(tangent) <= mu * normal:
            return normal, tangent, 1.0, 0.0, 1.0
    else:
        sign = 1.0 if state == FORTH else -1.0
    along = (normal + sign * mu * tangent) / (1.0 + mu * mu)
    if along <= 0.0:
        return 0.0, 0.0, 0.0, 0.0, 0.0
    part = 1.0 / (1.0 + mu * mu)
    return along, sign * mu * along, part, sign * mu * part, mu * mu * part


@kernel
def impulses_of(memory: LargeMemory, z: FloatArray, last: FloatArray, delta: float, free: float) -> tuple[float, float]:
    """q(z) to ``trial``, its derivative over delta to ``C``, F over delta to ``rest``; |F|, and what F is the slope of.

    The latter is convex: |P_K(J z)|^2 / 2 - p_0 . J z + delta |z - z_last|^2 / 2.
    """
    op, group, work, best, scale = memory.op, memory.group, memory.newton, memory.best.p, memory.scale
    y, q, C, change, cost = work.speed, work.trial, work.C, work.change, 0.0
    add_effect(op, group, z, work.slope, y, PLANAR)
    for k in range(group.n):
        d = scale[k]
        weight = 1.0 / (d * d * delta)
        if group.law[k] == BILATERAL:
            q[k, 0], q[k, 1] = best[k, 0] + free * y[k, 0], best[k, 1] + free * y[k, 1]
            C[k, 0], C[k, 1], C[k, 2], C[k, 3] = free / delta, 0.0, 0.0, free / delta
            cost += 0.5 * free * (y[k, 0] * y[k, 0] + y[k, 1] * y[k, 1])
        else:
            normal, tangent, nn, nt, tt = nearest(memory, k, y[k, 0] / d, y[k, 1] / d)
            q[k, 0], q[k, 1] = normal / d, tangent / d
            C[k, 0], C[k, 1], C[k, 2], C[k, 3] = weight * nn, weight * nt, weight * nt, weight * tt
            cost += 0.5 * (normal * normal + tangent * tangent) - best[k, 0] * y[k, 0] - best[k, 1] * y[k, 1]
        change[k, 0], change[k, 1] = (best[k, 0] - q[k, 0]) / delta, (best[k, 1] - q[k, 1]) / delta
    for i in range(op.n_unknowns):
        work.x[i] = z[i] - last[i]
    size = defect(op, group, work.x, change, work.rest, PLANAR)
    return delta * size, cost + 0.5 * delta * product(op, group, work.x, work.x, PLANAR)


@kernel
def next_multipliers(memory: LargeMemory, delta: float, free: float, goal: float) -> bool:
    """Newton's method for one z_last, ``point``, which is replaced by z; whether it got there."""
    op, work, n = memory.op, memory.newton, memory.op.n_unknowns
    last, z, step, rest, best = work.point, memory.trial_point, work.step, work.rest, memory.good_point
    for i in range(n):
        best[i] = last[i]
    size, cost = impulses_of(memory, best, last, delta, free)
    for _ in range(STEPS):
        if size <= goal:
            break
        if not factorise(op, work.C, memory.apart, PLANAR):
            return False
        slope = 0.0
        for i in range(n):
            step[i] = -rest[i]
        solve(op, memory.apart, step)
        for i in range(n):
            slope += delta * rest[i] * step[i]
        length, before = 1.0, size
        while length > SHORTEST:
            for i in range(n):
                z[i] = best[i] + length * step[i]
            size, now = impulses_of(memory, z, last, delta, free)
            if now <= cost + 1e-4 * length * slope or size <= 0.5 * before:
                break
            length *= 0.4
        if length <= SHORTEST:
            return False
        cost = now
        for i in range(n):
            best[i] = z[i]
    for i in range(n):
        last[i] = best[i]
    return size <= goal


@kernel
def least_impulses(problem: BodyContacts, memory: LargeMemory) -> int:
    """Replace the impulses p that were just found by the least of the same effect; SOLVED, ITERATION_LIMIT or ROOM.

    Right after ``take_impulses`` of the same problem. Impulses whose effect differs, so that the residual would be
    larger and above the tolerance, are not taken. After ROOM, which ``memory.apart`` lacks, p is as it was. The pattern
    is one of its own, of these contacts alone: neither do later steps depend on it, nor does it depend on earlier ones.
    """
    op, group, judged, best, work = memory.op, memory.group, memory.judged, memory.best, memory.newton
    if group.n < 2:
        return ITERATION_LIMIT
    memory.apart.known = 0
    if not make_pattern(op, group, memory.apart) or not has_room(memory.apart):
        return ROOM
    residual = judge(op, group, judged, best.p, PLANAR)
    read_states(memory, residual)
    mean, effect = 0.0, 0.0
    for k in range(group.n):
        mean += 1.0 / (memory.scale[k] * memory.scale[k] * group.n)
        work.slope[k, 0], work.slope[k, 1] = 0.0, 0.0
    for i in range(op.n_unknowns):
        work.point[i] = 0.0
        effect = max(effect, abs(op.x[i]))
    before, delta, found = squares(memory, best.p), FIRST * mean, False
    for _ in range(CENTRES):
        if not next_multipliers(memory, delta, FREE * mean, CLOSE * effect):
            break
        copy_forces(group, work.trial, group.p, PLANAR)
        if judge(op, group, judged, group.p, PLANAR) <= max(residual, judged.tolerance * judged.load):
            found = True
            break
        delta = max(0.1 * delta, LEAST * mean)
    if not found or squares(memory, group.p) > before:
        return ITERATION_LIMIT
    copy_forces(group, group.p, best.p, PLANAR)
    unpack(problem, memory, best.p, PLANAR)
    return SOLVED


@kernel
def squares(memory: LargeMemory, p: FloatArray) -> float:
    """|p|^2 of all contacts."""
    total = 0.0
    for k in range(memory.group.n):
        if memory.group.law[k] != BILATERAL:
            d = memory.scale[k]
            total += (p[k, 0] * p[k, 0] + p[k, 1] * p[k, 1]) * d * d
    return total
