"""A Moreau-Jean step and its record.

See :mod:`lcpflex.steppers.moreau_jean.stepper` for the scheme.
"""

from __future__ import annotations

import math
from typing import Any

from lcpflex.contact.detection import ContactTable, detect
from lcpflex.contact.narrow_phase.feature import refresh
from lcpflex.contact.rows import contact_point
from lcpflex.dynamics.contact_forces import elastic_energy
from lcpflex.dynamics.contact_forces_friction import add_balanced_forces, compare_friction, forces_after
from lcpflex.dynamics.contact_forces_history import update_history
from lcpflex.dynamics.delassus import row_velocity
from lcpflex.dynamics.impulse import add_impulses, answer_joints, pose, recall_joints
from lcpflex.dynamics.inertia import stiffened
from lcpflex.dynamics.islands import unfinished
from lcpflex.dynamics.joint_reactions import compare_reactions, lay_reactions, note_step
from lcpflex.dynamics.mechanics import (
    contact_biases,
    count_rows,
    factorise,
    fill_contact_rows,
    fill_joint_rows,
    forces,
    solve_rows,
    solve_vector,
    supply,
)
from lcpflex.dynamics.touches import note_touches
from lcpflex.dynamics.workspace import Workspace
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.jit.leaf import in_space
from lcpflex.kinematics.configuration import advance
from lcpflex.model.arrays import Model
from lcpflex.model.planar import N_RIGID
from lcpflex.steppers.clock import StepClock, StepCount
from lcpflex.steppers.island_problems import shorten_forces, solve_islands
from lcpflex.steppers.moreau_jean.memory import MoreauJeanScheme
from lcpflex.steppers.moreau_jean.strikes import follow_order, held_within, keep_closed, struck
from lcpflex.steppers.passing import set_out
from lcpflex.steppers.projection import project_contacts, project_joints
from lcpflex.steppers.recorded_contacts import (
    add_compliant_impulse,
    add_impulse,
    friction_state,
    note_compliant,
    note_contact,
)
from lcpflex.steppers.recorder import Recorder, all_indent, note_gain, store_contacts, store_state
from lcpflex.steppers.scheme import NO_FACTOR, end_step, record, take_step
from lcpflex.steppers.status import RunStatus
from lcpflex.steppers.strike_order import add_strikes, apply_strike, end_order

__all__ = ["record_impulses"]

STICKING_SPEED = 1e-9  # [m/s] of a touching point on its cone: up to that it counts as sticking in the record


@in_space("lcpflex.steppers.spatial.closed")
@kernel
def find_closed(model: Model, q: FloatArray, tolerance: float, table: ContactTable) -> int:
    """Contacts with gap <= tolerance [m]; how many, as ``detect``."""
    return detect(model, q, tolerance, table)


@kernel
def predict(model: Model, scheme: MoreauJeanScheme, t: float, work: Workspace) -> int:
    """First half of a step: free motion, closed contacts, and the problem they pose. Returns the contacts found."""
    free, rows = work.free, work.rows
    q, u, h = scheme.q, scheme.u, scheme.step
    lean = scheme.theta * h
    advance(model, q, u, lean, free.middle)
    advance(model, q, u, scheme.activation * h, free.ahead)
    within = held_within(scheme) if work.impulses.n_held > 0 else scheme.gap_tolerance
    n = find_closed(model, free.ahead, within, rows.table)
    if n > len(rows.table.key):
        return n
    if within > scheme.gap_tolerance:
        n = keep_closed(scheme.gap_tolerance, n, work)
    if scheme.activation != scheme.theta:
        for k in range(n):
            refresh(model, free.middle, rows.table, k)
    supply(model, t + lean, free.middle, u, work)
    forces(model, t + lean, free.middle, u, work)
    factorise(model, free.middle, lean, lean * lean, work)
    add_balanced_forces(model, t + lean, free.middle, u, h, work)
    spare_spin(model, lean, u, work)
    for i in range(len(u)):
        free.u[i] = h * free.total[i]
    solve_vector(model, work, free.u)
    for i in range(len(u)):
        free.u[i] += u[i]
    n_joint = len(work.scratch.residual)
    if n_joint > 0:
        fill_joint_rows(model, t + lean, free.middle, u, free.external, rows)
    n_tangent = fill_contact_rows(model, free.middle, n, n_joint, rows)
    contact_biases(model, free.middle, u, n, n_tangent, n_joint, rows)
    solve_rows(model, rows, 0, n_joint + n + n_tangent)
    count_rows(rows, n_joint, n, n_tangent)
    pose(model, work, u, (1.0 - scheme.theta) * h, scheme.velocity_threshold)
    if not turn_on(model, scheme.gyroscopic, h, u, work):
        scheme.unsettled += 1
    if n > 1:
        follow_order(model, scheme, work)
    return n


