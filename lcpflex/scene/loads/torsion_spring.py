"""Torsional spring and damper between two points."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy.typing as npt

from lcpflex.bodies.placed_point import PlacedPoint
from lcpflex.scene.joints.joint import refuse_foreign
from lcpflex.scene.loads.load import Resistance, check_spring
from lcpflex.scene.relative import Relative
from lcpflex.scene.spatial import axes
from lcpflex.scene.spatial.angle import angle_about
from lcpflex.scene.spatial.keep import keep_axes, keep_half_turn
from lcpflex.scene.spatial.relative import SpatialResistance

__all__ = ["TorsionSpring"]


@dataclass(frozen=True, slots=True)
class TorsionSpring:
    """Torsional spring and damper: torque -k (angle_P - angle_Q - ``angle``) - c (rate of it) on P, the opposite on Q.

    ``stiffness`` k [N m/rad] >= 0, ``damping`` c [N m s/rad] >= 0, ``angle`` [rad] without torque, that of the start
    configuration if omitted. Raises ModelError for points or numbers that cannot be.

    In space the angle is that about ``axis`` (3,), fixed in the material at Q, as
    :class:`~lcpflex.scene.joints.driven_angle.DrivenAngle` counts it. The spring may be twisted by 170 degrees either
    way: a state does not tell whole turns, and a run that twists it further ends with an error.
    """

    P: PlacedPoint
    Q: PlacedPoint
    stiffness: float
    damping: float = 0.0
    angle: float | None = None
    axis: npt.ArrayLike | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        check_spring(self, "angle")
        refuse_foreign(self, (), ("axis",))
        if self.P.in_space:
            keep_axes(self, ("axis",), needed=("axis",))
            keep_half_turn(self)
            axes.check_turns(self, (self.spatial_forms()[0].coordinate,))

    def form(self) -> Resistance:
        """For the compilation."""
        return Resistance(Relative("angle", rest=self.angle), self.stiffness, self.damping)

    def spatial_forms(self) -> tuple[SpatialResistance, ...]:
        """The same in space."""
        about = angle_about(self.axis, self.angle)  # type: ignore[arg-type]  # a unit vector
        return (SpatialResistance(about, self.stiffness, self.damping),)
