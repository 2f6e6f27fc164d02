"""A force or torque given as functions of time."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from lcpflex.scene.functions_of_time import Signal

__all__ = ["Effort"]


@dataclass(frozen=True, slots=True)
class Effort:
    """Force or torque at the point P of a load: its components, or one function that returns all of them."""

    kind: str  # a name in the EFFORTS of :mod:`lcpflex.dynamics.applied_forces`, and of the same in space
    value: tuple[Signal, ...] | Callable[..., Any]
