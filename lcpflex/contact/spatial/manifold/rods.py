"""A cylinder among convex bodies, as a manifold sees it: in the frame of the other body, with its farthest places.

Along a unit vector n it reaches, below its middle m, n.m - L/2 |n.a| - R sqrt(1 - (n.a)^2).
"""

from __future__ import annotations

import math
from typing import NamedTuple

from lcpflex.bodies.spatial.surface import RIM_POINTS
from lcpflex.contact.spatial.cylinder_pass import ENDS_OF, SIDE_OF
from lcpflex.contact.spatial.kinds import AROUND
from lcpflex.contact.spatial.narrow_phase.cylinder import length_between
from lcpflex.contact.spatial.narrow_phase.edges import TILT
from lcpflex.contact.spatial.narrow_phase.rim import lowest_on_rim, rim_axis
from lcpflex.contact.spatial.narrow_phase.sides import Frame, frame_of, place_in, seen_from, world_place
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.kinematics.spatial.rotations import Vector
from lcpflex.kinematics.spatial.vectors import added, dot, scaled, turned_back
from lcpflex.model.spatial import SpatialModel

__all__ = ["Rod", "axis_node", "cap_of", "center_of", "chord_of", "is_along", "is_across", "lowest_at", "lowest_height",
           "outward_of", "rim_node", "rod_of", "side_of_rod"]  # fmt: skip

FLAT_FROM = math.cos(TILT)  # of the axis along a normal: from here on an end lies on the face
LYING_TO = math.sin(TILT)  # and up to here the side does
CHORDS_OF = ENDS_OF + 2  # of the features of a cylinder


class Rod(NamedTuple):
    """A cylinder: its surface, its first feature, where it begins [m], its axis, length and radius [m]."""

    surface: int
    first: int
    start: Vector
    axis: Vector
    length: float
    radius: float


@kernel
def rod_of(model: SpatialModel, q: FloatArray, s: int, frame: Frame) -> Rod:
    """Surface s in a frame."""
    c = model.contacts
    own, first = frame_of(model.bodies, q, c.surface_body[s]), c.feature_start[s]
    o, x = c.feature_point[first, 0], c.feature_point[first, 1]
    start = seen_from(frame, world_place(own, place_in(model.points, q, own, o)))
    axis = turned_back(frame.A, rim_axis(model.points, q, own, o, x))
    return Rod(s, first, start, axis, length_between(model.points, o, x), c.feature_radius[first])


@kernel
def center_of(rod: Rod, end: int) -> Vector:
    """Of an end, 0 or 1 [m]."""
    return added(rod.start, scaled(rod.length, rod.axis)) if end == 1 else rod.start


@kernel
def outward_of(rod: Rod, end: int) -> Vector:
    """The normal of an end."""
    return rod.axis if end == 1 else scaled(-1.0, rod.axis)


@kernel
def lowest_at(rod: Rod, end: int, n: Vector) -> Vector:
    """The lowest place of a rim along n [m]."""
    c, _ = lowest_on_rim(rod.axis, n)
    return added(center_of(rod, end), scaled(rod.radius, c))


@kernel
def lowest_height(rod: Rod, n: Vector) -> float:
    """The least n.r of all its places r [m]."""
    return min(dot(n, lowest_at(rod, 0, n)), dot(n, lowest_at(rod, 1, n)))


@kernel
def is_along(rod: Rod, n: Vector) -> bool:
    """Whether an end lies flat on a face with the normal n, or nearly."""
    return abs(dot(rod.axis, n)) > FLAT_FROM


@kernel
def is_across(rod: Rod, n: Vector) -> bool:
    """Whether the side lies along a face with the normal n, or nearly."""
    return abs(dot(rod.axis, n)) < LYING_TO


@kernel
def side_of_rod(rod: Rod) -> int:
    """The feature of the side, whose ends are those of the axis."""
    return rod.first + SIDE_OF


@kernel
def cap_of(rod: Rod, end: int) -> int:
    """The feature of an end."""
    return rod.first + ENDS_OF + end


@kernel
def chord_of(rod: Rod, end: int, k: int) -> int:
    """The feature of the chord from point k of a rim to the next one."""
    return rod.first + CHORDS_OF + end * AROUND + k


@kernel
def rim_node(model: SpatialModel, rod: Rod, end: int, k: int) -> int:
    """Point k of a rim among the nodes, which has every other point behind the others."""
    later = 2 * RIM_POINTS if k % 2 == 1 else 0
    return model.contacts.node_start[rod.surface] + later + end * RIM_POINTS + k // 2


@kernel
def axis_node(model: SpatialModel, rod: Rod, end: int) -> int:
    """The middle of an end, as a sphere of the radius of the cylinder, among the nodes."""
    return model.contacts.node_start[rod.surface + 1] - 2 + end
