"""Universal joint."""

from __future__ import annotations

from dataclasses import dataclass

import numpy.typing as npt

from lcpflex.bodies.placed_point import PlacedPoint
from lcpflex.scene.spatial import axes
from lcpflex.scene.spatial.joints.joint import check_spatial_joint
from lcpflex.scene.spatial.relative import SpatialRelative

__all__ = ["Universal"]


@dataclass(frozen=True, slots=True)
class Universal:
    """Cardan joint: P and Q coincide, and two axes stay at right angles, axis_P.axis_Q = 0 (4 rows).

    ``axis_p`` (3,) is the axis of the cross in the body of P, in the axes of that body, and ``axis`` (3,) the one in
    the body of Q (world axes on the ground). Raises ModelError for points that cannot be joined, zero axes, and axes
    more than 30 degrees off right angles at the start.

    name: of the joint, for results and messages; joint1, joint2, ... if empty.
    """

    P: PlacedPoint
    Q: PlacedPoint
    axis: npt.ArrayLike
    axis_p: npt.ArrayLike
    name: str = ""

    def __post_init__(self) -> None:
        check_spatial_joint(self, ("axis", "axis_p"), needed=("axis", "axis_p"))

    def spatial_rows(self) -> tuple[SpatialRelative, ...]:
        """The relative coordinates that are prescribed."""
        cross = SpatialRelative("perpendicular", self.axis, on_p=self.axis_p)  # type: ignore[arg-type]  # unit vectors
        return *axes.COINCIDENCE, cross
