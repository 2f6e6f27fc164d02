"""Explicit steps under continuous contact forces: Runge-Kutta 5(4) with error control, and Verlet's of fixed length."""

from __future__ import annotations

import math
from typing import NamedTuple

from lcpflex.dynamics.acceleration import project
from lcpflex.dynamics.contact_forces import mobility, pair_place, states_of_friction
from lcpflex.dynamics.contact_forces_history import note_depths, onset, roundings, update_history
from lcpflex.dynamics.instants import longest_look, time_left
from lcpflex.dynamics.touches import note_touches
from lcpflex.dynamics.workspace import Workspace
from lcpflex.force_laws.friction.kernels import bristle_rates, friction_force
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.jit.leaf import in_space
from lcpflex.kinematics.configuration import advance as advance_by, normalise
from lcpflex.model.arrays import Model
from lcpflex.steppers.passing import may_pass, set_out
from lcpflex.steppers.rates import Rates, ask_at, ask_step, next_instant, stored_at
from lcpflex.steppers.recorder import Recorder
from lcpflex.steppers.runge_kutta import (
    STAGES,
    C,
    E,
    copy_state,
    error_norm,
    interpolate,
    stage_state,
    step_factor,
)
from lcpflex.steppers.short_steps import ALL_OF_IT, onset_share
from lcpflex.steppers.smooth.memory import IMPULSES, SmoothMemory
from lcpflex.steppers.smooth.slope import (
    add_powers,
    horizon,
    natural_frequency,
    record,
    slope,
)
from lcpflex.steppers.status import RunStatus

__all__ = [
    "SmoothSettings",
    "advance",
    "advance_fixed",
    "close_step",
    "step",
    "step_fixed",
    "renew_history",
]

BEFORE, STARTING, STEPPING, EMITTING, CLOSING, NOTING, ENDING = range(7)  # memory.phase
SAME = 1e-12  # of the duration: instants nearer than that are one
NONE_OF_IT = 1e-6  # and below: a repeated step might fall short by its rounding, and the next one likewise
STALL, MOST_STALLS = 1e-13, 100  # of the time, of a step of no length; how many may follow each other
SMALL = 1e-5  # share of a state of friction by which it is moved for a difference


class SmoothSettings(NamedTuple):
    """Numbers of the scheme, as the compiled loops take them."""

    duration: float
    interval: float
    rtol: float
    atol: FloatArray  # (nq + ndof,)
    state_atol: float  # of states of friction
    max_step: float
    margin: float  # pairs farther apart are not looked at [m]
    stride: int  # steps of fixed length between stored instants


@kernel
def bristle_error(settings: SmoothSettings, h: float, memory: SmoothMemory) -> float:
    """Largest error / (atol + rtol |y|) of the states of friction in a step of h [s]: most are of contacts at rest."""
    largest = 0.0
    for i in range(memory.states, len(memory.y)):
        error = 0.0
        for j in range(STAGES):
            error += E[j] * memory.slopes[j, i]
        scale = settings.state_atol + settings.rtol * max(abs(memory.y[i]), abs(memory.end[i]))
        largest = max(largest, abs(h * error) / scale)
    return largest


