"""The problems of a generalised-alpha step, posed and applied one by one; here that of velocities.

See :mod:`lcpflex.steppers.generalized_alpha.stepper` for the scheme. All contact problems of a step are solved at one
place; :func:`predict` poses the one that is next and :func:`correct` applies its solution.
"""

from __future__ import annotations

import math

from lcpflex.dynamics.acceleration import STICKING
from lcpflex.dynamics.delassus import row_velocity
from lcpflex.dynamics.impulse import add_impulses, answer_joints, recall_joints
from lcpflex.dynamics.islands import Islands, forget_islands, unfinished
from lcpflex.dynamics.joint_reactions import lay_reactions, note_ends, note_impulses
from lcpflex.dynamics.workspace import Workspace
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.jit.leaf import in_space
from lcpflex.jit.struct import copy_parts
from lcpflex.model.arrays import Model
from lcpflex.steppers.clock import StepClock, StepCount
from lcpflex.steppers.generalized_alpha.memory import (
    POSITION,
    RESTART,
    SMOOTH,
    VELOCITY,
    AlphaScheme,
    note_overrun,
)
from lcpflex.steppers.generalized_alpha.position import (
    apply_position,
    pose_position,
)
from lcpflex.steppers.generalized_alpha.smooth import (
    apply_smooth,
    pose_smooth,
    slip_mode,
)
from lcpflex.steppers.generalized_alpha.velocity import pose_velocity, resting_load
from lcpflex.steppers.island_problems import solve_islands
from lcpflex.steppers.moreau_jean.step import record_impulses
from lcpflex.steppers.passing import set_out_freely
from lcpflex.steppers.recorded_contacts import add_impulse
from lcpflex.steppers.recorder import Recorder, note_gain
from lcpflex.steppers.scheme import record, set_length, take_step
from lcpflex.steppers.status import RunStatus
from lcpflex.steppers.strike_order import add_strikes, apply_strike, end_order

__all__: list[str] = []


@kernel
def accrue_impulse(scheme: AlphaScheme, recorder: Recorder) -> None:
    """Add the impulse of the smooth contact forces, with the weights that they have in the velocity.

    So impulses are the change of momentum to rounding, and not to the order of the step.
    """
    am = scheme.alpha_m
    af = scheme.alpha_f
    for law in range(len(scheme.recursive)):
        for i in range(scheme.recursive.shape[1]):
            now = scheme.start.contact[law, i]
            old = scheme.recursive[law, i]
            new = ((1.0 - af) * scheme.end.contact[law, i] + af * now - am * old) / (1.0 - am)
            recorder.total_impulse[law, i] += scheme.step * ((1.0 - scheme.gamma) * old + scheme.gamma * new)
            scheme.recursive[law, i] = new


@kernel
def mean_power(start: FloatArray, end: FloatArray, u: FloatArray, v: FloatArray) -> float:
    """Four times the mean power over a step from the velocity u to v of forces given at its ends."""
    done = 0.0
    for i in range(len(u)):
        done += (start[i] + end[i]) * (u[i] + v[i])
    return done


@kernel
def audit(t: float, work: Workspace, scheme: AlphaScheme, recorder: Recorder) -> None:
    """Add the step's work by kind and its impulses to the recorder: mean forces, or impulses, times mean velocities.

    ``work.free.u`` holds u+; ``work.impulses.p`` the whole impulses, of which h lambda belong to the smooth motion.
    """
    n_joint = work.rows.n_joint
    n = work.rows.n_contacts
    h, u = scheme.step, scheme.u
    start, end = scheme.start, scheme.end
    recorder.counts.lost_friction -= 0.25 * h * mean_power(start.friction, end.friction, u, scheme.v_new)
    recorder.counts.lost_impacts -= 0.25 * h * mean_power(start.normal, end.normal, u, scheme.v_new)
    recorder.counts.lost_damping -= 0.25 * h * mean_power(start.damping, end.damping, u, scheme.v_new)
    recorder.counts.supplied += 0.25 * h * mean_power(start.drive, end.drive, u, scheme.v_new)
    recorder.counts.lost_damping += scheme.numerical
    accrue_impulse(scheme, recorder)
    gained = 0.0
    for r in range(n_joint + n + work.rows.n_tangents):
        p = work.impulses.p[r]
        part = 1
        k = -1
        if r >= n_joint + n:
            part = 0
            k = work.rows.tangent[r - n_joint - n]
        elif r >= n_joint:
            k = r - n_joint
        if k >= 0 and scheme.matched[k] >= 0:
            p -= h * resting_load(work, scheme, k, r)
        before = row_velocity(work.rows.J, work.rows.body, r, work.rows.dof, scheme.v_new)
        done = 0.5 * p * (before + row_velocity(work.rows.J, work.rows.body, r, work.rows.dof, work.free.u))
        if k >= 0:
            gained += done
            if part == 0:
                recorder.counts.lost_friction -= done
            else:
                recorder.counts.lost_impacts -= done
            add_impulse(work, r - n_joint, p, recorder)
        elif work.rows.rate[r] != 0.0:
            recorder.counts.supplied += done
    note_gain(recorder, t, gained)


