"""The compiled step of the massless-boundary scheme (see
:class:`lcpflex.steppers.massless_boundary.stepper.MasslessBoundary`).

A step is made of equal parts, as many as stability asks for. Each part is predicted, its contact problem is solved, and
if the contacts that this closes do not admit its length, it is taken back and made shorter.
"""

from __future__ import annotations

import math

from lcpflex.contact.detection import detect
from lcpflex.contact.narrow_phase.feature import refresh
from lcpflex.contact.rows import contact_point
from lcpflex.dynamics.contact_compliance import ALL, HARD, choose, compliance_energy, misfit, note_depths
from lcpflex.dynamics.delassus import apply_impulses, delassus, row_velocity
from lcpflex.dynamics.mechanics import factorise, fill_contact_rows, forces, solve_rows, solve_vector, supply
from lcpflex.dynamics.position import admissible, pose_position, split_forces, static_response, static_sway
from lcpflex.dynamics.workspace import Workspace
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.kinematics.configuration import advance as move, difference
from lcpflex.kinematics.joint_rows import joint_rows
from lcpflex.model.arrays import SLIP, STICK, Model
from lcpflex.model.planar import N_RIGID
from lcpflex.solvers.contact.compiled import recall_basis, remember_basis, slip_of, solve_contacts
from lcpflex.solvers.semidefinite import cholesky, cholesky_solve
from lcpflex.steppers.clock import StepCount
from lcpflex.steppers.massless_boundary.memory import Boundary, Settings
from lcpflex.steppers.passing import may_pass, set_out
from lcpflex.steppers.projection import project_joints
from lcpflex.steppers.recorder import Tape, note_certificate, note_contact, store_contacts, store_state
from lcpflex.steppers.status import RunStatus

__all__ = ["advance", "short_enough"]

STICKING = 1e-9  # part of the largest gap or slip of a problem below which a contact counts as sticking
MOST_PASSES = 6  # of the contact problem in a step, each linearised about the static coordinates of the last
MOST_SETTLING = 40  # of them, where elastic laws of contacts are linearised, too
CURVED = 1e-3  # gap left by the linearisation, relative to the static displacement, that ends them
MOST_PARTS = 1000.0  # of a step; beyond, the contacts are all but rigid


@kernel
def predict(
    model: Model,
    settings: Settings,
    t: float,
    h: float,
    q: FloatArray,
    u: FloatArray,
    boundary: Boundary,
    work: Workspace,
    tape: Tape,
) -> int:
    """q+ in ``work.middle`` and u_h in ``work.free_u``, at time t = end of the step; returns the contacts near."""
    largest = 0.0
    for i in range(len(q)):
        work.free_u[i] = u[i] + 0.5 * h * boundary.acceleration[i]
        work.ahead[i] = work.free_u[i] + boundary.rate[i]
        largest = max(largest, abs(q[i]))
    move(model, q, work.ahead, h, work.middle)
    if h > 0.0 and len(work.residual) > 0:
        for i in range(len(q)):
            work.ahead[i] = work.middle[i]
        project_joints(model, t, work.middle, work.free_u, work, tape, 1e-12 * (1.0 + largest))
        difference(model, work.ahead, work.middle, work.ahead)
        for i in range(len(u)):
            work.free_u[i] += work.ahead[i] / h
    sway = static_sway(model, boundary.flexibility, q) + static_sway(model, boundary.flexibility, work.middle)
    return detect(model, work.middle, settings.gap_tolerance + sway, work.table)


@kernel
def hold_joints(model: Model, t: float, h: float, boundary: Boundary, work: Workspace) -> float:
    """Change the acceleration such that u_h + h/2 a fulfils the joints; power of the drives [W].

    Without a step (h = 0) the acceleration itself fulfils them.
    """
    n_joint = len(work.residual)
    if n_joint == 0:
        return 0.0
    a = boundary.acceleration
    joint_rows(model, t, work.middle, boundary.guess, work.external, work.rows, work.row_body, work.rate, work.bias)
    solve_rows(model, work, 0, n_joint)
    delassus(work.rows, work.solved, work.row_body, n_joint, work.G)
    cholesky(work.G, n_joint, work.lower)
    for j in range(n_joint):
        work.p[j] = -row_velocity(work.rows, work.row_body, j, work.dof, a)
        if h > 0.0:
            velocity = row_velocity(work.rows, work.row_body, j, work.dof, work.free_u)
            work.p[j] -= 2.0 / h * (velocity + work.rate[j])
        else:
            work.p[j] -= work.bias[j]
    cholesky_solve(work.lower, n_joint, work.p)
    apply_impulses(work.solved, work.row_body, 0, n_joint, work.p, work.dof, a)
    power = 0.0
    for j in range(n_joint):
        power -= work.p[j] * work.rate[j]
    return power


