"""What Newton's method asks of blocks of W: its unknowns x are the changes of the forces themselves.

(I + C W) dx = -F,   F = x - (q - c),   measured by F.W F, what F does; by its length where W is not symmetric

Its factors are sparse and made in Python, :mod:`lcpflex.solvers.contact.user_search`.
"""

from __future__ import annotations

from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.solvers.contact import operators
from lcpflex.solvers.contact.algebra import Vector
from lcpflex.solvers.contact.group import Group
from lcpflex.solvers.contact.operators import FACTOR_SWEEPS, product_as_they_are
from lcpflex.solvers.contact.operators.blocks import Blocks

__all__: list[str] = []

operators.unknowns.of(Blocks)(operators.components_of_forces)
operators.norm.of(Blocks)(operators.norm_of_forces)
operators.defect.of(Blocks)(operators.defect_of_forces)
operators.moves_centre.of(Blocks)(operators.keeps_centre)
operators.prepare.of(Blocks)(operators.has_room)


@operators.add_effect.of(Blocks)
@kernel
def add_effect(op: Blocks, group: Group, x: FloatArray, base: FloatArray, y: FloatArray, like: Vector) -> None:
    """y = base + W x."""
    S = len(like)
    for k in range(group.n):
        for a in range(S):
            total = base[k, a]
            for e in range(op.first[k], op.first[k + 1]):
                for b in range(S):
                    total += op.block[e, S * a + b] * x[S * op.other[e] + b]
            y[k, a] = total


@operators.product.of(Blocks)
@kernel
def product(op: Blocks, group: Group, a: FloatArray, b: FloatArray, like: Vector) -> float:
    """a.W b; a.b where W is not symmetric."""
    if op.symmetric == 0:
        return product_as_they_are(op, group, a, b, like)
    total, S = 0.0, len(like)
    for k in range(group.n):
        for e in range(op.first[k], op.first[k + 1]):
            for f in range(S):
                for g in range(S):
                    total += a[S * k + f] * op.block[e, S * f + g] * b[S * op.other[e] + g]
    return total


@operators.factor_work.of(Blocks)
@kernel(inline=True)
def factor_work(op: Blocks, group: Group) -> float:
    """So many sweeps."""
    return FACTOR_SWEEPS * len(op.other)


@operators.sweep_work.of(Blocks)
@kernel(inline=True)
def sweep_work(op: Blocks, group: Group) -> float:
    """A pass over the blocks."""
    return 1.0 * len(op.other)
