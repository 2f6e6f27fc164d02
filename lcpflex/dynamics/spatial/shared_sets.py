"""Forces on the index sets of space that contacts share in many ways, where that changes the motion.

Contacts that slide have their friction in the column of their normal: which of all solutions is taken decides what
friction does. It is the one of :mod:`lcpflex.solvers.contact.cones.shares`.
"""

from __future__ import annotations

import math
from typing import Any

from lcpflex.dynamics.spatial.inertia import SpatialWork
from lcpflex.jit.kernel import kernel, late_kernel
from lcpflex.solvers.contact.cones.mixed import judge_mixed, polish_mixed
from lcpflex.solvers.contact.cones.shares import MATTERS, NEEDED, SLIPS, TOUCHING, Shares, at_edge, share_out
from lcpflex.solvers.contact.index_sets import SLIDE_FORTH as SLIDING

__all__ = ["share_mixed", "share_sets", "slides"]

SETTLED = 1e-10  # of the largest normal force: shares that change by less are left
TURNS = 12


@kernel
def slides(work: SpatialWork, sets: Any) -> bool:
    """Whether a contact of the island posed last slides, and there are enough to share a load."""
    n = work.posed.problem.n_contacts
    if n < NEEDED:
        return False
    found = False
    for c in range(n):
        found = found or sets.mode[work.posed.part[c]] == SLIDING
    return found


@kernel
def note_slip(work: SpatialWork, sets: Any, s: Shares, load: float) -> None:
    """Note a contact that slides and whose slip feels a change ``s.z`` of the forces of the rows of ``scratch.G``."""
    problem, G = work.posed.problem, work.scratch.G
    rows = problem.n_contacts + problem.n_tangents
    for c in range(problem.n_contacts):
        k, j = work.posed.part[c], sets.row_here[c]
        if sets.mode[k] != SLIDING or j < 0:
            continue
        for x in range(j, j + 2):
            felt = 0.0
            for y in range(rows):
                felt += G[x, y] * s.z[y]
            if abs(felt) > MATTERS * load:
                s.told = 1 + work.rows.table.law[k]


@kernel
def share_sets(work: SpatialWork, sets: Any, m: int) -> None:
    """``sets.solution`` of the island reduced last, m rows that are dependent, by shares.

    Where they cannot all push, some pull: an event ends the sets then.
    """
    s, problem, G = work.impulses.solver.shares, work.posed.problem, work.scratch.G
    s.n, s.m = problem.n_contacts, m
    for c in range(s.n):
        s.contact[c] = c
        if sets.at[c] >= 0:
            s.contact[sets.at[c]], s.contact[sets.at[c] + 1] = c, c
    load = 0.0
    for r in range(m):
        i = sets.place[r]
        s.x[r], s.own[r] = sets.solution[r], G[i, i]
        s.weight[r] = work.rows.table.weight[work.posed.part[s.contact[r]]]
        load = max(load, abs(sets.free[i]))
        for q in range(m):
            s.W[r, q] = sets.reduced[r, q]
    share_out(s)
    for r in range(s.n + problem.n_tangents):
        s.z[r] = 0.0
    for r in range(m):
        d = s.x[r] - sets.solution[r]
        sets.solution[r] = s.x[r]
        s.z[sets.place[r]] += d
        k, j = work.posed.part[s.contact[r]], sets.row_here[s.contact[r]]
        if r < s.n and j >= 0 and sets.mode[k] == SLIDING:
            s.z[j] -= work.rows.mu[k] * sets.along[k, 0] * d
            s.z[j + 1] -= work.rows.mu[k] * sets.along[k, 1] * d
    note_slip(work, sets, s, load)


@kernel
def gather_mixed(work: SpatialWork, sets: Any) -> bool:
    """Contacts of ``sets.problem``, just judged, that touch, as a problem of shares; whether some slide, of enough."""
    s, p = work.impulses.solver.shares, sets.problem
    load, n, sliding = 0.0, 0, False
    for r in range(p.m):
        load = max(load, p.unit[r] * abs(p.q[r]))
    for c in range(p.n):
        if not (p.r[c] > 0.0 or p.unit[c] * p.u[c] <= TOUCHING * load):
            continue
        s.member[n] = c
        n += 1
    m = n
    for e in range(n):
        c = s.member[e]
        k, t = work.posed.part[c], p.at[c]
        s.along[e, 0], s.along[e, 1], s.rough[e] = 0.0, 0.0, -1
        if t < 0:
            sliding = sliding or sets.mode[k] == SLIDING
            continue
        slip = math.hypot(p.u[t], p.u[t + 1])
        if p.r[c] > 0.0 and p.unit[c] * slip > SLIPS * load and at_edge(p.r[c], p.r[t], p.r[t + 1], p.friction[c]):
            sliding = True
            s.along[e, 0], s.along[e, 1] = p.r[t] / p.r[c], p.r[t + 1] / p.r[c]
        else:
            s.rough[e] = m
            m += 2
    s.n, s.m = n, m
    return sliding and n >= NEEDED


