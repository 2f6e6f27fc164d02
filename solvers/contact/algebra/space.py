"""Vectors of three numbers, contacts in space.

What each function does is said in :mod:`lcpflex.solvers.contact.algebra`.
"""

from __future__ import annotations

import math

from lcpflex.jit.kernel import FloatArray, IntArray, kernel
from lcpflex.solvers.contact.algebra import vectors
from lcpflex.solvers.contact.algebra.vectors import Vector, add_sparse_row, sparse_dot


@vectors.taken.of(3)
@kernel(inline=True)
def taken(source: FloatArray, k: int, like: Vector) -> Vector:
    return source[k, 0], source[k, 1], source[k, 2]


@vectors.put.of(3)
@kernel(inline=True)
def put(target: FloatArray, k: int, value: Vector) -> None:
    target[k, 0], target[k, 1], target[k, 2] = value


@vectors.taken_at.of(3)
@kernel(inline=True)
def taken_at(source: FloatArray, row: IntArray, k: int, like: Vector) -> Vector:
    a, b, c = row[k, 0], row[k, 1], row[k, 2]
    return source[a], source[b] if b >= 0 else 0.0, source[c] if c >= 0 else 0.0


@vectors.put_at.of(3)
@kernel(inline=True)
def put_at(target: FloatArray, row: IntArray, k: int, value: Vector) -> None:
    target[row[k, 0]] = value[0]
    if row[k, 1] >= 0:
        target[row[k, 1]] = value[1]
    if row[k, 2] >= 0:
        target[row[k, 2]] = value[2]


@vectors.along_normal.of(3)
@kernel(inline=True)
def along_normal(value: float, like: Vector) -> Vector:
    return value, 0.0, 0.0


@vectors.with_normal.of(3)
@kernel(inline=True)
def with_normal(value: float, a: Vector) -> Vector:
    return value, a[1], a[2]


@vectors.less.of(3)
@kernel(inline=True)
def less(a: Vector, b: Vector) -> Vector:
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@vectors.size_of.of(3)
@kernel(inline=True)
def size_of(a: Vector) -> float:
    return max(abs(a[0]), max(abs(a[1]), abs(a[2])))


@vectors.block_times.of(3)
@kernel(inline=True)
def block_times(block: FloatArray, k: int, p: Vector) -> Vector:
    return (
        block[k, 0] * p[0] + block[k, 1] * p[1] + block[k, 2] * p[2],
        block[k, 3] * p[0] + block[k, 4] * p[1] + block[k, 5] * p[2],
        block[k, 6] * p[0] + block[k, 7] * p[1] + block[k, 8] * p[2],
    )


@vectors.rows_on.of(3)
@kernel(inline=True)
def rows_on(J: FloatArray, k: int, side: int, x: FloatArray, first: int, width: int, v: Vector) -> Vector:
    n, t, s = v
    for j in range(width):
        y = x[first + j]
        n += J[k, side, 0, j] * y
        t += J[k, side, 1, j] * y
        s += J[k, side, 2, j] * y
    return n, t, s


@vectors.add_rows.of(3)
@kernel(inline=True)
def add_rows(J: FloatArray, k: int, side: int, x: FloatArray, first: int, width: int, p: Vector) -> None:
    n, t, s = p
    for j in range(width):
        x[first + j] += J[k, side, 0, j] * n + J[k, side, 1, j] * t + J[k, side, 2, j] * s


@vectors.row_sizes.of(3)
@kernel(inline=True)
def row_sizes(J: FloatArray, k: int, side: int, x: FloatArray, first: int, width: int, v: Vector) -> Vector:
    n, t, s = v
    for j in range(width):
        y = x[first + j]
        n += abs(J[k, side, 0, j]) * y
        t += abs(J[k, side, 1, j]) * y
        s += abs(J[k, side, 2, j]) * y
    return n, t, s


