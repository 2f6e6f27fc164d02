"""How far impulses are from solving a large contact problem, judged with the velocities that they cause.

    r = max_k { |min(q_N, y_N)|, |q_T - clip(q_T - y_T, -mu max(q_N, 0), mu max(q_N, 0))| },  joint rows: |y|

relative to the size of the free velocities (strict) or, with it, of the terms that cancel in y (terms). The residual
that counts is the second, and below 1e-6 of the free velocities, too (:mod:`lcpflex.solvers.certificate`).
"""

from __future__ import annotations

import numpy as np

from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.solvers.certificate import guarded_residual, strict_residual, terms_residual
from lcpflex.solvers.contact.large.memory import FRICTIONAL, LargeMemory
from lcpflex.solvers.contact.large.packing import add_impulses, velocities

__all__ = ["absolute_residual", "conclude", "is_enough", "is_exact", "judge", "keep_best", "term_size"]


@kernel
def absolute_residual(memory: LargeMemory, q: FloatArray, y: FloatArray) -> float:
    """r of the impulses q where the velocities are y; inf for what is not finite."""
    worst = 0.0
    total = 0.0
    kind, mu = memory.kind, memory.mu
    for k in range(memory.n_units):
        normal, tangent, along = q[k, 0], q[k, 1], y[k, 1]
        total += 0.0 * (normal + tangent + y[k, 0] + along)
        if kind[k] > FRICTIONAL:
            worst = max(worst, max(abs(y[k, 0]), abs(along)))
            continue
        bound = mu[k] * max(normal, 0.0)
        worst = max(worst, abs(min(normal, y[k, 0])))
        if kind[k] == FRICTIONAL:
            worst = max(worst, abs(tangent - min(max(tangent - along, -bound), bound)))
    return worst if total == 0.0 else np.inf


@kernel
def judge(memory: LargeMemory, q: FloatArray) -> float:
    """r of the impulses q; x = J^T q and y = free + J x are made anew."""
    x = memory.x
    for i in range(memory.n_unknowns):
        x[i] = 0.0
    add_impulses(memory, 1.0, q, x)
    velocities(memory, memory.free, x, memory.y)
    return absolute_residual(memory, q, memory.y)


@kernel
def keep_best(memory: LargeMemory, q: FloatArray, worst: float) -> None:
    """Keep q if it is the best point so far."""
    if worst < memory.worst:
        memory.worst = worst
        best = memory.best
        for k in range(memory.n_units):
            best[k, 0], best[k, 1] = q[k, 0], q[k, 1]


@kernel
def term_size(memory: LargeMemory, q: FloatArray) -> float:
    """Size of the terms of y: that of the free velocities and the largest of |J| |J^T| |q|."""
    terms, pos, body, J = memory.terms, memory.pos, memory.body, memory.J
    for i in range(memory.n_unknowns):
        terms[i] = 0.0
    for k in range(memory.n_units):
        for i in range(2):
            b = body[k, i]
            if b >= 0:
                for j in range(pos[b + 1] - pos[b]):
                    terms[pos[b] + j] += abs(J[k, 0, i, j] * q[k, 0]) + abs(J[k, 1, i, j] * q[k, 1])
    largest = 0.0
    for k in range(memory.n_units):
        normal, tangent = 0.0, 0.0
        for i in range(2):
            b = body[k, i]
            if b >= 0:
                for j in range(pos[b + 1] - pos[b]):
                    normal += abs(J[k, 0, i, j]) * terms[pos[b] + j]
                    tangent += abs(J[k, 1, i, j]) * terms[pos[b] + j]
        largest = max(largest, max(normal, tangent))
    return memory.load + largest


@kernel
def is_exact(memory: LargeMemory) -> bool:
    """Whether the residual of the best point is within the tolerance even of the free velocities, which are finite."""
    return bool(memory.worst <= memory.tolerance * memory.load < np.inf)


@kernel
def is_enough(memory: LargeMemory) -> bool:
    """Whether the best point is within the tolerance."""
    if is_exact(memory):
        return True
    if not memory.worst < memory.load:
        return False
    size = term_size(memory, memory.best)
    return bool(guarded_residual(memory.worst, size, memory.load) <= memory.tolerance)


@kernel
def conclude(memory: LargeMemory) -> None:
    """Both sizes of the residual of the best point, its velocities made anew."""
    memory.worst = judge(memory, memory.best)
    memory.strict = strict_residual(memory.worst, memory.load)
    memory.residual = terms_residual(memory.worst, term_size(memory, memory.best), memory.load)
