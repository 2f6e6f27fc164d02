"""Linear drive."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from lcpflex.basics.renamed import GOES
from lcpflex.bodies.placed_point import PlacedPoint
from lcpflex.scene.functions_of_time import Motion, checked_motion
from lcpflex.scene.joints import later
from lcpflex.scene.joints.joint import check_joint, unit
from lcpflex.scene.relative import Relative

if TYPE_CHECKING:
    from lcpflex.scene.spatial.relative import SpatialRelative

__all__ = ["DrivenDisplacement"]


@dataclass(frozen=True, slots=True)
class DrivenDisplacement:
    """Linear drive: axis_Q.(r_P - r_Q) - f(t) = 0 (1 row). It guides nothing: add a prismatic joint or a line.

    ``motion`` f [m] is a number, :class:`~lcpflex.scene.functions_of_time.Harmonic`,
    :class:`~lcpflex.scene.functions_of_time.Table` or Python function of time; ``axis`` (2,), in space (3,), is fixed
    in the material at Q. Points, motion, axis: in this order, as of :class:`~lcpflex.DrivenAngle`. Raises ModelError
    for points that cannot be joined, a zero axis or a motion that is none.

    P: the point that is driven. name: of the joint, for results and messages; joint1, joint2, ... if empty.
    """

    P: PlacedPoint
    Q: PlacedPoint
    motion: Motion
    axis: npt.ArrayLike
    name: str = ""

    def __post_init__(self) -> None:
        if _is_sequence(self.motion) and not _is_sequence(self.axis):
            warnings.warn(
                f"DrivenDisplacement takes its motion before its axis, as DrivenAngle does: (P, Q, motion, axis); the "
                f"other order goes with version {GOES}",
                DeprecationWarning,
                stacklevel=3,
            )
            axis, motion = self.motion, self.axis
            object.__setattr__(self, "axis", axis)
            object.__setattr__(self, "motion", motion)
        in_space = check_joint(self)
        later.keep_line(self, omitted=False)
        object.__setattr__(self, "motion", checked_motion("DrivenDisplacement: motion", self.motion))
        if in_space:
            later.axes.check_turns(self, self.spatial_rows())

    def rows(self) -> tuple[Relative, ...]:
        """The relative coordinates that are prescribed."""
        return (Relative("along", unit("DrivenDisplacement", self.axis), motion=self.motion),)

    def spatial_rows(self) -> tuple[SpatialRelative, ...]:
        """The same in space."""
        return (later.SpatialRelative("along", self.axis, motion=self.motion),)  # type: ignore[arg-type]  # a unit vector


def _is_sequence(value: Any) -> bool:
    """Whether it is several numbers: an axis may be, a motion never."""
    return isinstance(value, (list, tuple)) or (isinstance(value, np.ndarray) and value.ndim > 0)
