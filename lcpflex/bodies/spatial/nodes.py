"""Points of solid meshes: single nodes, sets of nodes, places; their displacement and rotation from nodal values."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from lcpflex.basics.arguments import array_of
from lcpflex.bodies.fem.finite_elements import FiniteElements
from lcpflex.bodies.fem.node_sets import node_numbers
from lcpflex.bodies.fem.node_weights import node_weights
from lcpflex.bodies.fem.sparse_factor import links
from lcpflex.bodies.spatial.checks import skew
from lcpflex.bodies.spatial.elastic import PointOperator
from lcpflex.errors import ModelError
from lcpflex.jit.kernel import FloatArray, IntArray

if TYPE_CHECKING:
    from scipy.sparse import csc_matrix

__all__ = ["NodePoints"]

COLLINEAR = 1e-8  # second moment of nodes about their best line, relative to that across it
NEAR = 1e-6  # of the size of the mesh, within which a place is that of a node


class NodePoints:
    """The points of a mesh of N nodes with three displacements each; its stiffness tells the neighbours of a node."""

    def __init__(self, mesh: FiniteElements) -> None:
        self._mesh = mesh
        self._places = mesh.places
        self._graph: csc_matrix[Any] | None = None

    def of_nodes(self, nodes: Any, weights: Any = None) -> PointOperator:
        """The point that stands for some nodes, or is one; weights None: those of :func:`node_weights`.

        Raises
        ------
        ModelError
            For nodes that the mesh does not have or that are given twice, and weights that are not positive.
        """
        given = node_numbers("nodes", nodes, len(self._places), "node numbers").astype(np.int64)
        if len(np.unique(given)) != len(given):
            raise ModelError("nodes: one appears twice, expected each once (and a weight for what counts twice)")
        w = node_weights(self._mesh, given) if weights is None else array_of("weights", weights, (len(given),))
        if not w.min() > 0.0:
            raise ModelError(f"weights: {w.min():.6g} was given, expected weights > 0")
        return self._single(int(given[0])) if len(given) == 1 else self._mean(given, w / w.sum())

    def at(self, x: float, y: float, z: float) -> PointOperator:
        """The material at a place: a node, or between nodes where the elements are known, as matrices do not tell."""
        place = array_of("x, y, z", (x, y, z), (3,))
        away = np.linalg.norm(self._places - place, axis=1)
        nearest = int(away.argmin())
        if away[nearest] <= NEAR * float(np.ptp(self._places, axis=0).max()):
            return self._single(nearest)
        if self._mesh.locate is None:
            at = ", ".join(f"{v:.6g}" for v in self._places[nearest])
            raise ModelError(
                f"x, y, z: no node lies there; the nearest one, {nearest}, is at ({at}), {away[nearest]:.3g} m away"
            )
        return self._between(place, *self._mesh.locate(*place.tolist()))

    def _between(self, place: FloatArray, nodes: IntArray, weights: FloatArray) -> PointOperator:
        """Weighted displacements and rotations of nodes about a place."""
        parts = [(weight, self._single(int(node))) for node, weight in zip(nodes, weights, strict=True) if weight]
        return PointOperator(
            place=place,
            rows=np.concatenate([part.rows for _, part in parts]),
            u=np.concatenate([weight * part.u for weight, part in parts]),
            psi=np.concatenate([weight * part.psi for weight, part in parts]),
            turns=all(part.turns for _, part in parts),
        )

    def _mean(self, nodes: IntArray, w: FloatArray) -> PointOperator:
        """psi = G^-1 sum w y x u, G = sum w (|y|^2 I - y y^T)."""
        place = w @ self._places[nodes]
        y = self._places[nodes] - place
        moments = np.einsum("i,ij,ik->jk", w, y, y)
        G = np.trace(moments) * np.eye(3) - moments
        size = np.linalg.eigvalsh(G)
        u: FloatArray = np.kron(w[:, None], np.eye(3)).astype(np.float64)
        turns = bool(size[0] > COLLINEAR * size[2])
        psi = np.zeros_like(u)
        if turns:
            inverse = np.linalg.inv(G)
            psi = np.concatenate([(inverse @ (wi * skew(yi))).T for wi, yi in zip(w, y, strict=True)])
        return PointOperator(place, _rows(nodes), u, psi, turns, (nodes, w))

    def _single(self, node: int) -> PointOperator:
        """psi is half the curl of the best linear field through the node and those that share an element with it."""
        if self._graph is None:
            count = len(self._places)
            self._graph = links(self._mesh.stiffness, self._mesh.node, count)
        linked = self._graph.indices[self._graph.indptr[node] : self._graph.indptr[node + 1]]
        others = np.sort(linked[linked != node])
        y = self._places[others] - self._places[node]
        near = 1.0 / np.maximum((y * y).sum(axis=1), math.ulp(0.0) ** 0.5)
        moments = np.einsum("i,ij,ik->jk", near, y, y)
        place = self._places[node]
        if not len(others) or np.linalg.eigvalsh(moments)[0] < COLLINEAR * np.trace(moments):
            return PointOperator(place, _rows(np.array([node])), np.eye(3), np.zeros((3, 3)), turns=False)
        c = np.linalg.solve(moments, (near[:, None] * y).T).T  # gradient of a field v: sum of c_i (v_i - v_node)
        half = np.array([0.5 * skew(ci) for ci in c])
        psi = np.concatenate([-half.sum(axis=0).T, *(part.T for part in half)])
        u = np.zeros((3 + 3 * len(others), 3))
        u[:3] = np.eye(3)
        return PointOperator(place, _rows(np.array([node, *others])), u, psi)


def _rows(nodes: IntArray) -> IntArray:
    """The displacements of the nodes among the degrees of freedom."""
    return np.asarray((3 * nodes[:, None] + np.arange(3)).ravel())
