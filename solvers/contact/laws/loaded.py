"""Coulomb's law of a contact that carries at least a force f > 0, as an impact law may know.

    p_N >= f  _|_  v_N >= 0,    |p_T| <= mu p_N,    p_T against v_T where it slides

It is :mod:`.coulomb` where it presses more than f; else friction under a pressure that is known. No path is followed
under it, see :mod:`lcpflex.solvers.contact.tracing`.
"""

from __future__ import annotations

import math

import numpy as np

from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.jit.leaf import leaf
from lcpflex.solvers.contact.algebra import Vector, along, block_times, less, with_normal
from lcpflex.solvers.contact.group import Group
from lcpflex.solvers.contact.laws.coulomb import (
    answer as coulomb_answer,
    derivative as coulomb_derivative,
    room as coulomb_room,
    solve as coulomb_solve,
)
from lcpflex.solvers.contact.laws.disc import solve_cone
from lcpflex.solvers.contact.laws.interval import solve_contact
from lcpflex.solvers.contact.laws.states import LEAST

__all__ = ["answer", "derivative", "miss", "room", "soft", "solve"]


@kernel(inline=True)
def solve(group: Group, k: int, v: Vector, p: Vector) -> tuple[Vector, bool]:
    """What Coulomb's law takes if that is more than f; else f, and the friction under it."""
    more, found = coulomb_solve(group, k, v, p)
    if found and more[0] > group.floor[k]:
        return more, True
    start = with_normal(group.floor[k], p)
    d = less(start, p)
    new = rubbed(group, k, along(v, 1.0, block_times(group.own, k, d)), start)
    return new, found or v[0] + block_times(group.own, k, less(new, p))[0] >= 0.0


@leaf
def rubbed(group: Group, k: int, v: Vector, p: Vector) -> Vector:
    """The force with this normal component that obeys the law of friction, v the velocity under p."""
    raise NotImplementedError


@rubbed.of(2)
@kernel(inline=True)
def rubbed_in_plane(group: Group, k: int, v: Vector, p: Vector) -> Vector:
    """A contact whose normal is apart from its tangent, W_NN = 1, pressed by so much."""
    d = group.own[k, 3]
    f, t, group.state[k] = solve_contact(1.0, 0.0, 0.0, d, -p[0], v[1] - d * p[1], group.mu[k])
    return f, t


@rubbed.of(3)
@kernel(inline=True)
def rubbed_in_space(group: Group, k: int, v: Vector, p: Vector) -> Vector:
    """The same; of a block that is not symmetric the symmetric part, as in :mod:`.disc`."""
    aa, ab, bb = group.own[k, 4], 0.5 * (group.own[k, 5] + group.own[k, 7]), group.own[k, 8]
    f, t, s, group.slip[k] = solve_cone(
        1.0, 0.0, 0.0, aa, ab, bb,
        -p[0], v[1] - (aa * p[1] + ab * p[2]), v[2] - (ab * p[1] + bb * p[2]), group.mu[k], group.slip[k],
    )  # fmt: skip
    return f, t, s


@kernel
def answer(group: Group, k: int, a: Vector, convex: bool) -> tuple[Vector, int]:
    """(max(f, a_N), the nearest friction force to a_T); convex: the nearest point of the cone above f."""
    f = group.floor[k]
    q, state = coulomb_answer(group, k, a, convex)
    if q[0] > f:
        return q, state
    least, state = coulomb_answer(group, k, with_normal(f, a), False)
    return with_normal(f, least), state + LEAST


@kernel
def derivative(group: Group, k: int, a: Vector, state: int, rho: float, C: FloatArray) -> None:
    """That of Coulomb's law; under the least force nothing changes with a_N."""
    if state < LEAST:
        coulomb_derivative(group, k, a, state, rho, C)
        return
    coulomb_derivative(group, k, with_normal(group.floor[k], a), state - LEAST, rho, C)
    for e in range(len(a)):
        C[k, len(a) * e] = 0.0


@kernel
def room(group: Group, k: int, q: Vector, d: Vector) -> float:
    """Until no more than f is left, or what sticks slides."""
    f = group.floor[k]
    if q[0] > f:
        far = coulomb_room(group, k, q, d)
        return min(far, (f - q[0]) / d[0]) if d[0] < 0.0 else far
    return coulomb_room(group, k, q, with_normal(max(d[0], 0.0), d))


@kernel
def miss(group: Group, k: int, p: Vector, v: Vector) -> float:
    """|min(p_N - f, v_N)|, and p_T less its nearest point to p_T - v_T under the pressure p_N."""
    d = group.unit[k]
    away, left = d * v[0], (p[0] - group.floor[k]) / d
    rubs = friction_miss(p, v, d, group.mu[k] * max(p[0], 0.0) / d)
    return max(abs(min(left, away)), rubs) if abs(left) + abs(away) + rubs < np.inf else np.inf


@leaf
def friction_miss(p: Vector, v: Vector, unit: float, bound: float) -> float:
    """The largest component of p_T less the nearest point to p_T - v_T no longer than ``bound``, in its unit."""
    raise NotImplementedError


@friction_miss.of(2)
@kernel(inline=True)
def friction_miss_in_plane(p: Vector, v: Vector, unit: float, bound: float) -> float:
    """In an interval; NaN where anything is not finite."""
    t = p[1] / unit
    return abs(t - min(max(t - unit * v[1], -bound), bound)) + 0.0 * (t + v[1])


@friction_miss.of(3)
@kernel(inline=True)
def friction_miss_in_space(p: Vector, v: Vector, unit: float, bound: float) -> float:
    """In a disc; NaN where anything is not finite."""
    t, s = p[1] / unit, p[2] / unit
    y, z = t - unit * v[1], s - unit * v[2]
    size = math.sqrt(y * y + z * z)
    share = 1.0 if size <= bound else bound / size
    return max(abs(t - share * y), abs(s - share * z)) + 0.0 * (t + s + v[1] + v[2])


@kernel(inline=True)
def soft(eps: float) -> float:
    """A contact is as soft as it is taken to be."""
    return eps
