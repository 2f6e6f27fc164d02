"""Contacts with play, declared in one call: a pin in a slot, a pin in a hole in the place of a revolute joint.

They are methods of :class:`lcpflex.scene.scene.Scene`.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from lcpflex.basics.arguments import positive, text
from lcpflex.bodies.placed_point import check_pair
from lcpflex.bodies.surface import Kind
from lcpflex.errors import ModelError, shown
from lcpflex.model.planar import N_RIGID
from lcpflex.scene.placed_surface import PlacedSurface
from lcpflex.scene.slots import Slot, SlotParts

if TYPE_CHECKING:
    from lcpflex.bodies.body import MaterialPoint
    from lcpflex.bodies.placed_point import PlacedPoint
    from lcpflex.force_laws.law import Law
    from lcpflex.jit.kernel import FloatArray
    from lcpflex.scene.register import Register
    from lcpflex.scene.scene import Scene

__all__ = ["contact_slot", "pin_and_hole", "revolute_with_clearance"]

ROUNDING = 1e-12  # relative


def contact_slot(
    scene: Scene,
    pin: PlacedSurface,
    slot: Slot,
    friction: float = 0.0,
    restitution: float = 0.0,
    tangential_restitution: float = 0.0,
    name: str | None = None,
    *,
    law: Law | SlotParts[Law | None] | None = None,
) -> SlotParts[str]:
    """Let ``pin``, a disc of another body, run in ``slot``; returns the names of the four contacts.

    They are called name.inner, name.outer, name.first and name.last after the parts of the slot (slot1, slot2, ...
    for a name if omitted), and have the same friction and restitution, as in
    :meth:`lcpflex.scene.scene.Scene.contact`.

    ``law``: a continuous contact force, of all parts or ``SlotParts(inner=..., outer=..., first=..., last=...)``,
    as their radii differ. Where the pin goes over the seam between a track and an end, one contact ends as the
    other begins: gap and normal go on, but the force does so only if both have the same law.

    tangential_restitution: e_T in [0, 1].

    Raises
    ------
    ModelError
        For a pin that is no disc, that does not fit (its radius must be less than width / 2), or whose centre is
        outside of the slot at the start, and as in :meth:`lcpflex.scene.scene.Scene.contact`.
    """
    if not isinstance(slot, Slot):
        raise ModelError(f"slot: {shown(slot)} was given, expected one made by body.curved_slot or body.straight_slot")
    if not isinstance(pin, PlacedSurface) or pin.shape.kind is not Kind.CIRCLE:
        raise ModelError(f"pin: {shown(pin)} was given, expected a disc such as body.circle((0, 0), 0.01)")
    if pin.scene is not scene or slot.inner.scene is not scene:
        raise ModelError(f"pin: {shown(pin)} and a slot were given, expected both to be parts of this scene")
    _check_fit("pin", pin.shape.radius, 0.5 * slot.width, "half the width of the slot")
    stem = _stem("slot", name, scene)
    outside = slot.outside(_seen(scene, pin.body, pin.shape.points[0], slot.inner.body))
    if outside > 0.0:
        raise ModelError(
            f"pin: the centre of {pin.label!r} is {outside:.6g} m outside of the slot at the start, expected in it"
        )
    numbers = friction, restitution, tangential_restitution
    laws = law if isinstance(law, SlotParts) else SlotParts(law, law, law, law)
    return SlotParts(
        *(
            scene.contact(pin, part, *numbers, f"{stem}.{which}", law=own)
            for part, which, own in zip(slot.parts, SlotParts._fields, laws, strict=True)
        )
    )


def revolute_with_clearance(
    scene: Scene,
    P: PlacedPoint,
    Q: PlacedPoint,
    pin_radius: float,
    hole_radius: float,
    friction: float = 0.0,
    restitution: float = 0.0,
    tangential_restitution: float = 0.0,
    name: str | None = None,
    *,
    law: Law | None = None,
) -> str:
    """A revolute joint with play: a hole about P, a pin about Q of another body; returns the name of the contact.

    No joint is made: |P - Q| <= hole_radius - pin_radius [m] is kept by the contact alone. ``law``: a continuous
    contact force; the rest as in :meth:`lcpflex.scene.scene.Scene.contact`.

    friction, restitution, tangential_restitution: as in :meth:`lcpflex.scene.scene.Scene.contact`.

    Raises
    ------
    ModelError
        For pin_radius >= hole_radius, and for a start with the centre of the pin farther from P than the play.
    """
    pin, size = pin_and_hole(scene, P, Q, pin_radius, hole_radius)
    apart = float(np.hypot(*(_world(scene, Q.body, Q.material) - _world(scene, P.body, P.material))))
    if apart > (size - pin) * (1.0 + ROUNDING) + ROUNDING * size:
        raise ModelError(
            f"Q: {Q.label} is {apart:.6g} m from {P.label} at the start, expected at most the play of "
            f"{size - pin:.6g} m"
        )
    return scene.contact(
        scene._holder(Q.body).circle(Q, pin),
        scene._holder(P.body).hole(P, size),
        friction,
        restitution,
        tangential_restitution,
        name,
        law=law,
    )


def pin_and_hole(
    scene: Register, P: PlacedPoint, Q: PlacedPoint, pin_radius: float, hole_radius: float
) -> tuple[float, float]:
    """Radii of a pin about Q and of the hole about P [m]. Raises ModelError for no pair, and for a thick pin."""
    check_pair("revolute_with_clearance", P, Q)
    if P.scene is not scene or P.body == Q.body:
        raise ModelError(
            f"revolute_with_clearance: {P.label} and {Q.label} were given, expected points of two bodies of this scene"
        )
    size, pin = positive("hole_radius", hole_radius), positive("pin_radius", pin_radius)
    _check_fit("pin_radius", pin, size, "the radius of the hole")
    return pin, size


def _check_fit(argument: str, pin: float, room: float, what: str) -> None:
    if pin >= room:
        raise ModelError(f"{argument}: a radius of {pin:g} m was given, expected less than {room:g} m, {what}")


def _stem(kind: str, name: str | None, scene: Scene) -> str:
    """``name``, or the first free of kind1, kind2, ..."""
    if name is not None:
        return text("name", name)
    taken = {contact.rsplit(".", 1)[0] for contact in scene.parts().contacts}
    number = 1
    while f"{kind}{number}" in taken:
        number += 1
    return f"{kind}{number}"


def _world(scene: Scene, body: int, point: MaterialPoint) -> FloatArray:
    """(2,) where a material point is at the start."""
    q, turn = _frame(scene, body)
    return q[:2] + turn @ (point.place + q[N_RIGID:] @ point.phi)


def _seen(scene: Scene, body: int, point: MaterialPoint, other: int) -> FloatArray:
    """(2,) where a material point is at the start, seen from the frame of another body."""
    q, turn = _frame(scene, other)
    return np.asarray(turn.T @ (_world(scene, body, point) - q[:2]))


def _frame(scene: Scene, body: int) -> tuple[FloatArray, FloatArray]:
    """Initial configuration of a body, and the turn of its frame."""
    q = np.zeros(N_RIGID) if body < 0 else scene._holder(body).start[0]
    cos, sin = math.cos(q[2]), math.sin(q[2])
    return q, np.array([[cos, -sin], [sin, cos]])
