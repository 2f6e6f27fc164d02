"""Drift of joints and of closed contacts, taken out of the configuration after a step: projection, not springs.

The metric is the matrix of the step, so that stiff modes follow statically.
"""

from __future__ import annotations

from lcpflex.contact.narrow_phase.feature import refresh
from lcpflex.contact.table import entry_of
from lcpflex.dynamics.contact_problem import pose_island
from lcpflex.dynamics.delassus import row_velocity
from lcpflex.dynamics.joint_response import solve_joints
from lcpflex.dynamics.large_island import describe_island, is_large
from lcpflex.dynamics.mechanics import displace, supply
from lcpflex.dynamics.workspace import Workspace
from lcpflex.jit.kernel import FloatArray, kernel, late_kernel
from lcpflex.jit.leaf import in_space
from lcpflex.kinematics.joint_rows import joint_residual
from lcpflex.model.arrays import Model
from lcpflex.solvers.contact.algebra import PLANAR
from lcpflex.solvers.contact.compiled import solve_normals
from lcpflex.solvers.contact.large.solving import ROOM, solve_large
from lcpflex.steppers.recorder import Recorder

__all__ = ["begin_lift", "end_lift", "project_contacts", "project_joints"]


@kernel
def project_joints(
    model: Model, t: float, q: FloatArray, u: FloatArray, work: Workspace, recorder: Recorder, tolerance: float
) -> None:
    """q += A^-1 J^T d until |phi(q, t)| <= tolerance, with the rows of the step (a simplified Newton method)."""
    scratch = work.scratch
    n_joint = len(scratch.residual)
    if n_joint == 0:
        return
    supply(model, t, q, u, work)
    for _ in range(8):
        joint_residual(model, t, q, work.free.external, scratch.residual)
        drift = 0.0
        for j in range(n_joint):
            drift = max(drift, abs(scratch.residual[j]))
        if drift <= tolerance:
            break
        for j in range(n_joint):
            scratch.multipliers[j] = -scratch.residual[j]
        solve_joints(work.rows, scratch.multipliers)
        displace(model, work.rows, 0, n_joint, scratch.multipliers, q)
    recorder.counts.worst_drift = max(recorder.counts.worst_drift, drift)


@kernel
def hold_contacts(step: float, tolerance: float, stay: float, active: bool, work: Workspace, recorder: Recorder) -> int:
    """Note in ``scratch.sunk`` how far contacts are below the gap they closed at; their number, 0 unless ``active``.

    ``stay`` [m]: gap up to which they stay closed.

    ``work.free.u`` holds u+. A pair closes somewhere within its step, up to h |gdot| / 2 deep. To lift it from there
    would do work; to let it sink further, step by step over a curved surface, would have no bound.
    """
    rows, impulses = work.rows, work.impulses
    n_joint = rows.n_joint
    m = 0
    held = 0
    found = 0
    for k in range(rows.n_contacts):
        work.scratch.sunk[k] = 0.0
        gap = rows.table.gap[k]
        recorder.counts.worst_penetration = max(recorder.counts.worst_penetration, -gap)
        if impulses.p[n_joint + k] <= 0.0:
            continue
        before = entry_of(impulses.held_key[0], impulses.n_held, rows.table.key[k], found)
        found = before + 1 if before >= 0 else found
        target = min(gap, 0.0)  # of a contact that just closed; of others where it was when they did
        if before >= 0:
            target = max(impulses.held_gap[0, before], target)
        leaving = row_velocity(rows.J, rows.body, n_joint + k, rows.dof, work.free.u)
        if leaving * step > stay - gap:
            continue
        impulses.held_key[1, held] = rows.table.key[k]
        impulses.held_gap[1, held] = target
        held += 1
        if active and gap < target - tolerance:
            work.scratch.sunk[k] = gap - target
            m += 1
    for i in range(held):
        impulses.held_key[0, i] = impulses.held_key[1, i]
        impulses.held_gap[0, i] = impulses.held_gap[1, i]
    impulses.n_held = held
    return m


