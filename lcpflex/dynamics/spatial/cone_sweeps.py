"""Block Gauss-Seidel for the contacts of an island without joints, in the velocities of its bodies.

u = free + W^T x, x = A^-1 W p: ``work.solver.change`` holds x, and no Delassus operator is made. A sweep solves each
contact by itself, exactly, with the forces of the others as they are. The certificate is that of
:mod:`lcpflex.solvers.contact.cones.certificate`; the size of the terms is that of each contact's own force.
"""

from __future__ import annotations

import numpy as np

from lcpflex.dynamics.spatial.contact_problem import load_of
from lcpflex.dynamics.spatial.delassus import push, speeds
from lcpflex.dynamics.spatial.inertia import SpatialWork
from lcpflex.jit.kernel import kernel
from lcpflex.solvers.certificate import guarded_residual, own_share, strict_residual
from lcpflex.solvers.contact.cones.certificate import natural_miss
from lcpflex.solvers.contact.cones.dense import (
    CRAWLING,
    LOOK,
    POLISH,
    POLISHED,
    SLIDING,
    is_good,
    is_settled,
    lags,
    left_over,
    note_polish,
)
from lcpflex.solvers.contact.laws.disc import NONE, solve_cone

__all__ = ["judge_island", "sweep_island"]


@kernel
def judge_island(work: SpatialWork, i: int) -> None:
    """The velocities by the forces ``work.p`` of island i, made anew, and their residual in its two sizes."""
    memory, contact, n_joint, dof = work.solver, work.islands.contact, work.n_joint, work.dof
    rows, solved, row_body, free, p = work.rows, work.solved, work.row_body, work.free, work.p
    x, unit, own, tangent, mu = memory.change, memory.unit, memory.own, memory.tangent_row, work.mu
    first, last = work.islands.start[i], work.islands.start[i + 1]
    for d in range(len(x)):
        x[d] = 0.0
    for c in range(last - first):
        r, s = n_joint + contact[first + c], tangent[c]
        if p[r] != 0.0:
            push(solved, row_body, dof, r, s, p[r], p[s] if s >= 0 else 0.0, p[s + 1] if s >= 0 else 0.0, x)
    worst, terms, speed, missed = 0.0, 0.0, 0.0, 0.0
    for c in range(last - first):
        k = contact[first + c]
        r, s = n_joint + k, tangent[c]
        u, u1, u2 = speeds(rows, row_body, dof, free, r, s, x)
        f, f1, f2, rough = p[r], 0.0, 0.0, 0.0
        if s >= 0:
            f1, f2, rough = p[s], p[s + 1], mu[k]
        miss = natural_miss(f, f1, f2, u, u1, u2, rough, unit[c])
        size = abs(free[r]) + own[c, 0] * f + abs(own[c, 1] * f1) + abs(own[c, 2] * f2)
        worst, terms = max(worst, miss), max(terms, unit[c] * size)
        size += abs(u - free[r])  # and what its neighbours do to it
        missed = max(missed, own_share(miss, unit[c] * size, load_of(work, c, r, s), memory.load))
        if f > 0.0:
            speed = max(speed, unit[c] * (abs(u1) + abs(u2)))
    terms = max(terms, memory.load)
    memory.sliding = 1 if speed > SLIDING * memory.load else 0
    memory.worst, memory.terms, memory.missed = worst, terms, missed
    if worst < np.inf and memory.load < np.inf:
        memory.residual = guarded_residual(worst, terms, memory.load)
        memory.strict = strict_residual(worst, memory.load)
    else:
        memory.residual, memory.strict, memory.missed = np.inf, np.inf, np.inf


@kernel
def sweep(work: SpatialWork, i: int) -> float:
    """One sweep over the contacts of island i; the largest change of a force in its unit, inf if one is wedged."""
    memory, contact, n_joint, dof = work.solver, work.islands.contact, work.n_joint, work.dof
    rows, solved, row_body, free, p = work.rows, work.solved, work.row_body, work.free, work.p
    x, unit, own, tangent, mu, slip = memory.change, memory.unit, memory.own, memory.tangent_row, work.mu, memory.slip
    first, last = work.islands.start[i], work.islands.start[i + 1]
    largest = 0.0
    for c in range(last - first):
        k = contact[first + c]
        r, s = n_joint + k, tangent[c]
        u, u1, u2 = speeds(rows, row_body, dof, free, r, s, x)
        f, f1, f2, rough = p[r], 0.0, 0.0, 0.0
        if s >= 0:
            f1, f2, rough = p[s], p[s + 1], mu[k]
        nn, n1, n2, aa, ab, bb = own[c, 0], own[c, 1], own[c, 2], own[c, 3], own[c, 4], own[c, 5]
        u -= nn * f + n1 * f1 + n2 * f2
        u1 -= n1 * f + aa * f1 + ab * f2
        u2 -= n2 * f + ab * f1 + bb * f2
        g, g1, g2, state = solve_cone(nn, n1, n2, aa, ab, bb, u, u1, u2, rough, slip[c])
        if state == NONE:  # by itself: the others may help
            largest = np.inf
            continue
        slip[c] = state
        d, d1, d2 = g - f, g1 - f1, g2 - f2
        if d != 0.0 or d1 != 0.0 or d2 != 0.0:
            largest = max(largest, max(abs(d), max(abs(d1), abs(d2))) / unit[c])
            p[r] = g
            if s >= 0:
                p[s], p[s + 1] = g1, g2
            push(solved, row_body, dof, r, s, d, d1, d2, x)
    return largest


@kernel
def sweep_island(work: SpatialWork, i: int, most: float, patient: bool) -> bool:
    """Sweeps from the forces ``work.p`` of island i until they are good enough, ``most`` in all; whether they are.

    Where something slides that is the tolerance; where all that press stick, rounding if that can be had: what rests
    does not creep. Fewer sweeps where they crawl and one is not ``patient``.
    """
    memory = work.solver
    tolerance = memory.tolerance
    judge_island(work, i)
    rested = is_good(memory)
    polished = 0
    while memory.iterations < most:
        if is_good(memory):
            if memory.sliding == 1 or polished >= POLISH or is_settled(memory):
                break
            polished += LOOK
        lagging = lags(memory)
        before = left_over(memory, lagging)
        goal = POLISHED * memory.load if memory.residual <= tolerance else 0.1 * tolerance * memory.load
        for _ in range(LOOK):
            memory.iterations += 1.0
            if sweep(work, i) <= goal:
                break
        judge_island(work, i)
        if left_over(memory, lagging) > CRAWLING * before and not patient:
            break
    note_polish(memory, rested and polished > 0)
    return is_good(memory)
