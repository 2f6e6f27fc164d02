"""Explicit steps under continuous contact forces: Runge-Kutta 5(4) with error control, and Verlet's of fixed length."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from lcpflex.compiled import kernel
from lcpflex.dynamics.acceleration import project
from lcpflex.dynamics.workspace import Workspace
from lcpflex.model import Model
from lcpflex.steppers.runge_kutta import STAGES, C, copy_state, error_norm, interpolate, stage_state, step_factor
from lcpflex.steppers.smooth_slope import (
    DETAIL,
    DONE,
    ERROR,
    FREQUENCY,
    GROW,
    NOT_FINITE,
    PHASE,
    STEP,
    STEP_TOO_SHORT,
    STEPS,
    STORED,
    TAKEN,
    TIME,
    SmoothMemory,
    horizon,
    natural_frequency,
    record,
    slope,
)
from lcpflex.steppers.tape import Tape

__all__ = ["SmoothSettings", "advance", "advance_fixed", "close_step", "step", "step_fixed"]

STARTING, STEPPING, EMITTING, CLOSING = range(4)  # number[PHASE]


class SmoothSettings(NamedTuple):
    """Numbers of the scheme, as the compiled loops take them."""

    duration: float
    interval: float
    rtol: float
    atol: float
    max_step: float
    margin: float  # pairs farther apart are not looked at [m]
    stride: int  # steps of fixed length between stored instants


@kernel
def step(model: Model, settings: SmoothSettings, work: Workspace, memory: SmoothMemory) -> int:
    """One accepted Runge-Kutta step from y to end; its length in clock[TAKEN]. DONE, GROW or STEP_TOO_SHORT."""
    clock = memory.clock
    t = clock[TIME]
    rest = settings.duration - t
    n = 2 * len(work.free_u)
    h = clock[STEP]
    rejected = False
    longest = settings.max_step
    stage = 0
    while True:
        if stage == 0:
            copy_state(memory.y, memory.end)
        else:
            stage_state(memory.y, memory.slopes, h, stage, memory.end)
        found = slope(model, t + C[stage] * h, memory.end, work, memory, memory.slopes[stage])
        if found > len(work.table.key):
            clock[DETAIL] = found
            return GROW
        stage += 1
        if stage == 1:
            limit = horizon(model, memory.y, memory.slopes[0], settings.margin, work, memory)
            if limit < 0.0:
                clock[DETAIL] = -limit
                return GROW
            longest = min(longest, limit)
            if not h > 0.0:
                h = error_norm(memory.y, memory.y, memory.slopes, 1.0, n, settings.rtol, settings.atol)
                h = 0.01 * settings.duration if h < 1e-3 else min(0.01 * settings.duration, 0.1 / h)
            h = min(h, longest)
            if h > 0.99 * rest:
                h = rest
        elif stage == STAGES:
            error = error_norm(memory.y, memory.end, memory.slopes, h, n, settings.rtol, settings.atol)
            if error <= 1.0:
                factor = step_factor(error, clock[ERROR])
                if rejected:
                    factor = min(factor, 1.0)
                clock[STEP] = max(clock[STEP], h) if h == rest else h * factor
                clock[ERROR] = error
                clock[TAKEN] = h
                return DONE
            rejected = True
            h *= max(0.1, 0.9 * error**-0.2) if error < math.inf else 0.1
            if h < 1e-14 * max(t, 1e-3 * settings.duration):
                return STEP_TOO_SHORT
            stage = 1


@kernel
def due(settings: SmoothSettings, memory: SmoothMemory) -> float:
    """Time of the next instant to be stored in this step [s], its state in ``memory.at``; negative if none is left."""
    clock = memory.clock
    end = clock[TIME] + clock[TAKEN]
    stored = memory.number[STORED]
    t = min(stored * settings.interval, settings.duration) if settings.interval > 0.0 else end
    if stored < 0 or t > end + 1e-12 * settings.duration:
        return -1.0
    interpolate(memory.y, memory.slopes, clock[TAKEN], min((t - clock[TIME]) / clock[TAKEN], 1.0), memory.at)
    return min(t, end)


@kernel
def close_step(model: Model, settings: SmoothSettings, work: Workspace, memory: SmoothMemory, tape: Tape) -> int:
    """Go to the end of the step, with joints put right there; DONE or NOT_FINITE."""
    clock = memory.clock
    ndof = len(work.free_u)
    copy_state(memory.end, memory.y)
    clock[TIME] += clock[TAKEN]
    if clock[TIME] > settings.duration * (1.0 - 1e-14):
        clock[TIME] = settings.duration
    memory.number[STEPS] += 1
    if len(work.residual) > 0:
        q = memory.y[:ndof]
        u = memory.y[ndof : 2 * ndof]
        none = int(np.int64(0))  # a literal would have the kernel compiled once more
        drift = project(model, clock[TIME], q, u, none, True, work, memory.sets)
        tape.worst[2] = max(tape.worst[2], drift[0])
    total = 0.0
    for i in range(2 * ndof):
        total += abs(memory.y[i])
    return DONE if math.isfinite(total) else NOT_FINITE


@kernel
def advance(
    model: Model, settings: SmoothSettings, work: Workspace, memory: SmoothMemory, tape: Tape, last_step: int
) -> int:
    """Runge-Kutta steps until their number is ``last_step`` or the duration is reached; DONE, or what is missing."""
    number = memory.number
    clock = memory.clock
    while True:
        phase = number[PHASE]
        status = DONE
        if phase == STEPPING:
            if clock[TIME] >= settings.duration or number[STEPS] >= last_step:
                return DONE
            status = step(model, settings, work, memory)
            number[PHASE] = EMITTING if status == DONE else STEPPING
        elif phase == CLOSING:
            status = close_step(model, settings, work, memory, tape)
            number[PHASE] = STEPPING
        else:
            t = 0.0
            if phase == STARTING:
                copy_state(memory.y, memory.at)
            else:
                t = due(settings, memory)
            if t >= 0.0:
                status = record(model, t, memory.at, work, memory, tape)
                if status == DONE:
                    number[STORED] += 1
                    if t >= settings.duration * (1.0 - 1e-12):
                        number[STORED] = -1
            if status == DONE:
                if phase == STARTING:
                    number[PHASE] = STEPPING
                elif t < 0.0 or settings.interval <= 0.0 or number[STORED] < 0:
                    number[PHASE] = CLOSING
        if status != DONE:
            return status


@kernel
def step_fixed(model: Model, settings: SmoothSettings, work: Workspace, memory: SmoothMemory) -> int:
    """One step of Verlet's method from y to end: drift, kick, drift. DONE or GROW."""
    clock = memory.clock
    ndof = len(work.free_u)
    rest = settings.duration - clock[TIME]
    h = rest if rest < (1.0 + 1e-9) * settings.max_step else settings.max_step
    copy_state(memory.y, memory.end)
    for i in range(ndof):
        memory.end[i] += 0.5 * h * memory.y[ndof + i]
    found = slope(model, clock[TIME] + 0.5 * h, memory.end, work, memory, memory.slope)
    if found > len(work.table.key):
        clock[DETAIL] = found
        return GROW
    clock[FREQUENCY] = max(clock[FREQUENCY], natural_frequency(model, work, memory))
    for i in range(ndof, len(memory.end)):
        memory.end[i] += h * memory.slope[i]
    for i in range(ndof):
        memory.end[i] += 0.5 * h * memory.end[ndof + i]
    clock[TAKEN] = h
    return DONE


@kernel
def advance_fixed(
    model: Model, settings: SmoothSettings, work: Workspace, memory: SmoothMemory, tape: Tape, last_step: int
) -> int:
    """Steps of Verlet's method until their number is ``last_step`` or the duration is reached; returns as ``advance``.

    Stores the start, each ``stride``-th step and the end.
    """
    number = memory.number
    clock = memory.clock
    while True:
        ended = clock[TIME] >= settings.duration
        if number[STORED] != number[STEPS] + 1 and (ended or number[STEPS] % settings.stride == 0):
            status = record(model, clock[TIME], memory.y, work, memory, tape)
            if status != DONE:
                return status
            number[STORED] = number[STEPS] + 1
        number[PHASE] = STEPPING
        if ended or number[STEPS] >= last_step:
            return DONE
        status = step_fixed(model, settings, work, memory)
        if status == DONE:
            status = close_step(model, settings, work, memory, tape)
        if status != DONE:
            return status
