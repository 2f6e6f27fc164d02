"""Runs of time-stepping schemes: what they have in common around the compiled loop of a scheme.

A scheme holds its state and memory and calls its loop; a run keeps count of steps and time, ends on the duration,
empties and grows what is full, and says why it cannot go on.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Protocol

from lcpflex.dynamics.workspace import Workspace
from lcpflex.steppers.adaptive import Limits
from lcpflex.steppers.clock import StepClock, StepCount
from lcpflex.steppers.driver import Rescue
from lcpflex.steppers.pace import Pace, stopped_note
from lcpflex.steppers.run import Records
from lcpflex.steppers.status import RunStatus

__all__ = [
    "AdaptiveRun",
    "FixedRun",
    "contact_trouble",
]


class Scheme(Protocol):
    """A time-stepping scheme at work on a system."""

    records: Records
    work: Workspace

    def make_room(self, contacts: int) -> None:
        """Grow all memory to hold ``contacts`` contacts."""

    def trouble(self, status: int, time: float) -> str:
        """Why the loop cannot go on at ``time`` [s]; empty where it can after all."""


class Samples(Protocol):
    """Which steps of a run are sampled for their error; see :mod:`lcpflex.steppers.step_error`."""

    steps: int  # that a sample makes

    @property
    def ahead(self) -> float:
        """Number of the next step before which a sample is due; infinite if none is."""

    def sample(self, time: Callable[[], float], advance: Callable[[int], str]) -> str:
        """Make ``steps`` steps, most in halves as well; empty where all went well, else why the run cannot go on."""


class FixedScheme(Scheme, Protocol):
    """A scheme with steps of one length."""

    clock: StepCount
    impulsive: bool  # whether an impact falls on the end of a step

    @property
    def step(self) -> float:
        """Length of the steps [s]."""

    @property
    def within(self) -> float:
        """Time made of the present step [s]."""

    def loop(self, start: float, n_steps: int, stride: int) -> int:
        """Up to ``n_steps`` steps counted from time ``start``, each ``stride``-th one stored; what was returned."""

    def change_step(self, step: float) -> None:
        """Go on with steps of another length, counted from 0."""

    def sampling(self, total: int) -> Samples | None:
        """What measures the error of some of ``total`` steps; None where an own solver would see it."""

    def warn(self, steps: int) -> None:
        """Bring the warnings of the records up to date, after ``steps`` steps in all."""


class ControlledScheme(Scheme, Protocol):
    """A scheme with step control."""

    clock: StepClock

    def loop(self, limits: Limits, last_step: int) -> int:
        """Steps until there are ``last_step`` of them or the duration is reached; what was returned."""

    def remarks(self) -> list[str]:
        """Warnings of the run so far, but that of too short steps."""


def contact_trouble(work: Workspace, rescue: Rescue, status: int, number: int, tolerance: float, time: float) -> str:
    """Why a loop that returned ``status`` cannot go on; empty where its contact problem was solved after all."""
    if status == RunStatus.SOLVER_FAILED:
        return "" if rescue(work, time) else rescue.unsolved(work, number, tolerance)
    return RunStatus.NOT_FINITE.sentence


def _touching(work: Workspace) -> list[int]:
    """Declared contacts that the last contact problem held."""
    return sorted(set(work.table.law[: work.n_contacts].tolist()))


class FixedRun:
    """A run with steps of one length, the last one shorter where the duration is no multiple of it."""

    def __init__(self, scheme: FixedScheme, duration: float, interval: float) -> None:
        self.scheme = scheme
        self.records = scheme.records
        self.duration = duration
        self.fixed_step = step = scheme.step
        whole = math.floor(duration / step * (1.0 + 1e-12) + 1e-9)
        rest = duration - whole * step
        self._phases = [(step, whole)] + ([(rest, 1)] if rest > 1e-9 * step else [])
        self._stride = max(1, round(interval / step))
        self._start = 0.0
        self._made = 0
        total = sum(count for _, count in self._phases)
        self._sampling = self.records.sampling = scheme.sampling(total)
        self.records.impact_step = step if scheme.impulsive else 0.0

    @property
    def time(self) -> float:
        """Time reached [s]."""
        if not self._phases:
            return self.duration
        return self._start + self.scheme.clock.made * self.scheme.step + self.scheme.within

    @property
    def steps(self) -> int:
        """Steps made."""
        return self._made + self.scheme.clock.made

    @property
    def finished(self) -> bool:
        """Whether the run has reached its end and stored it."""
        return not self._phases

    @property
    def touching(self) -> list[int]:
        """Declared contacts that the last contact problem held."""
        return _touching(self.scheme.work)

    @property
    def events(self) -> list[tuple[float, str, int, float]]:
        """Time stepping locates no events."""
        return []

    def advance(self, n_steps: int) -> str:
        """Make up to ``n_steps`` steps; empty where all went well, else why the run cannot go on."""
        step, whole = self._phases[0]
        message = self._loop(min(n_steps, whole - self.scheme.clock.made), self._stride)
        self.scheme.warn(self.steps)
        if message or self.scheme.clock.made < whole:
            return message
        if len(self._phases) == 1:
            message = self._loop(0, 1)  # the end is stored even where the stride would skip it
        else:  # a last, shorter step ends the run on its duration
            self._made += whole
            self._start += whole * step
            self.scheme.change_step(self._phases[1][0])
        if not message:
            self._phases.pop(0)
        return message

    def _loop(self, n_steps: int, stride: int) -> str:
        """Make steps, some of them sampled; empty where all went well, else why the run cannot go on.

        A sample that begins among these steps is made as a whole, be they fewer: which steps are sampled, and with it
        the result, must not depend on how many are made at a time.
        """
        last = self.steps + n_steps
        left = self._phases[0][1] - self.scheme.clock.made  # steps of this length
        while self._sampling and self._sampling.ahead - 1.0 < last:
            before = int(self._sampling.ahead) - 1 - self.steps
            if before < 0 or before + self._sampling.steps > left:  # the last, shorter step is not sampled
                break
            message = self._steps(before, stride) or self._sampling.sample(
                lambda: self.time, lambda count: self._steps(count, stride)
            )
            if message:
                return message
            left -= before + self._sampling.steps
        return self._steps(max(last - self.steps, 0), stride)

    def _steps(self, n_steps: int, stride: int) -> str:
        clock = self.scheme.clock
        target = clock.made + n_steps
        while True:
            status = self.scheme.loop(self._start, int(target - clock.made), stride)
            if status == RunStatus.DONE:
                return ""
            if status == RunStatus.PASSED:
                self.records.examine(self.time, self.scheme.step)
                continue
            message = _remedied(self.scheme, status, self.time)
            if message:
                return message


class AdaptiveRun:
    """A run with step control."""

    def __init__(self, scheme: ControlledScheme, limits: Limits) -> None:
        self.scheme = scheme
        self.records = scheme.records
        self._limits = limits
        self._pace = Pace(limits.shortest)

    @property
    def time(self) -> float:
        """Time reached [s]."""
        return self.scheme.clock.time

    @property
    def steps(self) -> int:
        """Steps made, without those rejected and without the long ones that only measure the error."""
        return self.scheme.clock.steps

    @property
    def finished(self) -> bool:
        """Whether the run has reached its end and stored it."""
        return self.time >= self._limits.duration and self.scheme.clock.due == math.inf

    @property
    def touching(self) -> list[int]:
        """Declared contacts that the last contact problem held."""
        return _touching(self.scheme.work)

    @property
    def events(self) -> list[tuple[float, str, int, float]]:
        """Time stepping locates no events."""
        return []

    def advance(self, n_steps: int) -> str:
        """Make about ``n_steps`` steps; empty where all went well, else why the run cannot go on."""
        clock, target = self.scheme.clock, self.steps + n_steps
        try:
            while True:
                status = self.scheme.loop(self._limits, min(target, self._pace.due))
                message = "" if status == RunStatus.DONE else _remedied(self.scheme, status, self.time)
                self._pace.look(clock)
                if message or (status == RunStatus.DONE and (self.steps >= target or self.finished)):
                    return message
        finally:  # of an interrupted run, too
            self.records.warnings[:] = [*self.scheme.remarks(), *self._pace.warnings(clock)]
            self.records.notes[:] = stopped_note(self._limits, clock)


def _remedied(scheme: FixedScheme | ControlledScheme, status: int, time: float) -> str:
    """Empty what is full and grow what is too small; why the loop cannot go on where neither is the reason."""
    number = int(scheme.clock.number)
    if status == RunStatus.TAPE_FULL:
        scheme.records.empty()
    elif status == RunStatus.GROW_TAPE:
        scheme.records.grow(number)
    elif status == RunStatus.GROW:
        scheme.make_room(2 * number)
    else:
        return scheme.trouble(status, time)
    return ""
