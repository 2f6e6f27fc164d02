"""Problems in the text files of Siconos: LCPs, mixed LCPs, and frictional contact in the plane and in space.

A matrix is: how it is stored, its rows and columns, and then

* 0, dense: rows and columns once more, and the entries *column by column*;
* 1, blocks: how many, in how many rows and columns of blocks, where each of these ends, the two lengths and the arrays
  of the compressed rows of blocks, and of each block its number and its entries column by column;
* 2, sparse: where it is from (which counts for nothing here), two lines of heading as CSparse prints them, and the
  entries with their places, by column or each with both.

An LCP is n, M and q; contact is 2 or 3, the number of contacts, W, q and mu; contact of bodies ("global") is the same
with M, H, q, b and mu, where M v = H r + q and u = H^T v + b. A mixed LCP is two flags, n free unknowns and m others,
and then the limits of its blocks of rows, which of them are complementary, M and q (if the first flag is 1), or A, B,
C, D row by row, a and b (if the second is): A x + C z + a = 0 and w = D x + B z + b. What stands behind is skipped.
"""

from __future__ import annotations

import os
import re
from typing import Any

import numpy as np

from lcpflex.basics import libs
from lcpflex.basics.arguments import SHOWN, lines_of
from lcpflex.errors import ModelError, path_of
from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.solvers.contact.condensation import condensed, condensed_sparse, contact_problem
from lcpflex.solvers.contact.matrices import as_dense
from lcpflex.solvers.contact.problem import ContactProblem
from lcpflex.solvers.contact.spatial import SpatialContactProblem
from lcpflex.solvers.mixed.problems import MixedLcp
from lcpflex.solvers.problem import Lcp

__all__ = ["load_siconos", "load_siconos_contacts", "load_siconos_lcp", "load_siconos_mlcp"]

LARGEST = 8000  # rows of a matrix that becomes a dense one
MOST = 1_000_000  # rows of any
DENSE, BLOCKS, SPARSE = 0, 1, 2
_HEADING = re.compile(r"(?:(triplet|csr):\s*)?(\d+)-by-(\d+),\s*nzmax:\s*\d+\s+nnz:\s*(\d+)")