@in_space("lcpflex.dynamics.spatial.gyroscopic")
@kernel
def turn_on(model: Model, passes: int, h: float, u: FloatArray, work: Workspace) -> bool:
    """Correct the problem posed for inertial forces, which change within the step: in the plane, nothing.

    In space omega x J omega, taken at the start of a step alone, gains energy. False where several ``passes`` have not
    sufficed.
    """
    return True


@in_space("lcpflex.dynamics.spatial.gyroscopic")
@kernel
def spare_spin(model: Model, lean: float, u: FloatArray, work: Workspace) -> None:
    """Take the mean of a ringing body's torque 2 omega q^T G qdot, which has none, off the total force.

    With q + lean qdot and qdot it has 2 omega lean qdot^T G qdot, and would spin up a stiffened body step by step.
    """
    bodies = model.bodies
    for b in range(len(bodies.mass)):
        if bodies.geometric_start[b + 1] > bodies.geometric_start[b]:
            d = bodies.dof[b]
            rates = u[d + N_RIGID : bodies.dof[b + 1]]
            work.free.total[d + 2] -= 2.0 * lean * u[d + 2] * stiffened(bodies, b, rates, rates)


@kernel
def audit(model: Model, scheme: MoreauJeanScheme, t: float, work: Workspace, recorder: Recorder) -> None:
    """Add the step's work by kind, with the mean velocity (u + u+)/2, and its impulses to the recorder.

    ``work.free.u`` holds u+. Work of an impulse p on a row: p (w . u + w . u+)/2.
    """
    rows, free, counts = work.rows, work.free, recorder.counts
    u = scheme.u
    n_joint = rows.n_joint
    half = 0.5 * scheme.step
    for i in range(len(u)):
        both = u[i] + free.u[i]
        counts.lost_damping -= half * free.dissipative[i] * both
        counts.supplied += half * free.driving[i] * both
    contacts = work.compliant
    note_touches(contacts, scheme.step)
    for i in range(len(contacts.friction)):
        lost = half * contacts.friction[i] * (u[i] + free.u[i])
        counts.lost_friction -= lost
        counts.lost_damping += lost
    told = contacts.rows.n_contacts > 0 and all_indent(recorder)
    for k in range(contacts.rows.n_contacts):
        both = contacts.rate[k]
        both += row_velocity(contacts.rows.J, contacts.rows.body, contacts.rows.n_joint + k, contacts.rows.dof, free.u)
        lost = half * (contacts.p[k, 0] - contacts.elastic[k]) * both
        counts.lost_impacts -= lost
        counts.lost_damping += lost
        if told:
            counts.worst_penetration = max(counts.worst_penetration, -contacts.rows.table.gap[k])
        add_compliant_impulse(contacts, k, scheme.step, recorder)
    for r in range(n_joint):
        p = work.impulses.p[r]
        if p != 0.0 and rows.rate[r] != 0.0:
            before = row_velocity(rows.J, rows.body, r, rows.dof, u)
            after = row_velocity(rows.J, rows.body, r, rows.dof, free.u)
            counts.supplied += 0.5 * p * (before + after)
    gained = audit_contacts(u, work, recorder)
    note_gain(recorder, t, gained)
    if len(recorder.reactions.impulse) > 0:
        hit = rows.n_contacts > 0 and struck(model, scheme, work, recorder.reactions)
        note_step(model, work, scheme.step, hit, recorder.reactions)


@in_space("lcpflex.steppers.spatial.audit")
@kernel
def audit_contacts(u: FloatArray, work: Workspace, recorder: Recorder) -> float:
    """Add the work and the impulses of all contact rows to the recorder; what their impulses gained [J]."""
    rows = work.rows
    n_joint, n = rows.n_joint, rows.n_contacts
    gained = 0.0
    for r in range(n_joint, n_joint + n + rows.n_tangents):
        p = work.impulses.p[r]
        if p == 0.0:
            continue
        before = row_velocity(rows.J, rows.body, r, rows.dof, u)
        after = row_velocity(rows.J, rows.body, r, rows.dof, work.free.u)
        done = 0.5 * p * (before + after)
        gained += done
        if r < n_joint + n:
            recorder.counts.lost_impacts -= done
        else:
            recorder.counts.lost_friction -= done
        add_impulse(work, r - n_joint, p, recorder)
    return gained


