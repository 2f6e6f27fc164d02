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
from lcpflex.dynamics.spatial.delassus import push, speeds
from lcpflex.dynamics.spatial.inertia import SpatialWork
from lcpflex.jit.kernel import FloatArray, kernel

__all__ = ["shorten_island", "way_in_cone"]

EXACT, ENOUGH = 1e-15, 1e-11  # of what the forces do: what is left of it where the iteration ends, and may be left
TOUCHING = 1e-8  # of the free velocities: contacts that open faster carry nothing
MOST = 3  # iterations for each unknown
LIGHTEST = 1e-8  # of the largest weight: less gets no less, being nothing


@kernel
def respond(work: SpatialWork, i: int, force: FloatArray, out: FloatArray) -> None:
    """out = W force of island i, in units of its contacts; rows of open contacts are 0."""
    memory, contact, n_joint, dof = work.solver, work.islands.contact, work.n_joint, work.dof
    x, unit, tangent, zero = memory.change, memory.unit, memory.tangent_row, work.bias
    first = work.islands.start[i]
    n = work.islands.start[i + 1] - first
    for d in range(len(x)):
        x[d] = 0.0
    for c in range(n):
        r, own = n_joint + contact[first + c], unit[c]
        f, f1, f2 = own * force[3 * c], own * force[3 * c + 1], own * force[3 * c + 2]
        push(work.solved, work.row_body, dof, r, tangent[c], f, f1, f2, x)
    for c in range(n):
        r, s, own = n_joint + contact[first + c], tangent[c], unit[c] * work.solver.slip[c]
        u, u1, u2 = speeds(work.rows, work.row_body, dof, zero, r, s, x)
        out[3 * c], out[3 * c + 1], out[3 * c + 2] = own * u, own * u1, own * u2


@kernel
def mark_touching(work: SpatialWork, i: int) -> bool:
    """1 in ``work.solver.slip`` for contacts that touch, 0 for those that open; whether nothing slips."""
    memory, contact, n_joint = work.solver, work.islands.contact, work.n_joint
    first = work.islands.start[i]
    describe_island(work, i)
    judge_island(work, i)
    for c in range(work.islands.start[i + 1] - first):
        r, s = n_joint + contact[first + c], memory.tangent_row[c]
        u, _, _ = speeds(work.rows, work.row_body, work.dof, work.free, r, s, memory.change)
        memory.slip[c] = 1.0 if memory.unit[c] * u <= TOUCHING * memory.load else 0.0
    return bool(memory.sliding == 0 and memory.residual <= memory.tolerance)


@kernel
def weigh(work: SpatialWork, i: int) -> None:
    """The units of the contacts of island i times the roots of their weights, over that of the largest."""
    unit, contact, weight, first = work.solver.unit, work.islands.contact, work.table.weight, work.islands.start[i]
    n = work.islands.start[i + 1] - first
    largest = 0.0
    for c in range(n):
        largest = max(largest, weight[contact[first + c]])
    for c in range(n):
        own = weight[contact[first + c]]
        if own != largest:
            unit[c] *= math.sqrt(max(own / largest, LIGHTEST))


@kernel
def shorten_island(work: SpatialWork, i: int) -> None:
    """Shorten the forces ``work.p`` of island i, which has no joints, where nothing slips."""
    memory, p, contact, n_joint = work.solver, work.p, work.islands.contact, work.n_joint
    first = work.islands.start[i]
    n = work.islands.start[i + 1] - first
    least, left, ahead, moved = memory.force, memory.aside, memory.velocity, memory.sums
    if not mark_touching(work, i):
        return
    weigh(work, i)
    for r in range(len(work.bias)):
        work.bias[r] = 0.0
    for c in range(n):
        r, s, unit = n_joint + contact[first + c], memory.tangent_row[c], memory.unit[c]
        ahead[3 * c] = p[r] / unit
        ahead[3 * c + 1] = p[s] / unit if s >= 0 else 0.0
        ahead[3 * c + 2] = p[s + 1] / unit if s >= 0 else 0.0
    respond(work, i, ahead, left)
    size = 0.0
    for r in range(3 * n):
        least[r], ahead[r] = 0.0, left[r]
        size += left[r] * left[r]
    square, done = size, 0
    while square > EXACT * EXACT * size and done < MOST * 3 * n:
        respond(work, i, ahead, moved)
        along = 0.0
        for r in range(3 * n):
            along += ahead[r] * moved[r]
        if not along > 0.0:
            break
        share, before = square / along, square
        square = 0.0
        for r in range(3 * n):
            least[r] += share * ahead[r]
            left[r] -= share * moved[r]
            square += left[r] * left[r]
        for r in range(3 * n):
            ahead[r] = left[r] + square / before * ahead[r]
        done += 1
    if square <= ENOUGH * ENOUGH * size:
        approach(work, i)


@kernel
def approach(work: SpatialWork, i: int) -> None:
    """``work.p`` of island i towards ``work.solver.force``, in units, as far as all stay in their cones."""
    memory, p, contact, n_joint = work.solver, work.p, work.islands.contact, work.n_joint
    first = work.islands.start[i]
    n = work.islands.start[i + 1] - first
    share = 1.0
    for c in range(n):
        k = contact[first + c]
        r, s, unit = n_joint + k, memory.tangent_row[c], memory.unit[c]
        f, g = p[r], unit * memory.force[3 * c] - p[r]
        if s < 0:
            share = min(share, f / -g) if f + g < 0.0 else share
        else:
            g1, g2 = unit * memory.force[3 * c + 1] - p[s], unit * memory.force[3 * c + 2] - p[s + 1]
            share = min(share, way_in_cone(f, p[s], p[s + 1], g, g1, g2, work.mu[k]))
    for c in range(n):
        r, s, unit = n_joint + contact[first + c], memory.tangent_row[c], memory.unit[c]
        p[r] += share * (unit * memory.force[3 * c] - p[r])
        if s >= 0:
            p[s] += share * (unit * memory.force[3 * c + 1] - p[s])
            p[s + 1] += share * (unit * memory.force[3 * c + 2] - p[s + 1])


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
