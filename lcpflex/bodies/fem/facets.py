"""The facets of a mesh that belong to one element: its boundary, edges in the plane and faces in space."""

from __future__ import annotations

from typing import NoReturn

import numpy as np

from lcpflex.bodies.fem.mesh import Mesh, told_place
from lcpflex.errors import ModelError
from lcpflex.jit.kernel import IntArray

__all__ = ["outer_facets", "refuse"]


def outer_facets(mesh: Mesh) -> IntArray:
    """(F, k) nodes of the boundary facets, in the order of :attr:`Kind.facets`: seen from outside.

    Raises
    ------
    ModelError
        Where elements overlap: a facet of more than two, or of two on the same side of it; and where two elements have
        different nodes amid a facet.
    """
    kind, key = mesh.kind, mesh.facet_keys()
    walked = mesh.cells[:, np.array(kind.facets)].reshape(len(key), -1)
    _, first, number, uses = np.unique(key, return_index=True, return_inverse=True, return_counts=True)
    name = "an edge" if kind.dimension == 2 else "a face"
    if uses.max() > 2:
        refuse(mesh, int(walked[first[uses.argmax()], 0]), f"{uses.max()} elements share {name}", "at most two")
    inner = np.flatnonzero(uses == 2)
    order = np.argsort(number.ravel(), kind="stable")
    rows = order[np.searchsorted(number.ravel()[order], inner)[:, None] + [0, 1]]
    pairs = walked[rows]
    corners = kind.facet_corners
    same = _ways(pairs[:, 0, :corners]) == _ways(pairs[:, 1, :corners])
    if same.any():
        where = int(same.argmax())
        fault = f"two elements lie on the same side of {name}"
        if kind.dimension == 3:
            i, j = rows[where] // len(kind.facets)
            fault = f"elements {i} and {j} lie on the same side of a face (one is inverted, or they overlap)"
        refuse(mesh, int(pairs[where, 0, 0]), fault, "no overlap")
    amid = np.sort(pairs[:, :, corners:], axis=2)
    apart = (amid[:, 0] != amid[:, 1]).any(axis=1)
    if apart.any():
        where = int(apart.argmax())
        refuse(mesh, int(pairs[where, 0, corners]), f"{name} has two nodes amid it", "one that both elements share")
    return np.asarray(walked[first[uses == 1]])


def refuse(mesh: Mesh, node: int, fault: str, expected: str) -> NoReturn:
    """Raise ModelError for a fault of the mesh at a node."""
    raise ModelError(f"{mesh.source}: {fault} at {told_place(mesh.places[node])}, expected {expected}")


def _ways(corners: IntArray) -> IntArray:
    """Which way around facets (F, 2 to 4) are walked: two walks of the same corners go one way if these are equal."""
    rows, least = np.arange(len(corners)), corners.argmin(axis=1)
    if corners.shape[1] == 2:
        return least
    return np.asarray(corners[rows, (least + 1) % corners.shape[1]])