@kernel
def step(model: Model, settings: SmoothSettings, work: Workspace, memory: SmoothMemory) -> int:
    """One accepted Runge-Kutta step from y to end; its length in memory.step_taken. DONE, GROW or STEP_TOO_SHORT."""
    t = memory.time
    rest = time_left(model.signals, t, settings.duration)
    nq = memory.nq
    n = nq + len(work.free.u)
    h = memory.step
    rejected = False
    shortened = False
    longest = min(settings.max_step, longest_look(model.signals))
    stage = 0
    while True:
        if stage == 0:
            copy_state(memory.y, memory.end)
        else:
            stage_state(memory.y, memory.slopes, h, stage, memory.end)
        if not slope(model, t + C[stage] * h, memory.end, work, memory, memory.slopes[stage]):
            return RunStatus.GROW
        stage += 1
        if stage == 1:
            limit = horizon(model, memory.y, memory.slopes[0], settings.margin, work, memory)
            if work.compliant.needed > 0:
                return RunStatus.GROW
            longest = min(longest, limit)
            if not h > 0.0:
                h = error_norm(memory.y, memory.y, memory.slopes, 1.0, n, settings.rtol, settings.atol)
                h = 0.01 * settings.duration if h < 1e-3 else min(0.01 * settings.duration, 0.1 / h)
            h = min(h, longest)
            if h > 0.99 * rest:
                h = rest
        elif stage == STAGES:
            error = error_norm(memory.y, memory.end, memory.slopes, h, n, settings.rtol, settings.atol)
            if error < math.inf:  # and not less than no number
                error = max(error, bristle_error(settings, h, memory))
            if error <= 1.0:
                factor = step_factor(error, memory.error)
                if rejected:
                    factor = min(factor, 1.0)
                share = 1.0
                if len(work.compliant.history.feature) > 0 and onset(model, work.compliant):
                    share = onset_share(model, nq, memory.y, memory.slopes, h, memory.at, work.compliant)
                if work.compliant.needed > 0:
                    return RunStatus.GROW
                if NONE_OF_IT < share < ALL_OF_IT and not shortened:  # its stages would mix what is before and behind
                    shortened = True
                    memory.step = h
                    h *= share
                    stage = 1
                    continue
                if share < 1.0:
                    interpolate(memory.y, memory.slopes, h, share, memory.at)
                    copy_state(memory.at, memory.end)
                if not shortened:
                    memory.step = max(memory.step, h) if h == rest else h * factor
                memory.error = error
                memory.length = h
                memory.step_taken = share * h
                stalled = memory.step_taken < STALL * max(t, 1e-3 * settings.duration)
                memory.stalled = memory.stalled + 1 if stalled else 0
                return RunStatus.STEP_TOO_SHORT if memory.stalled > MOST_STALLS else RunStatus.DONE
            rejected = True
            h *= max(0.1, 0.9 * error**-0.2) if error < math.inf else 0.1
            if h < 1e-14 * max(t, 1e-3 * settings.duration):
                return RunStatus.STEP_TOO_SHORT
            stage = 1


@kernel
def due(model: Model, settings: SmoothSettings, memory: SmoothMemory, rates: Rates) -> float:
    """Time of the next instant to be stored [s], its state in ``memory.at``; negative if none is left.

    Of those within a step, or of the one at its end: that is stored once contacts have taken note of it, or a contact
    that begins there with an indentation would show a force without its impact speed.
    """
    ending = memory.phase != EMITTING
    end = memory.time if ending else memory.time + memory.step_taken
    own = next_instant(rates, 0, settings.interval, memory.stored, memory.steps, end, settings.duration)
    t = ask_at(rates, own, memory.steps, end, settings.duration)
    if t > end + SAME * settings.duration:
        return -1.0
    if ending:
        copy_state(memory.y, memory.at)
        return min(t, end)
    if t >= end - SAME * settings.duration:
        return -1.0
    interpolate(memory.y, memory.slopes, memory.length, (t - memory.time) / memory.length, memory.at)
    normalise(model, memory.at[: memory.nq])
    return t


@kernel
def close_step(
    model: Model, settings: SmoothSettings, work: Workspace, memory: SmoothMemory, recorder: Recorder
) -> int:
    """Go to the end of the step, with joints put right there; DONE or NOT_FINITE."""
    nq, base = memory.nq, memory.nq + len(work.free.u)
    copy_state(memory.end, memory.y)
    normalise(model, memory.y[:nq])
    memory.time += memory.step_taken
    if memory.time > settings.duration * (1.0 - 1e-14):
        memory.time = settings.duration
    memory.steps += 1
    note_depths(work.compliant)
    if len(work.scratch.residual) > 0:
        q = memory.y[:nq]
        u = memory.y[nq:base]
        drift = project(model, memory.time, q, u, 0, True, work, memory.sets)
        recorder.counts.worst_drift = max(recorder.counts.worst_drift, drift[0])
    total = 0.0
    for i in range(base):
        total += abs(memory.y[i])
    return RunStatus.DONE if math.isfinite(total) else RunStatus.NOT_FINITE


