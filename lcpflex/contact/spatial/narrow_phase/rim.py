"""The rim of a disc, a circle of radius R about o with axis a, over a plane: its lowest point C, of tube radius rho.

    m = n - (n.a) a,   c = -m/|m|,   r_C = r_o + R c,   g = n.(r_C - r_plane) - rho
    mdot = ndot - (ndot.a + n.adot) a - (n.a) adot,   cdot = -(mdot - c (c.mdot))/|m|

a is fixed in the material at o. C moves along the rim without changing the gap in first order, and the gap rate is
that of the material at C: n.(v_o + R Omega x c - v_Q). |m| is the sine of the tilt. A disc that lies flat, |m| below
``FLAT``, has no lowest point that could be told, and touches with fixed points of its rim instead; in a patch with the
point towards the middle of the other body as well, which is fixed in the material from one detection to the next.
"""

from __future__ import annotations

import math

from lcpflex.contact.spatial.narrow_phase.facet import plane_of, set_over
from lcpflex.contact.spatial.narrow_phase.sides import Frame, is_rigid, modal_sum, place_in, world_place
from lcpflex.contact.spatial.table import SpatialContactTable
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.kinematics.spatial.rotations import Vector, cross, exponential, rotation_matrix
from lcpflex.kinematics.spatial.vectors import NOTHING, added, apart_from, dot, norm, row_vector, scaled, turned
from lcpflex.model.spatial import SpatialPoints

__all__ = [
    "FLAT",
    "direction_at",
    "lowest_on_rim",
    "place_on_rim",
    "refresh_rim",
    "rim_axis",
    "rim_rate",
    "turned_by_material",
]

FLAT = 1e-7  # sine of the tilt below which a disc lies flat: rounding tells where its lowest point is
LEVEL = 1e-12  # and below which it has none


@kernel
def turned_by_material(points: SpatialPoints, q: FloatArray, frame: Frame, o: int, a: Vector) -> Vector:
    """A direction a of the undeformed body, carried by the material at o, world axes."""
    if not is_rigid(points, o):
        psi = modal_sum(points, points.psi, o, q, frame.modal)
        w, i, j, k = exponential(psi[0], psi[1], psi[2])
        a = turned(rotation_matrix(w, i, j, k), a)
    return turned(frame.A, a)


@kernel
def rim_axis(points: SpatialPoints, q: FloatArray, frame: Frame, o: int, x: int) -> Vector:
    """a, world axes, of the rim about material point o; x: another one on its axis, undeformed."""
    a = (
        points.place[x, 0] - points.place[o, 0],
        points.place[x, 1] - points.place[o, 1],
        points.place[x, 2] - points.place[o, 2],
    )
    return turned_by_material(points, q, frame, o, scaled(1.0 / norm(a), a))


@kernel
def lowest_on_rim(a: Vector, n: Vector) -> tuple[Vector, float]:
    """c, and |m|. Without any tilt, all of the rim is as low: c is any direction in the disc then."""
    m = apart_from(n, scaled(dot(n, a), a))
    m = apart_from(m, scaled(dot(m, a), a))
    size = norm(m)
    if size > LEVEL:
        return scaled(-1.0 / size, m), size
    x, y, z = abs(a[0]), abs(a[1]), abs(a[2])
    other = (1.0 if x <= y and x <= z else 0.0, 1.0 if y < x and y <= z else 0.0, 1.0 if z < x and z < y else 0.0)
    c = cross(a, other)
    return scaled(1.0 / norm(c), c), 0.0


@kernel
def direction_at(points: SpatialPoints, q: FloatArray, frame: Frame, o: int, x: int, angle: float) -> Vector:
    """Across the axis of a rim at an angle about it, fixed in the material."""
    a = apart_from(row_vector(points.place, x), row_vector(points.place, o))
    a = scaled(1.0 / norm(a), a)
    u, _ = lowest_on_rim(a, NOTHING)
    c = added(scaled(math.cos(angle), u), scaled(math.sin(angle), cross(a, u)))
    return turned_by_material(points, q, frame, o, c)


@kernel
def place_on_rim(
    points: SpatialPoints, q: FloatArray, frame: Frame, table: SpatialContactTable, k: int, n: Vector
) -> tuple[Vector, float]:
    """c and |m| of entry k; of a disc that lies flat the place that detection has chosen, if any."""
    o, x = table.point[k, 0], table.point[k, 1]
    c, tilt = lowest_on_rim(rim_axis(points, q, frame, o, x), n)
    if tilt <= FLAT and table.facing[k] != 0.0:
        return direction_at(points, q, frame, o, x, table.facing[k]), 0.0
    return c, tilt


@kernel
def refresh_rim(points: SpatialPoints, q: FloatArray, i: Frame, j: Frame, table: SpatialContactTable, k: int) -> None:
    """Gap, normal, tangent and foot of entry k."""
    plane = plane_of(points, q, j, table.point[k, 2], table.point[k, 3], table.point[k, 4])
    o = table.point[k, 0]
    c, _ = place_on_rim(points, q, i, table, k, turned(j.A, plane.n))
    lowest = added(world_place(i, place_in(points, q, i, o)), scaled(table.radius[k, 2], c))
    set_over(table, k, j, plane, lowest, table.radius[k, 0])


@kernel
def rim_rate(a: Vector, n: Vector, c: Vector, size: float, spin: Vector, ndot: Vector) -> tuple[Vector, Vector]:
    """c, and cdot [1/s], where the material at o turns with ``spin``; of a disc without tilt, of the material."""
    if size == 0.0:
        return c, cross(spin, c)
    adot = cross(spin, a)
    mdot = apart_from(ndot, scaled(dot(ndot, a) + dot(n, adot), a))
    mdot = apart_from(mdot, scaled(dot(n, a), adot))
    return c, scaled(-1.0 / size, apart_from(mdot, scaled(dot(c, mdot), c)))
