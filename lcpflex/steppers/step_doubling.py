"""Error control of any time-stepping scheme by doubling: one step of length h against two of h/2.

See :mod:`lcpflex.steppers.adaptive` for the rules. A step is made in parts: the whole, then from the same state its
halves; or, where it is as short as steps may be, alone and without control.
"""

from __future__ import annotations

import copy
import math
from typing import Any

from lcpflex.dynamics.workspace import Workspace
from lcpflex.jit.kernel import kernel
from lcpflex.jit.struct import allocate, copy_parts
from lcpflex.model.arrays import Model
from lcpflex.steppers.adaptive import (
    Limits,
    accept,
    after_rejection,
    doubling_error,
    end_there,
    least_interval,
    next_length,
    position_tolerance,
    threshold,
)
from lcpflex.steppers.backup import Backup, backup, keep_end, restore, save
from lcpflex.steppers.clock import ALONE, FRESH, LONG, SECOND, StepClock
from lcpflex.steppers.pace import Pace, stopped_note
from lcpflex.steppers.rates import ask_time, went_on
from lcpflex.steppers.recorder import Recorder, has_room
from lcpflex.steppers.scheme import (
    NO_FACTOR,
    begin_part,
    begin_trial,
    end_step,
    go_on,
    judge,
    record,
    set_length,
    take_step,
    unmet_share,
)
from lcpflex.steppers.status import RunStatus
from lcpflex.steppers.time_stepping import TimeStepping
from lcpflex.steppers.unmet import first_unmet

__all__ = ["StepDoubling", "advance"]


@kernel
def store_due(model: Model, limits: Limits, clock: StepClock, scheme: Any, work: Workspace, recorder: Recorder) -> int:
    """Store the present instant where that is due; DONE, or why it could not be."""
    ended = clock.time >= limits.duration
    if ask_time(recorder.rates, clock.due, clock.time, ended):
        if not has_room(work, recorder):
            return RunStatus.TAPE_FULL
        clock.number = record(model, scheme, clock.time, work, recorder)
        if clock.number == NO_FACTOR:
            return RunStatus.GROW_FACTOR
        if clock.number > len(recorder.table.key):
            return RunStatus.GROW_TAPE
        if recorder.rates.now[0] == 1:
            clock.due = math.inf if ended else clock.time + limits.interval
        went_on(recorder.rates, clock.time, ended)
    return RunStatus.DONE


@kernel
def begin(
    model: Model, limits: Limits, clock: StepClock, scheme: Any, kept: Backup, work: Workspace, recorder: Recorder
) -> None:
    """Choose the length of the next step and keep the state it starts from."""
    clock.tried = next_length(model, limits, clock)
    clock.part = ALONE if clock.tried <= limits.shortest else LONG
    begin_trial(model, scheme, clock.time, limits.duration)
    save(scheme, work, recorder, kept)
    set_length(scheme, clock.tried)
    begin_part(scheme, clock.part == ALONE, clock.stopped, threshold(limits, clock), work)


@kernel
def next_part(limits: Limits, clock: StepClock, scheme: Any, kept: Backup, work: Workspace, recorder: Recorder) -> None:
    """From the whole step to its first half, and to its second."""
    if clock.part == LONG:
        keep_end(scheme, kept)
        restore(scheme, work, recorder, kept)
        set_length(scheme, 0.5 * clock.tried)
        begin_part(scheme, False, clock.stopped, threshold(limits, clock), work)
    clock.part += 1


@kernel
def undo(clock: StepClock, scheme: Any, kept: Backup, work: Workspace, recorder: Recorder) -> None:
    """Back to the start of the step."""
    restore(scheme, work, recorder, kept)
    clock.part = FRESH


@kernel
def missed_end(
    model: Model, limits: Limits, clock: StepClock, scheme: Any, kept: Backup, work: Workspace, recorder: Recorder
) -> int:
    """DONE where no pair has closed unmet in a step of two halves; PART where one has, and the next trial ends there.

    GROW_TAPE where that cannot be told.
    """
    h = clock.tried
    share = first_unmet(model, h, scheme.q, scheme.u, scheme.gap_tolerance, work, recorder, kept)
    share = min(share, unmet_share(scheme, limits, clock))
    if share < 0.0:
        clock.number = -share
        return RunStatus.GROW_TAPE
    if (1.0 - share) * h <= limits.shortest:
        return RunStatus.DONE
    end_there(limits, clock, h, share)
    return RunStatus.PART


