"""The manifold of two cylinders.

Separating axes are the axes of both and, where these do not tell it, the normals of curves that cross: of the sides, of
a rim and a side, and of two rims.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from lcpflex.contact.spatial.entries import load_edge_by_rim, load_edges, load_rims
from lcpflex.contact.spatial.kinds import AROUND
from lcpflex.contact.spatial.manifold.curves import (
    DEEP,
    NO_CURVES,
    ON_RIM,
    SIDE_ACROSS,
    SIDE_ALONG,
    Curves,
    Flat,
    cross_within,
    decides,
    larger,
)
from lcpflex.contact.spatial.manifold.discs import NEARLY_PARALLEL, over_disc, set_disc
from lcpflex.contact.spatial.manifold.ends import lay_end_on_end
from lcpflex.contact.spatial.manifold.hulls import SHALLOW, THIN, TIE
from lcpflex.contact.spatial.manifold.lines import lay_on_end, lay_side_by_side
from lcpflex.contact.spatial.manifold.rods import (
    Rod,
    center_of,
    is_across,
    is_along,
    lowest_at,
    lowest_height,
    outward_of,
    rod_of,
    side_of_rod,
)
from lcpflex.contact.spatial.narrow_phase.edges import END
from lcpflex.contact.spatial.narrow_phase.rim_line import half_of, nearest_on_rim, towards
from lcpflex.contact.spatial.narrow_phase.rims import Circle, between, circle_of, nearest_of_rims, on_circle
from lcpflex.contact.spatial.narrow_phase.sides import frame_of
from lcpflex.contact.spatial.pairs import locate
from lcpflex.contact.spatial.table import SpatialContactTable
from lcpflex.jit.kernel import FloatArray, kernel, late_kernel
from lcpflex.kinematics.spatial.rotations import cross
from lcpflex.kinematics.spatial.vectors import added, apart_from, dot, norm, scaled
from lcpflex.model.spatial import SpatialModel

__all__ = ["cylinders_touch"]


class Rims(NamedTuple):
    """The two rims across which two cylinders are farthest apart, and the angles where they are nearest."""

    separation: float  # [m]
    one: int  # features
    other: int
    first: float  # [rad]
    second: float


@kernel
def end_of_rods(rods: tuple[Rod, Rod]) -> Flat:
    """Of two rods the end that the other one is farthest above; those of the second one first."""
    best = Flat(-math.inf, -1, -1, 0)
    for k in range(2):
        own = 1 - k
        for end in range(2):
            n = outward_of(rods[own], end)
            separation = lowest_height(rods[k], n) - dot(n, center_of(rods[own], end))
            tie = TIE * (rods[0].length + rods[1].length) if own == 0 and best.own == 1 else 0.0
            if separation > best.separation + tie:
                best = Flat(separation, end, -1, own)
    return best


@kernel
def side_by_side(rods: tuple[Rod, Rod]) -> Curves:
    """The sides of two rods; sense: of the first axis x the second one."""
    one, other = rods
    n = cross(one.axis, other.axis)
    away = apart_from(added(one.start, scaled(0.5 * one.length, one.axis)), other.start)
    away = apart_from(away, scaled(0.5 * other.length, other.axis))
    radii = one.radius + other.radius
    if norm(n) > NEARLY_PARALLEL:
        height = dot(n, away) / norm(n)
        return Curves(abs(height) - radii, SIDE_ACROSS, 0, 0, 1.0, 1.0 if height >= 0.0 else -1.0)
    away = apart_from(away, scaled(dot(away, other.axis), other.axis))
    return Curves(norm(away) - radii, SIDE_ALONG, 0, 0, 1.0, 1.0)


@kernel
def rim_by_side(rod: Rod, number: int, other: Rod) -> Curves:
    """The rims of a rod, which has this number, and the side of another one."""
    best = Curves(-math.inf, NO_CURVES, -1, 0, 1.0, 1.0)
    e = scaled(other.length, other.axis)
    for end in range(2):
        away, outward = apart_from(center_of(rod, end), other.start), outward_of(rod, end)
        found = nearest_on_rim(rod.axis, rod.radius, e, away)
        for k in range(2 if found.two else 1):
            place = found.first if k == 0 else found.second
            c = towards(found, place)
            to = added(away, scaled(rod.radius, c))
            s = dot(e, to) / dot(e, e)
            d = apart_from(scaled(s, e), to)
            if END < s < 1.0 - END and dot(d, outward) >= 0.0 and dot(d, c) >= 0.0:
                made = Curves(norm(d) - other.radius, ON_RIM, number, end, half_of(found, place[0]), 1.0)
                best = larger(best, made)
    return best


@kernel
def places_of_rims(one: Circle, other: Circle, found: Rims) -> Rims:
    """Of two rims the place with the largest separation, if that is larger than what was found.

    Places of the one that are nearer to the other than those beside them begin a search. What leads out of the one must
    lead into the other between side and end.
    """
    best = found
    step = 2.0 * math.pi / AROUND
    v = cross(other.axis, other.u)
    last, here = 0.0, 0.0
    for k in range(AROUND + 2):
        c, _ = on_circle(one, k * step)
        y = apart_from(added(one.middle, scaled(one.radius, c)), other.middle)
        second = math.atan2(dot(y, v), dot(y, other.u))
        d = between(one, k * step, other, second)
        following = dot(d, d)
        if k >= 2 and here <= last and here <= following:
            first, second = nearest_of_rims(one, other, (k - 1) * step, second)
            c, tau = on_circle(one, first)
            e, sigma = on_circle(other, second)
            n = cross(tau, sigma)
            if norm(n) > NEARLY_PARALLEL:
                n = scaled((1.0 if dot(n, apart_from(e, other.axis)) >= 0.0 else -1.0) / norm(n), n)
                out = min(min(dot(n, e), -dot(n, other.axis)), min(-dot(n, c), dot(n, one.axis)))
                separation = dot(n, between(one, first, other, second))
                if out >= 0.0 and separation > best.separation:
                    best = Rims(separation, best.one, best.other, first, second)
        last, here = here, following
    return best


@kernel
def rim_by_rim(model: SpatialModel, q: FloatArray, rods: tuple[Rod, Rod], margin: float) -> Rims:
    """The rims of two rods, where tangents of both are not nearly parallel."""
    c = model.contacts
    point = c.feature_point
    best = Rims(-math.inf, -1, -1, 0.0, 0.0)
    i, j = (
        frame_of(model.bodies, q, c.surface_body[rods[0].surface]),
        frame_of(model.bodies, q, c.surface_body[rods[1].surface]),
    )
    for end in range(2):
        rim = rods[0].first + end
        one = circle_of(model.points, q, i, point[rim, 0], point[rim, 1], rods[0].radius)
        for facing in range(2):
            touched = rods[1].first + facing
            other = circle_of(model.points, q, j, point[touched, 0], point[touched, 1], rods[1].radius)
            if norm(apart_from(one.middle, other.middle)) <= one.radius + other.radius + margin:
                made = places_of_rims(one, other, Rims(best.separation, rim, touched, 0.0, 0.0))
                if made.separation > best.separation:
                    best = made
    return best


@kernel
def lay_ends(
    model: SpatialModel, q: FloatArray, margin: float, table: SpatialContactTable, law: int, rods: tuple[Rod, Rod],
    flat: Flat, thin: float, size: float, n: int,
) -> tuple[int, bool]:  # fmt: skip
    """Entries that an end of one of two rods makes, from entry n on; the new count, and if any place is over it."""
    own, other = rods[flat.own], rods[1 - flat.own]
    frame = frame_of(model.bodies, q, model.contacts.surface_body[rods[1].surface])
    normal = outward_of(own, flat.at)
    facing = 0 if dot(other.axis, normal) > 0.0 else 1
    if is_along(other, normal):
        one, end, two, opposite = (
            (rods[0], facing, rods[1], flat.at) if flat.own == 1 else (rods[0], flat.at, rods[1], facing)
        )
        return lay_end_on_end(model, q, margin, table, law, frame, two, opposite, one, end, thin, size, n)
    if is_across(other, normal):
        return lay_on_end(model, q, margin, table, law, other, own, flat.at, thin, n)
    if not over_disc(set_disc(own, flat.at), lowest_at(other, facing, normal), thin):
        return n, False
    return lay_on_end(model, q, margin, table, law, other, own, flat.at, thin, n)


@kernel
def lay_sides(
    model: SpatialModel, q: FloatArray, margin: float, table: SpatialContactTable, law: int, rods: tuple[Rod, Rod],
    curves: Curves, thin: float, n: int,
) -> tuple[int, bool]:  # fmt: skip
    """The entries of the sides of two rods, or of a rim and a side, from entry n on; the same."""
    if curves.kind == SIDE_ALONG:
        return lay_side_by_side(model, q, margin, table, law, rods[0], rods[1], thin, n)
    if n < len(table.key):
        if curves.kind == SIDE_ACROSS:
            load_edges(model, table, n, law, side_of_rod(rods[0]), side_of_rod(rods[1]), curves.sense)
        else:
            rod, other = rods[curves.edge], rods[1 - curves.edge]
            load_edge_by_rim(model, table, n, law, side_of_rod(other), rod.first, curves.end, curves.half)
        locate(model, q, table, n)
    return n + 1, True


@late_kernel
def cylinders_touch(
    model: SpatialModel, q: FloatArray, margin: float, table: SpatialContactTable, a: int, b: int, law: int, n: int
) -> int:
    """Contacts of two cylinders with gaps up to ``margin``, from entry n on; the count."""
    c = model.contacts
    frame = frame_of(model.bodies, q, c.surface_body[b])
    rods = (rod_of(model, q, a, frame), rod_of(model, q, b, frame))
    flat = end_of_rods(rods)
    sides = side_by_side(rods)
    if flat.separation > margin or sides.separation > margin:
        return n
    size = 2.0 * min(c.surface_extent[a], c.surface_extent[b])
    thin = THIN * size
    if flat.separation > -DEEP * size:
        count, found = lay_ends(model, q, margin, table, law, rods, flat, thin, size, n)
        if found:
            return count
    if sides.kind == SIDE_ACROSS and not cross_within(
        apart_from(rods[0].start, rods[1].start), scaled(rods[0].length, rods[0].axis), rods[1]
    ):
        sides = Curves(-math.inf, NO_CURVES, -1, 0, 1.0, 1.0)
    curves = larger(sides, larger(rim_by_side(rods[0], 0, rods[1]), rim_by_side(rods[1], 1, rods[0])))
    rims = rim_by_rim(model, q, rods, margin)
    if max(curves.separation, rims.separation) > margin:
        return n
    if rims.separation > curves.separation:
        if not decides(Curves(rims.separation, ON_RIM, 0, 0, 1.0, 1.0), flat, size):
            count, found = lay_ends(model, q, margin, table, law, rods, flat, thin, size, n)
            if found or rims.separation < flat.separation - SHALLOW * size:
                return count
        if n < len(table.key):
            load_rims(model, table, n, law, rims.one, rims.other, rims.first, rims.second)
            locate(model, q, table, n)
        return n + 1
    if decides(curves, flat, size):
        count, found = lay_sides(model, q, margin, table, law, rods, curves, thin, n)
        if found:
            return count
    count, found = lay_ends(model, q, margin, table, law, rods, flat, thin, size, n)
    if not found and curves.separation > flat.separation - SHALLOW * size:
        count, found = lay_sides(model, q, margin, table, law, rods, curves, thin, n)
    return count
