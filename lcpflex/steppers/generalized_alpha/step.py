"""The problems of a generalised-alpha step, posed and applied one by one; here that of velocities.

See :mod:`lcpflex.steppers.generalized_alpha.stepper` for the scheme. All contact problems of a step are solved at one
place of the loop; :func:`predict` poses the one that is next and :func:`correct` applies its solution.
"""

from __future__ import annotations

import math

from lcpflex.dynamics.acceleration import STICKING
from lcpflex.dynamics.contact_problem import pose_contacts
from lcpflex.dynamics.delassus import apply_impulses, free_velocities, row_velocity
from lcpflex.dynamics.impulse import distribute
from lcpflex.dynamics.mechanics import multiply
from lcpflex.dynamics.workspace import Workspace
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.model.arrays import Model
from lcpflex.steppers.doubtful import keep_doubtful
from lcpflex.steppers.generalized_alpha.memory import (
    POSITION,
    RESTART,
    SMOOTH,
    VELOCITY,
    AlphaMemory,
    copy_end,
    match,
)
from lcpflex.steppers.generalized_alpha.position import (
    apply_position,
    pose_position,
)
from lcpflex.steppers.generalized_alpha.smooth import (
    AlphaSettings,
    apply_smooth,
    lay,
    pose_smooth,
    slip_mode,
)
from lcpflex.steppers.recorder import Tape, note_certificate, note_gain
from lcpflex.steppers.status import RunStatus

__all__ = ["AGAIN", "STEPPED", "correct", "give_up_smooth", "predict"]

AGAIN = 0  # the step has another problem to solve
STEPPED = 1


@kernel
def numerical_damping(
    model: Model, settings: AlphaSettings, u: FloatArray, work: Workspace, memory: AlphaMemory
) -> float:
    """Energy that the smooth motion has lost by not being that of the trapezoidal rule, which conserves it [J].

    dv M (u + v~)/2 - dq (f + f~)/2 with dv = v~ - u - h (w + w~)/2 and dq = q~ - q - h (u + v~)/2.
    """
    h = settings.step
    for i in range(len(u)):
        memory.mean[i] = 0.5 * (u[i] + memory.v_new[i])
    multiply(model, memory.q_new, memory.mean, work, memory.push)
    gained = 0.0
    for i in range(len(u)):
        a = memory.a[i]
        a_new = memory.a_new[i]
        dv = (1.0 - settings.gamma) * a + settings.gamma * a_new - 0.5 * (memory.w[i] + memory.w_new[i])
        dq = (
            (0.5 - settings.beta) * a
            + settings.beta * a_new
            - 0.5 * ((1.0 - settings.gamma) * a + settings.gamma * a_new)
        )
        force = 0.5 * (memory.start.conservative[i] + memory.end.conservative[i])
        gained += h * (dv * memory.push[i] - h * dq * force)
    return -gained


@kernel
def pose_velocity(
    model: Model, settings: AlphaSettings, t: float, u: FloatArray, work: Workspace, memory: AlphaMemory
) -> None:
    """Impact law and friction at the end of the step, for the whole impulses of the step.

    ``work.free_u``: velocity without any contact impulse. A contact that came to the step at rest has no restitution:
    its approach is that of a curved surface.
    """
    n = memory.n_found
    n_tangent = lay(model, t, 0.0, 0.0, n, work, memory)
    memory.numerical = numerical_damping(model, settings, u, work, memory)
    n_joint = work.n_joint
    total = n_joint + n + n_tangent
    h = settings.step
    for i in range(len(u)):
        work.free_u[i] = memory.v_new[i]
    for r in range(n_joint + n, total):
        work.p[r] = 0.0
    for k in range(n):
        i = match(work.table, k, memory.resting)
        memory.matched[k] = i
        work.p[n_joint + k] = -h * memory.resting.load[i, 0] if i >= 0 else 0.0
    for j in range(n_tangent):
        i = memory.matched[work.tangent[j]]
        if i >= 0:
            work.p[n_joint + n + j] = -h * memory.resting.load[i, 1]
    apply_impulses(work.solved, work.row_body, n_joint, total, work.p, work.dof, work.free_u)
    free_velocities(work.rows, work.row_body, n_joint, total, work.dof, work.free_u, work.free, work.problem.terms)
    for r in range(n_joint):
        work.free[r] += work.rate[r]
    for k in range(n):
        e_n = model.contacts.restitution[work.table.law[k]]
        if e_n > 0.0 and memory.matched[k] < 0:
            before = min(row_velocity(work.rows, work.row_body, n_joint + k, work.dof, u), 0.0)
            memory.approach = max(memory.approach, -before)
            gained = abs(work.free[n_joint + k] - before)
            if -before > settings.rebound + settings.settle * gained:
                work.free[n_joint + k] += e_n * before
            else:
                memory.stopped = max(memory.stopped, -before)
    for j in range(n_tangent):
        k = work.tangent[j]
        e_t = model.contacts.tangential_restitution[work.table.law[k]]
        if e_t > 0.0 and memory.matched[k] < 0:
            r = n_joint + n + j
            work.free[r] += e_t * row_velocity(work.rows, work.row_body, r, work.dof, u)
    pose_contacts(work)
    memory.warm = 1


