"""Pin."""

from __future__ import annotations

from dataclasses import dataclass

from lcpflex.bodies.placed_point import PlacedPoint
from lcpflex.scene.joints.joint import COINCIDENCE, check_joint
from lcpflex.scene.relative import Relative

__all__ = ["Revolute"]


@dataclass(frozen=True, slots=True)
class Revolute:
    """Pin: P and Q coincide, r_P - r_Q = 0 (2 rows). Raises ModelError for points that cannot be joined.

    name: of the joint, for results and messages; joint1, joint2, ... if empty.
    """

    P: PlacedPoint
    Q: PlacedPoint
    name: str = ""

    def __post_init__(self) -> None:
        check_joint(self)

    def rows(self) -> tuple[Relative, ...]:
        """The relative coordinates that are prescribed."""
        return COINCIDENCE
