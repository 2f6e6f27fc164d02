"""What Newton's method asks of a factor J of W: its unknowns are the changes x = J^T p that forces make.

(I + J^T C J) dx = -F,   F = x - J^T (q - c),   measured by its length

Its factors are sparse and made in Python, :mod:`lcpflex.solvers.contact.user_search`.
"""

from __future__ import annotations

import math

from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.solvers.contact import operators
from lcpflex.solvers.contact.algebra import Vector, add_sparse_rows, put, scaled, sparse_rows_on, taken
from lcpflex.solvers.contact.group import Group
from lcpflex.solvers.contact.operators import FACTOR_SWEEPS, product_as_they_are
from lcpflex.solvers.contact.operators.factor import Factor

__all__: list[str] = []

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
