"""Force at a point."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from lcpflex.basics.arguments import sequence_of
from lcpflex.basics.options import keep_flag
from lcpflex.bodies.placed_point import PlacedPoint
from lcpflex.errors import ModelError, shown
from lcpflex.scene.functions_of_time import Signal, checked_motion
from lcpflex.scene.loads.load import Effort, check_loaded

__all__ = ["Force"]


@dataclass(frozen=True, slots=True)
class Force:
    """Force [N] at P, in world axes or, with ``follower``, in axes that turn with the material at P.

    ``value`` is a pair of functions of time, one for each component, or one Python function f(t) or f(t, state)
    that returns both. Raises ModelError for a point on the ground or a value that is none of these.

    name: of the load, for messages.
    """

    P: PlacedPoint
    value: tuple[Signal, Signal] | Callable[..., Any]
    follower: bool = False
    name: str = ""

    def __post_init__(self) -> None:
        check_loaded(self)
        keep_flag(self, "follower", label="Force: follower")
        if callable(self.value):
            return
        pair = sequence_of("Force: value", self.value, "a pair (fx, fy) or a Python function of the time")
        if len(pair) != 2:
            raise ModelError(
                f"Force: value: {shown(self.value)} was given, "
                f"expected a pair (fx, fy) or a Python function of the time"
            )
        x, y = pair
        both = (checked_motion("Force: value[0]", x), checked_motion("Force: value[1]", y))
        object.__setattr__(self, "value", both)

    def form(self) -> Effort:
        """For the compilation."""
        return Effort("follower" if self.follower else "force", self.value)
