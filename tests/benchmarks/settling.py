"""Heaps of discs that lie at rest in their box before a benchmark begins: no overlap, forces in balance.

Damped steps of body Gauss-Seidel in which a gap counts, v_N + gap / h >= 0: what has sunk in comes out, and what would
part by less than a step's way stays a contact. Overlaps are not shrunk away in the end, which would let the whole heap
fall again by as much.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numba
import numpy as np

from tests.benchmarks.peers.body_gauss_seidel import touching
from tests.benchmarks.piles import FloatArray, heap_of

njit: Callable[..., Any] = numba.njit(cache=True, error_model="numpy")
NEIGHBOURS = 12  # of a disc, sides included, at most
REACH = 2e-5  # half the gap up to which two discs touch [m]
OUT = 0.05  # [m/s] at which what has sunk in comes out, at most
PACE, SWEEPS = 2e-3, 100  # time and sweeps of a step
PART, REST = 400, 1e-6  # steps of a part of the way, and speed of what rests [m/s]
KEPT = 0.99, 0.99, 0.9, 0.9  # of each speed after a step: while the heap falls and settles
FREE, CALM = 0.97, 0.5  # then in turns: single discs roll to where they stay, and forces come into balance
GRAVITY = 9.81


@njit
def find(pairs, p, known, kept, write):  # type: ignore[no-untyped-def]
    """Impulses of pairs by their disc of the larger number and its partner: written down, or read."""
    if write:
        known[:] = -9
    for k in range(len(pairs)):
        i, j = max(pairs[k, 0], pairs[k, 1]), min(pairs[k, 0], pairs[k, 1])
        for s in range(NEIGHBOURS):
            if write and known[i, s] == -9:
                known[i, s] = j
                kept[i, s] = p[k]
                break
            if not write and known[i, s] == j:
                p[k] = kept[i, s]
                break


@njit
def gap_of(q, radius, width, i, j):  # type: ignore[no-untyped-def]
    if j >= 0:
        return np.hypot(q[i, 0] - q[j, 0], q[i, 1] - q[j, 1]) - radius[i] - radius[j]
    return (q[i, 1] if j == -1 else q[i, 0] if j == -2 else width - q[i, 0]) - radius[i]


@njit
def give(u, i, j, x, y, spin):  # type: ignore[no-untyped-def]
    """The impulse (x, y) to disc i of 1 kg, its opposite to j, and to both what turns them: u[2] is r omega."""
    u[i, 0] += x
    u[i, 1] += y
    u[i, 2] += 2.0 * spin
    if j >= 0:
        u[j, 0] -= x
        u[j, 1] -= y
        u[j, 2] += 2.0 * spin


@njit
def sweep(u, pairs, normal, bias, mu, p, count):  # type: ignore[no-untyped-def]
    """Normal and tangent of one contact after the other; the ground is all zeros in the last row of u."""
    for _ in range(count):
        for k in range(len(pairs)):
            i, j = pairs[k, 0], max(pairs[k, 1], -1)
            x, y = normal[k, 0], normal[k, 1]
            bodies = 2.0 if j >= 0 else 1.0
            v = x * (u[i, 0] - u[j, 0]) + y * (u[i, 1] - u[j, 1]) + bias[k]
            new = max(p[k, 0] - v / bodies, 0.0)
            give(u, i, j, (new - p[k, 0]) * x, (new - p[k, 0]) * y, 0.0)
            p[k, 0] = new
            v = y * (u[i, 0] - u[j, 0]) - x * (u[i, 1] - u[j, 1]) + u[i, 2] + u[j, 2]
            new = min(max(p[k, 1] - v / (3.0 * bodies), -mu * p[k, 0]), mu * p[k, 0])
            change = new - p[k, 1]
            give(u, i, j, change * y, -change * x, change)
            p[k, 1] = new


@njit
def settle(q, u, radius, width, mu, known, kept, steps, keep):  # type: ignore[no-untyped-def]
    """So many steps in place; ``keep`` of each speed is left after one."""
    n = len(q)
    still = np.zeros_like(q)
    for _ in range(steps):
        pairs, normal = touching(q, still, radius + REACH, width, 0.0)
        p, bias = np.zeros((len(pairs), 2)), np.zeros(len(pairs))
        find(pairs, p, known, kept, False)
        u[:n, 1] -= GRAVITY * PACE
        for k in range(len(pairs)):
            i, j = pairs[k]
            x, y = normal[k]
            bias[k] = max(gap_of(q, radius, width, i, j) / PACE, -OUT)
            give(u, i, max(j, -1), p[k, 0] * x + p[k, 1] * y, p[k, 0] * y - p[k, 1] * x, p[k, 1])
        sweep(u, pairs, normal, bias, mu, p, SWEEPS)
        find(pairs, p, known, kept, True)
        q[:, :2] += PACE * u[:n, :2]
        u *= keep


def laid_to_rest(count: int, friction: float, most: int = 20) -> tuple[FloatArray, FloatArray, float, float]:
    """Places, radii, the width of the box, and the largest speed left [m/s] after at most so many turns.

    Radii are larger by a rounding: discs that touch then do so in the first step, too.
    """
    q, radius, width = heap_of(count)
    q[:, 1] = 0.101 + 0.2001 * np.round((q[:, 1] - 0.105) / 0.22)  # the rows next to each other: a short fall
    q[:, 2] = 0.0
    u = np.zeros((count + 1, 3))
    known, kept = np.full((count, NEIGHBOURS), -9), np.zeros((count, NEIGHBOURS, 2))
    for keep in KEPT:
        settle(q, u, radius, width, friction, known, kept, PART, keep)
    for _ in range(most):
        for keep in (CALM, FREE):
            settle(q, u, radius, width, friction, known, kept, PART, keep)
        if np.abs(u).max() < REST:
            break
    return q, radius + 1e-10, width, float(np.abs(u).max())
