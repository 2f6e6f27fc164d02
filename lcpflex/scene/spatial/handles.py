"""Handles of the bodies and the ground of a spatial scene: their points."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from operator import methodcaller
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
import numpy.typing as npt

from lcpflex.basics.arguments import absent, array_of, flag, positive
from lcpflex.bodies.placed_point import PlacedPoint
from lcpflex.bodies.spatial import surface as surfaces
from lcpflex.bodies.spatial.body import SpatialPoint, rigid_point
from lcpflex.bodies.spatial.closed_surface import check_closed, is_closed
from lcpflex.bodies.spatial.hull import block, convex_hull
from lcpflex.bodies.spatial.rigid import corners_of
from lcpflex.bodies.spatial.shapes import SurfaceShape
from lcpflex.bodies.spatial.surface import SpatialKind, SpatialSurface, carried
from lcpflex.bodies.spatial.triangle_solid import triangle_surface
from lcpflex.errors import ModelError, in_range, shown
from lcpflex.scene.placed_body import PlacedBody
from lcpflex.scene.placed_surface import PlacedSurface
from lcpflex.scene.spatial.orientation import matrix_of

if TYPE_CHECKING:
    from lcpflex.bodies.spatial.body import SpatialBody
    from lcpflex.jit.kernel import FloatArray
    from lcpflex.scene.compiling import ReductionOrder
    from lcpflex.scene.register import Register

__all__ = ["SpatialPlaced"]

Place = str | PlacedPoint | npt.ArrayLike


_SLOTS = "slots are planar; in space let a sphere or capsule run between surfaces such as box(...)"
_KNOWN_AS = {
    "half_plane": "it is planar; in space plane(point, normal)",
    "circle": "it is planar; in space sphere(center, radius), cylinder(...) or rim(...)",
    "arc": "it is planar; in space cylinder(center, axis, radius, length)",
    "chain": "it is planar; in space box(...), hull(points), mesh(surface), or the mesh of a body",
    **dict.fromkeys(("slot", "straight_slot", "curved_slot"), _SLOTS),
}


@dataclass(frozen=True, slots=True, eq=False)
class SpatialPlaced(PlacedBody):
    """A body in a spatial scene, or its ground. Places are in the body frame, undeformed (on the ground: world) [m].

    Made by ``scene.add(...)`` and ``scene.ground``, not by hand. Every method raises ModelError for an unknown name, a
    place off a flexible body, and numbers that cannot be.
    """

    _known_as: ClassVar[Mapping[str, str]] = _KNOWN_AS
    source: SpatialBody | None = field(repr=False)  # None for the ground
    start: tuple[FloatArray, FloatArray] = field(repr=False)  # (7 + n,) configuration and (6 + n,) velocity
    scene: Register = field(repr=False)
    order: ReductionOrder | None = field(default=None, repr=False)  # of a body that is reduced with its scene

    @property
    def has_outline(self) -> bool:
        """Whether the body has a surface that can be touched."""
        shape = None if self.source is None else self.source.shape
        if not isinstance(shape, SurfaceShape) or not len(shape.triangles):
            return shape is not None and not isinstance(shape, SurfaceShape)
        faces = any(one.body == self.body and one.shape.kind is SpatialKind.FACE for one in self.scene._surfaces)
        return not faces or is_closed(shape.triangles)  # where matrices tell no more than faces, these touch

    def point(self, name: str) -> PlacedPoint:
        """A named point of the body."""
        return self._named(name, "name")

    def _named(self, name: str, argument: str) -> PlacedPoint:
        known = {} if self.source is None else self.source.points
        if not isinstance(name, str) or name not in known:
            raise ModelError(f"{argument}: {shown(self.name)} has no point {absent(name, known)}")
        return PlacedPoint(self.scene, self.body, f"{self.name}.{name}", known[name], methodcaller("point", name))

    def at_nodes(self, nodes: Sequence[int] | int, weights: Sequence[float] | None = None) -> PlacedPoint:
        """The point that stands for nodes of the mesh of a flexible body: see :meth:`SpatialBody.at_nodes`."""
        if self.source is None:
            raise ModelError("nodes: the ground has no mesh, expected a body of SpatialMatrices")
        material = self.source.at_nodes(nodes, weights)
        label = f"{self.name}.at_nodes({shown(np.asarray(nodes).tolist())})"
        return PlacedPoint(self.scene, self.body, label, material, methodcaller("at_nodes", nodes, weights))

    def at(self, x: float, y: float, z: float) -> PlacedPoint:
        """The material point at (x, y, z)."""
        place = [in_range(axis, value, -math.inf, math.inf) for axis, value in zip("xyz", (x, y, z), strict=True)]
        if self.source is None:
            material = SpatialPoint(np.array(place), np.zeros((0, 3)), np.zeros((0, 3)))
        else:
            material = self.source.locate(*place)
        label = f"{self.name}.at({', '.join(f'{value:g}' for value in place)})"
        return PlacedPoint(self.scene, self.body, label, material, methodcaller("at", *place))

    def surface(self) -> PlacedSurface:
        """The whole surface of the body, as its shape tells: a sphere, a capsule, or triangles."""
        shape = None if self.source is None or self.source.shape is None else surfaces.surface_of(self.source.shape)
        if shape is None:
            held = "the ground" if self.source is None else f"{shown(self.name)} with the shape {self._shape_name()}"
            raise ModelError(
                f"surface: {held} has none that can be touched, expected a Sphere, Cuboid, Capsule, ConvexHull, "
                "Polyhedron or mesh; make one with sphere, capsule, cylinder, box, hull, mesh, rim, node, hole, pin, "
                "bore or plane"
            )
        if len(shape.triangles):
            check_closed(f"surface of {shown(self.name)}", np.array([p.place for p in shape.points]), shape.triangles)
        return PlacedSurface(self.scene, self.body, f"{self.name}.surface", shape, methodcaller("surface"))

    def face(self, name: str) -> PlacedSurface:
        """A named face of the mesh of a body: facets that touch with all their nodes, and with areas among these.

        It is an open part of the surface, of the body of a ``Solid`` (faces of the mesh, groups of its file, ``sets``,
        "surface") or of ``SpatialMatrices(faces=...)``. Asked for again, it is the same one.
        """
        if self.source is None:
            raise ModelError(
                f"name: {shown(name)} was given for the ground, which has no faces: make a plane, box, hull, mesh, "
                "sphere or cylinder on it"
            )
        if not len(self.source.faces):
            raise ModelError(
                f"name: {shown(self.name)} has no faces, expected a body of a Solid, or of SpatialMatrices(faces=...)"
            )
        try:
            found = self.source.face(name)
        except ModelError as error:
            raise ModelError(f"{error}, of {shown(self.name)}") from None
        label = f"{self.name}.face({name})"
        known = next((one for one in self.scene._surfaces if one.label == label), None)
        if known is not None:
            return known
        shape = surfaces.face(found)
        surface = PlacedSurface(self.scene, self.body, label, shape, methodcaller("face", name))
        self.scene._keep(surface)
        return surface

    def sphere(self, center: Place, radius: float) -> PlacedSurface:
        """A ball of ``radius`` > 0 [m] that moves with the material at ``center``, solid inside."""
        return self._round("sphere", SpatialKind.SPHERE, center, radius)

    def hole(self, center: Place, radius: float) -> PlacedSurface:
        """A spherical hole of ``radius`` > 0 [m] that moves with the material at ``center``, solid outside."""
        return self._round("hole", SpatialKind.HOLE, center, radius)

    def capsule(self, first: Place, second: Place, radius: float) -> PlacedSurface:
        """A rod of ``radius`` > 0 [m] with round ends about the line from ``first`` to ``second``, which are apart."""
        ends = self._located(first, "first"), self._located(second, "second")
        if not np.any(ends[0].place != ends[1].place):
            raise ModelError(f"second: {shown(second)} was given, expected another place than that of first")
        shape = SpatialSurface(SpatialKind.CAPSULE, ends, positive("radius", radius))
        return self._made("capsule", shape, partial(_again, "capsule", first, (second, radius)))

    def cylinder(self, center: Place, axis: npt.ArrayLike, radius: float, length: float) -> PlacedSurface:
        """A solid cylinder of ``radius`` and ``length`` > 0 [m] about ``axis`` (3,), its middle at ``center``.

        It is carried rigidly by the material at ``center``. Spheres, nodes, capsules, boxes, convex hulls and other
        cylinders touch its side, its flat ends and their rims, planes its rims.
        """
        direction = _direction("axis", axis)
        place = self._turning(center, "cylinder")
        made = surfaces.cylinder(place, direction, positive("radius", radius), positive("length", length))
        return self._made("cylinder", made, partial(_again, "cylinder", center, (direction, radius, length)))

    def pin(self, center: Place, axis: npt.ArrayLike, radius: float, length: float) -> PlacedSurface:
        """A pin of ``radius`` and ``length`` > 0 [m] about ``axis`` (3,), its middle at ``center``. It touches bores.

        It is carried rigidly by the material at ``center``. It has no ends: see :meth:`bore`.
        """
        return self._tube("pin", SpatialKind.PIN, center, axis, radius, length)

    def bore(self, center: Place, axis: npt.ArrayLike, radius: float, length: float) -> PlacedSurface:
        """A bore of ``radius`` and ``length`` > 0 [m] about ``axis`` (3,), its middle at ``center``, solid outside.

        It is carried rigidly by the material at ``center``. Pins, spheres and points touch its wall where they are
        between its ends. A pin touches at both ends of what is common to both, each with

            g = R - r - |y|,

        y from the axis of one to the end of the other, R the radius of the bore and r that of the pin: so it tilts
        until it touches at both ends, right to the square of the tilt. Neither has ends that hold it along the axis.
        """
        return self._tube("bore", SpatialKind.BORE, center, axis, radius, length)

    def box(self, center: Place, sizes: npt.ArrayLike, orientation: Any = None) -> PlacedSurface:
        """A solid block with edges of ``sizes`` (3,) > 0 [m] along its axes x, y, z, its middle at ``center``.

        ``orientation``: its axes in those of the body or the ground: a scipy Rotation, a 3 x 3 matrix whose columns
        they are, or None for the same ones. Not on flexible bodies.
        """
        self._check_rigid("box")
        given = array_of("sizes", sizes, (3,)).tolist()
        edges = np.array([positive(f"sizes[{k}]", size) for k, size in enumerate(given)])
        turn = matrix_of("orientation", orientation)
        place = self._located(center, "center")
        corners, triangles = block()
        made = surfaces.polyhedron(tuple(carried(place, turn @ (corner * edges)) for corner in corners), triangles)
        return self._made("box", made, partial(_again, "box", center, (edges, turn)))

    def hull(self, points: npt.ArrayLike) -> PlacedSurface:
        """The solid convex hull of ``points`` (k, 3), k >= 4 [m]; those inside of it do not matter.

        Not on flexible bodies.
        """
        self._check_rigid("hull")
        given = array_of("points", points, (-1, 3))
        found = convex_hull(given)
        check_closed("points", found.vertices, found.triangles)
        corners = tuple(rigid_point(*given[k].tolist()) for k in found.corners)
        return self._made("hull", surfaces.polyhedron(corners, found.triangles), partial(_again, "hull", given, ()))

    def mesh(self, surface: Any, length_unit: Any = None, *, is_open: bool = False) -> PlacedSurface:
        """Everything behind triangles: a part or a terrain. Not on flexible bodies.

        A closed surface is a solid, with cavities where shells inside are seen from inside; a convex one touches as
        :meth:`hull` does. Behind an open one all is solid, half its extent deep: what got deeper, or came from behind
        around its border, is not pushed back. Its border touches as a sharp edge.

        Parameters
        ----------
        surface : the name of an STL file, ASCII or binary; or vertices (N, 3) and triangles (T, 3) of them,
            counter-clockwise seen from outside
        length_unit : of the surface: "m", "cm", "mm", "um", "in", "ft", or its number of metres; None for metres, but
            of a file it must be told
        is_open : whether it may have a border; a hole is refused otherwise
        """
        self._check_rigid("mesh")
        corners, source, is_file = corners_of(surface, length_unit)
        if is_file and length_unit is None:
            raise ModelError(
                f"length_unit: none was given for {source}, which tells none; expected 'm', 'mm' or another"
            )
        vertices, triangles, convex = triangle_surface(source, corners, flag("is_open", is_open))
        points = tuple(rigid_point(*place) for place in vertices.tolist())
        made = (surfaces.polyhedron if convex else surfaces.mesh)(points, triangles)
        again = partial(_again_mesh, (vertices, triangles), is_open)
        return self._made("mesh", made, again)

    def rim(self, center: Place, axis: npt.ArrayLike, radius: float) -> PlacedSurface:
        """The rim of a disc: a circle of ``radius`` > 0 [m] about ``axis`` (3,) through ``center``. It touches planes.

        It is carried rigidly by the material at ``center``, and touches with its lowest point C = o + R c,
        c = -m / |m|, m = n - (n.a) a, where n is the normal of the plane and a the axis; where it stands flat, with
        points that are fixed on it.
        """
        direction = _direction("axis", axis)
        place = self._turning(center, "rim")
        made = surfaces.rim(place, direction, positive("radius", radius))
        return self._made("rim", made, partial(_again, "rim", center, (direction, radius)))

    def node(self, point: Place) -> PlacedSurface:
        """A single material point that may touch other surfaces."""
        shape = SpatialSurface(SpatialKind.NODE, (self._located(point, "point"),))
        return self._made("node", shape, partial(_again, "node", point, ()))

    def plane(self, point: Place, normal: npt.ArrayLike) -> PlacedSurface:
        """Everything behind the plane through ``point`` is solid; ``normal`` (3,) points out of it.

        On a body it is fixed in the material at ``point``.
        """
        direction = _direction("normal", normal)
        place = self._located(point, "point")
        if not place.turns:
            raise ModelError("point: a plane turns with its point, expected one whose rotation is known")
        made = surfaces.plane(place, direction)
        return self._made("plane", made, partial(_again, "plane", point, (direction,)))

    def _tube(
        self, method: str, kind: SpatialKind, center: Place, axis: npt.ArrayLike, radius: float, length: float
    ) -> PlacedSurface:
        direction = _direction("axis", axis)
        place = self._turning(center, method)
        made = surfaces.tube(kind, place, direction, positive("radius", radius), positive("length", length))
        return self._made(method, made, partial(_again, method, center, (direction, radius, length)))

    def _turning(self, center: Place, kind: str) -> SpatialPoint:
        """The material point at the centre of what turns with it."""
        place = self._located(center, "center")
        if not place.turns:
            raise ModelError(f"center: a {kind} turns with its centre, expected a point whose rotation is known")
        return place

    def _round(self, method: str, kind: SpatialKind, center: Place, radius: float) -> PlacedSurface:
        shape = SpatialSurface(kind, (self._located(center, "center"),), positive("radius", radius))
        return self._made(method, shape, partial(_again, method, center, (radius,)))

    def _made(self, kind: str, shape: SpatialSurface, again: Callable[[Any], PlacedSurface]) -> PlacedSurface:
        surface = PlacedSurface(self.scene, self.body, self.scene._label(f"{self.name}.{kind}"), shape, again)
        self.scene._keep(surface)
        return surface

    def _check_rigid(self, kind: str) -> None:
        """Raise ModelError for a body whose points move apart: faces of a solid would not stay plane."""
        modes = 0 if self.source is None else self.source.modes if self.order is None else self.order.modes
        if modes:
            raise ModelError(
                f"{kind}: {shown(self.name)} is flexible ({modes} modes), expected a rigid body or the "
                "ground: on it put sphere, capsule or cylinder, or take the surface of its mesh"
            )

    def _shape_name(self) -> str:
        shape = None if self.source is None else self.source.shape
        return "None" if shape is None else type(shape).__name__

    def _arm(self, point: Place, A: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Where a point is at the start from the origin of the frame, and what it has of velocity more, world axes.

        A (3, 3): the orientation of the body.
        """
        material, (q, u) = self._located(point, "point"), self.start
        place = A @ (material.place + q[7:] @ material.phi)
        return place, np.cross(A @ u[3:6], place) + A @ (u[6:] @ material.phi)

    def _located(self, place: Place, argument: str) -> SpatialPoint:
        """The material point that a name, a point of this body or three numbers tell."""
        if isinstance(place, str):
            found: SpatialPoint = self._named(place, argument).material
            return found
        if isinstance(place, PlacedPoint):
            if place.scene is not self.scene or place.body != self.body:
                raise ModelError(f"{argument}: {shown(place.label)} was given, expected a point of {shown(self.name)}")
            given: SpatialPoint = place.material
            return given
        x, y, z = array_of(argument, place, (3,))
        made: SpatialPoint = self.at(float(x), float(y), float(z)).material
        return made


def _direction(argument: str, given: npt.ArrayLike) -> FloatArray:
    """(3,) along what was given, without overflow where that is long."""
    direction = array_of(argument, given, (3,))
    if not direction.any():
        raise ModelError(f"{argument}: {shown(given)} was given, expected a direction (x, y, z), not all 0")
    scaled: FloatArray = direction / np.abs(direction).max()
    return scaled


# What makes a surface again is kept with it, and is pickled with the scene: functions of this module, no inner ones.


def _again(kind: str, place: Place, rest: tuple[Any, ...], body: SpatialPlaced) -> PlacedSurface:
    """The surface of that kind at the same place of another body."""
    there, *others = (item.again(body) if isinstance(item, PlacedPoint) else item for item in (place, *rest))
    surface: PlacedSurface = getattr(body, kind)(there, *others)
    return surface


def _again_mesh(surface: Any, is_open: bool, body: SpatialPlaced) -> PlacedSurface:
    """The same triangles on another body."""
    return body.mesh(surface, is_open=is_open)
