"""Impacts at an event, by the law of the run (:mod:`lcpflex.dynamics.impact_laws`), one contact problem a call.

An impact begins where a closed contact approaches faster than the velocity threshold, or where the acceleration level
has no solution (Painleve). It is over when its impulses are laid; others follow until no contact approaches.
"""

from __future__ import annotations

import math

from lcpflex.dynamics.acceleration import ContactSets, lay_rows
from lcpflex.dynamics.contact_problem import pose_island
from lcpflex.dynamics.delassus import apply_impulses, row_velocity
from lcpflex.dynamics.impact_laws import gives_back, impact_phases, integrates, reflects
from lcpflex.dynamics.impulse import add_impulses, answer_joints, lay_impulse, pose
from lcpflex.dynamics.islands import forget_islands, unfinished
from lcpflex.dynamics.joint_reactions import note_impulses
from lcpflex.dynamics.workspace import Workspace
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.jit.leaf import in_space
from lcpflex.model.arrays import Model
from lcpflex.solvers.contact.algebra import PLANAR
from lcpflex.steppers.event_driven.bounces import note_strike, too_low
from lcpflex.steppers.event_driven.memory import (
    EventMemory,
    EventSettings,
    copy_entry,
)
from lcpflex.steppers.island_problems import solve_islands
from lcpflex.steppers.recorder import Recorder, note_gain
from lcpflex.steppers.status import RunStatus

__all__ = ["AGAIN", "COUPLED", "HIT", "JAM", "RESOLVED", "SLOWEST", "UNSOLVED", "collide"]

# what a call returns
RESOLVED = 0
AGAIN = 1
UNSOLVED = 4
COUPLED = 5  # several contacts at once, which the law cannot treat

LOOKING, STRIKING, EXPANDING = 0, 1, 2  # memory.stage
HIT, JAM = 1, 2  # law_state[2]

ROUNDS = 30  # simultaneous impacts at one instant: the last third without restitution
SLOWEST = 1e-3  # of the velocity threshold: slower approach is none
TIE = 1e-6  # of the velocity: contacts that approach as equally as that are told apart by errors of integration
CHAIN = 1000  # impacts of single contacts at one instant, after which they are simultaneous and without restitution


@kernel
def account(model: Model, work: Workspace, memory: EventMemory, recorder: Recorder, u: FloatArray) -> None:
    """Energy and impulses of the impact just solved, u after, ``memory.u`` before: p does p (w . u + w . u+) / 2."""
    n_joint = work.rows.n_joint
    n = work.rows.n_contacts
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
            if memory.jamming == 0 and memory.stopping != 1:
                note_strike(memory, work.rows.table.key[k])
        else:
            k = work.rows.tangent[r - n_joint - n]
            memory.y[base] -= done
        law = work.rows.table.law[k]
        memory.law_work[law] += done
        if memory.law_state[2, law] == 0 and memory.stopping != 1:
            memory.law_state[2, law] = JAM if memory.jamming == 1 else HIT
        add_to_sums(work, memory, r, k, p)


@in_space("lcpflex.steppers.spatial.strikes")
@kernel
def add_to_sums(work: Workspace, memory: EventMemory, r: int, k: int, p: float) -> None:
    """The impulse p on row r, of contact k, to those of its law so far."""
    part = 1 if r >= work.rows.n_joint + work.rows.n_contacts else 0
    memory.y[memory.nq + len(memory.u) + 3 + 2 * work.rows.table.law[k] + part] += p


@kernel
def keep_closed(settings: EventSettings, work: Workspace, memory: EventMemory, u: FloatArray) -> None:
    """Keep those contacts in the table that do not leave, by the rows laid."""
    kept = 0
    for k in range(memory.n_found):
        if (
            row_velocity(work.rows.J, work.rows.body, work.rows.n_joint + k, work.rows.dof, u)
            <= settings.velocity_threshold
        ):
            copy_entry(work.rows.table, k, work.rows.table, kept)
            kept += 1
    memory.n_found = kept


