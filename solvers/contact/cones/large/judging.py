"""How far forces are from solving a large contact problem in space, judged with the velocities that they cause.

The natural map of the cones, each contact in its own unit (:mod:`lcpflex.solvers.contact.cones.certificate`), and |y|
of joint rows; relative to the size of the free velocities (strict), or of the terms of each contact's own force, too.
"""

from __future__ import annotations

import numpy as np

from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.solvers.certificate import guarded_residual, strict_residual
from lcpflex.solvers.contact.cones.certificate import natural_miss
from lcpflex.solvers.contact.cones.large.memory import FRICTIONAL, SpatialLargeMemory
from lcpflex.solvers.contact.cones.large.packing import add_forces, take_over, velocities

__all__ = ["conclude", "is_enough", "is_exact", "judge", "keep_best", "term_size"]


@kernel
def absolute_residual(memory: SpatialLargeMemory, q: FloatArray, y: FloatArray) -> float:
    """What is left of the natural map at the forces q with the velocities y; inf for what is not finite."""
    worst = 0.0
    kind, mu = memory.kind, memory.mu
    for k in range(memory.n_units):
        if kind[k] > FRICTIONAL:
            miss = max(abs(y[k, 0]), max(abs(y[k, 1]), abs(y[k, 2])))
            if not miss + abs(q[k, 0]) + abs(q[k, 1]) + abs(q[k, 2]) < np.inf:
                return np.inf
        else:
            miss = natural_miss(q[k, 0], q[k, 1], q[k, 2], y[k, 0], y[k, 1], y[k, 2], mu[k], 1.0)
        worst = max(worst, miss)
    return worst


@kernel
def judge(memory: SpatialLargeMemory, q: FloatArray) -> float:
    """The absolute residual of the forces q; x = J^T q and y = free + J x are made anew."""
    x = memory.x
    for i in range(memory.n_unknowns):
        x[i] = 0.0
    add_forces(memory, 1.0, q, x)
    velocities(memory, memory.free, x, memory.y)
    return absolute_residual(memory, q, memory.y)


@kernel
def keep_best(memory: SpatialLargeMemory, q: FloatArray, worst: float) -> None:
    """Keep q if it is the best point so far."""
    if worst < memory.worst:
        memory.worst = worst
        take_over(memory, q, memory.best)


@kernel
def term_size(memory: SpatialLargeMemory, q: FloatArray) -> float:
    """Size of the terms of y: the free velocity of each unit, and what its own force does to it."""
    largest, W, free = memory.load, memory.W, memory.free
    for k in range(memory.n_units):
        size = abs(free[k, 0]) + W[k, 0] * abs(q[k, 0]) + abs(W[k, 1] * q[k, 1]) + abs(W[k, 2] * q[k, 2])
        largest = max(largest, size)
    return largest


@kernel
def is_exact(memory: SpatialLargeMemory) -> bool:
    """Whether the residual of the best point is within the tolerance even of the free velocities, which are finite."""
    return bool(memory.worst <= memory.tolerance * memory.load < np.inf)


@kernel
def is_enough(memory: SpatialLargeMemory) -> bool:
    """Whether the best point is within the tolerance."""
    if is_exact(memory):
        return True
    if not memory.worst < memory.load < np.inf:
        return False
    return bool(guarded_residual(memory.worst, term_size(memory, memory.best), memory.load) <= memory.tolerance)


@kernel
def conclude(memory: SpatialLargeMemory) -> None:
    """Both sizes of the residual of the best point, its velocities made anew."""
    memory.worst = judge(memory, memory.best)
    if memory.worst < np.inf and memory.load < np.inf:
        memory.strict = strict_residual(memory.worst, memory.load)
        memory.residual = guarded_residual(memory.worst, term_size(memory, memory.best), memory.load)
    else:
        memory.strict, memory.residual = np.inf, np.inf
