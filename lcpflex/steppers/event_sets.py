"""What happens at an event: impacts, then the choice of the index sets anew.

1. All pairs with a closed gap enter the impulse-level LCP as long as one of them approaches faster than the velocity
   threshold. Slower approach is not reflected (e_N = 0) but stopped: this ends the infinitely many impacts
   of a bouncing body (Zeno) after finitely many.
2. Those that do not leave enter the acceleration-level LCP: it tells who stays closed, sticks, slips, separates.
   Contacts without force are let go: a closed gap that carries nothing is watched like an open one.
3. If that LCP has no solution (Painleve's paradox), an impulse resolves it: an impact without collision.
"""

from __future__ import annotations

import math

from lcpflex.compiled import FloatArray, kernel
from lcpflex.contact.detection import detect
from lcpflex.dynamics.acceleration import (
    SLIDE_BACK,
    SLIDE_FORTH,
    SMOOTH,
    STICKING,
    assemble,
    lay_rows,
    pose_sets,
)
from lcpflex.dynamics.delassus import apply_impulses, row_velocity
from lcpflex.dynamics.impulse import distribute, pose, solve_lcp
from lcpflex.dynamics.workspace import Workspace
from lcpflex.model import OPEN, SLIP, STICK, Model
from lcpflex.solvers.friction import split_friction_solution
from lcpflex.steppers.event_memory import (
    CONE,
    CONTACTS,
    DETAIL,
    FOUND,
    HITS,
    IMPACT,
    LIFT_OFF,
    NUDGE,
    PRESSURE,
    REVERSES,
    SLIPS,
    STICKS,
    STORED,
    TIME,
    TOUCH_DOWN,
    EventMemory,
    EventSettings,
    copy_entry,
    note_event,
)
from lcpflex.steppers.event_segment import FORCE_TOLERANCE, SLIP_PART
from lcpflex.steppers.tape import Tape, note_gain

__all__ = ["RESOLVED", "UNSOLVED", "choose", "collide", "fall_back", "gather", "note_changes"]

NO_EVENT = -1
SLIP_BACK = SLIP + 1  # tells the direction, for events
RESOLVED = 0
UNSOLVED = 4
ROUNDS = 30  # of impacts at one instant: the last third without restitution
CARRIES = 1e-10  # part of the largest contact force below which a contact carries nothing
INSIDE = 1e-6  # part of the largest contact force by which a sticking contact must be inside its cone


@kernel
def law_states(work: Workspace, memory: EventMemory) -> None:
    """State of each declared contact, sticking if any of its points sticks; the one before is kept."""
    row = 1
    for law in range(memory.law_state.shape[1]):
        memory.law_state[0, law] = memory.law_state[1, law]
        memory.law_state[row, law] = OPEN
    for k in range(memory.number[CONTACTS]):
        law = work.table.law[k]
        if memory.sets.mode[k] == STICKING:
            memory.law_state[row, law] = STICK
        elif memory.law_state[row, law] == OPEN:
            memory.law_state[row, law] = SLIP if memory.sets.mode[k] != SLIDE_BACK else SLIP_BACK


@kernel
def account(work: Workspace, memory: EventMemory, tape: Tape, u: FloatArray) -> None:
    """Energy and impulses of the impact just solved, u after, ``memory.u`` before: p does p (w . u + w . u+) / 2."""
    n_joint = work.step_size[0]
    n = work.step_size[1]
    base = 2 * len(u)
    gained = 0.0
    for r in range(n_joint + n + work.step_size[2]):
        p = work.p[r]
        if p == 0.0:
            continue
        before = row_velocity(work.rows, work.row_body, r, work.dof, memory.u)
        done = 0.5 * p * (before + row_velocity(work.rows, work.row_body, r, work.dof, u))
        if r < n_joint:
            if work.rate[r] != 0.0:
                memory.y[base + 2] += done
            continue
        gained += done
        part = 0
        if r < n_joint + n:
            k = r - n_joint
            tape.sums[1] -= done
        else:
            k = work.tangent[r - n_joint - n]
            part = 1
            memory.y[base] -= done
        law = work.table.law[k]
        memory.law_work[law] += done
        memory.law_state[2, law] = 1
        memory.y[base + 3 + 2 * law + part] += p
    note_gain(tape, memory.clock[TIME], gained)


