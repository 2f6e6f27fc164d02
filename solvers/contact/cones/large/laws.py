"""Coulomb's law regularised about the last forces c, and its derivative, unit by unit.

    y = base + J x,   a = c_N - rho y_N,   b = c_T - rho y_T,   rho = 1 / eps
    open (a <= 0) q = 0;   sticking (|b| <= mu a) q = (a, b);   sliding q = (a, mu a b / |b|);   joints q = c - rho y

The convex law takes the nearest point of the cone to (a, b) instead, as if what slides lifted off.
"""

from __future__ import annotations

import math

from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.solvers.contact.cones.certificate import nearest_in_cone
from lcpflex.solvers.contact.cones.large.memory import FRICTIONAL, SpatialLargeMemory
from lcpflex.solvers.contact.cones.large.packing import add_forces, velocities

__all__ = ["forces_at", "linearise", "same_states"]

OPEN, STICKING, SLIDING, EDGE = 0, 1, 2, 3  # state of a unit; joint rows stick; EDGE: of the cone, by the convex law
JOINT_EPS = 1e-6  # of joint rows at most: they are linear, and nothing cycles


@kernel
def regularised(a: float, b: float, c: float, mu: float, convex: bool) -> tuple[float, float, float, int]:
    """The force q of a contact for (a, b, c), and its state."""
    if convex:
        f, g, h = nearest_in_cone(a, b, c, mu)
        if f == 0.0:
            return 0.0, 0.0, 0.0, OPEN
        return f, g, h, (STICKING if f == a and g == b and h == c else EDGE)
    if a <= 0.0:
        return 0.0, 0.0, 0.0, OPEN
    size, bound = math.sqrt(b * b + c * c), mu * a
    if size <= bound:
        return a, b, c, STICKING
    return a, bound * (b / size), bound * (c / size), SLIDING


@kernel
def forces_at(memory: SpatialLargeMemory, x: FloatArray, eps: float, q: FloatArray, y: FloatArray) -> float:
    """q and y at x, the state of all units, F = x - J^T (q - c) in ``rest``; returns |F|."""
    velocities(memory, memory.base, x, y)
    kind, mu, centre, state, rest, change = (
        memory.kind, memory.mu, memory.centre, memory.state, memory.rest, memory.change,
    )  # fmt: skip
    rho, held, convex = 1.0 / eps, 1.0 / min(eps, JOINT_EPS), memory.convex == 1
    cost = 0.0
    for k in range(memory.n_units):
        own = held if kind[k] > FRICTIONAL else rho
        a, b, c = centre[k, 0] - own * y[k, 0], centre[k, 1] - own * y[k, 1], centre[k, 2] - own * y[k, 2]
        if kind[k] > FRICTIONAL:
            state[k] = STICKING
        else:
            a, b, c, state[k] = regularised(a, b, c, mu[k], convex)
        q[k, 0], q[k, 1], q[k, 2] = a, b, c
        change[k, 0], change[k, 1], change[k, 2] = a - centre[k, 0], b - centre[k, 1], c - centre[k, 2]
        if convex:
            for e in range(3):
                cost += 0.5 / own * (q[k, e] - centre[k, e]) * (q[k, e] + centre[k, e])
                cost += centre[k, e] * (y[k, e] - memory.base[k, e])
    total = 0.0
    for i in range(memory.n_unknowns):
        rest[i] = x[i]
        cost += 0.5 * x[i] * x[i]
    memory.cost = cost
    add_forces(memory, -1.0, change, rest)
    for i in range(memory.n_unknowns):
        total += rest[i] * rest[i]
    return math.sqrt(total)


@kernel
def linearise(memory: SpatialLargeMemory, eps: float) -> None:
    """C = -dq/dy of all units in their states, at the velocities ``speed``."""
    C, state, mu, centre, y = memory.C, memory.state, memory.mu, memory.centre, memory.speed
    for k in range(memory.n_units):
        rho = 1.0 / (min(eps, JOINT_EPS) if memory.kind[k] > FRICTIONAL else eps)
        for e in range(9):
            C[k, e] = 0.0
        if state[k] == OPEN:
            continue
        C[k, 0] = rho
        if state[k] == STICKING:
            C[k, 4], C[k, 8] = rho, rho
            continue
        a, b, c = centre[k, 0] - rho * y[k, 0], centre[k, 1] - rho * y[k, 1], centre[k, 2] - rho * y[k, 2]
        size, m = math.sqrt(b * b + c * c), mu[k]
        if size == 0.0:  # on the axis, where only a cone without width has an edge
            continue
        t, s = b / size, c / size
        along, across = 0.0, rho * m * a / size
        if state[k] == EDGE:
            part = 1.0 / (1.0 + m * m)
            C[k, 0] = rho * part
            along, across = rho * part * m * m, rho * part * m * (a + m * size) / size
            C[k, 1], C[k, 2] = rho * part * m * t, rho * part * m * s
            C[k, 3], C[k, 6] = C[k, 1], C[k, 2]
        else:
            C[k, 3], C[k, 6] = rho * m * t, rho * m * s
        C[k, 4] = along * t * t + across * s * s
        C[k, 5] = (along - across) * t * s
        C[k, 7] = C[k, 5]
        C[k, 8] = along * s * s + across * t * t


@kernel
def same_states(memory: SpatialLargeMemory) -> bool:
    """Whether all units are in the states of the last factor: then it has aged by turned slips alone. They are kept."""
    same = True
    state, factored = memory.state, memory.factored
    for k in range(memory.n_units):
        same = same and state[k] == factored[k]
        factored[k] = state[k]
    return same
