"""Pin in the plane, hinge in space."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy.typing as npt

from lcpflex.bodies.placed_point import PlacedPoint
from lcpflex.scene.joints import later
from lcpflex.scene.joints.joint import COINCIDENCE, check_joint
from lcpflex.scene.relative import Relative

if TYPE_CHECKING:
    from lcpflex.scene.spatial.relative import SpatialRelative

__all__ = ["Revolute"]


@dataclass(frozen=True, slots=True)
class Revolute:
    """Pin: P and Q coincide, r_P - r_Q = 0 (2 rows). Raises ModelError for points that cannot be joined.

    In space a hinge (5 rows): ``axis`` (3,) is fixed in the material at Q, in the axes of the body of Q (world axes on
    the ground), and stays parallel to ``axis_p`` (3,) in those of the body of P; what coincides with it at the start
    if omitted. Axes that point opposite ways at the start are refused.

    name: of the joint, for results and messages; joint1, joint2, ... if empty.
    """

    P: PlacedPoint
    Q: PlacedPoint
    name: str = ""
    axis: npt.ArrayLike | None = field(default=None, kw_only=True)
    axis_p: npt.ArrayLike | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        if check_joint(self, space=("axis", "axis_p")):
            later.keep_axes(self, ("axis", "axis_p"), needed=("axis",))
            later.axes.check_turns(self, self.spatial_rows())

    def rows(self) -> tuple[Relative, ...]:
        """The relative coordinates that are prescribed."""
        return COINCIDENCE

    def spatial_rows(self) -> tuple[SpatialRelative, ...]:
        """The same in space."""
        return *later.axes.COINCIDENCE, *later.axes.parallel(self.axis, self.axis_p)  # type: ignore[arg-type]  # unit vectors
