"""The state of a spatial scene that a Python function of time and state is asked at."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from lcpflex.basics.attributes import NamesNearest
from lcpflex.bodies.placed_point import PlacedPoint
from lcpflex.bodies.spatial.body import SpatialPoint
from lcpflex.dynamics.time_functions import Materials, OnBody, known_material
from lcpflex.jit.kernel import FloatArray
from lcpflex.kinematics.spatial.frames import matrices, small_rotations
from lcpflex.model.spatial import N_PLACE, N_RIGID, SpatialBodies

__all__ = ["SpatialState"]


@dataclass(frozen=True, slots=True, eq=False)
class SpatialState(NamesNearest):
    """The state that a Python force is asked at; nothing in it may be changed.

    All vectors are in world axes; q and u are laid out as told in :mod:`lcpflex.model.spatial`.
    """

    time: float  # [s]
    q: FloatArray  # (nq,)
    u: FloatArray  # (nu,)
    bodies: SpatialBodies
    materials: Materials | None = field(default=None, repr=False)  # of points of scenes with other bodies; None: theirs

    def position(self, point: PlacedPoint) -> FloatArray:
        """r_P = R + A (x + Phi eta) (3,) [m]."""
        if point.body < 0:
            return np.array(point.material.place)
        k = int(self.bodies.place[point.body])
        return np.asarray(self.q[k : k + 3] + self._frame(point.body) @ self._local(point))

    def velocity(self, point: PlacedPoint) -> FloatArray:
        """rdot_P = v + A (omega x s + Phi etadot) (3,) [m/s]."""
        if point.body < 0:
            return np.zeros(3)
        d = int(self.bodies.dof[point.body])
        rate = self._rates(point.body) @ self._material(point).phi + np.cross(self.u[d + 3 : d + 6], self._local(point))
        return np.asarray(self.u[d : d + 3] + self._frame(point.body) @ rate)

    def rotation(self, of: OnBody) -> FloatArray:
        """(3, 3) axes of a body, or of the material at a point of one; of the world for the ground."""
        if of.body < 0:
            return np.eye(3)
        frame = self._frame(of.body)
        if not isinstance(of, PlacedPoint) or not len(psi := self._material(of).psi):
            return frame
        return np.asarray(frame @ small_rotations(self._modal(of.body) @ psi))

    def angular_velocity(self, of: OnBody) -> FloatArray:
        """(3,) [rad/s] of a body, or of the material at a point of one; 0 for the ground.

        Of the material: A (omega + T(psi) psidot).
        """
        if of.body < 0:
            return np.zeros(3)
        d = int(self.bodies.dof[of.body])
        omega = self.u[d + 3 : d + 6]
        if isinstance(of, PlacedPoint) and len(shapes := self._material(of).psi):
            omega = omega + spin_of(self._modal(of.body) @ shapes, self._rates(of.body) @ shapes)
        return np.asarray(self._frame(of.body) @ omega)

    def _frame(self, body: int) -> FloatArray:
        k = int(self.bodies.place[body])
        return matrices(self.q[k + 3 : k + N_PLACE])

    def _modal(self, body: int) -> FloatArray:
        return self.q[int(self.bodies.place[body]) + N_PLACE : int(self.bodies.place[body + 1])]

    def _rates(self, body: int) -> FloatArray:
        return self.u[int(self.bodies.dof[body]) + N_RIGID : int(self.bodies.dof[body + 1])]

    def _local(self, point: PlacedPoint) -> FloatArray:
        material = self._material(point)
        return np.asarray(material.place + self._modal(point.body) @ material.phi)

    def _material(self, point: PlacedPoint) -> SpatialPoint:
        found: SpatialPoint = known_material(self.materials, point)
        return found


def spin_of(psi: FloatArray, rate: FloatArray) -> FloatArray:
    """T(psi) psidot with T = I + (1 - cos a)/a^2 psi~ + (a - sin a)/a^3 psi~^2: spin of the material, body axes."""
    a = float(np.linalg.norm(psi))
    if a < 1e-3:
        first, second = 0.5 - a * a / 24.0, 1.0 / 6.0 - a * a / 120.0
    else:
        first, second = (1.0 - np.cos(a)) / a**2, (a - np.sin(a)) / a**3
    turned = np.cross(psi, rate)
    return np.asarray(rate + first * turned + second * np.cross(psi, turned))
