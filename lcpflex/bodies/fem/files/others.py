"""Files of other formats, through meshio or meshlane, whichever is installed: VTK, MED, Nastran, Fluent and more."""

from __future__ import annotations

import contextlib
import io
import warnings
from collections.abc import Sequence
from typing import Any

import numpy as np

from lcpflex.basics import libs
from lcpflex.bodies.fem.files.found import CELLS, FoundMesh, Part, Unreadable, cell_of, grouped
from lcpflex.jit.kernel import FloatArray, IntArray

__all__ = ["read_other"]

ASKED = 100  # times that a reader may find the end of a file
MISSING = (
    "neither meshio nor meshlane is installed, expected one for files of its format: pip install 'lcpflex[meshes]'"
)


def read_other(name: str, source: str) -> FoundMesh:
    """The mesh in a file of that name; raises Unreadable for anything else."""
    found = _read(_library(), name)
    points = _places(found.points)
    blocks = [(str(block.type), _cells(str(block.type), block.data, len(points))) for block in found.cells]
    try:
        sets = {str(key): np.asarray(nodes, dtype=np.int64) for key, nodes in (found.point_sets or {}).items()}
        sources = [_cell_sets(found, blocks), _physical(found, blocks)]
    except (IndexError, ValueError, TypeError, KeyError) as error:
        raise Unreadable(f"its groups do not fit its elements ({error}), expected sets of them") from None
    for key, nodes in sets.items():
        if nodes.size and not 0 <= nodes.min() <= nodes.max() < len(points):
            raise Unreadable(f"group {key!r} has nodes that are not there, expected 0 to {len(points) - 1}")
    groups = grouped(sets, sources, {kind for kind, cells in blocks if len(cells)})
    return FoundMesh(points, blocks, groups, source, _stored(found))


def _library() -> Any:
    for library in ("meshio", "meshlane"):
        try:
            return getattr(libs, library)
        except ImportError:
            continue
    raise Unreadable(MISSING)


def _read(library: Any, name: str) -> Any:
    """What the library reads; its own talk is kept off the terminal, and becomes the message of the error."""
    talk = io.StringIO()
    try:
        with contextlib.redirect_stdout(talk), contextlib.redirect_stderr(talk), warnings.catch_warnings():
            warnings.simplefilter("ignore")
            if not name.lower().endswith(".msh"):
                return library.read(name)
            with _CutFile(io.FileIO(name)) as file:  # of Fluent, and its reader knows no end
                return library.read(file, "ansys")
    except SystemExit:  # meshio leaves the program where no reader takes the file
        said = " ".join(talk.getvalue().split())
    except ImportError as error:  # of a library that a format needs
        said = f"{error}"
    except Exception as error:  # the readers raise whatever a broken file makes them stumble over
        said = f"{type(error).__name__}: {error}"
    raise Unreadable(f"{library.__name__} cannot read it ({said}), expected a mesh in a format that it knows")


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


def _places(points: Any) -> FloatArray:
    """(N, 3) places; those of planar files get z = 0."""
    try:
        places = np.asarray(points, dtype=np.float64)
    except (TypeError, ValueError):
        raise Unreadable("its points are no numbers, expected two or three coordinates each") from None
    if places.ndim != 2 or places.shape[1] not in (2, 3) or not len(places):
        raise Unreadable(f"points of shape {places.shape}, expected two or three coordinates each")
    return places if places.shape[1] == 3 else np.column_stack([places, np.zeros(len(places))])


def _cells(kind: str, data: Any, count: int) -> IntArray:
    """Nodes of the elements of a block; those of kinds without a fixed number of nodes are but counted."""
    try:
        cells = np.asarray(data)
    except ValueError:  # polygons and polyhedra of several sizes
        cells = np.zeros(0)
    if kind not in CELLS and (cells.ndim != 2 or cells.dtype.kind not in "iu"):
        return np.zeros((len(data), 0), dtype=np.int64)
    if cells.ndim != 2 or (cells.size and cells.dtype.kind not in "iu"):
        raise Unreadable(f"{kind} that are no lists of nodes, expected numbers of nodes")
    if cells.size and not 0 <= cells.min() <= cells.max() < count:
        raise Unreadable(f"elements with nodes that it does not have, expected 0 to {count - 1}")
    if kind in CELLS and cells.size and cells.shape[1] != CELLS[kind].nodes:
        raise Unreadable(f"{kind} of {cells.shape[1]} nodes, expected {CELLS[kind].nodes}")
    return cells.astype(np.int64)


def _cell_sets(found: Any, blocks: Sequence[tuple[str, IntArray]]) -> list[Part]:
    return [
        (str(name), kind, cells[np.asarray(chosen, dtype=np.int64)])
        for name, of_blocks in (found.cell_sets or {}).items()
        if not str(name).startswith("gmsh:")  # meshio's own bookkeeping
        for (kind, cells), chosen in zip(blocks, of_blocks, strict=False)
        if chosen is not None and len(chosen)
    ]


def _physical(found: Any, blocks: Sequence[tuple[str, IntArray]]) -> list[Part]:
    """Physical groups in the way of Gmsh; one without a name is called by its number."""
    tags = (found.cell_data or {}).get("gmsh:physical")
    if tags is None:
        return []
    names = {(int(value[1]), int(value[0])): str(name) for name, value in (found.field_data or {}).items()}
    parts = []
    for (kind, cells), of_cells in zip(blocks, tags, strict=True):
        cell = cell_of(kind)
        if cell is not None:
            for tag in np.unique(of_cells)[np.unique(of_cells) != 0]:  # 0: in no group
                name = names.get((cell.dimension, int(tag)), str(int(tag)))
                parts.append((name, kind, cells[np.asarray(of_cells) == tag]))
    return parts


def _stored(found: Any) -> dict[str, list[FloatArray]]:
    """Numbers of scikit-fem; its own reader says what is wrong with them."""
    return {str(name): list(values) for name, values in (found.cell_data or {}).items() if name.startswith("skfem:")}
