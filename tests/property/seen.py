"""What is measured of a random scene: where its points are and go, and how deep its bodies are in each other."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

import lcpflex as lf
from tests.property.overlap import Outline, deepest, outlines, solids, speeds, tracks
from tests.property.own_systems import own_points
from tests.property.random_scenes import Drawn
from tests.property.yard import Wall, core

__all__ = ["Seen"]

Array = npt.NDArray[np.float64]
LOOKS = {2: 1000, 3: 24}  # instants at which depths are taken: in space one costs a millisecond


class Seen:
    """Measures states of the scene that was drawn; ``result``: any of its runs."""

    def __init__(self, drawn: Drawn, result: lf.Result) -> None:
        self._drawn = drawn
        self._shapes: list[Outline] = []
        if not drawn.system[0]:
            cores = [core(shape, drawn.dimension) for shape in drawn.shapes]
            self._shapes = outlines(result) if drawn.dimension == 2 else solids(result, cores)
        starts = [tracks(shape, result.q[:1])[0] for shape in self._shapes]
        spans = [float(np.ptp(p, axis=0).max()) for p in starts] + [2.0 * shape.radius for shape in self._shapes]
        self.extent = max(spans, default=drawn.length)  # [m] of the largest body

    def places(self, q: Array) -> Array:
        """All places of all bodies (m, p, d)."""
        if not self._shapes:
            return own_points(self._drawn, q, np.zeros_like(q))[0]
        return np.concatenate([tracks(shape, q) for shape in self._shapes], axis=1)

    def rates(self, q: Array, u: Array) -> Array:
        """Their velocities."""
        if not self._shapes:
            return own_points(self._drawn, q, u)[1]
        return np.concatenate([speeds(shape, q, u) for shape in self._shapes], axis=1)

    def depth(self, result: lf.Result, rows: Any) -> float:
        """The largest at these instants, or as many of them as time allows; negative where all are apart."""
        if not self._shapes or not len(rows):
            return -np.inf
        some = np.unique(np.linspace(0, len(rows) - 1, LOOKS[self._drawn.dimension]).astype(int))
        walls = [_solid(wall) for wall in self._drawn.walls]
        count = len(self._shapes)
        pairs = [(k, j) for k in range(count) for j in range(k) if self._drawn.may_touch(k, j)]
        if not walls and not pairs:
            return -np.inf
        return float(deepest(result, walls, pairs, rows[some], self._shapes).max())


def _solid(wall: Wall) -> tuple[Any, ...]:
    """As :func:`overlap.deepest` takes it."""
    place, numbers = np.array(wall.place), np.array(wall.numbers)
    if wall.kind == "plane":
        return "plane", place, numbers
    if wall.kind == "post":
        return "disc", place, float(numbers[0])
    shares = np.array(np.meshgrid(*[(0.0, 1.0)] * len(place), indexing="ij")).reshape(len(place), -1).T
    corners = place + shares * numbers
    return "ring", corners if len(place) == 3 else corners[[0, 2, 3, 1]]
