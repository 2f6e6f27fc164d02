"""What a kind of random scene is made of."""

from __future__ import annotations

from typing import NamedTuple

from tests.property.yard import Push, Shape, Vector, Wall

__all__ = ["Layout"]


class Layout(NamedTuple):
    """Bodies, walls and loads; None: drawn as for any other scene."""

    shapes: tuple[Shape, ...]
    gravity: Vector
    walls: tuple[Wall, ...] = ()
    pushes: tuple[Push, ...] = ()
    friction: float | None = None
    restitution: float | None = None
    touch: float = 0.0  # [s] that a touch lasts, where contacts are laws
    held: bool = False  # the first body is held
    system: tuple[str, Vector] = ("", ())  # of the user's own, instead of bodies
