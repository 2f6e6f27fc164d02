"""A node P, a sphere of radius rho, by a cylinder of radius R and length L from o along a: side, flat end, or rim.

The cylinder is carried rigidly by the material at o, whose spin is Omega. With y = r_P - r_o, z = a.y and
p = y - z a = r c, and of an end z0 = 0 or L and sigma = -1 or +1,

    side  n = c,          g = r - R - rho,             t1 = a
    cap   n = sigma a,    g = sigma (z - z0) - rho,    t1 fixed in the material
    rim   n = d/D,        g = D - rho,                 t1 = a x c,   d = (z - z0) a + (r - R) c,   D = |d|.

Seen from that material, P moves with w = v_P - v_o - Omega x y, and c' = (w - (a.w) a - (c.w) c)/r, d' = w - R c':

    ndot = Omega x n + n',   n' = c' of the side, 0 of a cap, (d' - (n.d') n)/D of the rim,
    t1dot.t2 = Omega.n + (a x c').t2,   the second part of the rim alone.

The cylinder is touched at r_o + l, l = y - (rho + g) n, which changes at ldot = ydot - gdot n - (rho + g) ndot.
"""

from __future__ import annotations

from lcpflex.contact.spatial.narrow_phase.rim import lowest_on_rim, rim_axis, turned_by_material
from lcpflex.contact.spatial.narrow_phase.sides import Frame, Motion, line_between, place_in, point_spin, world_place
from lcpflex.contact.spatial.narrow_phase.turning import COINCIDENT, Turning, set_entry
from lcpflex.contact.spatial.table import NODE_CAP, NODE_SIDE, SpatialContactTable, with_edge
from lcpflex.jit.kernel import FloatArray, kernel, late_kernel
from lcpflex.kinematics.spatial.rotations import Vector, cross
from lcpflex.kinematics.spatial.vectors import NOTHING, added, apart_from, dot, norm, row_vector, scaled
from lcpflex.model.spatial import SpatialPoints

__all__ = [
    "across_axis",
    "away_from_start",
    "cylinder_lever",
    "cylinder_lever_rate",
    "cylinder_margin",
    "cylinder_turning",
    "end_of",
    "length_between",
    "radial",
    "refresh_cylinder",
    "start_of",
]


@kernel
def length_between(points: SpatialPoints, o: int, x: int) -> float:
    """L [m] of a cylinder from material point o to x, undeformed."""
    return norm(apart_from(row_vector(points.place, x), row_vector(points.place, o)))


@kernel
def radial(a: Vector, y: Vector) -> tuple[float, Vector, float]:
    """z, p and r of a place that is y from o."""
    z = dot(a, y)
    p = apart_from(y, scaled(z, a))
    p = apart_from(p, scaled(dot(p, a), a))  # rounding, which would tilt the normal where p is short
    return z, p, norm(p)


@kernel
def outward(a: Vector, p: Vector, r: float, before: Vector) -> Vector:
    """c; on the axis itself, where there is no such direction, across the axis as near to ``before`` as that goes."""
    if r >= COINCIDENT:
        return scaled(1.0 / r, p)
    c, _ = lowest_on_rim(a, before)
    return scaled(-1.0, c)


@kernel
def start_of(table: SpatialContactTable, k: int) -> int:
    """The material point o of entry k."""
    return table.point[k, 2] if with_edge(table, k) else table.point[k, 1]


@kernel
def away_from_start(
    points: SpatialPoints, q: FloatArray, frames: tuple[Frame, Frame], table: SpatialContactTable, k: int
) -> Vector:
    """y of entry k [m], world axes: to the node, or to the foot on the edge of body i."""
    place = place_in(points, q, frames[0], table.point[k, 0])
    if with_edge(table, k):
        line = line_between(points, q, frames[0], table.point[k, 0], table.point[k, 1])
        place = added(place, scaled(table.foot[k, 0], line))
    start = place_in(points, q, frames[1], start_of(table, k))
    return apart_from(world_place(frames[0], place), world_place(frames[1], start))


@kernel
def end_of(points: SpatialPoints, table: SpatialContactTable, k: int) -> float:
    """z0 of entry k [m]."""
    if table.sense[k] < 0.0:
        return 0.0
    first = 2 if with_edge(table, k) else 1
    return length_between(points, table.point[k, first], table.point[k, first + 1])


@kernel
def across_axis(points: SpatialPoints, q: FloatArray, frame: Frame, o: int, x: int) -> Vector:
    """A unit vector across the axis that the material at o carries, world axes."""
    a = apart_from(row_vector(points.place, x), row_vector(points.place, o))
    c, _ = lowest_on_rim(scaled(1.0 / norm(a), a), NOTHING)
    return turned_by_material(points, q, frame, o, c)


