"""What shapes are meshed on: directions of lines, and grids and layers between them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from lcpflex.bodies.fem.graded_lines import Axis, Spot
from lcpflex.bodies.fem.hex_mesh import BoolArray, boundary_quads, grid, grid_cells, layered, with_faces
from lcpflex.bodies.fem.mesh import Mesh
from lcpflex.bodies.fem.polar_ball import ROUND, PolarBall
from lcpflex.bodies.fem.round_map import CORE, RoundMap
from lcpflex.jit.kernel import FloatArray

__all__ = ["Block", "Grid", "Round", "Shape", "Tube"]

SIDES = (("left", "right"), ("front", "back"), ("bottom", "top"))


class Grid(Protocol):
    """Lines whose crossings are nodes."""

    def axes(self) -> tuple[Axis, ...]:
        """Its directions of lines."""

    def pulled(self, place: FloatArray) -> list[tuple[int, float, float, float]]:
        """What a place of the surface does to lines: direction; at, away and metric of a :class:`Pull`."""

    def count(self, elements: Sequence[int]) -> int:
        """The number of elements, by those of each direction."""

    def mesh(self, lines: Sequence[FloatArray]) -> Mesh:
        """The mesh on lines of each direction."""


class Shape(Grid, Protocol):
    """A shape that can be meshed."""

    def turned_to(self, place: FloatArray) -> Shape:
        """The shape with its lines as they suit a place best."""

    def shells(self, spot: Spot, size: float) -> list[Grid]:
        """Grids with shells about a place, of elements of a size at most."""

    def names(self) -> tuple[str, ...]:
        """Of its faces."""

    def onto(self, place: FloatArray) -> FloatArray:
        """(3,) the nearest place of the surface."""


@dataclass(frozen=True, slots=True, eq=False)
class Block:
    """low <= x <= high of three coordinates."""

    low: FloatArray
    high: FloatArray

    def turned_to(self, place: FloatArray) -> Block:
        """Itself."""
        return self

    def shells(self, spot: Spot, size: float) -> list[Grid]:
        """None."""
        return []

    def names(self) -> tuple[str, ...]:
        """Names: "left" to "top"."""
        return tuple(name for names in SIDES for name in names)

    def axes(self) -> tuple[Axis, ...]:
        """Along x, y, z."""
        return tuple(Axis(float(a), float(b), 1.0, 1) for a, b in zip(self.low, self.high, strict=True))

    def onto(self, place: FloatArray) -> FloatArray:
        """Into the box, then to the nearest of its sides."""
        there = np.clip(place, self.low, self.high)
        depth = np.minimum(there - self.low, self.high - there)
        k = int(depth.argmin())
        there[k] = self.low[k] if there[k] - self.low[k] <= self.high[k] - there[k] else self.high[k]
        return there

    def pulled(self, place: FloatArray) -> list[tuple[int, float, float, float]]:
        """Lines of all directions pass the place."""
        return [(k, float(at), 0.0, 1.0) for k, at in enumerate(place)]

    def count(self, elements: Sequence[int]) -> int:
        """nx ny nz."""
        return math.prod(elements)

    def mesh(self, lines: Sequence[FloatArray]) -> Mesh:
        """A grid."""
        places, numbers = grid(lines)
        on: dict[str, BoolArray] = {}
        for k, names in enumerate(SIDES):
            on |= {names[0]: places[:, k] == lines[k][0], names[1]: places[:, k] == lines[k][-1]}
        return with_faces(places, grid_cells(numbers), on)


@dataclass(frozen=True, slots=True)
class Tube:
    """inner <= r <= outer, |z| <= length / 2; directions: angle from ``seam``, radius, z."""

    inner: float
    outer: float
    length: float
    seam: float = 0.0

    def turned_to(self, place: FloatArray) -> Tube:
        """With its seam at the angle of a place."""
        return replace(self, seam=math.atan2(place[1], place[0]))

    def shells(self, spot: Spot, size: float) -> list[Grid]:
        """None."""
        return []

    def names(self) -> tuple[str, ...]:
        """Names: "inner" to "top"."""
        return "inner", "outer", "bottom", "top"

    def axes(self) -> tuple[Axis, ...]:
        """Around, through, along."""
        around = Axis(self.seam, self.seam + 2.0 * math.pi, self.outer, 8)
        half = 0.5 * self.length
        return around, Axis(self.inner, self.outer, 1.0, 1), Axis(-half, half, 1.0, 1)

    def onto(self, place: FloatArray) -> FloatArray:
        """Into the wall, then to the nearest of its four sides."""
        angle, half = math.atan2(place[1], place[0]), 0.5 * self.length
        r = float(np.clip(math.hypot(place[0], place[1]), self.inner, self.outer))
        z = float(np.clip(place[2], -half, half))
        ends = [(self.inner, z), (self.outer, z), (r, -half), (r, half)]
        r, z = min(ends, key=lambda end: abs(end[0] - r) + abs(end[1] - z))
        return np.array([r * math.cos(angle), r * math.sin(angle), z])

    def pulled(self, place: FloatArray) -> list[tuple[int, float, float, float]]:
        """Lines around come back to the place."""
        r, turn = math.hypot(place[0], place[1]), 2.0 * math.pi
        ahead = (math.atan2(place[1], place[0]) - self.seam) % turn
        around = [(0, self.seam + ahead + turns * turn, 0.0, r) for turns in (-1, 0, 1)]
        return [*around, (1, r, 0.0, 1.0), (2, float(place[2]), 0.0, 1.0)]

    def count(self, elements: Sequence[int]) -> int:
        """Around, through, along."""
        return math.prod(elements)

    def mesh(self, lines: Sequence[FloatArray]) -> Mesh:
        """A grid whose last angle is its first."""
        angle, radius, z = lines
        polar, numbers = grid([angle[:-1], radius, z])
        places = np.stack([polar[:, 1] * np.cos(polar[:, 0]), polar[:, 1] * np.sin(polar[:, 0]), polar[:, 2]], axis=1)
        cells = grid_cells(np.concatenate([numbers, numbers[:1]]).transpose(1, 0, 2))
        names, of = ("inner", "outer", "bottom", "top"), (polar[:, 1], polar[:, 1], polar[:, 2], polar[:, 2])
        ends = radius[0], radius[-1], z[0], z[-1]
        on = {name: values == end for name, values, end in zip(names, of, ends, strict=True)}
        return with_faces(places, cells, on)


@dataclass(frozen=True, slots=True, eq=False)
class Round:
    """A ball, or a disc times |z| <= length / 2.

    Directions: those of the core, z of a cylinder, and through the layers around the core, 0 on it and 1 outside.
    ``turn`` (d, d) has the axes of the core as columns.
    """

    map: RoundMap
    length: float
    turn: FloatArray

    def turned_to(self, place: FloatArray) -> Round:
        """With the nearest axis of the core turned towards a place: lines that are close there are so there alone."""
        d = self.map.d
        size = float(np.linalg.norm(place[:d]))
        if size == 0.0:
            return self
        b, k = place[:d] / size, int(np.abs(place[:d]).argmax())
        a = math.copysign(1.0, place[k]) * np.eye(d)[k]
        about = np.outer(b, a) - np.outer(a, b)
        return replace(self, turn=np.eye(d) + about + about @ about / (1.0 + float(a @ b)))

    def shells(self, spot: Spot, size: float) -> list[Grid]:
        """Of a ball."""
        R = self.map.radius
        within = max(spot.radius, math.ceil(R / size) * spot.finest)  # no smaller for being as many as at the antipode
        if self.map.d == 2 or ROUND * within > 2.0 * R:
            return []
        k = int(np.abs(spot.place).argmax())
        axes = np.roll(self.turned_to(spot.place).turn, 2 - k, axis=1)  # the last one from the place or towards it
        axes = axes[:, [1, 0, 2]] * [1.0, 1.0, -1.0] if spot.place[k] > 0.0 else axes
        return [PolarBall(R, spot.radius, within, axes)]

    def names(self) -> tuple[str, ...]:
        """Names: "surface", or "side" to "top"."""
        return ("surface",) if self.map.d == 3 else ("side", "bottom", "top")

    def axes(self) -> tuple[Axis, ...]:
        """Lines of the core are closest where they reach the round surface; two elements there make eight around."""
        half = 0.5 * self.length
        core = [Axis(-1.0, 1.0, 0.25 * math.pi * self.map.radius, 2)] * self.map.d
        along = [Axis(-half, half, 1.0, 1)] * (3 - self.map.d)
        return *core, *along, Axis(0.0, 1.0, (1.0 - CORE) * self.map.radius, 1)

    def onto(self, place: FloatArray) -> FloatArray:
        """Onto the round surface or an end, whichever is nearer."""
        R, half, d = self.map.radius, 0.5 * self.length, self.map.d
        r, there = math.hypot(*place[:d]), place.copy()
        there[d:] = np.clip(place[d:], -half, half)
        if d == 2 and half - abs(there[2]) < R - r:
            there[2] = math.copysign(half, there[2])
            return there
        there[:d] = R * place[:d] / r if r > 0.0 else R * np.eye(d)[0]
        return there

    def pulled(self, place: FloatArray) -> list[tuple[int, float, float, float]]:
        """Lines of the core and of the layers, and those of z."""
        found = self.map.pulled(place[: self.map.d] @ self.turn)
        along = [(2, float(z), 0.0, 1.0) for z in place[self.map.d :]]
        return along + [(k if k < self.map.d else 3, at, away, metric) for k, at, away, metric in found]

    def count(self, elements: Sequence[int]) -> int:
        """Those of the core, and layers on its sides."""
        nx, ny, nz, layers = elements
        around = 2 * (nx + ny) * nz + (2 * nx * ny if self.map.d == 3 else 0)
        return nx * ny * nz + layers * around

    def mesh(self, lines: Sequence[FloatArray]) -> Mesh:
        """A grid for the core, and its sides drawn outwards."""
        *core, through = lines
        q, numbers = grid(core)
        cells = grid_cells(numbers)
        quads, d = boundary_quads(cells), self.map.d
        on_side = np.abs(q[:, :d]) == 1.0
        quads = quads[on_side[quads].all(axis=1).any(axis=1)]
        cells, below = layered(cells, quads, len(through) - 1)
        q = np.concatenate([q, *[q[below]] * (len(through) - 1)])
        t = np.repeat(through, [len(q) - len(below) * (len(through) - 1), *[len(below)] * (len(through) - 1)])
        places = np.hstack([self.map.places(q[:, :d], t) @ self.turn.T, q[:, d:]])
        if d == 3:
            return with_faces(places, cells, {"surface": t == 1.0})
        ends = lines[2][0], lines[2][-1]
        return with_faces(places, cells, {"side": t == 1.0, "bottom": q[:, 2] == ends[0], "top": q[:, 2] == ends[1]})