@kernel
def note_tie(settings: EventSettings, work: Workspace, memory: EventMemory, k: int, first: float, v: float) -> None:
    """Note it if contact k, now at v, approached as fast as the ``first`` one did that was struck, and felt that."""
    before = memory.approach[k]
    equal = before < -settings.velocity_threshold and abs(before - first) <= TIE * abs(first)
    if equal and abs(v - before) > TIE * abs(before):
        memory.ties += 1
        if memory.ties == 1:
            memory.first_tie = memory.time
            memory.tied[0] = work.rows.table.law[0]
            memory.tied[1] = work.rows.table.law[k]


@kernel
def fastest_approach(settings: EventSettings, work: Workspace, memory: EventMemory, u: FloatArray) -> int:
    """The contact that approaches fastest, to memory.target unless one is jammed; AGAIN if there is an impact.

    Contacts of a law that integrates, one by one, must not change the velocity of others that approach.
    """
    threshold = settings.velocity_threshold
    n = memory.n_found
    guarded = integrates(settings.law) and not settings.sequential and memory.round > 0
    if memory.stopping == 1:
        threshold *= SLOWEST
        guarded = False
    in_turn = memory.round > 0 and memory.alone == 1 and memory.jamming == 0 and memory.stopping == 0
    struck = memory.approach[0]
    at = 0
    lowest = 0.0
    coupled = False
    for k in range(n):
        v = row_velocity(work.rows.J, work.rows.body, work.rows.n_joint + k, work.rows.dof, u)
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
    memory.fastest = max(memory.fastest, -lowest)
    if memory.nudging == 0:
        if lowest >= -threshold:
            return RESOLVED
        if memory.stopping == 0:
            memory.gentlest = min(memory.gentlest, -lowest)
        memory.target = at
    return AGAIN


@kernel
def bring_forward(work: Workspace, memory: EventMemory, k: int) -> None:
    """Exchange entry k of the table with the first one."""
    if k > 0:
        copy_entry(work.rows.table, 0, memory.seen, 0)
        copy_entry(work.rows.table, k, work.rows.table, 0)
        copy_entry(memory.seen, 0, work.rows.table, k)
        memory.approach[0], memory.approach[k] = memory.approach[k], memory.approach[0]


@kernel
def begin(settings: EventSettings, work: Workspace, memory: EventMemory) -> None:
    """Begin an impact: of all closed contacts, or of one, which comes first in the table."""
    memory.round += 1
    memory.stage = STRIKING
    memory.jamming = memory.nudging
    memory.alone = 1 if settings.sequential or integrates(settings.law) else 0
    if memory.stopping == 1:
        memory.alone = 0
    if memory.alone == 1 and memory.round > CHAIN:
        memory.alone = 0
        if memory.round == CHAIN + 1:
            memory.cuts += 1
    if memory.alone == 1:
        bring_forward(work, memory, memory.target)
    memory.gained = 0.0


@kernel
def end(memory: EventMemory, recorder: Recorder) -> None:
    """End an impact."""
    memory.stage = LOOKING
    memory.nudging = 0
    if memory.stopping == 1:
        memory.stopping = 2
    else:
        memory.hits = 1
    note_gain(recorder, memory.time, memory.gained)


@kernel
def strike_alone(
    model: Model, settings: EventSettings, work: Workspace, memory: EventMemory, recorder: Recorder, u: FloatArray
) -> int:
    """Impact of the only contact laid, by a law that integrates it."""
    restitution = model.contacts.restitution[work.rows.table.law[0]]
    pose_island(work, 0, PLANAR)
    forget_islands(work.posed.islands)
    count = impact_phases(settings.law, work.posed.problem, restitution, memory.segments)
    if count < 0:
        return UNSOLVED
    total = work.rows.n_joint + 1 + work.rows.n_tangents
    for i in range(count):
        lay_impulse(work, memory.segments[i, 0], memory.segments[i, 1])
        apply_impulses(work.rows.solved, work.rows.body, 0, total, work.impulses.p, work.rows.dof, u)
        account(model, work, memory, recorder, u)
        for c in range(len(u)):
            memory.u[c] = u[c]
    return RESOLVED


