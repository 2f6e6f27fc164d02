"""A planar mesh of one kind of element, checked: what continuum bodies are assembled from.

Elements turn counter-clockwise: corners first, then the nodes amid the edges 0-1, 1-2, ..., then the middle.
"""

from __future__ import annotations

import os
import warnings
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from lcpflex.basics import libs
from lcpflex.bodies.body import array_of
from lcpflex.errors import ModelError, ModelWarning, in_range, shown
from lcpflex.jit.kernel import FloatArray, IntArray

__all__ = ["KINDS", "Kind", "PlanarMesh", "planar_mesh"]

FLAT = 1e-9  # of the size of the mesh: distances below it are rounding
EXTENTS = (1e-12, 1e9)  # [m] of meshes: whatever the unit was, beyond it numbers are broken
DEGENERATE = 1e-10  # area of an element relative to the square of its longest edge


@dataclass(frozen=True, slots=True)
class Kind:
    """One kind of element.

    Attributes
    ----------
    mesh, element : names of its classes in scikit-fem
    corners, nodes : numbers of them
    turned : the order of its nodes when it is run around the other way
    """

    mesh: str
    element: str
    corners: int
    nodes: int
    turned: tuple[int, ...]

    @property
    def quadratic(self) -> bool:
        """Whether its edges have a node amid."""
        return self.nodes > self.corners

    def edges(self) -> IntArray:
        """(corners, 2 or 3) nodes of each edge as one walks around it: first, last, and the one amid."""
        first = np.arange(self.corners)
        ends = [first, (first + 1) % self.corners]
        return np.column_stack([*ends, first + self.corners] if self.quadratic else ends)


KINDS = {  # by the names of meshio
    "triangle": Kind("MeshTri1", "ElementTriP1", 3, 3, (0, 2, 1)),
    "triangle6": Kind("MeshTri2", "ElementTriP2", 3, 6, (0, 2, 1, 5, 4, 3)),
    "quad": Kind("MeshQuad1", "ElementQuad1", 4, 4, (0, 3, 2, 1)),
    "quad9": Kind("MeshQuad2", "ElementQuad2", 4, 9, (0, 3, 2, 1, 7, 6, 5, 4, 8)),
}


@dataclass(frozen=True, slots=True, eq=False)
class PlanarMesh:
    """N nodes and m elements of one kind, connected through edges, all of positive area; no node is unused.

    Attributes
    ----------
    kind : what the elements are
    places : (N, 2) [m]
    cells : (m, nodes) nodes of the elements
    groups : named nodes that came with the mesh
    source : what the mesh is called in messages
    """

    kind: Kind
    places: FloatArray
    cells: IntArray
    groups: Mapping[str, IntArray] = field(default_factory=dict)
    source: str = "mesh"

    @property
    def size(self) -> float:
        """Extent of the mesh [m]."""
        return float(np.ptp(self.places, axis=0).max())

    def edge_keys(self) -> IntArray:
        """One number for the pair of ends of each edge of each element, whichever way it is walked."""
        ends = np.sort(self.cells[:, self.kind.edges()[:, :2]].reshape(-1, 2), axis=1)
        return np.asarray(ends[:, 0] * len(self.places) + ends[:, 1])

    def longest_edge(self) -> float:
        """Longest edge of an element, from corner to corner [m]."""
        corners = self.places[self.cells[:, : self.kind.corners]]
        arms = np.roll(corners, -1, axis=1) - corners
        return float(np.hypot(arms[..., 0], arms[..., 1]).max())


def planar_mesh(mesh: Any) -> PlanarMesh:
    """The checked mesh of a scikit-fem mesh, or of a file that meshio reads.

    Elements that run clockwise are turned around. Nodes without an element are left out, with a warning.

    Raises
    ------
    ModelError
        For anything else, another kind of element, elements without area or with a fold, places that are not finite,
        elements that overlap or hang together at a corner only, and a mesh in several parts.
    """
    if isinstance(mesh, PlanarMesh):
        return mesh
    if isinstance(mesh, (str, os.PathLike)):
        from lcpflex.bodies.fem.files import read_mesh

        found = read_mesh(mesh)
        if not isinstance(found, PlanarMesh):
            found = _from_scikit_fem(found, repr(os.fspath(mesh)))
    else:
        found = _from_scikit_fem(mesh, "mesh")
    return _checked(found)


