"""Where a place lies in a planar mesh: its element and the shape functions there."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from lcpflex.bodies.fem.assembly import shape_functions
from lcpflex.bodies.fem.boundary import Boundary
from lcpflex.bodies.fem.planar_mesh import PlanarMesh
from lcpflex.errors import ModelError
from lcpflex.jit.kernel import FloatArray, IntArray

__all__ = ["locator"]

INSIDE = 1e-6  # of an element, beyond its edge: still on it
ITERATIONS = 20
ROUNDING = 1e-12  # of weights


def locator(mesh: PlanarMesh, boundary: Boundary) -> Callable[[float, float], tuple[IntArray, FloatArray]]:
    """(x, y) -> nodes (k,) and weights (k,) of the material there; raises ModelError off the mesh."""
    of_cells = mesh.places[mesh.cells]
    low, high = of_cells.min(axis=1), of_cells.max(axis=1)
    margin = 0.05 * (high - low).max(axis=1, keepdims=True)  # a curved edge reaches beyond its nodes
    return partial(_locate, mesh, boundary, (low - margin, high + margin))


def _locate(
    mesh: PlanarMesh, boundary: Boundary, boxes: tuple[FloatArray, FloatArray], x: float, y: float
) -> tuple[IntArray, FloatArray]:
    """See :func:`locator`; ``boxes`` of the elements: (elements, 2) least and largest coordinates."""
    place = np.array([x, y])
    low, high = boxes
    near = np.flatnonzero(((low <= place) & (place <= high)).all(axis=1))
    for cell in near:
        weights = _weights(mesh, mesh.places[mesh.cells[cell]], place)
        if weights is not None:
            return mesh.cells[cell], weights
    nearest = _nearest(mesh, boundary, place)
    raise ModelError(
        f"x, y: ({x:.9g}, {y:.9g}) was given, expected a place on the body; "
        f"({nearest[0]:.9g}, {nearest[1]:.9g}) is nearest"
    )


def _weights(mesh: PlanarMesh, nodes: FloatArray, place: FloatArray) -> FloatArray | None:
    """(k,) shape functions at the place, by Newton's method; None outside of the element."""
    triangle = mesh.kind.corners == 3
    X = np.full(2, 1.0 / 3.0 if triangle else 0.5)
    size = np.ptp(nodes, axis=0).max()
    for _ in range(ITERATIONS):
        N, dN = shape_functions(mesh, X[:, None])
        miss = place - N[0] @ nodes
        if np.abs(miss).max() <= 1e-13 * size:
            break
        X = X + np.clip(np.linalg.lstsq((dN[0].T @ nodes).T, miss, rcond=None)[0], -1.0, 1.0)
    beyond = max(-X.min(), (X.sum() if triangle else X.max()) - 1.0)
    if beyond > INSIDE or np.abs(miss).max() > 1e-9 * size:
        return None
    return np.where(np.abs(N[0]) > ROUNDING, N[0], 0.0)  # on an edge, nodes off it have no part: an axis stays straight


def _nearest(mesh: PlanarMesh, boundary: Boundary, place: FloatArray) -> FloatArray:
    """The place on the boundary that is nearest, edges taken as straight from node to node."""
    starts = np.concatenate([mesh.places[loop] for loop in boundary.loops])
    ends = np.concatenate([np.roll(mesh.places[loop], -1, axis=0) for loop in boundary.loops])
    along = ends - starts
    share = np.clip(((place - starts) * along).sum(axis=1) / (along**2).sum(axis=1), 0.0, 1.0)
    feet = starts + share[:, None] * along
    return np.asarray(feet[np.hypot(*(feet - place).T).argmin()])
