"""Generalised forces of springs, dampers, forces and torques.

A spring or damper resists a relative coordinate of two points (:mod:`lcpflex.kinematics.relative`); a force or torque
is a function of time. To add one of a new kind: its name in ``EFFORTS``, its branch in :func:`effort`, and the file in
:mod:`lcpflex.scene.loads` that names it.
"""

from __future__ import annotations

import math

from lcpflex.dynamics.load_means import force_value
from lcpflex.jit.kernel import FloatArray, kernel, late_kernel
from lcpflex.jit.leaf import in_space
from lcpflex.kinematics.points import Arm, add_point_row, add_rotation_row, point_angle
from lcpflex.kinematics.relative import add_gradient, apart, coordinate_gradient, coordinate_value, relative_motion
from lcpflex.model.arrays import Model

__all__ = [
    "EFFORTS",
    "FOLLOWER",
    "FORCE",
    "TORQUE",
    "applied_forces",
    "effort",
    "spring_energy",
    "spring_forces",
    "spring_stretch",
]

EFFORTS = ("force", "follower", "torque")  # in world axes; in axes that turn with the material; on the material
FORCE, FOLLOWER, TORQUE = range(len(EFFORTS))


@kernel
def add_forces(
    model: Model,
    arms: tuple[Arm, Arm],
    k: int,
    gradient: tuple[float, float, float, float, float],
    size: float,
    force: FloatArray,
) -> None:
    """Add a force or torque ``size`` along the coordinate of spring k."""
    i = model.loads.spring_point[k, 0]
    j = model.loads.spring_point[k, 1]
    dof = model.bodies.dof
    b = model.points.body[i]
    on_p = force[dof[b] : dof[b + 1]]  # empty for the ground, body -1
    b = model.points.body[j]
    on_q = force[dof[b] : dof[b + 1]]
    add_gradient(model.points, (i, j), arms, gradient, size, on_p, on_q)


@in_space("lcpflex.dynamics.spatial.applied_forces")
@kernel
def spring_stretch(model: Model, q: FloatArray, k: int) -> float:
    """c - rest of spring k [m] or [rad]."""
    loads = model.loads
    at = apart(model.bodies, model.points, q, loads.spring_point[k, 0], loads.spring_point[k, 1])
    axis = loads.spring_axis[k]
    return coordinate_value(loads.spring_kind[k], at, axis[0], axis[1]) - loads.spring_value[k, 2]


@in_space("lcpflex.dynamics.spatial.applied_forces")
@kernel
def spring_forces(
    model: Model, q: FloatArray, u: FloatArray, conservative: FloatArray, dissipative: FloatArray
) -> None:
    """Forces -k (c - rest) and -d cdot along the relative coordinate c of each spring."""
    bodies = model.bodies
    points = model.points
    loads = model.loads
    for k in range(len(loads.spring_kind)):
        i = loads.spring_point[k, 0]
        j = loads.spring_point[k, 1]
        axis = loads.spring_axis[k]
        at, motion, arms = relative_motion(bodies, points, q, u, i, j)
        gradient = coordinate_gradient(loads.spring_kind[k], at, motion, axis[0], axis[1])
        gx, gy, turn_p, turn_q, _ = gradient
        rate = gx * motion.vx + gy * motion.vy + turn_p * motion.spin_p + turn_q * motion.spin_q
        tension = -loads.spring_value[k, 0] * spring_stretch(model, q, k)
        add_forces(model, arms, k, gradient, tension, conservative)
        drag = -loads.spring_value[k, 1] * rate
        add_forces(model, arms, k, gradient, drag, dissipative)


@in_space("lcpflex.dynamics.spatial.applied_forces")
@late_kernel
def effort(
    model: Model, q: FloatArray, k: int, t: float, span: FloatArray, external: FloatArray, force: FloatArray
) -> None:
    """Add the generalised force of force or torque k."""
    loads = model.loads
    p = loads.force_point[k]
    b = model.points.body[p]
    block = force[model.bodies.dof[b] : model.bodies.dof[b + 1]]
    fx = force_value(model.signals, loads.force_signal[k, 0], t, span, external)
    if loads.force_kind[k] == TORQUE:
        add_rotation_row(model.points, p, fx, block)
        return
    fy = force_value(model.signals, loads.force_signal[k, 1], t, span, external)
    if loads.force_kind[k] == FOLLOWER:
        angle = point_angle(model.bodies, model.points, q, p)
        fx, fy = math.cos(angle) * fx - math.sin(angle) * fy, math.sin(angle) * fx + math.cos(angle) * fy
    add_point_row(model.bodies, model.points, q, p, fx, fy, block)


@kernel
def applied_forces(
    model: Model,
    t: float,
    q: FloatArray,
    u: FloatArray,
    span: FloatArray,
    external: FloatArray,
    conservative: FloatArray,
    dissipative: FloatArray,
    driving: FloatArray,
) -> None:
    """Add the generalised forces of springs, of dampers, and of forces and torques at time t, each (ndof,).

    ``span`` (2,) [s] before and after t over which forces and torques are averaged; ``external`` (slots, 3) holds what
    Python callbacks supply at t.
    """
    spring_forces(model, q, u, conservative, dissipative)
    for k in range(len(model.loads.force_kind)):
        effort(model, q, k, t, span, external, driving)


@kernel
def spring_energy(model: Model, q: FloatArray) -> float:
    """Energy stored in all springs, the sum of k (c - rest)^2 / 2 [J]."""
    energy = 0.0
    for k in range(len(model.loads.spring_kind)):
        size = spring_stretch(model, q, k)
        energy += 0.5 * model.loads.spring_value[k, 0] * size * size
    return energy
