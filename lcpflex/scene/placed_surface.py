"""Surfaces of the bodies and of the ground of a scene."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from lcpflex.bodies.body import MaterialPoint
from lcpflex.errors import ModelError, shown

__all__ = ["PlacedSurface", "check_own"]


@dataclass(frozen=True, slots=True, eq=False)
class PlacedSurface:
    """A surface of one body or of the ground of one scene, made by the methods of :class:`Placed`."""

    scene: object = field(repr=False)  # identity of the scene
    body: int  # index of the body, -1 for the ground
    label: str  # unique in the scene, such as "pendulum.outline"
    shape: Any = field(repr=False)  # a Surface, or a SpatialSurface
    again: Callable[[Any], PlacedSurface] = field(repr=False)  # makes it on another body in the place of this one
    disc: tuple[MaterialPoint, float] | None = field(default=None, repr=False)  # centre and radius, to be drawn


def check_own(scene: object, argument: str, part: Any) -> None:
    """Raise ModelError for a point, surface or body of another scene."""
    if part.scene is not scene:
        raise ModelError(f"{argument}: {shown(part)} was given, expected a part of this scene, not of another one")
