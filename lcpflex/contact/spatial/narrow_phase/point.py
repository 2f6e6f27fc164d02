"""A node P, a sphere of radius rho, by a material point o: a vertex, or a sphere of radius R, from inside if R < 0.

    n = sense (r_P - r_o)/|.|,   D = sense |r_P - r_o|,   g = D - R - rho,   ndot = (1 - n n^T) dv / D

with dv = v_P - v_o and sense = sgn(R), +1 of vertices. A point has no edge: t1 is the projection of that axis c of
body j which is farthest from the normal, and changes for another one where that has come close;
t1dot.t2 = t2.(cdot - (c.n) ndot)/|c - (c.n) n|.
"""

from __future__ import annotations

from lcpflex.contact.spatial.narrow_phase.edge import turning_away
from lcpflex.contact.spatial.narrow_phase.sides import Frame, Motion, place_in, world_place
from lcpflex.contact.spatial.narrow_phase.turning import COINCIDENT, Turning, set_entry
from lcpflex.contact.spatial.table import SpatialContactTable
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.kinematics.spatial.rotations import Matrix, Vector, cross
from lcpflex.kinematics.spatial.vectors import NOTHING, apart_from, dot, norm, scaled, turned, turned_back
from lcpflex.model.spatial import SpatialPoints

__all__ = ["axis", "farthest_axis", "point_turning", "refresh_point"]

CLOSE = 0.95  # of n.c: such an axis is too close to the normal to be projected; the farthest has 0.58 at most


@kernel
def axis(A: Matrix, c: int) -> Vector:
    """Axis c of a body, world axes."""
    return A[c], A[3 + c], A[6 + c]


@kernel
def farthest_axis(A: Matrix, n: Vector, now: int) -> int:
    """The axis that t1 is the projection of: ``now``, unless that is none or too close to the normal n."""
    a, b, c = turned_back(A, n)
    a, b, c = abs(a), abs(b), abs(c)
    if now >= 0 and (a, b, c)[now] < CLOSE:
        return now
    if a <= b and a <= c:
        return 0
    return 1 if b <= c else 2


@kernel
def refresh_point(points: SpatialPoints, q: FloatArray, i: Frame, j: Frame, table: SpatialContactTable, k: int) -> None:
    """Gap, normal and tangent of entry k. At the very centre there is no direction: both stay what they were."""
    r = world_place(i, place_in(points, q, i, table.point[k, 0]))
    d = apart_from(r, world_place(j, place_in(points, q, j, table.point[k, 1])))
    D = norm(d)
    sense = table.sense[k]
    table.gap[k] = sense * D - table.radius[k, 0] - table.radius[k, 1]
    if D < COINCIDENT:
        return
    n = scaled(sense / D, d)
    table.along[k] = farthest_axis(j.A, n, table.along[k])
    c = axis(j.A, table.along[k])
    t = apart_from(c, scaled(dot(c, n), n))
    set_entry(table, k, table.gap[k], n, scaled(1.0 / norm(t), t))


@kernel
def point_turning(
    frame: Frame, motion: Motion, table: SpatialContactTable, k: int, n: Vector, t: Vector, dv: Vector
) -> Turning:
    """Of entry k, with normal n and first tangent t."""
    D = table.gap[k] + table.radius[k, 0] + table.radius[k, 1]
    ndot = turning_away(n, dv, D)
    along = max(table.along[k], 0)
    c = axis(frame.A, along)
    rate = cross(turned(frame.A, motion.omega), c)
    height = dot(c, n)
    spin = dot(cross(n, t), apart_from(rate, scaled(height, ndot))) / dot(c, t)
    return Turning(ndot, spin, NOTHING, 0.0, 0.0)
