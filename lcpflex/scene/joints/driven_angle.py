"""Rotary drive."""

from __future__ import annotations

from dataclasses import dataclass

from lcpflex.bodies.placed_point import PlacedPoint
from lcpflex.scene.functions_of_time import Motion, checked_motion
from lcpflex.scene.joints.joint import check_joint, keep_angle
from lcpflex.scene.relative import Relative

__all__ = ["DrivenAngle"]


@dataclass(frozen=True, slots=True)
class DrivenAngle:
    """Rotary drive: angle_P - angle_Q - ``angle`` - f(t) = 0 (1 row). It holds no place: add a revolute joint.

    ``motion`` f [rad] is a number,
    :class:`~lcpflex.scene.functions_of_time.Harmonic`, :class:`~lcpflex.scene.functions_of_time.Table` or
    Python function of time. ``angle`` [rad] is the relative angle of the start configuration if omitted, so that f is
    the rotation since then; 0 makes f the relative angle itself. Raises ModelError for points that cannot be joined or
    a motion that is none.

    P, Q: points of two bodies, or of a body and of the ground. name: of the joint, for results and messages;
    joint1, joint2, ... if empty.
    """

    P: PlacedPoint
    Q: PlacedPoint
    motion: Motion
    angle: float | None = None
    name: str = ""

    def __post_init__(self) -> None:
        check_joint(self)
        keep_angle(self)
        object.__setattr__(self, "motion", checked_motion("DrivenAngle: motion", self.motion))

    def rows(self) -> tuple[Relative, ...]:
        """The relative coordinates that are prescribed."""
        return (Relative("angle", rest=self.angle, motion=self.motion),)
