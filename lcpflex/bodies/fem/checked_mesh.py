"""The mesh of what the user gave, a mesh of scikit-fem or a file, checked: planar, or of a solid in space."""

from __future__ import annotations

import os
import warnings
from dataclasses import replace
from typing import Any

import numpy as np

from lcpflex.basics import libs
from lcpflex.bodies.body import array_of
from lcpflex.bodies.fem.assembly import own_order, reference_corners, shape_functions
from lcpflex.bodies.fem.files import read_mesh, read_solid_mesh
from lcpflex.bodies.fem.mesh import DEGENERATE, EXTENTS, KINDS, Kind, Mesh, check_nodes, told_place
from lcpflex.errors import ModelError, ModelWarning, in_range, shown
from lcpflex.jit.kernel import FloatArray, IntArray

__all__ = ["planar_mesh", "spatial_mesh"]


def planar_mesh(mesh: Any, unit: float = 1.0) -> Mesh:
    """The checked mesh of a scikit-fem mesh, or of a file, whose unit of length has ``unit`` metres.

    Elements that run clockwise are turned around. Nodes without an element are left out, with a warning.

    Raises
    ------
    ModelError
        For anything else, another kind of element, elements without area or with a fold, places that are not finite,
        elements that overlap or hang together at a corner only, and a mesh in several parts.
    """
    return _mesh_of(mesh, 2, unit)


def spatial_mesh(mesh: Any, unit: float = 1.0) -> Mesh:
    """The checked mesh of a solid in space: see :func:`planar_mesh`.

    Elements whose nodes are numbered as in a mirror are turned around; one that is inverted overlaps its neighbours,
    and is refused.
    """
    return _mesh_of(mesh, 3, unit)


def _mesh_of(mesh: Any, dimension: int, unit: float) -> Mesh:
    if isinstance(mesh, Mesh) and unit == 1.0:
        return mesh
    if isinstance(mesh, Mesh):
        return _checked(replace(mesh, places=unit * mesh.places))
    if isinstance(mesh, (str, os.PathLike)):
        found = read_mesh(mesh) if dimension == 2 else read_solid_mesh(mesh)
        if not isinstance(found, Mesh):
            found = _from_scikit_fem(found, repr(os.fspath(mesh)), dimension)
    else:
        found = _from_scikit_fem(mesh, "mesh", dimension)
    return _checked(found if unit == 1.0 else replace(found, places=unit * np.asarray(found.places)))


def _from_scikit_fem(mesh: Any, source: str, dimension: int) -> Mesh:
    """Nodes numbered as the columns of ``mesh.p``."""
    name = type(mesh).__name__
    known = {kind.mesh: kind for kind in KINDS.values() if kind.dimension == dimension}  # of 27 nodes, not of 20
    if name not in known:
        given = shown(mesh) if isinstance(mesh, (int, float, type(None))) else name
        raise ModelError(
            f"mesh: {given} was given, expected a scikit-fem mesh ({', '.join(known)}) or the name of a mesh file"
        )
    kind = known[name]
    places, corners = np.asarray(mesh.doflocs, dtype=np.float64).T, np.asarray(mesh.t)
    sound = (
        corners.size
        and places.ndim == 2
        and places.shape[1] == dimension
        and 0 <= corners.min() <= corners.max() < len(places)
    )
    if not sound:
        raise ModelError(
            f"{source}: {corners.shape[-1]} elements on {len(places)} nodes, expected elements on nodes that are there"
        )
    check_nodes(source, mesh)
    cells = np.asarray(mesh.dofs.element_dofs.T, dtype=np.int64)[:, own_order(kind)]
    groups = {str(key): np.unique(cells[np.asarray(of)]) for key, of in (mesh.subdomains or {}).items()}
    faces = {}
    for key, facets in (mesh.boundaries or {}).items():
        chosen = np.asarray(facets, dtype=np.int64)
        if dimension == 3:
            faces[str(key)] = np.ascontiguousarray(mesh.facets[:, chosen].T, dtype=np.int64)
            continue
        nodes = mesh.facets[:, chosen].ravel()
        if kind.quadratic:
            nodes = np.concatenate([nodes, mesh.dofs.facet_dofs[0, chosen]])
        groups[str(key)] = np.unique(nodes)
    return Mesh(kind, places, cells, groups, source, faces)


