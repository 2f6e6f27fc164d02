"""How much of the load at which a beam buckles it bears, held as it is.

With the axial force N(x), tension positive, and the deflection w of the beam in its frame, which turns by theta,

    max of  - integral of N (theta + w')^2 dx  /  (integral of E I w''^2 dx + energy of other bodies and springs)

over all small motions that joints, and contacts that press, allow: at 1 it has no stable straight state (Euler). The
beam is taken as it is, whatever modes it was reduced to: w is a polynomial of degree DEGREE, for which the load of a
beam with any ends is right to 1e-6. Motions in which next to nothing is strained are rotations of whole bodies, which
the equations of motion have without any approximation: what is looked for is orthogonal to them in the masses.
Source: Timoshenko & Gere, Theory of Elastic Stability, 1961.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial.legendre import Legendre

from lcpflex.checks.loads_in_time import resisted
from lcpflex.compile.compiled_scene import CompiledScene
from lcpflex.dynamics.mass_matrix import elastic_matrices, mass_matrix, null_space
from lcpflex.jit.kernel import FloatArray
from lcpflex.jit.struct import pack
from lcpflex.kinematics.relative import coordinate_gradient, relative_motion
from lcpflex.model.arrays import Axis
from lcpflex.model.planar import N_RIGID

__all__ = ["Support", "critical_share"]

DEGREE = 9
QUADRATURE = 400  # intervals: N is made of straight pieces, and jumps
LOOSE = 1e-4  # of the stiffness of the lowest bending: what is held less than that turns as a whole


class Support(NamedTuple):
    """A direction in which two bodies do not move relative to each other."""

    rows: FloatArray  # (2, width) of each side, by the velocities of its body
    body: tuple[int, int]  # -1 for the ground
    place: FloatArray  # (2, 2) where it acts on each, body axes [m]


def critical_share(
    compiled: CompiledScene, b: int, axis: Axis, q: FloatArray, N: FloatArray, supports: list[Support]
) -> float:
    """The largest of the quotients above for beam b at q, under N (k,) [N] at its stations; 0 if it bears none."""
    column = _Column(compiled, b, axis, q)
    J = np.array([column.row(one.rows, one.body, one.place) for one in supports]).reshape(len(supports), column.n)
    Z = null_space(J / np.maximum(np.abs(J).max(axis=1, initial=0.0, keepdims=True), np.finfo(float).tiny))
    L = np.linalg.cholesky(Z.T @ column.mass() @ Z)
    into = np.linalg.solve(L, Z.T).T  # coordinates in which the mass is one
    sizes, vectors = np.linalg.eigh(into.T @ column.stiffness() @ into)
    firm = sizes > LOOSE * (math.pi / axis.length) ** 2 * axis.euler * axis.length / float(
        compiled.model.bodies.mass[b]
    )
    bent = into @ vectors[:, firm] / np.sqrt(sizes[firm])
    if not bent.shape[1]:
        return 0.0
    return max(0.0, float(np.linalg.eigvalsh(bent.T @ column.pressed(N) @ bent)[-1]))


class _Column:
    """Coordinates of a scene in which one beam bends by polynomials in place of its modes."""

    def __init__(self, compiled: CompiledScene, b: int, axis: Axis, q: FloatArray) -> None:
        dof = compiled.model.bodies.dof
        self._compiled, self._model, self._b, self._axis, self._q = compiled, compiled.model, b, axis, q
        self._first = int(dof[b])
        own = np.arange(self._first + N_RIGID, int(dof[b + 1]))
        self._kept = np.setdiff1d(np.arange(int(dof[-1])), own)
        self._new = np.full(int(dof[-1]), -1)
        self._new[self._kept] = np.arange(len(self._kept))
        length = axis.length
        self._shapes = [Legendre.basis(k, domain=[0.0, length]) for k in range(2, DEGREE + 1)]
        self.n = len(self._kept) + len(self._shapes)
        self._rigid = self._new[self._first : self._first + N_RIGID]
        self._x = np.linspace(0.0, length, QUADRATURE + 1)
        self._weight = np.full(QUADRATURE + 1, length / QUADRATURE)
        self._weight[[0, -1]] *= 0.5

    def _fields(self, derivative: int) -> FloatArray:
        """(n, points) deflection across the axis, or a derivative of it, of each coordinate."""
        found = np.zeros((self.n, len(self._x)))
        cos, sin = math.cos(self._q[self._first + 2]), math.sin(self._q[self._first + 2])
        whole: tuple[list[Any], ...] = ([-sin, 0.0, 0.0], [cos, 0.0, 0.0], [self._x, 1.0, 0.0])
        for k, of in zip(self._rigid, whole, strict=True):
            found[k] = of[derivative]
        for k, shape in enumerate(self._shapes):
            found[len(self._kept) + k] = (shape.deriv(derivative) if derivative else shape)(self._x)
        return found

    def mass(self) -> FloatArray:
        """(n, n)."""
        M = self._spread(mass_matrix(self._model, self._q))
        density = float(self._model.bodies.mass[self._b]) / self._axis.length
        w = self._fields(0)
        bends = np.arange(len(self._kept), self.n)
        whole = density * (w * self._weight) @ w.T
        M[bends, :] = whole[bends, :]
        M[:, bends] = whole[:, bends]
        return M

    def stiffness(self) -> FloatArray:
        """(n, n) of bending, of all other modes, and of springs."""
        K = self._spread(elastic_matrices(self._model, self._q)[0])
        curved = self._fields(2)
        K += self._axis.euler * (self._axis.length / math.pi) ** 2 * (curved * self._weight) @ curved.T
        model: Any = pack(self._model)
        for k, value in enumerate(self._model.loads.spring_value[:, 0].tolist()):
            along = self._of_spring(model, k)
            K += value * np.outer(along, along)
        return K

    def pressed(self, N: FloatArray) -> FloatArray:
        """(n, n) with which the axial force works: - integral of N w' w'^T, of the whole slope."""
        slopes = self._fields(1)
        return np.asarray((slopes * (-np.interp(self._x, self._axis.station, N) * self._weight)) @ slopes.T)

    def row(self, rows: FloatArray, body: tuple[int, int], place: FloatArray) -> FloatArray:
        """(n,) of a support."""
        found = np.zeros(self.n)
        dof = self._model.bodies.dof
        for side, c in enumerate(body):
            if c == self._b:
                found[self._rigid] += rows[side, :N_RIGID]
                arm = self._turned(place[side])
                moment = rows[side, 2] - (arm[0] * rows[side, 1] - arm[1] * rows[side, 0])
                found[len(self._kept) :] += self._bending(rows[side, :2], moment, place[side])
            elif c >= 0:
                found[self._new[dof[c] : dof[c + 1]]] += rows[side, : dof[c + 1] - dof[c]]
        return found

    def _of_spring(self, model: Any, k: int) -> FloatArray:
        """(n,) of what spring k resists."""
        found = np.zeros(self.n)
        found[: len(self._kept)] = resisted(model, self._q, k)[self._kept]
        ends = [int(p) for p in model.loads.spring_point[k]]
        at, motion, _ = relative_motion(model.bodies, model.points, self._q, np.zeros_like(self._q), *ends)
        of = int(model.loads.spring_kind[k]), at, motion, *model.loads.spring_axis[k].tolist()
        gx, gy, turn_p, turn_q, _ = coordinate_gradient(*of)
        for p, sign, turn in zip(ends, (1.0, -1.0), (turn_p, turn_q), strict=True):
            if int(model.points.body[p]) == self._b:
                force = sign * np.array([gx, gy])
                found[len(self._kept) :] += self._bending(force, turn, model.points.place[p])
        return found

    def _bending(self, force: FloatArray, moment: float, place: FloatArray) -> FloatArray:
        """What a force in world axes and a moment, at a place of the beam, do to each polynomial."""
        along, across = self._turned(force, back=True)
        x, y = place.tolist()
        return np.array([across * shape(x) + (moment - y * along) * shape.deriv()(x) for shape in self._shapes])

    def _turned(self, s: FloatArray, back: bool = False) -> FloatArray:
        angle = -self._q[self._first + 2] if back else self._q[self._first + 2]
        cos, sin = math.cos(angle), math.sin(angle)
        return np.array([cos * s[0] - sin * s[1], sin * s[0] + cos * s[1]])

    def _spread(self, of_scene: FloatArray) -> FloatArray:
        """A matrix of the scene without the modes of the beam, with room for its polynomials."""
        found = np.zeros((self.n, self.n))
        found[: len(self._kept), : len(self._kept)] = of_scene[np.ix_(self._kept, self._kept)]
        return found
