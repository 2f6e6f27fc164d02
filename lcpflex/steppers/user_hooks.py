"""What steppers ask of a user's own system beside its mechanics.

Where velocities are not the rates of q: how they turn on, and what errors are as velocities. Where M depends on q and
``force`` has no known potential: the work of that,

    d/dt (u^T M u / 2) = u^T h + u^T (dM/dt) u / 2,

for h holds what balances it, as the centrifugal force of a radius that changes. Methods that integrate the work, or
take it at both ends of a step, see dM/dt u / 2 as one more driving force. Those of one force a step, at the middle q_m,
conserve u^T M(q_m) u / 2 but for the work of h: theirs is u+^T (M+ - M_m) u+ / 2 + u^T (M_m - M) u / 2.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from lcpflex.dynamics import mechanics
from lcpflex.dynamics.user_mechanics import Mechanics
from lcpflex.dynamics.workspace import Workspace
from lcpflex.jit.dispatch import Hooks, Kernel, link
from lcpflex.jit.kernel import FloatArray
from lcpflex.model.arrays import Model
from lcpflex.steppers import unmet
from lcpflex.steppers.backup import Backup
from lcpflex.steppers.moreau_jean import step
from lcpflex.steppers.recorder import Recorder
from lcpflex.steppers.smooth import explicit
from lcpflex.steppers.smooth.memory import WORK

__all__ = ["hooks_of_steps"]


def hooks_of_steps(system: Mechanics, known: Hooks) -> Hooks:
    """Replacements beside the ``known`` ones of its mechanics; none for the plainest, where qdot = u."""
    moving = _moving_hooks(system, known)
    return {**moving, **_inertia_hooks(system, {**known, **moving})} if system.books_inertia else moving


def _inertia_hooks(system: Mechanics, known: Hooks) -> Hooks:
    """Replacements that book the power u^T (dM/dt) u / 2."""
    forces, audit, kick_again = known[mechanics.forces], link(step.audit, known), link(explicit.kick_again, known)
    moved = system.kinematics.moved
    pull = np.zeros(system.n)  # dM/dt u / 2 where forces were taken last

    def forces_and_pull(model: Model, t: float, q: FloatArray, u: FloatArray, work: Workspace) -> None:
        forces(model, t, q, u, work)
        pull[:] = 0.5 * system.mass_rate(q, u) @ u
        work.free.driving += pull  # which counts for energies alone: work.free.total is what moves

    def over_step(h: float, places: tuple[FloatArray, ...], u: FloatArray, end: FloatArray) -> float:
        # what changes of M over a step did, less what the audit has taken of ``pull``
        before, middle, after = (system.mass(q) for q in places)
        done = 0.5 * (end @ (after - middle) @ end + u @ (middle - before) @ u)
        return float(done - 0.5 * h * pull @ (u + end))

    def audit_step(model: Model, scheme: Any, t: float, work: Workspace, recorder: Recorder) -> None:
        audit(model, scheme, t, work, recorder)
        h, u, end = scheme.step, scheme.u, work.free.u
        after = moved(scheme.q, scheme.theta * end + (1.0 - scheme.theta) * u, h)
        recorder.counts.supplied += over_step(h, (scheme.q, work.free.middle, after), u, end)

    def kick(model: Model, h: float, work: Workspace, memory: Any) -> None:
        kick_again(model, h, work, memory)
        nq, base = memory.nq, memory.nq + system.n
        middle, u, end = memory.end[:nq], memory.y[nq:base], memory.end[nq:base]
        places = memory.y[:nq], middle, moved(middle, end, 0.5 * h)
        memory.end[base + WORK] += over_step(h, places, u, end)

    return {mechanics.forces: forces_and_pull, step.audit: audit_step, explicit.kick_again: kick}


def _moving_hooks(system: Mechanics, known: Hooks) -> Hooks:
    """Replacements for what moves configurations and bodies; none where qdot = u and contacts are planar."""
    if not system.kinematics.own:
        return _without_bodies(system) if system.has_cones else {}
    forces = known[mechanics.forces]
    asked_at = [0.0]

    def forces_noted(model: Model, t: float, q: FloatArray, u: FloatArray, work: Workspace) -> None:
        asked_at[0] = t
        forces(model, t, q, u, work)

    def turn_on(model: Model, passes: int, h: float, u: FloatArray, work: Workspace) -> bool:
        # such forces at the velocity before a step, as omega x J omega, gain energy in each step
        t, q = asked_at[0], work.free.middle
        before = system.force(t, q, u)
        kind = work.free.conservative if system.has_potential else work.free.driving
        for _ in range(passes):
            after = system.force(t, q, 0.5 * (u + work.free.u))
            change = after - before
            kind += change
            work.free.total += change
            change *= h
            known[mechanics.solve_vector](model, work, change)
            work.free.u += change
            before = after
        return True

    return {mechanics.forces: forces_noted, step.turn_on: turn_on, unmet.on_way: _on_way(system)}


def _on_way(system: Mechanics) -> Kernel:
    """What goes along a step by the cubic that has the configurations and their rates at both ends."""
    moves = system.kinematics

    def on_way(model: Model, q: FloatArray, u: FloatArray, h: float, share: float, kept: Backup) -> None:
        left = 1.0 - share
        way = share * share * (3.0 - 2.0 * share) * (q - kept.q)
        bent = h * share * left * (left * moves.rate(kept.q, kept.u) - share * moves.rate(q, u))
        kept.at[:] = moves.normalised(kept.q + way + bent)

    return on_way


def _without_bodies(system: Mechanics) -> Hooks:
    """What kernels of space would do to bodies, of which such a system has none."""

    def turn_on(model: Model, passes: int, h: float, u: FloatArray, work: Workspace) -> bool:
        return True

    return {step.turn_on: turn_on, unmet.on_way: _on_way(system)}
