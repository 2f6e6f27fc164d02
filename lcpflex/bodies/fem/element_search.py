"""Where a place lies in a mesh: its element and the shape functions there."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from lcpflex.bodies.fem.assembly import shape_functions
from lcpflex.bodies.fem.mesh import Mesh
from lcpflex.errors import ModelError
from lcpflex.jit.kernel import FloatArray, IntArray

__all__ = ["locator"]

INSIDE = 1e-6  # of an element, beyond its edge: still on it
ITERATIONS = 20
ROUNDING = 1e-12  # of weights


def locator(mesh: Mesh, edges: FloatArray) -> Callable[..., tuple[IntArray, FloatArray]]:
    """(x, y) or (x, y, z) -> nodes (k,) and weights (k,) of the material there; raises ModelError off the mesh.

    edges: (k, 2, d) both ends of straight pieces of the boundary, on which the nearest place is told.
    """
    of_cells = mesh.places[mesh.cells]
    low, high = of_cells.min(axis=1), of_cells.max(axis=1)
    margin = 0.05 * (high - low).max(axis=1, keepdims=True)  # a curved edge reaches beyond its nodes
    return partial(_locate, mesh, edges, (low - margin, high + margin))


def _locate(
    mesh: Mesh, edges: FloatArray, boxes: tuple[FloatArray, FloatArray], *at: float
) -> tuple[IntArray, FloatArray]:
    """See :func:`locator`; ``boxes`` of the elements: (elements, d) least and largest coordinates."""
    place = np.array(at)
    low, high = boxes
    near = np.flatnonzero(((low <= place) & (place <= high)).all(axis=1))
    for cell in near:
        weights = _weights(mesh, mesh.places[mesh.cells[cell]], place)
        if weights is not None:
            return mesh.cells[cell], weights
    given, nearest = (f"({', '.join(f'{value:.9g}' for value in one)})" for one in (place, _nearest(edges, place)))
    raise ModelError(
        f"{', '.join('xyz'[: len(at)])}: {given} was given, expected a place on the body; {nearest} is nearest"
    )


def _weights(mesh: Mesh, nodes: FloatArray, place: FloatArray) -> FloatArray | None:
    """(k,) shape functions at the place, by Newton's method; None outside of the element."""
    d = mesh.kind.dimension
    simplex = mesh.kind.simplex
    X = np.full(d, 1.0 / (d + 1) if simplex else 0.5)
    size = np.ptp(nodes, axis=0).max()
    for _ in range(ITERATIONS):
        N, dN = shape_functions(mesh.kind, X[:, None])
        miss = place - N[0] @ nodes
        if np.abs(miss).max() <= 1e-13 * size:
            break
        X = X + np.clip(np.linalg.lstsq((dN[0].T @ nodes).T, miss, rcond=None)[0], -1.0, 1.0)
    beyond = max(-X.min(), (X.sum() if simplex else X.max()) - 1.0)
    if beyond > INSIDE or np.abs(miss).max() > 1e-9 * size:
        return None
    return np.where(np.abs(N[0]) > ROUNDING, N[0], 0.0)  # on an edge, nodes off it have no part: an axis stays straight


def _nearest(edges: FloatArray, place: FloatArray) -> FloatArray:
    """The place on the edges that is nearest."""
    starts = edges[:, 0]
    along = edges[:, 1] - starts
    share = np.clip(((place - starts) * along).sum(axis=1) / (along**2).sum(axis=1), 0.0, 1.0)
    feet = starts + share[:, None] * along
    return np.asarray(feet[np.linalg.norm(feet - place, axis=1).argmin()])
