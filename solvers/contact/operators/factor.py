"""W = J J^T by the rows of J in compressed form, whatever its columns are; x = J^T p is kept up to date."""

from __future__ import annotations

from lcpflex.jit.kernel import FloatArray, IntArray, kernel
from lcpflex.jit.struct import array, struct
from lcpflex.solvers.contact import operators
from lcpflex.solvers.contact.algebra import Vector, add_sparse_rows, sparse_rows_on, taken
from lcpflex.solvers.contact.group import Group
from lcpflex.solvers.contact.operators import own_terms

__all__ = ["Factor"]


@struct
class Factor:
    """Row r of J: entries first[r] to first[r + 1], value[e] in column place[e]."""

    row: IntArray = array("units", "rows")  # of each unit in J; -1: it has none there
    first: IntArray = array("offsets")
    place: IntArray = array("entries")
    value: FloatArray = array("entries")
    x: FloatArray = array("columns")


@operators.begin.of(Factor)
@kernel
def begin(op: Factor, group: Group, p: FloatArray, like: Vector) -> None:
    """x = J^T p."""
    for i in range(len(op.x)):
        op.x[i] = 0.0
    for k in range(group.n):
        push(op, group, k, taken(p, k, like))


@operators.velocity.of(Factor)
@kernel(inline=True)
def velocity(op: Factor, group: Group, k: int, like: Vector) -> Vector:
    """free + J_k x."""
    return sparse_rows_on(op.row, k, op.first, op.place, op.value, op.x, taken(group.free, k, like))


@operators.push.of(Factor)
@kernel(inline=True)
def push(op: Factor, group: Group, k: int, d: Vector) -> None:
    """x += J_k^T d."""
    add_sparse_rows(op.row, k, op.first, op.place, op.value, op.x, d)


@operators.terms.of(Factor)
@kernel(inline=True)
def terms(op: Factor, group: Group, k: int, p: FloatArray, v: Vector) -> tuple[float, float]:
    """Of its own force, and of all others together."""
    return own_terms(group, k, p, v)
