"""What is collected while a scene is compiled: material points, functions of time, and the start they refer to."""

from __future__ import annotations

from dataclasses import dataclass, field

from lcpflex.bodies.body import MaterialPoint
from lcpflex.bodies.placed_point import PlacedPoint
from lcpflex.dynamics.time_functions import SignalTable, State
from lcpflex.kinematics.relative import Apart, Motion, coordinate_gradient, coordinate_value
from lcpflex.model.arrays import PointTable
from lcpflex.model.coordinates import KINDS
from lcpflex.scene.relative import Relative

__all__ = ["Assembly"]


@dataclass(slots=True)
class Assembly:
    """Material points and functions of time, collected while a scene is compiled."""

    state: State  # at the start
    points: PointTable = field(default_factory=PointTable)
    signals: SignalTable = field(default_factory=SignalTable)
    _known: dict[tuple[int, int], tuple[int, MaterialPoint]] = field(default_factory=dict)

    def point(self, body: int, material: MaterialPoint) -> int:
        """Index of a material point; one object is registered once."""
        key = (body, id(material))
        if key not in self._known:
            index = self.points.add(body, material.place, material.phi, material.psi)
            self._known[key] = (index, material)  # holds the object, so that its id stays its own
        return self._known[key][0]

    def of(self, point: PlacedPoint) -> int:
        """Index of a point of the scene."""
        return self.point(point.body, point.material)

    def value(self, of: Relative, P: PlacedPoint, Q: PlacedPoint) -> float:
        """A relative coordinate of P and Q at the start [m] or [rad]."""
        return float(coordinate_value(KINDS.index(of.kind), self._apart(P, Q), *of.axis))

    def rate(self, of: Relative, P: PlacedPoint, Q: PlacedPoint) -> float:
        """Its rate at the start [m/s] or [rad/s]."""
        state = self.state
        vx, vy = state.velocity(P) - state.velocity(Q)
        motion = Motion(float(vx), float(vy), 0.0, 0.0, state.angular_velocity(P), state.angular_velocity(Q))
        gx, gy, turn_p, turn_q, _ = coordinate_gradient(KINDS.index(of.kind), self._apart(P, Q), motion, *of.axis)
        return float(gx * motion.vx + gy * motion.vy + turn_p * motion.spin_p + turn_q * motion.spin_q)

    def _apart(self, P: PlacedPoint, Q: PlacedPoint) -> Apart:
        x, y = self.state.position(P) - self.state.position(Q)
        return Apart(float(x), float(y), self.state.angle(P), self.state.angle(Q))
