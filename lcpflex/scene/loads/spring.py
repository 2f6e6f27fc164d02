"""Spring and damper between two points."""

from __future__ import annotations

from dataclasses import dataclass

from lcpflex.bodies.placed_point import PlacedPoint
from lcpflex.scene.loads.load import Resistance, check_spring
from lcpflex.scene.relative import Relative
from lcpflex.scene.spatial.relative import SpatialRelative, SpatialResistance

__all__ = ["Spring"]


@dataclass(frozen=True, slots=True)
class Spring:
    """Spring and damper along the line from P to Q: tension k (L - ``length``) + c Ldot with L = |r_P - r_Q|.

    ``stiffness`` k [N/m] >= 0, ``damping`` c [N s/m] >= 0, ``length`` [m] >= 0 without force, that of the start
    configuration if omitted. Raises ModelError for points or numbers that cannot be.
    """

    P: PlacedPoint
    Q: PlacedPoint
    stiffness: float
    damping: float = 0.0
    length: float | None = None

    def __post_init__(self) -> None:
        check_spring(self, "length")

    def form(self) -> Resistance:
        """For the compilation."""
        return Resistance(Relative("distance", rest=self.length), self.stiffness, self.damping)

    def spatial_forms(self) -> tuple[SpatialResistance, ...]:
        """The same in space."""
        return (SpatialResistance(SpatialRelative("distance", rest=self.length), self.stiffness, self.damping),)
