"""What spatial bodies look like: for pictures, and for whatever touches them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from lcpflex.jit.kernel import FloatArray, IntArray

__all__ = ["SHAPES", "CapsuleShape", "CylinderShape", "Shape", "SphereShape", "SurfaceShape"]


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
    """

    vertices: FloatArray
    triangles: IntArray
    phi: FloatArray
    convex: bool = False

    def deformed(self, eta: FloatArray) -> FloatArray:
        """(N, 3) places of the vertices in the body frame at the modal coordinates eta (n,)."""
        return np.asarray(self.vertices + np.einsum("ikj,k->ij", self.phi, eta))


Shape: TypeAlias = SphereShape | CylinderShape | CapsuleShape | SurfaceShape
SHAPES = (SphereShape, CylinderShape, CapsuleShape, SurfaceShape)
