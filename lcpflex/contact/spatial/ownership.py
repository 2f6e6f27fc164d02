"""Which features a place belongs to, in the frame of their body.

Above the surface: a facet owns what is between planes through its sides, a bulging edge what is beyond both its facets
and between its ends, a vertex what is behind the planes through it across all its edges. On a convex polyhedron every
outside place has one owner, and the least distance to a feature is that to the polyhedron. Below the surface there are
facets alone, down to a depth; across a hollow side a facet goes on below the one that it meets there.

The planes between features are those of the facets, and facets own what is on them, to a thickness that stands for
rounding. Facets of a body that deforms own more below them: where a flat face is bent to a hollow, places below the
side between two facets would be in neither, and deep below a facet of the far side. Facets may also have what is up to
a band beside them, if no other one owns it.

Source: Ericson, Real-Time Collision Detection (2005), 5.1.
"""

from __future__ import annotations

from typing import NamedTuple

from lcpflex.contact.spatial.kinds import EDGE, FACET
from lcpflex.contact.spatial.mesh_pairs import DEEP
from lcpflex.contact.spatial.narrow_phase.sides import Frame, is_rigid, place_in
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.kinematics.spatial.rotations import Vector, cross
from lcpflex.kinematics.spatial.vectors import NOTHING, apart_from, dot, norm, scaled
from lcpflex.model.spatial import SpatialModel

__all__ = ["Corners", "Over", "beyond_side", "corners_of", "facet_normal", "over", "over_facet"]


class Corners(NamedTuple):
    """Of a facet, in the frame of its body [m]."""

    a: Vector
    b: Vector
    c: Vector


class Over(NamedTuple):
    """Whether a feature owns a place, how far that is above it [m], and the way there."""

    owned: bool
    distance: float  # to a facet < 0 below it; to the centre of an edge, vertex or sphere
    away: Vector  # of facets the normal; else from the feature to the place, not normalised
    beside: float  # > 0: a facet has it though it is so far beside it [m]


NOWHERE = Over(False, 0.0, NOTHING, 0.0)
SEAM = 0.05  # [rad] by which facets of one face, or of a bulge, are bent to a hollow that they hold together, at most


@kernel
def corners_of(model: SpatialModel, q: FloatArray, frame: Frame, f: int) -> Corners:
    """Of facet f, deformed."""
    point = model.contacts.feature_point
    return Corners(
        place_in(model.points, q, frame, point[f, 0]),
        place_in(model.points, q, frame, point[f, 1]),
        place_in(model.points, q, frame, point[f, 2]),
    )


@kernel
def facet_normal(at: Corners) -> Vector:
    """Outward, of length 1."""
    n = cross(apart_from(at.b, at.a), apart_from(at.c, at.a))
    return scaled(1.0 / norm(n), n)


@kernel
def beyond_side(start: Vector, end: Vector, n: Vector, place: Vector) -> float:
    """How far a place is beyond the side of a facet with normal n from start to end, counter-clockwise [m]."""
    e = apart_from(end, start)
    return dot(apart_from(place, start), cross(e, n)) / norm(e)


@kernel
def over_side(
    model: SpatialModel, q: FloatArray, frame: Frame, across: int, start: Vector, end: Vector, beyond: Vector,
    place: Vector, thin: float,
) -> bool:  # fmt: skip
    """Whether a facet owns what is beyond its side from start to end: where that is below the facet it meets there.

    across: that facet, -1: none in a hollow. beyond: how far beyond this side, the one before and the one behind it,
    -1 of those that are no hollows. Past an end of the side, it must be beyond the next hollow side as well.
    """
    if beyond[0] <= thin:
        return True
    if across < 0:
        return False
    e = apart_from(end, start)
    along = dot(apart_from(place, start), e)
    if (along < 0.0 and beyond[1] <= thin) or (along > dot(e, e) and beyond[2] <= thin):
        return False
    at = corners_of(model, q, frame, across)
    height = dot(facet_normal(at), apart_from(place, at.a))
    return -model.contacts.feature_depth[across] <= height <= thin


