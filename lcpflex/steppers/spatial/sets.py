"""Index sets of contacts in space, as the event-driven stepper chooses them: see the plane.

Contacts whose slip |gamma| is at most the threshold enter the problem of accelerations with a cone, those that slide
with their friction in the column of their normals (:mod:`lcpflex.solvers.contact.cones.mixed`). Of the former, those
whose force is inside the cone stick; those at its edge begin to slide against their friction.
"""

from __future__ import annotations

import math
from typing import Any

from lcpflex.dynamics.contact_problem import fits
from lcpflex.dynamics.spatial.acceleration import (
    BEGINS,
    SLIDING,
    SpatialContactSets,
    keep_direction,
    pose_on_sets,
    put_force,
    reduce_sets,
    slip_of,
    spread,
)
from lcpflex.dynamics.spatial.inertia import SpatialWork
from lcpflex.dynamics.spatial.shared_sets import share_mixed
from lcpflex.dynamics.spatial.turning_slip import add_across, eliminate_across
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.model.arrays import OPEN
from lcpflex.solvers.contact.cones.mixed import judge_mixed, solve_mixed
from lcpflex.solvers.contact.cones.reserve import LIMIT, UNIQUE, held_forces, most_reserve
from lcpflex.solvers.contact.cones.several import several_forces
from lcpflex.solvers.contact.index_sets import SMOOTH, STICKING
from lcpflex.steppers.event_driven.memory import CONE, PRESSURE, EventSettings, copy_entry
from lcpflex.steppers.event_driven.segment import FORCE_TOLERANCE
from lcpflex.steppers.recorder import Recorder
from lcpflex.steppers.status import RunStatus

__all__ = ["fall_back", "keep_sets", "note_paradox", "read_sets", "solve_on_sets", "sort_tangents"]

CARRIES = 1e-10  # as in the plane
INSIDE = 1e-6


@kernel
def sort_tangents(settings: EventSettings, n: int, work: SpatialWork, memory: Any, u: FloatArray) -> None:
    """Sets of n closed contacts, by their slip."""
    sets = memory.sets
    sets.slow = settings.slip_threshold
    sets.referred = 0
    for k in range(n):
        sets.mode[k] = SMOOTH
        sets.youth[k] = 0
        if sets.tangent_of[k] < 0:
            continue
        first, second = slip_of(work, sets, k, u)
        slip = math.hypot(first, second)
        memory.fastest = max(memory.fastest, slip)
        if slip <= sets.slow:
            sets.mode[k] = STICKING
        else:
            sets.mode[k] = SLIDING
            keep_direction(work, sets, k, first, second)


@kernel
def lay_mixed(work: SpatialWork, sets: SpatialContactSets, i: int) -> None:
    """``sets.problem`` of island i."""
    n = pose_on_sets(work, sets, i)
    eliminate_across(work, sets)
    m = reduce_sets(work, sets)
    problem = sets.problem
    problem.n, problem.m = n, m
    for c in range(n):
        k = work.posed.part[c]
        problem.at[c] = sets.at[c]
        problem.friction[c] = work.rows.mu[k]
        problem.floor[c] = work.posed.least[k] if work.posed.shifted == 1 else 0.0
    for r in range(m):
        problem.q[r] = sets.right[r]
        problem.terms[r] = work.free.terms[work.posed.part[sets.place[r]]]
        for s in range(m):
            problem.W[r, s] = sets.reduced[r, s]


@kernel
def rests(sets: SpatialContactSets, r: int) -> bool:
    """Whether unknown r of the solved problem has no acceleration."""
    total = sets.right[r]
    size = abs(total)
    for s in range(sets.problem.m):
        total += sets.reduced[r, s] * sets.problem.r[s]
        size += abs(sets.reduced[r, s] * sets.problem.r[s])
    return abs(total) <= FORCE_TOLERANCE * size


@kernel
def all_rest(sets: SpatialContactSets) -> bool:
    """Whether no unknown of the solved problem has an acceleration."""
    resting = True
    for r in range(sets.problem.m):
        resting = resting and rests(sets, r)
    return resting


