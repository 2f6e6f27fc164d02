"""Slider that may turn."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy.typing as npt

from lcpflex.bodies.placed_point import PlacedPoint
from lcpflex.scene.joints import later
from lcpflex.scene.joints.joint import across, check_joint
from lcpflex.scene.relative import Relative

if TYPE_CHECKING:
    from lcpflex.scene.spatial.relative import SpatialRelative

__all__ = ["PointOnLine"]


@dataclass(frozen=True, slots=True)
class PointOnLine:
    """P stays on a line through Q, n_Q.(r_P - r_Q) = 0 (1 row), and may turn.

    ``axis`` (2,) is the direction of the line, fixed in the material at Q, and n_Q its normal; (1, 0) if omitted.
    Raises ModelError for points that cannot be joined or a zero axis. In space (2 rows) ``axis`` is (3,), (1, 0, 0) if
    omitted.

    name: of the joint, for results and messages; joint1, joint2, ... if empty.
    """

    P: PlacedPoint
    Q: PlacedPoint
    axis: npt.ArrayLike | None = None
    name: str = ""

    def __post_init__(self) -> None:
        in_space = check_joint(self)
        later.keep_line(self)
        if in_space:
            later.axes.check_turns(self, self.spatial_rows())

    def rows(self) -> tuple[Relative, ...]:
        """The relative coordinates that are prescribed."""
        return (Relative("along", across(self.axis)),)  # type: ignore[arg-type]  # a unit vector

    def spatial_rows(self) -> tuple[SpatialRelative, ...]:
        """The same in space."""
        return later.axes.off_line(self.axis)  # type: ignore[arg-type]  # a unit vector