@kernel
def broken(work: Workspace, scheme: AlphaScheme) -> bool:
    """Whether the acceleration jumps at the end of the step: a contact closed, opened, or changed its slip."""
    n_joint = work.rows.n_joint
    kept = 0
    for k in range(work.rows.n_contacts):
        i = scheme.matched[k]
        carries = work.impulses.p[n_joint + k] > 0.0
        if carries and i < 0:
            return True
        if carries:
            kept += 1
    anew = slips_anew(work, scheme)
    return kept != scheme.resting.count or anew


@in_space("lcpflex.steppers.spatial.alpha")
@kernel
def slips_anew(work: Workspace, scheme: AlphaScheme) -> bool:
    """Whether a contact that slid has come to rest, or slides the other way, at the velocity ``work.free.u``."""
    n_joint, n = work.rows.n_joint, work.rows.n_contacts
    found = False
    for j in range(work.rows.n_tangents):
        i = scheme.matched[work.rows.tangent[j]]
        if i >= 0 and scheme.resting.mode[i] != STICKING:
            r = n_joint + n + j
            slip = row_velocity(work.rows.J, work.rows.body, r, work.rows.dof, work.free.u)
            if slip_mode(slip, scheme.velocity_threshold) != scheme.resting.mode[i]:
                found = True
                smooth = row_velocity(work.rows.J, work.rows.body, r, work.rows.dof, scheme.v_new)
                start = row_velocity(work.rows.J, work.rows.body, r, work.rows.dof, scheme.u)
                note_overrun(scheme, abs(smooth - slip), abs(smooth - start))
    return found


@in_space("lcpflex.steppers.spatial.alpha")
@kernel
def speed_left(model: Model, work: Workspace, scheme: AlphaScheme) -> float:
    """Speed of contacts that the velocity problem was to stop, at the velocity ``work.free.u`` [m/s].

    In the plane none: problems are solved to rounding there, which ``velocity_threshold`` is above.
    """
    return 0.0


@kernel
def struck(work: Workspace, scheme: AlphaScheme) -> bool:
    """Whether a contact carries that did not rest."""
    found = False
    for k in range(work.rows.n_contacts):
        found = found or (work.impulses.p[work.rows.n_joint + k] > 0.0 and scheme.matched[k] < 0)
    return found


@kernel
def note_penetration(work: Workspace, scheme: AlphaScheme, recorder: Recorder) -> None:
    """Keep the deepest penetration: what is left, and what more than ``sunk`` was lifted where no impulse pushed.

    Such a pair opens again at the end of a step in which it closed: where it met, and how hard, the step has missed.
    """
    table, deep, counts, worst = work.rows.table, scheme.deep, recorder.counts, 0.0
    for k in range(work.rows.n_contacts):
        if work.impulses.p[work.rows.n_joint + k] > 0.0:
            deep[table.law[k]] = 0.0
    for k in range(work.rows.n_contacts):
        worst = max(worst, -table.gap[k])
        if deep[table.law[k]] > scheme.sunk:
            worst = max(worst, deep[table.law[k]])
    counts.worst_penetration = max(counts.worst_penetration, worst)


@kernel
def apply_velocity(model: Model, t: float, work: Workspace, scheme: AlphaScheme, recorder: Recorder) -> bool:
    """The state at the end of the step, in place. False where it is not finite: that of the start stays, then."""
    q, u = scheme.q, scheme.u
    answer_joints(work)
    recall_joints(work)
    n_joint = work.rows.n_joint
    add_impulses(work, work.free.u)
    if scheme.order.rounds > 0:
        add_strikes(work, scheme.order)
    finite = True
    for i in range(len(q)):
        finite = finite and math.isfinite(scheme.q_new[i])
    for i in range(len(u)):
        finite = finite and math.isfinite(work.free.u[i])
    if not finite:
        return False
    audit(t, work, scheme, recorder)
    for r in range(n_joint):
        recorder.counts.worst_drift = max(recorder.counts.worst_drift, abs(work.scratch.residual[r]))
    note_penetration(work, scheme, recorder)
    scheme.left = speed_left(model, work, scheme)
    jumps = broken(work, scheme)
    note_ends(model, scheme.step, recorder.reactions)
    note_impulses(model, work, struck(work, scheme), recorder.reactions)
    for i in range(len(q)):
        q[i] = scheme.q_new[i]
    for i in range(len(u)):
        u[i] = work.free.u[i]
        scheme.a[i] = scheme.a_new[i]
        scheme.w[i] = scheme.w_new[i]
    copy_parts(scheme.end, scheme.start)
    scheme.phase = RESTART if jumps else SMOOTH
    scheme.turn = 0
    end_order(scheme.order)
    work.impulses.unsolved = 0  # of the next step
    return True


