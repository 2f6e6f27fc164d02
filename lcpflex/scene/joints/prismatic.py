"""Slider that does not turn."""

from __future__ import annotations

from dataclasses import dataclass

import numpy.typing as npt

from lcpflex.bodies.placed_point import PlacedPoint
from lcpflex.scene.joints.joint import across, check_joint, keep_angle, unit
from lcpflex.scene.relative import Relative

__all__ = ["Prismatic"]


@dataclass(frozen=True, slots=True)
class Prismatic:
    """P slides along a line through Q without turning (2 rows): n_Q.(r_P - r_Q) = 0, angle_P - angle_Q = ``angle``.

    ``axis`` (2,) is the direction of the line, fixed in the material at Q, and n_Q its normal. ``angle`` [rad] is the
    relative angle of the start configuration if omitted. Raises ModelError for points that cannot be joined, a
    zero axis, numbers that are not finite.

    name: of the joint, for results and messages; joint1, joint2, ... if empty.
    """

    P: PlacedPoint
    Q: PlacedPoint
    axis: npt.ArrayLike = (1.0, 0.0)
    angle: float | None = None
    name: str = ""

    def __post_init__(self) -> None:
        check_joint(self)
        keep_angle(self)
        object.__setattr__(self, "axis", unit("Prismatic", self.axis))

    def rows(self) -> tuple[Relative, ...]:
        """The relative coordinates that are prescribed."""
        return Relative("along", across(unit("Prismatic", self.axis))), Relative("angle", rest=self.angle)
