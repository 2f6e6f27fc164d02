"""How a square becomes a disc, and a cube a ball, without elements that are flat at their corners.

A core of bent squares has layers around it. A place is known by a point q of the square |q_k| <= 1 and t: on the core,
t = 0, anywhere; in the layers, q on the rim of the square, up to t = 1 on the circle.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from lcpflex.jit.kernel import FloatArray

__all__ = ["CORE", "RoundMap"]

CORE = 0.55  # half the width of the core, of the radius: edges of a ball differ by 1.6, more elements the smaller it is
BULGE = 0.3  # of the core: 0 a square, 1 a disc, whose elements are flat at four corners; .3 is the best for a ball
STEP = 1e-5  # of coordinates, over which differences are taken
BISECTIONS = 60  # to rounding


@dataclass(frozen=True, slots=True)
class RoundMap:
    """A disc (d = 2) or a ball (d = 3) about the origin; radius [m]."""

    d: int
    radius: float

    def core(self, q: FloatArray) -> FloatArray:
        """(k, d) places of the core: x_i = c R q_i sqrt(1 - b sum_j q_j^2 / 2 + b^2 prod_j q_j^2 / 3), j not i."""
        square = q * q
        others = square.sum(axis=1, keepdims=True) - square
        bent = 1.0 - 0.5 * BULGE * others
        if self.d == 3:
            bent += BULGE**2 / 3.0 * square[:, [1, 2, 0]] * square[:, [2, 0, 1]]
        return np.asarray(CORE * self.radius * q * np.sqrt(bent))

    def surface(self, q: FloatArray) -> FloatArray:
        """(k, d) places of the surface that lines from the rim of the square lead to; equal steps are equal angles."""
        towards = np.tan(0.25 * math.pi * q)
        return np.asarray(self.radius * towards / np.linalg.norm(towards, axis=1, keepdims=True))

    def places(self, q: FloatArray, t: FloatArray) -> FloatArray:
        """(k, d) places of points (k, d), (k,)."""
        found = self.core(q)
        out = t > 0.0
        share = t[out, None]
        found[out] = (1.0 - share) * found[out] + share * self.surface(q[out])
        return found

    def pulled(self, place: FloatArray) -> list[tuple[int, float, float, float]]:
        """What a place (d,) does to lines: direction (d: that of t); at, away and metric of a ``Pull``.

        Lines of the directions that do not pass it are drawn to where they come nearest.
        """
        q, t = self._inverse(place)
        if t > 0.0:
            return self._pulled_outside(q, t)
        rims = [_put(q, k, end) for k in range(self.d) for end in (-1.0, 1.0)]
        away, rim = min(((self._apart(q, 0.0, rim, 0.0), n) for n, rim in enumerate(rims)))
        lines = [(k, float(q[k]), 0.0, self._metric(q, 0.0, k)) for k in range(self.d)]
        return [*lines, (self.d, 0.0, away, self._through(rims[rim]))]

    def _pulled_outside(self, q: FloatArray, t: float) -> list[tuple[int, float, float, float]]:
        """Of a place in the layers: those to its side are reached across the core's rim or past a corner of it."""
        out = int(np.abs(q).argmax())
        along = [k for k in range(self.d) if k != out]
        lines = [(k, float(q[k]), 0.0, self._metric(q, t, k)) for k in along]
        beside = [(q, 0.0), *((_put(q, k, math.copysign(1.0, q[k])), t) for k in along)]
        away, nearest = min((self._apart(q, t, *other), n) for n, other in enumerate(beside))
        metric = self._metric(*beside[nearest], out)
        return [*lines, (out, float(q[out]), away, metric), (self.d, t, 0.0, self._through(q))]

    def _at(self, q: FloatArray, t: float) -> FloatArray:
        return np.asarray(self.places(q[None], np.array([t]))[0])

    def _apart(self, q: FloatArray, t: float, p: FloatArray, s: float) -> float:
        return float(np.linalg.norm(self._at(q, t) - self._at(p, s)))

    def _through(self, q: FloatArray) -> float:
        """Thickness of the layers [m]."""
        return self._apart(q, 0.0, q, 1.0)

    def _metric(self, q: FloatArray, t: float, k: int) -> float:
        """Metres a unit of a coordinate."""
        ends = [_put(q, k, float(np.clip(q[k] + step, -1.0, 1.0))) for step in (-STEP, STEP)]
        return self._apart(ends[0], t, ends[1], t) / float(ends[1][k] - ends[0][k])

    def _inverse(self, place: FloatArray) -> tuple[FloatArray, float]:
        """The point (d,) and t of a place (d,): of a ball on its surface."""
        out = int(np.abs(place).argmax())
        size = float(np.linalg.norm(place))
        if self.d == 3 or size >= self.radius * (1.0 - 1e-12):
            return np.arctan(place / abs(place[out])) / (0.25 * math.pi), 1.0
        x, y = place[out] / (CORE * self.radius), place[1 - out] / (CORE * self.radius)
        A, B = _unbent(abs(x), abs(y))
        if A <= 1.0:
            q = np.empty(2)
            q[out], q[1 - out] = math.copysign(A, x), math.copysign(B, y)
            return q, 0.0
        return self._inverse_outside(place, out)

    def _inverse_outside(self, place: FloatArray, out: int) -> tuple[FloatArray, float]:
        """In the layers: the straight line from the core to the circle that passes the place, by bisection."""
        q = np.full(2, math.copysign(1.0, place[out]))
        low, high = -1.0, 1.0
        for _ in range(BISECTIONS):
            q[1 - out] = 0.5 * (low + high)
            inner, outer = self._at(q, 0.0), self._at(q, 1.0)
            arm, on = outer - inner, place - inner
            beyond = (arm[out] * on[1 - out] - arm[1 - out] * on[out]) * q[out] > 0.0
            low, high = (q[1 - out], high) if beyond else (low, q[1 - out])
        return q, min(1.0, float(arm @ on) / float(arm @ arm))


def _unbent(x: float, y: float) -> tuple[float, float]:
    """(a, b) of x = a sqrt(1 - g b^2), y = b sqrt(1 - g a^2), x >= y >= 0; a beyond 1 where there are none."""
    g, apart = 0.5 * BULGE, x * x - y * y
    half = 0.5 * (1.0 + g * apart)
    root = half * half - g * x * x
    if root < 0.0:
        return 2.0, 2.0
    A = (half - math.sqrt(root)) / g
    return math.sqrt(A), y / math.sqrt(1.0 - g * A)


def _put(q: FloatArray, k: int, value: float) -> FloatArray:
    changed = q.copy()
    changed[k] = value
    return changed
