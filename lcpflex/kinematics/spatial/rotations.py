"""Finite rotations: unit quaternions (scalar first), rotation vectors, and the rates of both.

A(p) turns body axes into world axes. With a rotation vector psi of length a, E = exp(psi~) and its quaternion
(cos a/2, sin(a/2) psi/a); Edot E^T = (T psidot)~ with

    T = I + b psi~ + c psi~^2,   b = (1 - cos a)/a^2,   c = (a - sin a)/a^3.

Vectors are passed as three numbers and matrices as nine, row by row: nothing is allocated. Sources: Shabana, Dynamics
of Multibody Systems; Bruls & Cardona (2010), on T.
"""

from __future__ import annotations

import math

import numpy as np

from lcpflex.jit.kernel import FloatArray, kernel

__all__ = [
    "Matrix",
    "Quaternion",
    "Vector",
    "axes_at",
    "compose",
    "conjugate",
    "cross",
    "exponential",
    "logarithm",
    "product",
    "rotation_matrix",
    "tangent",
    "tangent_rate",
    "transform",
    "transform_back",
    "unit",
]

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]
Matrix = tuple[float, float, float, float, float, float, float, float, float]

SERIES = 0.25  # [rad^2] below which b and c are summed as series: terms of their closed forms cancel


@kernel
def rotation_matrix(w: float, x: float, y: float, z: float) -> Matrix:
    """A(p) of a unit quaternion, row by row."""
    return (
        1.0 - 2.0 * (y * y + z * z),
        2.0 * (x * y - w * z),
        2.0 * (x * z + w * y),
        2.0 * (x * y + w * z),
        1.0 - 2.0 * (x * x + z * z),
        2.0 * (y * z - w * x),
        2.0 * (x * z - w * y),
        2.0 * (y * z + w * x),
        1.0 - 2.0 * (x * x + y * y),
    )


def axes_at(q: FloatArray, place: int) -> FloatArray:
    """A (3, 3) of the body whose numbers begin at ``place`` of q."""
    w, x, y, z = q[place + 3 : place + 7]
    return np.reshape(rotation_matrix(w, x, y, z), (3, 3))


@kernel
def compose(a: Quaternion, b: Quaternion) -> Quaternion:
    """a o b: A(a o b) = A(a) A(b)."""
    return (
        a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
        a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
        a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
        a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
    )


@kernel
def conjugate(p: Quaternion) -> Quaternion:
    """The reverse rotation."""
    return p[0], -p[1], -p[2], -p[3]


@kernel
def unit(p: Quaternion) -> Quaternion:
    """p / |p|."""
    scale = 1.0 / math.sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2] + p[3] * p[3])
    return p[0] * scale, p[1] * scale, p[2] * scale, p[3] * scale


@kernel
def exponential(x: float, y: float, z: float) -> Quaternion:
    """The unit quaternion of the rotation vector (x, y, z) [rad]."""
    square = x * x + y * y + z * z
    if square < 1e-8:
        scale = 0.5 - square / 48.0
        return 1.0 - square * (0.125 - square / 384.0), scale * x, scale * y, scale * z
    angle = math.sqrt(square)
    scale = math.sin(0.5 * angle) / angle
    return math.cos(0.5 * angle), scale * x, scale * y, scale * z


@kernel
def logarithm(p: Quaternion) -> Vector:
    """The shortest rotation vector of a quaternion [rad], at most pi long: that of p and -p."""
    w, x, y, z = p
    if w < 0.0:
        w, x, y, z = -w, -x, -y, -z
    length = math.sqrt(x * x + y * y + z * z)
    if length < 1e-4 * w:
        square = (length / w) ** 2
        scale = 2.0 / w * (1.0 - square * (1.0 / 3.0 - square / 5.0))
    else:
        scale = 2.0 * math.atan2(length, w) / length
    return scale * x, scale * y, scale * z


