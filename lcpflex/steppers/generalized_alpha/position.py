"""The position problem of a generalised-alpha step: no drift of joints, no penetration.

See :mod:`lcpflex.steppers.generalized_alpha.stepper` for the scheme.
"""

from __future__ import annotations

from lcpflex.contact.detection import detect
from lcpflex.contact.narrow_phase.feature import refresh
from lcpflex.dynamics.acceleration import SMOOTH as FRICTIONLESS
from lcpflex.dynamics.contact_problem import lay_contacts
from lcpflex.dynamics.impulse import answer_joints
from lcpflex.dynamics.large_island import prepare_large
from lcpflex.dynamics.mechanics import count_rows, displace, energies, supply
from lcpflex.dynamics.workspace import Workspace
from lcpflex.jit.kernel import kernel
from lcpflex.kinematics.joint_rows import joint_residual
from lcpflex.model.arrays import Model
from lcpflex.steppers.event_driven.memory import copy_entry
from lcpflex.steppers.generalized_alpha.memory import (
    VELOCITY,
    AlphaScheme,
    hold,
    match,
)
from lcpflex.steppers.generalized_alpha.smooth import assemble_rows
from lcpflex.steppers.recorder import Recorder

__all__ = ["apply_position", "gather_pressed", "pose_position", "position_error"]

MOST_LIFTS = 8  # passes of the position problem
CLOSED = 2e-14  # times 1 + |q|: drift and penetration that are left


@kernel
def gather_pressed(model: Model, work: Workspace, scheme: AlphaScheme) -> int:
    """Closed pairs at the present configuration, and those that carried something in the last pass; their number."""
    n = detect(model, scheme.q_new, scheme.gap_tolerance, work.rows.table)
    pressed = scheme.pressed
    if n + pressed.count > len(work.rows.table.key):
        return n + pressed.count
    match(work.rows.table, n, pressed, scheme.matched)
    for k in range(n):
        i = scheme.matched[k]
        scheme.total[k] = pressed.load[i, 0] if i >= 0 else 0.0
    for i in range(pressed.count):
        if pressed.taken[i] == 0:
            copy_entry(pressed.table, i, work.rows.table, n)
            refresh(model, scheme.q_new, work.rows.table, n)
            scheme.total[n] = pressed.load[i, 0]
            n += 1
    return n


@kernel
def position_error(model: Model, t: float, n: int, work: Workspace, scheme: AlphaScheme) -> float:
    """Largest violation of joints, of closed gaps that carry and of all others below zero [m or rad]."""
    n_joint = len(work.scratch.residual)
    worst = 0.0
    if n_joint > 0:
        supply(model, t, scheme.q_new, scheme.v_new, work)
        joint_residual(model, t, scheme.q_new, work.free.external, work.scratch.residual)
    for r in range(n_joint):
        worst = max(worst, abs(work.scratch.residual[r]))
    for k in range(n):
        gap = work.rows.table.gap[k]
        worst = max(worst, abs(gap) if scheme.total[k] > 0.0 else -gap)
    return worst


@kernel
def pose_position(model: Model, t: float, work: Workspace, scheme: AlphaScheme) -> int:
    """0 <= g + W^T A^-1 W (nu - nu_last) _|_ nu >= 0 and phi = 0 at t; where they hold, the velocity problem is next.

    nu [N s] times the step moves the configuration. That of a resting contact starts at half of its impulse: without
    its force it would penetrate, so it stays closed unless that is taken away from it.
    """
    n = gather_pressed(model, work, scheme)
    if n > len(work.rows.table.key):
        return n
    largest = 0.0
    for i in range(len(scheme.q_new)):
        largest = max(largest, abs(scheme.q_new[i]))
    worst = position_error(model, t, n, work, scheme)
    if scheme.turn == 0:
        note_depths(n, work, scheme)
    if worst <= CLOSED * (1.0 + largest) or scheme.turn >= MOST_LIFTS:
        scheme.phase = VELOCITY
        scheme.n_found = n
        return n
    h = scheme.step
    scale = h * h * scheme.beta * (1.0 - scheme.alpha_f) / (1.0 - scheme.alpha_m)
    assemble_rows(model, t, scale / h, scale, n, work, scheme)
    n_joint = work.rows.n_joint
    count_rows(work.rows, n_joint, n, 0)
    for r in range(n_joint):
        work.free.v[r] = work.scratch.residual[r] / h
    for k in range(n):
        work.free.v[n_joint + k] = work.rows.table.gap[k] / h
        work.free.terms[k] = 0.0
        work.posed.counted[k] = scheme.total[k]
    lay_contacts(work)
    prepare_large(model, work)
    work.posed.lifted = 1
    scheme.warm = 1
    return n


@kernel
def note_depths(n: int, work: Workspace, scheme: AlphaScheme) -> None:
    """How deep the n contacts of the table are before they are lifted."""
    table, deep = work.rows.table, scheme.deep
    match(table, n, scheme.resting, scheme.matched)
    for k in range(n):
        deep[table.law[k]] = 0.0
    for k in range(n):
        scheme.lifted = max(scheme.lifted, -table.gap[k])
        if scheme.matched[k] < 0:
            scheme.struck_at = max(scheme.struck_at, -table.gap[k])
            deep[table.law[k]] = max(deep[table.law[k]], -table.gap[k])


@kernel
def apply_position(model: Model, work: Workspace, scheme: AlphaScheme, recorder: Recorder) -> None:
    """Move the configuration; what that does to the energy of bodies that have just met counts as loss by impact."""
    n_joint = work.rows.n_joint
    n = work.rows.n_contacts
    meet = False
    for k in range(n):
        pressed = work.impulses.p[n_joint + k]
        work.impulses.normal[k] = pressed
        work.impulses.p[n_joint + k] = pressed - scheme.total[k]
        meet = meet or (pressed > 0.0 and scheme.total[k] == 0.0)
    answer_joints(work)
    for r in range(n_joint + n):
        work.impulses.p[r] *= scheme.step
    scheme.pressed.count = 0
    for k in range(n):
        if work.impulses.normal[k] > 0.0:
            hold(work.rows.table, k, work.impulses.normal[k], FRICTIONLESS, scheme.pressed)
    sign = 1.0
    for _ in range(2 if meet else 1):
        if meet:
            kinetic, elastic, potential = energies(model, scheme.q_new, scheme.v_new, work)
            recorder.counts.lost_impacts += sign * (kinetic + elastic + potential)
        if sign > 0.0:
            displace(model, work.rows, 0, n_joint + n, work.impulses.p, scheme.q_new)
        sign = -1.0
    scheme.turn += 1
