"""A ball with one place of contact: shells about the place, whose elements grow with their distance from it.

A half-space z >= 0 becomes the ball by inversion, which keeps angles, and lengths at the place, its origin:

    x = 4 R^2 s / |s|^2,   s = p + (0, 0, 2 R)

A half cube of elements about the origin has half spheres around it; that of radius 2 R becomes the disc halfway to
the antipode, and p -> 4 R^2 p / |p|^2 the mirror image in it. So the shells end on a half cube about the antipode.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lcpflex.bodies.fem.graded_lines import Axis
from lcpflex.bodies.fem.hex_mesh import boundary_quads, grid, grid_cells, layered, with_faces
from lcpflex.bodies.fem.mesh import Mesh
from lcpflex.bodies.fem.round_map import CORE, RoundMap
from lcpflex.jit.kernel import FloatArray

__all__ = ["ROUND", "PolarBall"]

UNIT = RoundMap(3, 1.0 / CORE)  # whose core is a bent cube of half the width 1
ROUND = 2.0  # widths of the cube at which shells are spheres; its corners are at 1.48 and stay behind them
MIRRORED = [0, 3, 2, 1, 4, 7, 6, 5]  # nodes of an element whose mirror image it is


@dataclass(frozen=True, slots=True, eq=False)
class PolarBall:
    """A ball about the origin, with small elements about the place ``turn @ (0, 0, -radius)``.

    Directions: across the cubes, along all three axes alike, and the length of arc from cube to cube.
    """

    radius: float
    asked: float  # distance from the place up to which elements are small at least [m]
    within: float  # half the width of the cube there [m]
    turn: FloatArray  # (3, 3)

    def axes(self) -> tuple[Axis, ...]:
        """Elements across are longest at the antipode."""
        R = self.radius
        first, last = (2.0 * R * math.atan2(rho, 2.0 * R) for rho in (self.within, 4.0 * R))
        return Axis(-1.0, 1.0, R, 4), Axis(first, last, 1.0, 2)

    def pulled(self, place: FloatArray) -> list[tuple[int, float, float, float]]:
        """What the place does to lines: shells grow from the cube on."""
        return [(0, 0.0, 0.0, self.within), (1, self.within - self.asked, 0.0, 1.0)]

    def count(self, elements: Sequence[int]) -> int:
        """Two half cubes, and shells."""
        across, shells = elements
        return across**3 + 3 * across**2 * shells

    def mesh(self, lines: Sequence[FloatArray]) -> Mesh:
        """A half cube, its sides drawn outwards, and a half cube on the last shell."""
        across, arcs = lines
        q, numbers = grid([across, across, across[across >= 0.0]])
        core = grid_cells(numbers)
        quads = boundary_quads(core)
        quads = quads[(np.abs(q) == 1.0)[quads].all(axis=1).any(axis=1)]
        cells, rim = layered(core, quads, len(arcs) - 1)
        shells = 2.0 * self.radius * np.tan(0.5 * arcs / self.radius)
        around = [self._shell(q[rim], float(rho)) for rho in shells[1:]]
        last = len(q) + (len(arcs) - 2) * len(rim)
        inner = np.setdiff1d(np.arange(len(q)), rim)
        far = np.empty(len(q), dtype=np.int64)
        far[rim], far[inner] = last + np.arange(len(rim)), last + len(rim) + np.arange(len(inner))
        near = self._inverted(self.within * UNIT.core(q), 1.0)
        beyond = self._inverted(self.radius * UNIT.core(q[inner]), -1.0)
        places = np.vstack([near, *around, beyond])
        on = np.concatenate([q[:, 2], np.tile(q[rim, 2], len(arcs) - 1), q[inner, 2]]) == 0.0
        cells = np.concatenate([cells, far[core][:, MIRRORED]])
        return with_faces(places @ self.turn.T, cells, {"surface": on})

    def _shell(self, q: FloatArray, rho: float) -> FloatArray:
        """(k, 3) places of the rim of a cube (k, 3), drawn out to a shell of the half space."""
        R, side = self.radius, 1.0
        width = self.within
        if rho > 2.0 * R:
            rho, side, width = 4.0 * R**2 / rho, -1.0, R
        share = min(1.0, math.log(rho / width) / math.log(ROUND))
        return self._inverted(rho * ((1.0 - share) * UNIT.core(q) + share / UNIT.radius * UNIT.surface(q)), side)

    def _inverted(self, p: FloatArray, side: float) -> FloatArray:
        """Places of the ball for those of the half space; side -1: about the antipode."""
        R = self.radius
        s = p + np.array([0.0, 0.0, 2.0 * R])
        found = 4.0 * R**2 * s / np.sum(s * s, axis=1, keepdims=True) - [0.0, 0.0, R]
        return np.asarray(found * [1.0, 1.0, -side])
