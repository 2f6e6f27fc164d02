"""The position problem of a generalised-alpha step: no drift of joints, no penetration.

See :mod:`lcpflex.steppers.generalized_alpha.stepper` for the scheme.
"""

from __future__ import annotations

from lcpflex.contact.detection import detect
from lcpflex.contact.narrow_phase.feature import refresh
from lcpflex.dynamics.acceleration import SMOOTH as FRICTIONLESS
from lcpflex.dynamics.contact_problem import pose_contacts
from lcpflex.dynamics.delassus import apply_impulses, joint_impulses
from lcpflex.dynamics.mechanics import energies, supply
from lcpflex.dynamics.workspace import Workspace
from lcpflex.jit.kernel import kernel
from lcpflex.kinematics.joint_rows import joint_residual
from lcpflex.model.arrays import Model
from lcpflex.steppers.event_driven.memory import copy_entry
from lcpflex.steppers.generalized_alpha.memory import (
    VELOCITY,
    AlphaMemory,
    hold,
    match,
)
from lcpflex.steppers.generalized_alpha.smooth import AlphaSettings, lay
from lcpflex.steppers.recorder import Tape

__all__ = ["apply_position", "gather_pressed", "pose_position", "position_error"]

MOST_LIFTS = 8  # passes of the position problem
CLOSED = 2e-14  # times 1 + |q|: drift and penetration that are left


@kernel
def gather_pressed(model: Model, settings: AlphaSettings, work: Workspace, memory: AlphaMemory) -> int:
    """Closed pairs at the present configuration, and those that carried something in the last pass; their number."""
    n = detect(model, memory.q_new, settings.gap_tolerance, work.table)
    pressed = memory.pressed
    if n + pressed.count > len(work.table.key):
        return n + pressed.count
    for i in range(pressed.count):
        memory.matched[i] = 0
    near = n
    for k in range(near):
        memory.total[k] = 0.0
        i = match(work.table, k, pressed)
        if i >= 0 and memory.matched[i] == 0:
            memory.total[k] = pressed.load[i, 0]
            memory.matched[i] = 1
    for i in range(pressed.count):
        if memory.matched[i] == 0:
            copy_entry(pressed.table, i, work.table, n)
            refresh(model, memory.q_new, work.table, n)
            memory.total[n] = pressed.load[i, 0]
            n += 1
    return n


@kernel
def position_error(model: Model, t: float, n: int, work: Workspace, memory: AlphaMemory) -> float:
    """Largest violation of joints, of closed gaps that carry and of all others below zero [m or rad]."""
    n_joint = len(work.residual)
    worst = 0.0
    if n_joint > 0:
        supply(model, t, memory.q_new, memory.v_new, work)
        joint_residual(model, t, memory.q_new, work.external, work.residual)
    for r in range(n_joint):
        worst = max(worst, abs(work.residual[r]))
    for k in range(n):
        gap = work.table.gap[k]
        worst = max(worst, abs(gap) if memory.total[k] > 0.0 else -gap)
    return worst


@kernel
def pose_position(model: Model, settings: AlphaSettings, t: float, work: Workspace, memory: AlphaMemory) -> int:
    """0 <= g + W^T A^-1 W (nu - nu_last) _|_ nu >= 0 and phi = 0 at t; where they hold, the velocity problem is next.

    nu [N s] times the step moves the configuration. That of a resting contact starts at half of its impulse: without
    its force it would penetrate, so it stays closed unless that is taken away from it.
    """
    n = gather_pressed(model, settings, work, memory)
    if n > len(work.table.key):
        return n
    largest = 0.0
    for i in range(len(memory.q_new)):
        largest = max(largest, abs(memory.q_new[i]))
    worst = position_error(model, t, n, work, memory)
    if memory.turn == 0:
        for k in range(n):
            memory.lifted = max(memory.lifted, -work.table.gap[k])
            if -work.table.gap[k] > memory.struck_at and match(work.table, k, memory.resting) < 0:
                memory.struck_at = -work.table.gap[k]
    if worst <= CLOSED * (1.0 + largest) or memory.turn >= MOST_LIFTS:
        memory.phase = VELOCITY
        memory.n_found = n
        return n
    h = settings.step
    scale = h * h * settings.beta * (1.0 - settings.alpha_f) / (1.0 - settings.alpha_m)
    lay(model, t, scale / h, scale, n, work, memory)
    n_joint = work.n_joint
    work.n_tangents = 0
    for r in range(n_joint):
        work.free[r] = work.residual[r] / h
    for k in range(n):
        work.free[n_joint + k] = work.table.gap[k] / h
    pose_contacts(work)
    problem = work.problem
    for k in range(n):
        for c in range(n):
            problem.free[k] -= problem.delassus[k, c] * memory.total[c]
    memory.warm = 1
    return n


@kernel
def apply_position(model: Model, settings: AlphaSettings, work: Workspace, memory: AlphaMemory, tape: Tape) -> None:
    """Move the configuration; what that does to the energy of bodies that have just met counts as loss by impact."""
    n_joint = work.n_joint
    n = work.n_contacts
    meet = False
    for k in range(n):
        work.p[n_joint + k] = work.solver.normal[k] - memory.total[k]
        meet = meet or (work.solver.normal[k] > 0.0 and memory.total[k] == 0.0)
    joint_impulses(work.free, n_joint, n_joint + n, work.lower, work.share, work.p)
    for r in range(n_joint + n):
        work.p[r] *= settings.step
    memory.pressed.count = 0
    for k in range(n):
        if work.solver.normal[k] > 0.0:
            hold(work.table, k, work.solver.normal[k], 0.0, FRICTIONLESS, memory.pressed)
    sign = 1.0
    for _ in range(2 if meet else 1):
        if meet:
            kinetic, elastic, potential = energies(model, memory.q_new, memory.v_new, work)
            tape.counts.lost_impacts += sign * (kinetic + elastic + potential)
        if sign > 0.0:
            apply_impulses(work.solved, work.row_body, 0, n_joint + n, work.p, work.dof, memory.q_new)
        sign = -1.0
    memory.turn += 1
