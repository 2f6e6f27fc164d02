"""Contact forces of an island that its contacts share in many ways, where that changes the motion: as all give way.

Where some of three or more contacts between one pair of bodies slide, their normal forces are divided as
:mod:`lcpflex.solvers.contact.cones.shares` has it, with the friction that they slide under; those of other contacts
stay. In an island with joints all contacts are divided together: a body that is guided takes any moment, so that two
jaws may carry their loads at one and the same corner. What that does to slip, and to other bodies, sweeps settle; then
they are divided anew. The shares change less each time, by about the friction coefficient, and begin from those of the
last step. What sticks altogether moves in the same way under all shares, and is left alone.
"""

from __future__ import annotations

import math

from lcpflex.dynamics.delassus import delassus
from lcpflex.dynamics.spatial.cone_sweeps import judge_island, sweep_island
from lcpflex.dynamics.spatial.contact_problem import give_forces, has_joints, take_forces
from lcpflex.dynamics.spatial.inertia import SpatialWork
from lcpflex.dynamics.spatial.least_cones import way_in_cone
from lcpflex.jit.kernel import kernel, late_kernel
from lcpflex.solvers.contact.algebra import IN_SPACE
from lcpflex.solvers.contact.cones.dense import FIRST_SWEEPS, mend_posed, tell, weigh_posed
from lcpflex.solvers.contact.cones.memory import OF_A_PAIR
from lcpflex.solvers.contact.cones.shares import MATTERS, NEEDED, SLIPS, TOUCHING, at_edge, share_out
from lcpflex.solvers.contact.judging import is_good
from lcpflex.solvers.contact.operators import push, velocity

__all__ = ["judge_forces", "put_forces", "share_loads", "shares_in_joints", "tangents_of", "velocity_of"]

SETTLED = 1e-5  # of the largest normal force: shares that change by less are left
TURNS = 12  # at most: what is left of a change is about the friction coefficient of it


@kernel
def find_groups(work: SpatialWork, i: int) -> bool:
    """Leaders of the contacts of island i by their pairs of bodies; whether a pair has enough of them to be divided."""
    s, contact = work.impulses.solver.shares, work.posed.islands.contact
    row_body, first = work.rows.body, work.posed.islands.start[i]
    n, found = work.posed.islands.start[i + 1] - first, False
    for c in range(n):
        r = work.rows.n_joint + contact[first + c]
        s.head[max(row_body[r, 0], row_body[r, 1])] = -1
    for c in range(n):
        r = work.rows.n_joint + contact[first + c]
        b, other = max(row_body[r, 0], row_body[r, 1]), min(row_body[r, 0], row_body[r, 1])
        leader = s.head[b]
        while leader >= 0:
            e = work.rows.n_joint + contact[first + leader]
            if min(row_body[e, 0], row_body[e, 1]) == other:
                break
            leader = s.further[leader]
        if leader < 0:
            leader = c
            s.further[c] = s.head[b]
            s.head[b] = c
            s.count[c] = 0
        s.leader[c] = leader
        s.count[leader] += 1
        found = found or s.count[leader] >= NEEDED
    return found


@kernel
def shares_in_joints(work: SpatialWork, i: int) -> bool:
    """Whether island i has joints and not too many contacts, and a pair of its bodies has several of them."""
    n, shares = work.posed.islands.start[i + 1] - work.posed.islands.start[i], work.impulses.solver.shares
    if not NEEDED <= n <= OF_A_PAIR or not has_joints(work, i):
        return False
    find_groups(work, i)
    several = False
    for c in range(n):
        several = several or (shares.leader[c] == c and shares.count[c] > 1)
    return several


@kernel
def velocity_of(work: SpatialWork, posed: bool, c: int) -> tuple[float, float, float]:
    """Velocity of the contact at place c of its island, under the forces judged last."""
    group = work.impulses.solver.group
    if posed:
        return group.y[c, 0], group.y[c, 1], group.y[c, 2]
    u, u1, u2 = velocity(work.impulses.solver.scene, group, c, IN_SPACE)
    return u, u1, u2


@kernel
def tangents_of(work: SpatialWork, k: int) -> int:
    """First of two tangential rows of contact k; -1: it has none."""
    j = work.posed.tangent_of[k]
    return work.rows.n_joint + work.rows.n_contacts + j if j >= 0 else -1


