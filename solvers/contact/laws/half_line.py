"""Contact without friction, whose force is at least f: 0 or, where an impact law knows of a force, what that is.

p_N >= f  _|_  v_N >= 0,    p_T = 0
"""

from __future__ import annotations

import numpy as np

from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.solvers.contact.algebra import Vector, along_normal
from lcpflex.solvers.contact.group import Group
from lcpflex.solvers.contact.laws.states import OPEN, STICKING

__all__ = ["answer", "derivative", "miss", "room", "soft", "solve"]


@kernel(inline=True)
def solve(group: Group, k: int, v: Vector, p: Vector) -> tuple[Vector, bool]:
    """p_N = max(f, p_N - v_N / W_NN); one that nothing moves keeps f if it does not approach."""
    own = group.own[k, 0]
    if own > 0.0:
        new = p[0] + max(group.floor[k] - p[0], -v[0] / own)
        return along_normal(new, p), True
    return along_normal(group.floor[k], p), v[0] + own * (group.floor[k] - p[0]) >= 0.0


@kernel(inline=True)
def answer(group: Group, k: int, a: Vector, convex: bool) -> tuple[Vector, int]:
    """max(f, a_N)."""
    if a[0] <= group.floor[k]:
        return along_normal(group.floor[k], a), OPEN
    return along_normal(a[0], a), STICKING


@kernel(inline=True)
def derivative(group: Group, k: int, a: Vector, state: int, rho: float, C: FloatArray) -> None:
    """1 where it is more than f."""
    for e in range(C.shape[1]):
        C[k, e] = 0.0
    if state == STICKING:
        C[k, 0] = rho


@kernel(inline=True)
def room(group: Group, k: int, q: Vector, d: Vector) -> float:
    """Until no more than f is left."""
    return (group.floor[k] - q[0]) / d[0] if q[0] > group.floor[k] and d[0] < 0.0 else np.inf


@kernel(inline=True)
def miss(group: Group, k: int, p: Vector, v: Vector) -> float:
    """|min(p_N - f, v_N)|."""
    d = group.unit[k]
    away, left = d * v[0], (p[0] - group.floor[k]) / d
    return float(abs(min(left, away))) if abs(left) + abs(away) < np.inf else np.inf


@kernel(inline=True)
def soft(eps: float) -> float:
    """A contact is as soft as it is taken to be."""
    return eps
