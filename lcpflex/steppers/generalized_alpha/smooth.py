"""The smooth motion of a generalised-alpha step: Newton's method on accelerations, with contact forces.

See :mod:`lcpflex.steppers.generalized_alpha.stepper` for the scheme.
"""

from __future__ import annotations

import math

from lcpflex.contact.detection import detect
from lcpflex.contact.narrow_phase.feature import refresh
from lcpflex.dynamics.acceleration import (
    SLIDE_BACK,
    SLIDE_FORTH,
    SMOOTH as FRICTIONLESS,
    STICKING,
    pose_sets,
)
from lcpflex.dynamics.contact_problem import lay_contacts, list_tangents
from lcpflex.dynamics.delassus import apply_impulses, row_velocity
from lcpflex.dynamics.impulse import answer_joints
from lcpflex.dynamics.large_island import prepare_large
from lcpflex.dynamics.mechanics import (
    contact_biases,
    count_rows,
    factorise,
    fill_contact_rows,
    fill_joint_rows,
    forces,
    multiply,
    solve_rows,
    solve_vector,
    supply,
)
from lcpflex.dynamics.workspace import Workspace
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.jit.leaf import in_space
from lcpflex.kinematics.configuration import advance
from lcpflex.kinematics.modal_places import first_mode, first_rate
from lcpflex.model.arrays import Model
from lcpflex.steppers.event_driven.memory import copy_entry
from lcpflex.steppers.generalized_alpha.memory import (
    POSITION,
    SMOOTH,
    AlphaScheme,
    EndForces,
    hold,
)
from lcpflex.steppers.generalized_alpha.mixing import go_on_from, mix
from lcpflex.steppers.recorder import Recorder

__all__ = ["apply_smooth", "assemble_rows", "gather_resting", "pose_smooth", "slip_mode"]

MOST_PASSES = 15  # of Newton's method on the smooth motion
SETTLED = 1e-11  # change of an acceleration, relative to the largest, at which Newton's method has converged
MISSED = 1e-9  # the same of passes that are combined, where it does not become less
SLOW = 0.1  # change over the last one from which on passes are combined, where no contact may open or slip instead
DOUBTFUL = 1e-6  # change at which it has not after the last pass


@kernel
def place_end(model: Model, h: float, scheme: AlphaScheme) -> None:
    """Smooth motion to the end of a step of length h, from the iterate of the acceleration there."""
    u, way = scheme.u, scheme.mean
    am, af = scheme.alpha_m, scheme.alpha_f
    beta, gamma = scheme.beta, scheme.gamma
    for i in range(len(u)):
        a = scheme.a[i]
        a_new = ((1.0 - af) * scheme.w_new[i] + af * scheme.w[i] - am * a) / (1.0 - am)
        scheme.a_new[i] = a_new
        way[i] = u[i] + h * ((0.5 - beta) * a + beta * a_new)
        scheme.v_new[i] = u[i] + h * ((1.0 - gamma) * a + gamma * a_new)
    advance(model, scheme.q, way, h, scheme.q_new)


@in_space("lcpflex.steppers.spatial.alpha")
@kernel
def gather_resting(model: Model, work: Workspace, scheme: AlphaScheme) -> int:
    """Contacts closed at rest at the start of the step, with their modes; returns how many pairs are closed."""
    q, u = scheme.q, scheme.u
    scheme.n_found = 0
    found = detect(model, q, scheme.gap_tolerance, work.rows.table)
    if found == 0 or found > len(work.rows.table.key):
        return found
    n_joint = len(work.scratch.residual)
    n_tangent = fill_contact_rows(model, q, found, n_joint, work.rows)
    kept = 0
    j = 0
    for k in range(found):
        frictional = j < n_tangent and work.rows.tangent[j] == k
        if abs(row_velocity(work.rows.J, work.rows.body, n_joint + k, work.rows.dof, u)) <= scheme.velocity_threshold:
            mode = FRICTIONLESS
            if frictional:
                slip = row_velocity(work.rows.J, work.rows.body, n_joint + found + j, work.rows.dof, u)
                mode = slip_mode(slip, scheme.velocity_threshold)
            copy_entry(work.rows.table, k, work.rows.table, kept)
            scheme.sets.mode[kept] = mode
            kept += 1
        if frictional:
            j += 1
    scheme.n_found = kept
    return found


@kernel
def slip_mode(slip: float, threshold: float) -> int:
    """STICKING, SLIDE_FORTH or SLIDE_BACK."""
    if abs(slip) <= threshold:
        return STICKING
    return SLIDE_FORTH if slip > 0.0 else SLIDE_BACK


