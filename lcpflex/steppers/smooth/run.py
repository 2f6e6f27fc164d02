"""Runs under continuous contact forces: what those of all integrators share, and the explicit ones."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from lcpflex.force_laws.history import ContactMemory
from lcpflex.force_laws.layout import LawRow
from lcpflex.jit.dispatch import link
from lcpflex.steppers.law_run import law_warnings, too_deep
from lcpflex.steppers.run import Records
from lcpflex.steppers.smooth.explicit import (
    STEPPING,
    SmoothSettings,
    advance,
    advance_fixed,
)
from lcpflex.steppers.smooth.memory import (
    smooth_memory,
)
from lcpflex.steppers.status import RunStatus
from lcpflex.steppers.step_error import UNSTORED, Sampling
from lcpflex.steppers.system import System

__all__ = ["FixedRun", "SmoothRun"]

STABLE = 2.0  # frequency times step up to which explicit steps of fixed length do not grow


class SmoothRun:
    """A run of adaptive Runge-Kutta steps; the parts that other integrators share."""

    def __init__(
        self, system: System, laws: Sequence[LawRow], settings: SmoothSettings, first_step: float = 0.0
    ) -> None:
        self.system = system
        self.records = Records(system)
        self.records.by_law, self.records.laws = system.names, list(laws)
        self.duration = settings.duration
        self._settings = settings
        self._laws = laws
        self._work = system.workspace(1, system.compliant(laws, 16))
        self._memory = smooth_memory(system, self._history, laws)
        self._memory.step = first_step
        self.records.indentation = self._history.worst
        self._advance = link(advance, system.hooks)
        bouncing = [
            name for name, e in zip(system.names, system.model.contacts.restitution.tolist(), strict=True) if e > 0.0
        ]
        if bouncing:
            self.records.warnings.append(
                f"the restitution of contacts {', '.join(bouncing)} is not used: under continuous contact forces a "
                "rebound follows from the damping of the force law"
            )
        self._own = list(self.records.warnings)

    @property
    def _history(self) -> ContactMemory:
        return self._work.compliant.history

    @property
    def time(self) -> float:
        """Time reached [s]."""
        return self._memory.time

    @property
    def steps(self) -> int:
        """Steps accepted."""
        return self._memory.steps

    @property
    def finished(self) -> bool:
        """Whether the run has reached its end and stored it."""
        return self.time >= self.duration and self._memory.phase == STEPPING

    @property
    def touching(self) -> list[int]:
        """Declared contacts that touched at the last evaluation."""
        contacts = self._work.compliant
        return sorted(set(contacts.table.law[: contacts.n_contacts].tolist()))

    @property
    def events(self) -> list[tuple[float, str, int, float]]:
        """Continuous forces have no events."""
        return []

    def advance(self, n_steps: int) -> str:
        """Make up to n_steps steps; empty, or why the run cannot go on."""
        target = self.steps + n_steps
        while True:
            status = self._advance(
                self.system.model, self._settings, self._work, self._memory, self.records.tape, target
            )
            message = "" if status == RunStatus.DONE else self._handle(status)
            if message or status == RunStatus.DONE:
                self._warn()
                return message

    def _warn(self) -> None:
        """Keep in the records what there is to warn of at present, each once."""
        self.records.warnings[:] = [*self._own, *law_warnings(self.system.names, self._history)]

    def _handle(self, status: int) -> str:
        """Make room for what there was none, and go on; or why not."""
        detail = int(self._memory.detail)
        if status == RunStatus.PASSED:
            self.records.examine(self.time, self._memory.step_taken)
        elif status == RunStatus.TAPE_FULL:
            self.records.empty()
        elif status == RunStatus.GROW_TAPE:
            self.records.grow(detail)
        elif status == RunStatus.GROW:
            span = self._work.span
            before = self._work.compliant
            more = self.system.compliant(self._laws, 2 * before.needed, before)
            self._work = self.system.workspace(1, more)
            self._work.span[:] = span
        elif status == RunStatus.OUT_OF_RANGE:
            return too_deep(self.system.names, self._history, self._work.compliant.out_of_range)
        elif status == RunStatus.NOT_FINITE:
            return "the state is no longer finite: the step is too long for the forces of this scene"
        else:
            return RunStatus(status).sentence
        return ""


class FixedRun(SmoothRun):
    """A run of explicit steps of fixed length, which warns where contacts are too stiff for it."""

    def __init__(self, system: System, laws: Sequence[LawRow], settings: SmoothSettings) -> None:
        super().__init__(system, laws, settings)
        self.fixed_step = settings.max_step
        self._work.span[:] = 0.5 * settings.max_step  # loads by their mean over a step
        self._advance = link(advance_fixed, system.hooks)
        total = math.ceil(settings.duration / settings.max_step)
        self._sampling = self.records.sampling = Sampling(self, total)

    def advance(self, n_steps: int) -> str:
        """Make up to n_steps steps, some of them sampled; empty, or why the run cannot go on."""
        last = self.steps + n_steps
        while self._sampling.ahead - 1.0 < last:  # made as a whole, be these steps fewer
            before = int(self._sampling.ahead) - 1 - self.steps
            message = super().advance(before) or self._sampling.sample(lambda: self.time, super().advance)
            if message or self.finished:
                return message
        return super().advance(max(last - self.steps, 0))

    def state(self) -> tuple[Any, ...]:
        """All that a step changes, q and u first."""
        ndof, y = len(self.system.q), self._memory.y
        return (y[:ndof], y[ndof : 2 * ndof], self._memory, self._history)

    def half_steps(self, time: float, done: int, count: int) -> int:
        """``count`` steps of half the length, after ``done`` ones since ``time`` [s]; what the loop returned."""
        halved = self._settings._replace(duration=math.inf, max_step=0.5 * self._settings.max_step, stride=UNSTORED)
        target = self.steps + count
        self._work.span[:] *= 0.5
        try:
            while True:
                status = self._advance(self.system.model, halved, self._work, self._memory, self.records.tape, target)
                if status != RunStatus.PASSED:
                    return int(status)
        finally:
            self._work.span[:] *= 2.0

    def _warn(self) -> None:
        """Keep in the records what there is to warn of at present, each once."""
        super()._warn()
        product = self._memory.frequency * self._settings.max_step
        if not product <= STABLE:
            self.records.warnings.append(
                f"the stiffest contact has sqrt(k G_nn) step = {product:.4g} > 2: explicit steps of fixed length are "
                f"unstable there (highest contact frequency {self._memory.frequency:.4g} rad/s)"
            )
