"""Force at a point."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from lcpflex.basics.options import keep_flag
from lcpflex.bodies.placed_point import PlacedPoint
from lcpflex.scene.functions_of_time import Signal
from lcpflex.scene.loads.load import Effort, check_loaded, check_rotation, keep_components

__all__ = ["Force"]


@dataclass(frozen=True, slots=True)
class Force:
    """Force [N] at P, in world axes or, with ``follower``, in axes that turn with the material at P.

    ``value`` is a pair of functions of time, one for each component, or one Python function f(t) or f(t, state)
    that returns both; in space it is a triple, or a function that returns three. Raises ModelError for a point on the
    ground or a value that is none of these.

    name: of the load, for messages.
    """

    P: PlacedPoint
    value: tuple[Signal, ...] | Callable[..., Any]
    follower: bool = False
    name: str = ""

    def __post_init__(self) -> None:
        check_loaded(self)
        keep_flag(self, "follower", label="Force: follower")
        if self.follower:
            check_rotation(self)
        if not callable(self.value):
            keep_components(self, ("fx", "fy", "fz")[: 3 if self.P.in_space else 2])

    def form(self) -> Effort:
        """For the compilation."""
        return Effort("follower" if self.follower else "force", self.value)

    def spatial_forms(self) -> tuple[Effort, ...]:
        """The same in space."""
        return (self.form(),)
