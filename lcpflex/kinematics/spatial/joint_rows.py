"""Bilateral constraints phi(q, t) = 0 of joints in space: residuals, Jacobian rows and accelerations.

Each row prescribes one relative coordinate c of the points P and Q of its joint
(:mod:`lcpflex.kinematics.spatial.relative`), as :mod:`lcpflex.kinematics.joint_rows` tells for the plane:

    phi = c - rest - f(t),   phidot = J u - f',   phiddot = J udot + bias - f''.
"""

from __future__ import annotations

from lcpflex.jit.kernel import FloatArray, IntArray, kernel
from lcpflex.kinematics.signal_values import signal_value
from lcpflex.kinematics.spatial.relative import (
    Directions,
    add_gradient,
    apart,
    coordinate_bias,
    coordinate_gradient,
    coordinate_value,
    off_rest,
    relative_motion,
)
from lcpflex.kinematics.spatial.vectors import row_vector
from lcpflex.model.spatial import SpatialJoints, SpatialModel

__all__ = ["joint_residual", "joint_rows"]


@kernel
def directions(joints: SpatialJoints, r: int) -> Directions:
    """Of row r."""
    return Directions(row_vector(joints.axis, r), row_vector(joints.on_p, r), row_vector(joints.on_q, r))


@kernel
def joint_residual(model: SpatialModel, t: float, q: FloatArray, external: FloatArray, phi: FloatArray) -> None:
    """phi(q, t) of all joints, ``joints.row[-1]`` values [m] or [rad]; angles in (-pi, pi]."""
    joints = model.joints
    for joint in range(len(joints.point)):
        at, _ = apart(model.bodies, model.points, q, joints.point[joint, 0], joints.point[joint, 1])
        for r in range(joints.row[joint], joints.row[joint + 1]):
            f = 0.0
            if joints.signal[r] >= 0:
                f, _, _ = signal_value(model.signals, joints.signal[r], t, external)
            kind = joints.kind[r]
            phi[r] = off_rest(kind, coordinate_value(kind, at, directions(joints, r)) - joints.rest[r] - f)


@kernel
def joint_rows(
    model: SpatialModel,
    t: float,
    q: FloatArray,
    u: FloatArray,
    external: FloatArray,
    rows: FloatArray,
    row_body: IntArray,
    wrench: FloatArray,
    rate: FloatArray,
    bias: FloatArray,
) -> None:
    """The rows J of all joints by body block, with phidot = J u + rate and phiddot = J udot + bias.

    rows (R, 2, width), row_body (R, 2), rate (R,) [m/s] or [rad/s], bias (R,) [m/s^2] or [rad/s^2]: the first
    ``joints.row[-1]`` of each are overwritten. Block 0 belongs to the body of P, block 1 to that of Q; body -1 is the
    ground. wrench: the force on the body of P, at P, and the moment that a multiplier 1 of each row makes, (R, 6) F, M,
    world axes.
    """
    joints = model.joints
    bodies = model.bodies
    points = model.points
    for r in range(joints.row[-1]):
        for k in range(rows.shape[2]):
            rows[r, 0, k] = 0.0
            rows[r, 1, k] = 0.0
    for joint in range(len(joints.point)):
        i = joints.point[joint, 0]
        j = joints.point[joint, 1]
        at, arms = apart(bodies, points, q, i, j)
        motion = relative_motion(bodies, points, u, i, j, arms)
        for r in range(joints.row[joint], joints.row[joint + 1]):
            row_body[r, 0] = points.body[i]
            row_body[r, 1] = points.body[j]
            way = directions(joints, r)
            gradient = coordinate_gradient(joints.kind[r], at, way)
            add_gradient(points, (i, j), arms, gradient, 1.0, rows[r, 0], rows[r, 1])
            for k in range(3):
                wrench[r, k] = gradient.g[k]
                wrench[r, 3 + k] = gradient.at_p[k]
            rate[r] = 0.0
            bias[r] = coordinate_bias(joints.kind[r], at, motion, way)
            if joints.signal[r] >= 0:
                _, f_rate, f_acceleration = signal_value(model.signals, joints.signal[r], t, external)
                rate[r] = -f_rate
                bias[r] -= f_acceleration
