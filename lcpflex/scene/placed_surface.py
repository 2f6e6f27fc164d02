"""Surfaces of the bodies and of the ground of a scene."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from lcpflex.bodies import surface as shapes
from lcpflex.bodies.body import MaterialPoint
from lcpflex.bodies.surface import Surface
from lcpflex.errors import ModelError, shown

if TYPE_CHECKING:
    from lcpflex.scene.handles import Placed

__all__ = ["PlacedSurface", "can_touch", "check_own", "can_be_node_side", "listed"]


@dataclass(frozen=True, slots=True, eq=False)
class PlacedSurface:
    """A surface of one body or of the ground of one scene, made by the methods of :class:`Placed`."""

    scene: object = field(repr=False)  # identity of the scene
    body: int  # index of the body, -1 for the ground
    label: str  # unique in the scene, such as "pendulum.outline"
    shape: Surface = field(repr=False)
    again: Callable[[Placed], PlacedSurface] = field(repr=False)  # makes it on another body in the place of this one
    disc: tuple[MaterialPoint, float] | None = field(default=None, repr=False)  # centre and radius, to be drawn


def can_touch(a: PlacedSurface, b: PlacedSurface) -> bool:
    """Whether there is a contact between surfaces of these kinds: a node, disc, solid arc or chain is one of them."""
    return shapes.can_touch(a.shape, b.shape)


def can_be_node_side(node_side: PlacedSurface, other: PlacedSurface) -> bool:
    """Whether ``node_side`` has material points that may touch others, and ``other`` something to be touched."""
    return shapes.can_be_node_side(node_side.shape, other.shape)


def listed(names: Sequence[str]) -> str:
    """Names for a message."""
    return ", ".join(repr(name) for name in names) if names else "(there are none)"


def check_own(scene: object, argument: str, part: Any) -> None:
    """Raise ModelError for a point, surface or body of another scene."""
    if part.scene is not scene:
        raise ModelError(f"{argument}: {shown(part)} was given, expected a part of this scene, not of another one")