def _checked(mesh: Mesh) -> Mesh:
    """The mesh in its form: counter-clockwise elements, or those of positive volume, no unused nodes."""
    array_of(f"{mesh.source}: places of the nodes", mesh.places, (-1, mesh.kind.dimension))
    if not len(mesh.cells):
        raise ModelError(f"{mesh.source}: no elements were given, expected one at least")
    mesh = _without_unused(mesh)
    in_range(f"{mesh.source}: extent [m]", mesh.size, *EXTENTS)
    mesh = replace(mesh, cells=_turned(mesh))
    _check_connected(mesh)
    return mesh


def _without_unused(mesh: Mesh) -> Mesh:
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
    renumbered = {name: number[corners] for name, corners in mesh.faces.items()}
    faces = {name: corners[(corners >= 0).all(axis=1)] for name, corners in renumbered.items()}
    return Mesh(mesh.kind, mesh.places[used], number[mesh.cells], kept, mesh.source, faces)


def _turned(mesh: Mesh) -> IntArray:
    """The cells, all counter-clockwise or of positive volume; refuses flat ones and repeated nodes."""
    cells = mesh.cells
    ordered = np.sort(cells, axis=1)
    repeated = (ordered[:, 1:] == ordered[:, :-1]).any(axis=1)
    corners = mesh.places[cells[:, : mesh.kind.corners]]
    planar = mesh.kind.dimension == 2
    content, edge = _areas(corners) if planar else _volumes(mesh.kind, corners)
    flat = repeated | ~(np.abs(content) > DEGENERATE * edge)
    if flat.any():
        bad = int(np.flatnonzero(flat)[0])
        raise ModelError(
            f"{mesh.source}: element {bad} at {told_place(corners[bad].mean(axis=0))} has the "
            f"{'area' if planar else 'volume'} {content[bad]:.3g} m^{mesh.kind.dimension}"
            f"{' and a node twice' if repeated[bad] else ''}, expected corners that span "
            f"{'an area' if planar else 'a volume'}"
        )
    return np.asarray(np.where((content < 0.0)[:, None], cells[:, mesh.kind.turned], cells))


def _areas(corners: FloatArray) -> tuple[FloatArray, FloatArray]:
    """(m,) signed areas of elements with corners (m, k, 2), and the squares of their longest edges."""
    arms = corners - corners[:, :1]  # from a corner: of small elements far from the origin little would be left
    on = np.roll(arms, -1, axis=1)
    twice = (arms[..., 0] * on[..., 1] - on[..., 0] * arms[..., 1]).sum(axis=1)
    edge = np.hypot(*np.moveaxis(on - arms, -1, 0)).max(axis=1)
    return 0.5 * twice, edge**2


def _volumes(kind: Kind, corners: FloatArray) -> tuple[FloatArray, FloatArray]:
    """(m,) signed volumes of elements with corners (m, k, 3), by det J amid them, and cubes of their longest edges."""
    _, dN = shape_functions(kind.linear, reference_corners(kind).mean(axis=0)[:, None])
    J = np.einsum("mni,nj->mij", corners - corners[:, :1], dN[0])
    first, last = np.moveaxis(corners[:, kind.pairs], 2, 0)
    edge = np.linalg.norm(last - first, axis=2).max(axis=1)
    return np.linalg.det(J) / (6.0 if kind.simplex else 1.0), edge**3


def _check_connected(mesh: Mesh) -> None:
    """Refuse loose parts: elements hang together through edges, in space through faces."""
    kind, cells = mesh.kind, mesh.cells
    owner = np.repeat(np.arange(len(cells)), len(kind.facets))
    _, number = np.unique(mesh.facet_keys(), return_inverse=True)
    links = libs.sparse.coo_matrix(
        (np.ones(len(owner)), (owner, number.ravel())), shape=(len(cells), int(number.max()) + 1)
    ).tocsr()
    parts, label = libs.csgraph.connected_components(links @ links.T, directed=False)
    if parts == 1:
        return
    second = int(np.flatnonzero(label != label[0])[0])
    place = told_place(mesh.places[cells[second, : kind.corners]].mean(axis=0))
    facet = "edge" if kind.dimension == 2 else "face"
    raise ModelError(
        f"{mesh.source}: its elements make {parts} parts that share no {facet} (element {second} at {place} is "
        f"not in the part of element 0), expected one piece: merge nodes that "
        f"coincide, let no node hang on an edge, or make a body of each part"
    )
