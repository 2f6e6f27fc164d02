"""Bilateral constraints phi(q, t) = 0 of the joints: residuals, Jacobian rows and accelerations.

Each row prescribes one relative coordinate c of the points P and Q of its joint (:mod:`lcpflex.kinematics.relative`):

    phi = c - rest - f(t),   phidot = J u - f',   phiddot = J udot + bias - f''.
"""

from __future__ import annotations

from lcpflex.jit.kernel import FloatArray, IntArray, kernel
from lcpflex.jit.leaf import in_space
from lcpflex.kinematics.relative import add_gradient, apart, coordinate_gradient, coordinate_value, relative_motion
from lcpflex.kinematics.signal_values import signal_value
from lcpflex.model.arrays import Model

__all__ = ["joint_residual", "joint_rows"]


@kernel
def prescribed(model: Model, row: int, t: float, external: FloatArray) -> tuple[float, float, float]:
    """f, f', f'' of a row; 0 without a motion."""
    if model.joints.signal[row] < 0:
        return 0.0, 0.0, 0.0
    return signal_value(model.signals, model.joints.signal[row], t, external)


@in_space("lcpflex.kinematics.spatial.joint_rows")
@kernel
def joint_residual(model: Model, t: float, q: FloatArray, external: FloatArray, phi: FloatArray) -> None:
    """phi(q, t) of all joints, ``joints.row[-1]`` values [m] or [rad]."""
    joints = model.joints
    for joint in range(len(joints.point)):
        at = apart(model.bodies, model.points, q, joints.point[joint, 0], joints.point[joint, 1])
        for r in range(joints.row[joint], joints.row[joint + 1]):
            f, _, _ = prescribed(model, r, t, external)
            phi[r] = coordinate_value(joints.kind[r], at, joints.axis[r, 0], joints.axis[r, 1]) - joints.rest[r] - f


@in_space("lcpflex.kinematics.spatial.joint_rows")
@kernel
def joint_rows(
    model: Model,
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
    ground. wrench: the force on the body of P, at P, and the moment that a multiplier 1 of each row makes, (R, 3) F_x,
    F_y, M.
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
        at, motion, arms = relative_motion(bodies, points, q, u, i, j)
        for r in range(joints.row[joint], joints.row[joint + 1]):
            row_body[r, 0] = points.body[i]
            row_body[r, 1] = points.body[j]
            gradient = coordinate_gradient(joints.kind[r], at, motion, joints.axis[r, 0], joints.axis[r, 1])
            add_gradient(points, (i, j), arms, gradient, 1.0, rows[r, 0], rows[r, 1])
            wrench[r, 0], wrench[r, 1], wrench[r, 2] = gradient[0], gradient[1], gradient[2]
            _, f_rate, f_acceleration = prescribed(model, r, t, external)
            rate[r] = -f_rate
            bias[r] = gradient[4] - f_acceleration
