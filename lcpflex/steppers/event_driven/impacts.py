"""Impacts at an event, by the law of the run (:mod:`lcpflex.dynamics.impact_laws`), one contact problem a call.

An impact begins where a closed contact approaches faster than the velocity threshold, or where the acceleration level
has no solution (Painleve). It is over when its impulses are laid; others follow until no contact approaches.
"""

from __future__ import annotations

import math

from lcpflex.dynamics.acceleration import lay_rows
from lcpflex.dynamics.delassus import apply_impulses, row_velocity
from lcpflex.dynamics.impact import energetic_segments, lay_impulse, shift_normals
from lcpflex.dynamics.impact_laws import ENERGETIC, NEWTON, POISSON
from lcpflex.dynamics.impulse import distribute, pose, solve_lcp
from lcpflex.dynamics.workspace import Workspace
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.model.arrays import Model
from lcpflex.steppers.event_driven.bounces import note_strike, too_low
from lcpflex.steppers.event_driven.memory import (
    ALONE,
    CUTS,
    DETAIL,
    FASTEST,
    FIRST_TIE,
    FOUND,
    GAINED,
    GENTLEST,
    HITS,
    JAMMING,
    LOW,
    NUDGING,
    ROUND,
    STAGE,
    STOPPING,
    TARGET,
    TIES,
    TIME,
    EventMemory,
    EventSettings,
    copy_entry,
)
from lcpflex.steppers.recorder import Tape, note_certificate, note_gain

__all__ = ["AGAIN", "COUPLED", "HIT", "JAM", "RESOLVED", "SLOWEST", "UNSOLVED", "collide"]

# what a call returns
RESOLVED = 0
AGAIN = 1
UNSOLVED = 4
COUPLED = 5  # several contacts at once, which the law cannot treat

LOOKING, STRIKING, EXPANDING = 0, 1, 2  # number[STAGE]
HIT, JAM = 1, 2  # law_state[2]

ROUNDS = 30  # simultaneous impacts at one instant: the last third without restitution
SLOWEST = 1e-3  # of the velocity threshold: slower approach is none
TIE = 1e-6  # of the velocity: contacts that approach as equally as that are told apart by errors of integration
CHAIN = 1000  # impacts of single contacts at one instant, after which they are simultaneous and without restitution


@kernel
def account(work: Workspace, memory: EventMemory, tape: Tape, u: FloatArray) -> None:
    """Energy and impulses of the impact just solved, u after, ``memory.u`` before: p does p (w . u + w . u+) / 2."""
    n_joint = work.n_joint
    n = work.n_contacts
    base = 2 * len(u)
    for r in range(n_joint + n + work.n_tangents):
        p = work.p[r]
        if p == 0.0:
            continue
        before = row_velocity(work.rows, work.row_body, r, work.dof, memory.u)
        done = 0.5 * p * (before + row_velocity(work.rows, work.row_body, r, work.dof, u))
        if r < n_joint:
            if work.rate[r] != 0.0:
                memory.y[base + 2] += done
            continue
        memory.clock[GAINED] += done
        part = 0
        if r < n_joint + n:
            k = r - n_joint
            tape.counts.lost_impacts -= done
        else:
            k = work.tangent[r - n_joint - n]
            part = 1
            memory.y[base] -= done
        law = work.table.law[k]
        memory.law_work[law] += done
        if part == 0 and memory.number[JAMMING] == 0 and memory.number[STOPPING] != 1:
            note_strike(memory, work.table.key[k])
        if memory.law_state[2, law] == 0 and memory.number[STOPPING] != 1:
            memory.law_state[2, law] = JAM if memory.number[JAMMING] == 1 else HIT
        memory.y[base + 3 + 2 * law + part] += p


@kernel
def keep_closed(settings: EventSettings, work: Workspace, memory: EventMemory, u: FloatArray) -> None:
    """Keep those contacts in the table that do not leave, by the rows laid."""
    kept = 0
    for k in range(memory.number[FOUND]):
        if row_velocity(work.rows, work.row_body, work.n_joint + k, work.dof, u) <= settings.velocity_threshold:
            copy_entry(work.table, k, work.table, kept)
            kept += 1
    memory.number[FOUND] = kept


