"""The choice of the index sets at an event, after its impacts (:mod:`lcpflex.steppers.event_driven.impacts`).

1. All pairs with a closed gap take part in impacts as long as one of them approaches faster than the velocity
   threshold. Slower approach is not reflected (e_N = 0) but stopped: this ends the infinitely many impacts
   of a bouncing body (Zeno) after finitely many.
2. Those that do not leave enter the acceleration-level LCP: it tells who stays closed, sticks, slips, separates.
   Contacts without force are let go: a closed gap that carries nothing is watched like an open one.
3. If that LCP has no solution (Painleve's paradox), an impulse resolves it: an impact without collision. If it has
   several motions, the run says so and goes on with the one that was found (tested up to 6 unknowns).
"""

from __future__ import annotations

from lcpflex.contact.detection import detect
from lcpflex.dynamics.acceleration import (
    SLIDE_BACK,
    SLIDE_FORTH,
    SMOOTH,
    STICKING,
    ContactSets,
    assemble,
    pose_sets,
    reduce_sets,
)
from lcpflex.dynamics.delassus import row_velocity
from lcpflex.dynamics.islands import forget_islands, unfinished
from lcpflex.dynamics.workspace import Workspace
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.jit.leaf import in_space
from lcpflex.model.arrays import OPEN, SLIP, STICK, Model
from lcpflex.solvers.contact.several_motions import several_motions
from lcpflex.steppers.event_driven.impacts import AGAIN, JAM, LOOKING, RESOLVED, SLOWEST, UNSOLVED
from lcpflex.steppers.event_driven.leaving import leave_passing
from lcpflex.steppers.event_driven.memory import (
    CONE,
    IMPACT,
    JAMS_UP,
    LIFT_OFF,
    PRESSURE,
    REVERSES,
    SLIPS,
    STICKS,
    TOUCH_DOWN,
    EventMemory,
    EventSettings,
    copy_entry,
    note_event,
)
from lcpflex.steppers.event_driven.segment import FORCE_TOLERANCE
from lcpflex.steppers.island_problems import solve_island
from lcpflex.steppers.recorder import Recorder
from lcpflex.steppers.status import RunStatus

__all__ = ["choose", "fall_back", "gather", "note_changes", "note_paradox"]

NO_EVENT = -1
SLIP_BACK = SLIP + 1  # tells the direction, for events
CARRIES = 1e-10  # part of the largest contact force below which a contact carries nothing
INSIDE = 1e-6  # part of the largest contact force by which a sticking contact must be inside its cone


@kernel
def law_states(work: Workspace, memory: EventMemory) -> None:
    """State of each declared contact, sticking if any of its points sticks; the one before is kept."""
    row = 1
    for law in range(memory.law_state.shape[1]):
        memory.law_state[0, law] = memory.law_state[1, law]
        memory.law_state[row, law] = OPEN
    for k in range(memory.n_contacts):
        law = work.rows.table.law[k]
        if memory.sets.mode[k] == STICKING:
            memory.law_state[row, law] = STICK
        elif memory.law_state[row, law] == OPEN:
            memory.law_state[row, law] = SLIP if memory.sets.mode[k] != SLIDE_BACK else SLIP_BACK


@in_space("lcpflex.steppers.spatial.sets")
@kernel
def sort_tangents(settings: EventSettings, n: int, work: Workspace, memory: EventMemory, u: FloatArray) -> None:
    """Sets H and G of n closed contacts, by their tangential velocities."""
    for k in range(n):
        tangent = memory.sets.tangent_of[k]
        memory.sets.mode[k] = SMOOTH
        if tangent >= 0:
            slip = row_velocity(work.rows.J, work.rows.body, work.rows.n_joint + n + tangent, work.rows.dof, u)
            memory.fastest = max(memory.fastest, abs(slip))
            if abs(slip) <= settings.slip_threshold:
                memory.sets.mode[k] = STICKING
            else:
                memory.sets.mode[k] = SLIDE_FORTH if slip > 0.0 else SLIDE_BACK


