"""What vectors of one contact can do; the kernels are in :mod:`.plane` and :mod:`.space`."""

from __future__ import annotations

from typing import TypeAlias

from lcpflex.jit.kernel import FloatArray, IntArray, kernel
from lcpflex.jit.leaf import leaf

__all__ = [
    "IN_SPACE",
    "PLANAR",
    "Vector",
    "add_block",
    "add_rows",
    "add_sparse_row",
    "add_sparse_rows",
    "add_to_rows",
    "along_normal",
    "block_times",
    "less",
    "put",
    "put_at",
    "row_sizes",
    "rows_on",
    "size_of",
    "sparse_dot",
    "sparse_rows_on",
    "taken",
    "taken_at",
    "with_normal",
]

Vector: TypeAlias = tuple[float, ...]  # S numbers
PLANAR, IN_SPACE = (0.0, 0.0), (0.0, 0.0, 0.0)  # what ``like`` is


@leaf
def taken(source: FloatArray, k: int, like: Vector) -> Vector:
    """Row k of an array (units, S)."""
    raise NotImplementedError


@leaf
def put(target: FloatArray, k: int, value: Vector) -> None:
    """A vector to row k of an array (units, S)."""
    raise NotImplementedError


@leaf
def taken_at(source: FloatArray, row: IntArray, k: int, like: Vector) -> Vector:
    """Entries row[k] of an array by rows; row (units, S), -1 for a row that unit k does not have: 0."""
    raise NotImplementedError


@leaf
def put_at(target: FloatArray, row: IntArray, k: int, value: Vector) -> None:
    """A vector to entries row[k] of an array by rows."""
    raise NotImplementedError


@leaf
def along_normal(value: float, like: Vector) -> Vector:
    """(value, 0, ...)."""
    raise NotImplementedError


@leaf
def with_normal(value: float, a: Vector) -> Vector:
    """The vector a with another first number."""
    raise NotImplementedError


@leaf
def less(a: Vector, b: Vector) -> Vector:
    """Vector a - b."""
    raise NotImplementedError


@leaf
def along(a: Vector, factor: float, b: Vector) -> Vector:
    """Vector a + factor b."""
    raise NotImplementedError


@leaf
def scaled(factor: float, a: Vector) -> Vector:
    """Vector factor a."""
    raise NotImplementedError


@leaf
def dot(a: Vector, b: Vector) -> float:
    """Scalar product."""
    raise NotImplementedError


@leaf
def lifted(v: Vector, mu: float) -> Vector:
    """The velocity v of a contact as if it lifted off at the rate mu times that of its slip."""
    raise NotImplementedError


@leaf
def size_of(a: Vector) -> float:
    """The largest abs(a_i); NaN if the first number is none."""
    raise NotImplementedError


@leaf
def slip_size(a: Vector) -> float:
    """The sum of abs(a_i) in the tangents."""
    raise NotImplementedError


@leaf
def own_size(block: FloatArray, k: int, p: Vector) -> float:
    """Size of the terms of W_k p along the normal."""
    raise NotImplementedError


@leaf
def block_times(block: FloatArray, k: int, p: Vector) -> Vector:
    """Vector W_k p; block (units, S S) by rows."""
    raise NotImplementedError


@leaf
def add_block(block: FloatArray, e: int, p: Vector, v: Vector) -> Vector:
    """Vector v + block_e p; block (entries, S S) by rows."""
    raise NotImplementedError


@leaf
def absolute(a: Vector) -> Vector:
    """Vector of abs(a_i)."""
    raise NotImplementedError


@leaf
def add_block_sizes(block: FloatArray, e: int, p: Vector, v: Vector) -> Vector:
    """Vector v + abs(block_e) abs(p)."""
    raise NotImplementedError


@leaf
def sparse_rows_on(
    row: IntArray, k: int, first: IntArray, place: IntArray, value: FloatArray, x: FloatArray, v: Vector
) -> Vector:
    """Vector v + J_k x; rows row[k] of J in compressed form, none where it is -1."""
    raise NotImplementedError


@leaf
def add_sparse_rows(
    row: IntArray, k: int, first: IntArray, place: IntArray, value: FloatArray, x: FloatArray, p: Vector
) -> None:
    """x += J_k^T p; arrays as of :func:`sparse_rows_on`."""
    raise NotImplementedError


@kernel(inline=True)
def sparse_dot(r: int, first: IntArray, place: IntArray, value: FloatArray, x: FloatArray) -> float:
    """J_r x; 0 without a row."""
    total = 0.0
    if r >= 0:
        for e in range(first[r], first[r + 1]):
            total += value[e] * x[place[e]]
    return total


@kernel(inline=True)
def add_sparse_row(
    r: int, first: IntArray, place: IntArray, value: FloatArray, factor: float, x: FloatArray
) -> None:  # fmt: skip
    """x += factor J_r^T."""
    if r >= 0 and factor != 0.0:
        for e in range(first[r], first[r + 1]):
            x[place[e]] += factor * value[e]


@leaf
def rows_on(J: FloatArray, k: int, side: int, x: FloatArray, first: int, width: int, v: Vector) -> Vector:
    """Vector v + J_k x of one of the two bodies of unit k; J (units, 2, S, width), x from ``first`` on."""
    raise NotImplementedError


@leaf
def add_rows(J: FloatArray, k: int, side: int, x: FloatArray, first: int, width: int, p: Vector) -> None:
    """x += J_k^T p of one of the two bodies of unit k; arrays as of :func:`rows_on`."""
    raise NotImplementedError


@leaf
def row_sizes(J: FloatArray, k: int, side: int, x: FloatArray, first: int, width: int, v: Vector) -> Vector:
    """Vector v + abs(J_k) x of one of the two bodies of unit k; arrays as of :func:`rows_on`."""
    raise NotImplementedError


@leaf
def add_to_rows(matrix: FloatArray, row: IntArray, k: int, p: Vector, y: FloatArray, m: int) -> None:
    """y += matrix^T p: rows row[k] of the matrix, m entries each."""
    raise NotImplementedError
