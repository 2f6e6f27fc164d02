"""Two edges, of body i and j, that cross over a face of one of them, whose normal is that of the contact.

The corner of a patch of faces that lie on each other; or that of a face and a cylinder which lies on it, whose axis is
the other edge, of radius R (rho on i). With e = r_b - r_a of body i, f = r_d - r_c of body j, the
outward normal m of the face, n = m if it is on j and -m if it is on i, and y = r_a - r_c,

    P = r_a + s e,  Q = r_c + t f,  r_P - r_Q = D n:   s = -y.(f x n)/d,  t = y.(n x e)/d,  d = n.(e x f),
    g = D - rho - R.

One of e and f lies in the face. P and Q are frozen in the material, as of a node over a facet: the normal turns with
the face, and its foot there slides,

    ndot = Omega x n,   b_rel += -Omega x (1 - n n^T)(dv - D ndot),

Omega being that of the body of the face, and dv = v_P - v_Q. That the crossing itself moves along both edges is left
out: it changes g at the rate of the slip times the tilt of the edge over the sine of the crossing, 0 of faces on each
other.
"""

from __future__ import annotations

import math

from lcpflex.contact.spatial.narrow_phase.facet import PlaneTurn, plane_slip
from lcpflex.contact.spatial.narrow_phase.sides import Frame, Motion, place_in, seen_from, world_place
from lcpflex.contact.spatial.narrow_phase.turning import Turning, set_entry
from lcpflex.contact.spatial.table import SpatialContactTable
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.kinematics.spatial.rotations import Vector, cross
from lcpflex.kinematics.spatial.vectors import apart_from, dot, norm, scaled, turned, turned_back
from lcpflex.model.spatial import SpatialPoints

__all__ = ["crossing_turning", "face_on_j", "refresh_crossing"]

UNKNOWN = 1e-12  # sine of the angle of two edges below which rounding tells where they cross


@kernel
def face_on_j(points: SpatialPoints, table: SpatialContactTable, k: int) -> bool:
    """Whether the face of entry k is one of body j, else of body i."""
    return bool(points.body[table.point[k, 4]] == table.body[k, 1])


@kernel
def refresh_crossing(
    points: SpatialPoints, q: FloatArray, i: Frame, j: Frame, table: SpatialContactTable, k: int
) -> None:
    """Gap, normal, tangent and feet of entry k; the feet may leave their edges, those of parallel ones are infinite."""
    start = place_in(points, q, j, table.point[k, 2])
    f = apart_from(place_in(points, q, j, table.point[k, 3]), start)
    head = place_in(points, q, i, table.point[k, 0])
    e = turned_back(j.A, turned(i.A, apart_from(place_in(points, q, i, table.point[k, 1]), head)))
    y = apart_from(seen_from(j, world_place(i, head)), start)
    corner = table.point[k, 4]
    if face_on_j(points, table, k):
        side, inward = f, apart_from(place_in(points, q, j, corner), start)
    else:
        side, inward = e, turned_back(j.A, turned(i.A, apart_from(place_in(points, q, i, corner), head)))
    n = cross(side, inward)
    n = scaled(table.sense[k] / norm(n), n)
    d = dot(n, cross(e, f))
    height, table.foot[k, 0], table.foot[k, 1] = dot(n, y), math.inf, math.inf
    if abs(d) > UNKNOWN * norm(e) * norm(f):
        s = -dot(y, cross(f, n)) / d
        t = dot(y, cross(n, e)) / d
        table.foot[k, 0], table.foot[k, 1] = s, t
        height += s * dot(n, e) - t * dot(n, f)
    height -= table.radius[k, 0] + table.radius[k, 1]
    set_entry(table, k, height, turned(j.A, n), turned(j.A, scaled(1.0 / norm(side), side)))


@kernel
def crossing_turning(
    points: SpatialPoints, motions: tuple[Motion, Motion], frames: tuple[Frame, Frame], table: SpatialContactTable,
    k: int, n: Vector, t: Vector, dv: Vector,
) -> Turning:  # fmt: skip
    """Of entry k, with normal n and first tangent t, which are fixed in the face."""
    own = 1 if face_on_j(points, table, k) else 0
    omega = turned(frames[own].A, motions[own].omega)
    w = cross(n, t)
    turn = PlaneTurn(t, w, cross(omega, t), cross(omega, w), cross(omega, n), dot(omega, n))
    return plane_slip(turn, dv, table.gap[k] + table.radius[k, 0] + table.radius[k, 1])
