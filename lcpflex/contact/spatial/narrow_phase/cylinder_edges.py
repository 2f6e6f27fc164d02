"""An edge from material point a to b of body i, of radius rho, by a cylinder of radius R and length L from o along a_j.

Its side: as two edges, e = r_b - r_a and a_j, but that the cylinder is carried rigidly by the material at o. Its rim,
the circle about the end at z0: X = r_a + s e and K = r_o + z0 a_j + R c are nearest to each other, tau = a_j x c,

    d = X - K = D n,   g = D - rho,   e.d = 0,   tau.d = 0,   t1 = tau.

Seen from the material at o, whose spin is Omega, with w = v_X - v_o - Omega x (X - r_o) and e' = edot - Omega x e, the
feet slide with s' and phi (c' = phi tau):

    e.e s' - R e.tau phi = -(d.e' + e.w),   e.tau s' - (R + c.d) phi = -tau.w,
    d' = w + s' e - R phi tau,   n' = (d' - (n.d') n)/D,   ndot = Omega x n + n',   t1dot.t2 = Omega.n - phi c.t2.

A sharp edge, rho = 0, may touch and cut the rim. Its D has a sign: n = +-(e x tau)/|.| leads out of the rim, and

    n' = -(n.e') e* + phi (n.c) tau*   with the dual basis e* = tau x n/d, tau* = n x e/d, d = n.(e x tau).

Its flat end: where the edge enters or leaves the circle about the end, seen along the axis, it is frozen in its
material as a node over that end: n = sigma a_j, g = sigma (z - z0) - rho, ndot = Omega x n. That this place moves along
the edge is left out, as of two edges that cross over a face (:mod:`lcpflex.contact.spatial.narrow_phase.crossing`).
"""

from __future__ import annotations

import math

from lcpflex.contact.spatial.narrow_phase.cylinder import across_axis, away_from_start, end_of, length_between
from lcpflex.contact.spatial.narrow_phase.edges import END, PARALLEL, TILT, crossing_of, edges_cross
from lcpflex.contact.spatial.narrow_phase.rim import rim_axis
from lcpflex.contact.spatial.narrow_phase.rim_line import nearest_of_half, nearest_on_rim, towards
from lcpflex.contact.spatial.narrow_phase.sides import (
    Frame,
    Motion,
    line_between,
    line_rate,
    place_in,
    point_spin,
    world_place,
)
from lcpflex.contact.spatial.narrow_phase.turning import COINCIDENT, Turning, set_entry
from lcpflex.contact.spatial.table import EDGE_CAP, EDGE_SIDE, SpatialContactTable
from lcpflex.jit.kernel import FloatArray, kernel, late_kernel
from lcpflex.kinematics.spatial.rotations import Vector, cross
from lcpflex.kinematics.spatial.vectors import NOTHING, added, apart_from, dot, norm, row_vector, scaled, turned
from lcpflex.model.spatial import SpatialPoints

__all__ = ["crossing_of_circle", "edge_by_cylinder_turning", "edge_margin", "refresh_edge_by_cylinder"]


@kernel
def edge_of(
    points: SpatialPoints, q: FloatArray, frames: tuple[Frame, Frame], table: SpatialContactTable, k: int
) -> tuple[Vector, Vector, Vector]:
    """r_a - r_o, e and the axis of the cylinder of entry k, world axes."""
    i, j = frames
    head = world_place(i, place_in(points, q, i, table.point[k, 0]))
    e = turned(i.A, line_between(points, q, i, table.point[k, 0], table.point[k, 1]))
    o, x = table.point[k, 2], table.point[k, 3]
    return apart_from(head, world_place(j, place_in(points, q, j, o))), e, rim_axis(points, q, j, o, x)


