"""Matrices in texts: Matrix Market, and the entries of Abaqus, which name their nodes."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from lcpflex.basics import libs
from lcpflex.basics.arguments import lines_of
from lcpflex.errors import ModelError
from lcpflex.jit.kernel import FloatArray, IntArray

__all__ = ["HEAD", "ROWS", "Entries", "Labelled", "abaqus_entries", "labelled", "matrix_market"]

SUPPORT = 1e30  # no stiffness is that large: such entries are penalties that hold a support
HEAD = 10_000  # characters that tell what a file is
BLOCK = 100_000  # lines that are made an array: as Python's numbers they take ten times the memory
ROWS = 10_000_000  # of a matrix; a broken header may ask for any memory


@dataclass(frozen=True, slots=True, eq=False)
class Labelled:
    """A matrix whose rows know their nodes, d each.

    Attributes
    ----------
    matrix : (d N, d N) sparse
    labels : (N,) numbers of the nodes in the file, ascending
    """

    matrix: Any
    labels: IntArray


@dataclass(frozen=True, slots=True, eq=False)
class Entries:
    """Entries of a matrix whose file names their nodes.

    Attributes
    ----------
    nodes, directions : (k, 2) of the row and of the column
    values : (k,)
    """

    nodes: IntArray
    directions: IntArray
    values: FloatArray

    def head(self, k: int) -> tuple[int, ...]:
        """Node, direction, node and direction of an entry."""
        return tuple(np.stack([self.nodes[k], self.directions[k]], axis=1).ravel().tolist())


def matrix_market(name: str, path: Path) -> Any:
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


def abaqus_entries(name: str, path: Path) -> Entries:
    """Lines ``node, dof, node, dof, value``; comments begin with two asterisks."""
    expected = "expected lines 'node, dof, node, dof, value' (Abaqus: *MATRIX OUTPUT, FORMAT=MATRIX INPUT)"
    rows: list[list[float]] = []
    blocks = []
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
            if len(rows) == BLOCK:
                blocks.append(np.array(rows))
                rows = []
    if not rows and not blocks:
        raise ModelError(f"{name}: {str(path)!r} has no entries, {expected}")
    return _entries(name, np.concatenate([*blocks, np.array(rows).reshape(-1, 5)]))


def _entries(name: str, rows: FloatArray) -> Entries:
    """Lines that were read, (k, 5), if they are those of displacements."""
    heads = rows[:, :4].astype(np.int64)
    if (heads != rows[:, :4]).any() or heads[:, [0, 2]].min() < 1:
        raise ModelError(f"{name}: node {rows[:, [0, 2]].min():g} was found, expected nodes and dofs that count from 1")
    other = heads[:, [1, 3]]
    if not np.isin(other, (1, 2, 3)).all():
        bad = other[~np.isin(other, (1, 2, 3))][0]
        what = "a rotation of a node of a beam or shell" if bad in (4, 5, 6) else "no displacement"
        raise ModelError(f"{name}: degree of freedom {bad} was found, {what}, expected 1, 2 and 3 only: a continuum")
    if not np.isfinite(rows[:, 4]).all() or np.abs(rows[:, 4]).max() >= SUPPORT:
        bad = int(np.abs(np.nan_to_num(rows[:, 4], nan=np.inf)).argmax())
        raise ModelError(
            f"{name}: an entry {rows[bad, 4]:g} at node {heads[bad, 0]} was found, a support, expected "
            f"a free-free body: leave boundary conditions out and hold the body by joints in the scene"
        )
    return Entries(heads[:, [0, 2]], other, rows[:, 4])


def labelled(name: str, entries: Entries, d: int) -> Labelled:
    """The symmetric matrix of its entries: each pair of rows once, or twice with one value."""
    labels = np.unique(entries.nodes)
    place = d * np.searchsorted(labels, entries.nodes) + entries.directions - 1
    size = d * len(labels)
    low, high = place.min(axis=1), place.max(axis=1)
    order = np.lexsort((place[:, 0], high, low))
    same = (np.diff(low[order]) == 0) & (np.diff(high[order]) == 0)
    first, second = order[:-1][same], order[1:][same]
    twice = (place[first] == place[second]).all(axis=1)
    if twice.any():
        raise ModelError(f"{name}: entry {entries.head(first[twice.argmax()])} comes twice, expected each entry once")
    unequal = entries.values[first] != entries.values[second]
    if unequal.any():
        entry = entries.head(first[unequal.argmax()])
        raise ModelError(f"{name}: entry {entry} and its mirror image differ, expected a symmetric matrix")
    once = np.setdiff1d(np.arange(len(place)), second)
    upper = libs.sparse.coo_matrix((entries.values[once], (low[once], high[once])), shape=(size, size)).tocsc()
    return Labelled(_mirrored(upper), labels)
