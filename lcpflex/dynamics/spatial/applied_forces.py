"""Generalised forces of springs, dampers, forces and torques in space.

A spring or damper resists a relative coordinate c of two points (:mod:`lcpflex.kinematics.spatial.relative`): its force
-k (c - rest) - d cdot along c does its work by the gradient of c. A force or torque is a function of time, in world
axes or, a follower, in axes that turn with the material. To add one of a new kind: as in the plane
(:mod:`lcpflex.dynamics.applied_forces`).
"""

from __future__ import annotations

import math

from lcpflex.dynamics.load_means import force_value
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.kinematics.spatial.points import add_wrench, arm_of, material_axes
from lcpflex.kinematics.spatial.relative import (
    Apart,
    Directions,
    add_gradient,
    apart,
    coordinate_gradient,
    coordinate_rate,
    coordinate_value,
    off_rest,
    relative_motion,
    twist,
)
from lcpflex.kinematics.spatial.rotations import Vector
from lcpflex.kinematics.spatial.vectors import NOTHING, row_vector, turned
from lcpflex.model.spatial import SpatialLoads, SpatialModel

__all__ = [
    "EFFORTS",
    "FOLLOWER",
    "FORCE",
    "TORQUE",
    "TORQUE_FOLLOWER",
    "WOUND",
    "effort",
    "spring_forces",
    "spring_stretch",
    "spring_twist",
]

EFFORTS = ("force", "follower", "torque", "torque follower")  # world axes, those of the material; the same of torques
FORCE, FOLLOWER, TORQUE, TORQUE_FOLLOWER = range(len(EFFORTS))
WOUND = math.radians(170.0)  # a state does not tell whole turns: springs that twist have no force beyond, but NaN


@kernel
def directions(loads: SpatialLoads, k: int) -> Directions:
    """Of the coordinate of spring k."""
    return Directions(
        row_vector(loads.spring_axis, k), row_vector(loads.spring_on_p, k), row_vector(loads.spring_on_q, k)
    )


@kernel
def stretch(kind: int, at: Apart, way: Directions, rest: float) -> float:
    """c - rest of a spring [m] or [rad]; NaN where it is twisted by more than WOUND."""
    if not twist(kind, at, way, rest) <= WOUND:
        return math.nan
    return off_rest(kind, coordinate_value(kind, at, way) - rest)


@kernel
def spring_twist(model: SpatialModel, q: FloatArray, k: int) -> float:
    """How far spring k is turned out of its rest [rad], either way."""
    loads = model.loads
    at, _ = apart(model.bodies, model.points, q, loads.spring_point[k, 0], loads.spring_point[k, 1])
    return twist(loads.spring_kind[k], at, directions(loads, k), loads.spring_value[k, 2])


@kernel
def spring_stretch(model: SpatialModel, q: FloatArray, k: int) -> float:
    """c - rest of spring k [m] or [rad]; NaN where it is twisted by more than WOUND."""
    loads = model.loads
    at, _ = apart(model.bodies, model.points, q, loads.spring_point[k, 0], loads.spring_point[k, 1])
    return stretch(loads.spring_kind[k], at, directions(loads, k), loads.spring_value[k, 2])


@kernel
def spring_forces(
    model: SpatialModel, q: FloatArray, u: FloatArray, conservative: FloatArray, dissipative: FloatArray
) -> None:
    """Forces -k (c - rest) and -d cdot along the relative coordinate c of each spring."""
    loads = model.loads
    points = model.points
    dof = model.bodies.dof
    for k in range(len(loads.spring_kind)):
        i = loads.spring_point[k, 0]
        j = loads.spring_point[k, 1]
        kind = loads.spring_kind[k]
        way = directions(loads, k)
        at, arms = apart(model.bodies, points, q, i, j)
        gradient = coordinate_gradient(kind, at, way)
        b = points.body[i]
        c = points.body[j]
        tension = -loads.spring_value[k, 0] * stretch(kind, at, way, loads.spring_value[k, 2])
        on_p = conservative[dof[b] : dof[b + 1]]  # empty for the ground, body -1
        on_q = conservative[dof[c] : dof[c + 1]]
        add_gradient(points, (i, j), arms, gradient, tension, on_p, on_q)
        if loads.spring_value[k, 1] != 0.0:
            motion = relative_motion(model.bodies, points, u, i, j, arms)
            drag = -loads.spring_value[k, 1] * coordinate_rate(gradient, motion)
            on_p = dissipative[dof[b] : dof[b + 1]]
            on_q = dissipative[dof[c] : dof[c + 1]]
            add_gradient(points, (i, j), arms, gradient, drag, on_p, on_q)


@kernel
def components(model: SpatialModel, k: int, t: float, span: FloatArray, external: FloatArray) -> Vector:
    """Values of force or torque k at time t."""
    signal = model.loads.force_signal
    return (
        force_value(model.signals, signal[k, 0], t, span, external),
        force_value(model.signals, signal[k, 1], t, span, external),
        force_value(model.signals, signal[k, 2], t, span, external),
    )


@kernel
def effort(
    model: SpatialModel, q: FloatArray, k: int, t: float, span: FloatArray, external: FloatArray, force: FloatArray
) -> None:
    """Add the generalised force of force or torque k."""
    loads = model.loads
    p = loads.force_point[k]
    b = model.points.body[p]
    kind = loads.force_kind[k]
    arm = arm_of(model.bodies, model.points, q, p)
    f = components(model, k, t, span, external)
    if kind in (FOLLOWER, TORQUE_FOLLOWER):
        f = turned(material_axes(arm), f)
    block = force[model.bodies.dof[b] : model.bodies.dof[b + 1]]
    if kind in (FORCE, FOLLOWER):
        add_wrench(model.points, p, arm, f, NOTHING, block)
    else:
        add_wrench(model.points, p, arm, NOTHING, f, block)
