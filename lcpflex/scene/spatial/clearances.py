"""A pin in a bore with play, across the axis and along it, in the place of a hinge: contacts declared in one call.

It is a method of :class:`lcpflex.scene.spatial.scene.SpatialScene`.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from lcpflex.basics.arguments import positive
from lcpflex.errors import ModelError, in_range, shown
from lcpflex.scene.clearances import pin_and_hole
from lcpflex.scene.spatial.axes import way_of

if TYPE_CHECKING:
    import numpy.typing as npt

    from lcpflex.bodies.placed_point import PlacedPoint
    from lcpflex.force_laws.law import Law
    from lcpflex.jit.kernel import FloatArray
    from lcpflex.scene.spatial.scene import SpatialScene

__all__ = ["revolute_with_clearance"]

COLLAR = 1.5  # radii of the hole: that of a collar, where nothing else is said


def revolute_with_clearance(
    scene: SpatialScene,
    P: PlacedPoint,
    Q: PlacedPoint,
    pin_radius: float,
    hole_radius: float,
    friction: float = 0.0,
    restitution: float = 0.0,
    tangential_restitution: float = 0.0,
    name: str | None = None,
    *,
    axis: npt.ArrayLike,
    length: float,
    axis_p: npt.ArrayLike | None = None,
    pin_length: float | None = None,
    axial_play: float | None = None,
    collar_radius: float | None = None,
    law: Law | None = None,
) -> str:
    """A hinge with play: a bore about P, a pin about Q of another body; returns the name of their contact.

    No joint is made. R and r being the radii of hole and pin, y the way from the axis of one to the end of the other,

        R - r - |y| >= 0

    at both ends of what is common to both, so that the pin moves across the bore, and tilts until it touches at both
    ends; right to the square of the tilt. Along the axis it slides freely, or between two collars on the body of Q.

    Parameters
    ----------
    P, Q
        Middles of the bore and of the pin, of two bodies of the scene, or of one and its ground.
    pin_radius, hole_radius
        r < R [m].
    friction, restitution, tangential_restitution, law
        As in :meth:`contact`, of all contacts that are made.
    name
        Of the contact of the pin with the bore; those of the collars are called name.first, name.second.
    axis, axis_p
        (3,) direction of the pin in the axes of the body of Q (world axes on the ground), and of the bore in those of
        the body of P; for the latter what coincides with ``axis`` at the start, if omitted.
    length, pin_length
        Of the bore, and of the pin, as long if omitted [m]. What the shorter has touches the longer.
    axial_play
        How far the pin moves along its axis [m]: collars on the body of Q, discs of ``collar_radius``, stand that far,
        together, from the flat faces about the ends of the bore, planes of the body of P, which go on beyond that body.
        None: nothing holds it along the axis.
    collar_radius
        More than that of the hole; 1.5 times that, if omitted.

    Raises
    ------
    ModelError
        For points that are no pair, a pin that does not fit, numbers that cannot be; collars without ``axial_play``,
        or on flexible bodies; and where what penetrates is refused, for a pin that is not in its bore at the start.
    """
    pin, size = pin_and_hole(scene, P, Q, pin_radius, hole_radius)
    long = positive("length", length)
    other = long if pin_length is None else positive("pin_length", pin_length)
    collar = _collar(axial_play, collar_radius, size)
    along = np.array(way_of("axis", axis))
    along_p = _carried_over(scene, Q.body, P.body, along) if axis_p is None else np.array(way_of("axis_p", axis_p))
    of_bore, of_pin = scene._holder(P.body), scene._holder(Q.body)
    numbers = friction, restitution, tangential_restitution
    bore = of_bore.bore(P, along_p, size, long)
    made = scene.contact(of_pin.pin(Q, along, pin, other), bore, *numbers, name, law=law)
    if collar is not None:
        play, radius = collar
        for sign, which in ((-1.0, "first"), (1.0, "second")):
            face = of_bore.plane(tuple(P.material.place + 0.5 * sign * long * along_p), sign * along_p)
            disc = of_pin.rim(tuple(Q.material.place + 0.5 * sign * (long + play) * along), along, radius)
            scene.contact(disc, face, *numbers, f"{made}.{which}", law=law)
    return made


def _collar(play: float | None, radius: float | None, hole: float) -> tuple[float, float] | None:
    """Play along the axis and radius of the collars; None where there are none."""
    if play is None:
        if radius is not None:
            raise ModelError(f"collar_radius: {shown(radius)} was given without axial_play, expected both, or neither")
        return None
    found = in_range("axial_play", play, 0.0, math.inf)
    own = COLLAR * hole if radius is None else positive("collar_radius", radius)
    if own <= hole:
        raise ModelError(f"collar_radius: {own:g} m was given, expected more than {hole:g} m, the radius of the hole")
    return found, own


def _carried_over(scene: SpatialScene, body: int, other: int, direction: FloatArray) -> FloatArray:
    """A direction of the axes of one body in those of another, at the start."""
    parts = scene.parts()
    return np.asarray(parts.rotation(other).T @ (parts.rotation(body) @ direction))
