"""Vectors of two numbers, contacts in the plane.

What each function does is said in :mod:`lcpflex.solvers.contact.algebra`.
"""

from __future__ import annotations

from lcpflex.jit.kernel import FloatArray, IntArray, kernel
from lcpflex.solvers.contact.algebra import vectors
from lcpflex.solvers.contact.algebra.vectors import Vector, add_sparse_row, sparse_dot


@vectors.taken.of(2)
@kernel(inline=True)
def taken(source: FloatArray, k: int, like: Vector) -> Vector:
    return source[k, 0], source[k, 1]


@vectors.put.of(2)
@kernel(inline=True)
def put(target: FloatArray, k: int, value: Vector) -> None:
    target[k, 0], target[k, 1] = value


@vectors.taken_at.of(2)
@kernel(inline=True)
def taken_at(source: FloatArray, row: IntArray, k: int, like: Vector) -> Vector:
    a, b = row[k, 0], row[k, 1]
    return source[a], source[b] if b >= 0 else 0.0


@vectors.put_at.of(2)
@kernel(inline=True)
def put_at(target: FloatArray, row: IntArray, k: int, value: Vector) -> None:
    target[row[k, 0]] = value[0]
    if row[k, 1] >= 0:
        target[row[k, 1]] = value[1]


@vectors.along_normal.of(2)
@kernel(inline=True)
def along_normal(value: float, like: Vector) -> Vector:
    return value, 0.0


@vectors.with_normal.of(2)
@kernel(inline=True)
def with_normal(value: float, a: Vector) -> Vector:
    return value, a[1]


@vectors.less.of(2)
@kernel(inline=True)
def less(a: Vector, b: Vector) -> Vector:
    return a[0] - b[0], a[1] - b[1]


@vectors.size_of.of(2)
@kernel(inline=True)
def size_of(a: Vector) -> float:
    return max(abs(a[0]), abs(a[1]))


@vectors.block_times.of(2)
@kernel(inline=True)
def block_times(block: FloatArray, k: int, p: Vector) -> Vector:
    return (
        block[k, 0] * p[0] + block[k, 1] * p[1],
        block[k, 2] * p[0] + block[k, 3] * p[1],
    )


@vectors.rows_on.of(2)
@kernel(inline=True)
def rows_on(J: FloatArray, k: int, side: int, x: FloatArray, first: int, width: int, v: Vector) -> Vector:
    n, t = v
    for j in range(width):
        y = x[first + j]
        n += J[k, side, 0, j] * y
        t += J[k, side, 1, j] * y
    return n, t


@vectors.add_rows.of(2)
@kernel(inline=True)
def add_rows(J: FloatArray, k: int, side: int, x: FloatArray, first: int, width: int, p: Vector) -> None:
    n, t = p
    for j in range(width):
        x[first + j] += J[k, side, 0, j] * n + J[k, side, 1, j] * t


@vectors.row_sizes.of(2)
@kernel(inline=True)
def row_sizes(J: FloatArray, k: int, side: int, x: FloatArray, first: int, width: int, v: Vector) -> Vector:
    n, t = v
    for j in range(width):
        y = x[first + j]
        n += abs(J[k, side, 0, j]) * y
        t += abs(J[k, side, 1, j]) * y
    return n, t


@vectors.add_to_rows.of(2)
@kernel(inline=True)
def add_to_rows(matrix: FloatArray, row: IntArray, k: int, p: Vector, y: FloatArray, m: int) -> None:
    a, b = row[k, 0], row[k, 1]
    normal = matrix[a]
    if b < 0:
        for i in range(m):
            y[i] += normal[i] * p[0]
        return
    tangent = matrix[b]
    for i in range(m):
        y[i] += normal[i] * p[0] + tangent[i] * p[1]


@vectors.add_block.of(2)
@kernel(inline=True)
def add_block(block: FloatArray, e: int, p: Vector, v: Vector) -> Vector:
    return (
        v[0] + (block[e, 0] * p[0] + block[e, 1] * p[1]),
        v[1] + (block[e, 2] * p[0] + block[e, 3] * p[1]),
    )


@vectors.sparse_rows_on.of(2)
@kernel(inline=True)
def sparse_rows_on(
    row: IntArray, k: int, first: IntArray, place: IntArray, value: FloatArray, x: FloatArray, v: Vector
) -> Vector:
    return (
        v[0] + sparse_dot(row[k, 0], first, place, value, x),
        v[1] + sparse_dot(row[k, 1], first, place, value, x),
    )


@vectors.add_sparse_rows.of(2)
@kernel(inline=True)
def add_sparse_rows(
    row: IntArray, k: int, first: IntArray, place: IntArray, value: FloatArray, x: FloatArray, p: Vector
) -> None:
    add_sparse_row(row[k, 0], first, place, value, p[0], x)
    add_sparse_row(row[k, 1], first, place, value, p[1], x)


@vectors.slip_size.of(2)
@kernel(inline=True)
def slip_size(a: Vector) -> float:
    return abs(a[1])


@vectors.own_size.of(2)
@kernel(inline=True)
def own_size(block: FloatArray, k: int, p: Vector) -> float:
    return float(block[k, 0] * p[0] + abs(block[k, 1] * p[1]))


@vectors.absolute.of(2)
@kernel(inline=True)
def absolute(a: Vector) -> Vector:
    return abs(a[0]), abs(a[1])


@vectors.add_block_sizes.of(2)
@kernel(inline=True)
def add_block_sizes(block: FloatArray, e: int, p: Vector, v: Vector) -> Vector:
    return (
        v[0] + abs(block[e, 0] * p[0]) + abs(block[e, 1] * p[1]),
        v[1] + abs(block[e, 2] * p[0]) + abs(block[e, 3] * p[1]),
    )


@vectors.along.of(2)
@kernel(inline=True)
def along(a: Vector, factor: float, b: Vector) -> Vector:
    return a[0] + factor * b[0], a[1] + factor * b[1]


@vectors.scaled.of(2)
@kernel(inline=True)
def scaled(factor: float, a: Vector) -> Vector:
    return factor * a[0], factor * a[1]


@vectors.dot.of(2)
@kernel(inline=True)
def dot(a: Vector, b: Vector) -> float:
    return a[0] * b[0] + a[1] * b[1]


@vectors.lifted.of(2)
@kernel(inline=True)
def lifted(v: Vector, mu: float) -> Vector:
    return v[0] + mu * abs(v[1]), v[1]