@kernel
def prefer_rest(work: SpatialWork, sets: SpatialContactSets, tolerance: float) -> bool:
    """Of several solutions of an island that has not slid take the one at rest, if it has a reserve; whether it did.

    Where normal forces are not determined, the problem may be solved by slip under loads that others of them hold.
    """
    problem = sets.problem
    for c in range(problem.n):
        if sets.mode[work.posed.part[c]] == SLIDING:
            return False
    if all_rest(sets):
        return False
    largest = 0.0
    for r in range(problem.m):
        sets.reference[r] = problem.r[r]
    for c in range(problem.n):
        problem.rests[c] = 1
        largest = max(largest, problem.r[c])
    taken = held_forces(problem, largest) > LIMIT and judge_mixed(problem, sets.search, problem.x) <= tolerance
    for r in range(problem.m):
        problem.r[r] = problem.x[r] if taken else sets.reference[r]
    judge_mixed(problem, sets.search, problem.r)  # what the problem tells is told of what is taken
    return taken


@kernel
def solve_on_sets(
    work: SpatialWork, sets: SpatialContactSets, i: int, tolerance: float, warm: bool, recorder: Recorder
) -> int:
    """Forces of the contacts of island i to ``work.impulses.p``, on their sets; DONE, GROW, or SOLVER_FAILED."""
    if not fits(work, i):
        return RunStatus.GROW
    lay_mixed(work, sets, i)
    problem, solver, counts = sets.problem, work.impulses.solver, recorder.counts
    solver.residual = solve_mixed(problem, sets.search, tolerance)
    if work.posed.shifted == 0 and prefer_rest(work, sets, tolerance):
        solver.residual = judge_mixed(problem, sets.search, problem.r)
    solver.residual = share_mixed(work, sets, tolerance, solver.residual)
    solver.strict = problem.strict
    solver.size = problem.m
    solver.iterations = problem.iterations
    if not solver.residual <= tolerance:
        work.impulses.number = 1
        return RunStatus.SOLVER_FAILED
    counts.worst_residual = max(counts.worst_residual, solver.residual)
    counts.worst_size = max(counts.worst_size, problem.m)
    counts.worst_relative = max(counts.worst_relative, solver.strict)
    spread(work, sets, problem.r)
    add_across(work, sets)
    return RunStatus.DONE


@kernel
def share_load(work: SpatialWork, sets: SpatialContactSets, largest: float) -> float:
    """The forces of contacts at rest with most reserve, to ``problem.x``; their reserve over the ``largest`` force."""
    problem = sets.problem
    for c in range(problem.n):
        t = sets.at[c]
        free = rests(sets, c) and sets.mode[work.posed.part[c]] != SLIDING
        free = free and (t < 0 or (rests(sets, t) and rests(sets, t + 1)))
        problem.rests[c] = 1 if free else 0
    reserve = most_reserve(problem, largest)
    if reserve > UNIQUE:
        for r in range(problem.m):
            problem.r[r] = problem.x[r]
        spread(work, sets, problem.r)
    return reserve


@kernel
def at_limit(work: SpatialWork, sets: SpatialContactSets, c: int, largest: float) -> None:
    """Contact c at rest, of several that have no reserve: it slides where no choice of forces takes it off its edge."""
    k, t, x = work.posed.part[c], sets.at[c], sets.problem.r
    friction = math.hypot(x[t], x[t + 1])
    if x[c] > INSIDE * largest and friction >= sets.problem.friction[c] * (x[c] - INSIDE * largest) and friction > 0.0:
        keep_direction(work, sets, k, -x[t], -x[t + 1])
        sets.youth[k] = BEGINS
        sets.fallback[k] = SLIDING
        sets.tried[k] = SLIDING


