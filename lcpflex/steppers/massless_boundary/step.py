"""The compiled step of the massless-boundary scheme (see
:class:`lcpflex.steppers.massless_boundary.stepper.MasslessBoundary`).

A step is made of equal parts, as many as stability asks for. Each part is predicted, its contact problem is solved, and
if the contacts that this closes do not admit its length, it is taken back and made shorter.
"""

from __future__ import annotations

import math

from lcpflex.contact.detection import detect
from lcpflex.contact.narrow_phase.feature import refresh
from lcpflex.dynamics.contact_compliance import ALL, HARD, choose, compliance_energy, misfit, note_depths
from lcpflex.dynamics.contact_problem import rows_of_each
from lcpflex.dynamics.delassus import apply_impulses, row_velocity
from lcpflex.dynamics.joint_reactions import lay_reactions, note_ends
from lcpflex.dynamics.joint_response import factorise_joints, solve_joints
from lcpflex.dynamics.mechanics import (
    factorise,
    fill_contact_rows,
    fill_joint_rows,
    forces,
    solve_rows,
    solve_vector,
    supply,
)
from lcpflex.dynamics.position import (
    given_energy,
    held_give,
    pose_position,
    solve_position,
    split_forces,
    static_response,
)
from lcpflex.dynamics.stable_step import admissible, admit, is_admitted
from lcpflex.dynamics.workspace import Workspace
from lcpflex.jit.kernel import kernel
from lcpflex.jit.leaf import in_space
from lcpflex.kinematics.configuration import advance as move, difference
from lcpflex.kinematics.modal_places import first_mode, first_rate
from lcpflex.model.arrays import Model
from lcpflex.steppers.clock import StepClock, StepCount
from lcpflex.steppers.massless_boundary.booked import audit, note_forces
from lcpflex.steppers.massless_boundary.memory import BoundaryScheme
from lcpflex.steppers.massless_boundary.reach import has_strayed, look_around
from lcpflex.steppers.massless_boundary.static_loads import book_loads, load_static_modes
from lcpflex.steppers.massless_boundary.stored import turn_back
from lcpflex.steppers.passing import set_out
from lcpflex.steppers.projection import project_joints
from lcpflex.steppers.recorder import Recorder, store_contacts, store_state
from lcpflex.steppers.scheme import record, take_step
from lcpflex.steppers.status import RunStatus

__all__ = ["short_enough"]

MOST_PASSES = 6  # of the contact problem in a step, each linearised about the static coordinates of the last
MOST_SETTLING = 40  # of them, where elastic laws of contacts are linearised, too
CURVED = 1e-3  # gap left by the linearisation, relative to the static displacement, that ends them
MOST_PARTS = 1000.0  # of a step; beyond, the contacts are all but rigid


@kernel
def predict(model: Model, scheme: BoundaryScheme, t: float, h: float, work: Workspace, recorder: Recorder) -> int:
    """q+ in ``work.free.middle`` and u_h in ``work.free.u``, at time t = end of the step; returns the contacts near."""
    q, u = scheme.q, scheme.u
    largest = 0.0
    for i in range(len(u)):
        work.free.u[i] = u[i] + 0.5 * h * scheme.acceleration[i]
        work.scratch.velocity[i] = work.free.u[i] + scheme.rate[i]
    for i in range(len(q)):
        largest = max(largest, abs(q[i]))
    move(model, q, work.scratch.velocity, h, work.free.middle)
    if h > 0.0 and len(work.scratch.residual) > 0:
        for i in range(len(q)):
            work.free.ahead[i] = work.free.middle[i]
        project_joints(model, t, work.free.middle, work.free.u, work, recorder, 1e-12 * (1.0 + largest))
        difference(model, work.free.ahead, work.free.middle, work.scratch.velocity)
        for i in range(len(u)):
            scheme.joined[i] = work.scratch.velocity[i] / h
            work.free.u[i] += scheme.joined[i]
    load_static_modes(model, scheme, t, work)
    margin = scheme.gap_tolerance + look_around(model, scheme, work)
    return detect(model, work.free.middle, margin, work.rows.table)


