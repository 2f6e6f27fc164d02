"""Surfaces of spatial bodies and of the ground: what they are made of, and which of them can touch each other.

A surface holds *nodes*, material points with a radius that may touch others, and *features* that others may touch:
spheres, facets, edges and vertices, planes. Which side does what follows from the two kinds: of two, the one that comes
first in :class:`SpatialKind` is the node side, if nothing else was chosen.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from enum import Enum
from typing import Any, NamedTuple

import numpy as np

from lcpflex.bodies.spatial.body import SpatialPoint, rigid_point
from lcpflex.bodies.spatial.face_nodes import FaceNodes
from lcpflex.bodies.spatial.shapes import CapsuleShape, CylinderShape, Shape, SphereShape, SurfaceShape
from lcpflex.jit.kernel import FloatArray, IntArray

__all__ = [
    "ALL_FEATURES",
    "BORE",
    "CAPSULE",
    "CODES",
    "CONVEX",
    "CORNERS",
    "CYLINDER",
    "EDGED",
    "EDGES",
    "FACE",
    "FACES",
    "MESH",
    "MESHES",
    "NO_POINTS",
    "PIN",
    "POLYHEDRON",
    "RANKS",
    "RIMMED",
    "RIM_POINTS",
    "TOUCHES",
    "TWO_SIDED",
    "Pass",
    "SpatialKind",
    "SpatialSurface",
    "carried",
    "cylinder",
    "face",
    "mesh",
    "passes_of",
    "plane",
    "polyhedron",
    "rim",
    "surface_of",
    "tube",
]


class SpatialKind(Enum):
    """What a surface is made of."""

    NODE = "node"
    SPHERE = "sphere"
    CAPSULE = "capsule"
    CYLINDER = "cylinder"
    RIM = "rim"
    FACE = "face"
    POLYHEDRON = "convex polyhedron"
    MESH = "triangle surface"
    HOLE = "hole"
    PIN = "pin"
    BORE = "bore"
    PLANE = "plane"


# by which kernels know them, and files of results: what came later is behind the others
_LATE = (SpatialKind.FACE, SpatialKind.PIN, SpatialKind.BORE)
_CODED = (*(kind for kind in SpatialKind if kind not in _LATE), *_LATE)
CODES = {kind: code for code, kind in enumerate(_CODED)}
RANKS = tuple(list(SpatialKind).index(kind) for kind in _CODED)  # by the codes: of two node sides, the lower is it
SOLID = (SpatialKind.CAPSULE, SpatialKind.POLYHEDRON, SpatialKind.MESH, SpatialKind.HOLE, SpatialKind.PLANE)
TOUCHED = {  # what the nodes of a surface may touch
    SpatialKind.NODE: (SpatialKind.SPHERE, SpatialKind.CYLINDER, SpatialKind.BORE, *SOLID),
    SpatialKind.SPHERE: (SpatialKind.SPHERE, SpatialKind.CYLINDER, SpatialKind.BORE, *SOLID),
    SpatialKind.CAPSULE: (SpatialKind.CYLINDER, *SOLID),
    SpatialKind.CYLINDER: (SpatialKind.CYLINDER, SpatialKind.POLYHEDRON, SpatialKind.PLANE),
    SpatialKind.RIM: (SpatialKind.PLANE,),
    SpatialKind.FACE: (SpatialKind.SPHERE, SpatialKind.CYLINDER, SpatialKind.FACE, *SOLID),
    SpatialKind.POLYHEDRON: (SpatialKind.CYLINDER, *SOLID),
    SpatialKind.MESH: SOLID,
    SpatialKind.PIN: (SpatialKind.BORE,),
    SpatialKind.BORE: (SpatialKind.PIN,),
}
TOUCHES = np.array([[b in TOUCHED.get(a, ()) for b in CODES] for a in CODES])  # the same by their codes
WITH_EDGES = (SpatialKind.CAPSULE, SpatialKind.POLYHEDRON, SpatialKind.MESH)
EDGED = tuple(kind in WITH_EDGES for kind in CODES)  # by their codes, those that touch each other with edges
CAPSULE, CYLINDER = CODES[SpatialKind.CAPSULE], CODES[SpatialKind.CYLINDER]
POLYHEDRON, MESH = CODES[SpatialKind.POLYHEDRON], CODES[SpatialKind.MESH]
FACE = CODES[SpatialKind.FACE]
PIN, BORE = CODES[SpatialKind.PIN], CODES[SpatialKind.BORE]
ON_CYLINDER = (SpatialKind.CAPSULE, SpatialKind.CYLINDER)
RIMMED = (SpatialKind.CYLINDER, SpatialKind.RIM)  # those that touch with circles
RIM_POINTS = 8  # of each rim, on which a cylinder or disc stands on a plane; on other bodies there are twice as many
# what a pass looks at: nodes against all, against all but points; edges; nodes against all. Of the second and the last,
# the nodes of the other surface and the edges of both are looked at, too: what a node stands for is itself alone
# CONVEX: all of two convex bodies, MESHES: of other surfaces of triangles, whichever is the node side; CORNERS, within
# that: nodes where sharp edges end, against all; FACES: nodes or areas of an open face on the faces of what has some
ALL_FEATURES, NO_POINTS, EDGES, TWO_SIDED, CONVEX, MESHES, CORNERS, FACES = range(8)


class Pass(NamedTuple):
    """What is looked at between two surfaces, 0: the one and 1: the other."""

    node_side: int
    touched: int
    mode: int = ALL_FEATURES


@dataclass(frozen=True, slots=True, eq=False)
class SpatialSurface:
    """One surface of a body, in its frame. Made by the functions of this module.

    points: material points (vertices of triangles; centre of a sphere or hole; both ends of the axis of a capsule, pin
    or bore;
    three points of a plane, a metre apart, seen counter-clockwise from outside; the centres of both rims of a cylinder,
    or of a rim and another point on its axis, and points on them, of cylinders those half-way between, too).
    radius [m] of spheres, holes, capsules, pins, bores, cylinders and rims. triangles (T, 3): of which points,
    counter-clockwise seen from outside; none: the points alone are known. cells of a face: of which points each facet
    is made, (3,), (4,), (6,), (8,) or (9,): its corners, counter-clockwise seen from outside, then those amid its edges
    (behind the first corner's, the one between it and the second), then the middle.
    """

    kind: SpatialKind
    points: tuple[SpatialPoint, ...]
    radius: float = 0.0
    triangles: IntArray = field(default_factory=lambda: np.zeros((0, 3), dtype=np.int64))
    cells: tuple[IntArray, ...] = ()

    def can_touch(self, other: Any) -> bool:
        """Whether there is a contact between surfaces of these kinds."""
        return self.can_be_node_side(other) or other.can_be_node_side(self)

    def can_be_node_side(self, other: Any) -> bool:
        """Whether nodes of this one may touch features of the other."""
        return isinstance(other, SpatialSurface) and other.kind in TOUCHED.get(self.kind, ())

    def can_meet(self, other: SpatialSurface) -> bool:
        """Whether such surfaces can come to each other from apart: points cannot, nor solids that fill all around."""
        kinds = {self.kind, other.kind}
        hollow = {SpatialKind.HOLE, SpatialKind.BORE, SpatialKind.PLANE}
        return kinds != {SpatialKind.NODE} and not kinds.issubset(hollow)

    def partners(self) -> str:
        """What surfaces it can touch, in words."""
        found = [kind.value for kind in SpatialKind if self.can_touch(SpatialSurface(kind, ()))]
        hint = "; on meshes, a ConvexHull of its points" if self.kind is SpatialKind.CYLINDER else ""
        return f"a {self.kind.value} with one of: {', '.join(found)}{hint}"

    def node_sides(self) -> str:
        """What it can be the node side of, in words."""
        found = [kind.value for kind in TOUCHED.get(self.kind, ())]
        return f"it to be the node side of {' or '.join(found)}" if found else "the other one, as it has no nodes"

    @property
    def deforms(self) -> bool:
        """Whether its points move in its body."""
        return any(point.phi.any() for point in self.points)

    def passes(self, other: SpatialSurface, node_side: int | None = None) -> tuple[Pass, ...]:
        """What is looked at between this surface and another one, 0: this one, 1: the other.

        node_side: the one that was chosen.
        """
        if SpatialKind.FACE in (self.kind, other.kind):
            return (_face_pass((self, other), node_side),)
        codes = CODES[self.kind], CODES[other.kind]
        both = {self.kind, other.kind} == {SpatialKind.PIN, SpatialKind.BORE}  # ends of each, whichever is longer
        whole = (self.kind, other.kind) in (ON_CYLINDER, ON_CYLINDER[::-1]) or are_convex(codes) or both
        if node_side is not None and not whole:  # else edges touch, too, in any case
            return (Pass(node_side, 1 - node_side),)
        return passes_of(codes, self.deforms or other.deforms, (len(self.points), len(other.points)))


def _face_pass(pair: tuple[SpatialSurface, SpatialSurface], node_side: int | None) -> Pass:
    """What is looked at between two surfaces of which one is a face, or both: then the node side is known."""
    own = int(pair[0].kind is not SpatialKind.FACE) if node_side is None else node_side
    faced = pair[1 - own].kind in (SpatialKind.FACE, SpatialKind.POLYHEDRON, SpatialKind.MESH)
    return Pass(own, 1 - own, FACES if faced else ALL_FEATURES)


def are_convex(kinds: tuple[int, int]) -> bool:
    """Whether two surfaces, by the codes of their kinds, touch as convex bodies do: with one manifold."""
    return all(code in (CYLINDER, POLYHEDRON) for code in kinds)


def passes_of(kinds: tuple[int, int], deform: bool, points: tuple[int, int]) -> tuple[Pass, ...]:
    """What is looked at between two surfaces, by the codes of their kinds and the numbers of their points.

    Of two node sides: both, and edges against edges. But where one of them deforms, of the coarser one, that with fewer
    points, the outline alone, of a capsule nothing: two meshes that touch with all nodes of both have each force shared
    in a way nothing determines, while the patch ends where a rim is over a face of the finer one.
    """
    first = 0 if RANKS[kinds[0]] <= RANKS[kinds[1]] else 1
    other = 1 - first
    if are_convex(kinds):
        return (Pass(first, other, CONVEX),)
    if not TOUCHES[kinds[first], kinds[other]]:
        return (Pass(other, first),)
    if set(kinds) == {PIN, BORE}:
        return Pass(first, other), Pass(other, first)
    if kinds[first] == CAPSULE and kinds[other] == CYLINDER:
        return Pass(first, other), Pass(first, other, EDGES)
    if MESH in kinds and kinds[first] in (POLYHEDRON, MESH) and kinds[other] in (POLYHEDRON, MESH):
        return (Pass(first, other, MESHES),)
    if not (TOUCHES[kinds[other], kinds[first]] and EDGED[kinds[0]] and EDGED[kinds[1]]):
        return (Pass(first, other),)
    if deform:
        return (Pass(first, other),) if points[first] >= points[other] else (Pass(other, first),)
    capsule = kinds[first] == CAPSULE  # its ends have touched what is a point already
    back = NO_POINTS if capsule else TWO_SIDED
    return Pass(first, other, TWO_SIDED), Pass(other, first, back), Pass(first, other, EDGES)


def surface_of(shape: Shape) -> SpatialSurface | None:
    """The surface of a whole body; None of shapes that nothing touches yet."""
    if isinstance(shape, SphereShape):
        return SpatialSurface(SpatialKind.SPHERE, (rigid_point(0.0, 0.0, 0.0),), shape.radius)
    if isinstance(shape, CapsuleShape):
        ends = tuple(rigid_point(0.0, 0.0, sign * 0.5 * shape.length) for sign in (-1.0, 1.0))
        return SpatialSurface(SpatialKind.CAPSULE, ends, shape.radius)
    if isinstance(shape, CylinderShape):
        return _cylinder(rigid_point(0.0, 0.0, 0.0), np.eye(3), shape.radius, shape.length)
    if isinstance(shape, SurfaceShape):
        points = tuple(
            SpatialPoint(place, phi, np.zeros_like(phi), False)
            for place, phi in zip(shape.vertices, shape.phi, strict=True)
        )
        kind = SpatialKind.POLYHEDRON if shape.convex and not shape.phi.size else SpatialKind.MESH
        return SpatialSurface(kind, points, triangles=shape.triangles)
    return None


def _circle(radius: float, behind: float = 0.0) -> FloatArray:
    """(RIM_POINTS, 3) places on a circle about z, by a part of their distance ``behind``."""
    angles = (np.arange(RIM_POINTS) + behind) * (2.0 * math.pi / RIM_POINTS)
    return radius * np.column_stack([np.cos(angles), np.sin(angles), np.zeros(RIM_POINTS)])


def rim(center: SpatialPoint, axis: FloatArray, radius: float) -> SpatialSurface:
    """The circle of ``radius`` about ``axis`` (3,), not zero, around ``center``, carried by the material there."""
    n, first, second = _frame(axis)
    around = _circle(radius) @ np.array([first, second, n])
    points = (center, carried(center, radius * n), *(carried(center, offset) for offset in around))
    return SpatialSurface(SpatialKind.RIM, points, radius)


def cylinder(center: SpatialPoint, axis: FloatArray, radius: float, length: float) -> SpatialSurface:
    """A cylinder about ``axis`` (3,), not zero, around ``center``, carried by the material there."""
    n, first, second = _frame(axis)
    return _cylinder(center, np.array([first, second, n]), radius, length)


def _cylinder(center: SpatialPoint, axes: FloatArray, radius: float, length: float) -> SpatialSurface:
    """Along the third row of ``axes`` (3, 3): the centres of both rims, points on them, and those half-way between."""
    ends = [0.5 * sign * length * axes[2] for sign in (-1.0, 1.0)]
    around, between = _circle(radius) @ axes, _circle(radius, 0.5) @ axes
    rims = [end + offset for circle in (around, between) for end in ends for offset in circle]
    points = (carried(center, offset) for offset in (*ends, *rims))
    return SpatialSurface(SpatialKind.CYLINDER, tuple(points), radius)


def tube(kind: SpatialKind, center: SpatialPoint, axis: FloatArray, radius: float, length: float) -> SpatialSurface:
    """A pin or bore about ``axis`` (3,), not zero, around ``center``: the middles of both ends, carried there."""
    n, _, _ = _frame(axis)
    return SpatialSurface(kind, tuple(carried(center, 0.5 * sign * length * n) for sign in (-1.0, 1.0)), radius)


def plane(point: SpatialPoint, normal: FloatArray) -> SpatialSurface:
    """Everything behind the plane through ``point``; ``normal`` (3,), not zero, points out of the solid."""
    _, first, second = _frame(normal)
    return SpatialSurface(SpatialKind.PLANE, (point, carried(point, first), carried(point, second)))


def face(nodes: FaceNodes) -> SpatialSurface:
    """A part of the surface of a mesh."""
    return SpatialSurface(SpatialKind.FACE, nodes.points, triangles=nodes.triangles, cells=nodes.cells)


def polyhedron(points: tuple[SpatialPoint, ...], triangles: IntArray) -> SpatialSurface:
    """A convex polyhedron of vertices that do not move in their body; ``triangles`` (T, 3) counter-clockwise."""
    return SpatialSurface(SpatialKind.POLYHEDRON, points, triangles=triangles)


def mesh(points: tuple[SpatialPoint, ...], triangles: IntArray) -> SpatialSurface:
    """Triangles (T, 3) of vertices, counter-clockwise seen from outside; they may be open."""
    return SpatialSurface(SpatialKind.MESH, points, triangles=triangles)


def _frame(normal: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """The direction of ``normal``, and two across it that make a right-handed frame with it: first, second, n."""
    n = normal / np.linalg.norm(normal)
    across = np.cross(n, np.eye(3)[int(np.argmin(np.abs(n)))])
    first = across / np.linalg.norm(across)
    return n, first, np.cross(n, first)


def carried(point: SpatialPoint, offset: FloatArray) -> SpatialPoint:
    """A point ``offset`` (3,) [m] from ``point``, carried rigidly by the material there."""
    phi = point.phi + np.cross(point.psi, offset)
    return SpatialPoint(point.place + offset, phi, point.psi, made_at=point.made_at, spread=point.spread)
