"""Generalised forces of springs, dampers, forces and torques."""

from __future__ import annotations

import math

from lcpflex.dynamics.load_means import force_value
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.kinematics.points import (
    add_point_row,
    add_rotation_row,
    point_angle,
    point_position,
    point_velocity,
)
from lcpflex.model.arrays import Model

__all__ = ["applied_forces", "spring_energy"]

SMALLEST_LENGTH = 1e-300  # [m] a shorter vector has no direction


@kernel
def push(model: Model, q: FloatArray, p: int, fx: float, fy: float, force: FloatArray) -> None:
    """force += generalised force of (fx, fy) [N, world axes] at point p."""
    b = model.points.body[p]
    if b >= 0:
        block = force[model.bodies.dof[b] : model.bodies.dof[b + 1]]
        add_point_row(model.bodies, model.points, q, p, fx, fy, block)


@kernel
def twist(model: Model, p: int, torque: float, force: FloatArray) -> None:
    """force += generalised force of a torque [N m] on the material at point p."""
    b = model.points.body[p]
    if b >= 0:
        add_rotation_row(model.bodies, model.points, p, torque, force[model.bodies.dof[b] : model.bodies.dof[b + 1]])


@kernel
def spring_forces(
    model: Model, q: FloatArray, u: FloatArray, conservative: FloatArray, dissipative: FloatArray
) -> None:
    """Forces -k (L - L0) and -c Ldot along each spring; torques -k (angle - angle0) and -c rate of torsional ones."""
    bodies = model.bodies
    points = model.points
    for k in range(len(model.loads.spring_kind)):
        i = model.loads.spring_point[k, 0]
        j = model.loads.spring_point[k, 1]
        stiffness = model.loads.spring_value[k, 0]
        damping = model.loads.spring_value[k, 1]
        free = model.loads.spring_value[k, 2]
        if model.loads.spring_kind[k] == 1:
            torque = -stiffness * (point_angle(bodies, points, q, i) - point_angle(bodies, points, q, j) - free)
            twist(model, i, torque, conservative)
            twist(model, j, -torque, conservative)
            torque = -damping * (point_angle(bodies, points, u, i) - point_angle(bodies, points, u, j))
            twist(model, i, torque, dissipative)
            twist(model, j, -torque, dissipative)
        else:
            xi, yi = point_position(bodies, points, q, i)
            xj, yj = point_position(bodies, points, q, j)
            length = math.hypot(xi - xj, yi - yj)
            if length < SMALLEST_LENGTH:
                continue
            ex = (xi - xj) / length
            ey = (yi - yj) / length
            tension = -stiffness * (length - free)
            push(model, q, i, tension * ex, tension * ey, conservative)
            push(model, q, j, -tension * ex, -tension * ey, conservative)
            vxi, vyi = point_velocity(bodies, points, q, u, i)
            vxj, vyj = point_velocity(bodies, points, q, u, j)
            tension = -damping * (ex * (vxi - vxj) + ey * (vyi - vyj))
            push(model, q, i, tension * ex, tension * ey, dissipative)
            push(model, q, j, -tension * ex, -tension * ey, dissipative)


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
        p = model.loads.force_point[k]
        fx = force_value(model.signals, model.loads.force_signal[k, 0], t, span, external)
        if model.loads.force_kind[k] == 2:
            twist(model, p, fx, driving)
            continue
        fy = force_value(model.signals, model.loads.force_signal[k, 1], t, span, external)
        if model.loads.force_kind[k] == 1:
            angle = point_angle(model.bodies, model.points, q, p)
            cos = math.cos(angle)
            sin = math.sin(angle)
            push(model, q, p, cos * fx - sin * fy, sin * fx + cos * fy, driving)
        else:
            push(model, q, p, fx, fy, driving)


@kernel
def spring_energy(model: Model, q: FloatArray) -> float:
    """Energy stored in all springs, the sum of k (L - L0)^2 / 2 and k (angle - angle0)^2 / 2 [J]."""
    energy = 0.0
    for k in range(len(model.loads.spring_kind)):
        i = model.loads.spring_point[k, 0]
        j = model.loads.spring_point[k, 1]
        if model.loads.spring_kind[k] == 1:
            size = point_angle(model.bodies, model.points, q, i) - point_angle(model.bodies, model.points, q, j)
        else:
            xi, yi = point_position(model.bodies, model.points, q, i)
            xj, yj = point_position(model.bodies, model.points, q, j)
            size = math.hypot(xi - xj, yi - yj)
        stretch = size - model.loads.spring_value[k, 2]
        energy += 0.5 * model.loads.spring_value[k, 0] * stretch * stretch
    return energy
