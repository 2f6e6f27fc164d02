"""Facets of a surface as a user gives them: their nodes must come in the order that normals and shapes follow from."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from lcpflex.basics import libs
from lcpflex.bodies.fem.sparse_factor import links
from lcpflex.errors import ModelError
from lcpflex.jit.kernel import FloatArray, IntArray

if TYPE_CHECKING:
    from scipy.sparse import csc_matrix

__all__ = ["check_facets"]

BESIDE = 0.3  # of an edge: from its middle to the node amid it; on an arc of 120 degrees that is .29
FLATTENED = 1e-6  # of the square of its longest edge: what is less at a corner is rounding of places to six digits
OF_ELEMENT = 40  # nodes besides those of a facet: elements have 18, condensed matrices all, which tells no side
INSIDE = 1e-6  # of the size of a facet: how far, on average, nodes of its element are in front of it by rounding


def check_facets(faces: Mapping[str, IntArray], stiffness: csc_matrix[Any], places: FloatArray) -> None:
    """Raise ModelError for facets (F, k) with nodes in another order, flattened, or clockwise seen from outside.

    Outside is where the element is not: nodes that share entries of the stiffness with all nodes of a facet are its.
    """
    if not faces:
        return
    graph = links(stiffness, np.arange(len(places)).repeat(3), len(places))
    graph.data[:] = 1.0
    for name, facets in faces.items():
        corners = 3 if facets.shape[1] in (3, 6) else 4
        _check_amid(name, facets, corners, places)
        _check_convex(name, facets, corners, places)
        _check_turn(name, facets, corners, places, graph)


def _check_convex(name: str, facets: IntArray, corners: int, places: FloatArray) -> None:
    """Corners go around: of crossed, concave and flattened facets the area is none of a surface."""
    x = places[facets[:, :corners]]
    ahead, back = np.roll(x, -1, axis=1) - x, np.roll(x, 1, axis=1) - x
    turn = np.cross(ahead, back)
    size = np.maximum((ahead**2).sum(axis=2), (back**2).sum(axis=2)).max(axis=1)
    mean = turn.mean(axis=1)
    normal = mean / np.maximum(np.linalg.norm(mean, axis=1), np.finfo(np.float64).tiny)[:, None]
    wrong = np.flatnonzero(np.einsum("ikj,ij->ik", turn, normal).min(axis=1) <= FLATTENED * size)
    if len(wrong):
        raise ModelError(
            f"faces[{name!r}]: facet {wrong[0]} has nodes {facets[wrong[0], :corners].tolist()} as corners, which are "
            "crossed, on one line, or turn inwards at one of them, expected those of a convex facet, one after another "
            "around it"
        )


def _check_amid(name: str, facets: IntArray, corners: int, places: FloatArray) -> None:
    """Nodes amid edges, and the middle, are near where they belong."""
    first = places[facets[:, :corners]]
    after = np.roll(first, -1, axis=1)
    length = np.linalg.norm(after - first, axis=2)
    wanted, size = 0.5 * (first + after), length
    if facets.shape[1] == 9:
        wanted = np.concatenate([wanted, first.mean(axis=1)[:, None]], axis=1)
        size = np.concatenate([size, length.max(axis=1)[:, None]], axis=1)
    amid = places[facets[:, corners:]]
    if not amid.shape[1]:
        return
    off = np.linalg.norm(amid - wanted, axis=2) > BESIDE * size
    if off.any():
        facet = int(off.any(axis=1).argmax())
        node = int(facets[facet, corners + int(off[facet].argmax())])
        raise ModelError(
            f"faces[{name!r}]: node {node} of facet {facet} is not near the middle of its edge, expected the corners "
            "first, then the nodes amid edges, that between the first two corners before the others, then the middle"
        )


def _check_turn(name: str, facets: IntArray, corners: int, places: FloatArray, graph: csc_matrix[Any]) -> None:
    """Elements are behind their facets."""
    count, k = facets.shape
    rows = np.repeat(np.arange(count), k)
    own = libs.sparse.csr_matrix((np.ones(count * k), (rows, facets.ravel())), shape=(count, len(places)))
    shared = (own @ graph).tocoo()
    whole = shared.data > k - 0.5
    facet, node = shared.row[whole], shared.col[whole]
    x = places[facets[:, :corners]]
    normal = np.cross(x[:, 1] - x[:, -1], x[:, 2] - x[:, 0])
    size = np.sqrt(np.linalg.norm(normal, axis=1))
    normal /= np.maximum(size * size, np.finfo(np.float64).tiny)[:, None]
    height = np.einsum("ij,ij->i", places[node] - x.mean(axis=1)[facet], normal[facet])
    others = ~np.isin(facet * len(places) + node, rows * len(places) + facets.ravel())
    number = np.bincount(facet[others], minlength=count)
    mean = np.bincount(facet[others], height[others], count) / np.maximum(number, 1)
    wrong = np.flatnonzero((mean > INSIDE * size) & (number <= OF_ELEMENT))
    if len(wrong):
        raise ModelError(
            f"faces[{name!r}]: {len(wrong)} facet(s) are clockwise seen from outside (the first one is {wrong[0]}), "
            "expected their corners counter-clockwise"
        )
