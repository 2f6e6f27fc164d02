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
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.model.arrays import OPEN
from lcpflex.solvers.contact.cones.ambiguity import several_forces
from lcpflex.solvers.contact.cones.mixed import solve_mixed
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
    m = reduce_sets(work, sets)
    problem = sets.problem
    problem.n, problem.m = n, m
    for c in range(n):
        k = work.part[c]
        problem.at[c] = sets.at[c]
        problem.friction[c] = work.mu[k]
        problem.floor[c] = work.least[k] if work.shifted == 1 else 0.0
    for r in range(m):
        problem.q[r] = sets.right[r]
        problem.terms[r] = work.terms[work.part[sets.place[r]]]
        for s in range(m):
            problem.W[r, s] = sets.reduced[r, s]


@kernel
def solve_on_sets(
    work: SpatialWork, sets: SpatialContactSets, i: int, tolerance: float, warm: bool, recorder: Recorder
) -> int:
    """Forces of the contacts of island i to ``work.p``, on their sets; DONE, GROW, or SOLVER_FAILED."""
    if not fits(work, i):
        return RunStatus.GROW
    lay_mixed(work, sets, i)
    problem, solver, counts = sets.problem, work.solver, recorder.counts
    solver.residual = solve_mixed(problem, tolerance)
    solver.strict = problem.strict
    solver.size = problem.m
    solver.iterations = problem.iterations
    if not solver.residual <= tolerance:
        work.number = 1
        return RunStatus.SOLVER_FAILED
    counts.worst_residual = max(counts.worst_residual, solver.residual)
    counts.worst_size = max(counts.worst_size, problem.m)
    counts.worst_relative = max(counts.worst_relative, solver.strict)
    spread(work, sets, problem.r)
    return RunStatus.DONE


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
def read_sets(work: SpatialWork, memory: Any) -> None:
    """What each contact of the island just solved does: see the plane."""
    sets = memory.sets
    problem, x = sets.problem, sets.problem.r
    largest = 0.0
    for c in range(problem.n):
        largest = max(largest, x[c])
        if work.G[c, c] > 0.0:
            largest = max(largest, abs(sets.free[c]) / work.G[c, c])
    others = False
    for c in range(problem.n):
        k, t = work.part[c], sets.at[c]
        kept = not x[c] <= CARRIES * largest
        put_force(work, sets, k)
        sets.tried[k] = sets.mode[k]
        sets.fallback[k] = sets.mode[k]
        if t >= 0 and kept:
            friction = math.hypot(x[t], x[t + 1])
            if friction >= problem.friction[c] * x[c] * (1.0 - FORCE_TOLERANCE):
                keep_direction(work, sets, k, -x[t], -x[t + 1])
                sets.youth[k] = BEGINS
                sets.fallback[k] = SLIDING
                if not (rests(sets, t) and rests(sets, t + 1)):
                    sets.tried[k] = SLIDING
        if not kept and others and largest > 0.0 and rests(sets, c):
            memory.spared = 1 + work.table.law[k]
        others = others or kept
        sets.kept[k] = 1 if kept else 0


@kernel
def keep_sets(n: int, work: SpatialWork, memory: Any) -> None:
    """Leave those of n contacts in the table that are kept, with their modes."""
    sets = memory.sets
    kept = 0
    for k in range(n):
        if sets.kept[k] == 1:
            copy_entry(work.table, k, work.table, kept)
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

    Tried were the shortest forces, and sticking of contacts at the edge that do not move.
    """
    sets = memory.sets
    held = True
    for k in range(memory.n_contacts):
        inside = -FORCE_TOLERANCE * memory.force
        if sets.mode[k] != sets.fallback[k]:
            inside = INSIDE * memory.force
        held = held and memory.value[PRESSURE, k] >= 0.0 and memory.value[CONE, k] >= inside
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
            memory.taken[work.problem.pair[0]] = OPEN
