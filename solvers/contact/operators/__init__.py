"""How the matrix W of a contact problem is stored, and what iterations ask of it: one struct and its kernels a file.

Sweeps ask for ``begin``, ``velocity``, ``push`` and ``terms``; the other leaves are Newton's method's, whose unknowns x
are the operator's own: forces, or velocities of bodies.

:mod:`.dense` keeps velocities by columns of W; :mod:`.bodies` and :mod:`.factor` keep x = J^T p, W = J J^T, by body and
by compressed rows; :mod:`.blocks` keeps nothing and adds the blocks of a unit up; :mod:`.scene` has
x = A^-1 B^T p by the rows of a step.
"""

from __future__ import annotations

import math
from typing import Any, TypeAlias

from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.jit.leaf import leaf
from lcpflex.solvers.contact.algebra import Vector, own_size, taken
from lcpflex.solvers.contact.group import Group

__all__ = [
    "FACTOR_SWEEPS", "Operator", "add_effect", "begin", "components_of_forces", "defect", "defect_of_forces",
    "factor_work", "factorise", "factorise_moving", "has_room", "keeps_centre", "moves_centre", "norm",
    "norm_of_forces", "norm_of_velocities", "own_terms", "prepare", "product", "product_as_they_are", "push",
    "solve", "sweep_work", "terms", "unknowns", "velocity",
]  # fmt: skip

Operator: TypeAlias = Any  # a struct that has kernels for the leaves below

FACTOR_SWEEPS = 20.0  # sweeps that a factor of scipy counts for: what it takes is known once it is made


@leaf
def begin(op: Operator, group: Group, p: FloatArray, like: Vector) -> None:
    """Take the forces p (units, S): what is kept up to date of their effect is made anew."""
    raise NotImplementedError


@leaf
def velocity(op: Operator, group: Group, k: int, like: Vector) -> Vector:
    """Velocity of unit k under the forces as they are, the free one included."""
    raise NotImplementedError


@leaf
def push(op: Operator, group: Group, k: int, d: Vector) -> None:
    """Take note that the force of unit k has changed by d."""
    raise NotImplementedError


@leaf
def terms(op: Operator, group: Group, k: int, p: FloatArray, v: Vector) -> tuple[float, float]:
    """Size of the terms that cancel in the velocity v of unit k under the forces p; the same with its neighbours'.

    In its unit. An operator that adds bodies up knows of its neighbours just what they do together.
    """
    raise NotImplementedError


@kernel(inline=True)
def own_terms(group: Group, k: int, p: FloatArray, v: Vector) -> tuple[float, float]:
    """The free velocity along the normal and what its own force does to it; with the rest of v added."""
    free = group.free[k, 0]
    size = abs(free) + own_size(group.own, k, taken(p, k, v))
    return group.unit[k] * size, group.unit[k] * (size + abs(v[0] - free))


@leaf
def unknowns(op: Operator, group: Group) -> int:
    """How many unknowns Newton's method has."""
    raise NotImplementedError


@leaf
def moves_centre(op: Operator) -> bool:
    """Whether it has factors for a centre that moves with the forces: then these are the unknowns."""
    raise NotImplementedError


@leaf
def add_effect(op: Operator, group: Group, x: FloatArray, base: FloatArray, y: FloatArray, like: Vector) -> None:
    """Velocities y = base + effect of x of all units, (units, S)."""
    raise NotImplementedError


@leaf
def product(op: Operator, group: Group, a: FloatArray, b: FloatArray, like: Vector) -> float:
    """Scalar product of unknowns in the metric in which F is measured."""
    raise NotImplementedError


@leaf
def norm(op: Operator, group: Group, x: FloatArray) -> float:
    """Length of unknowns, in units in which these are alike."""
    raise NotImplementedError


@leaf
def defect(op: Operator, group: Group, x: FloatArray, change: FloatArray, rest: FloatArray, like: Vector) -> float:
    """F to ``rest``: x less what a change of the forces (units, S) comes to; its size."""
    raise NotImplementedError


@leaf
def factorise(op: Operator, group: Group, C: FloatArray, like: Vector) -> bool:
    """Factor of the Jacobian of F with C = -dp/dv, (units, S S) by rows; False where it is singular."""
    raise NotImplementedError


@leaf
def factorise_moving(op: Operator, group: Group, C: FloatArray, like: Vector) -> bool:
    """The same where the centre moves with the forces: of I - C / rho + C W, rho of each unit by its own diagonal."""
    raise NotImplementedError


@leaf
def solve(op: Operator, group: Group, x: FloatArray) -> None:
    """x := J^-1 x by the factor made last."""
    raise NotImplementedError


@leaf
def prepare(op: Operator, group: Group) -> bool:
    """Make ready for factors of this problem; False where there is no room for them."""
    raise NotImplementedError


@leaf
def factor_work(op: Operator, group: Group) -> float:
    """Multiplications of a factor."""
    raise NotImplementedError


@leaf
def sweep_work(op: Operator, group: Group) -> float:
    """Multiplications of a factor that take as long as a sweep."""
    raise NotImplementedError


@kernel(inline=True)
def components_of_forces(op: Operator, group: Group) -> int:
    """How many unknowns there are where these are forces: all components of all of them."""
    return int(group.n * group.p.shape[1])


@kernel(inline=True)
def keeps_centre(op: Operator) -> bool:
    """No factors for a moving centre: scipy's are for one that stays, or the unknowns are velocities."""
    return False


@kernel(inline=True)
def has_room(op: Operator, group: Group) -> bool:
    """Ready from the start: there is room for a factor of all rows, or Python makes it."""
    return True


@kernel
def product_as_they_are(op: Operator, group: Group, a: FloatArray, b: FloatArray, like: Vector) -> float:
    """a.b: in velocities the matrix of the step is the identity, and a W without symmetry has no metric."""
    total = 0.0
    for i in range(unknowns(op, group)):
        total += a[i] * b[i]
    return total


@kernel
def norm_of_forces(op: Operator, group: Group, x: FloatArray) -> float:
    """Length of unknowns that are forces, each in the unit of its contact."""
    total, S = 0.0, group.p.shape[1]
    for k in range(group.n):
        for e in range(S):
            force = x[S * k + e] / group.unit[k]
            total += force * force
    return math.sqrt(total)


@kernel
def defect_of_forces(
    op: Operator, group: Group, x: FloatArray, change: FloatArray, rest: FloatArray, like: Vector
) -> float:  # fmt: skip
    """F = x - change of unknowns that are forces."""
    S = len(like)
    for k in range(group.n):
        for e in range(S):
            rest[S * k + e] = x[S * k + e] - change[k, e]
    return math.sqrt(max(product(op, group, rest, rest, like), 0.0))


@kernel
def norm_of_velocities(op: Operator, group: Group, x: FloatArray) -> float:
    """Length of unknowns that are velocities, in which the matrix of the step is the identity."""
    total = 0.0
    for i in range(unknowns(op, group)):
        total += x[i] * x[i]
    return math.sqrt(total)
