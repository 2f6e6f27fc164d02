"""The loop of an event-driven run: phases from step to step and through events, each entered again where it stopped.

A kernel that calls another contains it, compiled anew; so the loop calls what is large, and from one place.
"""

from __future__ import annotations

import math

from lcpflex.contact.rows import contact_point
from lcpflex.dynamics.acceleration import SMOOTH, STICKING, project, room_for
from lcpflex.dynamics.contact_forces import elastic_energy
from lcpflex.dynamics.contact_forces_history import update_history
from lcpflex.dynamics.delassus import row_velocity
from lcpflex.dynamics.joint_reactions import note_instant
from lcpflex.dynamics.workspace import Workspace
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.jit.leaf import in_space
from lcpflex.kinematics.configuration import normalise
from lcpflex.model.arrays import SLIP, STICK, Model
from lcpflex.steppers.event_driven.impacts import AGAIN, COUPLED, RESOLVED, UNSOLVED, collide
from lcpflex.steppers.event_driven.memory import (
    EVENT_CAPACITY,
    WINDOW,
    EventMemory,
    EventSettings,
    within,
)
from lcpflex.steppers.event_driven.segment import search, step, watch
from lcpflex.steppers.event_driven.sets import choose, fall_back, gather, note_changes
from lcpflex.steppers.event_driven.slope import slope
from lcpflex.steppers.rates import Rates, ask_all, ask_at, next_instant, stored_at
from lcpflex.steppers.recorded_contacts import note_compliant, note_contact
from lcpflex.steppers.recorder import Recorder, is_penetration, store_contacts, store_state
from lcpflex.steppers.runge_kutta import copy_state, interpolate
from lcpflex.steppers.status import RunStatus

__all__ = ["CHOOSING", "COLLIDING", "STEPPING", "advance", "record"]


# where it is, memory.phase
BEFORE, GATHERING, COLLIDING, CHOOSING, TRYING, SETTLING, AFTER, STEPPING, EMITTING, CLOSING_STEP = range(10)

SAME_TIME = 1e-13  # relative: events so close count as one instant
MOST_EVENTS = 200  # at one instant


@in_space("lcpflex.steppers.spatial.sliding")
@kernel
def note_forces(
    model: Model,
    settings: EventSettings,
    q: FloatArray,
    u: FloatArray,
    work: Workspace,
    memory: EventMemory,
    recorder: Recorder,
) -> None:
    """Add the touching points with the forces ``work.impulses.p`` to the instant about to be stored."""
    n = work.rows.n_contacts
    for k in range(n):
        r = work.rows.n_joint + k
        force_t = 0.0
        state = STICK if memory.sets.mode[k] == STICKING else SLIP
        if memory.sets.mode[k] != SMOOTH:
            tangent = work.rows.n_joint + n + memory.sets.tangent_of[k]
            force_t = work.impulses.p[tangent]
            slip = row_velocity(work.rows.J, work.rows.body, tangent, work.rows.dof, u)
            if abs(slip) <= settings.slip_threshold:
                state = STICK
        place = contact_point(model, q, work.rows.table, k)
        note_contact(
            recorder, work.rows.table.law[k], place, work.rows.table.normal[k], work.impulses.p[r], force_t, state
        )


@kernel
def record(
    model: Model,
    settings: EventSettings,
    t: float,
    y: FloatArray,
    work: Workspace,
    memory: EventMemory,
    recorder: Recorder,
) -> int:
    """Store the state y of time t with its contact forces; returns DONE, or why there is no room."""
    base = memory.nq + len(memory.u)
    q = y[: memory.nq]
    u = y[memory.nq : base]
    slope(model, t, y, work, memory, memory.slope)
    n = memory.n_contacts
    points = n + work.compliant.rows.n_contacts
    if recorder.n_instants >= len(recorder.times) or (
        recorder.n_points + points > len(recorder.points) and recorder.n_points > 0
    ):
        return RunStatus.TAPE_FULL
    needed = store_contacts(model, q, recorder)
    if needed > len(recorder.table.key) or points > len(recorder.points):
        memory.number = max(needed, points)
        return RunStatus.GROW_TAPE
    recorder.counts.lost_friction = y[base]
    by_law = y[len(y) - 1]
    recorder.counts.lost_damping = y[base + 1] - by_law
    recorder.counts.supplied = y[base + 2]
    recorder.counts.lost_impacts += by_law - recorder.counts.lost_by_law
    recorder.counts.lost_by_law = by_law
    row = recorder.n_instants
    sums = recorder.total_impulse.shape[1]
    for law in range(len(recorder.total_impulse)):
        for i in range(sums):
            recorder.total_impulse[law, i] = y[base + 3 + sums * law + i]
        if recorder.gap[row, law] < 0.0 and is_penetration(recorder, law):
            recorder.counts.worst_penetration = max(recorder.counts.worst_penetration, -recorder.gap[row, law])
    note_forces(model, settings, q, u, work, memory, recorder)
    if work.compliant.rows.n_contacts > 0:
        note_compliant(model, q, work.compliant, False, recorder)
    if work.rows.n_joint > 0:
        note_instant(model, work, recorder.rates.now, recorder.reactions)
    store_state(model, t, q, u, work, elastic_energy(model, work.compliant), recorder)
    return RunStatus.DONE


