"""Arguments of joints and springs in space, kept in one form."""

from __future__ import annotations

import math
from typing import Any

from lcpflex.basics.options import keep_number_or_none
from lcpflex.errors import ModelError
from lcpflex.scene.joints.joint import unit
from lcpflex.scene.spatial.axes import axes_of, way_of

__all__ = ["keep_axes", "keep_half_turn", "keep_line", "keep_orientation"]


def keep_axes(part: Any, names: tuple[str, ...], needed: tuple[str, ...] = ()) -> None:
    """Keep directions of a part as unit vectors, what is omitted as None unless it is ``needed``."""
    owner = type(part).__name__
    for name in names:
        given = getattr(part, name)
        if given is not None:
            object.__setattr__(part, name, way_of(f"{owner}: {name}", given))
        elif name in needed:
            raise ModelError(f"{owner}: {name}: it was omitted, expected a direction (x, y, z) in a spatial scene")


def keep_line(part: Any, omitted: bool = True) -> None:
    """Keep the axis of a part as a unit vector, of two numbers in the plane and of three in space.

    omitted: whether None stands for x.
    """
    owner, in_space = type(part).__name__, part.P.in_space
    given = part.axis
    if given is None and omitted:
        given = (1.0, 0.0, 0.0) if in_space else (1.0, 0.0)
    object.__setattr__(part, "axis", way_of(f"{owner}: axis", given) if in_space else unit(owner, given))


def keep_orientation(part: Any, name: str = "orientation") -> None:
    """Keep a relative orientation as the rows of a matrix, or as None."""
    object.__setattr__(part, name, axes_of(f"{type(part).__name__}: {name}", getattr(part, name)))


def keep_half_turn(part: Any) -> None:
    """Keep the rest angle within half a turn, or as None: in space whole turns are not told apart."""
    keep_number_or_none(part, "angle", -math.pi, math.pi, label=f"{type(part).__name__}: angle")