@kernel
def predict(model: Model, t: float, work: Workspace, scheme: AlphaScheme) -> int:
    """Pose the next contact problem of the step from t; returns the contacts found, which must fit into the table."""
    h = scheme.step
    if scheme.phase <= SMOOTH:
        length = h if scheme.phase == SMOOTH else 0.0
        return pose_smooth(model, length, t, work, scheme)
    n = scheme.n_found
    if scheme.phase == POSITION:
        n = pose_position(model, t + h, work, scheme)
    if scheme.phase == VELOCITY:
        pose_velocity(model, t + h, work, scheme)
    return n


@kernel
def correct(model: Model, t: float, work: Workspace, scheme: AlphaScheme, recorder: Recorder) -> int:
    """Apply the solution of the problem posed: PART where the step has more of them, DONE or NOT_FINITE."""
    if scheme.phase <= SMOOTH:
        start = scheme.phase == RESTART
        apply_smooth(model, scheme.step if scheme.phase == SMOOTH else 0.0, work, scheme, recorder)
        lay_reactions(model, work, recorder.reactions.ahead)
        if start:
            note_ends(model, 0.0, recorder.reactions)
    elif scheme.phase == POSITION:
        apply_position(model, work, scheme, recorder)
    elif scheme.order.goes_on == 1:
        apply_strike(work, scheme.order)
    elif apply_velocity(model, t, work, scheme, recorder):
        return RunStatus.DONE
    else:
        return RunStatus.NOT_FINITE
    return RunStatus.PART


@kernel
def give_up_smooth(scheme: AlphaScheme, islands: Islands) -> bool:
    """After an unsolved problem: whether it was one of accelerations, without which the impulses of the step do."""
    if scheme.phase > SMOOTH or scheme.n_found == 0:
        return False
    scheme.skip = 1
    scheme.turn = 0
    forget_islands(islands)
    return True


@in_space("lcpflex.steppers.spatial.alpha")
@kernel
def solve_problems(work: Workspace, scheme: AlphaScheme, t: float, last: bool, recorder: Recorder) -> int:
    """The problems laid that are not solved yet; as :func:`lcpflex.steppers.island_problems.solve_islands`."""
    return solve_islands(work, t, scheme.tolerance, scheme.warm == 1, last, recorder)


@take_step.of(AlphaScheme)
@kernel
def alpha_step(
    model: Model, scheme: AlphaScheme, t: float, work: Workspace, recorder: Recorder, clock: StepCount | StepClock
) -> int:
    """The problems of a step, one after the other."""
    set_out_freely(model, scheme.q, scheme.u, scheme.step, recorder)
    while True:
        if not unfinished(work.posed.islands):
            clock.number = predict(model, t, work, scheme)
            if clock.number > len(work.rows.table.key):
                return RunStatus.GROW
        last = scheme.phase == VELOCITY and scheme.order.goes_on == 0
        status = solve_problems(work, scheme, t, last, recorder)
        if status == RunStatus.SOLVER_FAILED and give_up_smooth(scheme, work.posed.islands):
            continue
        if status != RunStatus.DONE:
            clock.number = work.impulses.number
            return status
        status = correct(model, t, work, scheme, recorder)
        if status != RunStatus.PART:
            return status


record.of(AlphaScheme)(record_impulses)


@set_length.of(AlphaScheme)
@kernel
def carry_acceleration(scheme: AlphaScheme, length: float) -> None:
    """The recursive acceleration stands for udot at t + (alpha_m - alpha_f) h: a' = udot + (a - udot) h'/h."""
    ratio = length / scheme.step
    for i in range(len(scheme.a)):
        scheme.a[i] = scheme.w[i] + ratio * (scheme.a[i] - scheme.w[i])
    for law in range(len(scheme.recursive)):
        for i in range(scheme.recursive.shape[1]):
            now = scheme.start.contact[law, i]
            scheme.recursive[law, i] = now + ratio * (scheme.recursive[law, i] - now)
    scheme.step = length
