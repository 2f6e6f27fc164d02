"""W = J J^T by the rows of the two bodies of each unit, in coordinates in which the matrix of a step is the identity.

x = J^T p are the changes of the velocities of the bodies: a unit costs as much as its bodies have coordinates, and
memory is linear in the units.
"""

from __future__ import annotations

from lcpflex.jit.kernel import FloatArray, IntArray, kernel
from lcpflex.jit.struct import array, struct
from lcpflex.solvers.contact import operators
from lcpflex.solvers.contact.algebra import Vector, add_rows, rows_on, taken
from lcpflex.solvers.contact.group import Group
from lcpflex.solvers.contact.operators import own_terms
from lcpflex.solvers.contact.operators.sparse_factor import SparseFactor

__all__ = ["Bodies"]


@struct
class Bodies:
    """Rows by body."""

    n_bodies: int
    n_unknowns: int
    pos: IntArray = array("offsets")  # first unknown of each body
    body: IntArray = array("units", 2)  # -1: none, or one that nothing moves
    J: FloatArray = array("units", 2, "rows", "width")
    x: FloatArray = array("unknowns")
    factor: SparseFactor  # of Newton's method


@operators.begin.of(Bodies)
@kernel
def begin(op: Bodies, group: Group, p: FloatArray, like: Vector) -> None:
    """x = J^T p."""
    for i in range(op.n_unknowns):
        op.x[i] = 0.0
    for k in range(group.n):
        push(op, group, k, taken(p, k, like))


@operators.velocity.of(Bodies)
@kernel(inline=True)
def velocity(op: Bodies, group: Group, k: int, like: Vector) -> Vector:
    """free + J_k x."""
    v = taken(group.free, k, like)
    for side in range(2):
        b = op.body[k, side]
        if b >= 0:
            v = rows_on(op.J, k, side, op.x, op.pos[b], op.pos[b + 1] - op.pos[b], v)
    return v


@operators.push.of(Bodies)
@kernel(inline=True)
def push(op: Bodies, group: Group, k: int, d: Vector) -> None:
    """x += J_k^T d."""
    for side in range(2):
        b = op.body[k, side]
        if b >= 0:
            add_rows(op.J, k, side, op.x, op.pos[b], op.pos[b + 1] - op.pos[b], d)


@operators.terms.of(Bodies)
@kernel(inline=True)
def terms(op: Bodies, group: Group, k: int, p: FloatArray, v: Vector) -> tuple[float, float]:
    """Of its own force, and of all others together."""
    return own_terms(group, k, p, v)
