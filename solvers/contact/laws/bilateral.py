"""Rows of joints: v = 0, whatever force it takes. Up to S rows between the same bodies in one unit."""

from __future__ import annotations

import numpy as np

from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.jit.leaf import leaf
from lcpflex.solvers.contact.algebra import Vector, size_of
from lcpflex.solvers.contact.group import Group
from lcpflex.solvers.contact.laws.states import STICKING

__all__ = ["answer", "derivative", "miss", "room", "soft", "solve"]

SINGULAR = 1e-13  # relative determinant of two rows that move together
HELD = 1e-6  # eps at most: rows of joints are linear, and nothing cycles


@leaf
def solve(group: Group, k: int, v: Vector, p: Vector) -> tuple[Vector, bool]:
    """p - W_kk^-1 v; of rows that depend on each other the first alone are served."""
    raise NotImplementedError


@solve.of(2)
@kernel(inline=True)
def solve_two(group: Group, k: int, v: Vector, p: Vector) -> tuple[Vector, bool]:
    """Both rows at once; the second may be none (W_TT = 0)."""
    a, b, d = group.own[k, 0], group.own[k, 1], group.own[k, 3]
    det = a * d - b * b
    if det > SINGULAR * a * d:
        return (p[0] + (b * v[1] - d * v[0]) / det, p[1] + (b * v[0] - a * v[1]) / det), True
    if a > 0.0:
        return (p[0] - v[0] / a, p[1]), True
    return (p[0], p[1] - v[1] / d if d > 0.0 else p[1]), True


@solve.of(3)
@kernel
def solve_three(group: Group, k: int, v: Vector, p: Vector) -> tuple[Vector, bool]:
    """By factors L D L^T of W_kk; a row whose pivot is rounding keeps its force."""
    own = group.own
    d_0 = own[k, 0]
    l_1, l_2 = (own[k, 3] / d_0, own[k, 6] / d_0) if d_0 > 0.0 else (0.0, 0.0)
    d_1 = own[k, 4] - l_1 * own[k, 3]
    second = d_1 > SINGULAR * own[k, 4]
    l_21 = (own[k, 7] - l_2 * own[k, 3]) / d_1 if second else 0.0
    d_2 = own[k, 8] - l_2 * own[k, 6] - l_21 * l_21 * d_1
    y_1 = -v[1] + l_1 * v[0]
    y_2 = -v[2] + l_2 * v[0] - l_21 * y_1
    x_2 = y_2 / d_2 if d_2 > SINGULAR * own[k, 8] else 0.0
    x_1 = y_1 / d_1 - l_21 * x_2 if second else 0.0
    x_0 = -v[0] / d_0 - l_1 * x_1 - l_2 * x_2 if d_0 > 0.0 else 0.0
    return (p[0] + x_0, p[1] + x_1, p[2] + x_2), True


@kernel(inline=True)
def answer(group: Group, k: int, a: Vector, convex: bool) -> tuple[Vector, int]:
    """Whatever is asked for."""
    return a, STICKING


@kernel(inline=True)
def derivative(group: Group, k: int, a: Vector, state: int, rho: float, C: FloatArray) -> None:
    """The identity."""
    for e in range(C.shape[1]):
        C[k, e] = rho if e % (len(a) + 1) == 0 else 0.0


@kernel(inline=True)
def room(group: Group, k: int, q: Vector, d: Vector) -> float:
    """No end."""
    return np.inf


@kernel(inline=True)
def miss(group: Group, k: int, p: Vector, v: Vector) -> float:
    """|v|, inf where anything is not finite."""
    left = size_of(v) * group.unit[k]
    return left if left + size_of(p) < np.inf else np.inf


@kernel(inline=True)
def soft(eps: float) -> float:
    """Hard enough that one centre does."""
    return min(eps, HELD)