@kernel
def advance(
    model: Model,
    limits: Limits,
    clock: StepClock,
    scheme: Any,
    kept: Backup,
    work: Workspace,
    recorder: Recorder,
    last_step: int,
) -> int:
    """Steps until their number reaches ``last_step`` or the duration is reached; DONE, PAUSE after a while, or what is
    missing.

    A step that could not be finished goes on, at the next call, where it stopped.
    """
    beats = recorder.beats[0]
    while True:
        if clock.part == FRESH:
            status = store_due(model, limits, clock, scheme, work, recorder)
            if status != RunStatus.DONE or clock.time >= limits.duration or clock.steps >= last_step:
                return status
            if recorder.beats[0] != beats:
                return RunStatus.PAUSE
            begin(model, limits, clock, scheme, kept, work, recorder)
        part, h = clock.part, clock.tried
        now = clock.time + (scheme.step if part == SECOND else 0.0)
        status = take_step(model, scheme, now, work, recorder, clock)
        if status == RunStatus.GROW or (part == ALONE and status != RunStatus.DONE):
            return status
        if status == RunStatus.DONE and part < SECOND:
            next_part(limits, clock, scheme, kept, work, recorder)
            continue
        error = 0.0 if part == ALONE else math.inf
        if status == RunStatus.DONE and part == SECOND:
            error = doubling_error(model, limits, scheme.q, scheme.u, kept)
            if error <= 1.0:
                status = missed_end(model, limits, clock, scheme, kept, work, recorder)
        if status == RunStatus.PART:
            undo(clock, scheme, kept, work, recorder)
            continue
        if status == RunStatus.GROW_TAPE:
            undo(clock, scheme, kept, work, recorder)
            return status
        closing = (error, 0.0, 0.0, 0.0)
        if status == RunStatus.DONE:
            near = position_tolerance(limits, scheme.q)
            closing = judge(model, scheme, clock, error, near, work, recorder, kept)
        if not closing[0] <= 1.0:
            undo(clock, scheme, kept, work, recorder)
            after_rejection(limits, clock, h, closing[0])
            continue
        accept(limits, clock, h, closing[0], part == ALONE, closing[1])
        go_on(scheme, limits, clock, closing[2], closing[3], work)
        clock.part = FRESH
        if not end_step(model, scheme, clock.time, False, work):
            return RunStatus.OUT_OF_RANGE


class StepDoubling:
    """A time-stepping scheme with error control."""

    fixed_step = 0.0

    def __init__(self, stepping: TimeStepping, limits: Limits) -> None:
        self.stepping, self.records = stepping, stepping.records
        self._limits = limits
        self._pace = Pace(limits.shortest)
        scheme = stepping.scheme
        scheme.step = min(max(scheme.step, limits.shortest), limits.longest)
        self.clock = allocate(StepClock, {}, step=scheme.step)
        self.records.control = limits.near, limits.rtol
        self.records.impact_step = limits.shortest if stepping.support.impulsive else 0.0
        self.records.recorder.rates.least = least_interval(limits.duration)
        self._kept = backup(stepping.system, _twin(scheme), 16)
        self._advance = stepping.link(advance)

    @property
    def finished(self) -> bool:
        """Whether the run has reached its end and stored it."""
        return self.clock.time >= self._limits.duration and self.clock.due == math.inf

    @property
    def touching(self) -> Any:
        """Declared contacts that the last contact problem held."""
        return self.stepping.touching

    @property
    def motion(self) -> tuple[Any, Any]:
        """Configuration and velocity from which the step that is due begins."""
        begins = self.stepping.scheme if self.clock.part == FRESH else self._kept
        return begins.q, begins.u

    def loop(self, target: int) -> int:
        """Steps until there are ``target`` of them or the duration is reached; what the loop returned."""
        stepping = self.stepping
        while True:
            status: int = self._advance(
                stepping.system.model, self._limits, self.clock, stepping.scheme, self._kept, stepping.work,
                self.records.recorder, min(target, self._pace.due),
            )  # fmt: skip
            self._pace.update(self.clock)
            if status != RunStatus.DONE or self.clock.steps >= target or self.finished:
                return status

    def make_room(self, contacts: int) -> None:
        """Memory for more contacts, ``contacts`` being needed: a step that is under way goes on."""
        self.stepping.make_room(contacts)
        kept = backup(self.stepping.system, _twin(self.stepping.scheme), len(self.stepping.work.rows.table.key))
        copy_parts(self._kept, kept)
        self._kept = kept

    def more_laws(self) -> None:
        """Room for more pairs under a rule that have touched."""
        self.records.more_laws(self.stepping.scheme, self.stepping.work, self._kept)

    def trouble(self, status: int) -> str:
        """Why the loop cannot go on; empty where it can after all."""
        return self.stepping.trouble(status, int(self.clock.number), self.clock.time)

    def remarks(self) -> tuple[list[str], list[str]]:
        """Warnings and notes of the run so far."""
        warnings = [*self.stepping.remarks(), *self._pace.warnings(self.clock)]
        return warnings, [*stopped_note(self._limits, self.clock), *self.stepping.notes()]


def _twin(scheme: Any) -> Any:
    """Another struct with arrays of its own."""
    return copy.deepcopy(scheme)