@kernel
def hold_joints(model: Model, t: float, h: float, scheme: BoundaryScheme, work: Workspace) -> float:
    """Change the acceleration such that u_h + h/2 a fulfils the joints; power of the drives [W].

    Without a step (h = 0) the acceleration itself fulfils them.
    """
    n_joint = len(work.scratch.residual)
    if n_joint == 0:
        return 0.0
    a = scheme.acceleration
    fill_joint_rows(model, t, work.free.middle, scheme.guess, work.free.external, work.rows)
    solve_rows(model, work.rows, 0, n_joint)
    factorise_joints(work.rows)
    for j in range(n_joint):
        work.impulses.p[j] = -row_velocity(work.rows.J, work.rows.body, j, work.rows.dof, a)
        if h > 0.0:
            velocity = row_velocity(work.rows.J, work.rows.body, j, work.rows.dof, work.free.u)
            work.impulses.p[j] -= 2.0 / h * (velocity + work.rows.rate[j])
        else:
            work.impulses.p[j] -= work.rows.bias[j]
    solve_joints(work.rows, work.impulses.p)
    apply_impulses(work.rows.solved, work.rows.body, 0, n_joint, work.impulses.p, work.rows.dof, a)
    power = 0.0
    for j in range(n_joint):
        power -= work.impulses.p[j] * work.rows.rate[j]
    return power


@in_space("lcpflex.steppers.spatial.massless_momenta")
@kernel
def carry_momenta(model: Model, scheme: BoundaryScheme, h: float, work: Workspace) -> None:
    """Change u_h such that u+ has the momenta that all but inertial forces leave: in the plane, nothing."""


@in_space("lcpflex.steppers.spatial.massless_momenta")
@kernel
def note_momenta(model: Model, scheme: BoundaryScheme, work: Workspace) -> None:
    """Keep the momenta at the end of the step, and what changes them, for the next one: in the plane, nothing."""


@kernel
def accelerate(model: Model, t: float, h: float, scheme: BoundaryScheme, work: Workspace) -> float:
    """a+ at ``work.free.middle`` under all forces but those of joints; modal damping is implicit.

    Velocities for the forces: u_h + h/2 a, to second order; the diagonal of the damping acts on u+ itself.
    """
    a = scheme.acceleration
    guess = scheme.guess
    for i in range(len(a)):
        guess[i] = work.free.u[i] + 0.5 * h * a[i]
    supply(model, t, work.free.middle, guess, work)
    forces(model, t, work.free.middle, guess, work)
    factorise(model, work.free.middle, 0.5 * h, 0.0, work)
    for i in range(len(a)):
        a[i] = work.free.total[i]
    for b in range(len(model.bodies.mass)):
        first = first_rate(model, b)
        own = first_mode(model, b)
        for k in range(work.rows.dof[b + 1] - first):
            a[first + k] += model.bodies.damping[own + k] * (guess[first + k] - work.free.u[first + k])
    n_joint = len(work.scratch.residual)
    total = n_joint + work.rows.n_contacts + work.rows.n_tangents
    apply_impulses(work.rows.J, work.rows.body, n_joint, total, work.impulses.p, work.rows.dof, a)
    for i in range(len(a)):
        if scheme.flexibility[i] > 0.0:
            a[i] = 0.0
    solve_vector(model, work, a)
    if h > 0.0:
        carry_momenta(model, scheme, h, work)
    return hold_joints(model, t, h, scheme, work)


@kernel
def closed(work: Workspace) -> int:
    """How many contacts the solution of the present problem closes."""
    count = 0
    for k in range(work.rows.n_contacts):
        if work.impulses.normal[k] > 0.0:
            count += 1
    return count