@kernel
def accelerate(model: Model, t: float, h: float, boundary: Boundary, work: Workspace) -> float:
    """a+ at ``work.middle`` under all forces but those of joints; modal damping is implicit.

    Velocities for the forces: u_h + h/2 a, to second order; the diagonal of the damping acts on u+ itself.
    """
    a = boundary.acceleration
    guess = boundary.guess
    for i in range(len(a)):
        guess[i] = work.free_u[i] + 0.5 * h * a[i]
    supply(model, t, work.middle, guess, work)
    forces(model, t, work.middle, guess, work)
    factorise(model, work.middle, 0.5 * h, 0.0, work)
    for i in range(len(a)):
        a[i] = work.total[i]
    for b in range(len(model.bodies.mass)):
        for k in range(work.dof[b] + N_RIGID, work.dof[b + 1]):
            a[k] += model.bodies.damping[k - N_RIGID * (b + 1)] * (guess[k] - work.free_u[k])
    n_joint = len(work.residual)
    total = n_joint + work.n_contacts + work.n_tangents
    apply_impulses(work.rows, work.row_body, n_joint, total, work.p, work.dof, a)
    for i in range(len(a)):
        if boundary.flexibility[i] > 0.0:
            a[i] = 0.0
    solve_vector(model, work, a)
    return hold_joints(model, t, h, boundary, work)


@kernel
def audit(h: float, drives: float, u: FloatArray, boundary: Boundary, work: Workspace, tape: Tape) -> None:
    """Add the step's work by kind, and its impulses, to the tape; trapezoidal in time, as Verlet's own balance is.

    Friction: the mean of the forces at both ends times the slip, which is exact for the contact compliance.
    """
    lost = 0.0
    for i in range(len(u)):
        lost -= work.dissipative[i] * u[i]
        drives += work.driving[i] * u[i]
    tape.counts.lost_damping += 0.5 * h * (boundary.power[0] + lost)
    tape.counts.supplied += 0.5 * h * (boundary.power[1] + drives)
    boundary.power[0] = lost
    boundary.power[1] = drives
    for law in range(len(boundary.force)):
        for i in range(2):
            tape.total_impulse[law, i] += 0.5 * h * boundary.force[law, i]
            boundary.force[law, i] = 0.0
    n = work.n_contacts
    for k in range(n):
        boundary.force[work.table.law[k], 0] += work.normal[k]
    length = boundary.unit[0] * boundary.unit[1]
    held = work.n_held
    for j in range(work.n_tangents):
        k = work.tangent[j]
        boundary.force[work.table.law[k], 1] += work.tangential[j]
        before = 0.0
        for i in range(held):
            if work.held_key[0, i] == work.table.key[k]:
                before = work.held_gap[0, i]
        work.held_key[1, j] = work.table.key[k]
        work.held_gap[1, j] = work.tangential[j]
        if h > 0.0 and (before != 0.0 or work.tangential[j] != 0.0):
            tape.counts.lost_friction -= 0.5 * (before + work.tangential[j]) * slip_of(work.solver, n + j) * length
    work.n_held = work.n_tangents
    for j in range(work.n_tangents):
        work.held_key[0, j] = work.held_key[1, j]
        work.held_gap[0, j] = work.held_gap[1, j]
    for law in range(len(boundary.force)):
        for i in range(2):
            tape.total_impulse[law, i] += 0.5 * h * boundary.force[law, i]
    note_certificate(work, tape)


@kernel
def closed(work: Workspace) -> int:
    """How many contacts the solution of the present problem closes."""
    count = 0
    for k in range(work.n_contacts):
        if work.normal[k] > 0.0:
            count += 1
    return count