@kernel
def coefficients(square: float) -> tuple[float, float, float, float]:
    """b and c of T, and their derivatives, as functions of a^2 [rad^2]."""
    if square < SERIES:
        b, c, slope_b, slope_c = 1.0, 1.0, 0.0, 0.0
        for k in range(18, 2, -2):  # of 2 b = sum 2 (-a^2)^j / (2 j + 2)! and 6 c = sum 6 (-a^2)^j / (2 j + 3)!
            slope_b = -(b + square * slope_b) / ((k - 1.0) * k)
            slope_c = -(c + square * slope_c) / (k * (k + 1.0))
            b = 1.0 - square * b / ((k - 1.0) * k)
            c = 1.0 - square * c / (k * (k + 1.0))
        return b / 2.0, c / 6.0, slope_b / 2.0, slope_c / 6.0
    a = math.sqrt(square)
    sine = math.sin(a)
    half = math.sin(0.5 * a)
    b = 2.0 * half * half / square
    c = (a - sine) / (a * square)
    return b, c, (sine / a - 2.0 * b) / (2.0 * square), (b - 3.0 * c) / (2.0 * square)


@kernel
def tangent(x: float, y: float, z: float) -> Matrix:
    """T of the rotation vector (x, y, z) [rad], row by row."""
    square = x * x + y * y + z * z
    b, c, _, _ = coefficients(square)
    return (
        1.0 + c * (x * x - square),
        c * x * y - b * z,
        c * x * z + b * y,
        c * x * y + b * z,
        1.0 + c * (y * y - square),
        c * y * z - b * x,
        c * x * z - b * y,
        c * y * z + b * x,
        1.0 + c * (z * z - square),
    )


@kernel
def tangent_rate(psi: Vector, rate: Vector) -> Matrix:
    """Tdot where psi moves with ``rate`` [rad/s]."""
    x, y, z = psi
    u, v, w = rate
    square = x * x + y * y + z * z
    along = x * u + y * v + z * w  # half the rate of a^2
    b, c, slope_b, slope_c = coefficients(square)
    db, dc = 2.0 * slope_b * along, 2.0 * slope_c * along
    return (
        dc * (x * x - square) + 2.0 * c * (x * u - along),
        dc * x * y + c * (u * y + x * v) - db * z - b * w,
        dc * x * z + c * (u * z + x * w) + db * y + b * v,
        dc * x * y + c * (u * y + x * v) + db * z + b * w,
        dc * (y * y - square) + 2.0 * c * (y * v - along),
        dc * y * z + c * (v * z + y * w) - db * x - b * u,
        dc * x * z + c * (u * z + x * w) - db * y - b * v,
        dc * y * z + c * (v * z + y * w) + db * x + b * u,
        dc * (z * z - square) + 2.0 * c * (z * w - along),
    )


@kernel
def transform(m: Matrix, x: float, y: float, z: float) -> Vector:
    """m (x, y, z)."""
    return (
        m[0] * x + m[1] * y + m[2] * z,
        m[3] * x + m[4] * y + m[5] * z,
        m[6] * x + m[7] * y + m[8] * z,
    )


@kernel
def transform_back(m: Matrix, x: float, y: float, z: float) -> Vector:
    """m^T (x, y, z)."""
    return (
        m[0] * x + m[3] * y + m[6] * z,
        m[1] * x + m[4] * y + m[7] * z,
        m[2] * x + m[5] * y + m[8] * z,
    )


@kernel
def product(m: Matrix, n: Matrix) -> Matrix:
    """The matrix product m n."""
    a, b, c = transform_back(n, m[0], m[1], m[2])
    d, e, f = transform_back(n, m[3], m[4], m[5])
    g, h, i = transform_back(n, m[6], m[7], m[8])
    return a, b, c, d, e, f, g, h, i


@kernel
def cross(a: Vector, b: Vector) -> Vector:
    """The vector product a x b."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]