@kernel
def gather(work: SpatialWork, i: int, leader: int, posed: bool) -> int:
    """Contacts of a group that touch, with what each does; how many, and 0 where nothing slides."""
    memory, shares = work.impulses.solver, work.impulses.solver.shares
    p, first = work.impulses.p, work.posed.islands.start[i]
    n, m, slides = 0, 0, False
    for c in range(work.posed.islands.start[i + 1] - first):
        if shares.leader[c] != leader:
            continue
        k = work.posed.islands.contact[first + c]
        r, t, unit = work.rows.n_joint + k, tangents_of(work, k), memory.group.unit[c]
        u, u1, u2 = velocity_of(work, posed, c)
        f = p[r]
        if not (f > 0.0 or unit * u <= TOUCHING * memory.judged.load):
            continue
        if 3 * n + 3 > len(shares.b):
            return 0  # more than there is room for
        along, across, rough = 0.0, 0.0, -1
        if t >= 0:
            slip = math.hypot(u1, u2)
            if unit * slip > SLIPS * memory.judged.load and at_edge(f, p[t], p[t + 1], work.rows.mu[k]):
                slides = True
                along = p[t] / f if f > 0.0 else -work.rows.mu[k] * u1 / slip
                across = p[t + 1] / f if f > 0.0 else -work.rows.mu[k] * u2 / slip
            else:
                rough = m
                m += 2
        shares.member[n], shares.rough[n] = c, rough
        shares.along[n, 0], shares.along[n, 1] = along, across
        n += 1
    for e in range(n):
        if shares.rough[e] >= 0:
            shares.rough[e] += n
    shares.n, shares.m = n, n + m
    return n if slides and n >= NEEDED else 0


@kernel
def respond(work: SpatialWork, i: int, n: int, posed: bool) -> None:
    """``shares.G`` of the n contacts gathered: three rows each, those of contacts without friction for nothing."""
    shares, n_joint, first = work.impulses.solver.shares, work.rows.n_joint, work.posed.islands.start[i]
    if posed:
        W = work.posed.problem.delassus
        for e in range(n):
            for d in range(n):
                for x in range(3):
                    for y in range(3):
                        shares.G[3 * e + x, 3 * d + y] = W[3 * shares.member[e] + x, 3 * shares.member[d] + y]
        return
    for e in range(n):
        k = work.posed.islands.contact[first + shares.member[e]]
        t = tangents_of(work, k)
        shares.part[3 * e] = k
        shares.part[3 * e + 1] = t - n_joint if t >= 0 else k
        shares.part[3 * e + 2] = t - n_joint + 1 if t >= 0 else k
    rows, solved, row_body = work.rows.J[n_joint:], work.rows.solved[n_joint:], work.rows.body[n_joint:]
    delassus(rows, solved, row_body, shares.part, 3 * n, shares.G)


@kernel
def pose_group(work: SpatialWork, i: int, n: int) -> None:
    """The problem of shares of the n contacts gathered."""
    s, p = work.impulses.solver.shares, work.impulses.p
    G, first = work.impulses.solver.shares.G, work.posed.islands.start[i]
    for e in range(n):
        k = work.posed.islands.contact[first + s.member[e]]
        for x in range(3):
            r = e if x == 0 else s.rough[e] + x - 1
            if x > 0 and s.rough[e] < 0:
                break
            s.x[r] = p[work.rows.n_joint + k] if x == 0 else p[tangents_of(work, k) + x - 1]
            s.own[r], s.weight[r], s.contact[r] = G[3 * e + x, 3 * e + x], work.rows.table.weight[k], e
            for d in range(n):
                s.W[r, d] = G[3 * e + x, 3 * d]
                if s.rough[d] >= 0:
                    s.W[r, s.rough[d]], s.W[r, s.rough[d] + 1] = G[3 * e + x, 3 * d + 1], G[3 * e + x, 3 * d + 2]
                else:
                    s.W[r, d] += s.along[d, 0] * G[3 * e + x, 3 * d + 1] + s.along[d, 1] * G[3 * e + x, 3 * d + 2]


@kernel
def changed(work: SpatialWork, i: int, n: int) -> float:
    """Largest change of a normal force by the shares found, over the largest one."""
    s, p, first = work.impulses.solver.shares, work.impulses.p, work.posed.islands.start[i]
    most, largest = 0.0, 0.0
    for e in range(n):
        f = p[work.rows.n_joint + work.posed.islands.contact[first + s.member[e]]]
        most, largest = max(most, abs(s.x[e] - f)), max(largest, f)
    return most / largest if largest > 0.0 else 0.0


@kernel
def way(work: SpatialWork, i: int, n: int) -> float:
    """The part of the way to the shares found on which contacts that stick stay in their cones."""
    s, p, first = work.impulses.solver.shares, work.impulses.p, work.posed.islands.start[i]
    part = 1.0
    for e in range(n):
        if s.rough[e] >= 0:
            k = work.posed.islands.contact[first + s.member[e]]
            t, j = tangents_of(work, k), s.rough[e]
            f, f1, f2 = p[work.rows.n_joint + k], p[t], p[t + 1]
            part = min(part, way_in_cone(f, f1, f2, s.x[e] - f, s.x[j] - f1, s.x[j + 1] - f2, work.rows.mu[k]))
    return part


