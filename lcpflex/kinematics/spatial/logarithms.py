"""Rotation vectors of matrices, and the rate of a rotation vector by the angular velocity.

    Rdot R^T = w~,  R = exp(theta~):   thetadot = T^-1 w,   T^-1 = I - theta~ / 2 + e theta~^2,
    e = (1 - (a/2) cot(a/2)) / a^2,   a = |theta|

with T of :mod:`lcpflex.kinematics.spatial.rotations`.
"""

from __future__ import annotations

import math

from lcpflex.jit.kernel import kernel
from lcpflex.kinematics.spatial.rotations import Matrix, Vector
from lcpflex.kinematics.spatial.vectors import dot, norm, scaled

__all__ = ["half_cotangent", "vector_of_axes"]

SMALL = 0.25  # [rad^2] of a^2 below which e is summed as a series: terms of its closed form cancel
SERIES = (1 / 12, 1 / 720, 1 / 30240, 1 / 1209600, 1 / 47900160, 691 / 1307674368000, 1 / 74724249600)
HALF_TURN = 0.1  # [rad] before half a turn where the axis is taken from the symmetric part of R


@kernel
def half_cotangent(square: float) -> tuple[float, float]:
    """e and its derivative by a^2."""
    if square < SMALL:
        e = 0.0
        slope = 0.0
        for k in range(6, -1, -1):
            slope = e + square * slope
            e = SERIES[k] + square * e
        return e, slope
    a = math.sqrt(square)
    sin = math.sin(0.5 * a)
    cot = math.cos(0.5 * a) / sin
    e = (1.0 - 0.5 * a * cot) / square
    return e, (0.125 / (sin * sin) - 0.25 * cot / a - e) / square


@kernel
def vector_of_axes(R: Matrix) -> Vector:
    """The rotation vector of R, at most pi long. At half a turn both signs mean the same, and one is taken."""
    sines = (0.5 * (R[7] - R[5]), 0.5 * (R[2] - R[6]), 0.5 * (R[3] - R[1]))  # sin a n
    sin = norm(sines)
    cos = 0.5 * (R[0] + R[4] + R[8] - 1.0)
    angle = math.atan2(sin, cos)
    if cos > 0.0 or sin > HALF_TURN:
        return scaled(angle / sin if sin > 0.0 else 1.0, sines)
    # R + R^T = 2 cos a I + 2 (1 - cos a) n n^T: n from its largest column, its sign from the sines
    xy, xz, yz = 0.5 * (R[1] + R[3]), 0.5 * (R[2] + R[6]), 0.5 * (R[5] + R[7])
    x, y, z = R[0] - cos, R[4] - cos, R[8] - cos
    n = (xz, yz, z)
    if x >= y and x >= z:
        n = (x, xy, xz)
    elif y >= z:
        n = (xy, y, yz)
    return scaled((angle if dot(n, sines) >= 0.0 else -angle) / norm(n), n)
