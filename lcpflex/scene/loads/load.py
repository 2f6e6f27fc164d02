"""What a load tells the compilation: a coordinate that resists, or a force or torque given as functions of time."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar, Protocol, runtime_checkable

from lcpflex.basics.arguments import sequence_of
from lcpflex.basics.options import keep_number, keep_number_or_none
from lcpflex.bodies.placed_point import PlacedPoint, check_pair, check_point
from lcpflex.errors import ModelError, shown
from lcpflex.scene.functions_of_time import checked_motion
from lcpflex.scene.loads.effort import Effort
from lcpflex.scene.relative import Relative

__all__ = ["Effort", "Load", "Resistance", "check_loaded", "check_rotation", "check_spring", "keep_components"]


@dataclass(frozen=True, slots=True)
class Resistance:
    """Force -k (c - rest) - d cdot along a relative coordinate c of the points P and Q of a load."""

    coordinate: Relative
    stiffness: float  # k [N/m] or [N m/rad]
    damping: float  # d [N s/m] or [N m s/rad]


@runtime_checkable
class Load(Protocol):
    """A load: a frozen dataclass with a point P, for a :class:`Resistance` also Q, for an :class:`Effort` a name."""

    __dataclass_fields__: ClassVar[dict[str, Any]]

    @property
    def P(self) -> PlacedPoint: ...

    def form(self) -> Resistance | Effort:
        """For the compilation."""
        ...


def check_spring(spring: Any, rest: str) -> None:
    """Points, coefficients >= 0 and the rest length or angle."""
    owner = type(spring).__name__
    check_pair(owner, spring.P, spring.Q)
    keep_number(spring, "stiffness", 0.0, math.inf, label=f"{owner}: stiffness")
    keep_number(spring, "damping", 0.0, math.inf, label=f"{owner}: damping")
    keep_number_or_none(spring, rest, 0.0 if rest == "length" else -math.inf, math.inf, label=f"{owner}: {rest}")


def check_loaded(load: Any) -> None:
    """A point on a body."""
    owner = type(load).__name__
    check_point(owner, "P", load.P)
    if not isinstance(load.name, str):
        raise ModelError(f"{owner}: name: {shown(load.name)} was given, expected a text")
    if load.P.body < 0:
        raise ModelError(f"{owner}: P: {load.P.label} was given, expected a point of a body: the ground does not move")


def check_rotation(load: Any) -> None:
    """A point of space whose rotation is known, or any of the plane."""
    if load.P.in_space and not load.P.material.turns:
        raise ModelError(
            f"{type(load).__name__}: P: {load.P.label} was given, whose nodes lie on one line and tell no rotation "
            "about it, expected nodes that span a surface"
        )


def keep_components(load: Any, names: tuple[str, ...]) -> None:
    """Keep the value of a force or torque as a tuple of functions of time, one for each of ``names``."""
    owner, count = type(load).__name__, {2: "a pair", 3: "a triple"}[len(names)]
    expected = f"{count} ({', '.join(names)}) or a Python function of the time"
    parts = sequence_of(f"{owner}: value", load.value, expected)
    if len(parts) != len(names):
        raise ModelError(f"{owner}: value: {shown(load.value)} was given, expected {expected}")
    kept = tuple(checked_motion(f"{owner}: value[{k}]", part) for k, part in enumerate(parts))
    object.__setattr__(load, "value", kept)