class _Reader:
    """The words of a file one after the other, with the line each is from."""

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = path_of("path", path)
        self._lines = lines_of("path", self.path)
        self._line, self._rest = 0, [] if not self._lines else self._lines[0].split()[::-1]

    @property
    def _name(self) -> str:
        return f"path {str(self.path)[-SHOWN:]!r}"

    def fail(self, what: str, expected: str) -> ModelError:
        """The error that tells where the reader is."""
        return ModelError(f"{self._name}: line {min(self._line + 1, len(self._lines))}: {what}; expected {expected}")

    def _look(self, expected: str) -> None:
        """Go to the next word."""
        while not self._rest:
            self._line += 1
            if self._line >= len(self._lines):
                raise self.fail("the file ends", expected)
            self._rest = self._lines[self._line].split()[::-1]

    def word(self, expected: str) -> str:
        """The next word."""
        self._look(expected)
        return self._rest.pop()

    def whole(self, expected: str, most: int = MOST) -> int:
        """The next word as a number from 0 to ``most``."""
        word = self.word(expected)
        if not word.isdecimal() or len(word) > 9 or int(word) > most:
            raise self.fail(f"found {word[:30]!r}", f"{expected}, a whole number from 0 to {most}")
        return int(word)

    def number(self, expected: str) -> float:
        """The next word as a finite number."""
        word = self.word(expected)
        try:
            value = float(word)
        except ValueError:
            value = float("nan")
        if not np.isfinite(value):
            raise self.fail(f"found {word[:30]!r}", f"{expected}, a finite number")
        return value

    def numbers(self, count: int, expected: str) -> FloatArray:
        """The next ``count`` numbers."""
        return np.array([self.number(f"{expected}, {count} numbers") for _ in range(count)])

    def wholes(self, count: int, expected: str, most: int) -> IntArray:
        """The next ``count`` whole numbers."""
        return np.array([self.whole(f"{expected}, {count} of them", most) for _ in range(count)], dtype=np.int64)

    def line(self, expected: str) -> str:
        """The rest of this line, or the next one that is not empty."""
        self._look(expected)
        text = " ".join(self._rest[::-1])
        self._rest = []
        return text

    def dense(self, name: str) -> FloatArray:
        """The next matrix as an array."""
        matrix = self.matrix(name)
        if max(matrix.shape) > LARGEST:
            raise self.fail(f"{name} is {matrix.shape[0]} x {matrix.shape[1]}", f"at most {LARGEST}, it becomes dense")
        return as_dense(matrix)

    def matrix(self, name: str) -> Any:
        """The next matrix, an array where it is stored so, else sparse."""
        storage = self.whole(f"the storage of {name}: 0 (dense), 1 (blocks) or 2 (sparse)", SPARSE)
        shape = self.whole(f"the rows of {name}"), self.whole(f"the columns of {name}")
        if storage == DENSE:
            if max(shape) > LARGEST:
                raise self.fail(f"{name} is {shape[0]} x {shape[1]}", f"at most {LARGEST} where it is stored densely")
            again = self.whole(f"the rows of {name} again"), self.whole(f"the columns of {name} again")
            if again != shape:
                raise self.fail(f"{name} is {again[0]} x {again[1]}", f"{shape[0]} x {shape[1]} as before")
            return self.numbers(shape[0] * shape[1], f"entries of {name}").reshape(shape[::-1]).T.copy()
        return self._blocks(name, shape) if storage == BLOCKS else self._sparse(name, shape)

    def _blocks(self, name: str, shape: tuple[int, int]) -> Any:
        count = self.whole(f"the number of blocks of {name}", MOST**2)
        rows, columns = self.whole("rows of blocks"), self.whole("columns of blocks")
        ends = [self.wholes(k, "ends of blocks", MOST) for k in (rows, columns)]
        for end, size in zip(ends, shape, strict=True):
            if (np.diff(end, prepend=0) <= 0).any() or (size and (not len(end) or end[-1] != size)):
                raise self.fail(f"blocks of {name} end at {end[:8]}", f"increasing numbers, the last of them {size}")
        lengths = self.whole("the length of the first index"), self.whole("that of the second", MOST**2)
        if lengths != (rows + 1, count):
            raise self.fail(f"indices have lengths {lengths}", f"{(rows + 1, count)}")
        first = self.wholes(lengths[0], "the first index", count)
        second = self.wholes(lengths[1], "the second index, columns of blocks", max(columns - 1, 0))
        if first[0] != 0 or first[-1] != count or (np.diff(first) < 0).any():
            raise self.fail(f"the first index is {first[:8]}", f"numbers that rise from 0 to {count}")
        found: list[tuple[IntArray, IntArray, FloatArray]] = []
        starts = [np.concatenate([[0], end[:-1]]) for end in ends]
        for i in range(rows):
            for k in range(first[i], first[i + 1]):
                number = self.whole(f"the number {k} of a block", MOST**2)
                if number != k:
                    raise self.fail(f"block {number}", f"block {k}")
                j = second[k]
                down, right = np.meshgrid(
                    np.arange(starts[0][i], ends[0][i]), np.arange(starts[1][j], ends[1][j])
                )  # columns of the block one after the other, as its entries are
                entries = self.numbers(down.size, f"entries of block {k}")
                found.append((down.ravel(), right.ravel(), entries))
        places = [np.concatenate([part[k] for part in found]) if found else np.zeros(0, dtype=np.int64) for k in (0, 1)]
        values = np.concatenate([part[2] for part in found]) if found else np.zeros(0)
        return libs.sparse.csr_array((values, tuple(places)), shape=shape)

    def _sparse(self, name: str, shape: tuple[int, int]) -> Any:
        self.whole("where the sparse matrix is from", 10)
        self.line("a line of CSparse")
        text = self.line("the heading of a sparse matrix")
        heading = _HEADING.match(text)
        if heading is None:
            raise self.fail(f"found {text[:60]!r}", "'n-by-m, nzmax: k nnz: k' as CSparse prints it")
        kind, rows, columns, count = heading.group(1), *(int(word[:9]) for word in heading.groups()[1:])
        if (rows, columns) != shape:
            raise self.fail(f"{name} is {rows} x {columns}", f"{shape[0]} x {shape[1]} as before")
        places: list[tuple[int, int]] = []
        values: list[float] = []
        done, j = 0, 0
        lines = 0 if kind == "triplet" else rows if kind == "csr" else columns  # each has a heading, empty ones too
        while done < count or lines:
            place = self.word("a column or an entry")
            if place == "col" and kind != "triplet":
                j = self.whole("the number of a column", (rows if kind == "csr" else columns) - 1)
                self.line("the places of the column")
                lines -= 1
                continue
            if done == count:
                raise self.fail(f"found {place[:30]!r}", f"the headings of {lines} more empty columns")
            if kind == "triplet":
                i, j = self._index(place, rows), self.whole("the column of an entry", columns - 1)
            else:
                i = self._index(place, columns if kind == "csr" else rows)
            colon = self.word("a colon")
            if colon != ":":
                raise self.fail(f"found {colon[:30]!r}", "a colon between place and entry")
            values.append(self.number("an entry"))
            places.append((j, i) if kind == "csr" else (i, j))
            done += 1
        down, right = np.array(places, dtype=np.int64).reshape(-1, 2).T
        return libs.sparse.csr_array((np.array(values), (down, right)), shape=shape)

    def _index(self, word: str, size: int) -> int:
        if not word.isdecimal() or len(word) > 9 or int(word) >= size:
            raise self.fail(f"found {word[:30]!r}", f"the place of an entry, 0 to {size - 1}")
        return int(word)


