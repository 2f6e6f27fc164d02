"""Meshes from files, through meshio: Gmsh, Abaqus, VTK and its other formats.

Nodes keep the order of the file, from 0. Groups of the file keep their names: physical groups of Gmsh, node and
element sets of Abaqus, and what scikit-fem stores with its meshes.
"""

from __future__ import annotations

import contextlib
import io
import os
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from lcpflex.basics import libs
from lcpflex.basics.arguments import LARGEST_TEXT
from lcpflex.bodies.fem.planar_mesh import FLAT, KINDS, PlanarMesh
from lcpflex.errors import ModelError, path_of, shown
from lcpflex.jit.kernel import FloatArray, IntArray

__all__ = ["read_mesh"]

LINES = ("vertex", "line", "line3")  # what a planar mesh may hold besides: it names points and edges
ABAQUS = {"3": "CPS3", "4": "CPS4", "6": "CPE6", "8": "S8R"}  # by number of nodes: the names that meshio knows
ASKED = 100  # times that a reader may find the end of a file
ABAQUS_TYPE = re.compile(r"(?im)^(\*element\b.*?\btype\s*=\s*)(?:cps|cpe|cax)([3468])\w*")


def read_mesh(path: str | os.PathLike[str]) -> Any:
    """The planar mesh in a file: a :class:`PlanarMesh`, or the mesh of scikit-fem that was stored there.

    Raises
    ------
    ModelError
        For files that cannot be read, spatial meshes, and elements of several or other kinds.
    """
    name = str(path_of("mesh", path))
    source = f"mesh {name!r}"
    if not Path(name).is_file():
        raise ModelError(f"mesh: {shown(name)} was given, expected the name of a file that is there")
    if Path(name).stat().st_size > LARGEST_TEXT:
        raise ModelError(f"{source}: it is too large, expected a file of at most {LARGEST_TEXT:.0e} bytes")
    found = _read(name, source)
    kind = _only_kind(found, source)
    found.points = places = _planar(np.asarray(found.points, dtype=np.float64), source)
    for block in found.cells:
        nodes = np.asarray(block.data)
        if nodes.size and not 0 <= nodes.min() <= nodes.max() < len(places):
            raise ModelError(f"{source}: elements with nodes that it does not have, expected 0 to {len(places) - 1}")
        if block.type == kind and nodes.ndim == 2 and nodes.shape[1] != KINDS[kind].nodes:
            raise ModelError(f"{source}: {kind} of {nodes.shape[1]} nodes, expected {KINDS[kind].nodes}")
    if any(key.startswith("skfem:") for key in found.cell_data):
        return _stored_by_scikit_fem(found, source)
    cells = np.concatenate([np.asarray(block.data) for block in found.cells if block.type == kind]).astype(np.int64)
    return PlanarMesh(KINDS[kind], places, cells, _groups(found, source), source)


def _stored_by_scikit_fem(found: Any, source: str) -> Any:
    try:
        return libs.from_meshio(found)
    except Exception as error:  # its tags have no checks of their own
        raise ModelError(
            f"{source}: scikit-fem cannot read its tags ({error}), expected a file that it saved"
        ) from None


def _read(name: str, source: str) -> Any:
    """What meshio reads; its own talk is kept off the terminal, and becomes the message of the error."""
    talk = io.StringIO()
    try:
        with contextlib.redirect_stdout(talk), contextlib.redirect_stderr(talk):
            if name.lower().endswith(".inp"):
                return _read_abaqus(name)
            if name.lower().endswith(".msh"):
                return _read_msh(name)
            return libs.meshio.read(name)
    except SystemExit:  # meshio leaves the program where no reader takes the file
        said = " ".join(talk.getvalue().split())
    except Exception as error:  # the readers raise whatever a broken file makes them stumble over
        said = f"{type(error).__name__}: {error}"
    raise ModelError(f"{source}: meshio cannot read it ({said}), expected a mesh in a format that it knows")


class _CutFile(io.BufferedReader):
    """A file that raises EOFError where a reader asks for more behind its end again and again."""

    asked = 0

    def read(self, size: int | None = -1, /) -> bytes:
        return self._counted(super().read(size))

    def readline(self, size: int | None = -1, /) -> bytes:
        return self._counted(super().readline(size))

    def _counted(self, found: bytes) -> bytes:
        self.asked += not found
        if self.asked > ASKED:
            raise EOFError("it ends too soon")
        return found


def _read_msh(name: str) -> Any:
    """A file of Gmsh, or one of Fluent, which begins with a parenthesis; meshio's reader of those knows no end."""
    with _CutFile(io.FileIO(name)) as file:
        if file.peek(1)[:1] != b"(":
            return libs.meshio.read(name, "gmsh")
        return libs.meshio.read(file, "ansys")


