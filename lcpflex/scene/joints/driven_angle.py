"""Rotary drive."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy.typing as npt

from lcpflex.bodies.placed_point import PlacedPoint
from lcpflex.scene.functions_of_time import Motion, checked_motion
from lcpflex.scene.joints import later
from lcpflex.scene.joints.joint import check_joint, keep_angle
from lcpflex.scene.relative import Relative

if TYPE_CHECKING:
    from lcpflex.scene.spatial.relative import SpatialRelative

__all__ = ["DrivenAngle"]


@dataclass(frozen=True, slots=True)
class DrivenAngle:
    """Rotary drive: angle_P - angle_Q - ``angle`` - f(t) = 0 (1 row). It holds no place: add a revolute joint.

    ``motion`` f [rad] is a number,
    :class:`~lcpflex.scene.functions_of_time.Harmonic`, :class:`~lcpflex.scene.functions_of_time.Table` or
    Python function of time. ``angle`` [rad] is the relative angle of the start configuration if omitted, so that f is
    the rotation since then; 0 makes f the relative angle itself. Raises ModelError for points that cannot be joined or
    a motion that is none.

    In space the angle is that about ``axis`` (3,), fixed in the material at Q and parallel to what coincides with it at
    P at the start; the revolute joint beside it keeps them so. It is counted over any number of turns. The relative
    angle is 0 where the axes of the two bodies are parallel, if the axis has the same components in both; if it has
    not, where they are after the shortest rotation that takes one to the other.

    P, Q: points of two bodies, or of a body and of the ground. name: of the joint, for results and messages;
    joint1, joint2, ... if empty.
    """

    P: PlacedPoint
    Q: PlacedPoint
    motion: Motion
    angle: float | None = None
    name: str = ""
    axis: npt.ArrayLike | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        if check_joint(self, space=("axis",)):
            later.keep_axes(self, ("axis",), needed=("axis",))
            later.keep_half_turn(self)
            later.axes.check_turns(self, self.spatial_rows())
        keep_angle(self)
        object.__setattr__(self, "motion", checked_motion("DrivenAngle: motion", self.motion))

    def rows(self) -> tuple[Relative, ...]:
        """The relative coordinates that are prescribed."""
        return (Relative("angle", rest=self.angle, motion=self.motion),)

    def spatial_rows(self) -> tuple[SpatialRelative, ...]:
        """The same in space."""
        return (later.angle_about(self.axis, self.angle, self.motion),)  # type: ignore[arg-type]  # a unit vector
