"""W as one matrix. Velocities are kept up to date by its columns: a change of one force is one pass over memory."""

from __future__ import annotations

from lcpflex.jit.kernel import FloatArray, IntArray, kernel
from lcpflex.jit.struct import array, struct
from lcpflex.solvers.contact import operators
from lcpflex.solvers.contact.algebra import Vector, add_to_rows, taken, taken_at
from lcpflex.solvers.contact.group import Group

__all__ = ["Dense"]


@struct
class Dense:
    """The matrix and the velocities of all its rows."""

    m: int  # rows
    symmetric: int  # 1: W is
    columns: FloatArray = array("matrix", "matrix")  # W^T: that of a symmetric W itself
    row: IntArray = array("units", "rows")  # of each unit in the matrix; -1: it has none there
    free: FloatArray = array("matrix")
    y: FloatArray = array("matrix")  # velocities under the forces as they are
    # of Newton's method, see dense_newton
    table: FloatArray = array("unknowns", "unknowns")
    pivots: IntArray = array("unknowns")
    solution: FloatArray = array("unknowns")
    caused: FloatArray = array("matrix")


@operators.begin.of(Dense)
@kernel
def begin(op: Dense, group: Group, p: FloatArray, like: Vector) -> None:
    """y = free + W p."""
    for i in range(op.m):
        op.y[i] = op.free[i]
    for k in range(group.n):
        push(op, group, k, taken(p, k, like))


@operators.velocity.of(Dense)
@kernel(inline=True)
def velocity(op: Dense, group: Group, k: int, like: Vector) -> Vector:
    """What is kept."""
    return taken_at(op.y, op.row, k, like)


@operators.push.of(Dense)
@kernel(inline=True)
def push(op: Dense, group: Group, k: int, d: Vector) -> None:
    """y += W_k d, the columns of unit k."""
    add_to_rows(op.columns, op.row, k, d, op.y, op.m)


@operators.terms.of(Dense)
@kernel
def terms(op: Dense, group: Group, k: int, p: FloatArray, v: Vector) -> tuple[float, float]:
    """|free| + |W| |p|, the largest of its rows."""
    largest = 0.0
    for e in range(len(v)):
        r = op.row[k, e]
        if r >= 0:
            size = abs(op.free[r])
            for c in range(group.n):
                for f in range(len(v)):
                    if op.row[c, f] >= 0:
                        size += abs(op.columns[op.row[c, f], r] * p[c, f])
            largest = max(largest, size)
    return group.unit[k] * largest, group.unit[k] * largest
