"""Heaps of spheres in an open box that have come to rest before a benchmark begins: no overlap, forces in balance.

Steps of Gauss-Seidel in the velocities of bodies in which a gap counts, v_N + gap / h >= 0: what has sunk in comes out,
and what parts by less than a step's way stays a contact. First the heap falls; then its motion is damped kinetically,
as in dynamic relaxation: a sphere stops when its speed falls, and goes on from there.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numba
import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from tests.benchmarks.peers.spheres import GRAVITY, walls

njit: Callable[..., Any] = numba.njit(cache=True, error_model="numpy")
FloatArray, IntArray = NDArray[np.float64], NDArray[np.int64]
RADIUS, SCATTER = 0.05, 0.1  # the largest [m], and by what part of it others are smaller
NEAR = 0.01  # gaps of pairs that are looked at [m]
OUT = 0.05  # [m/s] at which what has sunk in comes out, at most
PACE, PART = 2e-3, 200  # time of a step, steps of a part of the way
FALL, FALLING, LYING = 500, 20, 30  # steps of the fall, sweeps of a step in it and later
KEPT, SPEEDING = 0.99, 0.9  # of speeds after a step: while it falls, and then of a sphere that gets faster
REST = 1e-6  # speed of what rests [m/s]


@njit
def gap_of(q, radius, point, side, i, j, n):  # type: ignore[no-untyped-def]
    """The gap of sphere i and j, or wall -1 - j; its normal to n, towards i."""
    if j < 0:
        n[:] = side[-1 - j]
        return (q[i] - point[-1 - j]) @ n - radius[i]
    n[:] = q[i] - q[j]
    distance = np.sqrt(n @ n)
    n /= distance
    return distance - radius[i] - radius[j]


@njit
def give(u, inverse, i, j, n, p):  # type: ignore[no-untyped-def]
    """The impulse p to sphere i, its opposite to j: u holds v and r omega of each."""
    x, y, z = n[1] * p[2] - n[2] * p[1], n[2] * p[0] - n[0] * p[2], n[0] * p[1] - n[1] * p[0]
    for b, sign in ((i, 1.0), (j, -1.0)):
        if b >= 0:
            for e in range(3):
                u[b, e] += sign * inverse[b] * p[e]
            u[b, 3] -= 2.5 * inverse[b] * x
            u[b, 4] -= 2.5 * inverse[b] * y
            u[b, 5] -= 2.5 * inverse[b] * z


@njit
def sweep(u, inverse, pairs, normal, bias, mu, p, count):  # type: ignore[no-untyped-def]
    """One contact after the other, each exactly: the block of a sphere's contact is diagonal."""
    d = np.zeros(3)
    for _ in range(count):
        for k in range(len(pairs)):
            i, j = pairs[k]
            a, b, c = normal[k]
            v0, v1, v2, w0, w1, w2 = u[i]
            free = inverse[i]
            if j >= 0:
                v0, v1, v2 = v0 - u[j, 0], v1 - u[j, 1], v2 - u[j, 2]
                w0, w1, w2 = w0 + u[j, 3], w1 + u[j, 4], w2 + u[j, 5]
                free += inverse[j]
            v = v0 * a + v1 * b + v2 * c
            old = p[k, 0] * a + p[k, 1] * b + p[k, 2] * c
            new = max(old - (v + bias[k]) / free, 0.0)
            if new == 0.0 and old == 0.0:
                continue
            own = 1.0 / (3.5 * free)
            x = p[k, 0] - old * a - own * (v0 - v * a - (w1 * c - w2 * b))
            y = p[k, 1] - old * b - own * (v1 - v * b - (w2 * a - w0 * c))
            z = p[k, 2] - old * c - own * (v2 - v * c - (w0 * b - w1 * a))
            size = np.sqrt(x * x + y * y + z * z)
            part = mu * new / size if size > mu * new else 1.0
            d[0] = new * a + part * x - p[k, 0]
            d[1] = new * b + part * y - p[k, 1]
            d[2] = new * c + part * z - p[k, 2]
            p[k] += d
            give(u, inverse, i, j, normal[k], d)


