"""Surfaces of bodies and of the ground: what they are made of, which can touch, and which points touch which side.

A surface holds *nodes*, material points with a radius that may touch others, and *features*, the segments and arcs
that others may touch. Which side does what follows from the two kinds: discs, single nodes and solid arcs are the node
side of everything, chains that of half-planes, holes and (both ways) of other chains, if nothing else was chosen. The
ends of an open arc are corners, as those of a chain: nodes beside it, and features; those of part of a hole are the
nodes that it has.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import Enum

import numpy as np
import numpy.typing as npt

from lcpflex.bodies.body import Chain, MaterialPoint, Outline
from lcpflex.errors import ModelError
from lcpflex.jit.kernel import FloatArray

__all__ = [
    "Kind",
    "Surface",
    "arc",
    "can_touch",
    "carried",
    "chain",
    "circle",
    "half_plane",
    "hole",
    "can_be_node_side",
    "node",
    "on_body",
]

WHOLE = 2.0 * math.pi - 2e-9  # [rad] an arc of more has no ends: detection widens it to a circle
ROUND = 128  # corners of the polygon that stands for a round outline where the thickness of the solid is measured


class Kind(Enum):
    """What a surface is made of."""

    NODE = "node"
    CIRCLE = "circle"
    CHAIN = "chain"
    ARC = "arc"
    HOLE = "hole"
    HALF_PLANE = "half-plane"


@dataclass(frozen=True, slots=True, eq=False)
class Surface:
    """One surface of a body, in its frame. Made by the functions of this module.

    points: material points (nodes of a chain; centre of a circle, hole or arc; two points a metre apart of a
    half-plane). radius [m] of circles, holes, arcs and discs. start, extent [rad] of arcs. closed: whether a chain ends
    where it begins. outline (k, 2): closed outline of the body, which tells how deep the solid is below an open chain
    or behind the wall of a hole; without it, as deep as the chain or hole is large. mirrored: whether the body is the
    half section of a solid of revolution, which goes on beyond an end of a chain on its axis, y = 0. goes_over: whether
    another surface goes on smoothly at both ends of an open chain or arc, so that no corner is there to be touched.
    wall [m]: thickness of the solid behind the wall of a hole, where another hole is nearer than the outline.
    """

    kind: Kind
    points: tuple[MaterialPoint, ...]
    radius: float = 0.0
    start: float = 0.0
    extent: float = 2.0 * math.pi
    closed: bool = False
    outline: FloatArray | None = None
    mirrored: bool = False
    goes_over: bool = False
    wall: float = math.inf

    def goes_on(self) -> tuple[bool, bool]:
        """Whether the solid goes on beyond the beginning and the end of an open chain, though the chain does not."""
        first, last = (float(self.points[k].place[1]) == 0.0 for k in (0, -1))
        return self.mirrored and first, self.mirrored and last

    def ends(self) -> tuple[MaterialPoint, ...]:
        """Corners at the beginning and the end of an open arc, carried by the material at its centre; else none."""
        if self.kind not in (Kind.ARC, Kind.HOLE) or self.goes_over or self.extent >= WHOLE:
            return ()
        angles = (self.start, self.start + self.extent)
        offsets = [self.radius * np.array([math.cos(angle), math.sin(angle)]) for angle in angles]
        return carried(self.points[0], offsets[0]), carried(self.points[0], offsets[1])

    @property
    def rank(self) -> int:
        """Order of node sides: of two surfaces, the lower one is the node side; see :data:`BOTH`."""
        if self.kind is Kind.HOLE:
            return OPEN_HOLE if self.ends() else NO_NODE
        return RANK.get(self.kind, NO_NODE)

    def can_touch(self, other: Surface) -> bool:
        """See :func:`can_touch`."""
        return can_touch(self, other)

    def can_be_node_side(self, other: Surface) -> bool:
        """See :func:`can_be_node_side`."""
        return can_be_node_side(self, other)

    def can_meet(self, other: Surface) -> bool:
        """Whether such surfaces can come to each other from apart: points cannot, nor solids that fill all around."""
        kinds = {self.kind, other.kind}
        return kinds != {Kind.NODE} and not kinds.issubset({Kind.HOLE, Kind.HALF_PLANE})

    def partners(self) -> str:
        """What contacts need, in words."""
        return "a node, disc or chain on one side"

    def node_sides(self) -> str:
        """What can be a node side, in words."""
        return "a node, disc, arc or chain, and no node for the other one"


def node(point: MaterialPoint, radius: float = 0.0) -> Surface:
    """A single material point, or a disc about it."""
    return Surface(Kind.NODE if radius == 0.0 else Kind.CIRCLE, (point,), radius)


def circle(center: MaterialPoint, radius: float) -> Surface:
    """A disc, solid inside."""
    return Surface(Kind.CIRCLE, (center,), radius)


def hole(center: MaterialPoint, radius: float) -> Surface:
    """A circular hole, solid outside."""
    return Surface(Kind.HOLE, (center,), radius)


def arc(
    center: MaterialPoint, radius: float, start: float, extent: float, hole: bool = False, goes_over: bool = False
) -> Surface:
    """Part of a circle from the angle ``start`` over ``extent`` [rad], body frame; solid inside; ``hole``: outside.

    Its ends are corners, unless it ``goes_over`` to other surfaces there.
    """
    return Surface(Kind.HOLE if hole else Kind.ARC, (center,), radius, start, extent, goes_over=goes_over)


def half_plane(point: MaterialPoint, normal: npt.ArrayLike) -> Surface:
    """Everything behind the line through ``point``; ``normal`` (2,) points out of the solid."""
    direction = np.asarray(normal, dtype=float)
    along = np.array([-direction[1], direction[0]]) / np.hypot(*direction)
    return Surface(Kind.HALF_PLANE, (point, carried(point, along)))  # a second point a metre along the line


def carried(point: MaterialPoint, offset: FloatArray) -> MaterialPoint:
    """A point ``offset`` (2,) [m] from ``point``, carried rigidly by the material there."""
    turned = np.array([-offset[1], offset[0]])
    return MaterialPoint(point.place + offset, point.phi + point.psi[:, None] * turned, point.psi)


def chain(points: Sequence[MaterialPoint], closed: bool = False, goes_over: bool = False) -> Surface:
    """Straight pieces from node to node, solid on the left; ``goes_over``: its ends are no corners but go over to arcs.

    A chain that ends where it begins is closed: ends that may be bulges would hide the solid behind them.

    Raises
    ------
    ModelError
        If two successive nodes coincide.
    """
    if not closed and not goes_over and len(points) > 3 and _coincide(points[0], points[-1]):
        points, closed = points[:-1], True
    places = np.array([point.place for point in points])
    steps = np.diff(np.vstack([places, places[:1]]) if closed else places, axis=0)
    if len(steps) and np.hypot(*steps.T).min() == 0.0:
        raise ModelError(
            f"chain: nodes {places.tolist()} were given, expected no two successive ones at the same place"
        )
    return Surface(Kind.CHAIN, tuple(points), closed=closed, goes_over=goes_over)


def _coincide(a: MaterialPoint, b: MaterialPoint) -> bool:
    """Whether two material points are one, however their body deforms."""
    return np.array_equal(a.place, b.place) and np.array_equal(a.phi, b.phi) and np.array_equal(a.psi, b.psi)


def whole_section(half: FloatArray) -> FloatArray:
    """Closed outline of the section of a solid of revolution about y = 0 from that of its upper half (k, 2).

    Both are counter-clockwise. One that does not touch the axis, as of a ring, stays what it is.
    """
    on_axis = half[:, 1] == 0.0
    if on_axis.all() or not on_axis.any():
        return half
    last = int(np.flatnonzero(on_axis & ~np.roll(on_axis, -1))[0])  # from where the loop leaves the axis
    loop = np.roll(half, -last, axis=0)
    back = 1 + int(np.flatnonzero(loop[1:, 1] == 0.0)[0]) if np.any(loop[1:, 1] == 0.0) else len(loop)
    upper = loop[: back + 1]
    lower = upper[(-2 if back < len(loop) else -1) : 0 : -1] * np.array([1.0, -1.0])
    return np.vstack([upper, lower])


def on_body(surface: Surface, outline: Outline, mirrored: bool = False) -> Surface:
    """``surface`` with the closed outline of its body, from which it takes how deep the solid is.

    ``mirrored``: the body is the half section of a solid of revolution.
    """
    if isinstance(outline, Chain):
        if not outline.closed:
            return surface
        places = np.array([point.place for point in outline.points])
        if mirrored:
            return replace(surface, outline=whole_section(places), mirrored=True)
    else:
        if outline.hole:
            return surface
        angle = np.arange(ROUND) * (2.0 * math.pi / ROUND)
        places = outline.center.place + outline.radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return replace(surface, outline=places)


RANK = {Kind.NODE: 0, Kind.CIRCLE: 1, Kind.ARC: 2, Kind.CHAIN: 3}  # the lower is the node side; others are none
BOTH = RANK[Kind.CHAIN]  # of two surfaces of this rank or the next, corners of each may touch the other
OPEN_HOLE = BOTH + 1  # part of a hole, whose ends are corners
NO_NODE = OPEN_HOLE + 1


def can_touch(a: Surface, b: Surface) -> bool:
    """Whether there is a contact between surfaces of these kinds: a node, disc, solid arc or chain is one of them."""
    return can_be_node_side(a, b) or can_be_node_side(b, a)


def can_be_node_side(node_side: Surface, other: Surface) -> bool:
    """Whether ``node_side`` has material points that may touch others, and ``other`` features to be touched."""
    return node_side.rank != NO_NODE and other.kind is not Kind.NODE
