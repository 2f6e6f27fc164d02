"""Impacts of an event-driven run in space: what their impulses do, and the second problem of Poisson's law."""

from __future__ import annotations

from typing import Any

from lcpflex.dynamics.acceleration import FORCE
from lcpflex.dynamics.delassus import row_velocity
from lcpflex.dynamics.joint_reactions import note_impulses
from lcpflex.dynamics.spatial.acceleration import SpatialContactSets, across
from lcpflex.dynamics.spatial.inertia import SpatialWork
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.solvers.contact.index_sets import SMOOTH, STICKING
from lcpflex.steppers.event_driven.bounces import note_strike
from lcpflex.steppers.event_driven.impacts import HIT, JAM
from lcpflex.steppers.island_problems import solve_islands
from lcpflex.steppers.recorder import Recorder
from lcpflex.steppers.spatial.sets import solve_on_sets
from lcpflex.steppers.spatial.sliding import first_side, sum_of
from lcpflex.steppers.status import RunStatus

__all__ = ["account", "solve_strike"]


@kernel
def account(model: Any, work: SpatialWork, memory: Any, recorder: Recorder, u: FloatArray) -> None:
    """Energy and impulses of the impact just solved, u after, ``memory.u`` before: p does p (w . u + w . u+) / 2."""
    n_joint, n = work.rows.n_joint, work.rows.n_contacts
    base = memory.nq + len(u)
    if n_joint > 0:
        note_impulses(model, work, True, recorder.reactions)
    for r in range(n_joint + n + work.rows.n_tangents):
        p = work.impulses.p[r]
        if p == 0.0:
            continue
        before = row_velocity(work.rows.J, work.rows.body, r, work.rows.dof, memory.u)
        done = 0.5 * p * (before + row_velocity(work.rows.J, work.rows.body, r, work.rows.dof, u))
        if r < n_joint:
            if work.rows.rate[r] != 0.0:
                memory.y[base + 2] += done
            continue
        memory.gained += done
        if r < n_joint + n:
            k = r - n_joint
            recorder.counts.lost_impacts -= done
            memory.y[sum_of(work, memory, k)] += p
            if memory.jamming == 0 and memory.stopping != 1:
                note_strike(memory, work.rows.table.key[k])
        else:
            j = r - n_joint - n
            k = work.rows.tangent[j]
            memory.y[base] -= done
            first, second = across(work, k)
            at, side = sum_of(work, memory, k) + 1, first_side(work, memory, k)
            for i in range(3):
                memory.y[at + i] += side * p * (first[i] if work.posed.tangent_of[k] == j else second[i])
        law = work.rows.table.law[k]
        memory.law_work[law] += done
        if memory.law_state[2, law] == 0 and memory.stopping != 1:
            memory.law_state[2, law] = JAM if memory.jamming == 1 else HIT


@kernel
def all_free(work: SpatialWork, sets: SpatialContactSets) -> None:
    """No contact is known to slide."""
    sets.level = FORCE
    for k in range(work.rows.n_contacts):
        sets.mode[k] = STICKING if sets.tangent_of[k] >= 0 else SMOOTH


@kernel
def solve_strike(
    work: SpatialWork,
    sets: SpatialContactSets,
    t: float,
    tolerance: float,
    warm: bool,
    last: bool,
    recorder: Recorder,
) -> int:
    """The problems of an impact that are not solved yet; those with impulses that are at least something here."""
    if work.posed.shifted == 0:
        return solve_islands(work, t, tolerance, warm, last, recorder)
    all_free(work, sets)
    islands = work.posed.islands
    while islands.next < islands.count:
        status = solve_on_sets(work, sets, islands.next, tolerance, warm, recorder)
        if status != RunStatus.DONE:
            return status
        islands.next += 1
    return RunStatus.DONE
