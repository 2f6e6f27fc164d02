"""How far impulses are from solving a large contact problem, judged with the velocities that they cause.

    r = max_k { |min(q_N, y_N)|, |q_T - clip(q_T - y_T, -mu max(q_N, 0), mu max(q_N, 0))| },  joint rows: |y|

relative to the size of the free velocities (strict) or, with it, of the terms that cancel in y (terms). The residual
that counts is the second, and below 1e-6 of the free velocities, too (:mod:`lcpflex.solvers.certificate`). Light bodies
beside heavy ones are nothing in it: each contact is measured by its own load as well (missed).
"""

from __future__ import annotations

import numpy as np

from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.solvers.certificate import OWN, guarded_residual, own_share, strict_residual, terms_residual
from lcpflex.solvers.contact.large.memory import FRICTIONAL, LargeMemory
from lcpflex.solvers.contact.large.packing import add_impulses, velocities

__all__ = [
    "absolute_residual",
    "conclude",
    "is_enough",
    "is_exact",
    "is_good",
    "judge",
    "keep_best",
    "lags",
    "term_size",
]


@kernel
def absolute_residual(memory: LargeMemory, q: FloatArray, y: FloatArray) -> float:
    """r of the impulses q where the velocities are y; inf for what is not finite."""
    worst = 0.0
    total = 0.0
    kind, mu = memory.kind, memory.mu
    for k in range(memory.n_units):
        normal, tangent, away, along = q[k, 0], q[k, 1], y[k, 0], y[k, 1]
        total += 0.0 * (normal + tangent + away + along)
        worst = max(worst, unit_miss(kind[k], mu[k], normal, tangent, away, along))
    return worst if total == 0.0 else np.inf


@kernel
def unit_miss(kind: int, mu: float, normal: float, tangent: float, away: float, along: float) -> float:
    """What a unit misses of its law, or of standing still, with its two impulses and velocities."""
    if kind > FRICTIONAL:
        return max(abs(away), abs(along))
    miss = abs(min(normal, away))
    if kind == FRICTIONAL:
        bound = mu * max(normal, 0.0)
        miss = max(miss, abs(tangent - min(max(tangent - along, -bound), bound)))
    return miss


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
def is_good(memory: LargeMemory) -> bool:
    """Whether the best point, judged by :func:`conclude`, is within the tolerance, near it by the load of each contact.

    Where the rounding of the velocities is a part of the free ones, no residual says anything: it is inf.
    """
    return bool(is_enough(memory) and memory.residual < np.inf and memory.missed <= OWN * memory.tolerance)


@kernel
def lags(memory: LargeMemory) -> bool:
    """Whether the best point is within the tolerance as a whole, and some contact is not."""
    return bool(memory.missed > OWN * memory.tolerance and is_enough(memory) and memory.residual < np.inf)


@kernel
def conclude(memory: LargeMemory) -> None:
    """The sizes of the residual of the best point, its velocities made anew."""
    memory.worst = judge(memory, memory.best)
    memory.strict = strict_residual(memory.worst, memory.load)
    memory.residual = terms_residual(memory.worst, term_size(memory, memory.best), memory.load)
    weigh_shares(memory)


@kernel
def weigh_shares(memory: LargeMemory) -> None:
    """``missed`` and ``behind`` of the best point, whose velocities are ``y``."""
    missed, behind, load = 0.0, 0, memory.load
    free, best, y, W, kind, mu, own = (
        memory.free, memory.best, memory.y, memory.W, memory.kind, memory.mu, memory.own,
    )  # fmt: skip
    for k in range(memory.n_units):
        if kind[k] <= FRICTIONAL:
            normal, tangent, away, along = best[k, 0], best[k, 1], y[k, 0], y[k, 1]
            terms = abs(free[k, 0]) + W[k, 0] * normal + abs(W[k, 2] * tangent)
            terms += abs(away - free[k, 0])  # and what its neighbours do to it
            miss = unit_miss(kind[k], mu[k], normal, tangent, away, along)
            share = own_share(miss, terms, own[k], load)
            if share > missed:
                missed, behind = share, k
    memory.missed, memory.behind = missed, behind