def _read_abaqus(name: str) -> Any:
    """An Abaqus input file, with the planar and axisymmetric element types that meshio has no name for."""
    text = Path(name).read_text(errors="replace")
    translated = ABAQUS_TYPE.sub(lambda match: match[1] + ABAQUS[match[2]], text)
    if translated == text or re.search(r"(?im)^\*include", text):
        return libs.meshio.read(name)
    return libs.meshio.abaqus._abaqus.read_buffer(io.StringIO(translated))


def _only_kind(found: Any, source: str) -> str:
    """The one kind of planar elements."""
    kinds = sorted({block.type for block in found.cells if len(block.data)} - set(LINES))
    if len(kinds) == 1 and kinds[0] in KINDS:
        return kinds[0]
    hint = ""
    if "quad8" in kinds:
        hint = "; quadrilaterals of second order have nine nodes here (Gmsh: Mesh.SecondOrderIncomplete = 0)"
    raise ModelError(
        f"{source}: elements {', '.join(kinds) or '(none)'} were found, expected one kind of {', '.join(KINDS)}{hint}"
    )


def _planar(points: FloatArray, source: str) -> FloatArray:
    """(N, 2) places; refuses a mesh that leaves its plane."""
    if points.ndim != 2 or points.shape[1] not in (2, 3) or not len(points):
        raise ModelError(f"{source}: points of shape {points.shape}, expected two or three coordinates each")
    if points.shape[1] == 3:
        extent = float(np.ptp(points, axis=0).max())
        height = np.abs(points[:, 2])
        if not height.max() <= FLAT * extent:
            raise ModelError(
                f"{source}: node {int(height.argmax())} has z = {points[height.argmax(), 2]:.6g}, expected a mesh "
                f"in the plane z = 0"
            )
    return np.ascontiguousarray(points[:, :2])


def _groups(found: Any, source: str) -> dict[str, IntArray]:
    """Named nodes: of edges and points first, then of areas; a name that comes twice keeps its first meaning."""
    try:
        groups = _named_nodes(found)
    except (IndexError, ValueError, TypeError) as error:
        raise ModelError(f"{source}: its groups do not fit its elements ({error}), expected sets of them") from None
    for name, nodes in groups.items():
        if nodes[0] < 0 or nodes[-1] >= len(found.points):
            raise ModelError(
                f"{source}: group {name!r} has nodes that are not there, expected 0 to {len(found.points) - 1}"
            )
    return groups


def _named_nodes(found: Any) -> dict[str, IntArray]:
    groups: dict[str, IntArray] = {str(k): np.asarray(v, dtype=np.int64) for k, v in (found.point_sets or {}).items()}
    for wanted in (lambda kind: kind in LINES, lambda kind: kind in KINDS):
        for name, nodes in (*_cell_sets(found, wanted), *_physical(found, wanted)):
            groups.setdefault(name, nodes)
    return {name: np.unique(nodes) for name, nodes in groups.items() if len(nodes)}


def _cell_sets(found: Any, wanted: Callable[[str], bool]) -> Iterator[tuple[str, IntArray]]:
    for name, blocks in (found.cell_sets or {}).items():
        if str(name).startswith("gmsh:"):
            continue  # meshio's own bookkeeping
        parts = [
            np.asarray(block.data)[np.asarray(chosen, dtype=np.int64)].ravel()
            for block, chosen in zip(found.cells, blocks, strict=False)
            if chosen is not None and len(chosen) and wanted(block.type)
        ]
        if parts:
            yield str(name), np.concatenate(parts).astype(np.int64)


def _physical(found: Any, wanted: Callable[[str], bool]) -> Iterator[tuple[str, IntArray]]:
    """Physical groups of Gmsh; one without a name is called by its number."""
    tags = (found.cell_data or {}).get("gmsh:physical")
    if tags is None:
        return
    names = {(int(value[1]), int(value[0])): name for name, value in (found.field_data or {}).items()}
    nodes: dict[str, list[IntArray]] = {}
    for block, of_cells in zip(found.cells, tags, strict=True):
        if not wanted(block.type):
            continue
        dimension = 0 if block.type == "vertex" else 1 if block.type in LINES else 2
        for tag in np.unique(of_cells):
            if tag:  # 0: in no group
                name = names.get((dimension, int(tag)), str(int(tag)))
                nodes.setdefault(name, []).append(np.asarray(block.data)[np.asarray(of_cells) == tag].ravel())
    for name, parts in nodes.items():
        yield name, np.concatenate(parts).astype(np.int64)