@vectors.add_to_rows.of(3)
@kernel(inline=True)
def add_to_rows(matrix: FloatArray, row: IntArray, k: int, p: Vector, y: FloatArray, m: int) -> None:
    a, b, c = row[k, 0], row[k, 1], row[k, 2]
    normal = matrix[a]
    if b < 0:
        for i in range(m):
            y[i] += normal[i] * p[0]
        return
    first, second = matrix[b], matrix[c]
    for i in range(m):
        y[i] += normal[i] * p[0] + first[i] * p[1] + second[i] * p[2]


@vectors.add_block.of(3)
@kernel(inline=True)
def add_block(block: FloatArray, e: int, p: Vector, v: Vector) -> Vector:
    return (
        v[0] + (block[e, 0] * p[0] + block[e, 1] * p[1] + block[e, 2] * p[2]),
        v[1] + (block[e, 3] * p[0] + block[e, 4] * p[1] + block[e, 5] * p[2]),
        v[2] + (block[e, 6] * p[0] + block[e, 7] * p[1] + block[e, 8] * p[2]),
    )


@vectors.sparse_rows_on.of(3)
@kernel(inline=True)
def sparse_rows_on(
    row: IntArray, k: int, first: IntArray, place: IntArray, value: FloatArray, x: FloatArray, v: Vector
) -> Vector:
    return (
        v[0] + sparse_dot(row[k, 0], first, place, value, x),
        v[1] + sparse_dot(row[k, 1], first, place, value, x),
        v[2] + sparse_dot(row[k, 2], first, place, value, x),
    )


@vectors.add_sparse_rows.of(3)
@kernel(inline=True)
def add_sparse_rows(
    row: IntArray, k: int, first: IntArray, place: IntArray, value: FloatArray, x: FloatArray, p: Vector
) -> None:
    add_sparse_row(row[k, 0], first, place, value, p[0], x)
    add_sparse_row(row[k, 1], first, place, value, p[1], x)
    add_sparse_row(row[k, 2], first, place, value, p[2], x)


@vectors.slip_size.of(3)
@kernel(inline=True)
def slip_size(a: Vector) -> float:
    return abs(a[1]) + abs(a[2])


@vectors.own_size.of(3)
@kernel(inline=True)
def own_size(block: FloatArray, k: int, p: Vector) -> float:
    return float(block[k, 0] * p[0] + abs(block[k, 1] * p[1]) + abs(block[k, 2] * p[2]))


@vectors.absolute.of(3)
@kernel(inline=True)
def absolute(a: Vector) -> Vector:
    return abs(a[0]), abs(a[1]), abs(a[2])


@vectors.add_block_sizes.of(3)
@kernel(inline=True)
def add_block_sizes(block: FloatArray, e: int, p: Vector, v: Vector) -> Vector:
    return (
        v[0] + abs(block[e, 0] * p[0]) + abs(block[e, 1] * p[1]) + abs(block[e, 2] * p[2]),
        v[1] + abs(block[e, 3] * p[0]) + abs(block[e, 4] * p[1]) + abs(block[e, 5] * p[2]),
        v[2] + abs(block[e, 6] * p[0]) + abs(block[e, 7] * p[1]) + abs(block[e, 8] * p[2]),
    )


@vectors.along.of(3)
@kernel(inline=True)
def along(a: Vector, factor: float, b: Vector) -> Vector:
    return a[0] + factor * b[0], a[1] + factor * b[1], a[2] + factor * b[2]


@vectors.scaled.of(3)
@kernel(inline=True)
def scaled(factor: float, a: Vector) -> Vector:
    return factor * a[0], factor * a[1], factor * a[2]


@vectors.dot.of(3)
@kernel(inline=True)
def dot(a: Vector, b: Vector) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@vectors.lifted.of(3)
@kernel(inline=True)
def lifted(v: Vector, mu: float) -> Vector:
    return v[0] + mu * math.hypot(v[1], v[2]), v[1], v[2]
