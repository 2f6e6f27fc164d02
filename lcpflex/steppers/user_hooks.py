"""What steppers ask of a user's own system beside its mechanics, where velocities are not the rates of q."""

from __future__ import annotations

import numpy as np

from lcpflex.dynamics import mechanics
from lcpflex.dynamics.user_mechanics import Mechanics
from lcpflex.dynamics.workspace import Workspace
from lcpflex.jit.dispatch import Hooks, Kernel
from lcpflex.jit.kernel import FloatArray
from lcpflex.model.arrays import Model
from lcpflex.steppers import runge_kutta
from lcpflex.steppers.moreau_jean import step

__all__ = ["hooks_of_steps"]


def hooks_of_steps(system: Mechanics, known: Hooks) -> Hooks:
    """Replacements beside the ``known`` ones of its mechanics; none where qdot = u and contacts are planar."""
    if not system.kinematics.own:
        return _without_bodies(system) if system.has_cones else {}
    forces = known[mechanics.forces]
    asked_at = [0.0]

    def forces_noted(model: Model, t: float, q: FloatArray, u: FloatArray, work: Workspace) -> None:
        asked_at[0] = t
        forces(model, t, q, u, work)

    def turn_on(model: Model, passes: int, h: float, u: FloatArray, work: Workspace) -> bool:
        # such forces at the velocity before a step, as omega x J omega, gain energy in each step
        t, q = asked_at[0], work.middle
        before = system.force(t, q, u)
        kind = work.conservative if system.has_potential else work.driving
        for _ in range(passes):
            after = system.force(t, q, 0.5 * (u + work.free_u))
            change = after - before
            kind += change
            work.total += change
            change *= h
            known[mechanics.solve_vector](model, work, change)
            work.free_u += change
            before = after
        return True

    return {mechanics.forces: forces_noted, step.turn_on: turn_on, runge_kutta.add_errors: _add_errors(system)}


def _add_errors(system: Mechanics) -> Kernel:
    """What adds the errors of a Runge-Kutta step, as velocities."""

    def add_errors(model: Model, y: FloatArray, slopes: FloatArray, h: float, sums: FloatArray) -> None:
        nq, nu = system.kinematics.nq, system.n
        error = runge_kutta.EXTRAPOLATED * h * (runge_kutta.E @ slopes[:, : nq + nu])
        sums[0] += np.abs(system.kinematics.velocity(y[:nq], error[:nq]))
        sums[1] += np.abs(error[nq:])

    return add_errors


def _without_bodies(system: Mechanics) -> Hooks:
    """What kernels of space would do to bodies, of which such a system has none."""

    def turn_on(model: Model, passes: int, h: float, u: FloatArray, work: Workspace) -> bool:
        return True

    return {step.turn_on: turn_on, runge_kutta.add_errors: _add_errors(system)}
