"""Reactions of redundant joints: of all that make the same motion those of the least norm.

With the multipliers p of all rows, S = J A^-1 J^T and the norm p^T W p = sum over joints |F|^2 + |M|^2 / L^2, L being
the extent of the largest body, what is to be taken off p is the limit of

    n_0 = p,   (S + eps W) n_k+1 = eps W n_k,

as each turn leaves eps / (lambda + eps) of what has an effect on the motion, and all of what has none. Nothing is
asked of the rank: rounding hides some dependent rows from the factor of S, while that of S + eps W has none. What
rounding adds goes with the size of n: the same again for p - n leaves the rounding of what is left. A vector with a
part of every row shows which joints have some in what has no effect: the others have a reaction of their own.

Source: inverse iteration; the proximal point method for least squares (iterated Tikhonov regularisation).
"""

from __future__ import annotations

import math

from lcpflex.dynamics.joint_response import assemble_joints, factorise_joints
from lcpflex.dynamics.reaction_memory import Reactions, reaction
from lcpflex.dynamics.workspace import Workspace
from lcpflex.jit.kernel import FloatArray, kernel, late_kernel
from lcpflex.model.arrays import Model
from lcpflex.solvers.sparse_cholesky import factorise_sparse, solve_sparse

__all__ = ["take_least"]

WEIGHT = 1e-8  # eps, in units of S / W
TURNS = 60
SETTLED = 1e-12  # of the largest multiplier: change that ends turns and passes
SLOW = 0.5  # of the change before: what is left then is rounding, or without an effect to eps
CONVERGED = 1e-3  # of the largest multiplier: change that must be reached
PASSES = 6
SWEEPS = 30  # over rows of a joint that are not at right angles
OPEN_PART = 1e-4  # of a row's part of the vector: more without an effect is a reaction that is not determined
GOLDEN = 0.6180339887498949


@kernel
def products(a: FloatArray, b: FloatArray) -> tuple[float, float]:
    """Of the forces of two reactions, and of their moments."""
    n = len(a)
    force, moment = 0.0, 0.0
    for i in range(n):
        if i < n - n // 2:
            force += a[i] * b[i]
        else:
            moment += a[i] * b[i]
    return force, moment


@kernel
def weight(work: Workspace, size: float, r: int, s: int) -> float:
    """W[r, s] of two rows of one joint, L = ``size`` [m]."""
    force, moment = products(work.rows.wrench[r], work.rows.wrench[s])
    return force + moment / (size * size)


@kernel
def factorise_weighted(work: Workspace, reactions: Reactions) -> float:
    """The factor of S + eps W in the place of that of S; returns eps."""
    factor, owner = work.rows.joints.factor, reactions.owner
    order, start, column, value = factor.order, factor.start, factor.column, factor.value
    assemble_joints(work.rows)
    mean, count = 0.0, 0
    for i in range(len(order)):
        own, unit = value[start[i + 1] - 1], weight(work, reactions.size, order[i], order[i])
        if own > 0.0 and unit > 0.0:
            mean += math.log(own / unit)
            count += 1
    scale = WEIGHT * math.exp(mean / max(count, 1))
    for i in range(len(order)):
        for e in range(start[i], start[i + 1]):
            r, s = order[i], order[column[e]]
            if owner[r] == owner[s]:
                value[e] += scale * weight(work, reactions.size, r, s)
    factorise_sparse(factor)
    return scale


@kernel
def without_effect(model: Model, work: Workspace, scale: float, p: FloatArray, reactions: Reactions) -> bool:
    """reactions.least: the part of the multipliers p without an effect on the motion; whether it converged."""
    factor, owner, part, load = work.rows.joints.factor, reactions.owner, reactions.least, reactions.load
    order, row = factor.order, model.joints.row
    largest = 0.0
    for r in range(len(p)):
        part[r] = p[r]
        largest = max(largest, abs(p[r]))
    moved = largest
    for turn in range(TURNS):
        for i in range(len(p)):
            r = order[i]
            load[i] = 0.0
            for s in range(row[owner[r]], row[owner[r] + 1]):
                load[i] += scale * weight(work, reactions.size, r, s) * part[s]
        solve_sparse(factor, load)
        before = moved
        moved = 0.0
        for i in range(len(p)):
            moved = max(moved, abs(load[i] - part[order[i]]))
            part[order[i]] = load[i]
        if not moved > SETTLED * largest or (turn > 1 and moved > SLOW * before):
            break
    return moved <= CONVERGED * largest


