"""Islands whose contacts begin to slide or to open though other forces of the same contacts would hold them.

Between flush jaws on guides, no law of motion tells which corners carry the load. Sweeps may leave all of it to one
corner of each jaw, about which the rest turns or tilts: a solution of the contact problem, but one that forces which
all corners share do not have. So what was at rest stays there where some forces hold it with a reserve, see
:mod:`lcpflex.solvers.contact.cones.reserve`; where none do, the problem is solved once more, from those that miss
Coulomb's law by the least, brought into the cones.
"""

from __future__ import annotations

import math

from lcpflex.dynamics.delassus import delassus
from lcpflex.dynamics.spatial.contact_problem import has_joints
from lcpflex.dynamics.spatial.inertia import SpatialWork
from lcpflex.dynamics.spatial.shared_loads import put_forces, tangents_of, velocity_of
from lcpflex.jit.kernel import kernel, late_kernel
from lcpflex.solvers.contact.cones.mixed_problem import fill_units
from lcpflex.solvers.contact.cones.reserve import LIMIT, UNIQUE, held_forces
from lcpflex.solvers.contact.cones.shares import TOUCHING
from lcpflex.solvers.contact.judging import SLIDING
from lcpflex.solvers.contact.recollection import place_of

__all__ = ["GOES_ON", "hold_island", "moves", "way_of_motion"]

RESTED, SLID, NEW = 0, 1, 2  # what a contact did in the last step
GOES_ON, BEGINS, STOPS = 0, 1, 2  # what an island does that moves; the last: it goes on unless forces hold it


@kernel
def before(work: SpatialWork, k: int, c: int, guess: int) -> tuple[int, int]:
    """What contact k, the one at place c of its island, did in the last step, and where the next is looked for."""
    known, memory = work.impulses.remembered, work.impulses.solver
    place = place_of(known, work.rows.table.key[k], guess)
    if place < 0:
        return NEW, guess
    kept = known.force[known.now, place]
    slip = kept[4] * math.sqrt(kept[1] * kept[1] + kept[2] * kept[2] + kept[3] * kept[3])
    rested = kept[0] > 0.0 and memory.group.unit[c] * slip <= SLIDING * memory.judged.load
    return RESTED if rested else SLID, place + 1 if place + 1 < known.n else 0


@kernel
def moves(work: SpatialWork, i: int, posed: bool) -> bool:
    """Whether a contact of the island just solved slides, or one that carries nothing moves in any way."""
    memory, first = work.impulses.solver, work.posed.islands.start[i]
    found = memory.judged.sliding == 1
    for c in range(work.posed.islands.start[i + 1] - first):
        k = work.posed.islands.contact[first + c]
        if not found and not work.impulses.p[work.rows.n_joint + k] > 0.0:
            u, u1, u2 = velocity_of(work, posed, c)
            found = memory.group.unit[c] * (abs(u) + abs(u1) + abs(u2)) > SLIDING * memory.judged.load
    return found


@kernel
def can_stop(work: SpatialWork, i: int) -> bool:
    """Whether other forces, of no larger normal ones in all, may stop the island posed.

    Forces r that hold it take u W^-1 u >= (u_k / d_k)^2 more from the slip u found than those found: they press more
    where the slip is fast.
    """
    memory, first = work.impulses.solver, work.posed.islands.start[i]
    n, fastest, taken, most = work.posed.islands.start[i + 1] - first, 0.0, 0.0, 0.0
    for c in range(n):
        _, u1, u2 = velocity_of(work, True, c)
        slip = math.hypot(u1, u2)
        fastest, taken = max(fastest, slip), max(taken, memory.group.unit[c] * slip)
    for c in range(n):
        k = work.posed.islands.contact[first + c]
        _, u1, u2 = velocity_of(work, True, c)
        most += work.rows.mu[k] * work.impulses.p[work.rows.n_joint + k] * (fastest - math.hypot(u1, u2))
    return most >= taken * taken