@kernel
def correct(
    model: Model, t: float, h: float, q: FloatArray, u: FloatArray, boundary: Boundary, work: Workspace, tape: Tape
) -> bool:
    """Forces, accelerations and the state at the end t of the step, in place. False where they are not finite."""
    # rows of the deformed surfaces: with others, forces do work that is not stored
    fill_contact_rows(model, work.middle, work.n_contacts, len(work.residual), work)
    soft = boundary.compliance.soft
    everywhere = boundary.compliance.some[0] == ALL  # all that there is to tell is indentation, then
    for k in range(work.n_contacts):
        if everywhere or soft[work.table.law[k]] == 0:  # an elastic law asks for its indentation
            tape.counts.worst_penetration = max(tape.counts.worst_penetration, -work.table.gap[k])
    boundary.n_closed = closed(work)
    drives = accelerate(model, t, h, boundary, work)
    finite = True
    difference(model, q, work.middle, boundary.rate)
    for i in range(len(q)):
        moved = boundary.flexibility[i] > 0.0 and h > 0.0 and boundary.n_closed > 0
        boundary.rate[i] = boundary.rate[i] / h if moved else 0.0
        q[i] = work.middle[i]
        u[i] = work.free_u[i] + 0.5 * h * boundary.acceleration[i]
        finite = finite and math.isfinite(q[i] + u[i])
    audit(h, drives, u, boundary, work, tape)
    return finite


@kernel
def record(
    model: Model, t: float, q: FloatArray, u: FloatArray, boundary: Boundary, work: Workspace, tape: Tape
) -> int:
    """Store the present instant with its contact forces."""
    needed = store_contacts(model, q, tape)
    if needed > len(tape.table.key):
        return needed
    n = work.n_contacts
    tangent = 0
    for k in range(n):
        force_t = 0.0
        slip = 1.0
        if tangent < work.n_tangents and work.tangent[tangent] == k:
            force_t = work.tangential[tangent]
            slip = slip_of(work.solver, n + tangent)
            tangent += 1
        if work.normal[k] > 0.0:
            state = STICK if abs(slip) <= STICKING else SLIP
            place = contact_point(model, q, work.table, k)
            note_contact(tape, work.table.law[k], place, work.table.normal[k], work.normal[k], force_t, state)
    store_state(model, t, q, u, work, compliance_energy(boundary.compliance, work), tape)
    return needed


@kernel
def part_length(settings: Settings, clock: StepCount) -> float:
    """Length of the next part of the step [s]; 0 for the start, which only finds forces."""
    if clock.begun == 0:
        return 0.0
    remaining = settings.step - clock.within
    return remaining / max(1.0, math.ceil(remaining / settings.step * clock.parts - 1e-9))


@kernel
def deform(model: Model, boundary: Boundary, work: Workspace) -> float:
    """Static coordinates by the solution; gap that the curvature of the geometry leaves in closed contacts.

    Relative to the largest static displacement of them. Those with a law of their own have a gap, see ``misfit``.
    """
    split_forces(work, boundary.unit)
    static_response(work, boundary.flexibility, work.middle)
    left = 0.0
    displaced = 0.0
    for k in range(work.n_contacts):
        refresh(model, work.middle, work.table, k)
        if work.normal[k] > 0.0 and (boundary.compliance.some[0] == 0 or work.closed[k] == HARD):
            left = max(left, abs(work.table.gap[k]))
            displaced = max(displaced, boundary.unit[1] * work.problem.delassus[k, k] * work.normal[k])
    return left / displaced if displaced > 0.0 else 0.0


@kernel
def short_enough(model: Model, settings: Settings, h: float, boundary: Boundary, work: Workspace) -> bool:
    """Whether the scheme is stable with steps h [s] and the contacts that the present problem closes."""
    square = (2.0 * settings.safety / h) ** 2 - settings.spring
    if square <= 0.0 or h * settings.damper > settings.safety:
        return False
    return admissible(model, work.middle, square, boundary.flexibility, boundary.unit, work)


