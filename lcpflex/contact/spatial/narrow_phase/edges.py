"""Two edges: from material point a to b of body i, with radius rho, and from c to d of body j, with radius R.

    e = r_b - r_a, f = r_d - r_c,   n = sense e x f/|.|,   y = r_a - r_c,   D = n.y,   g = D - rho - R
    s = -e*.y, t = f*.y,   ndot = -(n.edot) e* - (n.fdot) f*,   sdot = e*.(D ndot - dv), tdot = f*.(dv - D ndot)

with e*, f* the dual basis of e, f in the plane normal to n, and dv = v_P - v_Q of the feet P = r_a + s e and
Q = r_c + t f. The sense makes n lead out of body j. Parallel edges have no such normal: see :func:`edges_cross`.
"""

from __future__ import annotations

import math

from lcpflex.contact.spatial.narrow_phase.sides import (
    Frame,
    Motion,
    line_between,
    line_rate,
    place_in,
    seen_from,
    world_place,
)
from lcpflex.contact.spatial.narrow_phase.turning import Turning, set_entry
from lcpflex.contact.spatial.table import SpatialContactTable
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.kinematics.spatial.rotations import Vector, cross
from lcpflex.kinematics.spatial.vectors import added, apart_from, dot, norm, scaled, turned, turned_back
from lcpflex.model.spatial import SpatialPoints

__all__ = ["END", "PARALLEL", "TILT", "crossing_of", "edges_cross", "edges_turning", "refresh_edges"]

TILT = 0.02  # [rad] by which a normal may be off a wedge: faces that are less from parallel touch as such
END = 1e-6  # of its length: an edge that is crossed so near its end touches with its vertex
PARALLEL = 1e-6  # sine of the angle below which two edges are no pair of their own: their ends touch instead


@kernel
def edges_cross(e: Vector, f: Vector) -> bool:
    """Whether two edges (in the same axes) are far enough from parallel to touch as two edges."""
    return norm(cross(e, f)) > PARALLEL * norm(e) * norm(f)


@kernel
def crossing_of(y: Vector, e: Vector, f: Vector) -> tuple[Vector, float, float]:
    """n = e x f/|.| and the feet s, t where the line along e from y crosses that along f from 0, not parallel."""
    n = cross(e, f)
    size = norm(n)
    n = scaled(1.0 / size, n)
    return n, -dot(y, cross(f, n)) / size, dot(y, cross(n, e)) / size


@kernel
def refresh_edges(points: SpatialPoints, q: FloatArray, i: Frame, j: Frame, table: SpatialContactTable, k: int) -> None:
    """Gap, normal, tangent and feet of entry k; the feet may leave their edges.

    Edges that have become parallel have no feet: these are infinite, outside of both, and the normal stays.
    """
    start = place_in(points, q, j, table.point[k, 2])
    f = apart_from(place_in(points, q, j, table.point[k, 3]), start)
    head = place_in(points, q, i, table.point[k, 0])
    e = turned_back(j.A, turned(i.A, apart_from(place_in(points, q, i, table.point[k, 1]), head)))
    y = apart_from(seen_from(j, world_place(i, head)), start)
    radii = table.radius[k, 0] + table.radius[k, 1]
    if not edges_cross(e, f):
        n = turned_back(j.A, (table.normal[k, 0], table.normal[k, 1], table.normal[k, 2]))
        table.gap[k] = dot(n, y) - radii
        table.foot[k, 0] = math.inf
        table.foot[k, 1] = math.inf
        return
    sense = table.sense[k]
    n, table.foot[k, 0], table.foot[k, 1] = crossing_of(y, e, f)
    t = turned(j.A, scaled(1.0 / norm(f), f))
    set_entry(table, k, sense * dot(n, y) - radii, turned(j.A, scaled(sense, n)), t)


@kernel
def edges_turning(
    points: SpatialPoints, q: FloatArray, u: FloatArray, frames: tuple[Frame, Frame], motions: tuple[Motion, Motion],
    table: SpatialContactTable, k: int, n: Vector, t: Vector, dv: Vector,
) -> Turning:  # fmt: skip
    """Of entry k, with normal n and first tangent t."""
    D = table.gap[k] + table.radius[k, 0] + table.radius[k, 1]
    of_i = line_between(points, q, frames[0], table.point[k, 0], table.point[k, 1])
    of_j = line_between(points, q, frames[1], table.point[k, 2], table.point[k, 3])
    rate_e = line_rate(points, u, frames[0], motions[0], table.point[k, 0], table.point[k, 1], of_i)
    rate_f = line_rate(points, u, frames[1], motions[1], table.point[k, 2], table.point[k, 3], of_j)
    e, f = turned(frames[0].A, of_i), turned(frames[1].A, of_j)
    inverse = 1.0 / dot(n, cross(e, f))
    dual_e, dual_f = scaled(inverse, cross(f, n)), scaled(inverse, cross(n, e))
    ndot = added(scaled(-dot(n, rate_e), dual_e), scaled(-dot(n, rate_f), dual_f))
    away = apart_from(dv, scaled(D, ndot))
    on_i, on_j = -dot(dual_e, away), dot(dual_f, away)
    slip = apart_from(scaled(on_i, rate_e), scaled(on_j, rate_f))
    return Turning(ndot, dot(cross(n, t), rate_f) / norm(f), slip, on_i, on_j)