@kernel
def share(wrench: FloatArray, left: FloatArray, size: float) -> float:
    """The multiplier of a row that comes nearest to a reaction, ``left``; 0 of a row without any."""
    force, moment = products(wrench, left)
    of_force, of_moment = products(wrench, wrench)
    if of_force == 0.0:  # nothing but a moment: without rounding by its unit
        return moment / of_moment if of_moment > 0.0 else 0.0
    if of_moment == 0.0:
        return force / of_force
    unit = size * size
    return (force * unit + moment) / (of_force * unit + of_moment)


@kernel
def multipliers(model: Model, work: Workspace, reactions: Reactions) -> None:
    """reactions.rows: multipliers with the force and moment ``reactions.mean`` of each joint, as near as they come.

    Zero of joints whose forces no step has told.
    """
    p, row, wrench, left = reactions.rows, model.joints.row, work.rows.wrench, reactions.change
    for joint in range(len(reactions.mean)):
        for r in range(row[joint], row[joint + 1]):
            p[r] = 0.0
        force = 0.0
        for i in range(reactions.mean.shape[1]):
            force += abs(reactions.mean[joint, i])
        if not force < math.inf:
            continue
        for _ in range(SWEEPS):
            largest = 0.0
            for r in range(row[joint], row[joint + 1]):
                now = reaction(model, work, joint, p)
                for i in range(len(now)):
                    left[joint, i] = reactions.mean[joint, i] - now[i]
                added = share(wrench[r], left[joint], reactions.size)
                p[r] += added
                largest = max(largest, abs(added))
            if not largest > 1e-14 * force:
                break


@kernel
def mark(model: Model, work: Workspace, scale: float, reactions: Reactions) -> bool:
    """``reactions.unique`` of each joint; whether there is one that is not."""
    p, part = reactions.rows, reactions.least
    for r in range(len(p)):
        p[r] = 0.5 + (GOLDEN * r) % 1.0
        force, moment = products(work.rows.wrench[r], work.rows.wrench[r])
        if moment > 0.0 and force == 0.0:
            p[r] *= reactions.size
    converged = without_effect(model, work, scale, p, reactions)
    some = False
    for joint in range(len(reactions.unique)):
        unique = 1 if converged else 0
        for r in range(model.joints.row[joint], model.joints.row[joint + 1]):
            if abs(part[r]) > OPEN_PART * p[r]:
                unique = 0
        reactions.unique[joint] = unique
        some = some or unique == 0
    return some


@late_kernel
def take_least(model: Model, work: Workspace, reactions: Reactions) -> None:
    """Make ``reactions.mean`` that of the least norm where joints are redundant, and mark these.

    Where the turns do not converge, all are marked and stay as they are.
    """
    scale = factorise_weighted(work, reactions)
    if mark(model, work, scale, reactions):
        p, part = reactions.rows, reactions.least
        multipliers(model, work, reactions)
        for _ in range(PASSES):
            if not without_effect(model, work, scale, p, reactions):
                break
            largest, taken = 0.0, 0.0
            for r in range(len(p)):
                p[r] -= part[r]
                largest = max(largest, abs(p[r]))
                taken = max(taken, abs(part[r]))
            for joint in range(len(reactions.mean)):
                if reactions.unique[joint] == 0:
                    force = reaction(model, work, joint, part)
                    for i in range(len(force)):
                        reactions.mean[joint, i] -= force[i]
            if not taken > SETTLED * largest:
                break
    factorise_joints(work.rows)
