"""Facets of a surface as a user gives them: their nodes must come in the order that normals and shapes follow from."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

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
ALONG = 0.9  # cosine of the normals of facets that cover one another: coarse and fine ones on an arc, also
IN_PLANE = 1e-3  # of its size: how far from a facet another one that covers it is, if they have no node in common
COMMON = 1e-3  # of the smaller facet: how far into it another one reaches that covers it; less is rounding of places


def check_facets(faces: Mapping[str, IntArray], stiffness: csc_matrix[Any], places: FloatArray) -> None:
    """Raise ModelError for facets (F, k) with nodes in another order, flattened, clockwise seen from outside, or twice.

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
        _check_repeated(name, facets, corners)
    _check_covered(faces, places)


def _check_repeated(name: str, facets: IntArray, corners: int) -> None:
    """Every facet once: contact on a second one would have the forces of the first one again."""
    _, first, number = np.unique(np.sort(facets[:, :corners], axis=1), axis=0, return_index=True, return_inverse=True)
    again = np.flatnonzero(first[number.ravel()] != np.arange(len(facets)))
    if len(again):
        here = int(again[0])
        raise ModelError(
            f"faces[{name!r}]: facets {first[number.ravel()[here]]} and {here} have the same corners "
            f"{facets[here, :corners].tolist()} ({len(again)} facet(s) are given again), expected each once: what "
            "touches would count twice"
        )


def _check_covered(faces: Mapping[str, IntArray], places: FloatArray) -> None:
    """A surface has one division: different facets, also of different faces, do not cover one another."""
    corners = 3 if next(iter(faces.values())).shape[1] in (3, 6) else 4
    every = np.concatenate([facets[:, :corners] for facets in faces.values()])
    told = [f"faces[{name!r}], facet {k}" for name, facets in faces.items() for k in range(len(facets))]
    _, own = np.unique(np.sort(every, axis=1), axis=0, return_index=True)
    x = places[every[own]]
    middle = x.mean(axis=1)
    reach = np.linalg.norm(x - middle[:, None], axis=2).max(axis=1)
    near = libs.cKDTree(middle).query_ball_point(middle, 2.0 * reach)  # of two, the larger one finds the smaller one
    large = np.repeat(np.arange(len(own)), [len(one) for one in near])
    small = np.concatenate([np.asarray(one, dtype=np.int64) for one in near])
    large, small = (side[(small != large) & (reach[small] <= reach[large])] for side in (large, small))
    normal = np.cross(x[:, 1] - x[:, -1], x[:, 2] - x[:, 0])
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    height = np.abs(((middle[small] - middle[large]) * normal[large]).sum(axis=1))
    joined = (every[own][large][:, :, None] == every[own][small][:, None]).any(axis=(1, 2))
    close = ((normal[small] * normal[large]).sum(axis=1) > ALONG) & (joined | (height <= IN_PLANE * reach[large]))
    large, small = large[close], small[close]
    covered = np.flatnonzero(_overlap(x[large], x[small], normal[large], COMMON * reach[small]))
    if len(covered):
        a, b = sorted((int(own[large[covered[0]]]), int(own[small[covered[0]]])))
        raise ModelError(
            f"{told[a]} with corners {every[a].tolist()} and {told[b]} with corners {every[b].tolist()} cover one "
            f"another ({len(covered)} pair(s)), expected facets that have edges in common at most: what touches would "
            "count twice"
        )


def _overlap(a: FloatArray, b: FloatArray, normal: FloatArray, least: FloatArray) -> npt.NDArray[np.bool_]:
    """(P,) whether convex polygons a and b (P, k, 3), seen along ``normal``, have more in common than ``least`` [m].

    Those that have not are parted by a line along an edge of one of them (separating axes).
    """
    common = np.ones(len(a), dtype=bool)
    for own, other in ((a, b), (b, a)):
        edge = np.roll(own, -1, axis=1) - own
        inward = np.cross(normal[:, None], edge)
        inward /= np.linalg.norm(inward, axis=2)[:, :, None]
        depth = np.einsum("pkjd,pkd->pkj", other[:, None] - own[:, :, None], inward).max(axis=2)
        common &= (depth > least[:, None]).all(axis=1)
    return common


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