@kernel
def way_of_motion(work: SpatialWork, i: int, posed: bool, resting: bool) -> int:
    """Whether the island just solved, which moves, begins to or may as well stop; all was at rest if ``resting``.

    It begins to where a contact slides or opens that was at rest; those that were not are marked by 0 in
    ``impulses.solver.held.rests``. With joints a contact that is new counts as one at rest. Without, the loads of most
    contacts are determined: islands in which something slides already are left alone.
    """
    memory, first = work.impulses.solver, work.posed.islands.start[i]
    n, rests, jointed = work.posed.islands.start[i + 1] - first, memory.held.rests, has_joints(work, i)
    if n > len(rests):
        return GOES_ON
    begins, guess = False, 0
    for c in range(n):
        k = work.posed.islands.contact[first + c]
        state = RESTED
        if not resting:
            state, guess = before(work, k, c, guess)
        rests[c] = 0 if state == SLID else 1
        if not jointed and state != RESTED:
            return GOES_ON
        u, u1, u2 = velocity_of(work, posed, c)
        begins = begins or (
            rests[c] == 1 and memory.group.unit[c] * (abs(u) + abs(u1) + abs(u2)) > SLIDING * memory.judged.load
        )
    if begins:
        return BEGINS if jointed else STOPS
    if memory.judged.sliding == 0 or not posed or not can_stop(work, i):
        return GOES_ON
    for c in range(n):
        rests[c] = 1
    return STOPS


@kernel
def lay_held(work: SpatialWork, i: int, posed: bool) -> float:
    """``work.impulses.solver.held`` of island i, with the forces ``work.impulses.p``; the largest normal one."""
    p, part, first = work.impulses.solver.held, work.impulses.solver.shares.part, work.posed.islands.start[i]
    n_joint, n = work.rows.n_joint, work.posed.islands.start[i + 1] - work.posed.islands.start[i]
    p.n, p.m, largest = n, n, 0.0
    for c in range(n):
        k = work.posed.islands.contact[first + c]
        t = tangents_of(work, k)
        p.friction[c], p.floor[c], p.at[c] = work.rows.mu[k], 0.0, -1
        part[c], p.r[c] = 3 * c if posed else k, work.impulses.p[n_joint + k]
        largest = max(largest, p.r[c])
        if t >= 0:
            p.at[c] = p.m
            for x in range(2):
                part[p.m] = 3 * c + 1 + x if posed else t - n_joint + x
                p.r[p.m] = work.impulses.p[t + x]
                p.m += 1
    if posed:
        for r in range(p.m):
            p.q[r] = work.posed.problem.free[part[r]]
            for s in range(p.m):
                p.W[r, s] = work.posed.problem.delassus[part[r], part[s]]
    else:
        delassus(work.rows.J[n_joint:], work.rows.solved[n_joint:], work.rows.body[n_joint:], part, p.m, p.W)
        for r in range(p.m):
            p.q[r] = work.free.v[n_joint + part[r]]
    fill_units(p)
    return largest


@kernel
def put_held(work: SpatialWork, i: int) -> None:
    """The forces found to ``work.impulses.p``, those that break Coulomb's law on the edge of their cones."""
    p, first = work.impulses.solver.held, work.posed.islands.start[i]
    for c in range(p.n):
        k = work.posed.islands.contact[first + c]
        t, j = tangents_of(work, k), p.at[c]
        f = max(p.x[c], 0.0)
        work.impulses.p[work.rows.n_joint + k] = f
        work.impulses.solver.group.slip[c] = 0.0
        if t >= 0:
            size, most = math.hypot(p.x[j], p.x[j + 1]), work.rows.mu[k] * f
            share = most / size if size > most else 1.0
            work.impulses.p[t], work.impulses.p[t + 1] = share * p.x[j], share * p.x[j + 1]


@late_kernel
def hold_island(work: SpatialWork, i: int, posed: bool, way: int) -> bool:
    """Forces ``p`` that hold the contacts marked; of an island that begins to slide, that miss it by the least.

    Whether there are such forces. Contacts that open in the solution found are left alone where all cannot be held. The
    forces of that solution go to ``shares.before``.
    """
    memory, p, first = work.impulses.solver, work.impulses.solver.held, work.posed.islands.start[i]
    largest = lay_held(work, i, posed)
    reserve = held_forces(p, largest)
    if not reserve > LIMIT:
        opens = False
        for c in range(p.n):
            k = work.posed.islands.contact[first + c]
            u, _, _ = velocity_of(work, posed, c)
            if (
                p.rests[c] == 1
                and not work.impulses.p[work.rows.n_joint + k] > 0.0
                and memory.group.unit[c] * u > TOUCHING * memory.judged.load
            ):
                p.rests[c], opens = 0, True
        if opens:
            lay_held(work, i, posed)
            reserve = held_forces(p, largest)
    if reserve == UNIQUE or (way == STOPS and not reserve > LIMIT):
        return False
    put_forces(work, i, False)
    put_held(work, i)
    return True
