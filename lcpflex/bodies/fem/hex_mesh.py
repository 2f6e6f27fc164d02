"""Meshes of 8-node hexahedra: grids, layers around them, and the quadrilaterals of their boundary."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from typing import Any, TypeAlias

import numpy as np

from lcpflex.bodies.fem.mesh import KINDS, Mesh
from lcpflex.jit.kernel import FloatArray, IntArray

__all__ = ["BoolArray", "boundary_quads", "grid", "grid_cells", "layered", "with_faces"]

BoolArray: TypeAlias = np.ndarray[Any, np.dtype[np.bool_]]

HEXAHEDRON = KINDS["hexahedron"]


def grid(lines: Sequence[FloatArray]) -> tuple[FloatArray, IntArray]:
    """(N, 3) coordinates of the crossings of lines, and their numbers (nx + 1, ny + 1, nz + 1)."""
    places = np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1).reshape(-1, 3)
    return places, np.arange(len(places)).reshape([len(line) for line in lines])


def grid_cells(numbers: IntArray) -> IntArray:
    """(m, 8) the elements of a grid whose nodes have the numbers (nx + 1, ny + 1, nz + 1)."""
    low, high = slice(None, -1), slice(1, None)
    around = ((low, low), (high, low), (high, high), (low, high))
    corners = [numbers[i, j, k] for k in (low, high) for i, j in around]
    return np.stack([corner.ravel() for corner in corners], axis=1)


def boundary_quads(cells: IntArray) -> IntArray:
    """(k, 4) nodes of the faces of one element alone, counter-clockwise seen from outside."""
    quads = cells[:, np.array(HEXAHEDRON.facets)].reshape(-1, 4)
    first = quads.argmin(axis=1)
    rows = np.arange(len(quads))
    key = quads[rows, first] * (int(cells.max()) + 1) + quads[rows, (first + 2) % 4]  # of a diagonal: one quad has it
    _, place, uses = np.unique(key, return_index=True, return_counts=True)
    return np.asarray(quads[np.sort(place[uses == 1])])


def layered(cells: IntArray, quads: IntArray, layers: int) -> tuple[IntArray, IntArray]:
    """The elements of a mesh with layers of elements on some quadrilaterals of its boundary, and the nodes below them.

    Nodes (s,) that the quadrilaterals have come again in each layer, in their order, after those of the mesh.
    """
    below, number = np.unique(quads, return_inverse=True)
    number, count = number.reshape(quads.shape), int(cells.max()) + 1
    levels = [quads, *(count + layer * len(below) + number for layer in range(layers))]
    shell = [np.hstack([inner, outer]) for inner, outer in itertools.pairwise(levels)]
    return np.concatenate([cells, *shell]), below


def with_faces(places: FloatArray, cells: IntArray, on: Mapping[str, BoolArray]) -> Mesh:
    """The mesh with its boundary in faces, each of the quadrilaterals all nodes of which are marked, (N,) bool."""
    quads = boundary_quads(cells)
    faces = {name: quads[marked[quads].all(axis=1)] for name, marked in on.items()}
    return Mesh(HEXAHEDRON, places, cells, faces=faces)