@kernel
def take_shares(work: SpatialWork, i: int, n: int, part: float, posed: bool) -> None:
    """``part`` of the way to the shares found, with the friction under them; note where slip feels it."""
    memory, s = work.impulses.solver, work.impulses.solver.shares
    p, first = work.impulses.p, work.posed.islands.start[i]
    for e in range(n):
        c = s.member[e]
        k = work.posed.islands.contact[first + c]
        r, t, j = work.rows.n_joint + k, tangents_of(work, k), s.rough[e]
        d = part * (s.x[e] - p[r])
        d1, d2 = s.along[e, 0] * d, s.along[e, 1] * d
        if j >= 0:
            d1, d2 = part * (s.x[j] - p[t]), part * (s.x[j + 1] - p[t + 1])
        elif t >= 0:  # on the edge exactly
            d1, d2 = s.along[e, 0] * (p[r] + d) - p[t], s.along[e, 1] * (p[r] + d) - p[t + 1]
        s.z[3 * e], s.z[3 * e + 1], s.z[3 * e + 2] = d, d1, d2
        p[r] += d
        if t >= 0:
            p[t] += d1
            p[t + 1] += d2
        if not posed:
            push(memory.scene, memory.group, c, (d, d1, d2))
    for e in range(n):
        k = work.posed.islands.contact[first + s.member[e]]
        if s.rough[e] >= 0 or tangents_of(work, k) < 0:
            continue
        for x in range(3 * e + 1, 3 * e + 3):
            felt = 0.0
            for y in range(3 * n):
                felt += s.G[x, y] * s.z[y]
            if memory.group.unit[s.member[e]] * abs(felt) > MATTERS * memory.judged.load:
                s.told = 1 + work.rows.table.law[k]


@kernel
def share_group(work: SpatialWork, i: int, leader: int, posed: bool) -> bool:
    """Divide the load of one pair of bodies; whether something changed."""
    n = gather(work, i, leader, posed)
    if n == 0:
        return False
    respond(work, i, n, posed)
    pose_group(work, i, n)
    if not share_out(work.impulses.solver.shares) or not changed(work, i, n) > SETTLED:
        return False
    part = way(work, i, n)
    if not part > 0.0:
        return False
    take_shares(work, i, n, part, posed)
    return True


@kernel
def put_forces(work: SpatialWork, i: int, back: bool) -> None:
    """Forces of island i to ``shares.before``; or ``back`` from there."""
    before, p, first = work.impulses.solver.shares.before, work.impulses.p, work.posed.islands.start[i]
    for c in range(work.posed.islands.start[i + 1] - first):
        k = work.posed.islands.contact[first + c]
        r, t = work.rows.n_joint + k, tangents_of(work, k)
        for x in range(3 if t >= 0 else 1):
            at = r if x == 0 else t + x - 1
            if back:
                p[at] = before[3 * c + x]
            else:
                before[3 * c + x] = p[at]


@late_kernel
def judge_forces(work: SpatialWork, posed: bool, mend: bool) -> bool:
    """Judge the forces ``work.impulses.p`` of the island solved last, mended where needed if that is asked for.

    Whether they are good enough.
    """
    memory = work.impulses.solver
    if posed:
        give_forces(work)
        good = weigh_posed(memory)
        if not good and mend:
            good = mend_posed(memory)
            take_forces(work)
    else:
        judge_island(work)
        good = is_good(memory.judged)
        if not good and mend:
            good = sweep_island(work, FIRST_SWEEPS, False)
    tell(memory)
    return good


@late_kernel
def divide(work: SpatialWork, i: int, posed: bool) -> bool:
    """Divide the loads of island i until shares and forces agree; False where sweeps find no forces for them."""
    shares = work.impulses.solver.shares
    n = work.posed.islands.start[i + 1] - work.posed.islands.start[i]
    for _ in range(TURNS):
        moved = False
        for c in range(n):
            if shares.leader[c] == c and shares.count[c] >= NEEDED:
                moved = share_group(work, i, c, posed) or moved
        if not moved:
            return True
        if not judge_forces(work, posed, True):
            return False
    return True


@kernel
def share_loads(work: SpatialWork, i: int, posed: bool) -> None:
    """Divide the loads of the contacts of island i, whose forces ``work.impulses.p`` have just been judged good enough.

    posed: as one dense problem, joints condensed. Where dividing leads nowhere, the forces stay as they are.
    """
    n = work.posed.islands.start[i + 1] - work.posed.islands.start[i]
    if work.impulses.solver.judged.sliding == 0 or n < NEEDED:
        return
    if posed and shares_in_joints(work, i):
        for c in range(n):
            work.impulses.solver.shares.leader[c] = 0
        work.impulses.solver.shares.count[0] = n
    elif not find_groups(work, i):
        return
    put_forces(work, i, False)
    if not divide(work, i, posed):
        put_forces(work, i, True)
        judge_forces(work, posed, False)
