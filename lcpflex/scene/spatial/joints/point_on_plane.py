"""Point that stays in a plane."""

from __future__ import annotations

from dataclasses import dataclass

import numpy.typing as npt

from lcpflex.bodies.placed_point import PlacedPoint
from lcpflex.scene.spatial.joints.joint import check_spatial_joint
from lcpflex.scene.spatial.relative import SpatialRelative

__all__ = ["PointOnPlane"]


@dataclass(frozen=True, slots=True)
class PointOnPlane:
    """P stays in a plane through Q, axis_Q.(r_P - r_Q) = 0 (1 row); all rotations are free.

    ``axis`` (3,) is the normal of the plane, fixed in the material at Q. Raises ModelError for points that cannot be
    joined or a zero normal.

    name: of the joint, for results and messages; joint1, joint2, ... if empty.
    """

    P: PlacedPoint
    Q: PlacedPoint
    axis: npt.ArrayLike
    name: str = ""

    def __post_init__(self) -> None:
        check_spatial_joint(self, ("axis",), needed=("axis",))

    def spatial_rows(self) -> tuple[SpatialRelative, ...]:
        """The relative coordinates that are prescribed."""
        return (SpatialRelative("along", self.axis),)  # type: ignore[arg-type]  # a unit vector
