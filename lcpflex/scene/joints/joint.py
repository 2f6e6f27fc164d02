"""What a joint tells the compilation, and the checks that joints share."""

from __future__ import annotations

import math
from typing import Any, ClassVar, Protocol, runtime_checkable

import numpy as np
import numpy.typing as npt

from lcpflex.basics.options import keep_number_or_none
from lcpflex.bodies.body import array_of
from lcpflex.bodies.placed_point import PlacedPoint, check_pair
from lcpflex.errors import ModelError, shown
from lcpflex.scene.relative import Relative

__all__ = ["COINCIDENCE", "Joint", "across", "check_joint", "keep_angle", "refuse_foreign", "unit"]

COINCIDENCE = (Relative("component", (1.0, 0.0)), Relative("component", (0.0, 1.0)))  # r_P - r_Q = 0


@runtime_checkable
class Joint(Protocol):
    """A joint: a frozen dataclass with two points, a name, and what it prescribes of them."""

    __dataclass_fields__: ClassVar[dict[str, Any]]

    @property
    def P(self) -> PlacedPoint: ...
    @property
    def Q(self) -> PlacedPoint: ...
    @property
    def name(self) -> str: ...

    def rows(self) -> tuple[Relative, ...]:
        """The relative coordinates that are prescribed, in the order of the rows."""
        ...


def check_joint(joint: Any, plane: tuple[str, ...] = (), space: tuple[str, ...] = ()) -> bool:
    """Points on two bodies, and a name that is one; whether they are points of space.

    plane, space: arguments that have a meaning in the plane alone, and in space alone; elsewhere they must be omitted.
    """
    owner = type(joint).__name__
    check_pair(owner, joint.P, joint.Q)
    if joint.P.body == joint.Q.body:
        raise ModelError(
            f"{owner}: {joint.P.label} and {joint.Q.label} are points of the same body, expected points of two bodies"
        )
    if not isinstance(joint.name, str):
        raise ModelError(f"{owner}: name: {shown(joint.name)} was given, expected a text")
    refuse_foreign(joint, plane, space)
    return bool(joint.P.in_space)


def refuse_foreign(part: Any, plane: tuple[str, ...], space: tuple[str, ...]) -> None:
    """Raise ModelError for an argument of a joint or load that has no meaning in the scene of its points."""
    owner, where = type(part).__name__, "a spatial" if part.P.in_space else "a planar"
    for name in plane if part.P.in_space else space:
        if (given := getattr(part, name)) is not None and given is not False:
            raise ModelError(f"{owner}: {name}: {shown(given)} was given with points of {where} scene, expected none")


def keep_angle(joint: Any) -> None:
    """Keep the rest angle as a float, unless it is None."""
    keep_number_or_none(joint, "angle", -math.inf, math.inf, label=f"{type(joint).__name__}: angle")


def unit(owner: str, axis: npt.ArrayLike) -> tuple[float, float]:
    """``axis`` as a unit vector."""
    vector = array_of(f"{owner}: axis", axis, (2,))
    if not vector.any():
        raise ModelError(f"{owner}: axis: {shown(axis)} was given, expected a direction (x, y), not both 0")
    x, y = vector / np.abs(vector).max()
    length = math.hypot(x, y)
    return float(x / length), float(y / length)


def across(axis: tuple[float, float]) -> tuple[float, float]:
    """The normal of a unit vector, counter-clockwise of it."""
    return -axis[1], axis[0]
