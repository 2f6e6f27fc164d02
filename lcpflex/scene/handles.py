"""Handles of the bodies and the ground of a scene: their points and their surfaces."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from operator import methodcaller
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
import numpy.typing as npt

from lcpflex.basics.arguments import absent, flag, sequence_of
from lcpflex.bodies import surface as shapes
from lcpflex.bodies.body import Body, Chain, MaterialPoint, array_of
from lcpflex.bodies.placed_point import PlacedPoint
from lcpflex.errors import ModelError, in_range, shown
from lcpflex.scene import slots
from lcpflex.scene.placed_body import PlacedBody
from lcpflex.scene.placed_surface import PlacedSurface

if TYPE_CHECKING:
    from lcpflex.bodies.surface import Surface
    from lcpflex.jit.kernel import FloatArray
    from lcpflex.scene.compiling import ReductionOrder
    from lcpflex.scene.register import Register
    from lcpflex.scene.slots import Slot

__all__ = ["Placed"]

Place = str | PlacedPoint | npt.ArrayLike


_KNOWN_AS = {
    "face": "it is spatial; in the plane surface(name), of an outline or a set of nodes",
    "plane": "it is spatial; in the plane half_plane(point, normal)",
    "sphere": "it is spatial; in the plane circle(center, radius)",
    "cylinder": "it is spatial; in the plane circle(center, radius)",
    "capsule": "it is spatial; in the plane node(x, y, radius), or chain(places, closed=True)",
    "box": "it is spatial; in the plane chain(places, closed=True)",
    "hull": "it is spatial; in the plane chain(places, closed=True)",
    "slot": "did you mean 'straight_slot' or 'curved_slot'?",
}


@dataclass(frozen=True, slots=True, eq=False)
class Placed(PlacedBody):
    """A body in a scene, or its ground. Places are in the body frame, undeformed (in world axes for the ground) [m].

    Made by ``scene.add(...)`` and ``scene.ground``, not by hand. Where a place is asked for, the name of a point of the
    body does as well. Every method raises ModelError for an unknown name, a place off a flexible body, and numbers
    that cannot be.
    """

    _known_as: ClassVar[Mapping[str, str]] = _KNOWN_AS
    source: Body | None = field(repr=False)  # None for the ground
    start: tuple[FloatArray, FloatArray] = field(repr=False)  # (3 + n,) configuration and velocity
    scene: Register = field(repr=False)
    order: ReductionOrder | None = field(default=None, repr=False)  # of a body that is reduced with its scene

    @property
    def frame_point(self) -> MaterialPoint | None:
        """The point of a solid of revolution that rides with its frame; None of other bodies."""
        return self.source.points.get("axis") if self.source is not None and self.source.axisymmetric else None

    @property
    def has_outline(self) -> bool:
        """Whether the body came with a surface that is the whole of it."""
        return self.source is not None and "outline" in self.source.surfaces

    def point(self, name: str) -> PlacedPoint:
        """A named point of the body."""
        known = {} if self.source is None else self.source.points
        if not isinstance(name, str) or name not in known:
            raise ModelError(f"name: {shown(self.name)} has no point {absent(name, known)}")
        return PlacedPoint(self.scene, self.body, f"{self.name}.{name}", known[name], methodcaller("point", name))

    def at(self, x: float, y: float) -> PlacedPoint:
        """The material point at (x, y)."""
        x, y = in_range("x", x, -math.inf, math.inf), in_range("y", y, -math.inf, math.inf)
        material = self._located((x, y))
        label = f"{self.name}.at({float(x):g}, {float(y):g})"
        return PlacedPoint(self.scene, self.body, label, material, methodcaller("at", x, y))

    def surface(self, name: str = "outline") -> PlacedSurface:
        """A surface that the body came with; "outline" is the whole of it."""
        known = {} if self.source is None else self.source.surfaces
        if not isinstance(name, str) or name not in known:
            hint = "; make one with circle, arc, half_plane, chain or node" if not known else ""
            raise ModelError(f"name: {shown(self.name)} has no surface {absent(name, known)}{hint}")
        outline = known[name]
        if isinstance(outline, Chain):
            shape = shapes.chain(outline.points, outline.closed)
        else:
            shape = (shapes.hole if outline.hole else shapes.circle)(outline.center, outline.radius)
        label = f"{self.name}.{name}"
        return PlacedSurface(self.scene, self.body, label, self._on_body(shape), methodcaller("surface", name))

    def circle(self, center: Place, radius: float) -> PlacedSurface:
        """A disc of ``radius`` > 0 [m] that moves with the material at ``center``, solid inside."""
        return self._about("circle", shapes.circle, center, "center", _radius(radius))

    def hole(self, center: Place, radius: float) -> PlacedSurface:
        """A circular hole of ``radius`` > 0 [m] that moves with the material at ``center``, solid outside."""
        return self._about("hole", shapes.hole, center, "center", _radius(radius))

    def arc(self, center: Place, radius: float, start: float, extent: float, hole: bool = False) -> PlacedSurface:
        """Part of a circle, counter-clockwise from the angle ``start`` over ``extent`` in (0, 2 pi] [rad].

        Solid inside, up to the centre, or outside with ``hole``, as at the end of a slot. The ends of an open arc are
        corners: they touch what corners of chains touch, and are touched by discs.
        """
        start = in_range("start", start, -math.inf, math.inf)
        hole = flag("hole", hole)
        extent = in_range("extent", extent, 0.0, 2.0 * math.pi)
        if extent == 0.0:
            raise ModelError("extent: 0 was given, expected an angle in (0, 2 pi]")
        return self._about("arc", shapes.arc, center, "center", _radius(radius), start, extent, hole)

    def node(self, x: float, y: float, radius: float = 0.0) -> PlacedSurface:
        """A single material point that may touch other surfaces, or a disc of ``radius`` [m] about it."""
        x, y = in_range("x", x, -math.inf, math.inf), in_range("y", y, -math.inf, math.inf)
        shape = shapes.node(self._located((x, y)), in_range("radius", radius, 0.0, math.inf))
        return self._made("node", shape, methodcaller("node", x, y, radius))

    def half_plane(self, point: Place, normal: npt.ArrayLike) -> PlacedSurface:
        """Everything behind the straight line through ``point`` is solid; ``normal`` (2,) points out of it."""
        direction = array_of("normal", normal, (2,))
        if not direction.any():
            raise ModelError(f"normal: {shown(normal)} was given, expected a direction (x, y), not both 0")
        return self._about("half_plane", shapes.half_plane, point, "point", direction)

    def chain(self, places: Sequence[Place], closed: bool = False) -> PlacedSurface:
        """Straight pieces from place to place, at least two, solid on the left and outward normal on the right.

        Around a solid, places run counter-clockwise. ``closed`` runs on from the last place to the first.
        """
        places = tuple(sequence_of("places", places, "a sequence of places"))
        closed = flag("closed", closed)
        points = tuple(self._located(place, f"places[{k}]") for k, place in enumerate(places))
        if len(points) < (3 if closed else 2):
            raise ModelError(f"places: {len(points)} were given, expected at least {3 if closed else 2}")
        return self._made(
            "chain",
            shapes.chain(points, closed),
            partial(_chain_again, places, closed),
        )

    def curved_slot(self, center: Place, radius: float, width: float, start: float, extent: float) -> Slot:
        """A slot along an arc about ``center``, counter-clockwise from the angle ``start`` over ``extent`` [rad].

        ``radius`` [m] is that of its middle line, on which a pin of radius width / 2 would run: the inner track is a
        solid arc of radius - width / 2, the outer one the wall of a hole of radius + width / 2, each end a half circle
        of width / 2 about the end of the middle line. All is carried rigidly by the material at ``center``. Declare
        what a pin does in it by ``scene.contact_slot``.
        """
        self._located(center, "center")
        return slots.curved_slot(self, center, radius, width, start, extent)

    def straight_slot(self, first: Place, last: Place, width: float) -> Slot:
        """A straight slot, its ends half circles of width / 2 [m] about ``first`` and ``last``.

        On a flexible body each end moves with the material at its place, and the tracks run between them.
        """
        for argument, place in (("first", first), ("last", last)):
            self._located(place, argument)
        return slots.straight_slot(self, first, last, width)

    def _made_of(self, kind: str, places: Sequence[Place], shape: Callable[..., Surface]) -> PlacedSurface:
        """The surface ``shape`` makes of the material points at ``places``, here and on another body: a part."""
        return self._made(
            kind,
            shape(*(self._located(place) for place in places)),
            partial(_made_again, kind, tuple(places), shape),
        )

    def _about(
        self, kind: str, shape: Callable[..., Surface], place: Place, argument: str, *numbers: Any
    ) -> PlacedSurface:
        """The surface that the method ``kind`` makes about one place, from ``numbers`` that have been checked."""
        return self._made(kind, shape(self._located(place, argument), *numbers), partial(_again, kind, place, numbers))

    def _made(self, kind: str, shape: Surface, again: Callable[[Placed], PlacedSurface]) -> PlacedSurface:
        shape = self._on_body(shape)
        disc = (shape.points[0], shape.radius) if shape.kind is shapes.Kind.CIRCLE else None
        surface = PlacedSurface(self.scene, self.body, self.scene._label(f"{self.name}.{kind}"), shape, again, disc)
        self.scene._keep(surface)
        return surface

    def _on_body(self, shape: Surface) -> Surface:
        """With what tells how deep the solid is below an open chain or behind the wall of a hole: the outline."""
        one_sided = shape.kind is shapes.Kind.HOLE or (shape.kind is shapes.Kind.CHAIN and not shape.closed)
        if one_sided and self.source is not None and "outline" in self.source.surfaces:
            return shapes.on_body(shape, self.source.surfaces["outline"], self.source.axisymmetric)
        return shape

    def _arm(self, point: Place) -> tuple[FloatArray, FloatArray]:
        """Where a point is at the start from the origin of the frame, and what it has of velocity more, world axes."""
        material, (q, u) = self._located(point, "point"), self.start
        c, s = math.cos(q[2]), math.sin(q[2])
        A = np.array([[c, -s], [s, c]])
        place = A @ (material.place + q[3:] @ material.phi)
        return place, u[2] * np.array([-place[1], place[0]]) + A @ (u[3:] @ material.phi)

    def _located(self, place: Place, argument: str = "place") -> MaterialPoint:
        if isinstance(place, str):
            known = {} if self.source is None else self.source.points
            if place not in known:
                raise ModelError(f"{argument}: {shown(self.name)} has no point {absent(place, known)}")
            return known[place]
        if isinstance(place, PlacedPoint):
            if place.scene is not self.scene or place.body != self.body:
                raise ModelError(f"{argument}: {shown(place.label)} was given, expected a point of {shown(self.name)}")
            given: MaterialPoint = place.material
            return given
        x, y = array_of(argument, place, (2,))
        if self.source is None:
            return MaterialPoint(np.array([x, y]), np.zeros((0, 2)), np.zeros(0))
        return self.source.locate(float(x), float(y))


def _radius(value: float) -> float:
    return in_range("radius", value, 0.0, math.inf, open_ends=True)


def _on(place: Place, body: Placed) -> Place:
    """The same place of another body: points are made anew, names and numbers stay."""
    return place.again(body) if isinstance(place, PlacedPoint) else place


# What makes a surface again is kept with it, and is pickled with the scene: functions of this module, no inner ones.


def _again(kind: str, place: Place, rest: tuple[Any, ...], body: Placed) -> PlacedSurface:
    """The surface of that kind at the same place of another body."""
    surface: PlacedSurface = getattr(body, kind)(_on(place, body), *rest)
    return surface


def _chain_again(places: Sequence[Place], closed: bool, body: Placed) -> PlacedSurface:
    return body.chain([_on(place, body) for place in places], closed)


def _made_again(kind: str, places: Sequence[Place], shape: Callable[..., Surface], body: Placed) -> PlacedSurface:
    return body._made_of(kind, [_on(place, body) for place in places], shape)