@njit
def step(q, u, last, radius, inverse, point, side, pairs, p, mu, sweeps, lying):  # type: ignore[no-untyped-def]
    """One in place; the largest speed."""
    normal, bias = np.zeros((len(pairs), 3)), np.zeros(len(pairs))
    u[:, 2] -= GRAVITY * PACE
    for k in range(len(pairs)):
        i, j = pairs[k]
        bias[k] = max(gap_of(q, radius, point, side, i, j, normal[k]) / PACE, -OUT)
        give(u, inverse, i, j, normal[k], p[k])
    sweep(u, inverse, pairs, normal, bias, mu, p, sweeps)
    fastest = 0.0
    for i in range(len(q)):
        q[i] += PACE * u[i, :3]
        speed = np.sqrt(u[i] @ u[i])
        fastest = max(fastest, speed)
        stops = lying and speed < last[i]
        last[i] = 0.0 if stops else speed
        u[i] *= 0.0 if stops else (SPEEDING if lying else KEPT)
    return fastest


def pairs_of(q: FloatArray, radius: FloatArray, point: FloatArray, side: FloatArray) -> IntArray:
    """Spheres that are near each other or a wall, in order."""
    near = cKDTree(q).query_pairs(2.0 * radius.max() + NEAR, output_type="ndarray")
    gap = np.linalg.norm(q[near[:, 0]] - q[near[:, 1]], axis=1) - radius[near].sum(axis=1)
    ball, wall = np.nonzero(np.einsum("iwe,we->iw", q[:, None] - point, side) - radius[:, None] < NEAR)
    pairs = np.concatenate([near[gap < NEAR], np.column_stack([ball, -1 - wall])])
    return np.asarray(pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))])


def carried_over(old: IntArray, p: FloatArray, pairs: IntArray, count: int) -> FloatArray:
    """Impulses of pairs that were there before."""
    new = np.zeros((len(pairs), 3))
    if len(old):
        width = count + len(walls(1.0))
        known, wanted = old @ (width, 1), pairs @ (width, 1)
        at = np.minimum(np.searchsorted(known, wanted), len(known) - 1)
        same = known[at] == wanted
        new[same] = p[at[same]]
    return new


def laid_to_rest(count: int, friction: float, seed: int, most: int = 30) -> tuple[FloatArray, FloatArray, float, float]:
    """Places, radii, the width of the box, and the largest speed left [m/s] after at most so many parts of the way."""
    across, rng, pitch = round((count / 2.0) ** (1.0 / 3.0)), np.random.default_rng(seed), 2.05 * RADIUS
    layer, rest = np.divmod(np.arange(count), across**2)
    q = pitch * (np.column_stack([rest % across, rest // across, layer]) + 0.5)
    radius = RADIUS * (1.0 - SCATTER * rng.uniform(size=count))
    q += 0.02 * RADIUS * rng.uniform(-1.0, 1.0, (count, 3))
    width, u, last, inverse = across * pitch, np.zeros((count, 6)), np.zeros(count), (RADIUS / radius) ** 3
    point, side = (np.array(each, dtype=float) for each in zip(*walls(width), strict=True))
    pairs, p, fastest = np.zeros((0, 2), dtype=np.int64), np.zeros((0, 3)), np.inf
    for k in range(FALL + most * PART):
        if k % 5 == 0:
            found = pairs_of(q, radius, point, side)
            pairs, p = found, carried_over(pairs, p, found, count)
        sweeps = FALLING if k < FALL else LYING
        fastest = step(q, u, last, radius, inverse, point, side, pairs, p, friction, sweeps, k >= FALL)
        if fastest < REST and (k - FALL) % PART == PART - 1:
            break
    return q, radius, width, float(fastest)
