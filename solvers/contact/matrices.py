"""Contacts posed by a user: their matrices, dense or sparse, and the size up to which they become dense."""

from __future__ import annotations

from collections.abc import Hashable, Iterator
from dataclasses import dataclass, field
from typing import Any, Self

import numpy as np
import numpy.typing as npt

from lcpflex.basics import libs
from lcpflex.basics.arguments import numbers, point_of
from lcpflex.errors import ModelError, shown
from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.solvers.arrays import as_array, check_finite, finite_array
from lcpflex.solvers.balance import NOTHING, Units, contact_units
from lcpflex.solvers.certificate import SYMMETRY

__all__ = [
    "DENSE_LARGEST", "PosedContacts", "as_dense", "check_dense", "coefficients", "diagonal_of",
    "equals_transpose", "in_units_of", "is_sparse", "keys_of", "of_rows", "read_delassus", "read_factor", "shown_only",
]  # fmt: skip

# Rows of the largest square array that is made of a contact problem, 128 MB: beyond it all that is kept is sparse, and
# memory is linear in the entries.
DENSE_LARGEST = 4000
BLOCK = 256  # rows of the Delassus operator that exist at a time where only its factor is known


def check_dense(what: str, rows: int) -> None:
    """Raise ModelError for a square matrix of more than DENSE_LARGEST rows, which is not made dense."""
    if rows > DENSE_LARGEST:
        raise ModelError(
            f"{what} has {rows} rows: expected at most {DENSE_LARGEST}, up to which it is formed as a dense matrix; "
            "beyond, Auto() and BlockGaussSeidel() solve a ContactProblem by its sparse matrices"
        )


def shown_only(matrix: Any) -> Any:
    """The same numbers, read-only, of an array or a CSR array; None stays None."""
    if matrix is None:
        return None
    if is_sparse(matrix):
        parts = tuple(shown_only(part) for part in (matrix.data, matrix.indices, matrix.indptr))
        return libs.sparse.csr_array(parts, shape=matrix.shape)
    view = matrix.view()
    view.flags.writeable = False
    return view


def as_dense(matrix: Any) -> FloatArray:
    """A matrix of numpy or of scipy.sparse as an array."""
    return np.asarray(matrix.toarray() if hasattr(matrix, "toarray") else matrix)


def is_sparse(value: Any) -> bool:
    """Whether it is a matrix of scipy.sparse."""
    return bool(libs.sparse.issparse(value))


def diagonal_of(delassus: Any, factor: Any) -> FloatArray:
    """That of a Delassus operator, or of the product of its factor where it is None."""
    if delassus is not None:
        return np.asarray(delassus.diagonal())
    squares = factor.power(2) if is_sparse(factor) else factor**2
    return np.asarray(squares.sum(axis=1)).ravel()


def equals_transpose(matrix: Any) -> bool:
    """Whether a square matrix of numpy or of scipy.sparse equals its transpose to 1e-10 of its largest entry."""
    return not matrix.shape[0] or bool(abs(matrix - matrix.T).max() <= SYMMETRY * abs(matrix).max())


def in_units_of(delassus: Any, factor: Any, d: FloatArray) -> tuple[Any, Any]:
    """D G D and D J with D the diagonal matrix of d (m,); None stays None."""
    if factor is not None:
        factor = libs.sparse.diags_array(d) @ factor if is_sparse(factor) else factor * d[:, None]
    if is_sparse(delassus):
        delassus = libs.sparse.diags_array(d) @ delassus @ libs.sparse.diags_array(d)
    elif delassus is not None:
        delassus = delassus * np.outer(d, d)
    return delassus, factor


def of_rows(delassus: Any, factor: Any, rows: IntArray) -> tuple[Any, Any]:
    """A Delassus operator and its factor of some rows alone, the factor without columns of zeros; None stays None."""
    if delassus is not None:
        delassus = delassus[rows][:, rows] if is_sparse(delassus) else delassus[np.ix_(rows, rows)]
    if factor is not None:
        factor = factor[rows]
        moved = np.unique(factor.indices) if is_sparse(factor) else np.flatnonzero(factor.any(axis=0))
        factor = factor[:, moved]
    return delassus, factor


