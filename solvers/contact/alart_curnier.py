"""Newton's method on Alart and Curnier's function: the laws about the forces as they are, no centre in the way.

    F(p) = p - answer(p - rho y(p)) = 0,   rho of the own diagonal of each unit
    (I - D + C (W + delta)) dp = -F,   D = d answer / d a,   C = rho D

It needs the forces as its unknowns, and comes to rounding where the proximal method ends at that of y / eps; from far
away it cycles. delta keeps the matrix regular where contacts are dependent; the function itself is without it. A step
may lose against the last value if it wins against one of the last four. Sources: Alart & Curnier 1991; Acary, Bremond &
Huber 2018 (comparison of solvers).
"""

from __future__ import annotations

import numpy as np

from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.solvers.contact.algebra import Vector, along, less, put, taken
from lcpflex.solvers.contact.best import Best, copy_forces, keep_best
from lcpflex.solvers.contact.group import Group
from lcpflex.solvers.contact.judging import Judged, is_exact, judge
from lcpflex.solvers.contact.laws import answer, derivative
from lcpflex.solvers.contact.operators import Operator, factorise_moving, norm, solve, unknowns
from lcpflex.solvers.contact.proximal_newton import NewtonWork

__all__ = ["alart_curnier"]

HALVINGS = 12
DESCENT = 1e-4  # share of the step that the function must fall by
STILL = 1e-15  # of the load: what is left of the function is rounding


@kernel
def miss_of(
    op: Operator, group: Group, judged: Judged, best: Best, work: NewtonWork, p: FloatArray, like: Vector
) -> float:
    """F of the forces p to ``rest``, the states of the units; the length of F. The best forces are kept."""
    keep_best(group, best, p, judge(op, group, judged, p, like), like)
    S = len(like)
    for k in range(group.n):
        force, y = taken(p, k, like), taken(group.y, k, like)
        q, state = answer(group, k, along(force, -(group.unit[k] * group.unit[k]), y), False)
        left = less(force, q)
        put(work.change, k, left)
        put(work.speed, k, y)
        work.state[k] = state
        for e in range(S):
            work.rest[S * k + e] = work.change[k, e]
    return norm(op, group, work.rest)


@kernel
def direction(op: Operator, group: Group, work: NewtonWork, p: FloatArray, like: Vector) -> bool:
    """``step`` = -J^-1 F; False where it is not finite."""
    n = unknowns(op, group)
    for k in range(group.n):
        rho = group.unit[k] * group.unit[k]
        a = along(taken(p, k, like), -rho, taken(work.speed, k, like))
        derivative(group, k, a, work.state[k], rho, work.C)
    work.factors += 1
    if not factorise_moving(op, group, work.C, like):
        return False
    for i in range(n):
        work.step[i] = -work.rest[i]
    solve(op, group, work.step)
    return bool(norm(op, group, work.step) < np.inf)


@kernel
def move(group: Group, p: FloatArray, share: float, step: FloatArray, trial: FloatArray, like: Vector) -> None:
    """Forces trial = p + share step."""
    S = len(like)
    for k in range(group.n):
        for e in range(S):
            trial[k, e] = p[k, e] + share * step[S * k + e]


@kernel
def alart_curnier(
    op: Operator, group: Group, judged: Judged, best: Best, work: NewtonWork, count: int, like: Vector
) -> bool:
    """From the forces p, up to ``count`` factors; whether ``best`` is within the tolerance of the load.

    It goes on to rounding, which costs one or two of them.
    """
    p, trial = group.p, work.trial
    value, goal, limit = miss_of(op, group, judged, best, work, p, like), STILL * judged.load, work.factors + count
    first, second, third, fourth = value, 0.0, 0.0, 0.0
    while value > goal and work.factors < limit:
        if not direction(op, group, work, p, like):
            break
        allowed, share, beaten = max(max(first, second), max(third, fourth)), 1.0, False
        for _ in range(HALVINGS):
            move(group, p, share, work.step, trial, like)
            now = miss_of(op, group, judged, best, work, trial, like)
            if now <= allowed * (1.0 - DESCENT * share):
                beaten = True
                break
            share *= 0.5
        if not beaten:
            break
        stays = now > 0.5 * value and is_exact(judged, best.worst)
        first, second, third, fourth, value = now, first, second, third, now
        copy_forces(group, trial, p, like)
        if stays:  # what is left is rounding
            break
    return is_exact(judged, best.worst)