@late_kernel
def refresh_cylinder(
    points: SpatialPoints, q: FloatArray, i: Frame, j: Frame, table: SpatialContactTable, k: int
) -> None:
    """Gap, normal and tangent of entry k, which stays at its side, end or rim. On the very rim n and t1 stay."""
    o, x = table.point[k, 1], table.point[k, 2]
    a = rim_axis(points, q, j, o, x)
    z, p, r = radial(a, away_from_start(points, q, (i, j), table, k))
    rho, R = table.radius[k, 0], table.radius[k, 2]
    if table.kind[k] == NODE_CAP:
        sense = table.sense[k]
        height = sense * (z - end_of(points, table, k))
        set_entry(table, k, height - rho, scaled(sense, a), across_axis(points, q, j, o, x))
        return
    c = outward(a, p, r, row_vector(table.normal, k))
    if table.kind[k] == NODE_SIDE:
        set_entry(table, k, r - R - rho, c, a)
        return
    d = added(scaled(z - end_of(points, table, k), a), scaled(r - R, c))
    D = norm(d)
    table.gap[k] = D - rho
    if D >= COINCIDENT:
        set_entry(table, k, D - rho, scaled(1.0 / D, d), cross(a, c))


@kernel
def cylinder_turning(
    points: SpatialPoints, q: FloatArray, u: FloatArray, frames: tuple[Frame, Frame], motions: tuple[Motion, Motion],
    table: SpatialContactTable, k: int, n: Vector, t: Vector, dv: Vector,
) -> Turning:  # fmt: skip
    """Of entry k, with normal n and first tangent t; dv = v_P - v_o."""
    o = table.point[k, 1]
    spin, _ = point_spin(points, q, u, frames[1], motions[1], o)
    ndot, about = cross(spin, n), dot(spin, n)
    if table.kind[k] == NODE_CAP:
        return Turning(ndot, about, NOTHING, 0.0, 0.0)
    a = rim_axis(points, q, frames[1], o, table.point[k, 2])
    y = away_from_start(points, q, frames, table, k)
    _, p, r = radial(a, y)
    c = outward(a, p, r, n)
    w = apart_from(dv, cross(spin, y))
    around = apart_from(apart_from(w, scaled(dot(a, w), a)), scaled(dot(c, w), c))
    around = scaled(1.0 / max(r, COINCIDENT), around)
    if table.kind[k] == NODE_SIDE:
        return Turning(added(ndot, around), about, NOTHING, 0.0, 0.0)
    rate = apart_from(w, scaled(table.radius[k, 2], around))
    rate = apart_from(rate, scaled(dot(n, rate), n))
    rate = scaled(1.0 / max(table.gap[k] + table.radius[k, 0], COINCIDENT), rate)
    return Turning(added(ndot, rate), about + dot(cross(a, around), cross(n, t)), NOTHING, 0.0, 0.0)


@kernel
def cylinder_lever(
    points: SpatialPoints, q: FloatArray, frames: tuple[Frame, Frame], table: SpatialContactTable, k: int, n: Vector
) -> Vector:
    """l of entry k [m], world axes: from o to where the cylinder is touched."""
    return apart_from(away_from_start(points, q, frames, table, k), scaled(table.radius[k, 0] + table.gap[k], n))


@kernel
def cylinder_lever_rate(
    table: SpatialContactTable, k: int, n: Vector, ndot: Vector, dv: Vector, spin: Vector, lever: Vector
) -> Vector:
    """ldot of entry k [m/s], world axes: of what touches, not of the material; dv = ydot, ``spin``: Omega."""
    closing = dot(n, apart_from(dv, cross(spin, lever)))
    turning = scaled(table.radius[k, 0] + table.gap[k], ndot)
    return apart_from(apart_from(dv, scaled(closing, n)), turning)


@kernel
def cylinder_margin(
    points: SpatialPoints, q: FloatArray, i: Frame, j: Frame, table: SpatialContactTable, k: int
) -> float:
    """How far the node of entry k is from what belongs to another part of the cylinder [m]."""
    a = rim_axis(points, q, j, table.point[k, 1], table.point[k, 2])
    z, _, r = radial(a, away_from_start(points, q, (i, j), table, k))
    if table.kind[k] == NODE_CAP:
        return table.radius[k, 2] - r
    if table.kind[k] == NODE_SIDE:
        return min(z, length_between(points, table.point[k, 1], table.point[k, 2]) - z)
    return min(r - table.radius[k, 2], table.sense[k] * (z - end_of(points, table, k)))