@kernel
def correct(model: Model, scheme: BoundaryScheme, t: float, h: float, work: Workspace, recorder: Recorder) -> bool:
    """Forces, accelerations and the state at the end t of the step, in place.

    False where they are not finite: the state of the start stays, then.
    """
    q, u = scheme.q, scheme.u
    # rows of the deformed surfaces: with others, forces do work that is not stored
    fill_contact_rows(model, work.free.middle, work.rows.n_contacts, len(work.scratch.residual), work.rows)
    soft = scheme.compliance.soft
    everywhere = scheme.compliance.some[0] == ALL  # all that there is to tell is indentation, then
    for k in range(work.rows.n_contacts):
        if everywhere or soft[work.rows.table.law[k]] == 0:  # an elastic law asks for its indentation
            recorder.counts.worst_penetration = max(recorder.counts.worst_penetration, -work.rows.table.gap[k])
    scheme.n_closed = closed(work)
    drives = accelerate(model, t, h, scheme, work)
    finite = True
    for i in range(len(q)):
        finite = finite and math.isfinite(work.free.middle[i])
    for i in range(len(u)):
        finite = finite and math.isfinite(work.free.u[i] + 0.5 * h * scheme.acceleration[i])
    if not finite:
        return False
    book_loads(model, h, scheme, work, recorder)
    difference(model, q, work.free.middle, scheme.rate)
    for i in range(len(q)):
        q[i] = work.free.middle[i]
    for i in range(len(u)):
        moved = scheme.flexibility[i] > 0.0 and h > 0.0 and scheme.n_closed > 0
        scheme.rate[i] = scheme.rate[i] / h if moved else 0.0
        u[i] = work.free.u[i] + 0.5 * h * scheme.acceleration[i]
    note_momenta(model, scheme, work)
    audit(h, drives, scheme, work, recorder)
    lay_reactions(model, work, recorder.reactions.ahead)
    note_ends(model, h, recorder.reactions)
    return True


@record.of(BoundaryScheme)
@kernel
def record_forces(model: Model, scheme: BoundaryScheme, t: float, work: Workspace, recorder: Recorder) -> int:
    """Store the present instant with its contact forces."""
    q, u = scheme.q, scheme.u
    needed = store_contacts(model, q, recorder)
    if needed > len(recorder.table.key):
        return needed
    note_forces(model, q, work, recorder)
    own = given_energy(model, work, scheme.flexibility, scheme.held_flexibility, scheme.compliance.soft)
    stored = compliance_energy(scheme.compliance, work) + own
    store_state(model, t, q, u, work, stored, recorder)
    turn_back(model, scheme, recorder)
    return needed


@kernel
def part_length(scheme: BoundaryScheme, clock: StepCount) -> float:
    """Length of the next part of the step [s]; 0 for the start, which only finds forces."""
    if clock.begun == 0:
        return 0.0
    remaining = scheme.step - clock.within
    return remaining / max(1.0, math.ceil(remaining / scheme.step * scheme.parts - 1e-9))


@kernel
def deform(model: Model, scheme: BoundaryScheme, work: Workspace) -> float:
    """Static coordinates by the solution; gap that the curvature of the geometry leaves in closed contacts.

    Relative to the largest static displacement of them. Those with a law of their own have a gap, see ``misfit``.
    """
    split_forces(work, scheme.unit)
    static_response(model, work, scheme.flexibility, scheme.load, work.free.middle)
    left = 0.0
    displaced = 0.0
    wide = rows_of_each(work)
    for k in range(work.rows.n_contacts):
        refresh(model, work.free.middle, work.rows.table, k)
        if work.impulses.normal[k] > 0.0 and (scheme.compliance.some[0] == 0 or work.scratch.closed[k] == HARD):
            give = held_give(model, work, scheme.flexibility, scheme.held_flexibility, work.rows.n_joint + k)
            left = max(left, abs(work.rows.table.gap[k] + give * work.impulses.normal[k]))
            own = work.posed.problem.delassus[wide * k, wide * k]
            displaced = max(displaced, scheme.unit[1] * own * work.impulses.normal[k])
    return left / displaced if displaced > 0.0 else 0.0


@kernel
def short_enough(model: Model, scheme: BoundaryScheme, h: float, work: Workspace) -> bool:
    """Whether the scheme is stable with steps h [s] and the contacts that the present problem closes."""
    square = (2.0 * scheme.safety / h) ** 2 - scheme.spring
    if square <= 0.0 or h * scheme.damper > scheme.safety:
        return False
    lasting = scheme.compliance.some[0] == 0  # stiffnesses of elastic laws change
    if lasting and is_admitted(scheme.held, work, square):
        return True
    found = admissible(model, work.free.middle, square, scheme.flexibility, scheme.unit, scheme.held, work)
    if found and lasting:
        admit(scheme.held, work, square)
    return bool(found)


