"""Slots in which a pin runs: two tracks and two round ends, one surface each.

The tracks go over to the ends with a common tangent. So the gap of a pin that fits is continuous over the seams, and
its normal too: on a seam, the line across the slot through the centre of an end, the end is as far away as the track.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Generic, NamedTuple, TypeVar

import numpy as np

from lcpflex.bodies import surface as shapes
from lcpflex.errors import ModelError, in_range, shown
from lcpflex.scene.placed_surface import PlacedSurface

if TYPE_CHECKING:
    from lcpflex.bodies.body import MaterialPoint
    from lcpflex.bodies.surface import Surface
    from lcpflex.jit.kernel import FloatArray
    from lcpflex.scene.handles import Place, Placed

__all__ = ["Slot", "SlotParts", "curved_slot", "straight_slot"]

T = TypeVar("T")


class SlotParts(NamedTuple, Generic[T]):
    """Something for each part of a slot: its surfaces, the names of its contacts, the laws of these contacts.

    inner, outer: of the two tracks. first, last: of the two round ends.
    """

    inner: T
    outer: T
    first: T
    last: T


@dataclass(frozen=True, slots=True, eq=False)
class Slot:
    """A slot of one body or of the ground, made by ``placed.curved_slot`` or ``placed.straight_slot``.

    Attributes
    ----------
    inner, outer
        The tracks. From the first end to the last, the inner one is on the left: of a curved slot the solid arc about
        its centre, and the outer one the wall of a hole about it.
    first, last
        The ends, half circles of radius width / 2.
    width
        [m]
    """

    inner: PlacedSurface
    outer: PlacedSurface
    first: PlacedSurface
    last: PlacedSurface
    width: float

    def __post_init__(self) -> None:
        for name, surface in self.parts._asdict().items():
            if not isinstance(surface, PlacedSurface):
                raise ModelError(f"{name}: {shown(surface)} was given, expected a surface of a body or of the ground")
            if surface.body != self.inner.body or surface.scene is not self.inner.scene:
                raise ModelError(f"{name}: {shown(surface)} was given, expected one of the body that inner belongs to")
        in_range("width", self.width, 0.0, math.inf, open_ends=True)

    @property
    def parts(self) -> SlotParts[PlacedSurface]:
        """The four surfaces."""
        return SlotParts(self.inner, self.outer, self.first, self.last)

    def outside(self, place: FloatArray) -> float:
        """How far ``place`` (2,), in the frame of the undeformed body, is outside of the slot [m]; negative inside."""
        a, b = (end.shape.points[0].place for end in (self.first, self.last))
        to_ends = min(float(np.hypot(*(place - a))), float(np.hypot(*(place - b))))
        return self._aside(place, a, b, to_ends) - 0.5 * self.width

    def _aside(self, place: FloatArray, a: FloatArray, b: FloatArray, to_ends: float) -> float:
        """Distance from the middle line, which runs from a to b."""
        track: shapes.Surface = self.inner.shape
        if track.kind is shapes.Kind.CHAIN:
            along = (b - a) / np.hypot(*(b - a))
            s = float(along @ (place - a))
            return (
                abs(float(along[0] * (place - a)[1] - along[1] * (place - a)[0]))
                if 0.0 < s < along @ (b - a)
                else to_ends
            )
        x, y = place - track.points[0].place
        if (math.atan2(y, x) - track.start) % (2.0 * math.pi) > track.extent:
            return to_ends
        return abs(math.hypot(x, y) - track.radius - 0.5 * self.width)


def curved_slot(body: Placed, center: Place, radius: float, width: float, start: float, extent: float) -> Slot:
    """See :meth:`lcpflex.scene.handles.Placed.curved_slot`."""
    middle = in_range("radius", radius, 0.0, math.inf, open_ends=True)
    wide = in_range("width", width, 0.0, 2.0 * middle, open_ends=True)
    begin = in_range("start", start, -math.inf, math.inf)
    turn = in_range("extent", extent, 0.0, 2.0 * math.pi, open_ends=True)
    half, end = 0.5 * wide, begin + turn
    between = 2.0 * middle * math.sin(0.5 * turn) - wide if turn > math.pi else math.inf  # the ends, back to back
    if between <= 0.0:
        raise ModelError(f"extent: {shown(extent)} was given, expected less: the ends of the slot run into each other")

    inner = partial(shapes.arc, radius=middle - half, start=begin, extent=turn, goes_over=True)
    outer = partial(shapes.arc, radius=middle + half, start=begin, extent=turn, hole=True, goes_over=True)
    cap = partial(_cap, middle=middle, half=half, wall=between)
    return Slot(
        body._made_of("inner", (center,), inner),
        body._made_of("outer", (center,), outer),
        body._made_of("first", (center,), partial(cap, angle=begin, opening=begin + math.pi)),
        body._made_of("last", (center,), partial(cap, angle=end, opening=end)),
        wide,
    )


def _cap(at: MaterialPoint, middle: float, half: float, wall: float, angle: float, opening: float) -> Surface:
    """The end of a curved slot about ``at`` whose middle line has the radius ``middle``."""
    offset = middle * np.array([math.cos(angle), math.sin(angle)])
    end = shapes.arc(shapes.carried(at, offset), half, opening, math.pi, hole=True, goes_over=True)
    return replace(end, wall=wall)


def straight_slot(body: Placed, first: Place, last: Place, width: float) -> Slot:
    """See :meth:`lcpflex.scene.handles.Placed.straight_slot`."""
    wide = in_range("width", width, 0.0, math.inf, open_ends=True)
    side, cap = partial(_side, half=0.5 * wide), partial(_straight_cap, half=0.5 * wide)
    return Slot(
        body._made_of("inner", (first, last), side),
        body._made_of("outer", (last, first), side),
        body._made_of("first", (last, first), cap),
        body._made_of("last", (first, last), cap),
        wide,
    )


def _side(a: MaterialPoint, b: MaterialPoint, half: float) -> Surface:
    """The track of a straight slot on the left from a to b."""
    along = _direction(a, b)
    left = half * np.array([-along[1], along[0]])
    return shapes.chain([shapes.carried(a, left), shapes.carried(b, left)], goes_over=True)


def _straight_cap(a: MaterialPoint, b: MaterialPoint, half: float) -> Surface:
    """The end of a straight slot about b."""
    along = _direction(a, b)
    opening = math.atan2(along[1], along[0]) - 0.5 * math.pi
    return shapes.arc(b, half, opening, math.pi, hole=True, goes_over=True)


def _direction(a: MaterialPoint, b: MaterialPoint) -> FloatArray:
    along = b.place - a.place
    length = float(np.hypot(*along))
    if length == 0.0:
        raise ModelError(f"last: the ends of a slot are both at {a.place.tolist()}, expected two places")
    return np.asarray(along / length)
