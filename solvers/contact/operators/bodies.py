"""W = J J^T by the rows of the two bodies of each unit, in coordinates in which the matrix of a step is the identity.

x = J^T p are the changes of the velocities of the bodies, Newton's unknowns too: a unit costs as much as its bodies
have coordinates, and memory is linear in the units.

    (I + J^T C J) dx = -F,   F = x - J^T (q - c),   measured by its length
"""

from __future__ import annotations

import math

from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.solvers.contact import operators
from lcpflex.solvers.contact.algebra import Vector, add_rows, put, rows_on, scaled, taken
from lcpflex.solvers.contact.group import Group
from lcpflex.solvers.contact.operators import own_terms, product_as_they_are
from lcpflex.solvers.contact.operators.fronts import factorise, has_room, solve
from lcpflex.solvers.contact.operators.ordering import make_pattern
from lcpflex.solvers.contact.operators.sparse_factor import Bodies

__all__ = ["Bodies"]

UNIT_WORK = 900.0  # measured: multiplications of a factor that take as long as a sweep over one unit in space


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


operators.moves_centre.of(Bodies)(operators.keeps_centre)
operators.product.of(Bodies)(product_as_they_are)
operators.norm.of(Bodies)(operators.norm_of_velocities)


@operators.unknowns.of(Bodies)
@kernel(inline=True)
def unknowns(op: Bodies, group: Group) -> int:
    """Velocities of the bodies."""
    return op.n_unknowns


@operators.add_effect.of(Bodies)
@kernel
def add_effect(op: Bodies, group: Group, x: FloatArray, base: FloatArray, y: FloatArray, like: Vector) -> None:
    """y = base + J x."""
    for k in range(group.n):
        v = taken(base, k, like)
        for side in range(2):
            b = op.body[k, side]
            if b >= 0:
                v = rows_on(op.J, k, side, x, op.pos[b], op.pos[b + 1] - op.pos[b], v)
        put(y, k, v)


@operators.defect.of(Bodies)
@kernel
def defect(op: Bodies, group: Group, x: FloatArray, change: FloatArray, rest: FloatArray, like: Vector) -> float:
    """F = x - J^T change."""
    for i in range(op.n_unknowns):
        rest[i] = x[i]
    for k in range(group.n):
        d = scaled(-1.0, taken(change, k, like))
        for side in range(2):
            b = op.body[k, side]
            if b >= 0:
                add_rows(op.J, k, side, rest, op.pos[b], op.pos[b + 1] - op.pos[b], d)
    return math.sqrt(product_as_they_are(op, group, rest, rest, like))


@operators.factorise.of(Bodies)
@kernel
def factorise_bodies(op: Bodies, group: Group, C: FloatArray, like: Vector) -> bool:
    """By fronts, in the pattern of ``op.factor``."""
    return factorise(op, C, op.factor, like)


@operators.factorise_moving.of(Bodies)
@kernel(inline=True)
def factorise_moving(op: Bodies, group: Group, C: FloatArray, like: Vector) -> bool:
    """Forces are not the unknowns."""
    return False


@operators.solve.of(Bodies)
@kernel
def solve_bodies(op: Bodies, group: Group, x: FloatArray) -> None:
    """By the factor made last."""
    solve(op, op.factor, x)


@operators.prepare.of(Bodies)
@kernel
def prepare(op: Bodies, group: Group) -> bool:
    """The pattern of the factor, which is kept while it serves."""
    return make_pattern(op, group, op.factor) and has_room(op.factor)


@operators.factor_work.of(Bodies)
@kernel
def factor_work(op: Bodies, group: Group) -> float:
    """As the pattern tells."""
    return op.factor.work


@operators.sweep_work.of(Bodies)
@kernel
def sweep_work(op: Bodies, group: Group) -> float:
    """Linear in the units."""
    return UNIT_WORK * max(group.n, 1)