@kernel
def divide_less(model: Model, scheme: BoundaryScheme, work: Workspace) -> None:
    """At the end of a step, where fewer contacts are closed than when it was divided: the parts that the next needs.

    Those that the contacts still closed admit. Their forces begin the next step: if that throws them open, its own
    problem has no contact that would object to its length, and a kick by h/2 of a contact force makes energy.
    """
    count = closed(work)
    if scheme.parts > scheme.least_parts and count < scheme.closed_then:
        parts = scheme.least_parts
        while parts < scheme.parts and not short_enough(model, scheme, scheme.step / parts, work):
            parts = more(parts, scheme)
        scheme.parts = min(parts, scheme.parts)
    scheme.closed_then = count


@kernel
def more(parts: float, scheme: BoundaryScheme) -> float:
    """The next number of parts to try."""
    return min(math.ceil(1.1 * parts + 0.1), scheme.most_parts)


@kernel
def solve_contact_forces(
    model: Model, scheme: BoundaryScheme, h: float, n: int, work: Workspace, clock: StepCount | StepClock
) -> int:
    """Contact forces at the end of a part of a step of length h, n contacts near; DONE, or why they are not known.

    PART: the part is too long for what it closes.
    """
    choose(model, scheme.compliance, work, n)
    load = scheme.load if scheme.loaded == 1 else scheme.load[:0]
    passes = 0
    while True:
        clock.number = pose_position(
            model, h, n, scheme.q, scheme.flexibility, scheme.held_flexibility, load, scheme.compliance, scheme.unit,
            scheme.gap_tolerance, scheme.least, work,
        )  # fmt: skip
        if clock.number >= 0.0:
            return RunStatus.STIFF
        clock.number = solve_position(work, scheme.unit, passes > 0, scheme.tolerance)
        if clock.number != 0 or not work.impulses.solver.residual <= scheme.tolerance:
            return RunStatus.SOLVER_FAILED
        passes += 1
        curved = deform(model, scheme, work)
        unsettled = misfit(scheme.compliance, scheme.unit, work) > 1.0
        if passes >= (MOST_SETTLING if unsettled else MOST_PASSES) or not (unsettled or curved > CURVED):
            break
    if unsettled and (h == 0.0 or scheme.parts >= scheme.most_parts):
        return RunStatus.UNSETTLED
    if unsettled or (h > 0.0 and not short_enough(model, scheme, h, work)):
        return RunStatus.TOO_LONG if scheme.parts >= scheme.most_parts else RunStatus.PART
    return RunStatus.DONE


@take_step.of(BoundaryScheme)
@kernel
def boundary_step(
    model: Model, scheme: BoundaryScheme, t: float, work: Workspace, recorder: Recorder, clock: StepCount
) -> int:
    """The next part of a step; before the first step, the forces of the start."""
    set_out(scheme.q, recorder)
    while True:
        h = part_length(scheme, clock)
        clock.number = predict(model, scheme, t + h, h, work, recorder)
        # they make one problem: static modes couple what joints do not
        work.impulses.most = max(work.impulses.most, int(clock.number))
        if clock.number > len(work.rows.table.key) or clock.number > len(work.posed.problem.friction):
            return RunStatus.GROW
        status = solve_contact_forces(model, scheme, h, int(clock.number), work, clock)
        if has_strayed(model, scheme, work):
            continue
        if status == RunStatus.DONE:
            clock.number = note_depths(scheme.compliance, work)
            if clock.number >= 0.0:
                return RunStatus.OUT_OF_RANGE
            break
        if status != RunStatus.PART:
            return status
        scheme.parts = more(scheme.parts, scheme)
        scheme.closed_then = closed(work)
    ends = h > 0.0 and clock.within + h >= scheme.step * (1.0 - 1e-9)
    used = scheme.parts
    if ends:
        divide_less(model, scheme, work)
    clock.step_taken = scheme.step / scheme.parts
    if not correct(model, scheme, t + h, h, work, recorder):
        return RunStatus.NOT_FINITE
    if h == 0.0:
        clock.begun = 1
    elif ends:
        if used > 1.0:
            scheme.n_split += 1
            scheme.finest = max(scheme.finest, used)
        return RunStatus.DONE
    else:
        clock.within += h
    return RunStatus.PART
