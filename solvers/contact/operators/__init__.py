"""How the matrix W of a contact problem is stored, and what iterations ask of it: one struct and its kernels a file.

    begin(op, group, p, like)         take the forces p (units, S): what is kept up to date of their effect is made anew
    velocity(op, group, k, like)      v_k = free_k + (W p)_k at the forces as they are
    push(op, group, k, d)             p_k has become p_k + d
    terms(op, group, k, p, v)         sizes of what cancels in the velocity v of unit k, in its unit

:mod:`.dense` keeps velocities by columns of W; :mod:`.bodies` and :mod:`.factor` keep x = J^T p, W = J J^T, by body and
by compressed rows; :mod:`.blocks` keeps nothing and adds the blocks of a unit up.
"""

from __future__ import annotations

from typing import Any, TypeAlias

from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.jit.leaf import leaf
from lcpflex.solvers.contact.algebra import Vector, own_size
from lcpflex.solvers.contact.group import Group

__all__ = ["Operator", "begin", "own_terms", "push", "terms", "velocity"]

Operator: TypeAlias = Any  # a struct that has kernels for the leaves below


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
def terms(op: Operator, group: Group, k: int, p: Vector, v: Vector) -> tuple[float, float]:
    """Size of the terms that cancel in the velocity v of unit k, which has the force p; the same with its neighbours'.

    In its unit. An operator that adds bodies up knows of its neighbours just what they do together.
    """
    raise NotImplementedError


@kernel(inline=True)
def own_terms(group: Group, k: int, p: Vector, v: Vector) -> tuple[float, float]:
    """The free velocity along the normal and what its own force does to it; with the rest of v added."""
    free = group.free[k, 0]
    size = abs(free) + own_size(group.own, k, p)
    return group.unit[k] * size, group.unit[k] * (size + abs(v[0] - free))
