"""W by its blocks of two units that are not zero: block k, c at one place of compressed rows.

Newton's unknowns x are the changes of the forces themselves,

    (I + C W) dx = -F,   F = x - (q - c),   measured by F.W F, what F does; by its length where W is not symmetric.

Its factors are sparse and made in Python, :mod:`lcpflex.solvers.contact.user_search`.
"""

from __future__ import annotations

from lcpflex.jit.kernel import FloatArray, IntArray, kernel
from lcpflex.jit.struct import array, struct
from lcpflex.solvers.contact import operators
from lcpflex.solvers.contact.algebra import Vector, absolute, add_block, add_block_sizes, along, put, size_of, taken
from lcpflex.solvers.contact.group import Group
from lcpflex.solvers.contact.operators import FACTOR_SWEEPS, product_as_they_are

__all__ = ["Blocks"]


@struct
class Blocks:
    """Blocks of unit k: first[k] to first[k + 1], with unit other[e], entries block[e] by rows."""

    symmetric: int  # 1: W is
    first: IntArray = array("offsets")
    other: IntArray = array("entries")
    block: FloatArray = array("entries", "block")
    p: FloatArray = array("units", "rows")  # forces as they are


@operators.begin.of(Blocks)
@kernel
def begin(op: Blocks, group: Group, p: FloatArray, like: Vector) -> None:
    """A copy of the forces."""
    for k in range(group.n):
        put(op.p, k, taken(p, k, like))


@operators.velocity.of(Blocks)
@kernel(inline=True)
def velocity(op: Blocks, group: Group, k: int, like: Vector) -> Vector:
    """free + W_kc p_c over the units c that k has a block with."""
    v = taken(group.free, k, like)
    for e in range(op.first[k], op.first[k + 1]):
        v = add_block(op.block, e, taken(op.p, op.other[e], like), v)
    return v


@operators.push.of(Blocks)
@kernel(inline=True)
def push(op: Blocks, group: Group, k: int, d: Vector) -> None:
    """The copy follows."""
    put(op.p, k, along(taken(op.p, k, d), 1.0, d))


@operators.terms.of(Blocks)
@kernel(inline=True)
def terms(op: Blocks, group: Group, k: int, p: FloatArray, v: Vector) -> tuple[float, float]:
    """|free| + |W_kc| |p_c| of the units c that k has a block with."""
    size = absolute(taken(group.free, k, v))
    for e in range(op.first[k], op.first[k + 1]):
        size = add_block_sizes(op.block, e, taken(p, op.other[e], v), size)
    largest = group.unit[k] * size_of(size)
    return largest, largest


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