@kernel
def renew_history(model: Model, work: Workspace, memory: SmoothMemory) -> int:
    """Renew the history of contacts in the state y, where a law asks for it; DONE, GROW or OUT_OF_RANGE."""
    contacts = work.compliant
    if contacts.history.watched[0] == 0:
        return RunStatus.DONE
    nq = memory.nq
    q = memory.y[:nq]
    u = memory.y[nq : nq + len(work.free.u)]
    states = memory.y[memory.states :].reshape(-1, states_of_friction(model))
    if update_history(model, memory.time, q, u, roundings(u), False, states, work):
        return RunStatus.DONE
    return RunStatus.GROW if contacts.needed > 0 else RunStatus.OUT_OF_RANGE


@kernel
def advance(
    model: Model, settings: SmoothSettings, work: Workspace, memory: SmoothMemory, recorder: Recorder, last_step: int
) -> int:
    """Runge-Kutta steps until their number is ``last_step`` or the duration is reached.

    DONE, PAUSE after a while, or what is missing.
    """
    beats = recorder.beats[0]
    while True:
        phase = memory.phase
        status: int = RunStatus.DONE
        if phase == STEPPING:
            if memory.time >= settings.duration or memory.steps >= last_step:
                return RunStatus.DONE
            if recorder.beats[0] != beats:
                return RunStatus.PAUSE
            status = step(model, settings, work, memory)
            memory.phase = EMITTING if status == RunStatus.DONE else STEPPING
        elif phase == CLOSING:
            status = close_step(model, settings, work, memory, recorder)
            memory.phase = NOTING
        elif phase in (NOTING, BEFORE):
            status = renew_history(model, work, memory)
            if status == RunStatus.DONE:
                memory.phase = ENDING if phase == NOTING else STARTING
        else:
            t = due(model, settings, memory, recorder.rates)
            if t >= 0.0:
                status = record(model, t, memory.at, work, memory, recorder)
                if status == RunStatus.DONE:
                    last = stored_at(recorder.rates, t, memory.steps, settings.duration)
                    if recorder.rates.now[0] == 1:
                        memory.stored = -1 if last else memory.stored + 1
            if status == RunStatus.DONE and phase == EMITTING:
                memory.phase = EMITTING if t >= 0.0 else CLOSING
            elif status == RunStatus.DONE and (t < 0.0 or phase == STARTING):
                memory.phase = STEPPING
        if status != RunStatus.DONE:
            return status


@in_space("lcpflex.steppers.spatial.kick")
@kernel
def relax(model: Model, h: float, work: Workspace, memory: SmoothMemory) -> float:
    """Let the states of friction go on by h [s], by linearly implicit steps: they relax in a far shorter time.

    After ``natural_frequency`` of the middle of the step. Returns the highest sqrt(|dF/dz| G_tt) [rad/s].
    """
    contacts = work.compliant
    history = contacts.history
    first = contacts.rows.n_joint + contacts.rows.n_contacts
    highest = 0.0
    for j in range(contacts.rows.n_tangents):
        k = contacts.rows.tangent[j]
        place = pair_place(model, history, contacts.rows.table, k)
        normal = contacts.p[k, 0]
        if place < 0 or not normal > 0.0:
            continue
        slip = contacts.slip[k]
        law = contacts.rows.table.law[k]
        kinds = history.kinds[law]
        p = history.parameters[law]
        at = memory.states + 2 * place
        z = memory.end[at]
        w = memory.end[at + 1]
        for i in range(2):
            rate = memory.slope[at + i]
            move = SMALL * (abs(memory.end[at + i]) + h * abs(rate))
            if move > 0.0:
                moved = (z + move, w) if i == 0 else (z, w + move)
                rates = bristle_rates(kinds, p, slip, normal, contacts.rows.mu[k], moved[0], moved[1])
                slope_of_rate = ((rates[0] if i == 0 else rates[1]) - rate) / move
                memory.end[at + i] += h * rate / (1.0 - h * min(slope_of_rate, 0.0))
                if i == 0:
                    change = friction_force(kinds, p, slip, normal, contacts.rows.mu[k], moved[0], w) - contacts.p[k, 1]
                    highest = max(highest, abs(change) / move * mobility(contacts, first + j))
    return math.sqrt(highest)