@kernel
def correct(model: Model, scheme: MoreauJeanScheme, t: float, work: Workspace, recorder: Recorder) -> bool:
    """Second half of a step: impulses, then u+ and q+ in place. False where they are not finite: u and q stay, then."""
    q, u, h = scheme.q, scheme.u, scheme.step
    theta = scheme.theta  # numbers of structs are read again behind each store: not in loops over coordinates
    answer_joints(work)
    recall_joints(work)
    add_impulses(work, work.free.u)
    if scheme.order.rounds > 0:
        add_strikes(work, scheme.order)
    for i in range(len(u)):
        if not math.isfinite(work.free.u[i]):
            return False
    audit(model, scheme, t, work, recorder)
    end_order(scheme.order)
    compare_friction(work.free.u, h, work)
    largest = 0.0
    for i in range(len(u)):
        u[i] = theta * work.free.u[i] + (1.0 - theta) * u[i]
    advance(model, q, u, h, q)
    for i in range(len(u)):
        u[i] = work.free.u[i]
    for i in range(len(q)):
        largest = max(largest, abs(q[i]))
        if not math.isfinite(q[i]):
            return False
    tolerance = 1e-12 * (1.0 + largest)
    project_joints(model, t + h, q, u, work, recorder, tolerance)
    stay = held_within(scheme)
    if project_contacts(model, h, scheme.gap_tolerance, stay, scheme.projection == 1, q, work, recorder):
        project_joints(model, t + h, q, u, work, recorder, tolerance)
    return True


@record.of(MoreauJeanScheme)
@kernel
def record_impulses(model: Model, scheme: Any, t: float, work: Workspace, recorder: Recorder) -> int:
    """Store the present instant; contact forces are the impulses of the last step over its length."""
    q, u, step = scheme.q, scheme.u, scheme.step
    loaded = work.rows.n_contacts > 0 and len(recorder.reactions.impulse) > 0
    if loaded:
        lay_reactions(model, work, recorder.reactions.change)
    done = shorten_forces(work)
    if loaded:
        compare_reactions(model, work, recorder.rates.now, recorder.reactions)
    if not done:
        return NO_FACTOR
    needed = store_contacts(model, q, recorder)
    if needed > len(recorder.table.key):
        return needed
    note_impulses(model, q, u, step, work, recorder)
    if len(work.compliant.friction) > 0:
        forces_after(model, q, u, work)
        note_compliant(model, q, work.compliant, False, recorder)
    store_state(model, t, q, u, work, elastic_energy(model, work.compliant), recorder)
    return needed


@in_space("lcpflex.steppers.spatial.records")
@kernel
def note_impulses(model: Model, q: FloatArray, u: FloatArray, step: float, work: Workspace, recorder: Recorder) -> None:
    """Add the touching points of the step to the instant about to be stored."""
    rows = work.rows
    n_joint = rows.n_joint
    n = rows.n_contacts
    tangent = 0
    for k in range(n):
        p_t = 0.0
        slip = 1.0
        if tangent < rows.n_tangents and rows.tangent[tangent] == k:
            r = n_joint + n + tangent
            p_t = work.impulses.p[r]
            slip = row_velocity(rows.J, rows.body, r, rows.dof, u)
            tangent += 1
        p_n = work.impulses.p[n_joint + k]
        if p_n > 0.0:
            state = friction_state(p_n, abs(p_t), rows.mu[k], abs(slip), STICKING_SPEED)
            place = contact_point(model, q, rows.table, k)
            note_contact(recorder, rows.table.law[k], place, rows.table.normal[k], p_n / step, p_t / step, state)


@take_step.of(MoreauJeanScheme)
@kernel
def moreau_jean_step(
    model: Model, scheme: MoreauJeanScheme, t: float, work: Workspace, recorder: Recorder, clock: StepCount | StepClock
) -> int:
    """Predict, detect and pose, solve, correct; from the problem on that was not solved, if one was not."""
    while True:
        if not unfinished(work.posed.islands):
            set_out(scheme.q, recorder)
            clock.number = predict(model, scheme, t, work)
            if clock.number > len(work.rows.table.key):
                return RunStatus.GROW
        warm = last = scheme.order.goes_on == 0
        status = solve_islands(work, t, scheme.tolerance, warm, last, recorder)
        if status != RunStatus.DONE:
            clock.number = work.impulses.number
            return status
        if last:
            break
        apply_strike(work, scheme.order)
    work.impulses.unsolved = 0  # of the next step
    if not correct(model, scheme, t, work, recorder):
        return RunStatus.NOT_FINITE
    return RunStatus.DONE


@end_step.of(MoreauJeanScheme)
@kernel
def note_compliant_contacts(model: Model, scheme: MoreauJeanScheme, t: float, explicit: bool, work: Workspace) -> bool:
    """Compliant contacts take note of the end of a step."""
    return update_history(model, t, scheme.q, scheme.u, 0.0, explicit, work.compliant.states, work)