@kernel
def without_restitution(memory: EventMemory) -> bool:
    """Whether approach or bounce are too small, or so many impacts were at this instant that they are to end."""
    most = CHAIN if memory.alone == 1 or memory.round > CHAIN else 2 * ROUNDS // 3
    return memory.round > most or memory.stopping == 1 or memory.low == 1


@kernel
def compressed(model: Model, settings: EventSettings, work: Workspace, memory: EventMemory) -> bool:
    """Whether contacts give back some of the impulses just laid: at least how much, to ``work.posed.least``."""
    if not gives_back(settings.law) or memory.stage == EXPANDING or without_restitution(memory):
        return False
    gives = False
    for k in range(work.rows.n_contacts):
        work.posed.least[k] = (
            model.contacts.restitution[work.rows.table.law[k]] * work.impulses.p[work.rows.n_joint + k]
        )
        gives = gives or work.posed.least[k] > 0.0
    return gives


@kernel
def lay_impact(model: Model, settings: EventSettings, work: Workspace, memory: EventMemory, u: FloatArray) -> None:
    """The problems of an impact of the contacts whose rows are laid."""
    threshold = math.inf if without_restitution(memory) else settings.velocity_threshold
    for i in range(len(u)):
        memory.u[i] = u[i]
        work.free.u[i] = u[i]
        memory.reflected[i] = u[i] if simple(memory) or reflects(settings.law) else 0.0
    pose(model, work, memory.reflected, 0.0, threshold)
    memory.number = 0.0


@kernel
def simple(memory: EventMemory) -> bool:
    """Whether the impact is one of velocities, none of them reflected."""
    return memory.round > CHAIN or memory.stopping == 1 or memory.low == 1


@in_space("lcpflex.steppers.spatial.strikes")
@kernel
def solve_strike(
    work: Workspace, sets: ContactSets, t: float, tolerance: float, warm: bool, last: bool, recorder: Recorder
) -> int:
    """The problems of an impact that are not solved yet; returns as :func:`solve_islands`."""
    return solve_islands(work, t, tolerance, warm, last, recorder)


@kernel
def collide(model: Model, settings: EventSettings, work: Workspace, memory: EventMemory, recorder: Recorder) -> int:
    """An impact; AGAIN, or RESOLVED: no closed contact approaches, those that leave are out of the table."""
    q = memory.y[: memory.nq]
    u = memory.y[memory.nq : memory.nq + len(memory.u)]
    looking = memory.stage == LOOKING
    n = memory.n_found
    if not looking and memory.alone == 1:
        n = 1
    if not unfinished(work.posed.islands):
        lay_rows(model, memory.time, q, u, n, work, memory.sets)
        if looking:
            limit = CHAIN + ROUNDS if settings.sequential or integrates(settings.law) else ROUNDS
            found = fastest_approach(settings, work, memory, u)
            if found == COUPLED:
                return COUPLED
            if found == RESOLVED or memory.round >= limit:
                keep_closed(settings, work, memory, u)
                return RESOLVED
            memory.low = 0
            if memory.nudging == 0 and too_low(model, settings, work, memory, memory.target):
                memory.low = 1
            begin(settings, work, memory)
            if memory.alone == 1:
                return AGAIN
        lay_impact(model, settings, work, memory, u)
        if integrates(settings.law) and not simple(memory):
            if strike_alone(model, settings, work, memory, recorder, u) != RESOLVED:
                return UNSOLVED
            end(memory, recorder)
            return AGAIN
        if memory.stage == EXPANDING:
            work.posed.shifted = 1
        elif memory.nudging == 1:
            for k in range(n):
                work.free.v[work.rows.n_joint + k] -= (
                    settings.velocity_threshold
                )  # an approach assumed where there is none
    warm = last = False
    if solve_strike(work, memory.sets, memory.time, settings.tolerance, warm, last, recorder) != RunStatus.DONE:
        memory.number = work.impulses.number
        return UNSOLVED
    answer_joints(work)
    add_impulses(work, u)
    account(model, work, memory, recorder, u)
    if compressed(model, settings, work, memory):
        memory.stage = EXPANDING
    else:
        end(memory, recorder)
    return AGAIN