@kernel
def over_facet(
    model: SpatialModel, q: FloatArray, frame: Frame, f: int, place: Vector, far: float, thin: float, band: float
) -> Over:
    """Of facet f, up to ``far`` above it; where it is not deep, up to a ``band`` beside it, too."""
    at = corners_of(model, q, frame, f)
    n = facet_normal(at)
    height = dot(n, apart_from(place, at.a))
    if height > far or height < -model.contacts.feature_depth[f]:
        return NOWHERE
    if height < 0.0 and not is_rigid(model.points, model.contacts.feature_point[f, 0]):
        thin -= SEAM * height
    beside = model.contacts.feature_neighbour
    g, h, i = beside[f, 0], beside[f, 1], beside[f, 2]
    x = beyond_side(at.b, at.c, n, place)
    y = beyond_side(at.c, at.a, n, place)
    z = beyond_side(at.a, at.b, n, place)
    hx, hy, hz = x if g >= 0 else -1.0, y if h >= 0 else -1.0, z if i >= 0 else -1.0
    owned = (
        over_side(model, q, frame, g, at.b, at.c, (x, hz, hy), place, thin)
        and over_side(model, q, frame, h, at.c, at.a, (y, hx, hz), place, thin)
        and over_side(model, q, frame, i, at.a, at.b, (z, hy, hx), place, thin)
    )
    if owned:
        return Over(True, height, n, 0.0)
    out = max(x, max(y, z))
    return Over(out <= band and height >= -DEEP * band, height, n, out)


@kernel
def beyond_facet(
    model: SpatialModel, q: FloatArray, frame: Frame, facet: int, f: int, place: Vector, thin: float
) -> bool:
    """Whether a place is beyond the side of a facet that is the edge f."""
    if facet < 0:
        return True
    point = model.contacts.feature_point
    at = corners_of(model, q, frame, facet)
    n = facet_normal(at)
    p, r = point[f, 0], point[f, 1]
    if point[facet, 0] != p and point[facet, 0] != r:
        return beyond_side(at.b, at.c, n, place) > thin
    if point[facet, 1] != p and point[facet, 1] != r:
        return beyond_side(at.c, at.a, n, place) > thin
    return beyond_side(at.a, at.b, n, place) > thin


@kernel
def over_edge(model: SpatialModel, q: FloatArray, frame: Frame, f: int, place: Vector, far: float, thin: float) -> Over:
    """Of edge f, up to ``far`` from its line."""
    c = model.contacts
    a = place_in(model.points, q, frame, c.feature_point[f, 0])
    b = place_in(model.points, q, frame, c.feature_point[f, 1])
    e = apart_from(b, a)
    d = apart_from(place, a)
    along = dot(d, e)
    if along <= 0.0 or dot(apart_from(place, b), apart_from(a, b)) <= 0.0:
        return NOWHERE
    away = apart_from(d, scaled(along / dot(e, e), e))
    distance = norm(away)
    if distance > far:
        return NOWHERE
    first, second = c.feature_neighbour[f, 0], c.feature_neighbour[f, 1]
    if not beyond_facet(model, q, frame, first, f, place, thin):
        return NOWHERE
    if not beyond_facet(model, q, frame, second, f, place, thin):
        return NOWHERE
    return Over(is_outside(model, q, frame, first, second, away), distance, away, 0.0)


@kernel
def is_outside(model: SpatialModel, q: FloatArray, frame: Frame, first: int, second: int, away: Vector) -> bool:
    """Whether the way from an edge leads out of the solid below its two facets: not where it was bent to a hollow."""
    height = 0.0
    if first >= 0:
        height += dot(facet_normal(corners_of(model, q, frame, first)), away)
    if second >= 0:
        height += dot(facet_normal(corners_of(model, q, frame, second)), away)
    return height >= 0.0


@kernel
def over_point(model: SpatialModel, q: FloatArray, frame: Frame, f: int, place: Vector, far: float) -> Over:
    """Of vertex or sphere f, up to ``far`` from its centre."""
    c = model.contacts
    o = place_in(model.points, q, frame, c.feature_point[f, 0])
    away = apart_from(place, o)
    distance = norm(away)
    if distance > far:
        return NOWHERE
    for k in range(c.fan_start[f], c.fan_start[f + 1]):
        if dot(away, apart_from(place_in(model.points, q, frame, c.fan[k]), o)) > 0.0:
            return NOWHERE
    return Over(True, distance, away, 0.0)


@kernel
def over(
    model: SpatialModel, q: FloatArray, frame: Frame, f: int, place: Vector, far: float, thin: float, band: float
) -> Over:  # fmt: skip
    """Of feature f and a place in the frame of its body.

    It is ``far`` above its surface at most; ``thin``: of planes, ``band``: what facets have beside them [m].
    """
    kind = model.contacts.feature_kind[f]
    if kind == FACET:
        return over_facet(model, q, frame, f, place, far, thin, band)
    if kind == EDGE:
        return over_edge(model, q, frame, f, place, far + model.contacts.feature_radius[f], thin)
    return over_point(model, q, frame, f, place, far + model.contacts.feature_radius[f])
