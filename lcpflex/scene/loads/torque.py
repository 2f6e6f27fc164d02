"""Torque on the material at a point."""

from __future__ import annotations

from dataclasses import dataclass

from lcpflex.bodies.placed_point import PlacedPoint
from lcpflex.scene.functions_of_time import Signal, checked_motion
from lcpflex.scene.loads.load import Effort, check_loaded

__all__ = ["Torque"]


@dataclass(frozen=True, slots=True)
class Torque:
    """Torque [N m] on the material at P, counter-clockwise: a function of time, f(t) or f(t, state).

    Raises ModelError for a point on the ground or a value that is none of these.

    name: of the load, for messages.
    """

    P: PlacedPoint
    value: Signal
    name: str = ""

    def __post_init__(self) -> None:
        check_loaded(self)
        object.__setattr__(self, "value", checked_motion("Torque: value", self.value))

    def form(self) -> Effort:
        """For the compilation."""
        return Effort("torque", (self.value,))
