"""Whether triangles are the whole boundary of a solid, seen from outside."""

from __future__ import annotations

from typing import NoReturn

import numpy as np

from lcpflex.basics import libs
from lcpflex.errors import ModelError
from lcpflex.jit.kernel import FloatArray, IntArray

__all__ = ["FLAT", "SIDES", "check_closed", "check_turned", "is_closed", "passed_edges"]

FLAT = 1e-12  # of the squared extent: twice the area of a triangle that has no normal
SIDES = ((0, 1), (1, 2), (2, 0))


def check_closed(name: str, vertices: FloatArray, triangles: IntArray) -> None:
    """Raise ModelError for triangles (T, 3) of vertices (N, 3) that no solid lies behind.

    As :func:`check_turned`; and each edge must belong to two of them, and the volume that they enclose, sum of
    det(a, b, c) / 6, be positive: counter-clockwise seen from outside.
    """
    check_turned(name, vertices, triangles)
    edges, there, back = passed_edges(triangles)
    lonely = np.flatnonzero(~np.isin(back, there))
    if len(lonely):
        _refuse_open(name, vertices, edges[lonely])
    middle = vertices[triangles.ravel()].mean(axis=0)
    volume = float(np.linalg.det(vertices[triangles] - middle).sum()) / 6.0
    if not volume > 0.0:
        raise ModelError(
            f"{name}: its triangles enclose {volume:.3g} m^3, expected a positive volume: counter-clockwise seen from "
            "outside, in a right-handed frame"
        )


def check_turned(name: str, vertices: FloatArray, triangles: IntArray) -> None:
    """Raise ModelError for triangles (T, 3) of vertices (N, 3) that are no surface, open or closed, with one outside.

    Each must have an area, and each edge belong to two of them at most, that pass it opposite ways.
    """
    corners = vertices[triangles]
    extent = float(np.ptp(vertices[triangles.ravel()], axis=0).max())
    double = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    flat = np.flatnonzero(~(double > FLAT * extent**2))
    if len(flat):
        raise ModelError(
            f"{name}: triangle {flat[0]} of vertices {triangles[flat[0]].tolist()} has twice the area "
            f"{double[flat[0]]:.3g} m^2, expected one with a normal"
        )
    _, there, _ = passed_edges(triangles)
    _, first, count = np.unique(there, return_index=True, return_counts=True)
    if (count > 1).any():
        _refuse_shared(name, vertices, triangles, int(first[count > 1][0]))


def is_closed(triangles: IntArray) -> bool:
    """Whether each edge belongs to two triangles (T, 3) that pass it opposite ways."""
    _, there, back = passed_edges(triangles)
    there = np.sort(there)
    return bool((np.diff(there) > 0).all()) and np.array_equal(there, np.sort(back))


def passed_edges(triangles: IntArray) -> tuple[IntArray, IntArray, IntArray]:
    """(3 T, 2) the edges of triangles, all first ones before all second ones; a number for each, and for its other way.

    Edge k is one of triangle k modulo T.
    """
    edges = np.concatenate([triangles[:, list(side)] for side in SIDES])
    size = int(triangles.max()) + 1
    return edges, edges @ np.array([size, 1]), edges @ np.array([1, size])


def _refuse_shared(name: str, vertices: FloatArray, triangles: IntArray, edge: int) -> NoReturn:
    """An edge of more than two triangles, or of two that are not turned alike."""
    edges, there, back = passed_edges(triangles)
    a, b = edges[edge].tolist()
    x, y, z = 0.5 * (vertices[a] + vertices[b])
    at = f"the edge {(a, b)} at ({x:.4g}, {y:.4g}, {z:.4g})"
    of_it = (there == there[edge]) | (back == there[edge])
    if of_it.sum() > 2:
        raise ModelError(f"{name}: {of_it.sum()} triangles share {at}, expected two at each edge of a solid's boundary")
    numbers, uses = np.unique(there, return_counts=True)
    turned = np.isin(there, numbers[uses > 1]).reshape(3, -1).sum(axis=0)  # of a triangle that is turned alone: 3
    raise ModelError(
        f"{name}: two triangles pass {at} in the same direction, so that one is turned around (triangle "
        f"{turned.argmax()} at {turned.max()} edges), expected opposite ones: all counter-clockwise seen from outside"
    )


def _refuse_open(name: str, vertices: FloatArray, edges: IntArray) -> NoReturn:
    """Edges (k, 2) of one triangle alone: around a hole, or several."""
    nodes, ends = np.unique(edges, return_inverse=True)
    ends, shape = ends.reshape(edges.shape), (len(nodes), len(nodes))
    graph = libs.sparse.coo_matrix((np.ones(len(ends)), (ends[:, 0], ends[:, 1])), shape=shape)
    holes, hole_of = libs.csgraph.connected_components(graph, directed=False)
    lengths = np.linalg.norm(vertices[edges[:, 0]] - vertices[edges[:, 1]], axis=1)
    around = np.bincount(hole_of[ends[:, 0]], lengths)
    largest = hole_of[ends[:, 0]] == around.argmax()
    middles = 0.5 * vertices[edges[largest]].sum(axis=1)
    x, y, z = (lengths[largest] @ middles) / lengths[largest].sum()
    more = f" and {len(edges) - 1} more" if len(edges) > 1 else ""
    told = "a hole" if holes == 1 else f"{holes} holes, of which the largest is"
    raise ModelError(
        f"{name}: only one triangle has the edge {tuple(edges[0].tolist())}{more}: {told} at "
        f"({x:.4g}, {y:.4g}, {z:.4g}) with {largest.sum()} edges, {around.max():.4g} m around, expected a closed "
        "surface"
    )