@in_space("lcpflex.steppers.spatial.sets")
@kernel
def read_sets(work: Workspace, memory: EventMemory) -> None:
    """What each contact of the island just solved does: ``tried``, ``fallback``, and whether it is ``kept``.

    Contacts without force are left out. A contact that is at the edge of its cone without moving (one of several that
    share a load) is set to stick for a try; ``fallback`` keeps its mode at the edge.
    """
    sets, problem, forces = memory.sets, work.posed.problem, work.impulses.solver
    n = problem.n_contacts
    n_stick = reduce_sets(work, sets)
    largest = 0.0
    for c in range(n):
        largest = max(largest, forces.normal[c])
        if problem.delassus[c, c] > 0.0:
            largest = max(largest, abs(problem.free[c]) / problem.delassus[c, c])
    others = False
    j = -1
    for c in range(n):
        k = work.posed.part[c]
        mode = sets.mode[k]
        tried = mode
        if mode == STICKING:
            j += 1
            force = forces.tangential[j]
            edge = work.rows.mu[k] * forces.normal[c] * (1.0 - FORCE_TOLERANCE)
            if abs(force) >= edge:
                mode = SLIDE_BACK if force > 0.0 else SLIDE_FORTH
                if not rests(n, n_stick, n + j, work, sets):
                    tried = mode
        kept = not forces.normal[c] <= CARRIES * largest
        if not kept and others and largest > 0.0 and rests(n, n_stick, c, work, sets):
            memory.spared = 1 + work.rows.table.law[k]
        others = others or kept
        sets.kept[k] = 1 if kept else 0
        sets.tried[k] = tried
        sets.fallback[k] = mode


@in_space("lcpflex.steppers.spatial.sets")
@kernel
def keep_sets(n: int, work: Workspace, memory: EventMemory) -> None:
    """Leave those of n contacts in the table that are kept, with their modes."""
    sets = memory.sets
    kept = 0
    for k in range(n):
        if sets.kept[k] == 1:
            copy_entry(work.rows.table, k, work.rows.table, kept)
            sets.mode[kept] = sets.tried[k]
            sets.fallback[kept] = sets.fallback[k]
            kept += 1
    memory.n_contacts = kept


@kernel
def rests(n: int, n_stick: int, r: int, work: Workspace, sets: ContactSets) -> bool:
    """Whether row r of the solved problem has no acceleration."""
    total = sets.right[r]
    size = abs(total)
    for c in range(n + n_stick):
        x = work.impulses.solver.normal[c] if c < n else work.impulses.solver.tangential[c - n]
        total += sets.reduced[r, c] * x
        size += abs(sets.reduced[r, c] * x)
    return abs(total) <= FORCE_TOLERANCE * size


@in_space("lcpflex.steppers.spatial.sets")
@kernel
def fall_back(memory: EventMemory) -> None:
    """Return to the modes of the LCP unless all contacts set to stick for a try are well inside their laws."""
    sets = memory.sets
    n = memory.n_contacts
    holds = True
    for k in range(n):
        inside = -FORCE_TOLERANCE * memory.force
        if sets.mode[k] != sets.fallback[k]:
            inside = INSIDE * memory.force
        holds = holds and memory.value[PRESSURE, k] >= 0.0 and memory.value[CONE, k] >= inside
    if not holds:
        for k in range(n):
            sets.mode[k] = sets.fallback[k]


@in_space("lcpflex.steppers.spatial.sets")
@kernel
def note_paradox(settings: EventSettings, work: Workspace, memory: EventMemory) -> None:
    """Remember that contacts of an island may move in several ways, and which contacts the first ones were."""
    if several_motions(work.posed.problem, work.impulses.solver, settings.tolerance, memory.trials):
        memory.several_now = 1
        memory.several += 1
        if memory.several == 1:
            memory.first_several = memory.time
            for c in range(work.posed.problem.n_contacts):
                memory.taken[work.posed.problem.pair[c]] = OPEN


