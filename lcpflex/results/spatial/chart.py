"""Coordinates in which the motion of spatial bodies between a few instants is interpolated as that of planar ones.

With q0 the first of the configurations, x = (R, log(conj(p0) o p), eta): nu coordinates as velocities have them. In
them rotations are added, a rotation about a fixed axis is a straight line, and what is interpolated is a rotation:

    p = p0 o exp(x),   omega = T(-x) xdot,   T(x) = I + (1 - cos a)/a^2 x~ + (a - sin a)/a^3 x~^2,   a = |x|
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from scipy.spatial.transform import Rotation

from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.model.spatial import N_PLACE, N_RIGID, SpatialBodies

__all__ = ["SpatialChart", "square_roots_of_masses"]

FEW = 1e-2  # [rad] below which coefficients are series
LAST = [1, 2, 3, 0]  # quaternions with the scalar last, as SciPy has them
FIRST = [3, 0, 1, 2]


class SpatialChart:
    """Coordinates about the configuration q0 (nq,)."""

    def __init__(self, bodies: SpatialBodies, q0: FloatArray) -> None:
        self._blocks = list(zip(pairwise(bodies.place.tolist()), pairwise(bodies.dof.tolist()), strict=True))
        self._q0 = q0

    def coordinates(self, q: FloatArray, u: FloatArray) -> tuple[FloatArray, FloatArray]:
        """x and xdot (m, nu) of the states q (m, nq), u (m, nu)."""
        x, rate = np.zeros(u.shape), u.copy()
        for (k, end), (d, last) in self._blocks:
            turned = self._origin(k).inv() * _rotations(q[:, k + 3 : k + N_PLACE])
            x[:, d : d + 3] = q[:, k : k + 3]
            x[:, d + 3 : d + N_RIGID] = turned.as_rotvec()
            x[:, d + N_RIGID : last] = q[:, k + N_PLACE : end]
            for row in range(len(q)):
                spin = slice(d + 3, d + N_RIGID)
                rate[row, spin] = np.linalg.solve(_spins(-x[row, spin]), u[row, spin])
        return x, rate

    def state(self, x: FloatArray, rate: FloatArray) -> tuple[FloatArray, FloatArray]:
        """q (nq,) and u (nu,) from x and xdot (nu,)."""
        q, u = np.zeros(len(self._q0)), rate.copy()
        for (k, end), (d, last) in self._blocks:
            turn = x[d + 3 : d + N_RIGID]
            q[k : k + 3] = x[d : d + 3]
            p = (self._origin(k) * Rotation.from_rotvec(turn)).as_quat()[FIRST]
            q[k + 3 : k + N_PLACE] = (p if p @ self._q0[k + 3 : k + N_PLACE] >= 0.0 else -p) / np.linalg.norm(p)
            q[k + N_PLACE : end] = x[d + N_RIGID : last]
            u[d + 3 : d + N_RIGID] = _spins(-turn) @ rate[d + 3 : d + N_RIGID]
        return q, u

    def number(self, coordinate: int) -> int:
        """Of q, the one that goes with a coordinate: of a rotation that of the quaternion's vector."""
        for (k, _), (d, last) in self._blocks:
            if coordinate < last:
                return int(k + coordinate - d + (coordinate - d >= 3))
        raise IndexError(coordinate)

    def _origin(self, k: int) -> Rotation:
        return _rotations(self._q0[k + 3 : k + N_PLACE])


def square_roots_of_masses(bodies: SpatialBodies) -> tuple[FloatArray, IntArray]:
    """Square root of the inertia of each coordinate, modes having 1, and the body that it belongs to, (nu,) each."""
    weight = np.ones(int(bodies.dof[-1]))
    for d, mass, second in zip(bodies.dof[:-1].tolist(), bodies.mass, bodies.second, strict=True):
        weight[d : d + 3] = np.sqrt(mass)
        weight[d + 3 : d + N_RIGID] = np.sqrt(np.maximum(np.trace(second) - np.diag(second), 0.0))
    return weight, np.repeat(np.arange(len(bodies.mass)), np.diff(bodies.dof))


def _rotations(p: FloatArray) -> Rotation:
    """Of quaternions (..., 4), scalar first."""
    return Rotation.from_quat(p[..., LAST])


def _spins(x: FloatArray) -> FloatArray:
    """T(x) (3, 3)."""
    a = float(np.linalg.norm(x))
    if a < FEW:
        first, second = 0.5 - a**2 / 24.0 + a**4 / 720.0, 1.0 / 6.0 - a**2 / 120.0 + a**4 / 5040.0
    else:
        first, second = (1.0 - np.cos(a)) / a**2, (a - np.sin(a)) / a**3
    cross = np.array([[0.0, -x[2], x[1]], [x[2], 0.0, -x[0]], [-x[1], x[0], 0.0]])
    return np.asarray(np.eye(3) + first * cross + second * cross @ cross)
