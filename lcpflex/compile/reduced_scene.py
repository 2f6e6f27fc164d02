"""A scene with the bodies reduced that are reduced when it is compiled, each for what acts on it there."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypeVar

from lcpflex.scene.contact_rules import by_rules
from lcpflex.scene.substitution import remade

if TYPE_CHECKING:
    from lcpflex.scene.register import Start
    from lcpflex.scene.scene import Scene
    from lcpflex.scene.spatial.scene import SpatialScene

__all__ = ["reduced_scene"]


AnyScene = TypeVar("AnyScene", bound="Scene | SpatialScene")


def reduced_scene(scene: AnyScene, gives_way: bool = False, listed: bool = False) -> tuple[AnyScene, tuple[str, ...]]:
    """The scene with reduced bodies in the place of unreduced ones, and which nodes of surfaces were taken, in words.

    It is the scene itself where none is unreduced. ``gives_way``: each contact needs compliance of its own;
    ``listed``: each pair of a rule is a contact.
    """
    parts: Any = scene.parts()
    turned = parts.rotation if scene.spatial else parts.angle
    if not any(placed.order for placed in parts.placed):
        return scene, ()
    everything = (parts.placed, parts.surfaces, parts.contacts, parts.rules, tuple(parts.joints.values()))
    by_rule, rule, _ = by_rules(*everything, listed)
    contacts = {**parts.contacts, **by_rule}
    if rule is not None:
        contacts |= rule.first_contacts({placed.body for placed in parts.placed if placed.order})
    bodies: list[tuple[Any, Start]] = []
    said: list[str] = []
    for placed in parts.placed:
        assert placed.source is not None
        if placed.order is None:
            bodies.append((placed.source, placed.start))
            continue
        interfaces, taken = placed.order.interfaces(placed, parts.joints, parts.loads, contacts, turned, gives_way)
        body = placed.order.body(interfaces) if placed.order.modes else placed.source
        bodies.append((body, placed.order.start(placed.start, body)))
        said += taken
    return remade(scene, bodies), tuple(said)
