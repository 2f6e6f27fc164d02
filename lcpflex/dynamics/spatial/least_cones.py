"""Undetermined forces in space: of all with the same effect, those nearest to the least ones in their cones.

A box on four corners is held by many sets of forces. In units of the contacts, times the roots of their weights, the
least set r_0 solves W r = W p for the forces p that were found; conjugate gradients that begin from nothing stay in the
range of W and come to it. Where r_0 leaves a cone, p goes towards it as far as all cones let it. Source: Hestenes &
Stiefel 1952.
"""

from __future__ import annotations

import math

from lcpflex.dynamics.spatial.cone_sweeps import judge_island
from lcpflex.dynamics.spatial.contact_problem import describe_island
from lcpflex.dynamics.spatial.inertia import SpatialWork
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.solvers.contact.algebra import IN_SPACE
from lcpflex.solvers.contact.operators import begin
from lcpflex.solvers.contact.operators.scene import row_velocities

__all__ = ["shorten_island", "way_in_cone"]

EXACT, ENOUGH = 1e-15, 1e-11  # of what the forces do: what is left of it where the iteration ends, and may be left
TOUCHING = 1e-8  # of the free velocities: contacts that open faster carry nothing
MOST = 3  # iterations for each unknown
LIGHTEST = 1e-8  # of the largest weight: less gets no less, being nothing


@kernel
def respond(work: SpatialWork, force: FloatArray, out: FloatArray) -> None:
    """out = W force of the island described, both (contacts, 3) in units; rows of open contacts are 0."""
    group, op = work.impulses.solver.group, work.impulses.solver.scene
    for c in range(group.n):
        for x in range(3):
            out[c, x] = group.unit[c] * force[c, x]
    begin(op, group, out, IN_SPACE)
    for c in range(group.n):
        own = group.unit[c] * group.slip[c]
        u, u1, u2 = row_velocities(op.rows, op.row_body, op.dof, op.normal[c], op.tangent[c], op.x)
        out[c, 0], out[c, 1], out[c, 2] = own * u, own * u1, own * u2


@kernel
def mark_touching(work: SpatialWork, i: int) -> bool:
    """1 in ``impulses.solver.group.slip`` for contacts that touch, 0 for those that open; whether nothing slips."""
    group, judged = work.impulses.solver.group, work.impulses.solver.judged
    describe_island(work, i)
    judge_island(work)
    for c in range(group.n):
        group.slip[c] = 1.0 if group.unit[c] * group.y[c, 0] <= TOUCHING * judged.load else 0.0
    return bool(judged.sliding == 0 and judged.residual <= judged.tolerance)


@kernel
def weigh(work: SpatialWork, i: int) -> None:
    """The units of the contacts of island i times the roots of their weights, over that of the largest."""
    unit, contact = work.impulses.solver.group.unit, work.posed.islands.contact
    weight, first = work.rows.table.weight, work.posed.islands.start[i]
    n = work.posed.islands.start[i + 1] - first
    largest = 0.0
    for c in range(n):
        largest = max(largest, weight[contact[first + c]])
    for c in range(n):
        own = weight[contact[first + c]]
        if own != largest:
            unit[c] *= math.sqrt(max(own / largest, LIGHTEST))


@kernel
def shorten_island(work: SpatialWork, i: int) -> None:
    """Shorten the forces ``work.impulses.p`` of island i, which has no joints, where nothing slips."""
    memory, group = work.impulses.solver, work.impulses.solver.group
    if not mark_touching(work, i):
        return
    weigh(work, i)
    n, least, left, ahead, moved = group.n, group.p, memory.aside, group.y, memory.moved
    for c in range(n):
        for x in range(3):
            ahead[c, x] = group.p[c, x] / group.unit[c]
    respond(work, ahead, left)
    size = 0.0
    for c in range(n):
        for x in range(3):
            least[c, x], ahead[c, x] = 0.0, left[c, x]
            size += left[c, x] * left[c, x]
    square, done = size, 0
    while square > EXACT * EXACT * size and done < MOST * 3 * n:
        respond(work, ahead, moved)
        along = 0.0
        for c in range(n):
            for x in range(3):
                along += ahead[c, x] * moved[c, x]
        if not along > 0.0:
            break
        share, before = square / along, square
        square = 0.0
        for c in range(n):
            for x in range(3):
                least[c, x] += share * ahead[c, x]
                left[c, x] -= share * moved[c, x]
                square += left[c, x] * left[c, x]
        for c in range(n):
            for x in range(3):
                ahead[c, x] = left[c, x] + square / before * ahead[c, x]
        done += 1
    if square <= ENOUGH * ENOUGH * size:
        approach(work)


@kernel
def approach(work: SpatialWork) -> None:
    """``impulses.p`` of the island described towards ``group.p``, in units, as far as all stay in their cones."""
    group, op, p = work.impulses.solver.group, work.impulses.solver.scene, work.impulses.p
    share = 1.0
    for c in range(group.n):
        r, s, unit = op.normal[c], op.tangent[c], group.unit[c]
        f, g = p[r], unit * group.p[c, 0] - p[r]
        if s < 0:
            share = min(share, f / -g) if f + g < 0.0 else share
        else:
            g1, g2 = unit * group.p[c, 1] - p[s], unit * group.p[c, 2] - p[s + 1]
            share = min(share, way_in_cone(f, p[s], p[s + 1], g, g1, g2, group.mu[c]))
    for c in range(group.n):
        r, s, unit = op.normal[c], op.tangent[c], group.unit[c]
        p[r] += share * (unit * group.p[c, 0] - p[r])
        if s >= 0:
            p[s] += share * (unit * group.p[c, 1] - p[s])
            p[s + 1] += share * (unit * group.p[c, 2] - p[s + 1])


@kernel
def way_in_cone(f: float, f1: float, f2: float, g: float, g1: float, g2: float, mu: float) -> float:
    """The largest t <= 1 for which f + t g lies in the cone |f_T| <= mu f_N, which f does."""
    if mu * (f + g) >= math.sqrt((f1 + g1) ** 2 + (f2 + g2) ** 2):
        return 1.0
    low, high = 0.0, 1.0
    for _ in range(60):
        t = 0.5 * (low + high)
        if mu * (f + t * g) >= math.sqrt((f1 + t * g1) ** 2 + (f2 + t * g2) ** 2):
            low = t
        else:
            high = t
    return low
