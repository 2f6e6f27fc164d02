"""Torsional spring and damper between two points."""

from __future__ import annotations

from dataclasses import dataclass

from lcpflex.bodies.placed_point import PlacedPoint
from lcpflex.scene.loads.load import Resistance, check_spring
from lcpflex.scene.relative import Relative

__all__ = ["TorsionSpring"]


@dataclass(frozen=True, slots=True)
class TorsionSpring:
    """Torsional spring and damper: torque -k (angle_P - angle_Q - ``angle``) - c (rate of it) on P, the opposite on Q.

    ``stiffness`` k [N m/rad] >= 0, ``damping`` c [N m s/rad] >= 0, ``angle`` [rad] without torque, that of the start
    configuration if omitted. Raises ModelError for points or numbers that cannot be.
    """

    P: PlacedPoint
    Q: PlacedPoint
    stiffness: float
    damping: float = 0.0
    angle: float | None = None

    def __post_init__(self) -> None:
        check_spring(self, "angle")

    def form(self) -> Resistance:
        """For the compilation."""
        return Resistance(Relative("angle", rest=self.angle), self.stiffness, self.damping)