@late_kernel
def refresh_edge_by_cylinder(
    points: SpatialPoints, q: FloatArray, i: Frame, j: Frame, table: SpatialContactTable, k: int
) -> None:
    """Gap, normal, tangent and foot of entry k, which stays at its side or rim."""
    y, e, a = edge_of(points, q, (i, j), table, k)
    if table.kind[k] == EDGE_SIDE:
        refresh_by_side(table, k, y, e, a)
    elif table.kind[k] == EDGE_CAP:
        s, _ = crossing_of_circle(y, e, a, table.radius[k, 2], table.foot[k, 1])
        table.foot[k, 0] = s
        sense = table.sense[k]
        height = sense * (dot(a, added(y, scaled(s, e))) - end_of(points, table, k)) - table.radius[k, 0]
        set_entry(table, k, height, scaled(sense, a), across_axis(points, q, j, table.point[k, 2], table.point[k, 3]))
    else:
        refresh_by_rim(points, table, k, y, e, a)


@kernel
def crossing_of_circle(y: Vector, e: Vector, a: Vector, R: float, half: float) -> tuple[float, float]:
    """s where an edge e from y leaves (half > 0) or enters a circle about the axis a; how far inside its middle is [m].

    Beside the circle, and below 0: where it is nearest to the axis.
    """
    p, f = apart_from(y, scaled(dot(a, y), a)), apart_from(e, scaled(dot(a, e), a))
    square = dot(f, f)
    if square <= COINCIDENT * COINCIDENT:
        return 0.0, -R
    middle = -dot(p, f) / square
    nearest = added(p, scaled(middle, f))
    reach = norm(nearest)
    if reach >= R:
        return middle, R - reach
    return middle + half * math.sqrt((R - reach) * (R + reach) / square), R - reach


@kernel
def refresh_by_side(table: SpatialContactTable, k: int, y: Vector, e: Vector, a: Vector) -> None:
    """The same of the side; an edge that has become parallel has no foot: it is infinite, and the normal stays."""
    radii = table.radius[k, 0] + table.radius[k, 2]
    if not edges_cross(e, a):
        table.gap[k] = dot(row_vector(table.normal, k), y) - radii
        table.foot[k, 0] = math.inf
        table.foot[k, 1] = math.inf
        return
    n, table.foot[k, 0], table.foot[k, 1] = crossing_of(y, e, a)
    set_entry(table, k, table.sense[k] * dot(n, y) - radii, scaled(table.sense[k], n), a)


@kernel
def refresh_by_rim(points: SpatialPoints, table: SpatialContactTable, k: int, y: Vector, e: Vector, a: Vector) -> None:
    """The same of a rim; foot: s, and which half of the circle. Where a round edge's axis goes through it, n stays."""
    R = table.radius[k, 2]
    away = apart_from(scaled(end_of(points, table, k), a), y)  # from r_a to the centre of the rim
    found = nearest_on_rim(a, R, e, away)
    c = towards(found, nearest_of_half(found, table.foot[k, 1]))
    to = added(away, scaled(R, c))
    s = dot(e, to) / dot(e, e)
    d = apart_from(scaled(s, e), to)
    d = apart_from(d, scaled(dot(d, e) / dot(e, e), e))
    D = norm(d)
    table.foot[k, 0] = s
    if table.radius[k, 0] == 0.0:
        tau = cross(a, c)
        n = cross(e, tau)
        size = norm(n)
        if size > PARALLEL * norm(e):
            out = dot(n, added(c, scaled(table.sense[k], a)))
            n = scaled(1.0 / size if out >= 0.0 else -1.0 / size, n)
            set_entry(table, k, dot(n, d), n, tau)
            return
    table.gap[k] = D - table.radius[k, 0]
    if D >= COINCIDENT:
        set_entry(table, k, D - table.radius[k, 0], scaled(1.0 / D, d), cross(a, c))