@kernel
def note_tie(settings: EventSettings, work: Workspace, memory: EventMemory, k: int, first: float, v: float) -> None:
    """Note it if contact k, now at v, approached as fast as the ``first`` one did that was struck, and felt that."""
    number = memory.number
    before = memory.approach[k]
    equal = before < -settings.velocity_threshold and abs(before - first) <= TIE * abs(first)
    if equal and abs(v - before) > TIE * abs(before):
        number[TIES] += 1
        if number[TIES] == 1:
            memory.clock[FIRST_TIE] = memory.clock[TIME]
            memory.tied[0] = work.table.law[0]
            memory.tied[1] = work.table.law[k]


@kernel
def look(settings: EventSettings, work: Workspace, memory: EventMemory, u: FloatArray) -> int:
    """The contact that approaches fastest, to number[TARGET] unless one is jammed; AGAIN if there is an impact.

    Contacts of Stronge's law, one by one, must not change the velocity of others that approach.
    """
    number = memory.number
    threshold = settings.velocity_threshold
    n = number[FOUND]
    guarded = settings.law == ENERGETIC and not settings.sequential and number[ROUND] > 0
    if number[STOPPING] == 1:
        threshold *= SLOWEST
        guarded = False
    in_turn = number[ROUND] > 0 and number[ALONE] == 1 and number[JAMMING] == 0 and number[STOPPING] == 0
    struck = memory.approach[0]
    at = 0
    lowest = 0.0
    coupled = False
    for k in range(n):
        v = row_velocity(work.rows, work.row_body, work.n_joint + k, work.dof, u)
        if guarded and k > 0 and abs(v - memory.approach[k]) > 1e-3 * threshold:
            coupled = coupled or min(v, memory.approach[k]) < -threshold
        if in_turn and k > 0:
            note_tie(settings, work, memory, k, struck, v)
        memory.approach[k] = v
        if v < lowest:
            lowest = v
            at = k
    if coupled:
        return COUPLED
    memory.clock[FASTEST] = max(memory.clock[FASTEST], -lowest)
    if number[NUDGING] == 0:
        if lowest >= -threshold:
            return RESOLVED
        if number[STOPPING] == 0:
            memory.clock[GENTLEST] = min(memory.clock[GENTLEST], -lowest)
        number[TARGET] = at
    return AGAIN


@kernel
def bring_forward(work: Workspace, memory: EventMemory, k: int) -> None:
    """Exchange entry k of the table with the first one."""
    if k > 0:
        copy_entry(work.table, 0, memory.seen, 0)
        copy_entry(work.table, k, work.table, 0)
        copy_entry(memory.seen, 0, work.table, k)
        memory.approach[0], memory.approach[k] = memory.approach[k], memory.approach[0]


@kernel
def begin(settings: EventSettings, work: Workspace, memory: EventMemory) -> None:
    """Begin an impact: of all closed contacts, or of one, which comes first in the table."""
    number = memory.number
    number[ROUND] += 1
    number[STAGE] = STRIKING
    number[JAMMING] = number[NUDGING]
    number[ALONE] = 1 if settings.sequential or settings.law == ENERGETIC else 0
    if number[STOPPING] == 1:
        number[ALONE] = 0
    if number[ALONE] == 1 and number[ROUND] > CHAIN:
        number[ALONE] = 0
        if number[ROUND] == CHAIN + 1:
            number[CUTS] += 1
    if number[ALONE] == 1:
        bring_forward(work, memory, number[TARGET])
    memory.clock[GAINED] = 0.0


@kernel
def end(memory: EventMemory, tape: Tape) -> None:
    """End an impact."""
    memory.number[STAGE] = LOOKING
    memory.number[NUDGING] = 0
    if memory.number[STOPPING] == 1:
        memory.number[STOPPING] = 2
    else:
        memory.number[HITS] = 1
    note_gain(tape, memory.clock[TIME], memory.clock[GAINED])