@kernel
def due(model: Model, settings: EventSettings, memory: EventMemory, rates: Rates) -> float:
    """Time of the next instant to be stored in this step [s], its state in ``memory.at``; negative if none is left."""
    end = memory.time + memory.share * memory.step_taken
    own = next_instant(rates, 0, settings.interval, memory.stored, memory.steps, end, settings.duration)
    if middle_due(settings, memory) and rates.done[0] <= memory.steps:
        own = memory.time + 0.5 * memory.share * memory.step_taken
    t = ask_at(rates, own, memory.steps, end, settings.duration)
    if t > end + 1e-12 * settings.duration:
        return -1.0
    share = min((t - memory.time) / memory.step_taken, memory.share)
    within(model, memory, share, memory.at)
    return min(t, end)


@kernel
def middle_due(settings: EventSettings, memory: EventMemory) -> bool:
    """Whether the next instant is the middle of the step: all are kept, and those at the ends of steps are even."""
    return settings.interval < 0.0 and memory.stored > 0 and memory.stored % 2 == 1


@kernel
def count_instant(settings: EventSettings, memory: EventMemory, t: float, rates: Rates) -> None:
    """Go on to the next instant of each rate."""
    last = stored_at(rates, t, memory.steps, settings.duration)
    if rates.now[0] == 0:
        return
    if middle_due(settings, memory):
        memory.stored += 1
        rates.done[0] = memory.steps  # its end is yet to come
    else:
        memory.stored = -1 if last else memory.stored + 1


@kernel
def close_step(model: Model, settings: EventSettings, memory: EventMemory) -> None:
    """Go to the end of the step or to the event in it."""
    if memory.share < 1.0:
        interpolate(memory.y, memory.slopes, memory.step_taken, memory.share, memory.at)
        copy_state(memory.at, memory.y)
    else:
        copy_state(memory.end, memory.y)
    normalise(model, memory.y[: memory.nq])
    memory.time += memory.share * memory.step_taken
    if memory.time > settings.duration * (1.0 - 1e-14):
        memory.time = settings.duration
    memory.steps += 1
    if memory.cause >= 0:
        again = memory.time - memory.last_event <= SAME_TIME * settings.duration
        memory.stuck = memory.stuck + 1 if again else 0
        memory.last_event = memory.time
        place = memory.located % WINDOW
        if memory.located >= WINDOW and memory.time - memory.recent[place] < settings.least_window:
            memory.too_many = 1
        memory.recent[place] = memory.time
        memory.located += 1


@in_space("lcpflex.steppers.spatial.sliding")
@kernel
def count_impulses(work: Workspace, memory: EventMemory) -> None:
    """Add the impulses of a projection of velocities: what drift, and approach below the threshold, have cost."""
    first = work.rows.n_joint
    n = work.rows.n_contacts
    base = memory.nq + len(memory.u) + 3
    for k in range(memory.n_contacts):
        law = base + 2 * work.rows.table.law[k]
        memory.y[law] += work.impulses.p[first + k]
        if memory.sets.tangent_of[k] >= 0:
            memory.y[law + 1] += work.impulses.p[first + n + memory.sets.tangent_of[k]]


@kernel
def next_phase(memory: EventMemory) -> int:
    """Where a projection leads: from the end of a step on, or from gathering and choosing."""
    phase = memory.phase
    if phase == CLOSING_STEP:  # forces jump at every event, velocities at impacts: both sides are stored
        return STEPPING if memory.cause < 0 else BEFORE
    return COLLIDING if phase == GATHERING else AFTER


@kernel
def finite(memory: EventMemory) -> bool:
    """Whether the state is."""
    total = 0.0
    for i in range(memory.nq + len(memory.u)):
        total += abs(memory.y[i])
    return math.isfinite(total)