def load_siconos(path: str | os.PathLike[str]) -> Lcp | MixedLcp | ContactProblem | SpatialContactProblem:
    """The problem of a text file of Siconos of whichever kind: the files do not say it, but one kind alone fits.

    Raises ModelError, with what is missing for each kind, where none fits, and where several do.

    path: of the file.
    """
    file = path_of("path", path)
    name = f"path {str(file)[-SHOWN:]!r}"
    lines_of("path", file)
    loaders = (load_siconos_lcp, load_siconos_contacts, load_siconos_mlcp)
    found: list[Lcp | MixedLcp | ContactProblem | SpatialContactProblem] = []
    errors = []
    for load in loaders:
        try:
            found.append(load(path))
        except ModelError as error:
            errors.append(str(error).removeprefix(f"{name}: ")[:100])
    if len(found) == 1:
        return found[0]
    if not found:
        words = f"as LCP, {errors[0]}; as contacts, {errors[1]}; as mixed LCP, {errors[2]}"
        raise ModelError(f"{name}: {words}; expected one of these")
    kinds = ", ".join(type(one).__name__ for one in found)
    raise ModelError(f"{name}: can be read as {kinds}; expected one: load_siconos_lcp, _contacts or _mlcp tell which")


def load_siconos_lcp(path: str | os.PathLike[str]) -> Lcp:
    """The LCP of a text file of Siconos, stored densely, in blocks or sparsely.

    Raises ModelError, with the file, the line and what was expected, for anything else.

    path: of the file.
    """
    file = _Reader(path)
    n = file.whole("the number of unknowns")
    M = _square(file, file.dense("M"), n)
    return Lcp(M, file.numbers(n, "q"))


