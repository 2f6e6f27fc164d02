"""The planar mesh of what the user gave, a mesh of scikit-fem or a file, checked."""

from __future__ import annotations

import os
import warnings
from dataclasses import replace
from typing import Any

import numpy as np

from lcpflex.basics import libs
from lcpflex.bodies.body import array_of
from lcpflex.bodies.fem.files import read_mesh
from lcpflex.bodies.fem.planar_mesh import DEGENERATE, EXTENTS, KINDS, PlanarMesh, check_nodes
from lcpflex.errors import ModelError, ModelWarning, in_range, shown
from lcpflex.jit.kernel import IntArray

__all__ = ["planar_mesh"]


def planar_mesh(mesh: Any, unit: float = 1.0) -> PlanarMesh:
    """The checked mesh of a scikit-fem mesh, or of a file, whose unit of length has ``unit`` metres.

    Elements that run clockwise are turned around. Nodes without an element are left out, with a warning.

    Raises
    ------
    ModelError
        For anything else, another kind of element, elements without area or with a fold, places that are not finite,
        elements that overlap or hang together at a corner only, and a mesh in several parts.
    """
    if isinstance(mesh, PlanarMesh) and unit == 1.0:
        return mesh
    if isinstance(mesh, PlanarMesh):
        return _checked(replace(mesh, places=unit * mesh.places))
    if isinstance(mesh, (str, os.PathLike)):
        found = read_mesh(mesh)
        if not isinstance(found, PlanarMesh):
            found = _from_scikit_fem(found, repr(os.fspath(mesh)))
    else:
        found = _from_scikit_fem(mesh, "mesh")
    return _checked(found if unit == 1.0 else replace(found, places=unit * np.asarray(found.places)))


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
    check_nodes(source, mesh)
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
