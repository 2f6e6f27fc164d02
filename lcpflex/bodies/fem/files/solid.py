"""Meshes of solids from files."""

from __future__ import annotations

import os

import numpy as np

from lcpflex.bodies.fem.files.found import FoundMesh, cell_of
from lcpflex.bodies.fem.files.reading import read_found
from lcpflex.bodies.fem.mesh import KINDS, Kind, Mesh
from lcpflex.errors import ModelError
from lcpflex.jit.kernel import IntArray

__all__ = ["read_solid_mesh"]

SOLID = {name: kind for name, kind in KINDS.items() if kind.dimension == 3}


def read_solid_mesh(path: str | os.PathLike[str]) -> Mesh:
    """The mesh of a solid in a file, of its elements in space; those of surfaces and lines name groups alone.

    Nodes keep the order of the file, from 0. Groups of the file keep their names: as faces where they are of the
    surface of the solid, as nodes elsewhere, between two of its materials, say.

    Raises
    ------
    ModelError
        For files that cannot be read, without elements of solids, and with several or other kinds of them.
    """
    found = read_found(path)
    kind = _only_kind(found)
    cells = found.cells(kind.name)
    faces = _outer(
        kind, cells, {name: group.facets for name, group in found.groups.items() if group.facets is not None}
    )
    groups = {name: group.nodes for name, group in found.groups.items() if name not in faces}
    return Mesh(kind, found.points, cells, groups, found.source, faces)


def _outer(kind: Kind, cells: IntArray, faces: dict[str, IntArray]) -> dict[str, IntArray]:
    """Those of the faces of which each facet is one of one element."""
    if not faces:
        return {}
    every = np.sort(np.concatenate(list(faces.values())), axis=1)
    near = np.zeros(int(cells.max()) + 1, dtype=np.bool_)  # nodes of the faces: no others need be looked at
    near[every[every < len(near)]] = True
    corners = np.array([facet[: kind.facet_corners] for facet in kind.facets])
    own = np.concatenate([facets[near[facets].all(axis=1)] for facets in (cells[:, nodes] for nodes in corners)])
    _, number = np.unique(np.concatenate([np.sort(own, axis=1), every]), axis=0, return_inverse=True)
    number = number.ravel()
    count = np.bincount(number[: len(own)], minlength=int(number.max()) + 1)
    outer = np.split(count[number[len(own) :]] == 1, np.cumsum([len(facets) for facets in faces.values()])[:-1])
    return {name: facets for (name, facets), on in zip(faces.items(), outer, strict=True) if on.all()}


def _only_kind(found: FoundMesh) -> Kind:
    counts = found.counts()
    solid = {name: count for name, count in counts.items() if (cell := cell_of(name)) is None or cell.dimension == 3}
    if len(solid) == 1 and next(iter(solid)) in SOLID:
        return SOLID[next(iter(solid))]
    told = ", ".join(f"{count} {name}" for name, count in (solid or counts).items()) or "(none)"
    hint = "" if solid else ": a mesh of surfaces or lines has no volume (in Gmsh: Mesh 3)"
    raise ModelError(
        f"{found.source}: elements {told} were found, expected those of one kind of {', '.join(SOLID)}{hint}"
    )
