"""A material point of a body in a scene: what joints, loads and questions to a state refer to."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from lcpflex.errors import ModelError, shown

if TYPE_CHECKING:
    pass

__all__ = ["PlacedPoint", "check_point", "check_pair"]


@dataclass(frozen=True, slots=True, eq=False)
class PlacedPoint:
    """A material point of one body of one scene, or a place of its ground.

    Made by ``placed.point(name)``, ``placed.at(x, y)`` and ``scene.ground.at(x, y)``, in space of three numbers, not by
    hand.
    """

    scene: object  # identity of the scene
    body: int  # index of the body, -1 for the ground
    label: str  # for messages, such as "pendulum.left"
    material: Any  # MaterialPoint or SpatialPoint: place in the body frame (world axes for the ground) and mode shapes
    again: Callable[[Any], PlacedPoint] = field(repr=False)  # makes it on another body at the same place, by its name

    @property
    def in_space(self) -> bool:
        """Whether it belongs to a spatial scene."""
        return len(self.material.place) == 3


def check_point(owner: str, argument: str, value: object) -> None:
    """Raise ModelError unless ``value`` is a point of a scene."""
    if not isinstance(value, PlacedPoint):
        raise ModelError(
            f"{owner}: {argument}: {shown(value)} was given, expected a point such as body.point('left'), "
            "body.at(x, y) or scene.ground.at(x, y)"
        )


def check_pair(owner: str, P: object, Q: object) -> None:
    """Raise ModelError unless P and Q are points of one scene, not both on its ground."""
    check_point(owner, "P", P)
    check_point(owner, "Q", Q)
    assert isinstance(P, PlacedPoint)
    assert isinstance(Q, PlacedPoint)
    if P.in_space is not Q.in_space:
        plane, space = (Q, P) if P.in_space else (P, Q)
        raise ModelError(
            f"{owner}: P, Q: {plane.label} is a point of a planar scene and {space.label} of a spatial one, expected "
            "two points of the same scene"
        )
    if P.scene is not Q.scene:
        raise ModelError(f"{owner}: P, Q: {P.label} and {Q.label} were given, expected two points of the same scene")
    if P.body < 0 and Q.body < 0:
        raise ModelError(f"{owner}: {P.label} and {Q.label} are both on the ground, expected at least one on a body")
