"""Surfaces of spatial bodies and of the ground: what they are made of, and which of them can touch each other.

A surface holds *nodes*, material points with a radius that may touch others, and *features* that others may touch:
spheres, facets, edges and vertices, planes. Which side does what follows from the two kinds: of two, the one that comes
first in :class:`SpatialKind` is the node side, if nothing else was chosen.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum
from typing import Any

import numpy as np

from lcpflex.bodies.spatial.body import SpatialPoint, rigid_point
from lcpflex.bodies.spatial.shapes import CapsuleShape, Shape, SphereShape, SurfaceShape
from lcpflex.jit.kernel import FloatArray, IntArray

__all__ = ["CODES", "SpatialKind", "SpatialSurface", "carried", "code_of", "plane", "surface_of"]


class SpatialKind(Enum):
    """What a surface is made of."""

    NODE = "node"
    SPHERE = "sphere"
    CAPSULE = "capsule"
    POLYHEDRON = "convex polyhedron"
    MESH = "triangle surface"
    HOLE = "hole"
    PLANE = "plane"


CODES = {kind: code for code, kind in enumerate(SpatialKind)}  # by which kernels know them
ROUND = (SpatialKind.SPHERE, SpatialKind.HOLE, SpatialKind.PLANE)
TOUCHED = {  # what the nodes of a surface may touch
    SpatialKind.NODE: ROUND,
    SpatialKind.SPHERE: ROUND,
    SpatialKind.CAPSULE: (SpatialKind.HOLE, SpatialKind.PLANE),
    SpatialKind.POLYHEDRON: (SpatialKind.HOLE, SpatialKind.PLANE),
    SpatialKind.MESH: (SpatialKind.HOLE, SpatialKind.PLANE),
}


def code_of(kind: SpatialKind) -> int:
    """The number by which kernels know a kind."""
    return CODES[kind]


@dataclass(frozen=True, slots=True, eq=False)
class SpatialSurface:
    """One surface of a body, in its frame. Made by the functions of this module.

    points: material points (vertices of triangles; centre of a sphere or hole; both ends of the axis of a capsule;
    three points of a plane, a metre apart, seen counter-clockwise from outside). radius [m] of spheres, holes and
    capsules. triangles (T, 3): of which points, counter-clockwise seen from outside; none: the points alone are known.
    """

    kind: SpatialKind
    points: tuple[SpatialPoint, ...]
    radius: float = 0.0
    triangles: IntArray = field(default_factory=lambda: np.zeros((0, 3), dtype=np.int64))

    def can_touch(self, other: Any) -> bool:
        """Whether there is a contact between surfaces of these kinds."""
        return self.can_be_node_side(other) or other.can_be_node_side(self)

    def can_be_node_side(self, other: Any) -> bool:
        """Whether nodes of this one may touch features of the other."""
        return isinstance(other, SpatialSurface) and other.kind in TOUCHED.get(self.kind, ())

    def partners(self) -> str:
        """What surfaces it can touch, in words."""
        found = [kind.value for kind in SpatialKind if self.can_touch(SpatialSurface(kind, ()))]
        return f"a {self.kind.value} with one of: {', '.join(found)}"

    def node_sides(self) -> str:
        """What it can be the node side of, in words."""
        found = [kind.value for kind in TOUCHED.get(self.kind, ())]
        return f"it to be the node side of {' or '.join(found)}" if found else "the other one, as it has no nodes"

    def passes(self, other: SpatialSurface) -> tuple[tuple[int, int], ...]:
        """(node side, touched side) of each pass, 0: this one, 1: the other; of two nodes sides the first kind."""
        if not (self.can_be_node_side(other) and other.can_be_node_side(self)):
            return ((0, 1) if self.can_be_node_side(other) else (1, 0),)
        return ((0, 1) if CODES[self.kind] <= CODES[other.kind] else (1, 0),)


def surface_of(shape: Shape) -> SpatialSurface | None:
    """The surface of a whole body; None of shapes that nothing touches yet."""
    if isinstance(shape, SphereShape):
        return SpatialSurface(SpatialKind.SPHERE, (rigid_point(0.0, 0.0, 0.0),), shape.radius)
    if isinstance(shape, CapsuleShape):
        ends = tuple(rigid_point(0.0, 0.0, sign * 0.5 * shape.length) for sign in (-1.0, 1.0))
        return SpatialSurface(SpatialKind.CAPSULE, ends, shape.radius)
    if isinstance(shape, SurfaceShape):
        points = tuple(
            SpatialPoint(place, phi, np.zeros_like(phi), False)
            for place, phi in zip(shape.vertices, shape.phi, strict=True)
        )
        kind = SpatialKind.POLYHEDRON if shape.convex and not shape.phi.size else SpatialKind.MESH
        return SpatialSurface(kind, points, triangles=shape.triangles)
    return None


def plane(point: SpatialPoint, normal: FloatArray) -> SpatialSurface:
    """Everything behind the plane through ``point``; ``normal`` (3,), not zero, points out of the solid."""
    n = normal / np.linalg.norm(normal)
    across = np.cross(n, np.eye(3)[int(np.argmin(np.abs(n)))])
    first = across / np.linalg.norm(across)
    second = np.cross(n, first)
    return SpatialSurface(SpatialKind.PLANE, (point, carried(point, first), carried(point, second)))


def carried(point: SpatialPoint, offset: FloatArray) -> SpatialPoint:
    """A point ``offset`` (3,) [m] from ``point``, carried rigidly by the material there."""
    return SpatialPoint(point.place + offset, point.phi + np.cross(point.psi, offset), point.psi)
