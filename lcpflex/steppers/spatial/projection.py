"""Drift of closed contacts in space, taken out of the configuration after a step."""

from __future__ import annotations

from typing import Any

from lcpflex.dynamics.contact_problem import pose_island
from lcpflex.dynamics.large_island import describe_island as describe_bodies, is_large
from lcpflex.dynamics.spatial.contact_problem import describe_island, has_joints
from lcpflex.dynamics.spatial.delassus import speeds
from lcpflex.dynamics.spatial.inertia import SpatialWork
from lcpflex.dynamics.spatial.mechanics import displace
from lcpflex.jit.kernel import FloatArray, kernel, late_kernel
from lcpflex.model.spatial import SpatialModel
from lcpflex.solvers.contact.algebra import IN_SPACE
from lcpflex.solvers.contact.large.solving import ROOM, solve_large
from lcpflex.solvers.contact.operators.scene import push_rows
from lcpflex.steppers.projection import begin_lift, end_lift

__all__ = ["lift_island"]

SWEEPS = 200
ENOUGH = 1e-6  # of the largest drift: what may be left for the next step


@kernel
def lift_island(model: SpatialModel, work: SpatialWork, i: int, q: FloatArray) -> bool:
    """Lift the sunk contacts of island i; whether there were any, and it could be done.

    The frictionless problem of their normals, 0 <= z _|_ G_NN z + drift >= 0, by projected Gauss-Seidel, joints held.
    """
    islands, n_joint = work.posed.islands, work.rows.n_joint
    first, m, deepest = islands.start[i], 0, 0.0
    for r in range(n_joint, n_joint + work.rows.n_contacts):
        work.scratch.multipliers[r] = 0.0
    for c in range(islands.start[i + 1] - first):
        sunk = work.scratch.sunk[islands.contact[first + c]]
        if sunk != 0.0:
            work.scratch.closed[m] = c
            work.scratch.drift[m] = sunk
            deepest = max(deepest, -sunk)
            m += 1
    if m == 0:
        return False
    held = has_joints(work, i)
    if held and is_large(work, i):
        return lift_in_bodies(model, work, i, m, q)
    if held:
        pose_island(work, i, IN_SPACE)
    else:
        describe_island(work, i)
    for d in range(len(work.impulses.solver.scene.x)):
        work.impulses.solver.scene.x[d] = 0.0
    for _ in range(SWEEPS):
        if lift_once(work, i, m, held) <= ENOUGH * deepest:
            break
    displace(model, work.rows, n_joint, n_joint + work.rows.n_contacts, work.scratch.multipliers, q)
    return True


@kernel
def lift_once(work: SpatialWork, i: int, m: int, held: bool) -> float:
    """One sweep over the m contacts ``closed``, lifts in ``multipliers``; the largest change of a gap."""
    islands, n_joint = work.posed.islands, work.rows.n_joint
    memory, lifts, G = work.impulses.solver, work.scratch.multipliers, work.posed.problem.delassus
    first, largest = islands.start[i], 0.0
    for e in range(m):
        c = work.scratch.closed[e]
        r = n_joint + islands.contact[first + c]
        gap = work.scratch.drift[e]
        own = G[3 * c, 3 * c] if held else memory.group.own[c, 0]
        if held:
            for f in range(m):
                gap += (
                    G[3 * c, 3 * work.scratch.closed[f]]
                    * lifts[n_joint + islands.contact[first + work.scratch.closed[f]]]
                )
        else:
            moved, _, _ = speeds(work.rows.J, work.rows.body, work.rows.dof, work.free.v, r, -1, memory.scene.x)
            gap += moved - work.free.v[r]
        if not own > 0.0:
            continue
        change = max(-lifts[r], -gap / own)
        if change != 0.0:
            lifts[r] += change
            largest = max(largest, abs(own * change))
            if not held:
                push_rows(work.rows.solved, work.rows.body, work.rows.dof, r, -1, change, 0.0, 0.0, memory.scene.x)
    return largest


@late_kernel
def lift_in_bodies(model: Any, work: SpatialWork, i: int, m: int, q: FloatArray) -> bool:
    """Lift the m contacts ``work.scratch.closed`` of a large island, its joints held, by the solver of large islands.

    Without friction, in place of impulses: these and the right-hand side of the step come back.
    """
    if len(work.rows.white) == 0:
        return False
    describe_bodies(work, i)
    begin_lift(work, m)
    solved = solve_large(work.posed.large, work.impulses.large_solver, IN_SPACE) != ROOM  # as far as it goes
    end_lift(model, work, m, solved, q)
    return solved