def load_siconos_contacts(path: str | os.PathLike[str]) -> ContactProblem | SpatialContactProblem:
    """The contact problem of a text file of Siconos, in the plane or in space.

    Local ones, and global ones, from which the motion of the bodies is eliminated. Raises ModelError, with the file,
    the line and what was expected, for anything else.

    path: of the file.
    """
    file = _Reader(path)
    dimension = file.whole("the dimension, 2 or 3", 3)
    if dimension < 2:
        raise file.fail(f"the dimension is {dimension}", "2 or 3")
    contacts = file.whole("the number of contacts")
    rows = contacts * dimension
    first = file.matrix("W or M")
    begins = file.word("q, or the matrix H")
    file._rest.append(begins)
    if first.shape == (rows, rows) and not _is_matrix(file, rows):
        return contact_problem(first, file.numbers(rows, "q"), file.numbers(contacts, "mu"), dimension)
    M = _square(file, first, first.shape[0])
    H = file.matrix("H")
    n = M.shape[0]
    if H.shape != (n, rows):
        raise file.fail(f"H is {H.shape[0]} x {H.shape[1]}", f"{n} x {rows}")
    f, b = file.numbers(n, "q"), file.numbers(rows, "b")
    mu = file.numbers(contacts, "mu")
    try:
        W, q = condensed(as_dense(M), as_dense(H), f, b) if n <= LARGEST else condensed_sparse(M, H, f, b)
    except ModelError as error:
        raise ModelError(f"{file._name}: {error}") from error
    return contact_problem(W, q, mu, dimension)


def _is_matrix(file: _Reader, rows: int) -> bool:
    """Whether a matrix with ``rows`` columns, and not numbers, comes next."""
    words = [*file._rest[::-1], *(w for line in file._lines[file._line + 1 : file._line + 9] for w in line.split())][:3]
    return len(words) == 3 and words[0] in ("0", "1", "2") and words[1].isdecimal() and words[2] == str(rows)


def load_siconos_mlcp(path: str | os.PathLike[str]) -> MixedLcp:
    """The mixed LCP of a text file of Siconos.

    Raises ModelError, with the file, the line and what was expected, for anything else: among it problems with more
    equations than unknowns.

    path: of the file.
    """
    file = _Reader(path)
    flags = file.whole("whether M is stored", 1), file.whole("whether A, B, C, D are stored", 1)
    n, m = file.whole("the number of free unknowns"), file.whole("the number of the others")
    if not any(flags):
        raise file.fail("neither M nor A, B, C, D is stored", "one of them")
    if flags[0]:
        ends = [file.whole("the first row of a block", n + m)]
        while ends[-1] < n + m:
            ends.append(file.whole("the first row of a block", n + m))
        if ends[0] != 0 or (np.diff(ends) < 0).any():
            raise file.fail(f"blocks begin at {ends[:8]}", f"numbers that rise from 0 to {n + m}")
        complementary = file.wholes(len(ends) - 1, "whether a block is complementary", 1)
        free = np.repeat(complementary == 0, np.diff(ends))
        if int(free.sum()) != n:
            raise file.fail(f"blocks have {int(free.sum())} free unknowns", f"{n} of them")
        M = _square(file, file.dense("M"), n + m)
        return MixedLcp(M, file.numbers(n + m, "q"), free)
    parts = [file.numbers(r * c, name).reshape(r, c) for name, r, c in (("A", n, n), ("B", m, m), ("C", n, m),
                                                                      ("D", m, n))]  # fmt: skip
    A, B, C, D = parts
    q = file.numbers(n + m, "a and b")
    return MixedLcp(np.block([[A, C], [D, B]]) if n + m else np.zeros((0, 0)), q, np.arange(n + m) < n)


def _square(file: _Reader, M: Any, n: int) -> Any:
    if M.shape != (n, n):
        raise file.fail(f"M is {M.shape[0]} x {M.shape[1]}", f"{n} x {n}, as many equations as unknowns")
    return M