@kernel
def still_approach(settings: EventSettings, work: Workspace, u: FloatArray) -> bool:
    """Whether contacts about to be let go approach, slower than the threshold: they would close again and again."""
    p, part, n_joint = work.impulses.p, work.posed.part, work.rows.n_joint
    n = work.posed.problem.n_contacts
    largest = 0.0
    for c in range(n):
        largest = max(largest, p[n_joint + part[c]])
    for c in range(n):
        if p[n_joint + part[c]] <= CARRIES * largest:
            v = row_velocity(work.rows.J, work.rows.body, n_joint + part[c], work.rows.dof, u)
            if v < -SLOWEST * settings.velocity_threshold:
                return True
    return False


@in_space("lcpflex.steppers.spatial.sets")
@kernel
def solve_on_sets(work: Workspace, sets: ContactSets, i: int, tolerance: float, warm: bool, recorder: Recorder) -> int:
    """Forces of the contacts of island i to ``work.impulses.p``, on their sets; returns as :func:`solve_island`."""
    return solve_island(work, i, tolerance, warm, recorder)


@kernel
def choose(model: Model, settings: EventSettings, work: Workspace, memory: EventMemory, recorder: Recorder) -> int:
    """Modes of the closed contacts from the acceleration-level LCPs; the table keeps those that carry a force.

    AGAIN: those let go have to be stopped first.
    """
    n = memory.n_found
    q = memory.y[: memory.nq]
    u = memory.y[memory.nq : memory.nq + len(memory.u)]
    islands = work.posed.islands
    if n > 0 and not unfinished(islands):
        assemble(model, memory.time, q, u, n, work, memory.sets)
        sort_tangents(settings, n, work, memory, u)
        pose_sets(work, memory.sets)
        memory.several_now = 0
    warm = False
    while n > 0 and islands.next < islands.count:
        status = solve_on_sets(work, memory.sets, islands.next, settings.tolerance, warm, recorder)
        if status != RunStatus.DONE:
            memory.number = work.impulses.number
            return UNSOLVED
        if memory.stopping == 0 and still_approach(settings, work, u):
            memory.stopping = 1
            forget_islands(islands)
            return AGAIN
        note_paradox(settings, work, memory)
        read_sets(work, memory)
        islands.next += 1
    keep_sets(n, work, memory)
    return RESOLVED


@kernel
def note_changes(work: Workspace, memory: EventMemory) -> None:
    """Events of every declared contact: what it was before, whether it was hit, what it is now."""
    law_states(work, memory)
    t = memory.time
    if memory.several_now == 1 and memory.several == 1:
        for law in range(len(memory.taken)):
            if memory.taken[law] >= 0:
                memory.taken[law] = memory.law_state[1, law]
    memory.several_now = 0
    for law in range(memory.law_state.shape[1]):
        before = memory.law_state[0, law]
        after = memory.law_state[1, law]
        for turn in range(2):
            kind = NO_EVENT
            change = 0.0
            if turn == 0:
                if memory.law_state[2, law] > 0:
                    kind = JAMS_UP if memory.law_state[2, law] == JAM else IMPACT
                    change = memory.law_work[law]
            elif before == after or memory.stored == 0:
                pass
            elif before == OPEN:
                kind = TOUCH_DOWN
            elif after == OPEN:
                kind = LIFT_OFF
            elif after == STICK:
                kind = STICKS
            else:
                kind = SLIPS if before == STICK else REVERSES
            if kind != NO_EVENT:
                note_event(memory, t, kind, law, change)


@kernel
def gather(model: Model, settings: EventSettings, work: Workspace, memory: EventMemory) -> bool:
    """All closed pairs into the table of the workspace. False leaves everything as it was: memory.number are needed."""
    found = detect(model, memory.y[: memory.nq], settings.gap_tolerance, memory.seen)
    if found <= len(memory.seen.key):
        found = leave_passing(model, settings, work, memory, found)
    if found > len(memory.seen.key):
        memory.number = found
        return False
    for law in range(memory.law_state.shape[1]):
        memory.law_state[2, law] = 0
        memory.law_work[law] = 0.0
    memory.hits = 0
    memory.n_found = found
    memory.round = 0
    memory.stage = LOOKING
    memory.nudging = 0
    memory.nudges = 0
    memory.stopping = 0
    for k in range(found):
        copy_entry(memory.seen, k, work.rows.table, k)
    return True
