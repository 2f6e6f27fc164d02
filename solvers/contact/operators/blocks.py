"""W by its blocks of two units that are not zero: block k, c at one place of compressed rows."""

from __future__ import annotations

from lcpflex.jit.kernel import FloatArray, IntArray, kernel
from lcpflex.jit.struct import array, struct
from lcpflex.solvers.contact import operators
from lcpflex.solvers.contact.algebra import Vector, absolute, add_block, add_block_sizes, along, put, size_of, taken
from lcpflex.solvers.contact.group import Group

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
