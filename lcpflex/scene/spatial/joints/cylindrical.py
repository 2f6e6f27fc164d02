"""Slider that may turn about its line."""

from __future__ import annotations

from dataclasses import dataclass

import numpy.typing as npt

from lcpflex.bodies.placed_point import PlacedPoint
from lcpflex.scene.spatial import axes
from lcpflex.scene.spatial.joints.joint import check_spatial_joint
from lcpflex.scene.spatial.relative import SpatialRelative

__all__ = ["Cylindrical"]


@dataclass(frozen=True, slots=True)
class Cylindrical:
    """P slides along a line through Q and turns about it (4 rows): two axes stay parallel, and P on the one of Q.

    ``axis`` (3,) is the direction of the line, fixed in the material at Q, and ``axis_p`` (3,) the one at P that stays
    parallel to it; what coincides with it at the start if omitted. Raises ModelError for points that cannot be joined,
    zero axes, and axes that point opposite ways at the start.

    name: of the joint, for results and messages; joint1, joint2, ... if empty.
    """

    P: PlacedPoint
    Q: PlacedPoint
    axis: npt.ArrayLike
    axis_p: npt.ArrayLike | None = None
    name: str = ""

    def __post_init__(self) -> None:
        check_spatial_joint(self, ("axis", "axis_p"), needed=("axis",))

    def spatial_rows(self) -> tuple[SpatialRelative, ...]:
        """The relative coordinates that are prescribed."""
        held = axes.parallel(self.axis, self.axis_p)  # type: ignore[arg-type]  # unit vectors
        return *held, *axes.off_line(self.axis)  # type: ignore[arg-type]