@kernel
def assemble_rows(
    model: Model, t: float, alpha_c: float, alpha_k: float, n: int, work: Workspace, scheme: AlphaScheme
) -> int:
    """Factorise and lay all rows at the end of the step; returns the tangential ones."""
    q = scheme.q_new
    n_joint = len(work.scratch.residual)
    supply(model, t, q, scheme.v_new, work)
    factorise(model, q, alpha_c, alpha_k, work)
    if n_joint > 0:
        fill_joint_rows(model, t, q, scheme.v_new, work.free.external, work.rows)
    for k in range(n):
        refresh(model, q, work.rows.table, k)
    n_tangent = fill_contact_rows(model, q, n, n_joint, work.rows)
    solve_rows(model, work.rows, 0, n_joint + n + n_tangent)
    count_rows(work.rows, n_joint, n, n_tangent)
    return n_tangent


@kernel
def restart_damping(model: Model, scheme: AlphaScheme) -> float:
    """By how much a first acceleration w counts in the damping forces -C (u + this w) that it begins from [s].

    Its own acceleration -c u reverses the velocity of a mode within a step where (1 - gamma) h c > 1, and the scheme
    would throw it to and fro ever farther from impact to impact. There damping is that of the velocity at gamma h from
    the start, else 0. What is damped less changes in that one step by a term of second order in h.
    """
    reverses = 1.0 / ((1.0 - scheme.gamma) * scheme.step) if scheme.gamma < 1.0 else math.inf
    for k in range(len(model.bodies.damping)):
        if model.bodies.damping[k] > reverses:
            return scheme.gamma * scheme.step
    return 0.0


@kernel
def damp_restart(model: Model, scheme: AlphaScheme, out: FloatArray) -> None:
    """Add what the first acceleration counts in the damping forces to these."""
    ahead, bodies = restart_damping(model, scheme), model.bodies
    if ahead == 0.0:
        return
    for b in range(len(bodies.mass)):
        first = first_rate(model, b)
        own = first_mode(model, b)
        for i in range(bodies.dof[b + 1] - first):
            out[first + i] -= ahead * bodies.damping[own + i] * scheme.w_new[first + i]


@kernel
def pose_smooth(model: Model, h: float, t: float, work: Workspace, scheme: AlphaScheme) -> int:
    """Newton's equation for udot at t + h, with joints and resting contacts at acceleration level.

    h = 0 asks for the acceleration at t itself.
    """
    n = scheme.n_found
    if scheme.turn == 0:
        found = 0
        scheme.n_found = 0
        if scheme.skip == 0:
            found = gather_resting(model, work, scheme)
            if found > len(work.rows.table.key):
                return found
        n = scheme.n_found
        for i in range(len(scheme.w)):
            scheme.w_new[i] = scheme.w[i]
    place_end(model, h, scheme)
    alpha_c = h * scheme.gamma * (1.0 - scheme.alpha_f) / (1.0 - scheme.alpha_m)
    if h == 0.0:
        alpha_c = restart_damping(model, scheme)
        if alpha_c > 0.0:  # damping counts with all of the first acceleration, not with its change
            scheme.w_new[:] = 0.0
    alpha_k = h * h * scheme.beta * (1.0 - scheme.alpha_f) / (1.0 - scheme.alpha_m)
    n_tangent = assemble_rows(model, t + h, alpha_c, alpha_k, n, work, scheme)
    n_joint = work.rows.n_joint
    forces(model, t + h, scheme.q_new, scheme.v_new, work)
    contact_biases(model, scheme.q_new, scheme.v_new, n, n_tangent, n_joint, work.rows)
    multiply(model, scheme.q_new, scheme.w_new, work, scheme.momentum)
    for i in range(len(scheme.w)):
        work.free.u[i] = work.free.total[i] - scheme.momentum[i]
    solve_vector(model, work, work.free.u)
    for i in range(len(scheme.w)):
        work.free.u[i] += scheme.w_new[i]
    for r in range(n_joint + n + n_tangent):
        work.free.v[r] = row_velocity(work.rows.J, work.rows.body, r, work.rows.dof, work.free.u) + work.rows.bias[r]
    for r in range(n + n_tangent):
        work.free.terms[r] = 0.0
    lay_contacts(work)
    prepare_large(model, work)
    scheme.warm = pose_modes(model, alpha_c, work, scheme)
    return n


@in_space("lcpflex.steppers.spatial.alpha")
@kernel
def pose_modes(model: Model, alpha_c: float, work: Workspace, scheme: AlphaScheme) -> int:
    """Let the modes of contacts count in the problems just laid; 1: all with friction stick, begin from the last step.

    alpha_c: dv/dw of the velocity at the end of the step [s], which slip that turns asks for in space.
    """
    list_tangents(work.rows, scheme.sets.tangent_of)
    return 1 if pose_sets(work, scheme.sets) == work.rows.n_tangents else 0