@kernel
def edge_by_cylinder_turning(
    points: SpatialPoints, q: FloatArray, u: FloatArray, frames: tuple[Frame, Frame], motions: tuple[Motion, Motion],
    table: SpatialContactTable, k: int, n: Vector, t: Vector, dv: Vector,
) -> Turning:  # fmt: skip
    """Of entry k, with normal n and first tangent t; dv = v_X - v_o, with its foot X frozen in the edge."""
    i = frames[0]
    first, last = table.point[k, 0], table.point[k, 1]
    line = line_between(points, q, i, first, last)
    e, edot = turned(i.A, line), line_rate(points, u, i, motions[0], first, last, line)
    spin, _ = point_spin(points, q, u, frames[1], motions[1], table.point[k, 2])
    a = rim_axis(points, q, frames[1], table.point[k, 2], table.point[k, 3])
    w = apart_from(dv, cross(spin, away_from_start(points, q, frames, table, k)))
    turn = apart_from(edot, cross(spin, e))
    D = table.gap[k] + table.radius[k, 0]
    if table.kind[k] == EDGE_SIDE:
        slide, rate = slide_along_side(e, a, n, D + table.radius[k, 2], turn, w)
        return Turning(added(cross(spin, n), rate), dot(spin, n), scaled(slide, edot), slide, 0.0)
    if table.kind[k] == EDGE_CAP:
        return Turning(cross(spin, n), dot(spin, n), NOTHING, 0.0, 0.0)
    R, c = table.radius[k, 2], cross(t, a)
    across, reach = dot(e, t), R + D * dot(c, n)
    on_e, on_t = -(D * dot(n, turn) + dot(e, w)), -dot(t, w)
    inverse = 1.0 / (R * across * across - dot(e, e) * reach)
    slide = (R * across * on_t - reach * on_e) * inverse
    around = (dot(e, e) * on_t - across * on_e) * inverse
    rate = added(w, apart_from(scaled(slide, e), scaled(R * around, t)))
    rate = scaled(1.0 / max(D, COINCIDENT), apart_from(rate, scaled(dot(n, rate), n)))
    inverse = dot(n, cross(e, t))
    if table.radius[k, 0] == 0.0 and abs(inverse) > PARALLEL * norm(e):
        dual_e, dual_t = scaled(1.0 / inverse, cross(t, n)), scaled(1.0 / inverse, cross(n, e))
        rate = added(scaled(-dot(n, turn), dual_e), scaled(around * dot(n, c), dual_t))
    about = dot(spin, n) - around * dot(c, cross(n, t))
    return Turning(added(cross(spin, n), rate), about, scaled(slide, edot), slide, 0.0)


@kernel
def slide_along_side(e: Vector, a: Vector, n: Vector, D: float, turn: Vector, w: Vector) -> tuple[float, Vector]:
    """s' of an edge by a side, and n': those of two edges of which the axis a is at rest; D: between the axes."""
    inverse = 1.0 / dot(n, cross(e, a))
    dual = scaled(inverse, cross(a, n))
    rate = scaled(-dot(n, turn), dual)
    return -dot(dual, apart_from(w, scaled(D, rate))), rate


@kernel
def edge_margin(
    points: SpatialPoints, q: FloatArray, i: Frame, j: Frame, table: SpatialContactTable, k: int, extent: float
) -> float:
    """How far entry k is inside its part of the cylinder.

    Of the side: how far from its ends it is crossed, in its length. Of an end: how far inside its circle the middle of
    the edge is, in extents. Of a rim: how far the normal is inside its wedge
    [rad], and how far the place is inside its half of the circle, in extents.
    """
    o, x = table.point[k, 2], table.point[k, 3]
    if table.kind[k] == EDGE_SIDE:
        t = table.foot[k, 1] / length_between(points, o, x)
        return min(t, 1.0 - t) - END
    y, e, a = edge_of(points, q, (i, j), table, k)
    if table.kind[k] == EDGE_CAP:
        _, within = crossing_of_circle(y, e, a, table.radius[k, 2], table.foot[k, 1])
        return within / extent
    n = row_vector(table.normal, k)
    found = nearest_on_rim(a, table.radius[k, 2], e, apart_from(scaled(end_of(points, table, k), a), y))
    place = nearest_of_half(found, table.foot[k, 1])
    across = table.radius[k, 2] * place[0]
    own = max(-found.apart, across) if table.foot[k, 1] >= 0.0 else min(found.apart, -across)
    return min(min(table.sense[k] * dot(n, a), dot(n, towards(found, place))) + TILT, own / extent)
