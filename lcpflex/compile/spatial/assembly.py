"""What is collected while a spatial scene is compiled: material points, functions of time, the start."""

from __future__ import annotations

from dataclasses import dataclass, field

from lcpflex.bodies.placed_point import PlacedPoint
from lcpflex.bodies.spatial.body import SpatialPoint
from lcpflex.dynamics.spatial.state import SpatialState
from lcpflex.dynamics.time_functions import SignalTable
from lcpflex.model.spatial import SpatialPointTable

__all__ = ["SpatialAssembly"]


@dataclass(slots=True)
class SpatialAssembly:
    """Material points and functions of time, collected while a scene is compiled."""

    state: SpatialState  # at the start
    points: SpatialPointTable = field(default_factory=SpatialPointTable)
    signals: SignalTable = field(default_factory=SignalTable)
    _known: dict[tuple[int, int], tuple[int, SpatialPoint]] = field(default_factory=dict)

    def point(self, body: int, material: SpatialPoint) -> int:
        """Index of a material point; one object is registered once."""
        key = (body, id(material))
        if key not in self._known:
            index = self.points.add(body, material.place, material.phi, material.psi)
            self._known[key] = (index, material)  # holds the object, so that its id stays its own
        return self._known[key][0]

    def of(self, point: PlacedPoint) -> int:
        """Index of a point of the scene."""
        return self.point(point.body, point.material)
