"""The relative coordinates of two points in space that joints prescribe and springs resist, and who declares them.

Directions are unit vectors of three numbers. Those at Q and P are fixed in the material there, in the axes of their
bodies (world axes on the ground).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, Protocol, TypeAlias, runtime_checkable

from lcpflex.bodies.placed_point import PlacedPoint
from lcpflex.scene.functions_of_time import Motion
from lcpflex.scene.loads.effort import Effort

__all__ = ["NOWHERE", "SpatialJoint", "SpatialLoad", "SpatialRelative", "SpatialResistance", "Way"]

Way: TypeAlias = tuple[float, float, float]

NOWHERE: Way = (0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class SpatialRelative:
    """A relative coordinate c of two points P and Q, and where it is held: c = rest + motion(t)."""

    kind: str  # a name in :data:`lcpflex.model.coordinates.SPATIAL_KINDS`
    axis: Way = (1.0, 0.0, 0.0)  # at Q; of a component, in the world
    on_p: Way | None = NOWHERE  # at P; None: what coincides with ``like`` at the start
    on_q: Way = NOWHERE  # at Q
    rest: float | None = 0.0  # [m] or [rad]; None: as at the start
    motion: Motion | None = None
    like: Way = NOWHERE  # the direction at Q that ``on_p`` is parallel to where the joint is assembled; none: zeros


@runtime_checkable
class SpatialJoint(Protocol):
    """A joint of space: a frozen dataclass with two points, a name, and what it prescribes of them."""

    __dataclass_fields__: ClassVar[dict[str, Any]]

    @property
    def P(self) -> PlacedPoint: ...
    @property
    def Q(self) -> PlacedPoint: ...
    @property
    def name(self) -> str: ...

    def spatial_rows(self) -> tuple[SpatialRelative, ...]:
        """The relative coordinates that are prescribed, in the order of the rows."""
        ...


@dataclass(frozen=True, slots=True)
class SpatialResistance:
    """Force -k (c - rest) - d cdot along a relative coordinate c of the points P and Q of a load."""

    coordinate: SpatialRelative
    stiffness: float  # k [N/m] or [N m/rad]
    damping: float  # d [N s/m] or [N m s/rad]


@runtime_checkable
class SpatialLoad(Protocol):
    """A load of space: a frozen dataclass with a point P, for a :class:`SpatialResistance` also Q."""

    __dataclass_fields__: ClassVar[dict[str, Any]]

    @property
    def P(self) -> PlacedPoint: ...

    def spatial_forms(self) -> tuple[SpatialResistance | Effort, ...]:
        """For the compilation."""
        ...
