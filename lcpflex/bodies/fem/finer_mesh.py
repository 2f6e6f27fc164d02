"""The next finer mesh of the same body: quadratic elements for linear ones, 2^d for each quadratic one."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np

from lcpflex.bodies.fem.assembly import reference_corners, shape_functions
from lcpflex.bodies.fem.mesh import KINDS, Kind, Mesh
from lcpflex.jit.kernel import FloatArray, IntArray

__all__ = ["finer"]

RAISED = {"triangle": "triangle6", "quad": "quad9", "tetra": "tetra10", "hexahedron": "hexahedron27"}
FULL = {"hexahedron20": "hexahedron27"}  # of parts of an element: those of 20 nodes have no nodes amid their faces
GRID = 8  # parts of an edge in which places are counted: a node amid half an edge is at 2 of them
# Corners of the parts of a simplex, each amid two of its corners (twice the same: that corner). The octahedron that is
# left amid a tetrahedron is cut in four along the line from the middle of 0-2 to that of 1-3.
PARTS_OF_TRIANGLE = (
    ((0, 0), (0, 1), (0, 2)),
    ((0, 1), (1, 1), (1, 2)),
    ((0, 2), (1, 2), (2, 2)),
    ((0, 1), (1, 2), (0, 2)),
)
PARTS_OF_TETRA = (
    ((0, 0), (0, 1), (0, 2), (0, 3)),
    ((0, 1), (1, 1), (1, 2), (1, 3)),
    ((0, 2), (1, 2), (2, 2), (2, 3)),
    ((0, 3), (1, 3), (2, 3), (3, 3)),
    ((0, 2), (1, 3), (0, 1), (1, 2)),
    ((0, 2), (1, 3), (1, 2), (2, 3)),
    ((0, 2), (1, 3), (2, 3), (0, 3)),
    ((0, 2), (1, 3), (0, 3), (0, 1)),
)


def finer(mesh: Mesh) -> Mesh:
    """A mesh of quadratic elements on the same body, without groups: one for each linear element, or four (in space
    eight) for each quadratic one; curved edges stay as they are.
    """
    kind = mesh.kind
    corners = reference_corners(kind)
    wanted = KINDS[FULL.get(kind.name, RAISED.get(kind.name, kind.name))]
    parts = _parts(kind) if kind.quadratic else corners[None]
    spots = np.stack([parts[:, list(amid)].mean(axis=1) for amid in wanted.middles], axis=1)  # (parts, nodes, d)
    at, number = np.unique(
        np.rint(GRID * spots.reshape(-1, kind.dimension)).astype(np.int64), axis=0, return_inverse=True
    )
    nodes, places = _nodes(mesh, at / GRID)
    cells = nodes[:, number.ravel()].reshape(-1, wanted.nodes)
    used, cells = np.unique(cells, return_inverse=True)
    return replace(mesh, kind=wanted, places=places[used], cells=cells.reshape(-1, wanted.nodes), groups={}, faces={})


def _parts(kind: Kind) -> FloatArray:
    """(2^d, corners, d) corners of the parts of the reference element."""
    corners = reference_corners(kind)
    if kind.simplex:
        table = PARTS_OF_TRIANGLE if kind.dimension == 2 else PARTS_OF_TETRA
        return np.array([[corners[list(pair)].mean(axis=0) for pair in part] for part in table])
    origins = np.array(list(itertools.product((0.0, 0.5), repeat=kind.dimension)))
    return np.asarray(origins[:, None] + 0.5 * corners)


def _nodes(mesh: Mesh, spots: FloatArray) -> tuple[IntArray, FloatArray]:
    """(m, s) numbers of nodes at the spots (s, d) of each element, and their places.

    Two elements have the same node at a spot of a facet that they share, whose place is the same mean of its corners.
    """
    kind = mesh.kind
    shares = np.rint(GRID**kind.dimension * shape_functions(kind.linear, spots.T)[0]).astype(np.int64)
    corners = mesh.cells[:, None, : kind.corners]
    key = np.where(shares > 0, corners * (GRID**kind.dimension + 1) + shares, -1)
    key = np.sort(key, axis=2).reshape(-1, kind.corners)
    number = key[:, 0]
    for column in key.T[1:]:  # numbered anew each time: products of keys would overflow
        both = np.stack([number, column], axis=1)
        number = np.unique(both, axis=0, return_inverse=True)[1].ravel()
    number = np.unique(number, return_inverse=True)[1]
    places = np.empty((int(number.max()) + 1, kind.dimension))
    N = shape_functions(kind, spots.T)[0]
    places[number.ravel()] = np.einsum("qn,mni->mqi", N, mesh.places[mesh.cells]).reshape(-1, kind.dimension)
    return number.reshape(len(mesh.cells), len(spots)), places
