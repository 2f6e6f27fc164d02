"""What touches when a cylinder touches: a face or flat end, or two curves that cross."""

from __future__ import annotations

from typing import NamedTuple

from lcpflex.contact.spatial.manifold.hulls import SHALLOW, WORSE
from lcpflex.contact.spatial.manifold.rods import Rod
from lcpflex.contact.spatial.narrow_phase.edges import END, crossing_of
from lcpflex.jit.kernel import kernel
from lcpflex.kinematics.spatial.rotations import Vector
from lcpflex.kinematics.spatial.vectors import scaled

__all__ = [
    "Curves",
    "DEEP",
    "Flat",
    "NO_CURVES",
    "ON_RIM",
    "SIDE_ACROSS",
    "SIDE_ALONG",
    "VERTEX",
    "cross_within",
    "decides",
    "larger",
]

DEEP = 0.02  # of the size: two bodies whose ends are in one plane are as deep in each other as they are long, side by
# side; where faces are deeper than that, curves are asked, too
NO_CURVES, SIDE_ACROSS, SIDE_ALONG, ON_RIM, VERTEX = range(5)


class Flat(NamedTuple):
    """The face or end that the other body is farthest above."""

    separation: float  # [m]
    at: int  # polygon, or end
    node: int  # of an end: the lowest vertex over it
    own: int  # of two cylinders: whose end it is


class Curves(NamedTuple):
    """The two curves across which two bodies are farthest apart."""

    separation: float  # [m]
    kind: int
    edge: int  # feature of the edge, or a vertex; of two cylinders: which one has the rim
    end: int  # of the rim; -1: the side
    half: float  # of the circle
    sense: float  # of e x a as the normal


@kernel
def larger(one: Curves, other: Curves) -> Curves:
    """That with the larger separation."""
    return other if other.separation > one.separation else one


@kernel
def decides(curves: Curves, flat: Flat, size: float) -> bool:
    """Whether curves are farther apart than faces, by more than tells nothing: a patch tells more."""
    return curves.separation > flat.separation + WORSE * abs(flat.separation) + SHALLOW * size


@kernel
def cross_within(y: Vector, e: Vector, rod: Rod) -> bool:
    """Whether a line e from y behind the start of a rod crosses its axis between the ends of both."""
    _, s, t = crossing_of(y, e, scaled(rod.length, rod.axis))
    return END < s < 1.0 - END and END < t < 1.0 - END
