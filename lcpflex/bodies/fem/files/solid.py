"""Meshes of solids from files."""

from __future__ import annotations

import os

from lcpflex.bodies.fem.files.found import FoundMesh, cell_of
from lcpflex.bodies.fem.files.reading import read_found
from lcpflex.bodies.fem.mesh import KINDS, Kind, Mesh
from lcpflex.errors import ModelError

__all__ = ["read_solid_mesh"]

SOLID = {name: kind for name, kind in KINDS.items() if kind.dimension == 3}


def read_solid_mesh(path: str | os.PathLike[str]) -> Mesh:
    """The mesh of a solid in a file, of its elements in space; those of surfaces and lines name groups alone.

    Nodes keep the order of the file, from 0. Groups of the file keep their names: as nodes, and as faces where they are
    of surfaces.

    Raises
    ------
    ModelError
        For files that cannot be read, without elements of solids, and with several or other kinds of them.
    """
    found = read_found(path)
    kind = _only_kind(found)
    groups = {name: group.nodes for name, group in found.groups.items() if group.facets is None}
    faces = {name: group.facets for name, group in found.groups.items() if group.facets is not None}
    return Mesh(kind, found.points, found.cells(kind.name), groups, found.source, faces)


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