@kernel
def pose_mixed(work: SpatialWork, sets: Any) -> None:
    """The contacts gathered as a problem of shares."""
    s, p = work.impulses.solver.shares, sets.problem
    for e in range(s.n):
        c, t = s.member[e], s.rough[e]
        s.part[e], s.contact[e] = c, e
        if t >= 0:
            s.part[t], s.part[t + 1] = p.at[c], p.at[c] + 1
            s.contact[t], s.contact[t + 1] = e, e
    for r in range(s.m):
        i = s.part[r]
        place = sets.place[i]
        s.x[r], s.own[r] = p.r[i], work.scratch.G[place, place]
        s.weight[r] = work.rows.table.weight[work.posed.part[s.member[s.contact[r]]]]
        for q in range(s.m):
            s.W[r, q] = p.W[i, s.part[q]]
    for e in range(s.n):
        t = p.at[s.member[e]]
        if t >= 0 and s.rough[e] < 0:
            for r in range(s.m):
                i = s.part[r]
                s.W[r, e] += s.along[e, 0] * p.W[i, t] + s.along[e, 1] * p.W[i, t + 1]


@kernel
def take_mixed(work: SpatialWork, sets: Any) -> float:
    """The shares found to ``p.r``; the largest change of a normal force, over the largest one."""
    s, p = work.impulses.solver.shares, sets.problem
    most, largest = 0.0, 0.0
    for e in range(s.n):
        c = s.member[e]
        most, largest = max(most, abs(s.x[e] - p.r[c])), max(largest, p.r[c])
    if not most > SETTLED * largest:
        return 0.0
    for r in range(work.posed.problem.n_contacts + work.posed.problem.n_tangents):
        s.z[r] = 0.0
    for r in range(s.m):
        s.z[sets.place[s.part[r]]] = s.x[r] - p.r[s.part[r]]
    load = 0.0
    for r in range(p.m):
        load = max(load, abs(p.q[r]))
    for e in range(s.n):
        c = s.member[e]
        k, t, j, d = work.posed.part[c], p.at[c], sets.row_here[c], s.x[e] - p.r[c]
        if t >= 0 and s.rough[e] < 0:
            p.r[t], p.r[t + 1] = s.along[e, 0] * s.x[e], s.along[e, 1] * s.x[e]
            s.z[sets.place[t]], s.z[sets.place[t + 1]] = s.along[e, 0] * d, s.along[e, 1] * d
        elif j >= 0 and sets.mode[k] == SLIDING:
            s.z[j], s.z[j + 1] = -work.rows.mu[k] * sets.along[k, 0] * d, -work.rows.mu[k] * sets.along[k, 1] * d
    for r in range(s.m):
        p.r[s.part[r]] = s.x[r]
    note_slip(work, sets, s, load)
    return most / largest


@late_kernel
def divide_mixed(work: SpatialWork, sets: Any, tolerance: float) -> float:
    """Divide the loads of ``sets.problem`` until shares and forces agree; the residual of what they come to."""
    s, p = work.impulses.solver.shares, sets.problem
    residual = judge_mixed(p, sets.search, p.r)
    for _ in range(TURNS):
        if not gather_mixed(work, sets):
            s.left = s.m
            break
        pose_mixed(work, sets)
        if not share_out(s):
            s.left = s.m
            break
        if take_mixed(work, sets) == 0.0:
            break
        residual = judge_mixed(p, sets.search, p.r)
        if residual > tolerance:
            residual = polish_mixed(p, sets.search)
            if residual > tolerance:
                break
    return residual


@kernel
def share_mixed(work: SpatialWork, sets: Any, tolerance: float, residual: float) -> float:
    """Divide the loads of ``sets.problem``, solved with this residual; that of the forces ``p.r`` after.

    Where that leads nowhere, the forces stay as they are.
    """
    s, p, before = work.impulses.solver.shares, sets.problem, work.impulses.solver.shares.before
    for c in range(p.n):
        s.idle[c] = 0
    if p.n < NEEDED or work.posed.shifted == 1 or not residual <= tolerance:
        return residual
    judge_mixed(p, sets.search, p.r)
    if not gather_mixed(work, sets):
        return residual
    for r in range(p.m):
        before[r] = p.r[r]
    found = divide_mixed(work, sets, tolerance)
    if not found <= tolerance:
        for r in range(p.m):
            p.r[r] = before[r]
        return judge_mixed(p, sets.search, p.r)
    for e in range(s.n):
        s.idle[s.member[e]] = 1
    for i in range(s.left):
        s.idle[s.member[s.contact[s.kept[i]]]] = 0
    return found