@kernel
def at_edge(work: SpatialWork, sets: SpatialContactSets, c: int) -> None:
    """Contact c slides where its force is at the edge and it moves; where it does not move, it may stick for a try."""
    k, t, x = work.posed.part[c], sets.at[c], sets.problem.r
    friction = math.hypot(x[t], x[t + 1])
    if friction >= sets.problem.friction[c] * x[c] * (1.0 - FORCE_TOLERANCE):
        keep_direction(work, sets, k, -x[t], -x[t + 1])
        sets.youth[k] = BEGINS
        sets.fallback[k] = SLIDING
        if not (rests(sets, t) and rests(sets, t + 1)):
            sets.tried[k] = SLIDING


@kernel
def read_sets(work: SpatialWork, memory: Any) -> None:
    """What each contact of the island just solved does: see the plane.

    Those at rest that share a load in many ways stick as long as any forces keep them all inside Coulomb's law. One
    that has no share of a load that slides stays in its set: it may get one, and no event would tell.
    """
    sets = memory.sets
    problem, x = sets.problem, sets.problem.r
    scale, largest = 0.0, 0.0
    for c in range(problem.n):
        scale = max(scale, x[c])
        largest = max(largest, x[c])
        if work.scratch.G[c, c] > 0.0:
            largest = max(largest, abs(sets.free[c]) / work.scratch.G[c, c])
    for c in range(problem.n):
        idle = work.impulses.solver.shares.idle[c] == 1 and sets.at[c] < 0 and rests(sets, c)
        sets.kept[work.posed.part[c]] = 0 if x[c] <= CARRIES * largest and not idle else 1
    reserve = share_load(work, sets, scale)
    others = False
    for c in range(problem.n):
        k, t = work.posed.part[c], sets.at[c]
        shared = reserve > UNIQUE and problem.rests[c] == 1
        if shared and reserve > LIMIT:
            sets.kept[k] = 1
        kept = sets.kept[k] == 1
        put_force(work, sets, k)
        sets.tried[k] = sets.mode[k]
        sets.fallback[k] = sets.mode[k]
        if t >= 0 and kept:
            if not shared:
                at_edge(work, sets, c)
            elif reserve <= LIMIT:
                at_limit(work, sets, c, scale)
        if not kept and others and largest > 0.0 and rests(sets, c):
            memory.spared = 1 + work.rows.table.law[k]
        others = others or kept


@kernel
def keep_sets(n: int, work: SpatialWork, memory: Any) -> None:
    """Leave those of n contacts in the table that are kept, with their modes."""
    sets = memory.sets
    kept = 0
    for k in range(n):
        if sets.kept[k] == 1:
            copy_entry(work.rows.table, k, work.rows.table, kept)
            sets.mode[kept] = sets.tried[k]
            sets.fallback[kept] = sets.fallback[k]
            sets.youth[kept] = sets.youth[k]
            for i in range(3):
                sets.direction[kept, i] = sets.direction[k, i]
            for i in range(4):
                sets.chosen[kept, i] = sets.chosen[k, i]
            kept += 1
    memory.n_contacts = kept


@kernel
def fall_back(memory: Any) -> None:
    """Return to the problem of accelerations where what was tried breaks Coulomb's law.

    Tried were the shortest forces, and sticking of contacts at the edge that do not move. What is as near to the edge
    as it is at the event would break the law again at once.
    """
    sets = memory.sets
    held = True
    for k in range(memory.n_contacts):
        held = held and memory.value[PRESSURE, k] >= 0.0 and memory.value[CONE, k] >= INSIDE * memory.force
    if not held:
        sets.referred = 1
        for k in range(memory.n_contacts):
            sets.mode[k] = sets.fallback[k]


@kernel
def note_paradox(settings: EventSettings, work: SpatialWork, memory: Any) -> None:
    """Remember that a contact that is an island alone may move in several ways; beyond one it is not looked for."""
    problem = memory.sets.problem
    if problem.n == 1 and several_forces(problem.W, problem.q, problem.at[0], problem.friction[0]):
        memory.several_now = 1
        memory.several += 1
        if memory.several == 1:
            memory.first_several = memory.time
            memory.taken[work.posed.problem.pair[0]] = OPEN
