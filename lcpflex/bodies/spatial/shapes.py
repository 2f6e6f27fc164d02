"""What spatial bodies look like: for pictures, and for whatever touches them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from lcpflex.basics.arguments import array_of
from lcpflex.errors import ModelError
from lcpflex.jit.kernel import FloatArray, IntArray

__all__ = ["SHAPES", "CapsuleShape", "CylinderShape", "Shape", "SphereShape", "SurfaceShape", "triangles_of"]


@dataclass(frozen=True, slots=True)
class SphereShape:
    """A sphere about the origin of the body frame; radius [m]."""

    radius: float


@dataclass(frozen=True, slots=True)
class CylinderShape:
    """A cylinder along z about the origin of the body frame, from z = -length / 2 to length / 2; radius, length [m]."""

    radius: float
    length: float


@dataclass(frozen=True, slots=True)
class CapsuleShape:
    """A cylinder along z about the origin of the body frame with half spheres at its ends.

    radius [m]; length of the cylinder, without the half spheres [m].
    """

    radius: float
    length: float


@dataclass(frozen=True, slots=True, eq=False)
class SurfaceShape:
    """A surface of triangles, which deforms with the body.

    Attributes
    ----------
    vertices : (N, 3) undeformed places in the body frame [m]
    triangles : (T, 3) vertices of each, counter-clockwise seen from outside; none: the vertices alone are known
    phi : (N, n, 3) displacement of each mode at the vertices [kg^-1/2]
    convex : whether it is the whole boundary of a convex body

    Raises
    ------
    ModelError
        For arrays of other shapes, numbers that are not finite, and triangles of vertices that there are not.
    """

    vertices: FloatArray
    triangles: IntArray
    phi: FloatArray
    convex: bool = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "vertices", array_of("vertices", self.vertices, (-1, 3)))
        object.__setattr__(self, "triangles", triangles_of(self.triangles, len(self.vertices)))
        object.__setattr__(self, "phi", array_of("phi", self.phi, (len(self.vertices), -1, 3)))

    def deformed(self, eta: FloatArray) -> FloatArray:
        """(N, 3) places of the vertices in the body frame at the modal coordinates eta (n,)."""
        return np.asarray(self.vertices + np.einsum("ikj,k->ij", self.phi, eta))


def triangles_of(given: Any, count: int) -> IntArray:
    """(T, 3) numbers of vertices, of which there are so many."""
    array = np.asarray(given)
    if array.ndim != 2 or array.shape[1] != 3 or (array.size and array.dtype.kind not in "iu"):
        kind = f"an array of shape {array.shape} and type {array.dtype}"
        raise ModelError(f"triangles: {kind} was given, expected (any, 3) integers")
    outside = array[(array < 0) | (array >= count)]
    if outside.size:
        raise ModelError(f"triangles: vertex {outside[0]} was given, expected numbers from 0 to {count - 1}")
    found: IntArray = np.array(array, dtype=np.int64, order="C")
    found.setflags(write=False)
    return found


Shape: TypeAlias = SphereShape | CylinderShape | CapsuleShape | SurfaceShape
SHAPES = (SphereShape, CylinderShape, CapsuleShape, SurfaceShape)
