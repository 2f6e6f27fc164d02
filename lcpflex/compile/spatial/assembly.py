"""What is collected while a spatial scene is compiled: material points, functions of time, the start."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from lcpflex.bodies.placed_point import PlacedPoint
from lcpflex.bodies.spatial.body import SpatialPoint
from lcpflex.dynamics.spatial.state import SpatialState
from lcpflex.dynamics.time_functions import SignalTable
from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.kinematics.spatial.relative import (
    Apart,
    Directions,
    Motion,
    coordinate_gradient,
    coordinate_rate,
    coordinate_value,
)
from lcpflex.model.coordinates import SPATIAL_KINDS
from lcpflex.model.spatial import SpatialPointTable
from lcpflex.scene.spatial.relative import Way

__all__ = ["SpatialAssembly"]


@dataclass(slots=True)
class SpatialAssembly:
    """Material points and functions of time, collected while a scene is compiled."""

    state: SpatialState  # at the start
    points: SpatialPointTable = field(default_factory=SpatialPointTable)
    signals: SignalTable = field(default_factory=SignalTable)
    spread: dict[int, tuple[IntArray, FloatArray]] = field(default_factory=dict)  # of points: see CompiledScene
    _known: dict[tuple[int, int], tuple[int, SpatialPoint]] = field(default_factory=dict)

    def point(self, body: int, material: SpatialPoint) -> int:
        """Index of a material point; one object is registered once."""
        key = (body, id(material))
        if key not in self._known:
            index = self.points.add(body, material.place, material.phi, material.psi)
            self._known[key] = (index, material)  # holds the object, so that its id stays its own
            if material.spread is not None:
                self.spread[index] = material.spread
        return self._known[key][0]

    def of(self, point: PlacedPoint) -> int:
        """Index of a point of the scene."""
        return self.point(point.body, point.material)

    def value(self, kind: str, way: Directions, P: PlacedPoint, Q: PlacedPoint) -> float:
        """A relative coordinate of P and Q at the start [m] or [rad]."""
        return float(coordinate_value(SPATIAL_KINDS.index(kind), self._apart(P, Q), way))

    def rate(self, kind: str, way: Directions, P: PlacedPoint, Q: PlacedPoint) -> float:
        """Its rate at the start [m/s] or [rad/s]."""
        state = self.state
        v = _three(state.velocity(P) - state.velocity(Q))
        spins = _three(state.angular_velocity(P)), _three(state.angular_velocity(Q))
        nothing = (0.0, 0.0, 0.0)
        gradient = coordinate_gradient(SPATIAL_KINDS.index(kind), self._apart(P, Q), way)
        return float(coordinate_rate(gradient, Motion(v, nothing, *spins, nothing, nothing)))

    def turn(self, P: PlacedPoint, Q: PlacedPoint) -> FloatArray:
        """A_Q^T A_P (3, 3) of the material at the start."""
        return np.asarray(self.state.rotation(Q).T @ self.state.rotation(P))

    def _apart(self, P: PlacedPoint, Q: PlacedPoint) -> Apart:
        axes = (tuple(float(a) for a in self.state.rotation(point).ravel()) for point in (P, Q))
        return Apart(_three(self.state.position(P) - self.state.position(Q)), *axes)  # type: ignore[arg-type]


def _three(numbers: FloatArray) -> Way:
    x, y, z = (float(number) for number in numbers)
    return x, y, z