@kernel
def divide_less(model: Model, settings: Settings, boundary: Boundary, work: Workspace, clock: StepCount) -> None:
    """At the end of a step, where fewer contacts are closed than when it was divided: the parts that the next needs.

    Those that the contacts still closed admit. Their forces begin the next step: if that throws them open, its own
    problem has no contact that would object to its length, and a kick by h/2 of a contact force makes energy.
    """
    count = closed(work)
    if clock.parts > settings.parts and count < clock.closed_then:
        parts = settings.parts
        while parts < clock.parts and not short_enough(model, settings, settings.step / parts, boundary, work):
            parts = more(parts, settings)
        clock.parts = min(parts, clock.parts)
    clock.closed_then = count


@kernel
def more(parts: float, settings: Settings) -> float:
    """The next number of parts to try."""
    return min(math.ceil(1.1 * parts + 0.1), settings.most_parts)


@kernel
def advance(
    model: Model,
    settings: Settings,
    start: float,
    clock: StepCount,
    q: FloatArray,
    u: FloatArray,
    boundary: Boundary,
    work: Workspace,
    tape: Tape,
    n_steps: int,
    stride: int,
) -> int:
    """At most n_steps steps from the state (q, u), which is stored before each ``stride``-th one.

    clock: steps made; a number that explains the return value; the step last stored; time made of the present step;
    whether forces are known; the parts of a step; contacts closed when that was chosen. Returns DONE, or why the next
    step or record could not be made; the state is then that of the last whole part of a step (but NOT_FINITE).
    """
    last = clock.made + n_steps
    while True:
        t = start + clock.made * settings.step + clock.within
        if clock.begun > 0 and clock.within == 0.0:
            if clock.made % stride == 0 and clock.stored != clock.made:
                if tape.n_instants >= len(tape.times) or tape.n_points + work.n_contacts > len(tape.spots):
                    return RunStatus.TAPE_FULL
                clock.number = record(model, t, q, u, boundary, work, tape)
                if clock.number > len(tape.table.key):
                    return RunStatus.GROW_TAPE
                clock.stored = clock.made
            if clock.made >= last:
                return RunStatus.DONE
        h = part_length(settings, clock)
        set_out(q, tape)
        clock.number = predict(model, settings, t + h, h, q, u, boundary, work, tape)
        if clock.number > len(work.table.key):
            return RunStatus.GROW
        n = int(clock.number)
        choose(model, boundary.compliance, work, n)
        passes = 0
        while True:
            clock.number = pose_position(model, h, n, q, boundary.flexibility, boundary.compliance, boundary.unit, work)
            if clock.number >= 0.0:
                return RunStatus.STIFF
            recall_basis(work.problem, work.solver)
            clock.number = solve_contacts(work.problem, work.solver)
            if clock.number != 0 or not work.solver.residual <= settings.tolerance:
                return RunStatus.SOLVER_FAILED
            remember_basis(work.problem, work.solver)
            passes += 1
            curved = deform(model, boundary, work)
            unsettled = misfit(boundary.compliance, boundary.unit, work) > 1.0
            if passes >= (MOST_SETTLING if unsettled else MOST_PASSES) or not (unsettled or curved > CURVED):
                break
        if unsettled and (h == 0.0 or clock.parts >= settings.most_parts):
            return RunStatus.UNSETTLED
        if unsettled or (h > 0.0 and not short_enough(model, settings, h, boundary, work)):
            if clock.parts >= settings.most_parts:
                return RunStatus.TOO_LONG
            clock.parts = more(clock.parts, settings)
            clock.closed_then = closed(work)
            continue
        clock.number = note_depths(boundary.compliance, work)
        if clock.number >= 0.0:
            return RunStatus.OUT_OF_RANGE
        ends = h > 0.0 and clock.within + h >= settings.step * (1.0 - 1e-9)
        used = clock.parts
        if ends:
            divide_less(model, settings, boundary, work, clock)
        if not correct(model, t + h, h, q, u, boundary, work, tape):
            return RunStatus.NOT_FINITE
        if h == 0.0:
            clock.begun = 1
        elif ends:
            if used > 1.0:
                boundary.n_split += 1
                boundary.finest = max(boundary.finest, used)
            clock.made += 1
            clock.within = 0.0
        else:
            clock.within += h
        if may_pass(model, q, tape):
            return RunStatus.PASSED
