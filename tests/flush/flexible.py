"""Flexible blocks and bars whose meshes are their surfaces, on each other and end to end."""

from __future__ import annotations

from functools import cache
from itertools import product
from typing import Any

import numpy as np

import lcpflex as lf
from tests.flush.places import Place
from tests.flush.scenes import level, on_floor
from tests.solids import block

__all__ = ["bars", "blocks", "skin"]

SOFT = {"density": 1000.0, "youngs_modulus": 2e8}


def skin(places: Any, cells: tuple[int, int, int]) -> Any:
    """(k, 3) triangles of the surface of a block of so many cells, seen counter-clockwise from outside."""
    low = places.min(axis=0)
    step = (places.max(axis=0) - low) / cells
    node = {tuple(at): k for k, at in enumerate(np.rint((places - low) / step).astype(int).tolist())}
    found = []
    for axis, end in product(range(3), (0, 1)):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        for i, j in product(range(cells[u]), range(cells[v])):
            ring = []
            for a, b in ((0, 0), (1, 0), (1, 1), (0, 1)):
                at = [0, 0, 0]
                at[axis], at[u], at[v] = end * cells[axis], i + a, j + b
                ring.append(node[tuple(at)])
            ring = ring if end else ring[::-1]
            found += [ring[:3], [ring[0], ring[2], ring[3]]]
    return np.array(found)


@cache
def solid(edges: tuple[float, float, float], cells: tuple[int, int, int], modes: int) -> lf.SpatialBody:
    """A block with its origin in its middle."""
    made = block(edges, cells, "hex1", **SOFT)
    made["coordinates"] = made["coordinates"] - 0.5 * np.array(edges)
    return lf.SpatialMatrices(**made, triangles=skin(made["coordinates"], cells)).reduce(modes=modes, damping=0.05)


def blocks(place: Place) -> lf.SpatialScene:
    """ "up" on "low" on a floor, undeformed."""
    scene, body = level(), solid((0.2, 0.2, 0.1), (3, 3, 2), 8)
    low = scene.add(body, "low", position=(0.0, 0.0, 0.05))
    up = scene.add(body, "up", place.at(0.2, 0.0, 0.15), place.turn())
    on_floor(scene, 0.5, "low")
    scene.contact(up.surface(), low.surface(), friction=0.5, name="up/low")
    return scene


def bars(place: Place) -> lf.SpatialScene:
    """A bar meets an equal one at rest, end to end and without gravity."""
    scene, body = level(0.0), solid((0.02, 0.02, 0.2), (2, 2, 8), 12)
    low = scene.add(body, "low", position=(0.0, 0.0, 0.1))
    up = scene.add(body, "up", place.at(0.02, 0.0, 0.3 + 1e-6), place.turn(), velocity=(0.0, 0.0, -1.0))
    scene.contact(up.surface(), low.surface(), name="up/low")
    return scene
