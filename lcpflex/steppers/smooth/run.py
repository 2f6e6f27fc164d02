"""Steps under continuous contact forces: what those of all integrators share, and the explicit ones."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Protocol

from lcpflex.force_laws.history import ContactMemory
from lcpflex.force_laws.layout import LawRow
from lcpflex.jit.dispatch import link
from lcpflex.jit.kernel import IntArray
from lcpflex.steppers.coarse_touches import Touches, rounded_down
from lcpflex.steppers.law_run import law_warnings, too_deep
from lcpflex.steppers.rates import strides_of
from lcpflex.steppers.records import Records
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
from lcpflex.steppers.system import System

__all__ = ["SmoothSteps"]

STABLE = 2.0  # frequency times step up to which explicit steps of fixed length do not grow


class Implicit(Protocol):
    """An integrator with a loop in Python."""

    def start(self) -> None:
        """Begin at the present state."""

    def loop(self, target: int) -> int:
        """Steps until there are ``target`` of them or the duration is reached; a status."""


class SmoothSteps:
    """Steps of any integrator: Runge-Kutta's with error control, Verlet's of fixed length, or those of ``implicit``.

    ``fixed_step``: of Verlet's method [s]; 0 for the others. ``implicit``: makes one with a loop of its own.
    """

    def __init__(
        self,
        system: System,
        laws: Sequence[LawRow],
        settings: SmoothSettings,
        first_step: float = 0.0,
        fixed_step: float = 0.0,
        implicit: Callable[[SmoothSteps], Implicit] | None = None,
    ) -> None:
        self.system, self.fixed_step = system, fixed_step
        self.records = Records(system)
        self.records.compliant, self.records.laws = system.names, list(laws)
        self.duration = settings.duration
        self.settings = settings
        self._laws = laws
        self.work = system.workspace(1, system.compliant(laws, 16))
        self.clock = smooth_memory(system, self.history, laws)
        self.clock.step = first_step
        self.records.indentation = self.history.worst
        self._advance = link(advance_fixed if fixed_step else advance, system.hooks)
        if fixed_step:
            strides_of(self.records.recorder.rates, fixed_step)
            self.records.touches = Touches(self.history.touches, fixed_step)
            self.work.free.span[:] = 0.5 * fixed_step  # loads by their mean over a step
        self._unused: list[str] = []
        bouncing = [
            name for name, e in zip(system.names, system.model.contacts.restitution.tolist(), strict=True) if e > 0.0
        ]
        if bouncing:
            self._unused.append(
                f"the restitution of contacts {', '.join(bouncing)} is not used: under continuous contact forces a "
                "rebound follows from the damping of the force law"
            )

        self._implicit = None if implicit is None else implicit(self)

    def begin_again(self) -> None:
        """Make the integrator whose state is about to be put back."""
        if self._implicit is not None:
            self._implicit.start()

    @property
    def history(self) -> ContactMemory:
        """What contacts remember; the same however large tables grow."""
        return self.work.compliant.history

    @property
    def finished(self) -> bool:
        """Whether the run has reached its end and stored it."""
        return self.clock.time >= self.duration and self.clock.phase == STEPPING

    @property
    def touching(self) -> IntArray:
        """Declared contacts that touched at the last evaluation."""
        contacts = self.work.compliant
        return contacts.rows.table.law[: contacts.rows.n_contacts]

    @property
    def motion(self) -> tuple[Any, Any]:
        """Configuration and velocity from which the step that is due begins."""
        nq, y = len(self.system.q), self.clock.y
        return y[:nq], y[nq : nq + len(self.system.u)]

    def loop(self, target: int) -> int:
        """Steps until there are ``target`` of them or the duration is reached; what the loop returned."""
        if self._implicit is not None:
            return self._implicit.loop(target)
        status: int = self._advance(
            self.system.model, self.settings, self.work, self.clock, self.records.recorder, target
        )
        return status

    def more_laws(self) -> None:
        """Its rules are listed: laws do not grow."""
        raise AssertionError("a rule that is not listed, under Smooth")

    def make_room(self, contacts: int) -> None:
        """Memory for more contacts than are near."""
        span, before = self.work.free.span, self.work.compliant
        self.work = self.system.workspace(1, self.system.compliant(self._laws, 2 * before.needed, before))
        self.work.free.span[:] = span

    def trouble(self, status: int) -> str:
        """Why the loop cannot go on."""
        if status == RunStatus.OUT_OF_RANGE:
            return too_deep(self.system.names, self.history, self.work.compliant.out_of_range)
        return RunStatus(status).sentence

    def remarks(self) -> tuple[list[str], list[str]]:
        """What there is to warn of at present, each once; no notes."""
        warnings = [*self._unused, *law_warnings(self.system.names, self.history)]
        product = self.clock.frequency * self.fixed_step
        if not product <= STABLE:
            warnings.append(
                f"the stiffest contact has sqrt(k G_nn) step = {product:.4g} > 2: explicit steps of fixed length are "
                f"unstable there (highest contact frequency {self.clock.frequency:.4g} rad/s; take steps of at most "
                f"{rounded_down(STABLE / self.clock.frequency):.2g} s)"
            )
        return [*warnings, *self.records.touches.warnings(self.system.names)], []
