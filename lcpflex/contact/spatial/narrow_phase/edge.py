"""A node P, a sphere of radius rho, by the edge from material point a to b, of radius R: sharp, or a capsule's axis.

    e = r_b - r_a,   s = e.(r_P - r_a)/e.e,   y = r_P - r_a - s e = D n,   g = D - rho - R
    sdot = (edot.y + e.dv)/e.e,   ndot = (1 - n n^T)(dv - sdot e)/D

with dv = v_P - v_Q, Q being the foot r_a + s e. The sense of n is +1; with -1 and R < 0 the node is in a bore.
"""

from __future__ import annotations

from lcpflex.contact.spatial.narrow_phase.sides import (
    Frame,
    Motion,
    line_between,
    line_rate,
    place_in,
    seen_from,
    world_place,
)
from lcpflex.contact.spatial.narrow_phase.turning import COINCIDENT, Turning, set_entry
from lcpflex.contact.spatial.table import SpatialContactTable
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.kinematics.spatial.rotations import Vector, cross
from lcpflex.kinematics.spatial.vectors import added, apart_from, dot, norm, row_vector, scaled, turned
from lcpflex.model.spatial import SpatialPoints

__all__ = ["edge_turning", "refresh_edge", "turning_away"]


HALF = 0.5  # of a unit vector


@kernel
def refresh_edge(points: SpatialPoints, q: FloatArray, i: Frame, j: Frame, table: SpatialContactTable, k: int) -> None:
    """Gap, normal, tangent and foot of entry k.

    On the line itself there is no direction: n stays if it is across, else it is one that is.
    """
    start = place_in(points, q, j, table.point[k, 1])
    e = apart_from(place_in(points, q, j, table.point[k, 2]), start)
    d = apart_from(seen_from(j, world_place(i, place_in(points, q, i, table.point[k, 0]))), start)
    square = dot(e, e)
    s = dot(e, d) / square
    t = scaled(1.0 / norm(e), e)
    y = apart_from(d, scaled(s, e))
    y = apart_from(y, scaled(dot(y, t), t))  # rounding of s e, which would tilt the normal where y is short
    D = norm(y)
    sense = table.sense[k]
    table.foot[k, 0] = s
    table.gap[k] = sense * D - table.radius[k, 0] - table.radius[k, 1]
    if D >= COINCIDENT:
        set_entry(table, k, table.gap[k], turned(j.A, scaled(sense / D, y)), turned(j.A, t))
    elif sense < 0.0:
        along = turned(j.A, t)
        n = row_vector(table.normal, k)
        n = apart_from(n, scaled(dot(n, along), along))
        if norm(n) < HALF:  # as good as along the line: that of the axes which is farthest from it
            a, b, c = abs(along[0]), abs(along[1]), abs(along[2])
            n = (1.0, 0.0, 0.0) if a <= b and a <= c else ((0.0, 1.0, 0.0) if b <= c else (0.0, 0.0, 1.0))
            n = apart_from(n, scaled(dot(n, along), along))
        set_entry(table, k, table.gap[k], scaled(1.0 / norm(n), n), along)


@kernel
def turning_away(n: Vector, rate: Vector, D: float) -> Vector:
    """ndot of n = y/D, where y changes at ``rate``."""
    at_least = max(abs(D), COINCIDENT)
    across = apart_from(rate, scaled(dot(n, rate), n))
    return scaled(1.0 / at_least if D >= 0.0 else -1.0 / at_least, across)


@kernel
def edge_turning(
    points: SpatialPoints, q: FloatArray, u: FloatArray, frame: Frame, motion: Motion, table: SpatialContactTable,
    k: int, n: Vector, t: Vector, dv: Vector,
) -> Turning:  # fmt: skip
    """Of entry k, with normal n and first tangent t."""
    D = table.gap[k] + table.radius[k, 0] + table.radius[k, 1]
    line = line_between(points, q, frame, table.point[k, 1], table.point[k, 2])
    e = turned(frame.A, line)
    rate = line_rate(points, u, frame, motion, table.point[k, 1], table.point[k, 2], line)
    slide = (D * dot(rate, n) + dot(e, dv)) / dot(e, e)
    ndot = turning_away(n, added(dv, scaled(-slide, e)), D)
    return Turning(ndot, dot(cross(n, t), rate) / norm(e), scaled(-slide, rate), 0.0, slide)
