"""Sweeps over many contacts that look at what they have reached, and end where sweeping no longer pays."""

from __future__ import annotations

import numpy as np

from lcpflex.jit.kernel import FloatArray, IntArray, kernel
from lcpflex.solvers.contact.coupling import weigh_contacts
from lcpflex.solvers.contact.sweeps import RUNAWAY, sweep_blocks

__all__ = ["point_of_forces", "settle"]

FIRST, MOST = 2, 16  # sweeps before the first look, and between two looks at most


@kernel
def point_of_forces(
    first: IntArray,
    other: IntArray,
    block: FloatArray,
    free: FloatArray,
    friction: FloatArray,
    tangent_of: IntArray,
    forces: FloatArray,
    z: FloatArray,
) -> None:
    """z = [lambda_N, lambda_R, xi_L] of the three-unknown form for forces (m,): xi_L from the slip that they cause."""
    n, m = len(friction), len(free)
    for k in range(n):
        z[k] = forces[k]
        t = tangent_of[k]
        if t >= 0:
            slip = free[t]
            for e in range(first[k], first[k + 1]):
                c = other[e]
                j = tangent_of[c]
                slip += block[e, 2] * forces[c]
                if j >= 0:
                    slip += block[e, 3] * forces[j]
            z[t] = forces[t] + friction[k] * forces[k]
            z[m - n + t] = max(-slip, 0.0)


@kernel
def settle(
    first: IntArray,
    other: IntArray,
    block: FloatArray,
    own: FloatArray,
    free: FloatArray,
    friction: FloatArray,
    tangent_of: IntArray,
    forces: FloatArray,
    states: IntArray,
    z: FloatArray,
    best: FloatArray,
    tolerance: float,
    limit: int,
    patience: int,
    crawling: float,
) -> tuple[int, float]:
    """Up to ``limit`` sweeps from ``forces`` on; how many were made, and the residual of the best point.

    first ... tangent_of: of a :class:`lcpflex.solvers.contact.coupling.Coupling`. forces (m,), states (n,): advanced.
    Out: best (m,), the best forces. Ends where the residual is within the tolerance, where ``patience`` sweeps leave
    more of it than the fraction ``crawling``, and where forces run away. Work: z.
    """
    m = len(free)
    load = 0.0
    for i in range(m):
        load = max(load, abs(free[i]))
    sweeps, look, least = 0, FIRST, np.inf
    mark, before = patience, np.inf
    while True:
        point_of_forces(first, other, block, free, friction, tangent_of, forces, z)
        residual, _, _ = weigh_contacts(first, other, block, free, friction, tangent_of, z, z[:0], z[:0])
        if residual < least:
            least = residual
            for i in range(m):
                best[i] = forces[i]
        if least <= tolerance or sweeps >= limit:
            return sweeps, least
        if sweeps >= mark:
            if least > crawling * before:
                return sweeps, least
            mark, before = sweeps + patience, least
        made, change = sweep_blocks(
            first, other, block, own, free, friction, tangent_of, forces, states, min(look, limit - sweeps), 0.0
        )
        sweeps += made
        look = min(2 * look, MOST)
        if not change < RUNAWAY * load:
            return sweeps, least
