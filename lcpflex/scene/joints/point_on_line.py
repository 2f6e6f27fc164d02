"""Slider that may turn."""

from __future__ import annotations

from dataclasses import dataclass

import numpy.typing as npt

from lcpflex.bodies.placed_point import PlacedPoint
from lcpflex.scene.joints.joint import across, check_joint, unit
from lcpflex.scene.relative import Relative

__all__ = ["PointOnLine"]


@dataclass(frozen=True, slots=True)
class PointOnLine:
    """P stays on a line through Q, n_Q.(r_P - r_Q) = 0 (1 row), and may turn.

    ``axis`` (2,) is the direction of the line, fixed in the material at Q, and n_Q its normal. Raises ModelError for
    points that cannot be joined or a zero axis.

    name: of the joint, for results and messages; joint1, joint2, ... if empty.
    """

    P: PlacedPoint
    Q: PlacedPoint
    axis: npt.ArrayLike = (1.0, 0.0)
    name: str = ""

    def __post_init__(self) -> None:
        check_joint(self)
        object.__setattr__(self, "axis", unit("PointOnLine", self.axis))

    def rows(self) -> tuple[Relative, ...]:
        """The relative coordinates that are prescribed."""
        return (Relative("along", across(unit("PointOnLine", self.axis))),)