@kernel
def strike_by_energy(
    model: Model, settings: EventSettings, work: Workspace, memory: EventMemory, tape: Tape, u: FloatArray
) -> int:
    """Impact of the only contact laid, by Stronge's law."""
    n_joint = work.n_joint
    gnt = 0.0
    gtt = 0.0
    v_t = 0.0
    mu = 0.0
    v_n = min(work.bc[0], 0.0)
    if work.n_tangents > 0:
        gnt = work.Gc[0, 1]
        gtt = work.Gc[1, 1]
        v_t = work.bc[1]
        mu = work.mu[0]
        if abs(v_t) <= 1e-14 * abs(v_n):
            v_t = 0.0
    e = model.contacts.restitution[work.table.law[0]]
    count = energetic_segments(work.Gc[0, 0], gnt, gtt, v_n, v_t, mu, e, memory.segments)
    if count < 0:
        return UNSOLVED
    total = n_joint + 1 + work.n_tangents
    for i in range(count):
        lay_impulse(work, memory.segments[i, 0], memory.segments[i, 1])
        apply_impulses(work.solved, work.row_body, 0, total, work.p, work.dof, u)
        account(work, memory, tape, u)
        for c in range(len(u)):
            memory.u[c] = u[c]
    return RESOLVED


@kernel
def without_restitution(memory: EventMemory) -> bool:
    """Whether approach or bounce are too small, or so many impacts were at this instant that they are to end."""
    most = CHAIN if memory.number[ALONE] == 1 or memory.number[ROUND] > CHAIN else 2 * ROUNDS // 3
    return memory.number[ROUND] > most or memory.number[STOPPING] == 1 or memory.number[LOW] == 1


@kernel
def compressed(model: Model, settings: EventSettings, work: Workspace, memory: EventMemory) -> bool:
    """Whether contacts give back some of the impulses just laid: at least how much, to ``memory.least``."""
    number = memory.number
    if settings.law != POISSON or number[STAGE] == EXPANDING or without_restitution(memory):
        return False
    gives = False
    for k in range(work.n_contacts):
        memory.least[k] = model.contacts.restitution[work.table.law[k]] * work.normal[k]
        gives = gives or memory.least[k] > 0.0
    return gives


@kernel
def collide(model: Model, settings: EventSettings, work: Workspace, memory: EventMemory, tape: Tape) -> int:
    """One contact problem; AGAIN, or RESOLVED: no closed contact approaches, those that leave are out of the table."""
    number = memory.number
    ndof = len(memory.u)
    q = memory.y[:ndof]
    u = memory.y[ndof : 2 * ndof]
    looking = number[STAGE] == LOOKING
    n = number[FOUND]
    if not looking and number[ALONE] == 1:
        n = 1
    lay_rows(model, memory.clock[TIME], q, u, n, work, memory.sets)
    if looking:
        limit = CHAIN + ROUNDS if settings.sequential or settings.law == ENERGETIC else ROUNDS
        found = look(settings, work, memory, u)
        if found == COUPLED:
            return COUPLED
        if found == RESOLVED or number[ROUND] >= limit:
            keep_closed(settings, work, memory, u)
            return RESOLVED
        number[LOW] = 0
        if number[NUDGING] == 0 and too_low(model, settings, work, memory, number[TARGET]):
            number[LOW] = 1
        begin(settings, work, memory)
        if number[ALONE] == 1:
            return AGAIN
    law = NEWTON if number[ROUND] > CHAIN or number[STOPPING] == 1 or number[LOW] == 1 else settings.law
    threshold = math.inf if without_restitution(memory) else settings.velocity_threshold
    for i in range(ndof):
        memory.u[i] = u[i]
        work.free_u[i] = u[i]
        memory.reflected[i] = u[i] if law == NEWTON else 0.0
    pose(model, work, memory.reflected, 0.0, threshold)
    memory.clock[DETAIL] = 0.0
    if law == ENERGETIC:
        if strike_by_energy(model, settings, work, memory, tape, u) != RESOLVED:
            return UNSOLVED
        end(memory, tape)
        return AGAIN
    if number[STAGE] == EXPANDING:
        shift_normals(work, memory.least)
    elif number[NUDGING] == 1:
        for k in range(n):
            work.q[k] -= settings.velocity_threshold  # an approach assumed where there is none
    status = solve_lcp(work)
    memory.clock[DETAIL] = status
    if status != 0 or not work.certified <= settings.tolerance:
        return UNSOLVED
    note_certificate(work, tape)
    if number[STAGE] == EXPANDING:
        for k in range(n):
            work.z[k] += memory.least[k]
    distribute(work)
    apply_impulses(work.solved, work.row_body, 0, work.n_joint + n + work.n_tangents, work.p, work.dof, u)
    account(work, memory, tape, u)
    if compressed(model, settings, work, memory):
        number[STAGE] = EXPANDING
    else:
        end(memory, tape)
    return AGAIN
