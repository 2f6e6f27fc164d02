"""Drift of closed contacts in space, taken out of the configuration after a step."""

from __future__ import annotations

from typing import Any

from lcpflex.dynamics.contact_problem import pose_rows
from lcpflex.dynamics.joint_response import row_product
from lcpflex.dynamics.large_island import describe_island as describe_bodies, is_large
from lcpflex.dynamics.spatial.contact_problem import has_joints
from lcpflex.dynamics.spatial.inertia import SpatialWork
from lcpflex.dynamics.spatial.mechanics import displace
from lcpflex.jit.kernel import FloatArray, kernel, late_kernel
from lcpflex.model.spatial import SpatialModel
from lcpflex.solvers.contact.algebra import IN_SPACE, along_normal, put
from lcpflex.solvers.contact.large.solving import ROOM, solve_large
from lcpflex.solvers.contact.laws import HALF_LINE
from lcpflex.solvers.contact.operators import begin
from lcpflex.solvers.contact.sweeping import sweep
from lcpflex.steppers.projection import begin_lift, end_lift

__all__ = ["lift_island"]

SWEEPS = 200
ENOUGH = 1e-6  # of the largest drift: what may be left for the next step


@kernel
def lift_island(model: SpatialModel, work: SpatialWork, i: int, q: FloatArray) -> bool:
    """Lift the sunk contacts of island i; whether there were any, and it could be done.

    The frictionless problem of their normals, 0 <= z _|_ G_NN z + drift >= 0, by sweeps, joints held.
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
    describe_lift(work, i, m, held)
    group, like = work.impulses.solver.group, IN_SPACE
    if held:
        begin(work.impulses.solver.dense, group, group.p, like)
        sweep(work.impulses.solver.dense, group, like, SWEEPS, ENOUGH * deepest)
    else:
        begin(work.impulses.solver.scene, group, group.p, like)
        sweep(work.impulses.solver.scene, group, like, SWEEPS, ENOUGH * deepest)
    for e in range(group.n):
        work.scratch.multipliers[work.impulses.solver.scene.normal[e]] = group.p[e, 0]
    displace(model, work.rows, n_joint, n_joint + work.rows.n_contacts, work.scratch.multipliers, q)
    return True


@kernel
def describe_lift(work: SpatialWork, i: int, m: int, held: bool) -> None:
    """The m contacts ``closed`` of island i as units without friction, gaps for velocities; with joints, posed.

    Forces in their units are the gaps that they open. One that no force moves is left alone.
    """
    group, scene, dense = work.impulses.solver.group, work.impulses.solver.scene, work.impulses.solver.dense
    part, first, n_joint = work.posed.part, work.posed.islands.start[i], work.rows.n_joint
    for e in range(m):
        k = work.posed.islands.contact[first + work.scratch.closed[e]]
        scene.normal[e], scene.tangent[e] = n_joint + k, -1
        if held:
            part[3 * e], part[3 * e + 1], part[3 * e + 2] = k, -1, -1
    if held:
        dense.m = 3 * m
        pose_rows(work, dense.m, dense.columns, dense.free)
    group.n = m
    for e in range(m):
        r = scene.normal[e]
        own = dense.columns[3 * e, 3 * e] if held else row_product(work.rows, r, 0, r) + row_product(work.rows, r, 1, r)
        gap = work.scratch.drift[e] if own > 0.0 else 0.0
        group.law[e], group.floor[e], group.own[e, 0] = HALF_LINE, 0.0, own
        group.unit[e] = 1.0 / own if own > 0.0 else 1.0
        put(group.free, e, along_normal(gap, IN_SPACE))
        put(group.p, e, IN_SPACE)
        if held:
            dense.free[3 * e] = gap


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
