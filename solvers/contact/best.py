"""The best point of a search: every attempt begins from it, and none can lose it."""

from __future__ import annotations

from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.jit.struct import array, struct
from lcpflex.solvers.contact.algebra import Vector, put, taken
from lcpflex.solvers.contact.group import Group

__all__ = ["Best", "copy_forces", "forget_best", "keep_best"]

NOTHING = 1e300  # what a point misses that nobody has judged yet


@struct
class Best:
    """Forces, and what they miss."""

    worst: float
    p: FloatArray = array("units", "rows")
    kept: float  # the same of another point put aside
    aside: FloatArray = array("units", "rows")


@kernel
def copy_forces(group: Group, source: FloatArray, target: FloatArray, like: Vector) -> None:
    """target = source, both (units, S)."""
    for k in range(group.n):
        put(target, k, taken(source, k, like))


@kernel
def forget_best(group: Group, best: Best, like: Vector) -> None:
    """No forces, until there are some that are finite."""
    best.worst = NOTHING
    for k in range(group.n):
        for e in range(len(like)):
            best.p[k, e] = 0.0


@kernel
def keep_best(group: Group, best: Best, p: FloatArray, worst: float, like: Vector) -> None:
    """Keep forces p (units, S) that miss no more than ``worst`` if they are the best ones so far."""
    if worst < best.worst:
        best.worst = worst
        copy_forces(group, p, best.p, like)
