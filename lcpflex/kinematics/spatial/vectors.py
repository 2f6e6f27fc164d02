"""Sums and products of vectors that are three numbers each: kernels keep them in registers, and allocate nothing."""

from __future__ import annotations

import math

from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.kinematics.spatial.rotations import Matrix, Vector, transform, transform_back

__all__ = [
    "IDENTITY",
    "NOTHING",
    "added",
    "apart_from",
    "dot",
    "is_zero",
    "norm",
    "row_vector",
    "scaled",
    "turned",
    "turned_back",
]

NOTHING = (0.0, 0.0, 0.0)
IDENTITY = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)


@kernel
def dot(a: Vector, b: Vector) -> float:
    """a.b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@kernel
def scaled(factor: float, a: Vector) -> Vector:
    """factor a."""
    return factor * a[0], factor * a[1], factor * a[2]


@kernel
def added(a: Vector, b: Vector) -> Vector:
    """a + b."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


@kernel
def apart_from(a: Vector, b: Vector) -> Vector:
    """a - b."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@kernel
def norm(a: Vector) -> float:
    """|a|."""
    return math.sqrt(dot(a, a))


@kernel
def is_zero(a: Vector) -> bool:
    """Whether all of it is 0."""
    return a[0] == 0.0 and a[1] == 0.0 and a[2] == 0.0


@kernel
def row_vector(rows: FloatArray, r: int) -> Vector:
    """Row r of an array (any, 3)."""
    return rows[r, 0], rows[r, 1], rows[r, 2]


@kernel
def turned(m: Matrix, a: Vector) -> Vector:
    """m a."""
    return transform(m, a[0], a[1], a[2])


@kernel
def turned_back(m: Matrix, a: Vector) -> Vector:
    """m^T a."""
    return transform_back(m, a[0], a[1], a[2])