@kernel
def accrue_impulse(settings: AlphaSettings, memory: AlphaMemory, tape: Tape) -> None:
    """Add the impulse of the smooth contact forces, with the weights that they have in the velocity.

    So impulses are the change of momentum to rounding, and not to the order of the step.
    """
    am = settings.alpha_m
    af = settings.alpha_f
    for law in range(len(memory.recursive)):
        for i in range(2):
            now = memory.start.contact[law, i]
            old = memory.recursive[law, i]
            new = ((1.0 - af) * memory.end.contact[law, i] + af * now - am * old) / (1.0 - am)
            tape.total_impulse[law, i] += settings.step * ((1.0 - settings.gamma) * old + settings.gamma * new)
            memory.recursive[law, i] = new


@kernel
def mean_power(start: FloatArray, end: FloatArray, u: FloatArray, v: FloatArray) -> float:
    """Four times the mean power over a step from the velocity u to v of forces given at its ends."""
    done = 0.0
    for i in range(len(u)):
        done += (start[i] + end[i]) * (u[i] + v[i])
    return done


@kernel
def audit(settings: AlphaSettings, t: float, u: FloatArray, work: Workspace, memory: AlphaMemory, tape: Tape) -> None:
    """Add the step's work by kind and its impulses to the tape: mean forces, or impulses, times mean velocities.

    ``work.free_u`` holds u+; ``work.p`` the whole impulses, of which h lambda belong to the smooth motion.
    """
    n_joint = work.n_joint
    n = work.n_contacts
    h = settings.step
    start, end = memory.start, memory.end
    tape.counts.lost_friction -= 0.25 * h * mean_power(start.friction, end.friction, u, memory.v_new)
    tape.counts.lost_impacts -= 0.25 * h * mean_power(start.normal, end.normal, u, memory.v_new)
    tape.counts.lost_damping -= 0.25 * h * mean_power(start.damping, end.damping, u, memory.v_new)
    tape.counts.supplied += 0.25 * h * mean_power(start.drive, end.drive, u, memory.v_new)
    tape.counts.lost_damping += memory.numerical
    accrue_impulse(settings, memory, tape)
    gained = 0.0
    for r in range(n_joint + n + work.n_tangents):
        p = work.p[r]
        part = 1
        k = -1
        if r >= n_joint + n:
            part = 0
            k = work.tangent[r - n_joint - n]
        elif r >= n_joint:
            k = r - n_joint
        if k >= 0 and memory.matched[k] >= 0:
            p -= h * memory.resting.load[memory.matched[k], 1 - part]
        before = row_velocity(work.rows, work.row_body, r, work.dof, memory.v_new)
        done = 0.5 * p * (before + row_velocity(work.rows, work.row_body, r, work.dof, work.free_u))
        if k >= 0:
            gained += done
            if part == 0:
                tape.counts.lost_friction -= done
            else:
                tape.counts.lost_impacts -= done
            tape.total_impulse[work.table.law[k], 1 - part] += p
        elif work.rate[r] != 0.0:
            tape.counts.supplied += done
    note_gain(tape, t, gained)


