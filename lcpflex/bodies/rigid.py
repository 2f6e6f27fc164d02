"""Rigid bodies: from mass properties, or from a shape and its density.

Each function gives a :class:`~lcpflex.bodies.body.Body` without modes. Every place of the plane may be taken as
a material point of it: a rigid body has no known boundary but the one that is used as a contact surface.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
import numpy.typing as npt

from lcpflex.basics.arguments import positive
from lcpflex.bodies.body import Body, Chain, MaterialPoint, Outline, Round, array_of, named
from lcpflex.errors import ModelError, shown
from lcpflex.jit.kernel import FloatArray

__all__ = ["Box", "Disc", "Polygon", "RigidBody"]


def RigidBody(
    mass: float,
    inertia: float,
    center: Sequence[float] = (0.0, 0.0),
    points: Mapping[str, Sequence[float]] | None = None,
) -> Body:
    """A rigid body from its mass properties. It has named points and no surface of its own.

    Parameters
    ----------
    mass : [kg]
    inertia : about the centre of mass [kg m^2]
    center : (x, y) place of the centre of mass in the body frame [m]; the frame is the user's
    points : name -> (x, y) in the body frame [m]; "center" is always there

    Raises
    ------
    ModelError
        For mass <= 0, inertia <= 0, NaN, or places that are not two numbers.
    """
    m = positive("mass", mass)
    about_center = positive("inertia", inertia)
    places = {"center": array_of("center", center, (2,))}
    for name, place in named("points", {} if points is None else points).items():
        places[name] = array_of(f"points[{name!r}]", place, (2,))
    return _rigid(m, about_center, places["center"], places, {})


def Disc(radius: float, density: float | None = None, mass: float | None = None, thickness: float = 1.0) -> Body:
    """A homogeneous disc. Frame origin and point "center": its centre. Surface "outline": its circle.

    m = rho t pi r^2, inertia m r^2 / 2.

    Parameters
    ----------
    radius : r [m]
    density, mass : one of the two [kg/m^3], [kg]
    thickness : t, out of the plane [m]; used with the density

    Raises
    ------
    ModelError
        For anything not positive and finite, or both or none of density and mass.
    """
    r = positive("radius", radius)
    m = _mass(math.pi * r * r, density, mass, thickness)
    center = _point(0.0, 0.0)
    return _rigid(m, 0.5 * m * r * r, center.place, {"center": center.place}, {"outline": Round(center, r)})


def Box(
    width: float, height: float, density: float | None = None, mass: float | None = None, thickness: float = 1.0
) -> Body:
    """A homogeneous rectangle. Frame origin: its centre.

    Points "center", the middles of the sides "left", "right", "bottom", "top", and the corners "bottom_left",
    "bottom_right", "top_right", "top_left". Surfaces "outline" (closed) and the sides "bottom", "right", "top", "left".

    m = rho t w h, inertia m (w^2 + h^2) / 12.

    Parameters
    ----------
    width, height : w along x and h along y [m]
    density, mass : one of the two [kg/m^3], [kg]
    thickness : t, out of the plane [m]; used with the density

    Raises
    ------
    ModelError
        For anything not positive and finite, or both or none of density and mass.
    """
    w = positive("width", width)
    h = positive("height", height)
    m = _mass(w * h, density, mass, thickness)
    corners = {
        "bottom_left": (-w / 2, -h / 2),
        "bottom_right": (w / 2, -h / 2),
        "top_right": (w / 2, h / 2),
        "top_left": (-w / 2, h / 2),
    }
    middles = {"left": (-w / 2, 0.0), "right": (w / 2, 0.0), "bottom": (0.0, -h / 2), "top": (0.0, h / 2)}
    places = {name: np.array(at) for name, at in {"center": (0.0, 0.0), **middles, **corners}.items()}
    ring = [_point(*at) for at in corners.values()]
    surfaces = _sides(ring, ("bottom", "right", "top", "left"))
    return _rigid(m, m * (w * w + h * h) / 12.0, places["center"], places, surfaces)


def Polygon(
    vertices: npt.ArrayLike, density: float | None = None, mass: float | None = None, thickness: float = 1.0
) -> Body:
    """A homogeneous convex polygon. The frame is that of the vertices.

    Points "center" (centre of mass) and "vertex_0", "vertex_1", ... in the order given. Surfaces "outline" (closed)
    and "side_0", "side_1", ...: side k joins vertex k and the vertex given after it.

    Area, centre and inertia are exact: Green's formulas, sums over the sides.

    Parameters
    ----------
    vertices : (k, 2) corners in either sense of rotation [m]; k >= 3
    density, mass : one of the two [kg/m^3], [kg]
    thickness : out of the plane [m]; used with the density

    Raises
    ------
    ModelError
        For fewer than three vertices, coincident ones, no area, a polygon that is not convex, NaN, or
        anything not positive.
    """
    given = array_of("vertices", vertices, (-1, 2))
    if len(given) < 3:
        raise ModelError(f"vertices: {len(given)} were given, expected at least 3")
    area, center, second = _green(given)
    names = [f"vertex_{k}" for k in range(len(given))]
    clockwise = area < 0.0
    _check_convex(given[::-1] if clockwise else given)
    m = _mass(abs(area), density, mass, thickness)
    places = {"center": center, **dict(zip(names, given, strict=True))}
    ring = [_point(*at) for at in given]
    surfaces = _sides(ring, [f"side_{k}" for k in range(len(ring))], clockwise)
    return _rigid(m, m * second, center, places, surfaces)


def _sides(ring: Sequence[MaterialPoint], names: Sequence[str], clockwise: bool = False) -> dict[str, Outline]:
    """The outline through the corners, and its sides by name, each from a corner to the one given after it."""
    way = -1 if clockwise else 1
    sides = {name: ring[k : k + 2] for k, name in enumerate(names[:-1])} | {names[-1]: [ring[-1], ring[0]]}
    outline: dict[str, Outline] = {"outline": Chain(tuple(ring[::way]), closed=True)}
    return outline | {name: Chain(tuple(side[::way]), closed=False) for name, side in sides.items()}


def _green(vertices: FloatArray) -> tuple[float, FloatArray, float]:
    """Signed area, centre, and second moment about the centre divided by the area."""
    origin = vertices.mean(axis=0)  # sums about a near point lose no digits
    p = vertices - origin
    q = np.roll(p, -1, axis=0)
    cross = p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0]
    area = 0.5 * float(cross.sum())
    size = float(np.ptp(vertices, axis=0).max())
    if not abs(area) > 1e-12 * size * size:
        raise ModelError(f"vertices: they enclose the area {shown(area)}, expected a polygon with an area")
    center = ((p + q) * cross[:, None]).sum(axis=0) / (6.0 * area)
    squares = (p * p + p * q + q * q).sum(axis=1)
    second = float((squares * cross).sum()) / (12.0 * area) - float(center @ center)
    return area, origin + center, second


def _check_convex(ring: FloatArray) -> None:
    """The counter-clockwise ring must turn left at every vertex, and only once around."""
    size = float(np.ptp(ring, axis=0).max())
    side = np.roll(ring, -1, axis=0) - ring
    length = np.hypot(side[:, 0], side[:, 1])
    at = [(float(x), float(y)) for x, y in ring]
    if not length.min() > 1e-12 * size:
        raise ModelError(f"vertices: two coincide at {at[int(length.argmin())]}, expected distinct ones")
    before = np.roll(side, 1, axis=0)
    turn = np.arctan2(before[:, 0] * side[:, 1] - before[:, 1] * side[:, 0], (before * side).sum(axis=1))
    if turn.min() < -1e-9:
        raise ModelError(
            f"vertices: the one at {at[int(turn.argmin())]} is re-entrant, expected a convex polygon "
            f"(split it and weld the parts)"
        )
    if turn.sum() > 3.0 * math.pi:
        raise ModelError("vertices: the sides cross each other, expected a convex polygon")


def _mass(area: float, density: float | None, mass: float | None, thickness: float) -> float:
    depth = positive("thickness", thickness)
    if (density is None) == (mass is None):
        raise ModelError(
            f"density, mass: {shown(density)} and {shown(mass)} were given, expected exactly one of the two"
        )
    if density is None:
        return positive("mass", mass)
    return positive("density", density) * area * depth


def _point(x: float, y: float) -> MaterialPoint:
    """A place of a rigid body: no shapes."""
    return MaterialPoint(array_of("x, y", (x, y), (2,)), np.zeros((0, 2)), np.zeros(0))


def _rigid(
    mass: float, inertia: float, center: FloatArray, places: Mapping[str, FloatArray], surfaces: Mapping[str, Outline]
) -> Body:
    """The body without modes: I0 = inertia about the centre + m |centre|^2."""
    none = np.zeros(0)
    return Body(
        mass=mass,
        inertia=inertia + mass * float(center @ center),
        moment=mass * center,
        S=np.zeros((0, 2)),
        a=none,
        c=none,
        stiffness=none,
        damping=none,
        coupling=None,
        cross_damping=None,
        points={name: _point(*place) for name, place in places.items()},
        surfaces=dict(surfaces),
        locate=_point,
    )
