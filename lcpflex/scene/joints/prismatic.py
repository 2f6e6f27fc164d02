"""Slider that does not turn."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy.typing as npt

from lcpflex.bodies.placed_point import PlacedPoint
from lcpflex.scene.joints import later
from lcpflex.scene.joints.joint import across, check_joint, keep_angle
from lcpflex.scene.relative import Relative

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

    from lcpflex.scene.spatial.relative import SpatialRelative

__all__ = ["Prismatic"]


@dataclass(frozen=True, slots=True)
class Prismatic:
    """P slides along a line through Q without turning (2 rows): n_Q.(r_P - r_Q) = 0, angle_P - angle_Q = ``angle``.

    ``axis`` (2,) is the direction of the line, fixed in the material at Q, and n_Q its normal; (1, 0) if omitted.
    ``angle`` [rad] is the
    relative angle of the start configuration if omitted. Raises ModelError for points that cannot be joined, a
    zero axis, numbers that are not finite.

    In space (5 rows) ``axis`` (3,) is (1, 0, 0) if omitted, and the rotation A_Q^T A_P = ``orientation`` is kept, as by
    :class:`~lcpflex.scene.joints.weld.Weld`.

    name: of the joint, for results and messages; joint1, joint2, ... if empty.
    """

    P: PlacedPoint
    Q: PlacedPoint
    axis: npt.ArrayLike | None = None
    angle: float | None = None
    name: str = ""
    orientation: Rotation | npt.ArrayLike | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        in_space = check_joint(self, plane=("angle",), space=("orientation",))
        later.keep_line(self)
        keep_angle(self)
        if in_space:
            later.keep_orientation(self)
            later.axes.check_turns(self, self.spatial_rows())

    def rows(self) -> tuple[Relative, ...]:
        """The relative coordinates that are prescribed."""
        return Relative("along", across(self.axis)), Relative("angle", rest=self.angle)  # type: ignore[arg-type]  # a unit vector

    def spatial_rows(self) -> tuple[SpatialRelative, ...]:
        """The same in space."""
        line = later.axes.off_line(self.axis)  # type: ignore[arg-type]  # a unit vector
        return *later.axes.locked(self.orientation), *line  # type: ignore[arg-type]  # a matrix or None