@kernel
def project_contacts(
    model: Model, step: float, tolerance: float, stay: float, active: bool, q: FloatArray, work: Workspace,
    recorder: Recorder,
) -> bool:  # fmt: skip
    """Take the drift out of contacts that stay closed; true where the configuration changed.

    min |dq|_A with W_N^T dq >= the drift of each: the frictionless LCP on their part of the condensed Delassus matrix.
    """
    for k in range(work.rows.n_contacts):
        refresh(model, q, work.rows.table, k)
    if hold_contacts(step, tolerance, stay, active, work, recorder) == 0:
        return False
    moved = False
    for i in range(work.posed.islands.count):
        moved = lift_island(model, work, i, q) or moved
    return moved


@in_space("lcpflex.steppers.spatial.projection")
@late_kernel
def lift_island(model: Model, work: Workspace, i: int, q: FloatArray) -> bool:
    """Lift the sunk contacts of island i; whether there were any, and it could be done."""
    scratch = work.scratch
    islands = work.posed.islands
    first = islands.start[i]
    m = 0
    for c in range(islands.start[i + 1] - first):
        if scratch.sunk[islands.contact[first + c]] != 0.0:
            scratch.closed[m] = c
            scratch.drift[m] = scratch.sunk[islands.contact[first + c]]
            m += 1
    if m == 0:
        return False
    if is_large(work, i):
        return lift_large_island(model, work, i, m, q)
    if islands.count > 1:
        pose_island(work, i, PLANAR)
    if solve_normals(work.posed.problem, scratch.closed, scratch.drift, m, work.impulses.solver) != 0:
        return False
    for c in range(m):
        r = work.rows.n_joint + islands.contact[first + scratch.closed[c]]
        scratch.multipliers[r] = scratch.drift[c]
        displace(model, work.rows, r, r + 1, scratch.multipliers, q)
    return True


@late_kernel
def lift_large_island(model: Model, work: Workspace, i: int, m: int, q: FloatArray) -> bool:
    """Lift the m contacts ``closed`` of a large island, its joints held: without friction, in place of impulses.

    The right-hand side and the impulses of the step come back, and the residual that the next step looks back to.
    """
    judged = work.impulses.large_solver.judged
    strict, residual = judged.strict, judged.residual
    describe_island(work, i)
    begin_lift(work, m)
    solved = (
        solve_large(work.posed.large, work.impulses.large_solver, PLANAR) != ROOM
    )  # as far as it goes: the rest is for the next step
    end_lift(model, work, m, solved, q)
    judged.strict, judged.residual = strict, residual
    return solved


@kernel
def begin_lift(work: Workspace, m: int) -> None:
    """The problem of the m contacts ``closed`` of the large island described; what it replaces is kept aside."""
    large, aside, first = work.posed.large, work.scratch.aside, work.rows.n_joint
    for c in range(m):
        large.normal_row[c] = large.normal_row[work.scratch.closed[c]]
        large.tangent_row[c] = -1
    large.n_contacts = m
    for r in range(m + large.n_joints):
        row = large.normal_row[r] if r < m else large.joint_row[r - m]
        aside[r, 0], aside[r, 1] = work.impulses.p[row], work.free.v[row]
        work.impulses.p[row] = 0.0
        work.free.v[row] = work.scratch.drift[r] if r < m else 0.0
        if r < m:
            aside[r, 2] = work.free.terms[row - first]
            work.free.terms[row - first] = 0.0


@kernel
def end_lift(model: Model, work: Workspace, m: int, solved: bool, q: FloatArray) -> None:
    """Move q by the lifts found, if they are; what :func:`begin_lift` has put aside comes back."""
    large, aside, first = work.posed.large, work.scratch.aside, work.rows.n_joint
    for r in range(m + large.n_joints):
        row = large.normal_row[r] if r < m else large.joint_row[r - m]
        if solved:
            displace(model, work.rows, row, row + 1, work.impulses.p, q)
        work.impulses.p[row], work.free.v[row] = aside[r, 0], aside[r, 1]
        if r < m:
            work.free.terms[row - first] = aside[r, 2]
