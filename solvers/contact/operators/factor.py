"""W = J J^T by the rows of J in compressed form, whatever its columns are; x = J^T p is kept up to date.

Newton's unknowns are the changes x = J^T p that forces make,

    (I + J^T C J) dx = -F,   F = x - J^T (q - c),   measured by its length.

Its factors are sparse and made in Python, :mod:`lcpflex.solvers.contact.user_search`.
"""

from __future__ import annotations

import math

from lcpflex.jit.kernel import FloatArray, IntArray, kernel
from lcpflex.jit.struct import array, struct
from lcpflex.solvers.contact import operators
from lcpflex.solvers.contact.algebra import Vector, add_sparse_rows, put, scaled, sparse_rows_on, taken
from lcpflex.solvers.contact.group import Group
from lcpflex.solvers.contact.operators import FACTOR_SWEEPS, own_terms, product_as_they_are

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


operators.product.of(Factor)(product_as_they_are)
operators.norm.of(Factor)(operators.norm_of_velocities)
operators.moves_centre.of(Factor)(operators.keeps_centre)
operators.prepare.of(Factor)(operators.has_room)


@operators.unknowns.of(Factor)
@kernel(inline=True)
def unknowns(op: Factor, group: Group) -> int:
    """Columns of J."""
    return len(op.x)


@operators.add_effect.of(Factor)
@kernel
def add_effect(op: Factor, group: Group, x: FloatArray, base: FloatArray, y: FloatArray, like: Vector) -> None:
    """y = base + J x."""
    for k in range(group.n):
        put(y, k, sparse_rows_on(op.row, k, op.first, op.place, op.value, x, taken(base, k, like)))


@operators.defect.of(Factor)
@kernel
def defect(op: Factor, group: Group, x: FloatArray, change: FloatArray, rest: FloatArray, like: Vector) -> float:
    """F = x - J^T change."""
    for i in range(len(op.x)):
        rest[i] = x[i]
    for k in range(group.n):
        add_sparse_rows(op.row, k, op.first, op.place, op.value, rest, scaled(-1.0, taken(change, k, like)))
    return math.sqrt(product_as_they_are(op, group, rest, rest, like))


@operators.factor_work.of(Factor)
@kernel(inline=True)
def factor_work(op: Factor, group: Group) -> float:
    """So many sweeps."""
    return FACTOR_SWEEPS * len(op.place)


@operators.sweep_work.of(Factor)
@kernel(inline=True)
def sweep_work(op: Factor, group: Group) -> float:
    """A pass over the rows."""
    return 1.0 * len(op.place)
