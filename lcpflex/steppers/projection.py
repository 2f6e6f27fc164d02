"""Drift of joints and of closed contacts, taken out of the configuration after a step: projection, not springs.

The metric is the matrix of the step, so that stiff modes follow statically.
"""

from __future__ import annotations

from lcpflex.contact.narrow_phase.feature import refresh
from lcpflex.dynamics.delassus import apply_impulses, row_velocity
from lcpflex.dynamics.mechanics import supply
from lcpflex.dynamics.workspace import Workspace
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.kinematics.joint_rows import joint_residual
from lcpflex.model.arrays import Model
from lcpflex.solvers.contact.compiled import solve_normals
from lcpflex.solvers.semidefinite import cholesky_solve
from lcpflex.steppers.recorder import Recorder

__all__ = ["project_contacts", "project_joints"]


@kernel
def project_joints(
    model: Model, t: float, q: FloatArray, u: FloatArray, work: Workspace, recorder: Recorder, tolerance: float
) -> None:
    """q += A^-1 J^T d until |phi(q, t)| <= tolerance, with the rows of the step (a simplified Newton method)."""
    n_joint = len(work.residual)
    if n_joint == 0:
        return
    supply(model, t, q, u, work)
    for _ in range(8):
        joint_residual(model, t, q, work.external, work.residual)
        drift = 0.0
        for j in range(n_joint):
            drift = max(drift, abs(work.residual[j]))
        if drift <= tolerance:
            break
        for j in range(n_joint):
            work.bias[j] = -work.residual[j]
        cholesky_solve(work.lower, n_joint, work.bias)
        apply_impulses(work.solved, work.row_body, 0, n_joint, work.bias, work.dof, q)
    recorder.counts.worst_drift = max(recorder.counts.worst_drift, drift)


@kernel
def held_at(work: Workspace, k: int) -> float:
    """Gap at which contact k is to be held: where it was when it closed; its present gap if it just did."""
    key = work.table.key[k]
    gap = min(work.table.gap[k], 0.0)
    for i in range(work.n_held):
        if work.held_key[0, i] == key:
            return max(work.held_gap[0, i], gap)
    return gap


@kernel
def hold_contacts(step: float, tolerance: float, active: bool, work: Workspace, recorder: Recorder) -> int:
    """Choose the contacts that have drifted below the gap they closed at; their number, 0 unless ``active``.

    ``work.free_u`` holds u+. A pair closes somewhere within its step, up to h |gdot| / 2 deep. To lift it from there
    would do work; to let it sink further, step by step over a curved surface, would have no bound.
    """
    n_joint = work.n_joint
    m = 0
    held = 0
    for k in range(work.n_contacts):
        gap = work.table.gap[k]
        recorder.counts.worst_penetration = max(recorder.counts.worst_penetration, -gap)
        if work.p[n_joint + k] <= 0.0:
            continue
        target = held_at(work, k)
        leaving = row_velocity(work.rows, work.row_body, n_joint + k, work.dof, work.free_u)
        if leaving * step > tolerance - gap:
            continue
        work.held_key[1, held] = work.table.key[k]
        work.held_gap[1, held] = target
        held += 1
        if active and gap < target - tolerance:
            work.closed[m] = k
            work.drift[m] = gap - target
            m += 1
    for i in range(held):
        work.held_key[0, i] = work.held_key[1, i]
        work.held_gap[0, i] = work.held_gap[1, i]
    work.n_held = held
    return m


@kernel
def project_contacts(
    model: Model, step: float, tolerance: float, active: bool, q: FloatArray, work: Workspace, recorder: Recorder
) -> bool:
    """Take the drift out of contacts that stay closed; true where the configuration changed.

    min |dq|_A with W_N^T dq >= the drift of each: the frictionless LCP on their part of the condensed Delassus matrix.
    """
    n_joint = work.n_joint
    for k in range(work.n_contacts):
        refresh(model, q, work.table, k)
    m = hold_contacts(step, tolerance, active, work, recorder)
    if m == 0:
        return False
    if solve_normals(work.problem, work.closed, work.drift, m, work.solver) != 0:
        return False
    for i in range(m):
        r = n_joint + work.closed[i]
        work.bias[r] = work.drift[i]
        apply_impulses(work.solved, work.row_body, r, r + 1, work.bias, work.dof, q)
    return True
