"""Planar meshes from files."""

from __future__ import annotations

import os
from typing import Any

import numpy as np

from lcpflex.basics import libs
from lcpflex.bodies.fem.files.found import FoundMesh
from lcpflex.bodies.fem.files.numbering import EXACT
from lcpflex.bodies.fem.files.reading import read_found
from lcpflex.bodies.fem.mesh import FLAT, KINDS, Mesh
from lcpflex.errors import ModelError
from lcpflex.jit.kernel import FloatArray, IntArray

__all__ = ["read_mesh"]

PLANAR = {name: kind for name, kind in KINDS.items() if kind.dimension == 2}
LINES = ("vertex", "line", "line3")  # what a planar mesh may hold besides: it names points and edges


def read_mesh(path: str | os.PathLike[str]) -> Any:
    """The planar mesh in a file: a :class:`Mesh`, or the mesh of scikit-fem that was stored there.

    Nodes keep the order of the file, from 0. Groups of the file keep their names: physical groups of Gmsh, node and
    element sets of Abaqus, and what scikit-fem stores with its meshes.

    Raises
    ------
    ModelError
        For files that cannot be read, spatial meshes, and elements of several or other kinds.
    """
    found = read_found(path)
    kind = _only_kind(found)
    places = _planar(found.points, found.source)
    cells = found.cells(kind)
    if found.tags:
        return _stored_by_scikit_fem(found, kind, places, cells)
    # A name of points or edges stands for them, whatever else it may name.
    groups = {name: group.nodes for name, group in found.groups.items()}
    return Mesh(PLANAR[kind], places, cells, groups, found.source)


def _stored_by_scikit_fem(found: FoundMesh, kind: str, places: FloatArray, cells: IntArray) -> Any:
    """Its names stand for elements, "skfem:s:name" with 1 for each of them, or facets: bit k of "skfem:b:name"."""
    make = getattr(libs.skfem, PLANAR[kind].mesh)
    p, t = np.ascontiguousarray(places.T), np.ascontiguousarray(cells.T)
    try:
        _check_tags(found)
        bare = make(p, t, validate=False)
        names: dict[str, dict[str, Any]] = {"s": {}, "b": {}}
        for key, of_blocks in found.tags.items():
            _, what, name = key.split(":", 2)
            values = np.concatenate([v for (k, _), v in zip(found.blocks, of_blocks, strict=True) if k == kind])
            whole = values.astype(np.int64)
            if values.shape != (len(cells),) or (whole != values).any() or whole.min() < 0:
                raise ValueError(f"{key} has other values than a whole number for each element")
            if what == "s":
                names["s"][name] = np.flatnonzero(whole)
            else:
                bits = (1 << np.arange(bare.refdom.nfacets))[:, None] & whole
                names[what][name] = np.unique(bare.t2f[bits != 0])
        return make(p, t, names["b"] or None, names["s"] or None)
    except Exception as error:  # scikit-fem raises whatever its parts stumble over
        raise ModelError(
            f"{found.source}: scikit-fem cannot read its tags ({error}), expected a file that it saved"
        ) from None


def _check_tags(found: FoundMesh) -> None:
    for name, of_blocks in found.tags.items():
        for values in of_blocks:
            if not (np.abs(np.asarray(values, dtype=np.float64)) < EXACT).all():
                raise ValueError(f"{name} has values that are no whole numbers")


def _only_kind(found: FoundMesh) -> str:
    """The one kind of planar elements."""
    kinds = sorted(set(found.counts()) - set(LINES))
    if len(kinds) == 1 and kinds[0] in PLANAR:
        return kinds[0]
    hint = ""
    if "quad8" in kinds:
        hint = "; quadrilaterals of second order have nine nodes here (Gmsh: Mesh.SecondOrderIncomplete = 0)"
    raise ModelError(
        f"{found.source}: elements {', '.join(kinds) or '(none)'} were found, expected one kind of "
        f"{', '.join(PLANAR)}{hint}"
    )


def _planar(points: FloatArray, source: str) -> FloatArray:
    """(N, 2) places; refuses a mesh that leaves its plane."""
    extent = float(np.ptp(points, axis=0).max())
    height = np.abs(points[:, 2])
    if not height.max() <= FLAT * extent:
        raise ModelError(
            f"{source}: node {int(height.argmax())} has z = {points[height.argmax(), 2]:.6g}, expected a mesh "
            f"in the plane z = 0"
        )
    return np.ascontiguousarray(points[:, :2])
