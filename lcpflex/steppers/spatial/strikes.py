"""Impacts of an event-driven run in space: what their impulses do, and the second problem of Poisson's law."""

from __future__ import annotations

from typing import Any

from lcpflex.dynamics.acceleration import FORCE
from lcpflex.dynamics.spatial.acceleration import SpatialContactSets, across
from lcpflex.dynamics.spatial.inertia import SpatialWork
from lcpflex.jit.kernel import kernel
from lcpflex.solvers.contact.index_sets import SMOOTH, STICKING
from lcpflex.steppers.island_problems import solve_islands
from lcpflex.steppers.recorder import Recorder
from lcpflex.steppers.spatial.sets import solve_on_sets
from lcpflex.steppers.spatial.sliding import first_side, sum_of
from lcpflex.steppers.status import RunStatus

__all__ = ["add_to_sums", "solve_strike"]


@kernel
def add_to_sums(work: SpatialWork, memory: Any, r: int, k: int, p: float) -> None:
    """The impulse p on row r, of contact k, to those of its law so far, friction in world axes."""
    at, first_tangent = sum_of(work, memory, k), work.rows.n_joint + work.rows.n_contacts
    if r < first_tangent:
        memory.y[at] += p
        return
    first, second = across(work, k)
    along, side = first if work.posed.tangent_of[k] == r - first_tangent else second, first_side(work, memory, k)
    for i in range(3):
        memory.y[at + 1 + i] += side * p * along[i]


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