def read_delassus(value: Any, rows: int) -> Any:
    """A Delassus matrix as a contiguous array, or a CSR array if it is sparse or has more than DENSE_LARGEST rows.

    None stays None. rows: of the contact problem, 0 for one without contacts.
    """
    if value is None:
        return None
    if not is_sparse(value):
        given = numbers(value)
        if not rows and given is not None and not given.size:  # [] and the like, whatever their shape
            return np.zeros((0, 0))
        if given is None or given.ndim != 2 or len(given) <= DENSE_LARGEST:
            dense = as_array("delassus", value, 2)
            check_finite("delassus", dense)
            return dense
        value = libs.sparse.csr_array(given)
    return np.zeros((0, 0)) if not rows and 0 in value.shape else _read_sparse("delassus", value)


def read_factor(value: Any) -> Any:
    """A factor as a contiguous array or a CSR array of finite numbers; None stays None."""
    if value is None:
        return None
    return _read_sparse("factor", value) if is_sparse(value) else finite_array("factor", value, 2)


def _read_sparse(name: str, value: Any) -> Any:
    if value.dtype.kind not in "iuf" or value.ndim != 2:
        raise ModelError(f"{name} is {shown(value)}: expected a matrix of real numbers")
    sparse = libs.sparse.csr_array(value, dtype=float, copy=True)
    sparse.sum_duplicates()
    check_finite(f"{name}.data", sparse.data)
    return sparse


def coefficients(value: Any) -> FloatArray:
    """Friction coefficients; raises ModelError for what is none."""
    friction = finite_array("friction", value, 1)
    if (friction < 0.0).any():
        raise ModelError(f"friction is {shown(friction)}: expected coefficients >= 0")
    return friction


def keys_of(value: Any, n: int) -> tuple[Hashable, ...]:
    """Names of n contacts, their numbers where none are given; raises ModelError for what is no sequence of names."""
    try:
        keys = tuple(value) if not isinstance(value, str | bytes | set | dict) and hasattr(value, "__len__") else None
        hash(keys)
    except Exception:  # names without a hash, and sequences that are none
        keys = None
    if keys is None:
        raise ModelError(f"keys is {shown(value)}: expected a sequence of names, one for each contact")
    keys = keys or tuple(range(n))
    if len(keys) != n or len(set(keys)) != n:
        raise ModelError(f"keys has {len(keys)} entries, {len(set(keys))} different: expected {n}, one each")
    return keys


