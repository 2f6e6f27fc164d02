"""Torque on the material at a point."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from lcpflex.basics.options import keep_flag
from lcpflex.bodies.placed_point import PlacedPoint
from lcpflex.scene.functions_of_time import Signal, checked_motion
from lcpflex.scene.joints.joint import refuse_foreign
from lcpflex.scene.loads.load import Effort, check_loaded, check_rotation, keep_components

__all__ = ["Torque"]


@dataclass(frozen=True, slots=True)
class Torque:
    """Torque [N m] on the material at P, counter-clockwise: a function of time, f(t) or f(t, state).

    In space a triple of functions of time, or a function that returns three, in world axes or, with ``follower``, in
    axes that turn with the material at P. Raises ModelError for a point on the ground or a value that is none of these.

    name: of the load, for messages.
    """

    P: PlacedPoint
    value: Signal | tuple[Signal, ...] | Callable[..., Any]
    name: str = ""
    follower: bool = field(default=False, kw_only=True)

    def __post_init__(self) -> None:
        check_loaded(self)
        keep_flag(self, "follower", label="Torque: follower")
        refuse_foreign(self, (), ("follower",))
        if self.P.in_space:
            check_rotation(self)
            if not callable(self.value):
                keep_components(self, ("Mx", "My", "Mz"))
            return
        object.__setattr__(self, "value", checked_motion("Torque: value", self.value))

    def form(self) -> Effort:
        """For the compilation."""
        return Effort("torque", (self.value,))  # type: ignore[arg-type]  # in the plane, one component

    def spatial_forms(self) -> tuple[Effort, ...]:
        """The same in space."""
        return (Effort("torque follower" if self.follower else "torque", self.value),)  # type: ignore[arg-type]
