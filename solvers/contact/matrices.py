"""The matrices of a contact problem, dense or sparse: read from a user, and the size up to which they become dense."""

from __future__ import annotations

from collections.abc import Hashable
from typing import Any

import numpy as np

from lcpflex.basics import libs
from lcpflex.basics.arguments import numbers
from lcpflex.errors import ModelError, shown
from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.solvers.arrays import as_array, check_finite, finite_array

__all__ = [
    "DENSE_LARGEST",
    "as_dense",
    "check_dense",
    "coefficients",
    "diagonal_of",
    "in_units_of",
    "is_sparse",
    "keys_of",
    "of_rows",
    "read_delassus",
    "read_factor",
    "shown_only",
]

# Rows of the largest square array that is made of a contact problem, 128 MB: beyond it all that is kept is sparse, and
# memory is linear in the entries.
DENSE_LARGEST = 4000


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