@dataclass(frozen=True, slots=True, eq=False)
class PosedContacts:
    """Contacts with velocities (or accelerations) ``G @ forces + free``; see the classes that are of it."""

    delassus: Any
    free: FloatArray
    friction: FloatArray
    keys: tuple[Hashable, ...] = ()
    factor: Any = None
    # What the arrays above show read-only: kernels would be compiled a second time for read-only arrays.
    _data: tuple[Any, FloatArray, FloatArray, Any] = field(init=False, repr=False)
    _kept: dict[str, Any] = field(default_factory=dict, init=False, repr=False)  # once asked for

    def __post_init__(self) -> None:
        friction = coefficients(self.friction)
        free = finite_array("free", self.free, 1)
        m, expected = self._rows(friction)
        delassus = read_delassus(self.delassus, m)
        factor = read_factor(self.factor)
        if delassus is None and factor is None:
            raise ModelError("delassus is None: expected a matrix, or else its factor")
        shape = (m, m) if delassus is None else delassus.shape
        if free.shape != (m,) or shape != (m, m) or (factor is not None and factor.shape[0] != m):
            given = f"factor has shape {factor.shape}" if delassus is None else f"delassus has shape {shape}"
            raise ModelError(f"{given} and free {free.shape}: expected {m} rows{expected}")
        keys = keys_of(self.keys, len(friction))
        object.__setattr__(self, "_data", (delassus, free, friction, factor))
        for name, value in zip(("delassus", "free", "friction", "factor"), self._data, strict=True):
            object.__setattr__(self, name, shown_only(value))
        object.__setattr__(self, "keys", keys)

    @staticmethod
    def _rows(friction: FloatArray) -> tuple[int, str]:
        """How many rows contacts have, and for what."""
        raise NotImplementedError

    @property
    def row_contacts(self) -> IntArray:
        """(m,) the contact of each row."""
        raise NotImplementedError

    def _rows_of(self, contacts: IntArray) -> IntArray:
        """The rows of contacts (k,), whose numbers rise."""
        raise NotImplementedError

    @property
    def unknown_units(self) -> Units:
        """The units of the unknowns, and the load."""
        raise NotImplementedError

    @property
    def units(self) -> FloatArray:
        """(n,) d_k = 1 / sqrt(max diag G_kk) of each contact: see :mod:`lcpflex.solvers.balance`."""
        if "units" not in self._kept:
            own = np.zeros(len(self.friction))
            np.maximum.at(own, self.row_contacts, self.diagonal)
            contact_units(own, len(own), NOTHING)
            self._kept["units"] = own
        return self._kept["units"]  # type: ignore[no-any-return]

    @property
    def row_units(self) -> FloatArray:
        """(m,) :attr:`units` of the contact of each row."""
        return self.units[self.row_contacts]

    @property
    def symmetric(self) -> bool:
        """Whether the Delassus operator equals its transpose to rounding."""
        if "symmetric" not in self._kept:
            self._kept["symmetric"] = self.delassus is None or equals_transpose(self._data[0])
        return self._kept["symmetric"]  # type: ignore[no-any-return]

    def balanced(self) -> Self:
        """The same contacts, each measured by its own diagonal: what comes out does not depend on units.

        With D the diagonal matrix of :attr:`row_units`: D G D and D free over a power of two; friction as it is.
        """
        if "balanced" not in self._kept:
            d, load = self.row_units, self.unknown_units.load
            delassus, factor = in_units_of(self._data[0], self._data[3], d)
            alike = type(self)(delassus, self.free / load * d, self.friction, self.keys, factor)
            alike._kept["units"] = np.ones(len(self.friction))
            self._kept["balanced"] = alike
        return self._kept["balanced"]  # type: ignore[no-any-return]

    @property
    def data(self) -> tuple[Any, FloatArray, FloatArray, Any]:
        """delassus, free, friction and factor, read-only."""
        return self.delassus, self.free, self.friction, self.factor

    @property
    def diagonal(self) -> FloatArray:
        """(m,) that of the Delassus operator."""
        return diagonal_of(self.delassus, self.factor)

    def _formed(self) -> Any:
        """The Delassus operator, or None where only its factor is known."""
        return self._data[0]

    def row_blocks(self) -> Iterator[tuple[slice, Any]]:
        """The rows of the Delassus operator, no more than BLOCK of them at a time; sparse where the factor is."""
        matrix = self._formed()
        for first in range(0, len(self.free), BLOCK):
            rows = slice(first, min(first + BLOCK, len(self.free)))
            yield rows, self.factor[rows] @ self.factor.T if matrix is None else matrix[rows]

    def dense(self) -> FloatArray:
        """The Delassus matrix (m, m) as an array, multiplied out if only its factor is known.

        Raises ModelError beyond 4000 rows.
        """
        if isinstance(self.delassus, np.ndarray):
            return self.delassus
        check_dense("the Delassus matrix", len(self.free))
        matrix = self.factor @ self.factor.T if self.delassus is None else self.delassus
        return np.ascontiguousarray(as_dense(matrix))

    def velocity(self, forces: npt.ArrayLike) -> FloatArray:
        """G @ forces + free (m,) for forces (m,), in the order of the rows."""
        x = point_of("forces", forces, len(self.free))
        delassus, _, _, factor = self._data
        product = factor @ (factor.T @ x) if delassus is None else delassus @ x
        return np.asarray(product + self.free)