@kernel
def note_certificate(work: Workspace, tape: Tape) -> None:
    """Keep the worst residual, size and pivots."""
    tape.worst[0] = max(tape.worst[0], work.certificate[0])
    tape.worst[3] = max(tape.worst[3], work.step_size[3])
    tape.worst[4] = max(tape.worst[4], work.certificate[1])


@kernel
def keep_closed(settings: EventSettings, work: Workspace, memory: EventMemory, u: FloatArray) -> None:
    """Keep those contacts in the table that do not leave, by the rows laid."""
    kept = 0
    for k in range(memory.number[FOUND]):
        if row_velocity(work.rows, work.row_body, work.step_size[0] + k, work.dof, u) <= settings.velocity_threshold:
            copy_entry(work.table, k, work.table, kept)
            kept += 1
    memory.number[FOUND] = kept


@kernel
def collide(model: Model, settings: EventSettings, work: Workspace, memory: EventMemory, tape: Tape) -> int:
    """Impulses until none of the closed contacts approaches; those that leave are dropped from the table.

    clock[NUDGE] [m/s] is an approach assumed once where there is none.
    """
    n = memory.number[FOUND]
    nudge = memory.clock[NUDGE]
    ndof = len(memory.u)
    q = memory.y[:ndof]
    u = memory.y[ndof : 2 * ndof]
    for turn in range(ROUNDS):
        lay_rows(model, memory.clock[TIME], q, u, n, work, memory.sets)
        n_joint = work.step_size[0]
        lowest = 0.0
        for k in range(n):
            lowest = min(lowest, row_velocity(work.rows, work.row_body, n_joint + k, work.dof, u))
        if lowest >= -settings.velocity_threshold and nudge == 0.0:
            break
        for i in range(ndof):
            memory.u[i] = u[i]
            work.free_u[i] = u[i]
        threshold = settings.velocity_threshold if 3 * turn < 2 * ROUNDS else math.inf
        pose(model, work, memory.u, 0.0, threshold)
        for k in range(n):
            work.q[k] -= nudge
        nudge = 0.0
        status = solve_lcp(work)
        memory.clock[DETAIL] = status
        if status != 0 or not work.certificate[0] <= settings.tolerance:
            return UNSOLVED
        note_certificate(work, tape)
        distribute(work)
        total = n_joint + n + work.step_size[2]
        apply_impulses(work.solved, work.row_body, 0, total, work.p, work.dof, u)
        account(work, memory, tape, u)
        memory.number[HITS] = 1
    keep_closed(settings, work, memory, u)
    return RESOLVED


@kernel
def sort_tangents(settings: EventSettings, n: int, work: Workspace, memory: EventMemory, u: FloatArray) -> None:
    """Sets H and G of n closed contacts, by their tangential velocities."""
    for k in range(n):
        tangent = memory.sets.tangent_of[k]
        memory.sets.mode[k] = SMOOTH
        if tangent >= 0:
            slip = row_velocity(work.rows, work.row_body, work.step_size[0] + n + tangent, work.dof, u)
            if abs(slip) <= SLIP_PART * settings.velocity_threshold:
                memory.sets.mode[k] = STICKING
            else:
                memory.sets.mode[k] = SLIDE_FORTH if slip > 0.0 else SLIDE_BACK


