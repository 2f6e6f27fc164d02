"""Massless rod."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from lcpflex.basics.options import is_number, keep_number
from lcpflex.bodies.placed_point import PlacedPoint
from lcpflex.scene.functions_of_time import Motion, checked_motion
from lcpflex.scene.joints import later
from lcpflex.scene.joints.joint import check_joint
from lcpflex.scene.relative import Relative

if TYPE_CHECKING:
    from lcpflex.scene.spatial.relative import SpatialRelative

__all__ = ["Distance"]


@dataclass(frozen=True, slots=True)
class Distance:
    """Massless rod: |r_P - r_Q| = ``length`` (1 row).

    ``length`` [m] is a number > 0, a function of time (:mod:`lcpflex.scene.functions_of_time`), or the distance of the
    start configuration if omitted. Raises ModelError for points that cannot be joined or a length <= 0.

    P, Q: points of two bodies, or of a body and of the ground. name: of the joint, for results and messages;
    joint1, joint2, ... if empty.
    """

    P: PlacedPoint
    Q: PlacedPoint
    length: Motion | None = None
    name: str = ""

    def __post_init__(self) -> None:
        check_joint(self)
        if is_number(self.length):
            keep_number(self, "length", 0.0, math.inf, open_ends=True, label="Distance: length")
        elif self.length is not None:
            checked_motion("Distance: length", self.length)

    def rows(self) -> tuple[Relative, ...]:
        """The relative coordinates that are prescribed."""
        if self.length is None or isinstance(self.length, float):
            return (Relative("distance", rest=self.length),)
        return (Relative("distance", motion=self.length),)

    def spatial_rows(self) -> tuple[SpatialRelative, ...]:
        """The same in space."""
        return tuple(later.SpatialRelative("distance", rest=row.rest, motion=row.motion) for row in self.rows())
