"""Bodies of space whose faces are split into triangles: rigid ones, and blocks of hexahedra that deform."""

from __future__ import annotations

from typing import Any

import numpy as np

import lcpflex as lf
from lcpflex.bodies.spatial.shapes import SurfaceShape
from tests.solids import block

Array = Any


def split_faces(cells: tuple[int, int, int]) -> tuple[Array, Array]:
    """(k, 3) whole numbers of the vertices on the surface of a block of cells, and its triangles, seen from outside.

    Diagonals of neighbouring cells cross, so that rays from the middles of triangles meet edges on the other side.
    """
    number: dict[tuple[int, ...], int] = {}
    triangles = []
    for axis in range(3):
        first, second = (k for k in range(3) if k != axis)
        for side in (0, cells[axis]):
            for i, j in np.ndindex(cells[first], cells[second]):
                corners = []
                for x, y in ((0, 0), (1, 0), (1, 1), (0, 1)):
                    place = [0, 0, 0]
                    place[axis], place[first], place[second] = side, i + x, j + y
                    corners.append(number.setdefault(tuple(place), len(number)))
                if (axis == 1) != (side == 0):
                    corners = corners[::-1]
                a, b, c, d = corners[(i + j) % 2 :] + corners[: (i + j) % 2]
                triangles += [(a, b, c), (a, c, d)]
    return np.array(list(number)), np.array(triangles)


def solid(vertices: Array, triangles: Array, mass: float = 1.0) -> tuple[lf.SpatialBody, Array]:
    """A homogeneous rigid body with this surface, in a frame at its mass centre, and the place of that."""
    corners = vertices[triangles]
    volumes = np.linalg.det(corners) / 6.0
    centre = volumes @ corners.sum(axis=1) / 4.0 / volumes.sum()
    corners = corners - centre
    volumes = np.linalg.det(corners) / 6.0
    second = np.zeros((3, 3))
    for volume, tetrahedron in zip(volumes, corners, strict=True):
        total = tetrahedron.sum(axis=0)
        second += volume / 20.0 * (np.outer(total, total) + tetrahedron.T @ tetrahedron)
    second *= mass / volumes.sum()
    shape = SurfaceShape(vertices - centre, triangles, np.zeros((len(vertices), 0, 3)))
    return lf.SpatialBody(mass=mass, inertia=np.trace(second) * np.eye(3) - second, shape=shape), centre


def split_box(
    edges: tuple[float, float, float], cells: tuple[int, int, int], uneven: float = 0.0, seed: int = 0
) -> lf.SpatialBody:
    """A rigid box about its centre, its vertices off their places by up to ``uneven`` [m] in each direction."""
    places, triangles = split_faces(cells)
    vertices = (places / np.array(cells) - 0.5) * np.array(edges)
    vertices += np.random.default_rng(seed).uniform(-uneven, uneven, vertices.shape)
    return solid(vertices, triangles)[0]


def soft_block(
    edges: tuple[float, float, float], cells: tuple[int, int, int], modes: int, damping: float = 0.0, **material: float
) -> lf.SpatialBody:
    """A block of linear hexahedra about its centre, the faces of which are its surface."""
    made = block(edges, cells, "hex1", **material)
    coordinates = made["coordinates"]
    counted = np.rint(coordinates / np.array(edges) * np.array(cells)).astype(int)
    node = {tuple(p): k for k, p in enumerate(counted.tolist())}
    places, triangles = split_faces(cells)
    on_surface = np.array([node[tuple(p)] for p in places.tolist()])
    centred = {**made, "coordinates": coordinates - 0.5 * np.array(edges)}
    return lf.SpatialMatrices(**centred, triangles=on_surface[triangles]).reduce(modes=modes, damping=damping)
