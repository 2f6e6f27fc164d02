"""Ball joint."""

from __future__ import annotations

from dataclasses import dataclass

from lcpflex.bodies.placed_point import PlacedPoint
from lcpflex.scene.spatial import axes
from lcpflex.scene.spatial.joints.joint import check_spatial_joint
from lcpflex.scene.spatial.relative import SpatialRelative

__all__ = ["Ball"]


@dataclass(frozen=True, slots=True)
class Ball:
    """P and Q coincide, r_P - r_Q = 0 (3 rows); all rotations are free. Raises ModelError for points that cannot be.

    name: of the joint, for results and messages; joint1, joint2, ... if empty.
    """

    P: PlacedPoint
    Q: PlacedPoint
    name: str = ""

    def __post_init__(self) -> None:
        check_spatial_joint(self)

    def spatial_rows(self) -> tuple[SpatialRelative, ...]:
        """The relative coordinates that are prescribed."""
        return axes.COINCIDENCE
