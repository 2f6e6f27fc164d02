"""Matrices and node places from the files of other programs.

| file | what it is |
|---|---|
| ``.mtx`` that begins with ``%%MatrixMarket`` | Matrix Market |
| ``.mtx`` with lines ``node, dof, node, dof, value`` | Abaqus, *MATRIX OUTPUT, FORMAT=MATRIX INPUT |
| ``.npz`` | ``scipy.sparse.save_npz``, or one array of ``numpy.savez`` |
| ``.npy`` | an array |
| ``.txt``, ``.csv`` | coordinates: lines ``x, y``, ``node, x, y``, ``x, y, z`` or ``node, x, y, z`` |
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from lcpflex.basics import libs
from lcpflex.basics.archives import load_arrays
from lcpflex.basics.arguments import lines_of, mapping_of, numbers as numbers_in
from lcpflex.bodies.body import array_of, named
from lcpflex.bodies.fem.length_unit import metres
from lcpflex.bodies.fem.matrix_texts import HEAD, ROWS, Entries, Labelled, abaqus_entries, labelled, matrix_market
from lcpflex.bodies.matrices import Matrices
from lcpflex.bodies.spatial.matrices import SpatialMatrices
from lcpflex.errors import ModelError, path_of, shown
from lcpflex.jit.kernel import FloatArray, IntArray

__all__ = ["matrices_from_files"]


def matrices_from_files(
    mass: str | os.PathLike[str],
    stiffness: str | os.PathLike[str],
    coordinates: str | os.PathLike[str] | npt.ArrayLike,
    node_sets: Mapping[str, int | Sequence[int]] | None = None,
    damping: str | os.PathLike[str] | None = None,
    *,
    faces: Mapping[str, npt.ArrayLike] | None = None,
    length_unit: str | float | None = None,
) -> Matrices | SpatialMatrices:
    """An unsupported body from the matrices of another program, M d'' + C d' + K d = forces, in the plane or in space.

    Rows are the displacements (x, y) or (x, y, z) of each node, interleaved: two or three rows for each of the
    coordinates tell which. Matrices of Abaqus name their nodes: rows are then put in the order of ascending node
    numbers, both halves or one of the symmetric matrix are read, and degrees of freedom must be 1 and 2 of every node,
    or 1, 2 and 3. Leave boundary conditions out of the step that writes them.

    Parameters
    ----------
    mass, stiffness, damping : names of files, as the module lists them [kg], [N/m], [N s/m]
    coordinates : (N, 2) or (N, 3) places of the nodes, with one more column if the numbers of the nodes come first, or
        the name of a file with such an array [m]. Without numbers the nodes come in the order of the rows.
    length_unit : of the coordinates: "m", "mm", "cm", "um", "in", "ft", or a number of metres; None: metres. The
        matrices are in kg and N/m whatever it is: multiply those of a model in mm, t, s and N by 1000
    node_sets : as for :class:`Matrices` or :class:`SpatialMatrices`; with the numbers of the nodes if the coordinates
        have them, else from 0
    faces : name -> (F, 3, 4, 6, 8 or 9) nodes of the facets of a part of the surface of a body in space, as for
        :class:`SpatialMatrices`; numbered as in ``node_sets``

    Returns
    -------
    Matrices or SpatialMatrices

    Raises
    ------
    ModelError
        For files that cannot be read or whose form is not known (the message says what was found), matrices that do
        not belong together, rotations of nodes, supports, and what :class:`Matrices` and :class:`SpatialMatrices`
        refuse.
    """
    names = {"mass": mass, "stiffness": stiffness, "damping": damping}
    read = {name: _matrix(name, path) for name, path in names.items() if path is not None or name != "damping"}
    entries = {name: value for name, value in read.items() if isinstance(value, Entries)}
    if entries and len(entries) < len(read):
        raise ModelError(f"{', '.join(names)}: some name their nodes and some do not, expected files of one form")
    table = _table_of(coordinates)
    d = _dimension(table, read["mass"], entries)
    known = {name: labelled(name, value, d) for name, value in entries.items()}
    places, numbers = _in_order(*_places(table, d), _common_labels(known))
    places = places if metres(length_unit) == 1.0 else metres(length_unit) * places
    sets = {
        name: _renumbered(f"node_sets[{name!r}]", nodes, numbers, 1).tolist() if numbers is not None else nodes
        for name, nodes in named("node_sets", {} if node_sets is None else node_sets).items()
    }
    facets = {
        name: _renumbered(f"faces[{name!r}]", nodes, numbers, 2) if numbers is not None else nodes
        for name, nodes in mapping_of("faces", {} if faces is None else faces).items()
    }
    if facets and d == 2:
        raise ModelError(f"faces: {shown(list(facets))} were given, expected none of a body in the plane")
    whole = {name: known[name].matrix if name in known else value for name, value in read.items()}
    made = SpatialMatrices if d == 3 else Matrices
    more: dict[str, Any] = {"faces": facets} if d == 3 else {}
    return made(whole["mass"], whole["stiffness"], places, sets, whole.get("damping"), **more)


def _dimension(table: FloatArray, mass: Any, entries: Mapping[str, Entries]) -> int:
    """2 or 3, by the columns of the coordinates; where three may be numbers and x, y, or x, y, z: by the matrices."""
    columns, count = table.shape[1], len(table)
    third = [name for name, value in entries.items() if (value.directions == 3).any()]
    if third and columns == 2:
        raise ModelError(
            f"{third[0]}: degree of freedom 3 was found, expected 1 and 2 only with coordinates (x, y): a planar "
            "continuum; or three coordinates of each node"
        )
    if entries and not third and columns == 4:
        raise ModelError(
            "mass: no degree of freedom 3 was found, expected 1, 2 and 3 with coordinates (number, x, y, z); or (x, y)"
        )
    if columns != 3 or entries:
        return 3 if third or columns == 4 else 2
    rows = (*np.shape(mass), 0)[0]
    if rows not in (2 * count, 3 * count):
        raise ModelError(
            f"mass: a matrix of {rows} rows was given, expected {3 * count}, three for each of the {count} rows (x, y, "
            f"z) of the coordinates, or {2 * count} if these are (number, x, y)"
        )
    return 3 if rows == 3 * count else 2


def _in_order(
    places: FloatArray, numbers: IntArray | None, labels: IntArray | None
) -> tuple[FloatArray, IntArray | None]:
    """Places and numbers of the nodes in the order of the rows of the matrices, which that of the labels is."""
    if labels is None:
        return places, numbers
    if len(places) != len(labels):
        raise ModelError(f"coordinates: {len(places)} places were given, expected those of the {len(labels)} nodes")
    if numbers is None:
        return places, None
    order = np.argsort(numbers, kind="stable")
    if not np.array_equal(numbers[order], labels):
        apart = np.setxor1d(numbers, labels)
        raise ModelError(f"coordinates: node {apart[0]} is not both there and in the matrices, expected the same nodes")
    return places[order], labels


def _common_labels(labelled: Mapping[str, Labelled]) -> IntArray | None:
    """The nodes of all the matrices: a node without mass or stiffness is none."""
    found = None
    for name, value in labelled.items():
        if found is not None and not np.array_equal(found, value.labels):
            apart = np.setxor1d(found, value.labels)
            raise ModelError(f"{name}: node {apart[0]} is not in every matrix, expected matrices of the same nodes")
        found = value.labels
    return found


def _renumbered(name: str, nodes: Any, numbers: IntArray, axes: int) -> IntArray:
    """Rows of the nodes with those numbers: of a list (``axes`` 1), or a table of facets (2)."""
    given = numbers_in(nodes)
    if given is None or max(given.ndim, 1) != axes or np.asarray(nodes).dtype.kind not in "iu":
        expected = "a node number or a sequence of them" if axes == 1 else "rows of node numbers, one a facet"
        raise ModelError(f"{name}: {shown(nodes)} was given, expected {expected}")
    given = np.atleast_1d(given)
    ascending = np.argsort(numbers, kind="stable")
    place = np.searchsorted(numbers, given, sorter=ascending)
    rows = ascending[np.minimum(place, len(numbers) - 1)]
    unknown = given[numbers[rows] != given]
    if len(unknown):
        raise ModelError(f"{name}: node {unknown[0]:g} was given, expected nodes of the coordinates")
    return np.asarray(rows)


def _path(name: str, value: Any) -> Path:
    path = path_of(name, value)
    if not path.is_file():
        raise ModelError(f"{name}: {str(value)!r} was given, expected the name of a file that is there")
    return path


def _matrix(name: str, value: Any) -> Any:
    path = _path(name, value)
    kind = path.suffix.lower()
    if kind in (".npz", ".npy"):
        return _numpy(name, path, sparse=True)
    if kind != ".mtx":
        raise ModelError(f"{name}: {str(path)!r} was given, expected a file .mtx, .npz or .npy")
    with path.open(errors="replace") as lines:
        first = lines.read(HEAD).lstrip()
    if first.lower().startswith("%%matrixmarket"):
        return matrix_market(name, path)
    return abaqus_entries(name, path)


def _numpy(name: str, path: Path, *, sparse: bool) -> Any:
    try:
        with path.open("rb") as file:  # which numpy leaves open where the file is damaged
            stored = load_arrays(file)
            if not hasattr(stored, "files"):
                return stored
            keys = list(stored.files)
            if sparse and "format" in keys and "data" in keys:
                _check_rows(stored)
                file.seek(0)
                matrix = libs.sparse.load_npz(file)
                if hasattr(matrix, "check_format"):
                    matrix.check_format(full_check=True)  # indices that point elsewhere would crash Python
                return matrix
            if len(keys) == 1:
                return stored[keys[0]]
    except Exception as error:  # numpy, zipfile and pickle each have their own
        raise ModelError(
            f"{name}: {str(path)!r} cannot be read ({str(error)[:150]}), expected arrays as numpy saves them"
        ) from None
    raise ModelError(f"{name}: {str(path)!r} holds {', '.join(keys) or 'nothing'}, expected one array or one matrix")


def _check_rows(stored: Any) -> None:
    """Raise ValueError for a sparse matrix of more rows or columns than any has: they take memory without entries."""
    shape = stored["shape"]
    if shape.shape != (2,) or shape.dtype.kind not in "iu" or not 0 <= shape.min() <= shape.max() <= ROWS:
        raise ValueError(f"its shape is {shown(shape)}, and at most {ROWS} rows and columns are read")


def _table_of(value: Any) -> FloatArray:
    """(N, 2 to 4) coordinates as they were given."""
    if isinstance(value, (str, os.PathLike)):
        path = _path("coordinates", value)
        kind = path.suffix.lower()
        if kind in (".npz", ".npy"):
            value = _numpy("coordinates", path, sparse=False)
        elif kind in (".txt", ".csv"):
            value = _table(path)
            if value.ndim != 2 or not value.size:
                raise ModelError(f"coordinates: {str(path)!r} has no rows of numbers, expected lines 'x, y'")
        else:
            raise ModelError(f"coordinates: {str(path)!r} was given, expected a file .npy, .npz, .txt or .csv")
    given = numbers_in(value)
    columns = given.shape[1] if given is not None and given.ndim == 2 else 2
    return array_of("coordinates", value if given is None else given, (-1, columns if columns in (3, 4) else 2))


def _places(table: FloatArray, d: int) -> tuple[FloatArray, IntArray | None]:
    """Places (N, d), and the numbers of the nodes if they are there."""
    if table.shape[1] == d:
        return table, None
    numbers = table[:, 0].astype(np.int64)
    if (numbers != table[:, 0]).any() or len(np.unique(numbers)) != len(numbers):
        columns = {3: "three", 4: "four"}[d + 1]
        raise ModelError(
            f"coordinates: their first of {columns} columns has no whole numbers, or one twice, expected nodes"
        )
    return table[:, 1:], numbers


def _table(path: Path) -> FloatArray:
    try:
        lines = [line.replace(",", " ") for line in lines_of("coordinates", path)]
        return np.array([[float(part) for part in line.split()] for line in lines if line.strip() and line[0] != "#"])
    except (ValueError, OSError) as error:
        raise ModelError(f"coordinates: {str(path)!r} cannot be read ({error}), expected lines 'x, y'") from None
