"""Steps of one length: the loop over any time-stepping scheme, and its run."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from lcpflex.dynamics.mechanics import count_rows
from lcpflex.dynamics.workspace import Workspace
from lcpflex.jit.kernel import kernel
from lcpflex.jit.struct import allocate
from lcpflex.model.arrays import Model
from lcpflex.steppers.clock import StepCount
from lcpflex.steppers.coarse_touches import Touches
from lcpflex.steppers.not_finite import not_finite
from lcpflex.steppers.passing import may_pass
from lcpflex.steppers.rates import ask_step, strides_of
from lcpflex.steppers.recorder import Recorder, has_room
from lcpflex.steppers.scheme import NO_FACTOR, end_step, record, set_length, take_step
from lcpflex.steppers.status import RunStatus
from lcpflex.steppers.time_stepping import TimeStepping

__all__ = ["FixedSteps", "advance"]


@kernel
def advance(model: Model, clock: StepCount, scheme: Any, work: Workspace, recorder: Recorder, last: int) -> int:
    """Steps until there are ``last`` of them, from a state that is stored where it is due.

    Returns DONE, PAUSE after a while, or why the next step or record could not be made; the state is then that of the
    last whole step or part of one (but NOT_FINITE).
    """
    beats = recorder.beats[0]
    if scheme.step != clock.length:
        set_length(scheme, clock.length)
    while True:
        t = clock.time
        if clock.begun == 1 and clock.within == 0.0:
            if clock.stored != clock.steps and ask_step(recorder.rates, clock.stride, clock.steps, clock.last):
                if not has_room(work, recorder):
                    return RunStatus.TAPE_FULL
                clock.number = record(model, scheme, t, work, recorder)
                if clock.number == NO_FACTOR:
                    return RunStatus.GROW_FACTOR
                if clock.number > len(recorder.table.key):
                    return RunStatus.GROW_TAPE
                clock.stored = clock.steps
            if clock.steps >= last:
                return RunStatus.DONE
            if recorder.beats[0] != beats:  # as DONE, with the present instant stored
                return RunStatus.PAUSE
        clock.step_taken = clock.length
        status = take_step(model, scheme, t, work, recorder, clock)
        if status == RunStatus.DONE:
            clock.steps += 1
            clock.within = 0.0
        elif status != RunStatus.PART:
            return status
        clock.time = clock.start + (clock.steps - clock.first) * clock.length + clock.within
        if status == RunStatus.DONE and not end_step(model, scheme, t + clock.length, True, work):
            return RunStatus.OUT_OF_RANGE
        if may_pass(model, scheme.q, recorder):
            return RunStatus.PASSED


class FixedSteps:
    """A time-stepping scheme with steps of one length, the last one shorter where the duration is no multiple of it.

    ``average``: shares of a step before and after the time that forces are asked for, over which loads are averaged.
    ``begun``: whether the forces of the start are known.
    """

    def __init__(
        self, stepping: TimeStepping, duration: float, interval: float, average: tuple[float, float], begun: bool = True
    ) -> None:
        self.stepping, self.records, self.system = stepping, stepping.records, stepping.system
        self.fixed_step = step = stepping.scheme.step
        self._duration, self._average = duration, np.array(average)
        self._whole = math.floor(duration / step * (1.0 + 1e-12) + 1e-9)
        rest = duration - self._whole * step
        last = self._whole + (rest > 1e-9 * step)
        self.clock = allocate(
            StepCount, {}, length=step, last=last, stored=-1, stride=max(1, round(interval / step)), begun=begun
        )
        strides_of(self.records.recorder.rates, step)
        self._advance = stepping.link(advance)
        self._choose(step)
        self.records.impact_step = step if stepping.support.impulsive else 0.0
        if stepping.system.is_compliant:
            self.records.touches = Touches(stepping.work.compliant.history.touches, step)

    @property
    def finished(self) -> bool:
        """Whether the run has reached its end and stored it."""
        return self.clock.steps == self.clock.stored == self.clock.last

    @property
    def touching(self) -> Any:
        """Declared contacts that the last contact problem held."""
        return self.stepping.touching

    @property
    def motion(self) -> tuple[Any, Any]:
        """Configuration and velocity from which the step that is due begins."""
        return self.stepping.scheme.q, self.stepping.scheme.u

    def loop(self, target: int) -> int:
        """Steps until there are ``target`` of them, or all; what the loop returned."""
        clock, whole = self.clock, self._whole
        status = self._loop(min(target, whole))
        if status != RunStatus.DONE or clock.steps < whole or clock.steps == clock.last or target <= whole:
            return status
        if clock.first < whole:  # a last, shorter step ends the run on its duration
            clock.start, clock.first = clock.start + whole * clock.length, whole
            self._choose(self._duration - whole * clock.length)
        return self._loop(clock.last)

    def _loop(self, last: int) -> int:
        stepping = self.stepping
        status: int = self._advance(
            stepping.system.model, self.clock, stepping.scheme, stepping.work, self.records.recorder, last
        )
        return status

    def _choose(self, length: float) -> None:
        """Go on with steps of this length [s]."""
        self.clock.length = length
        self.stepping.work.free.span[:] = self._average * length

    def make_room(self, contacts: int) -> None:
        """Memory for more contacts, ``contacts`` being needed."""
        self.stepping.make_room(contacts)

    def more_laws(self) -> None:
        """Room for more pairs under a rule that have touched."""
        self.records.more_laws(self.stepping.scheme, self.stepping.work)

    def trouble(self, status: int) -> str:
        """Why the loop cannot go on; empty where it can after all."""
        words = self.stepping.trouble(status, int(self.clock.number), self.clock.time)
        if words and (status == RunStatus.NOT_FINITE or not_finite(self.system, self.stepping.work)):
            self._store_last()
        return words

    def _store_last(self) -> None:
        """Store the state that the step began from, which is sound, without the forces of the contacts found in it."""
        clock, work = self.clock, self.stepping.work
        if clock.begun == 0 or clock.within != 0.0 or clock.stored == clock.steps:
            return
        self.records.empty()  # there is room
        rows, last = work.rows, clock.last
        held = rows.n_contacts, rows.n_tangents
        count_rows(rows, rows.n_joint, 0, 0)
        work.posed.islands.count = 0
        clock.last = clock.steps
        self._loop(clock.steps)
        clock.last = last
        count_rows(rows, rows.n_joint, *held)

    def remarks(self) -> tuple[list[str], list[str]]:
        """Warnings and notes of the run so far."""
        coarse = self.records.touches.warnings(self.system.names)
        return [*self.stepping.remarks(self.clock.steps), *coarse], self.stepping.notes()
