"""Contact nodes of a solid that give way along their normals alone: a third of the coordinates, where nothing rubs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from lcpflex.basics import libs
from lcpflex.bodies.fem.faces import even_parts
from lcpflex.bodies.fem.finite_elements import FiniteElements
from lcpflex.bodies.reduction.bases import Basis, constraint_columns, enough_nodes, left_loose
from lcpflex.bodies.reduction.eigenmodes import orthonormal_frame
from lcpflex.bodies.reduction.orthonormal_basis import own_basis
from lcpflex.errors import ModelError
from lcpflex.jit.kernel import FloatArray, IntArray

if TYPE_CHECKING:
    from scipy.sparse import csc_matrix

__all__ = ["nodal_normals", "normal_boundary_basis", "normal_loads"]


def nodal_normals(mesh: FiniteElements, argument: str, nodes: IntArray) -> FloatArray:
    """(k, 3) outward unit normals at nodes of the surface: means of those of the faces of the set, by their areas.

    Where no face of the surface has nodes of the set alone, of all faces at the node.

    Raises
    ------
    ModelError
        For nodes that are not on the surface, or where the surface is not known; and where its normals cancel.
    """
    if not len(mesh.facets):
        raise ModelError(f"{argument}: the faces of the mesh are not known, expected rows='all', or a mesh with faces")
    within = np.isin(mesh.facets, nodes).all(axis=1)
    found = _summed(mesh, mesh.facets[within])[nodes]
    missing = ~found.any(axis=1)
    if missing.any():
        found[missing] = _summed(mesh, mesh.facets)[nodes[missing]]
    size = np.linalg.norm(found, axis=1)
    bad = np.flatnonzero(~(size > 1e-9 * float(np.ptp(mesh.places, axis=0).max()) ** 2 / len(mesh.facets)))
    if len(bad):
        raise ModelError(f"{argument}: node {nodes[bad[0]]} has no normal, expected nodes of the surface")
    return np.asarray(found / size[:, None])


def _summed(mesh: FiniteElements, facets: IntArray) -> FloatArray:
    """(N, 3) area vectors of facets, shared by the nodes of their linear parts."""
    parts = even_parts(facets)
    corners = mesh.places[parts]
    last = corners.shape[1] - 1
    vector = np.cross(corners[:, 1] - corners[:, last], corners[:, 2] - corners[:, 0])
    total = np.zeros_like(mesh.places)
    np.add.at(total, parts.ravel(), np.repeat(vector, parts.shape[1], axis=0))
    return total


def normal_loads(mesh: FiniteElements, argument: str, nodes: IntArray) -> FloatArray:
    """(f, k) a unit force along the normal at each node."""
    loads = np.zeros((len(mesh.dofs), len(nodes)))
    normals = nodal_normals(mesh, argument, nodes)
    for axis in range(3):
        loads[3 * nodes + axis, np.arange(len(nodes))] = normals[:, axis]
    return loads


@dataclass(frozen=True, slots=True, eq=False)
class _Turned:
    """A mesh whose first displacement at some nodes is that along their normals."""

    mass: csc_matrix[Any]
    stiffness: csc_matrix[Any]
    rigid: FloatArray
    rank: IntArray


def normal_boundary_basis(mesh: FiniteElements, nodes: IntArray, modes: int | None) -> tuple[Basis, int]:
    """Constraint modes of the normal displacements at nodes, and modes of the mesh held by these alone.

    A flat face leaves the mesh three rigid motions, which stay among the columns. Also the number of modes there are.
    """
    turn = _turning(mesh, nodes)
    turned = _Turned(
        mass=(turn.T @ mesh.mass @ turn).tocsc(),
        stiffness=(turn.T @ mesh.stiffness @ turn).tocsc(),
        rigid=turn.T @ mesh.rigid,
        rank=mesh.rank,
    )
    words = ("boundary: with the normal displacements of its nodes held", enough_nodes(mesh))
    columns = turn @ constraint_columns(turned, 3 * nodes, modes, words, loose=True)
    frame = orthonormal_frame(mesh.mass, mesh.rigid)
    most = len(mesh.dofs) - len(nodes) - left_loose(turned.rigid, 3 * nodes)[0].shape[1]
    return own_basis(mesh.mass, mesh.stiffness, frame, columns, holds_rigid=True), most


def _turning(mesh: FiniteElements, nodes: IntArray) -> Any:
    """(f, f) orthogonal: displacements of nodes from those along their normals and across."""
    normals = nodal_normals(mesh, "boundary", nodes)
    across = np.cross(normals, np.eye(3)[np.abs(normals).argmin(axis=1)])
    across /= np.linalg.norm(across, axis=1)[:, None]
    blocks = np.tile(np.eye(3), (len(mesh.places), 1, 1))
    blocks[nodes] = np.stack([normals, across, np.cross(normals, across)], axis=2)
    row = (3 * np.arange(len(blocks))[:, None, None] + np.arange(3)[:, None]) + np.zeros((1, 1, 3), dtype=np.int64)
    column = row.transpose(0, 2, 1)
    return libs.sparse.coo_matrix((blocks.ravel(), (row.ravel(), column.ravel()))).tocsc()