@kernel
def advance(
    model: Model, settings: EventSettings, work: Workspace, memory: EventMemory, recorder: Recorder, last_step: int
) -> int:
    """Steps until their number is ``last_step`` or the duration is reached.

    DONE, PAUSE after a while, or what is missing. Calling again goes on.
    """
    beats = recorder.beats[0]
    q = memory.y[: memory.nq]
    u = memory.y[memory.nq : memory.nq + len(memory.u)]
    while True:
        phase = memory.phase
        ended = phase == STEPPING and memory.time >= settings.duration
        between = phase in (STEPPING, BEFORE, AFTER)
        if ended or (between and memory.steps >= last_step):
            return RunStatus.DONE
        if between and recorder.beats[0] != beats:
            return RunStatus.PAUSE
        if phase in (BEFORE, AFTER, EMITTING):
            t = memory.time
            if phase == EMITTING:
                t = due(model, settings, memory, recorder.rates)
            else:
                ask_all(recorder.rates)
                copy_state(memory.y, memory.at)
            if t >= 0.0:
                status = record(model, settings, t, memory.at, work, memory, recorder)
                if status != RunStatus.DONE:
                    return status
                if phase == EMITTING:
                    count_instant(settings, memory, t, recorder.rates)
            if phase == BEFORE:
                memory.phase = GATHERING
            elif phase == AFTER:
                memory.phase = STEPPING
                memory.stored = 1 if memory.stored == 0 else memory.stored
                for r in range(len(recorder.rates.count)):
                    recorder.rates.count[r] = 1 if recorder.rates.count[r] == 0 else recorder.rates.count[r]
            elif t < 0.0:
                memory.phase = CLOSING_STEP
        elif phase in (STEPPING, TRYING):
            slope(model, memory.time, memory.y, work, memory, memory.slopes[0])
            watch(model, work, memory, memory.y)
            if phase == TRYING:
                fall_back(memory)
                memory.phase = SETTLING
                continue
            if not step(model, settings, work, memory):
                return RunStatus.STEP_TOO_SHORT
            if not search(model, settings, work, memory):
                return RunStatus.GROW
            memory.phase = EMITTING
        elif phase == COLLIDING:
            outcome = collide(model, settings, work, memory, recorder)
            if outcome == RESOLVED:
                memory.phase = CHOOSING
            elif outcome == COUPLED:
                return RunStatus.HIT_TOGETHER
            elif outcome != AGAIN:
                return RunStatus.SOLVER_FAILED
        elif phase == CHOOSING:
            outcome = choose(model, settings, work, memory, recorder)
            if outcome == UNSOLVED:
                return RunStatus.SOLVER_FAILED
            memory.phase = TRYING if outcome == RESOLVED else COLLIDING
        else:  # GATHERING, SETTLING, CLOSING_STEP: all end in a projection
            n = memory.n_contacts
            if phase == CLOSING_STEP:
                close_step(model, settings, memory)
            elif phase == SETTLING:
                note_changes(work, memory)
                if memory.stored == 0 and memory.hits == 0:  # the state before was no other
                    recorder.n_instants = 0
                    recorder.n_points = 0
            else:
                if memory.n_events >= EVENT_CAPACITY:
                    return RunStatus.EVENTS_FULL
                if memory.time >= settings.calm:
                    return RunStatus.CALM
                if memory.stuck > MOST_EVENTS:
                    return RunStatus.CHATTER
                if memory.too_many == 1:
                    return RunStatus.TOO_OFTEN
                if not gather(model, settings, work, memory):
                    return RunStatus.GROW
                n = memory.n_found
            if not room_for(model, memory.time, q, u, n, work, memory.sets):
                memory.number = 0.0
                return RunStatus.GROW
            joint_drift, gap_drift = project(model, memory.time, q, u, n, phase != GATHERING, work, memory.sets)
            if phase != GATHERING:
                count_impulses(work, memory)
            if phase == CLOSING_STEP:
                recorder.counts.worst_penetration = max(recorder.counts.worst_penetration, gap_drift)
                recorder.counts.worst_drift = max(recorder.counts.worst_drift, joint_drift)
                if not update_history(model, memory.time, q, u, 0.0, False, work.compliant.states, work):
                    return RunStatus.OUT_OF_RANGE
            memory.phase = next_phase(memory)
            if not finite(memory):
                return RunStatus.NOT_FINITE