@kernel
def add_row(work: Workspace, r: int, p: float, out: FloatArray) -> None:
    """out += rows_r p."""
    for i in range(2):
        b = work.rows.body[r, i]
        if b >= 0:
            d = work.rows.dof[b]
            for k in range(work.rows.dof[b + 1] - d):
                out[d + k] += work.rows.J[r, i, k] * p


@kernel
def note_smooth(work: Workspace, scheme: AlphaScheme, at: EndForces, recorder: Recorder) -> None:
    """Hold the resting contacts with their forces, and the forces that do work, at one end of the step."""
    n_joint = work.rows.n_joint
    at.contact[:, :] = 0.0
    scheme.resting.count = 0
    for i in range(len(scheme.v_new)):
        at.friction[i] = 0.0
        at.normal[i] = 0.0
        at.damping[i] = work.free.dissipative[i]
        at.drive[i] = work.free.driving[i]
        at.conservative[i] = work.free.conservative[i]
    for r in range(n_joint):
        if work.rows.rate[r] != 0.0:
            add_row(work, r, work.impulses.p[r], at.drive)
    note_resting(work, scheme, at, recorder)


@in_space("lcpflex.steppers.spatial.alpha")
@kernel
def note_resting(work: Workspace, scheme: AlphaScheme, at: EndForces, recorder: Recorder) -> None:
    """Hold the contacts that carry with their forces, and add these to ``at``."""
    n_joint, n, resting = work.rows.n_joint, work.rows.n_contacts, scheme.resting
    for k in range(n):
        normal = work.impulses.p[n_joint + k]
        if normal <= 0.0:
            continue
        tangential = 0.0
        add_row(work, n_joint + k, normal, at.normal)
        if scheme.sets.tangent_of[k] >= 0:
            r = n_joint + n + scheme.sets.tangent_of[k]
            tangential = work.impulses.p[r]
            add_row(work, r, tangential, at.friction)
        at.contact[work.rows.table.law[k], 0] += normal
        at.contact[work.rows.table.law[k], 1] += tangential
        hold(work.rows.table, k, normal, scheme.sets.mode[k], resting)
        resting.load[resting.count - 1, 1] = tangential


@kernel
def settled(model: Model, h: float, work: Workspace, scheme: AlphaScheme) -> bool:
    """Take over the new iterate; whether Newton's method is done."""
    mixing = scheme.mixing
    largest = 0.0
    for i in range(len(scheme.w)):
        largest = max(largest, abs(work.free.u[i]))
    total = work.rows.n_joint + work.rows.n_contacts + work.rows.n_tangents
    apply_impulses(work.rows.solved, work.rows.body, 0, total, work.impulses.p, work.rows.dof, work.free.u)
    change = 0.0
    for i in range(len(scheme.w)):
        largest = max(largest, abs(work.free.u[i]))
        change = max(change, abs(work.free.u[i] - scheme.w_new[i]))
    turn = scheme.turn
    rate = 1.0 if turn == 0 else change / scheme.change
    scheme.change = change
    scheme.turn = turn + 1
    if turn == 0:
        mixing.count = 0
    mixed = mixing.count > 0
    ahead = 1.0 if mixed else min(rate, 1.0)  # of a combination the change does not tell what the next will be
    done = h == 0.0 or change * ahead <= SETTLED * largest
    if not done:
        doubtful = MISSED if mixed else DOUBTFUL
        stalled = turn >= 3 and rate > 0.7 and change <= doubtful * largest  # what is left is rounding
        if turn + 1 >= MOST_PASSES and change > DOUBTFUL * largest:
            scheme.unsettled += 1
        done = stalled or turn + 1 >= MOST_PASSES
    if not done and work.rows.n_contacts == 0 and turn >= 2 and (mixed or rate > SLOW):
        mix(model, work, scheme)
    else:
        go_on_from(work, scheme)
    return done


@kernel
def apply_smooth(model: Model, h: float, work: Workspace, scheme: AlphaScheme, recorder: Recorder) -> None:
    """A Newton step; after the last one what the next problem needs."""
    answer_joints(work)
    if not settled(model, h, work, scheme):
        return
    place_end(model, h, scheme)
    scheme.turn = 0
    scheme.skip = 0
    if h == 0.0:
        note_smooth(work, scheme, scheme.start, recorder)
        damp_restart(model, scheme, scheme.start.damping)
        for law in range(len(scheme.recursive)):
            for i in range(scheme.recursive.shape[1]):
                scheme.recursive[law, i] = scheme.start.contact[law, i]
        for i in range(len(scheme.w)):
            scheme.w[i] = scheme.w_new[i]
            scheme.a[i] = scheme.w_new[i]
        scheme.phase = SMOOTH
        return
    note_smooth(work, scheme, scheme.end, recorder)
    scheme.phase = POSITION
    scheme.pressed.count = 0
    resting = scheme.resting
    for i in range(resting.count):
        hold(resting.table, i, 0.5 * h * resting.load[i, 0], resting.mode[i], scheme.pressed)
