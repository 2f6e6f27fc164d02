"""Rigid bodies of space: from a shape and its density or mass, or from mass properties.

Each function gives a :class:`~lcpflex.bodies.spatial.body.SpatialBody` without modes. The frame of a shape has its
origin at the mass centre. Any place of space may be taken as a material point of a rigid body.
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from lcpflex.basics.arguments import array_of, mapping_of, numbers, positive, sequence_of
from lcpflex.bodies.fem.length_unit import check_rigid_size, metres
from lcpflex.bodies.spatial.body import SpatialBody, rigid_point
from lcpflex.bodies.spatial.checks import axes_of, even
from lcpflex.bodies.spatial.hull import block, convex_hull
from lcpflex.bodies.spatial.shapes import CapsuleShape, CylinderShape, Shape, SphereShape, SurfaceShape, triangles_of
from lcpflex.bodies.spatial.stl import TRIANGLES, read_stl
from lcpflex.bodies.spatial.triangle_solid import triangle_solid
from lcpflex.errors import ModelError, shown
from lcpflex.jit.kernel import FloatArray

__all__ = [
    "Capsule", "ConvexHull", "Cuboid", "Cylinder", "Polyhedron", "Sphere", "SpatialRigidBody", "corners_of",
]  # fmt: skip


def SpatialRigidBody(
    mass: float,
    inertia: npt.ArrayLike,
    center: Sequence[float] = (0.0, 0.0, 0.0),
    points: Mapping[str, Sequence[float]] | None = None,
    *,
    axes: Any = None,
) -> SpatialBody:
    """A rigid body of space from its mass properties. It has named points and no shape of its own.

    Parameters
    ----------
    mass : [kg]
    inertia : about the centre of mass [kg m^2]: a symmetric (3, 3) matrix J = integral of (|x|^2 I - x x^T) dm, whose
        off-diagonal entries are minus the integrals of x y, y z, z x; or the three principal moments
    center : (x, y, z) place of the centre of mass in the body frame [m]; the frame is the user's
    points : name -> (x, y, z) in the body frame [m]; "center" is always there
    axes : directions that ``inertia`` refers to, as the columns of a (3, 3) matrix or a ``Rotation`` of scipy, body
        frame; its own axes if omitted

    Raises
    ------
    ModelError
        For mass <= 0, NaN, an unsymmetric matrix, moments that violate the triangle inequality, mass on a line or in a
        point, axes that are not orthonormal or left-handed, or places that are not three numbers.
    """
    m = positive("mass", mass)
    given = numbers(inertia)
    flat = given is not None and given.ndim == 1
    J = np.diag(array_of("inertia", inertia, (3,))) if flat else even("inertia", array_of("inertia", inertia, (3, 3)))
    turn = axes_of("axes", axes)
    places = {"center": array_of("center", center, (3,))}
    for name, place in mapping_of("points", {} if points is None else points).items():
        places[name] = array_of(f"points[{name!r}]", place, (3,))
    at = places["center"]
    second = turn @ (0.5 * np.trace(J) * np.eye(3) - J) @ turn.T + m * np.outer(at, at)
    return _rigid(m, second, places, None, moment=m * at)


def Sphere(radius: float, density: float | None = None, mass: float | None = None) -> SpatialBody:
    """A homogeneous ball; frame origin and point "center": its centre. Inertia 2 m r^2 / 5.

    Parameters
    ----------
    radius : r [m]
    density, mass : one of the two [kg/m^3], [kg]

    Raises
    ------
    ModelError
        For anything not positive and finite, or both or none of density and mass.
    """
    r = positive("radius", radius)
    m = _mass(4.0 / 3.0 * math.pi * r**3, density, mass)
    return _rigid(m, m * r * r / 5.0 * np.eye(3), {"center": np.zeros(3)}, SphereShape(r))


def Cuboid(a: float, b: float, c: float, density: float | None = None, mass: float | None = None) -> SpatialBody:
    """A homogeneous rectangular block with edges along the axes; frame origin: its centre.

    Points "center", the middles of the faces "left", "right" (x), "front", "back" (y), "bottom", "top" (z), and the
    corners "left_front_bottom" ... "right_back_top". P0 = m / 12 diag(a^2, b^2, c^2).

    Parameters
    ----------
    a, b, c : edges along x, y, z [m]
    density, mass : one of the two [kg/m^3], [kg]

    Raises
    ------
    ModelError
        For anything not positive and finite, or both or none of density and mass.
    """
    edges = np.array([positive("a", a), positive("b", b), positive("c", c)])
    m = _mass(float(edges.prod()), density, mass)
    sides = (("left", "right"), ("front", "back"), ("bottom", "top"))
    places = {"center": np.zeros(3)}
    for axis, names in enumerate(sides):
        for sign, name in zip((-0.5, 0.5), names, strict=True):
            places[name] = sign * edges * (np.arange(3) == axis)
    corners, triangles = block()
    vertices = corners * edges
    for corner, place in zip(corners, vertices, strict=True):
        called = (names[int(half > 0.0)] for names, half in zip(sides, corner, strict=True))
        places["_".join(called)] = place
    return _rigid(m, m / 12.0 * np.diag(edges**2), places, _surface(vertices, triangles))


def Cylinder(radius: float, length: float, density: float | None = None, mass: float | None = None) -> SpatialBody:
    """A homogeneous cylinder along z; frame origin: its centre. P0 = m diag(r^2 / 4, r^2 / 4, l^2 / 12).

    Points "center", and the centres of its end faces "bottom" (z = -l / 2) and "top".

    Parameters
    ----------
    radius : r [m]
    length : l, along z [m]; a small one makes a disc, a long one a rod
    density, mass : one of the two [kg/m^3], [kg]

    Raises
    ------
    ModelError
        For anything not positive and finite, both or none of density and mass, or a radius below 5e-6 of the length,
        with which nothing resists a rotation about z.
    """
    r, h = positive("radius", radius), positive("length", length)
    m = _mass(math.pi * r * r * h, density, mass)
    second = m * np.diag([r * r / 4.0, r * r / 4.0, h * h / 12.0])
    return _rigid(m, second, _along_z(bottom=-h / 2.0, top=h / 2.0), CylinderShape(r, h))


def Capsule(radius: float, length: float, density: float | None = None, mass: float | None = None) -> SpatialBody:
    """A homogeneous cylinder along z with half spheres at its ends; frame origin: its centre.

    Points "center", the centres of the half spheres "lower_center", "upper_center" (z = -+l / 2), and the tips
    "bottom", "top". With the mass m_c of the cylinder and m_s of both half spheres
    P0_xx = m_c r^2 / 4 + m_s r^2 / 5,  P0_zz = m_c l^2 / 12 + m_s (l^2 / 4 + 3 l r / 8 + r^2 / 5).

    Parameters
    ----------
    radius : r [m]
    length : l, of the cylinder without the half spheres [m]
    density, mass : one of the two [kg/m^3], [kg]

    Raises
    ------
    ModelError
        For anything not positive and finite, both or none of density and mass, or a radius below 5e-6 of the length.
    """
    r, h = positive("radius", radius), positive("length", length)
    cylinder, ends = math.pi * r * r * h, 4.0 / 3.0 * math.pi * r**3
    m = _mass(cylinder + ends, density, mass)
    tube, caps = m * cylinder / (cylinder + ends), m * ends / (cylinder + ends)
    across = tube * r * r / 4.0 + caps * r * r / 5.0
    along = tube * h * h / 12.0 + caps * (h * h / 4.0 + 0.375 * h * r + r * r / 5.0)
    places = _along_z(lower_center=-h / 2.0, upper_center=h / 2.0, bottom=-h / 2.0 - r, top=h / 2.0 + r)
    return _rigid(m, np.diag([across, across, along]), places, CapsuleShape(r, h))


def ConvexHull(points: npt.ArrayLike, density: float | None = None, mass: float | None = None) -> SpatialBody:
    """A homogeneous convex polyhedron, the hull of points. **Its frame is moved to its mass centre**.

    ``body.origin`` is the mass centre in the coordinates given: a point x of them is x - origin in the body frame.
    Points "center", and "vertex_k" for each point k that is a vertex of the hull. Volume, centre and inertia are exact.

    Parameters
    ----------
    points : (k, 3), k >= 4 [m]; those inside of the hull do not matter
    density, mass : one of the two [kg/m^3], [kg]

    Raises
    ------
    ModelError
        For fewer than four points, points in one plane, NaN, anything not positive, or both or none of density and
        mass.
    """
    hull = convex_hull(array_of("points", points, (-1, 3)))
    m = _mass(hull.volume, density, mass)
    places = {"center": np.zeros(3)}
    places |= {f"vertex_{k}": place for k, place in zip(hull.corners, hull.vertices, strict=True)}
    shape = _surface(hull.vertices, hull.triangles)
    return _rigid(m, m / hull.volume * hull.second, places, shape, origin=hull.centre)


def Polyhedron(
    surface: Any, density: float | None = None, mass: float | None = None, *, length_unit: Any = None
) -> SpatialBody:
    """A homogeneous solid between triangles, of an STL file or given. **Its frame is moved to its mass centre**.

    ``body.origin`` is the mass centre in the coordinates given: a point x of them is x - origin in the body frame.
    Point "center". Volume, centre and inertia are exact: with V = det(a, b, c) / 6 of each triangle, integral of
    x = sum V (a + b + c) / 4 and of x x^T = sum V (sum v v^T + sum v (sum v)^T) / 20. A convex one touches as a
    :class:`ConvexHull` does, another one with its triangles. The surface must be closed; several separate shells are
    one body, and shells within others that are seen from inside are cavities.

    Parameters
    ----------
    surface : the name of an STL file, ASCII or binary; or vertices (N, 3) and triangles (T, 3) of them,
        counter-clockwise seen from outside
    density, mass : one of the two [kg/m^3], [kg]
    length_unit : of the surface: "m", "cm", "mm", "um", "in", "ft", or its number of metres; None for metres, with a
        warning where the body is larger than solids of its density are

    Raises
    ------
    ModelError
        For a file that is damaged or no STL; a surface that is open, with the hole; triangles that are turned around,
        have no area, or share an edge with more than one other; shells within each other that are no cavities;
        more than a million triangles; anything not positive, or both or none of density and mass.
    """
    corners, source, is_file = corners_of(surface, length_unit)
    solid = triangle_solid(source, corners)
    m = _mass(solid.volume, density, mass)
    if length_unit is None:
        width = 3.0 * solid.volume / solid.area
        check_rigid_size(source, solid.extent, width, m / solid.volume, from_file=is_file)
    shape = _surface(solid.vertices, solid.triangles, convex=solid.convex)
    return _rigid(m, m / solid.volume * solid.second, {"center": np.zeros(3)}, shape, origin=solid.centre)


def corners_of(surface: Any, length_unit: Any) -> tuple[FloatArray, str, bool]:
    """(T, 3, 3) corners [m] of triangles of a file or given, what to call them, and whether they are of a file."""
    unit = metres(length_unit)
    is_file = isinstance(surface, (str, os.PathLike))
    corners, source = read_stl("surface", surface) if is_file else (_corners(surface), "surface")
    with np.errstate(over="ignore"):  # what is too large then is refused
        return unit * corners, source, is_file


def _corners(surface: Any) -> FloatArray:
    """(T, 3, 3) of vertices and triangles."""
    expected = "the name of an STL file, or vertices (N, 3) and triangles (T, 3)"
    pair = sequence_of("surface", surface, expected)
    if len(pair) != 2:
        raise ModelError(f"surface: {shown(surface)} was given, expected {expected}")
    vertices = array_of("surface: vertices", pair[0], (-1, 3))
    if numbers(pair[1]) is None:
        raise ModelError(f"surface: triangles: {shown(pair[1])} was given, expected (any, 3) integers")
    try:
        triangles = triangles_of(pair[1], len(vertices))
    except ModelError as error:
        raise ModelError(f"surface: {error}") from None
    if not 0 < len(triangles) <= TRIANGLES:
        raise ModelError(f"surface: {len(triangles)} triangles were given, expected 1 to {TRIANGLES}")
    return vertices[triangles]


def _along_z(**heights: float) -> dict[str, FloatArray]:
    """The centre and points of the axis."""
    return {"center": np.zeros(3)} | {name: np.array([0.0, 0.0, z]) for name, z in heights.items()}


def _surface(vertices: FloatArray, triangles: Any, convex: bool = True) -> SurfaceShape:
    """The surface of a rigid body."""
    for array in (vertices, triangles):
        array.setflags(write=False)
    return SurfaceShape(vertices, triangles, np.zeros((len(vertices), 0, 3)), convex=convex)


def _mass(volume: float, density: float | None, mass: float | None) -> float:
    if (density is None) == (mass is None):
        raise ModelError(
            f"density, mass: {shown(density)} and {shown(mass)} were given, expected exactly one of the two"
        )
    return positive("mass", mass) if density is None else positive("density", density) * volume


def _rigid(
    mass: float, second: FloatArray, places: Mapping[str, FloatArray], shape: Shape | None, **more: Any
) -> SpatialBody:
    """The body without modes; ``second``: P0 about the origin of the frame."""
    points = {name: rigid_point(*place) for name, place in places.items()}
    return SpatialBody(mass=mass, second=0.5 * (second + second.T), points=points, shape=shape, **more)
