"""Rigid connection."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy.typing as npt

from lcpflex.bodies.placed_point import PlacedPoint
from lcpflex.scene.joints import later
from lcpflex.scene.joints.joint import COINCIDENCE, check_joint, keep_angle
from lcpflex.scene.relative import Relative

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

    from lcpflex.scene.spatial.relative import SpatialRelative

__all__ = ["Weld"]


@dataclass(frozen=True, slots=True)
class Weld:
    """P and Q coincide and keep their relative angle: r_P - r_Q = 0, angle_P - angle_Q = ``angle`` (3 rows).

    ``angle`` [rad] is the relative angle of the start configuration if omitted. Raises ModelError for points
    that cannot be joined or an angle that is not finite.

    In space (6 rows) they keep their relative rotation A_Q^T A_P = ``orientation``, a scipy Rotation or a 3 x 3 matrix
    whose columns are the axes of the body of P in those of the body of Q; that of the start if omitted. A start more
    than 30 degrees from a given one is refused.

    name: of the joint, for results and messages; joint1, joint2, ... if empty.
    """

    P: PlacedPoint
    Q: PlacedPoint
    angle: float | None = None
    name: str = ""
    orientation: Rotation | npt.ArrayLike | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        if check_joint(self, plane=("angle",), space=("orientation",)):
            later.keep_orientation(self)
            later.axes.check_turns(self, self.spatial_rows())
        keep_angle(self)

    def rows(self) -> tuple[Relative, ...]:
        """The relative coordinates that are prescribed."""
        return *COINCIDENCE, Relative("angle", rest=self.angle)

    def spatial_rows(self) -> tuple[SpatialRelative, ...]:
        """The same in space."""
        return *later.axes.COINCIDENCE, *later.axes.locked(self.orientation)  # type: ignore[arg-type]  # a matrix or None
