"""Vectors and rows of one contact as tuples of S numbers, the normal one first: S = 2 in the plane, 3 in space.

What iterates on contacts is written once, over a tuple ``like`` of the right length, and calls the functions here. Each
is written out for both lengths and copied into its callers: as calls they would cost a sweep half of its speed.
"""

from __future__ import annotations

import math
from typing import TypeAlias

from lcpflex.jit.kernel import FloatArray, IntArray, kernel
from lcpflex.jit.leaf import leaf
from lcpflex.solvers.contact.unrolled import unrolled

__all__ = [
    "IN_SPACE", "PLANAR", "Vector", "absolute", "add_block", "add_block_sizes", "add_rows", "add_sparse_row",
    "add_sparse_rows", "add_to_rows", "along", "along_normal", "block_times", "dot", "less", "lifted", "own_size",
    "put", "put_at", "rows_on", "scaled", "size_of", "slip_size", "sparse_dot", "sparse_rows_on", "taken",
    "taken_at", "with_normal",
]  # fmt: skip

Vector: TypeAlias = tuple[float, ...]  # S numbers
PLANAR, IN_SPACE = (0.0, 0.0), (0.0, 0.0, 0.0)  # what ``like`` is


@unrolled
def taken(source: FloatArray, k: int, like: Vector) -> Vector:
    """Row k of an array (units, S)."""
    return tuple(source[k, e] for e in range(len(like)))


@unrolled
def put(target: FloatArray, k: int, value: Vector) -> None:
    """A vector to row k of an array (units, S)."""
    for e in range(len(value)):
        target[k, e] = value[e]


@unrolled
def taken_at(source: FloatArray, row: IntArray, k: int, like: Vector) -> Vector:
    """Entries row[k] of an array by rows; row (units, S), -1 for a row that unit k does not have: 0."""
    return source[row[k, 0]], *(source[row[k, e]] if row[k, e] >= 0 else 0.0 for e in range(1, len(like)))


@unrolled
def put_at(target: FloatArray, row: IntArray, k: int, value: Vector) -> None:
    """A vector to entries row[k] of an array by rows."""
    target[row[k, 0]] = value[0]
    for e in range(1, len(value)):
        if row[k, e] >= 0:
            target[row[k, e]] = value[e]


@unrolled
def along_normal(value: float, like: Vector) -> Vector:
    """(value, 0, ...)."""
    return value, *(0.0 for _ in range(1, len(like)))


@unrolled
def with_normal(value: float, a: Vector) -> Vector:
    """The vector a with another first number."""
    return value, *(a[e] for e in range(1, len(a)))


@unrolled
def less(a: Vector, b: Vector) -> Vector:
    """Vector a - b."""
    return tuple(a[e] - b[e] for e in range(len(a)))


@unrolled
def along(a: Vector, factor: float, b: Vector) -> Vector:
    """Vector a + factor b."""
    return tuple(a[e] + factor * b[e] for e in range(len(a)))


@unrolled
def scaled(factor: float, a: Vector) -> Vector:
    """Vector factor a."""
    return tuple(factor * a[e] for e in range(len(a)))


@unrolled
def absolute(a: Vector) -> Vector:
    """Vector of abs(a_i)."""
    return tuple(abs(a[e]) for e in range(len(a)))


@unrolled
def dot(a: Vector, b: Vector) -> float:
    """Scalar product."""
    return sum(a[e] * b[e] for e in range(len(a)))


@unrolled
def size_of(a: Vector) -> float:
    """The largest abs(a_i); NaN if the first number is none."""
    return max(abs(a[e]) for e in range(len(a)))


@unrolled
def slip_size(a: Vector) -> float:
    """The sum of abs(a_i) in the tangents."""
    return sum(abs(a[e]) for e in range(1, len(a)))


@leaf
def lifted(v: Vector, mu: float) -> Vector:
    """The velocity v of a contact as if it lifted off at the rate mu times that of its slip."""
    raise NotImplementedError


@lifted.of(2)
@kernel(inline=True)
def lifted_in_plane(v: Vector, mu: float) -> Vector:
    """By abs(v_T)."""
    return v[0] + mu * abs(v[1]), v[1]


@lifted.of(3)
@kernel(inline=True)
def lifted_in_space(v: Vector, mu: float) -> Vector:
    """By the length of v_T."""
    return v[0] + mu * math.hypot(v[1], v[2]), v[1], v[2]


@unrolled
def block_times(block: FloatArray, k: int, p: Vector) -> Vector:
    """Vector W_k p; block (units, S S) by rows."""
    return tuple(sum(block[k, len(p) * e + f] * p[f] for f in range(len(p))) for e in range(len(p)))


@unrolled
def add_block(block: FloatArray, e: int, p: Vector, v: Vector) -> Vector:
    """Vector v + block_e p; block (entries, S S) by rows."""
    return tuple(v[a] + sum(block[e, len(p) * a + b] * p[b] for b in range(len(p))) for a in range(len(p)))


@unrolled
def own_size(block: FloatArray, k: int, p: Vector) -> float:
    """Size of the terms of W_k p along the normal."""
    size: float = block[k, 0] * p[0]
    for f in range(1, len(p)):
        size += abs(block[k, f] * p[f])
    return size


@unrolled
def add_block_sizes(block: FloatArray, e: int, p: Vector, v: Vector) -> Vector:
    """Vector v + abs(block_e) abs(p)."""
    for b in range(len(p)):
        v = tuple(v[a] + abs(block[e, len(p) * a + b] * p[b]) for a in range(len(v)))
    return v


@unrolled
def rows_on(J: FloatArray, k: int, side: int, x: FloatArray, first: int, width: int, v: Vector) -> Vector:
    """Vector v + J_k x of one of the two bodies of unit k; J (units, 2, S, width), x from ``first`` on."""
    for j in range(width):
        y = x[first + j]
        v = tuple(v[e] + J[k, side, e, j] * y for e in range(len(v)))
    return v


@unrolled
def add_rows(J: FloatArray, k: int, side: int, x: FloatArray, first: int, width: int, p: Vector) -> None:
    """x += J_k^T p of one of the two bodies of unit k; arrays as of :func:`rows_on`."""
    for j in range(width):
        x[first + j] += sum(J[k, side, e, j] * p[e] for e in range(len(p)))


@unrolled
def add_to_rows(matrix: FloatArray, row: IntArray, k: int, p: Vector, y: FloatArray, m: int) -> None:
    """y += matrix^T p: rows row[k] of the matrix, m entries each; -1 behind the first for those that there are not."""
    normal = matrix[row[k, 0]]
    if row[k, 1] < 0:
        for i in range(m):
            y[i] += normal[i] * p[0]
        return
    rows = tuple(matrix[row[k, e]] for e in range(len(p)))
    for i in range(m):
        y[i] += sum(rows[e][i] * p[e] for e in range(len(p)))


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


@unrolled
def sparse_rows_on(
    row: IntArray, k: int, first: IntArray, place: IntArray, value: FloatArray, x: FloatArray, v: Vector
) -> Vector:
    """Vector v + J_k x; rows row[k] of J in compressed form, none where it is -1."""
    return tuple(v[e] + sparse_dot(row[k, e], first, place, value, x) for e in range(len(v)))


@unrolled
def add_sparse_rows(
    row: IntArray, k: int, first: IntArray, place: IntArray, value: FloatArray, x: FloatArray, p: Vector
) -> None:
    """x += J_k^T p; arrays as of :func:`sparse_rows_on`."""
    for e in range(len(p)):
        add_sparse_row(row[k, e], first, place, value, p[e], x)
