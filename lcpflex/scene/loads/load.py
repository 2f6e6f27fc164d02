"""What a load tells the compilation: a coordinate that resists, or a force or torque given as functions of time."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar, Protocol, runtime_checkable

from lcpflex.basics.options import keep_number, keep_number_or_none
from lcpflex.bodies.placed_point import PlacedPoint, check_pair, check_point
from lcpflex.errors import ModelError, shown
from lcpflex.scene.functions_of_time import Signal
from lcpflex.scene.relative import Relative

__all__ = ["Effort", "Load", "Resistance", "check_loaded", "check_spring"]


@dataclass(frozen=True, slots=True)
class Resistance:
    """Force -k (c - rest) - d cdot along a relative coordinate c of the points P and Q of a load."""

    coordinate: Relative
    stiffness: float  # k [N/m] or [N m/rad]
    damping: float  # d [N s/m] or [N m s/rad]


@dataclass(frozen=True, slots=True)
class Effort:
    """Force or torque at the point P of a load: its components, or one function that returns both."""

    kind: str  # a name in :data:`lcpflex.dynamics.applied_forces.EFFORTS`
    value: tuple[Signal, ...] | Callable[..., Any]


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