@kernel
def broken(settings: AlphaSettings, work: Workspace, memory: AlphaMemory) -> bool:
    """Whether the acceleration jumps at the end of the step: a contact closed, opened, or changed its slip."""
    n_joint = work.n_joint
    n = work.n_contacts
    kept = 0
    for k in range(n):
        i = memory.matched[k]
        carries = work.p[n_joint + k] > 0.0
        if carries and i < 0:
            return True
        if carries:
            kept += 1
    if kept != memory.resting.count:
        return True
    for j in range(work.n_tangents):
        i = memory.matched[work.tangent[j]]
        if i >= 0 and memory.resting.mode[i] != STICKING:
            slip = row_velocity(work.rows, work.row_body, n_joint + n + j, work.dof, work.free_u)
            if slip_mode(slip, settings.velocity_threshold) != memory.resting.mode[i]:
                return True
    return False


@kernel
def apply_velocity(
    settings: AlphaSettings, t: float, q: FloatArray, u: FloatArray, work: Workspace, memory: AlphaMemory, tape: Tape
) -> bool:
    """The state at the end of the step, in place. False where it is not finite."""
    keep_doubtful(work, t)
    distribute(work)
    n_joint = work.n_joint
    total = n_joint + work.n_contacts + work.n_tangents
    apply_impulses(work.solved, work.row_body, 0, total, work.p, work.dof, work.free_u)
    audit(settings, t, u, work, memory, tape)
    for r in range(n_joint):
        tape.counts.worst_drift = max(tape.counts.worst_drift, abs(work.residual[r]))
    for k in range(work.n_contacts):
        tape.counts.worst_penetration = max(tape.counts.worst_penetration, -work.table.gap[k])
    jumps = broken(settings, work, memory)
    finite = True
    for i in range(len(q)):
        q[i] = memory.q_new[i]
        u[i] = work.free_u[i]
        memory.a[i] = memory.a_new[i]
        memory.w[i] = memory.w_new[i]
        finite = finite and math.isfinite(q[i] + u[i])
    copy_end(memory.end, memory.start)
    memory.phase = RESTART if jumps else SMOOTH
    memory.turn = 0
    memory.between = 1
    return finite


@kernel
def predict(
    model: Model,
    settings: AlphaSettings,
    t: float,
    q: FloatArray,
    u: FloatArray,
    work: Workspace,
    memory: AlphaMemory,
) -> int:
    """Pose the next contact problem of the step from t; returns the contacts found, which must fit into the table."""
    h = settings.step
    memory.between = 0
    if memory.phase <= SMOOTH:
        length = h if memory.phase == SMOOTH else 0.0
        return pose_smooth(model, settings, length, t, q, u, work, memory)
    n = memory.n_found
    if memory.phase == POSITION:
        n = pose_position(model, settings, t + h, work, memory)
    if memory.phase == VELOCITY:
        pose_velocity(model, settings, t + h, u, work, memory)
    return n


@kernel
def correct(
    model: Model,
    settings: AlphaSettings,
    t: float,
    q: FloatArray,
    u: FloatArray,
    work: Workspace,
    memory: AlphaMemory,
    tape: Tape,
) -> int:
    """Apply the solution of the problem posed: AGAIN where the step has more of them, STEPPED or NOT_FINITE."""
    note_certificate(work, tape)
    if memory.phase <= SMOOTH:
        length = settings.step if memory.phase == SMOOTH else 0.0
        apply_smooth(settings, length, q, u, work, memory)
        return AGAIN
    if memory.phase == POSITION:
        apply_position(model, settings, work, memory, tape)
        return AGAIN
    if apply_velocity(settings, t, q, u, work, memory, tape):
        return STEPPED
    return RunStatus.NOT_FINITE


@kernel
def give_up_smooth(memory: AlphaMemory) -> bool:
    """After an unsolved problem: whether it was one of accelerations, without which the impulses of the step do."""
    if memory.phase > SMOOTH or memory.n_found == 0:
        return False
    memory.skip = 1
    memory.turn = 0
    return True
