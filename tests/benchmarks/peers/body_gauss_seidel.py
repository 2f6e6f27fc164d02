"""A projected Gauss-Seidel method in the velocities of planar bodies, and discs in a box that step with it.

What many programs for granular matter do, in its shortest form: contact after contact takes the impulse that its own
law asks for, and the velocities of its two bodies follow at once. It is judged by the residual of the contact
problem, in the units of each contact and relative to the free velocity, as lcpflex judges itself (``Result.strict``).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numba
import numpy as np
from numpy.typing import NDArray

njit: Callable[..., Any] = numba.njit(cache=False, error_model="numpy")


@njit
def relative(u, bodies, normal, arms, k, axis):  # type: ignore[no-untyped-def]
    """Velocity of contact k along its normal (0) or tangent (1): of its first body against its second."""
    nx, ny = normal[k]
    if axis == 1:
        nx, ny = ny, -nx
    v = 0.0
    for side in range(2):
        b = bodies[k, side]
        if b >= 0:
            ax, ay = arms[k, side]
            sign = 1.0 - 2.0 * side
            v += sign * (nx * u[b, 0] + ny * u[b, 1] + (ax * ny - ay * nx) * u[b, 2])
    return v


@njit
def push(u, inverse, bodies, normal, arms, k, axis, p):  # type: ignore[no-untyped-def]
    """Give the bodies of contact k the impulse p along that axis; returns 1 / (its effective mass)."""
    nx, ny = normal[k]
    if axis == 1:
        nx, ny = ny, -nx
    weight = 0.0
    for side in range(2):
        b = bodies[k, side]
        if b >= 0:
            ax, ay = arms[k, side]
            lever = ax * ny - ay * nx
            sign = 1.0 - 2.0 * side
            u[b, 0] += sign * nx * p * inverse[b, 0]
            u[b, 1] += sign * ny * p * inverse[b, 0]
            u[b, 2] += sign * lever * p * inverse[b, 1]
            weight += inverse[b, 0] + lever**2 * inverse[b, 1]
    return weight


@njit
def solve(u, inverse, bodies, normal, arms, mu, p, tolerance, most):  # type: ignore[no-untyped-def]
    """Sweeps from the impulses p on until the residual is met: u and p in place; residual and number of sweeps."""
    n = len(bodies)
    weight = np.zeros((n, 2))
    largest = 0.0
    for k in range(n):
        for axis in range(2):
            weight[k, axis] = push(u, inverse, bodies, normal, arms, k, axis, 0.0)
            v = abs(relative(u, bodies, normal, arms, k, axis))
            largest = max(largest, v / np.sqrt(weight[k, axis]))
    for k in range(n):
        for axis in range(2):
            push(u, inverse, bodies, normal, arms, k, axis, p[k, axis])
    error, sweeps = judge(u, bodies, normal, arms, weight, mu, p) / largest, 0
    while error > tolerance and sweeps < most:
        for _ in range(4):
            for k in range(n):
                for axis in range(2):
                    v = relative(u, bodies, normal, arms, k, axis)
                    new = p[k, axis] - v / weight[k, axis]
                    new = max(new, 0.0) if axis == 0 else min(max(new, -mu * p[k, 0]), mu * p[k, 0])
                    push(u, inverse, bodies, normal, arms, k, axis, new - p[k, axis])
                    p[k, axis] = new
        sweeps += 4
        error = judge(u, bodies, normal, arms, weight, mu, p) / largest
    return error, sweeps


@njit
def judge(u, bodies, normal, arms, weight, mu, p):  # type: ignore[no-untyped-def]
    """The largest residual of the natural map, each contact in its own units."""
    error = 0.0
    for k in range(len(bodies)):
        root = np.sqrt(max(weight[k, 0], weight[k, 1]))
        y = relative(u, bodies, normal, arms, k, 0) / root
        t = relative(u, bodies, normal, arms, k, 1) / root
        bound = mu * max(p[k, 0], 0.0) * root
        q = p[k, 1] * root
        error = max(error, abs(min(p[k, 0] * root, y)), abs(q - min(max(q - t, -bound), bound)))
    return error


@njit
def touching(q, u, radius, width, half):  # type: ignore[no-untyped-def]
    """Pairs (m, 2), normals (m, 2) of discs in a box whose gap is closed after ``half``; sides are -1, -2, -3."""
    n = len(radius)
    order = np.argsort(q[:, 0])
    pairs, normals = np.empty((8 * n, 2), np.int64), np.empty((8 * n, 2))
    m, reach = 0, 2.02 * radius.max()
    for s in range(n):
        i = order[s]
        x, y = q[i, 0] + half * u[i, 0], q[i, 1] + half * u[i, 1]
        for side, nx, ny, gap in ((-1, 0.0, 1.0, y), (-2, 1.0, 0.0, x), (-3, -1.0, 0.0, width - x)):
            if gap < radius[i]:
                pairs[m, 0], pairs[m, 1] = i, side
                normals[m, 0], normals[m, 1] = nx, ny
                m += 1
        for later in range(s + 1, n):
            j = order[later]
            if q[j, 0] - q[i, 0] > reach:
                break
            dx, dy = x - q[j, 0] - half * u[j, 0], y - q[j, 1] - half * u[j, 1]
            distance = np.sqrt(dx * dx + dy * dy)
            if distance < radius[i] + radius[j]:
                pairs[m, 0], pairs[m, 1] = i, j
                normals[m, 0], normals[m, 1] = dx / distance, dy / distance
                m += 1
    return pairs[:m], normals[:m]


class Discs:
    """Discs of unit mass in a box: Moreau's midpoint rule, sweeps that start from the impulses of the step before."""

    def __init__(self, q: NDArray[np.float64], radius: NDArray[np.float64], width: float, friction: float, h: float):
        self.q, self.u = q.copy(), np.zeros_like(q)
        self.radius, self.width, self.friction, self.h = radius, width, friction, h
        self.inverse = np.column_stack([np.ones(len(q)), 2.0 / radius**2])
        self.kept: dict[tuple[int, int], NDArray[np.float64]] = {}

    def step(self, tolerance: float, most: int) -> tuple[float, int]:
        """One step; residual and sweeps."""
        pairs, normal = touching(self.q, self.u, self.radius, self.width, 0.5 * self.h)
        before, found = self.u.copy(), (0.0, 0)
        self.u[:, 1] -= 9.81 * self.h
        if len(pairs):
            arms = np.zeros((len(pairs), 2, 2))
            arms[:, 0] = -self.radius[pairs[:, 0], None] * normal
            arms[:, 1] = np.where(pairs[:, 1, None] >= 0, self.radius[pairs[:, 1], None] * normal, 0.0)
            none = np.zeros(2)
            keys = [tuple(sorted(map(int, pair))) for pair in pairs]
            p = np.array([self.kept.get(key, none) for key in keys])  # type: ignore[call-overload]
            found = solve(self.u, self.inverse, pairs, normal, arms, self.friction, p, tolerance, most)
            self.kept = dict(zip(keys, p, strict=True))  # type: ignore[arg-type]
        self.q += 0.5 * self.h * (before + self.u)
        return found
