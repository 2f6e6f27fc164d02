"""Matrices and node places from the files of other programs.

| file | what it is |
|---|---|
| ``.mtx`` that begins with ``%%MatrixMarket`` | Matrix Market |
| ``.mtx`` with lines ``node, dof, node, dof, value`` | Abaqus, *MATRIX OUTPUT, FORMAT=MATRIX INPUT |
| ``.npz`` | ``scipy.sparse.save_npz``, or one array of ``numpy.savez`` |
| ``.npy`` | an array |
| ``.txt``, ``.csv`` | coordinates: lines ``x, y`` or ``node, x, y`` |
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from lcpflex.basics import libs
from lcpflex.basics.archives import load_arrays
from lcpflex.basics.arguments import lines_of, numbers as numbers_in
from lcpflex.bodies.body import array_of, named
from lcpflex.bodies.fem.length_unit import metres
from lcpflex.bodies.matrices import Matrices
from lcpflex.errors import ModelError, path_of, shown
from lcpflex.jit.kernel import FloatArray, IntArray

__all__ = ["matrices_from_files"]

SUPPORT = 1e30  # no stiffness is that large: such entries are penalties that hold a support

HEAD = 10_000  # characters that tell what a file is
ROWS = 10_000_000  # of a matrix; a broken header may ask for any memory


@dataclass(frozen=True, slots=True, eq=False)
class Labelled:
    """A matrix whose rows know their nodes, two each.

    Attributes
    ----------
    matrix : (2 N, 2 N) sparse
    labels : (N,) numbers of the nodes in the file, ascending
    """

    matrix: Any
    labels: IntArray


def matrices_from_files(
    mass: str | os.PathLike[str],
    stiffness: str | os.PathLike[str],
    coordinates: str | os.PathLike[str] | npt.ArrayLike,
    node_sets: Mapping[str, int | Sequence[int]] | None = None,
    damping: str | os.PathLike[str] | None = None,
    *,
    length_unit: str | float | None = None,
) -> Matrices:
    """A planar unsupported body from the matrices of another program: M d'' + C d' + K d = forces.

    Rows are the displacements (x, y) of each node, interleaved. Matrices of Abaqus name their nodes: rows are then put
    in the order of ascending node numbers, both halves or one of the symmetric matrix are read, and degrees of freedom
    must be 1 and 2 (x and y) of every node. Leave boundary conditions out of the step that writes them.

    Parameters
    ----------
    mass, stiffness, damping : names of files, as the module lists them [kg], [N/m], [N s/m]
    coordinates : (N, 2) places of the nodes, or (N, 3) with the numbers of the nodes first, or the name of a file with
        such an array [m]. Without numbers the nodes come in the order of the rows.
    length_unit : of the coordinates: "m", "mm", "cm", "um", "in", "ft", or a number of metres; None: metres. The
        matrices are in kg and N/m whatever it is: multiply those of a model in mm, t, s and N by 1000
    node_sets : as for :class:`Matrices`; with the numbers of the nodes if the coordinates have them, else from 0

    Raises
    ------
    ModelError
        For files that cannot be read or whose form is not known (the message says what was found), matrices that do
        not belong together, supports, and what :class:`Matrices` refuses.
    """
    names = {"mass": mass, "stiffness": stiffness, "damping": damping}
    read = {name: _matrix(name, path) for name, path in names.items() if path is not None or name != "damping"}
    labelled = {name: value for name, value in read.items() if isinstance(value, Labelled)}
    if labelled and len(labelled) < len(read):
        raise ModelError(f"{', '.join(names)}: some name their nodes and some do not, expected files of one form")
    labels = _common_labels(labelled)
    places, numbers = _places(coordinates)
    if labels is not None and len(places) != len(labels):
        raise ModelError(f"coordinates: {len(places)} places were given, expected those of the {len(labels)} nodes")
    if numbers is not None:
        order = np.argsort(numbers, kind="stable") if labels is not None else np.arange(len(numbers))
        if labels is not None and not np.array_equal(numbers[order], labels):
            apart = np.setxor1d(numbers, labels)
            raise ModelError(
                f"coordinates: node {apart[0]} is not both there and in the matrices, expected the same nodes"
            )
        places, numbers = places[order], numbers[order]
    sets = {
        name: _renumbered(name, nodes, numbers)
        for name, nodes in named("node_sets", {} if node_sets is None else node_sets).items()
    }
    whole = {name: value.matrix if isinstance(value, Labelled) else value for name, value in read.items()}
    unit = metres(length_unit)
    places = places if unit == 1.0 else unit * places
    return Matrices(whole["mass"], whole["stiffness"], places, sets, whole.get("damping"))


def _common_labels(labelled: Mapping[str, Labelled]) -> IntArray | None:
    """The nodes of all the matrices: a node without mass or stiffness is none."""
    found = None
    for name, value in labelled.items():
        if found is not None and not np.array_equal(found, value.labels):
            apart = np.setxor1d(found, value.labels)
            raise ModelError(f"{name}: node {apart[0]} is not in every matrix, expected matrices of the same nodes")
        found = value.labels
    return found


def _renumbered(name: str, nodes: Any, numbers: IntArray | None) -> Any:
    """Rows of the nodes with those numbers."""
    if numbers is None:
        return nodes
    given = np.atleast_1d(np.asarray(nodes))
    if given.ndim != 1 or not np.issubdtype(given.dtype, np.integer):
        raise ModelError(f"node_sets[{name!r}]: {shown(nodes)} was given, expected a node number or a sequence of them")
    row = {int(number): k for k, number in enumerate(numbers)}
    unknown = [int(node) for node in given if int(node) not in row]
    if unknown:
        raise ModelError(f"node_sets[{name!r}]: node {unknown[0]} was given, expected nodes of the coordinates")
    return [row[int(node)] for node in given]


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
        return _matrix_market(name, path)
    return _abaqus(name, path)


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


def _matrix_market(name: str, path: Path) -> Any:
    """A real matrix, sparse or dense, general or symmetric. (That of scipy crashes Python on files that were cut.)"""
    where = f"{name}: {str(path)!r}: "
    head, *lines = lines_of(name, path, "replace")
    words = head.lower().split()[1:]
    known = len(words) == 4 and words[0] == "matrix" and words[1] in ("coordinate", "array")
    if not known or words[2] not in ("real", "double", "integer") or words[3] not in ("general", "symmetric"):
        raise ModelError(f"{where}{head[:60]!r}, expected a matrix, coordinate or array, real, general or symmetric")
    text = [line for line in lines if line.strip() and not line.startswith("%")]
    try:
        shape = [int(word) for word in text[0].split()] if text else []
        numbers = np.array(" ".join(text[1:]).split(), dtype=np.float64)
    except (ValueError, OverflowError) as error:
        raise ModelError(f"{where}{error}, expected numbers") from None
    symmetric, dense = words[3] == "symmetric", words[1] == "array"
    if len(shape) != (2 if dense else 3) or shape[0] != shape[1] or min(shape) < 1 or shape[0] > ROWS:
        raise ModelError(f"{where}the size {shape} was found, expected that of a square matrix of at most {ROWS} rows")
    n = shape[0]
    count = (n * (n + 1) // 2 if symmetric else n * n) if dense else 3 * shape[2]
    if len(numbers) != count:
        raise ModelError(f"{where}{len(numbers)} numbers were found, expected {count}")
    if dense:
        columns, rows = np.triu_indices(n) if symmetric else np.indices((n, n)).reshape(2, -1)
        values = numbers
    else:
        triples = numbers.reshape(-1, 3)
        rows, columns = (triples[:, :2] - 1.0).T.astype(np.int64)
        values = triples[:, 2]
        if (triples[:, :2] != np.stack([rows, columns], axis=1) + 1).any() or not 0 <= rows.min() <= rows.max() < n:
            raise ModelError(f"{where}an entry beyond row 1 to {n} was found, expected rows of the matrix")
        if not 0 <= columns.min() <= columns.max() < n:
            raise ModelError(f"{where}an entry beyond column 1 to {n} was found, expected columns of the matrix")
    matrix = libs.sparse.coo_matrix((values, (rows, columns)), shape=(n, n)).tocsc()
    return _mirrored(matrix) if symmetric else matrix


def _mirrored(half: Any) -> Any:
    """The symmetric matrix of its entries on one side of the diagonal, and on it."""
    return (half + half.T - libs.sparse.diags_array(half.diagonal())).tocsc()


def _abaqus(name: str, path: Path) -> Labelled:
    """Lines ``node, dof, node, dof, value``; comments begin with two asterisks."""
    expected = "expected lines 'node, dof, node, dof, value' (Abaqus: *MATRIX OUTPUT, FORMAT=MATRIX INPUT)"
    rows = []
    with path.open(errors="replace") as lines:
        for number, line in enumerate(iter(lambda: lines.readline(HEAD), ""), start=1):
            text = line.strip()
            if not text or text.startswith("**"):
                continue
            where = f"{name}: {str(path)!r}, line {number}: "
            if text.startswith("*"):
                raise ModelError(f"{where}{text[:60]!r} is the matrix of an element or a substructure, {expected}")
            parts = [part for part in text.split(",") if part.strip()] if "," in text else text.split()
            if len(parts) != 5:
                seen = (
                    "three columns, as FORMAT=COORDINATE writes, which does not tell the nodes"
                    if len(parts) == 3
                    else f"{text[:60]!r}"
                )
                raise ModelError(f"{where}{seen}, {expected}")
            try:
                rows.append([float(part.replace("D", "E").replace("d", "e")) for part in parts])
            except ValueError:
                raise ModelError(f"{where}{text[:60]!r}, {expected}") from None
    if not rows:
        raise ModelError(f"{name}: {str(path)!r} has no entries, {expected}")
    return _labelled(name, np.array(rows))


def _labelled(name: str, rows: FloatArray) -> Labelled:
    """The symmetric matrix of its entries: each pair of rows once, or twice with one value."""
    heads = rows[:, :4].astype(np.int64)
    if (heads != rows[:, :4]).any() or heads[:, [0, 2]].min() < 1:
        raise ModelError(f"{name}: node {rows[:, [0, 2]].min():g} was found, expected nodes and dofs that count from 1")
    other = heads[:, [1, 3]]
    if not np.isin(other, (1, 2)).all():
        bad = other[~np.isin(other, (1, 2))][0]
        raise ModelError(f"{name}: degree of freedom {bad} was found, expected 1 and 2 only: a planar continuum")
    if not np.isfinite(rows[:, 4]).all() or np.abs(rows[:, 4]).max() >= SUPPORT:
        bad = int(np.abs(np.nan_to_num(rows[:, 4], nan=np.inf)).argmax())
        raise ModelError(
            f"{name}: an entry {rows[bad, 4]:g} at node {heads[bad, 0]} was found, a support, expected "
            f"a free-free body: leave boundary conditions out and hold the body by joints in the scene"
        )
    labels = np.unique(heads[:, [0, 2]])
    place = 2 * np.searchsorted(labels, heads[:, [0, 2]]) + other - 1
    size = 2 * len(labels)
    low, high = place.min(axis=1), place.max(axis=1)
    order = np.lexsort((place[:, 0], high, low))
    same = (np.diff(low[order]) == 0) & (np.diff(high[order]) == 0)
    first, second = order[:-1][same], order[1:][same]
    twice = (place[first] == place[second]).all(axis=1)
    if twice.any():
        node = heads[first[twice.argmax()]]
        raise ModelError(f"{name}: entry {tuple(map(int, node))} comes twice, expected each entry once")
    unequal = rows[first, 4] != rows[second, 4]
    if unequal.any():
        node = heads[first[unequal.argmax()]]
        raise ModelError(
            f"{name}: entry {tuple(map(int, node))} and its mirror image differ, expected a symmetric matrix"
        )
    once = np.setdiff1d(np.arange(len(rows)), second)
    upper = libs.sparse.coo_matrix((rows[once, 4], (low[once], high[once])), shape=(size, size)).tocsc()
    return Labelled(_mirrored(upper), labels)


def _places(value: Any) -> tuple[FloatArray, IntArray | None]:
    """Places (N, 2), and the numbers of the nodes if they are there."""
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
    array = array_of("coordinates", value if given is None else given, (-1, 3 if columns == 3 else 2))
    if columns != 3:
        return array, None
    numbers = array[:, 0].astype(np.int64)
    if (numbers != array[:, 0]).any() or len(np.unique(numbers)) != len(numbers):
        raise ModelError("coordinates: their first of three columns has no whole numbers, or one twice, expected nodes")
    return array[:, 1:], numbers


def _table(path: Path) -> FloatArray:
    try:
        lines = [line.replace(",", " ") for line in lines_of("coordinates", path)]
        return np.array([[float(part) for part in line.split()] for line in lines if line.strip() and line[0] != "#"])
    except (ValueError, OSError) as error:
        raise ModelError(f"coordinates: {str(path)!r} cannot be read ({error}), expected lines 'x, y'") from None
