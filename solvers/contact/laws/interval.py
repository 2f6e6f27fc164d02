"""Coulomb's law of one contact in the plane: the friction force is in an interval.

    0 <= v_N = a p + b t + r_N  _|_  p >= 0,    v_T = c p + d t + r_T,    t in -mu p Sign(v_T)

Two unknowns, solved exactly: open, sticking, or sliding one way or the other. Sources: Jean 1999 (nonsmooth contact
dynamics); Jourdan, Alart & Jean 1998.
"""

from __future__ import annotations

import numpy as np

from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.solvers.contact.algebra import Vector
from lcpflex.solvers.contact.group import Group
from lcpflex.solvers.contact.laws import coulomb
from lcpflex.solvers.contact.laws.states import BACK, EDGE_BACK, EDGE_FORTH, FORTH, OPEN, STICKING

__all__ = ["solve_contact"]

ROUND = 1e-14  # how far a sign may be off, relative to its terms
INSIDE = 1e-12  # of the edge of its interval: a contact that is nearer slides already
SINGULAR = 1e-13  # relative determinant of a contact whose normal and tangent move together


@kernel
def solve_contact(
    a: float, b: float, c: float, d: float, r_n: float, r_t: float, mu: float
) -> tuple[float, float, int]:
    """Forces p, t and state of one contact: v_N = a p + b t + r_N, v_T = c p + d t + r_T, |t| <= mu p.

    If no state fits (a Painleve pattern, a - mu |b| <= 0 while approaching), the forces that stop the approach without
    friction.
    """
    if r_n >= 0.0:
        return 0.0, 0.0, OPEN
    det = a * d - b * c
    if det > SINGULAR * a * d:
        p = (b * r_t - d * r_n) / det
        t = (c * r_n - a * r_t) / det
        if p >= 0.0 and abs(t) <= mu * p * (1.0 + ROUND):
            return p, min(max(t, -mu * p), mu * p), STICKING
    best, p_best, t_best, state = np.inf, 0.0, 0.0, FORTH
    for turn in range(2):
        sign = -1.0 if turn == 0 else 1.0  # of the friction force: against sliding forth, against sliding back
        stiffness = a + sign * mu * b
        if stiffness > SINGULAR * a:
            p = -r_n / stiffness
            slip = c * p + d * sign * mu * p + r_t
            wrong = sign * slip  # sliding forth has slip >= 0 and a negative force
            if wrong < best:
                best, p_best, t_best = wrong, p, sign * mu * p
                state = FORTH if turn == 0 else BACK
    if best < np.inf:
        return p_best, t_best, state
    return (-r_n / a if a > 0.0 else 0.0), 0.0, FORTH


@coulomb.solve.of(2)
@kernel(inline=True)
def solve(group: Group, k: int, v: Vector, p: Vector) -> tuple[Vector, bool]:
    """Open, sticking or sliding, as :func:`solve_contact` tells."""
    a, b, c, d = group.own[k, 0], group.own[k, 1], group.own[k, 2], group.own[k, 3]
    new, rub, state = solve_contact(
        a, b, c, d, v[0] - a * p[0] - b * p[1], v[1] - c * p[0] - d * p[1], group.mu[k]
    )  # fmt: skip
    group.state[k] = state
    return (new, rub), True


@coulomb.answer.of(2)
@kernel(inline=True)
def answer(group: Group, k: int, a: Vector, convex: bool) -> tuple[Vector, int]:
    """(a_N, the nearest friction force to a_T)."""
    n, t, mu = a[0], a[1], group.mu[k]
    if convex:
        along = (n + mu * abs(t)) / (1.0 + mu * mu)
        if abs(t) <= mu * n:
            return a, STICKING
        if along <= 0.0:
            return (0.0, 0.0), OPEN
        return (along, (mu if t > 0.0 else -mu) * along), (EDGE_FORTH if t > 0.0 else EDGE_BACK)
    if n <= 0.0:
        return (0.0, 0.0), OPEN
    if abs(t) <= mu * n:
        return a, STICKING
    if t > 0.0:
        return (n, mu * n), FORTH
    return (n, -mu * n), BACK


@coulomb.derivative.of(2)
@kernel(inline=True)
def derivative(group: Group, k: int, a: Vector, state: int, rho: float, C: FloatArray) -> None:
    """Of the state, in which the answer is linear."""
    mu = group.mu[k]
    C[k, 0] = 0.0 if state == OPEN else rho
    C[k, 1] = 0.0
    C[k, 2] = mu * rho if state == FORTH else (-mu * rho if state == BACK else 0.0)
    C[k, 3] = rho if state == STICKING else 0.0
    if state >= EDGE_FORTH:
        side = mu if state == EDGE_FORTH else -mu
        part = rho / (1.0 + side * side)
        C[k, 0], C[k, 1], C[k, 2], C[k, 3] = part, side * part, side * part, side * side * part


@coulomb.room.of(2)
@kernel(inline=True)
def room(group: Group, k: int, q: Vector, d: Vector) -> float:
    """To the normal force 0, and to both edges of the interval."""
    far, mu, normal = np.inf, group.mu[k], q[0]
    if normal > 0.0:
        if d[0] < 0.0:
            far = -normal / d[0]
        for turn in range(2):
            sign = -1.0 if turn == 0 else 1.0
            left, rate = mu * normal - sign * q[1], sign * d[1] - mu * d[0]
            if rate > 0.0 and left > INSIDE * mu * normal:
                far = min(far, left / rate)
    return far


@coulomb.miss.of(2)
@kernel(inline=True)
def miss(group: Group, k: int, p: Vector, v: Vector) -> float:
    """|min(p_N, v_N)|, |p_T - clip(p_T - v_T, -mu p_N, mu p_N)|; inf where anything is not finite."""
    unit = group.unit[k]
    normal, tangent, away, along = p[0] / unit, p[1] / unit, unit * v[0], unit * v[1]
    if not abs(normal) + abs(tangent) + abs(away) + abs(along) < np.inf:
        return np.inf
    bound = group.mu[k] * max(normal, 0.0)
    return float(max(abs(min(normal, away)), abs(tangent - min(max(tangent - along, -bound), bound))))
