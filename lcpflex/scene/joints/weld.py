"""Rigid connection."""

from __future__ import annotations

from dataclasses import dataclass

from lcpflex.bodies.placed_point import PlacedPoint
from lcpflex.scene.joints.joint import COINCIDENCE, check_joint, keep_angle
from lcpflex.scene.relative import Relative

__all__ = ["Weld"]


@dataclass(frozen=True, slots=True)
class Weld:
    """P and Q coincide and keep their relative angle: r_P - r_Q = 0, angle_P - angle_Q = ``angle`` (3 rows).

    ``angle`` [rad] is the relative angle of the start configuration if omitted. Raises ModelError for points
    that cannot be joined or an angle that is not finite.

    name: of the joint, for results and messages; joint1, joint2, ... if empty.
    """

    P: PlacedPoint
    Q: PlacedPoint
    angle: float | None = None
    name: str = ""

    def __post_init__(self) -> None:
        check_joint(self)
        keep_angle(self)

    def rows(self) -> tuple[Relative, ...]:
        """The relative coordinates that are prescribed."""
        return *COINCIDENCE, Relative("angle", rest=self.angle)