def _from_scikit_fem(mesh: Any, source: str) -> PlanarMesh:
    """Nodes numbered as the columns of ``mesh.p``."""
    name = type(mesh).__name__
    kind = next((kind for kind in KINDS.values() if kind.mesh == name), None)
    if kind is None:
        given = shown(mesh) if isinstance(mesh, (int, float, type(None))) else name
        raise ModelError(
            f"mesh: {given} was given, expected a scikit-fem mesh ({', '.join(k.mesh for k in KINDS.values())}) "
            f"or the name of a mesh file"
        )
    places, corners = np.asarray(mesh.doflocs, dtype=np.float64).T, np.asarray(mesh.t)
    sound = (
        corners.size and places.ndim == 2 and places.shape[1] == 2 and 0 <= corners.min() <= corners.max() < len(places)
    )
    if not sound:
        raise ModelError(
            f"{source}: {corners.shape[-1]} elements on {len(places)} nodes, expected elements on nodes that are there"
        )
    cells = np.asarray(mesh.dofs.element_dofs.T, dtype=np.int64)
    groups = {str(key): np.unique(cells[np.asarray(of)]) for key, of in (mesh.subdomains or {}).items()}
    for key, facets in (mesh.boundaries or {}).items():
        chosen = np.asarray(facets, dtype=np.int64)
        nodes = mesh.facets[:, chosen].ravel()
        if kind.quadratic:
            nodes = np.concatenate([nodes, mesh.dofs.facet_dofs[0, chosen]])
        groups[str(key)] = np.unique(nodes)
    return PlanarMesh(kind, places, cells, groups, source)


def _checked(mesh: PlanarMesh) -> PlanarMesh:
    """The mesh in its form: counter-clockwise elements, no unused nodes."""
    array_of(f"{mesh.source}: places of the nodes", mesh.places, (-1, 2))
    if not len(mesh.cells):
        raise ModelError(f"{mesh.source}: no elements were given, expected one at least")
    mesh = _without_unused(mesh)
    in_range(f"{mesh.source}: extent [m]", mesh.size, *EXTENTS)
    cells = _turned(mesh)
    mesh = PlanarMesh(mesh.kind, mesh.places, cells, mesh.groups, mesh.source)
    _check_connected(mesh)
    return mesh


def _without_unused(mesh: PlanarMesh) -> PlanarMesh:
    count = len(mesh.places)
    used = np.unique(mesh.cells)
    if len(used) == count:
        return mesh
    spare = np.setdiff1d(np.arange(count), used)
    warnings.warn(
        f"{mesh.source}: node {spare[0]}{f' and {len(spare) - 1} more' if len(spare) > 1 else ''} without an element "
        f"left out; the nodes after it count from there",
        ModelWarning,
        stacklevel=2,
    )
    number = np.full(count, -1)
    number[used] = np.arange(len(used))
    groups = {name: number[nodes][number[nodes] >= 0] for name, nodes in mesh.groups.items()}
    kept = {name: nodes for name, nodes in groups.items() if len(nodes)}
    return PlanarMesh(mesh.kind, mesh.places[used], number[mesh.cells], kept, mesh.source)


def _turned(mesh: PlanarMesh) -> IntArray:
    """The cells, all counter-clockwise; refuses flat ones and repeated nodes."""
    cells = mesh.cells
    ordered = np.sort(cells, axis=1)
    repeated = (ordered[:, 1:] == ordered[:, :-1]).any(axis=1)
    corners = mesh.places[cells[:, : mesh.kind.corners]]
    arms = corners - corners[:, :1]  # from a corner: of small elements far from the origin little would be left
    on = np.roll(arms, -1, axis=1)
    twice = (arms[..., 0] * on[..., 1] - on[..., 0] * arms[..., 1]).sum(axis=1)
    edge = np.hypot(*np.moveaxis(on - arms, -1, 0)).max(axis=1)
    flat = repeated | ~(np.abs(twice) > 2.0 * DEGENERATE * edge**2)
    if flat.any():
        bad = int(np.flatnonzero(flat)[0])
        x, y = corners[bad].mean(axis=0)
        raise ModelError(
            f"{mesh.source}: element {bad} at ({x:.6g}, {y:.6g}) has the area {0.5 * twice[bad]:.3g} m^2"
            f"{' and a node twice' if repeated[bad] else ''}, expected corners that span an area"
        )
    return np.asarray(np.where((twice < 0.0)[:, None], cells[:, mesh.kind.turned], cells))


def _check_connected(mesh: PlanarMesh) -> None:
    """Refuse loose parts: elements hang together through edges."""
    kind, cells = mesh.kind, mesh.cells
    owner = np.repeat(np.arange(len(cells)), kind.corners)
    _, number = np.unique(mesh.edge_keys(), return_inverse=True)
    links = libs.sparse.coo_matrix(
        (np.ones(len(owner)), (owner, number.ravel())), shape=(len(cells), int(number.max()) + 1)
    ).tocsr()
    parts, label = libs.csgraph.connected_components(links @ links.T, directed=False)
    if parts == 1:
        return
    second = int(np.flatnonzero(label != label[0])[0])
    x, y = mesh.places[cells[second, : kind.corners]].mean(axis=0)
    raise ModelError(
        f"{mesh.source}: its elements make {parts} parts that share no edge (element {second} at ({x:.6g}, {y:.6g}) is "
        f"not in the part of element 0), expected one piece: merge nodes that "
        f"coincide, let no node hang on an edge, or make a body of each part"
    )