@kernel
def read_sets(n: int, n_stick: int, work: Workspace, memory: EventMemory) -> int:
    """Modes from the solved LCP, contacts without force left out; returns how many stay.

    A contact that is at the edge of its cone without moving (one of several that share a load) is set to stick for a
    try; ``fallback`` keeps its mode at the edge.
    """
    sets = memory.sets
    split_friction_solution(work.z, work.mu, sets.stick, n, n_stick, work.normal, work.tangential)
    largest = 0.0
    for k in range(n):
        largest = max(largest, work.normal[k])
        if work.Gc[k, k] > 0.0:
            largest = max(largest, abs(work.bc[k]) / work.Gc[k, k])
    kept = 0
    j = -1
    for k in range(n):
        mode = sets.mode[k]
        tried = mode
        if mode == STICKING:
            j += 1
            force = work.tangential[j]
            edge = work.mu[k] * work.normal[k] * (1.0 - FORCE_TOLERANCE)
            if abs(force) >= edge:
                mode = SLIDE_BACK if force > 0.0 else SLIDE_FORTH
                moved = sets.right[n + j]
                size = abs(moved)
                for c in range(n + n_stick):
                    x = work.normal[c] if c < n else work.tangential[c - n]
                    moved += sets.reduced[n + j, c] * x
                    size += abs(sets.reduced[n + j, c] * x)
                if abs(moved) > FORCE_TOLERANCE * size:
                    tried = mode
        if work.normal[k] > CARRIES * largest:
            copy_entry(work.table, k, work.table, kept)
            sets.mode[kept] = tried
            sets.fallback[kept] = mode
            kept += 1
    return kept


@kernel
def fall_back(memory: EventMemory) -> None:
    """Return to the modes of the LCP unless all contacts set to stick for a try are well inside their laws."""
    sets = memory.sets
    n = memory.number[CONTACTS]
    holds = True
    for k in range(n):
        inside = -FORCE_TOLERANCE * memory.force[0]
        if sets.mode[k] != sets.fallback[k]:
            inside = INSIDE * memory.force[0]
        holds = holds and memory.value[PRESSURE, k] >= 0.0 and memory.value[CONE, k] >= inside
    if not holds:
        for k in range(n):
            sets.mode[k] = sets.fallback[k]


@kernel
def choose(model: Model, settings: EventSettings, work: Workspace, memory: EventMemory, tape: Tape) -> int:
    """Modes of the closed contacts from the acceleration-level LCP; the table keeps those that carry a force."""
    n = memory.number[FOUND]
    ndof = len(memory.u)
    q = memory.y[:ndof]
    u = memory.y[ndof : 2 * ndof]
    t = memory.clock[TIME]
    kept = 0
    if n > 0:
        assemble(model, t, q, u, n, work, memory.sets)
        sort_tangents(settings, n, work, memory, u)
        n_stick = pose_sets(work, memory.sets)
        status = solve_lcp(work)
        memory.clock[DETAIL] = status
        if status != 0 or not work.certificate[0] <= settings.tolerance:
            return UNSOLVED
        note_certificate(work, tape)
        kept = read_sets(n, n_stick, work, memory)
    memory.number[CONTACTS] = kept
    return RESOLVED


@kernel
def note_changes(work: Workspace, memory: EventMemory) -> None:
    """Events of every declared contact: what it was before, whether it was hit, what it is now."""
    law_states(work, memory)
    t = memory.clock[TIME]
    for law in range(memory.law_state.shape[1]):
        before = memory.law_state[0, law]
        after = memory.law_state[1, law]
        for turn in range(2):
            kind = NO_EVENT
            change = 0.0
            if turn == 0:
                if memory.law_state[2, law] == 1:
                    kind = IMPACT
                    change = memory.law_work[law]
            elif before == after or memory.number[STORED] == 0:
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
    """All closed pairs into the table of the workspace. False leaves everything as it was: clock[DETAIL] are needed."""
    found = detect(model, memory.y[: len(memory.u)], settings.gap_tolerance, memory.seen)
    if found > len(memory.seen.key):
        memory.clock[DETAIL] = found
        return False
    for law in range(memory.law_state.shape[1]):
        memory.law_state[2, law] = 0
        memory.law_work[law] = 0.0
    memory.number[HITS] = 0
    memory.number[FOUND] = found
    memory.clock[NUDGE] = 0.0
    for k in range(found):
        copy_entry(memory.seen, k, work.table, k)
    return True
