"""Handles of the bodies and the ground of a spatial scene: their points."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from operator import methodcaller
from typing import TYPE_CHECKING

import numpy as np

from lcpflex.basics.arguments import absent
from lcpflex.bodies.placed_point import PlacedPoint
from lcpflex.bodies.spatial.body import SpatialPoint
from lcpflex.errors import ModelError, in_range, shown

if TYPE_CHECKING:
    from lcpflex.bodies.spatial.body import SpatialBody
    from lcpflex.jit.kernel import FloatArray

__all__ = ["SpatialPlaced"]


@dataclass(frozen=True, slots=True, eq=False)
class SpatialPlaced:
    """A body in a spatial scene, or its ground. Places are in the body frame, undeformed (on the ground: world) [m].

    Made by ``scene.add(...)`` and ``scene.ground``, not by hand. Every method raises ModelError for an unknown name, a
    place off a flexible body, and numbers that cannot be.
    """

    name: str
    body: int  # index in the scene, -1 for the ground
    source: SpatialBody | None = field(repr=False)  # None for the ground
    start: tuple[FloatArray, FloatArray] = field(repr=False)  # (7 + n,) configuration and (6 + n,) velocity
    scene: object = field(repr=False)

    def point(self, name: str) -> PlacedPoint:
        """A named point of the body."""
        known = {} if self.source is None else self.source.points
        if not isinstance(name, str) or name not in known:
            raise ModelError(f"name: {shown(self.name)} has no point {absent(name, known)}")
        return PlacedPoint(self.scene, self.body, f"{self.name}.{name}", known[name], methodcaller("point", name))

    def at_nodes(self, nodes: Sequence[int] | int, weights: Sequence[float] | None = None) -> PlacedPoint:
        """The point that stands for nodes of the mesh of a flexible body: see :meth:`SpatialBody.at_nodes`."""
        if self.source is None:
            raise ModelError("nodes: the ground has no mesh, expected a body of SpatialMatrices")
        material = self.source.at_nodes(nodes, weights)
        label = f"{self.name}.at_nodes({shown(np.asarray(nodes).tolist())})"
        return PlacedPoint(self.scene, self.body, label, material, methodcaller("at_nodes", nodes, weights))

    def at(self, x: float, y: float, z: float) -> PlacedPoint:
        """The material point at (x, y, z)."""
        place = [in_range(axis, value, -math.inf, math.inf) for axis, value in zip("xyz", (x, y, z), strict=True)]
        if self.source is None:
            material = SpatialPoint(np.array(place), np.zeros((0, 3)), np.zeros((0, 3)))
        else:
            material = self.source.locate(*place)
        label = f"{self.name}.at({', '.join(f'{value:g}' for value in place)})"
        return PlacedPoint(self.scene, self.body, label, material, methodcaller("at", *place))
