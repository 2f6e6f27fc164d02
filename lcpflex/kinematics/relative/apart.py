"""How two material points P and Q are placed and move relative to each other; the ground does neither."""

from __future__ import annotations

from typing import NamedTuple

from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.kinematics.points import point_angle, point_motion, point_position
from lcpflex.model.arrays import Bodies, Points

__all__ = ["Apart", "Motion", "apart", "relative_motion"]


class Apart(NamedTuple):
    """r = r_P - r_Q, world axes, and the angles of the material at both."""

    x: float  # [m]
    y: float
    angle_p: float  # [rad]
    angle_q: float


class Motion(NamedTuple):
    """rdot = v, rddot = L_P udot - L_Q udot + b, and the rates of the angles."""

    vx: float  # [m/s]
    vy: float
    bx: float  # [m/s^2]
    by: float
    spin_p: float  # [rad/s]
    spin_q: float


@kernel
def apart(bodies: Bodies, points: Points, q: FloatArray, i: int, j: int) -> Apart:
    """Of the points i = P and j = Q."""
    xi, yi = point_position(bodies, points, q, i)
    xj, yj = point_position(bodies, points, q, j)
    return Apart(xi - xj, yi - yj, point_angle(bodies, points, q, i), point_angle(bodies, points, q, j))


@kernel
def relative_motion(
    bodies: Bodies, points: Points, q: FloatArray, u: FloatArray, i: int, j: int
) -> tuple[Apart, Motion]:
    """Of the points i = P and j = Q."""
    xi, yi, vxi, vyi, bxi, byi = point_motion(bodies, points, q, u, i)
    xj, yj, vxj, vyj, bxj, byj = point_motion(bodies, points, q, u, j)
    place = Apart(xi - xj, yi - yj, point_angle(bodies, points, q, i), point_angle(bodies, points, q, j))
    spin_p = point_angle(bodies, points, u, i)
    spin_q = point_angle(bodies, points, u, j)
    return place, Motion(vxi - vxj, vyi - vyj, bxi - bxj, byi - byj, spin_p, spin_q)
