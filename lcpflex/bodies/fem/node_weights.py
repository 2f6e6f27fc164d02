"""How much the nodes of a set count: by the part of the volume, surface or line that is theirs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from lcpflex.bodies.fem.assembly import mass_matrix
from lcpflex.bodies.fem.faces import areas_of, even_parts
from lcpflex.bodies.fem.finite_elements import FiniteElements
from lcpflex.jit.kernel import FloatArray, IntArray

__all__ = ["node_weights"]


def node_weights(mesh: FiniteElements, nodes: IntArray) -> FloatArray:
    """(k,) weights > 0 of some nodes, of sum 1: their shares of what they make up together.

    Where all of them are nodes of elements that are in the set as a whole, by the diagonal of their mass; of faces in
    the set, by area; of edges of the surface in the set, by length. So a set that is finely meshed at one end has its
    mean where the material has it. Shares are those of linear parts of the facets, four of a quadratic one: those of
    its own shape functions are zero or negative at its corners. Other nodes, and those of a mesh whose elements are not
    known, count alike.
    """
    chosen = np.zeros(len(mesh.places), dtype=np.bool_)
    chosen[nodes] = True
    for shares in (_by_elements, _by_area, _by_length):
        found = shares(mesh, chosen)[nodes]
        if len(found) and found.min() > 0.0:
            return np.asarray(found / found.sum())
    return np.full(len(nodes), 1.0 / max(len(nodes), 1))


def _by_elements(mesh: FiniteElements, chosen: np.ndarray[tuple[int], np.dtype[np.bool_]]) -> FloatArray:
    if mesh.solid is None:
        return np.zeros(len(chosen))
    whole = mesh.solid.mesh
    inside = replace(whole, cells=whole.cells[chosen[whole.cells].all(axis=1)])
    return np.asarray(mass_matrix(replace(mesh.solid, mesh=inside)).diagonal()[:: mesh.dimension])


def _by_area(mesh: FiniteElements, chosen: np.ndarray[tuple[int], np.dtype[np.bool_]]) -> FloatArray:
    parts = even_parts(mesh.facets[chosen[mesh.facets].all(axis=1)])
    area = areas_of(mesh.places, parts) / parts.shape[1]
    return np.asarray(np.bincount(parts.ravel(), np.repeat(area, parts.shape[1]), len(chosen)), dtype=np.float64)


def _by_length(mesh: FiniteElements, chosen: np.ndarray[tuple[int], np.dtype[np.bool_]]) -> FloatArray:
    """By the edges of facets, in halves where they have a node amid."""
    k = mesh.facets.shape[1]
    corners = 3 if k in (3, 6) else 4
    after = np.roll(np.arange(corners), -1)
    if k > corners:
        pairs = np.concatenate([np.stack([np.arange(corners), corners + np.arange(corners)], 1),
                                np.stack([corners + np.arange(corners), after], 1)])  # fmt: skip
    else:
        pairs = np.stack([np.arange(corners), after], axis=1)
    ends = np.sort(mesh.facets[:, pairs].reshape(-1, 2), axis=1)
    ends = np.unique(ends[chosen[ends].all(axis=1)], axis=0)
    length = np.linalg.norm(mesh.places[ends[:, 1]] - mesh.places[ends[:, 0]], axis=1)
    return np.asarray(np.bincount(ends.ravel(), 0.5 * np.repeat(length, 2), len(chosen)), dtype=np.float64)