@in_space("lcpflex.steppers.spatial.kick")
@kernel
def kick_again(model: Model, h: float, work: Workspace, memory: SmoothMemory) -> None:
    """Make the kick anew with the mean of the velocities before and behind it: in the plane, nothing.

    In space omega x J omega, taken at the velocity before it alone, gains energy, and is of order 1.
    """


@kernel
def step_fixed(model: Model, settings: SmoothSettings, work: Workspace, memory: SmoothMemory) -> int:
    """One step of Verlet's method from y to end: drift, kick, drift. DONE or GROW."""
    nq, base = memory.nq, memory.nq + len(work.free.u)
    rest = settings.duration - memory.time
    h = rest if rest < (1.0 + 1e-9) * settings.max_step else settings.max_step
    copy_state(memory.y, memory.end)
    advance_by(model, memory.y[:nq], memory.y[nq:base], 0.5 * h, memory.end)
    if not slope(model, memory.time + 0.5 * h, memory.end, work, memory, memory.slope):
        return RunStatus.GROW
    note_touches(work.compliant, h)
    memory.frequency = max(memory.frequency, natural_frequency(model, work, memory))
    if memory.states < len(memory.end):
        memory.frequency = max(memory.frequency, relax(model, h, work, memory))
    for i in range(base, base + IMPULSES):  # at the mean velocity, below
        memory.slope[i] = 0.0
    for i in range(nq, memory.states):
        memory.end[i] += h * memory.slope[i]
    kick_again(model, h, work, memory)
    advance_by(model, memory.end[:nq], memory.end[nq:base], 0.5 * h, memory.end)
    for i in range(nq, base):
        memory.at[i] = 0.5 * (memory.y[i] + memory.end[i])
    add_powers(work, memory.at[nq:base], base, memory.slope)  # one step may hold all of a load
    for i in range(base, base + IMPULSES):
        memory.end[i] += h * memory.slope[i]
    memory.step_taken = h
    return RunStatus.DONE


@kernel
def advance_fixed(
    model: Model, settings: SmoothSettings, work: Workspace, memory: SmoothMemory, recorder: Recorder, last_step: int
) -> int:
    """Steps of Verlet's method until their number is ``last_step`` or the duration is reached; returns as ``advance``.

    Stores the start, each ``stride``-th step and the end.
    """
    beats = recorder.beats[0]
    while True:
        if memory.phase != STEPPING:
            status = renew_history(model, work, memory)
            if status != RunStatus.DONE:
                return status
            memory.phase = STEPPING
        ended = memory.time >= settings.duration
        last = memory.steps if ended else -1
        if memory.stored != memory.steps + 1 and ask_step(recorder.rates, settings.stride, memory.steps, last):
            status = record(model, memory.time, memory.y, work, memory, recorder)
            if status != RunStatus.DONE:
                return status
            memory.stored = memory.steps + 1
        if ended or memory.steps >= last_step:
            return RunStatus.DONE
        if recorder.beats[0] != beats:
            return RunStatus.PAUSE
        set_out(memory.y[: memory.nq], recorder)
        status = step_fixed(model, settings, work, memory)
        if status == RunStatus.DONE:
            status = close_step(model, settings, work, memory, recorder)
            memory.phase = NOTING
            if status == RunStatus.DONE and may_pass(model, memory.y[: memory.nq], recorder):
                return RunStatus.PASSED
        if status != RunStatus.DONE:
            return status
