"""A run in progress: what makes its steps, advanced in chunks, and what it has recorded."""

from __future__ import annotations

from typing import Any, Protocol

from lcpflex.contact.rule_pairs import MORE_LAWS
from lcpflex.steppers.records import Records
from lcpflex.steppers.status import RunStatus

__all__ = ["Method", "Run", "remedied"]


class Method(Protocol):
    """What makes the steps of a run: :class:`FixedSteps`, :class:`StepDoubling`, or a method with a loop of its own."""

    records: Records
    fixed_step: float  # length of steps of one length [s]; 0 where error control chooses it
    # a struct with the time reached [s], the steps made, the length of the last part of one (step_taken) [s], and a
    # number that explains the last status: how much room is needed, which contact it was
    clock: Any

    @property
    def finished(self) -> bool:
        """Whether the run has reached its end and stored it."""

    @property
    def touching(self) -> Any:
        """Declared contacts of the last contact problem or evaluation, each at least once."""

    @property
    def motion(self) -> tuple[Any, Any]:
        """Configuration and velocity from which the step that is due begins."""

    def loop(self, target: int) -> int:
        """Steps until there are ``target`` of them or the duration is reached, or for a while; a status."""

    def make_room(self, number: int) -> None:
        """Larger tables."""

    def more_laws(self) -> None:
        """Room for more pairs under a rule that have touched."""

    def trouble(self, status: int) -> str:
        """Why the loop cannot go on; empty where it can after all."""

    def remarks(self) -> tuple[list[str], list[str]]:
        """Warnings and notes of the run so far."""


Event = tuple[float, str, int, float]  # time [s], kind, declared contact, energy change [J]


class Run:
    """A run: steps of a method, its records, and its events where it locates them."""

    def __init__(self, method: Method) -> None:
        self.method = method
        self.records = method.records

    @property
    def fixed_step(self) -> float:
        """Length of steps of one length [s]; 0 where error control chooses it."""
        return self.method.fixed_step

    @property
    def time(self) -> float:
        """Time reached [s]."""
        return float(self.method.clock.time)

    @property
    def steps(self) -> int:
        """Steps made, without those rejected and without the long ones that only measure the error."""
        return int(self.method.clock.steps)

    @property
    def finished(self) -> bool:
        """Whether the run has reached its end and stored it."""
        return self.method.finished

    @property
    def touching(self) -> list[int]:
        """Declared contacts that the last contact problem held, or that touched at the last evaluation."""
        return sorted(set(self.method.touching.tolist()))

    @property
    def motion(self) -> tuple[Any, Any]:
        """Configuration and velocity from which the step that is due begins."""
        q, u = self.method.motion
        return q.copy(), u.copy()

    @property
    def events(self) -> list[Event]:
        """The events so far; only event-driven runs locate them."""
        found: list[Event] = getattr(self.method, "events", [])
        return found

    def advance(self, n_steps: int) -> str:
        """Make up to ``n_steps`` steps; empty, or why the run cannot go on.

        Fewer where they take long: it returns a few times a second (:mod:`lcpflex.basics.pulse`).
        """
        try:
            return self._towards(self.steps + n_steps)
        finally:  # of an interrupted run, too
            self.records.warnings[:], self.records.notes[:] = self.method.remarks()

    def _towards(self, target: int) -> str:
        """Steps until there are ``target`` of them, or for a while."""
        while True:
            status = self.method.loop(target)
            if status in (RunStatus.DONE, RunStatus.PAUSE):
                return ""
            if message := remedied(self.method, status):
                return message


def remedied(method: Method, status: int) -> str:
    """Empty what is full and grow what is too small; why a loop cannot go on where neither is the reason."""
    number = abs(int(method.clock.number)) if status in (RunStatus.GROW, RunStatus.GROW_TAPE) else 0
    if status == RunStatus.TAPE_FULL:
        method.records.make_room()
    elif number == MORE_LAWS:
        method.more_laws()
    elif status == RunStatus.GROW_TAPE:
        method.records.grow(number)
    elif status == RunStatus.GROW:
        method.make_room(int(method.clock.number))
    elif status == RunStatus.PASSED:
        while method.records.examine(method.clock.time, method.clock.step_taken) == MORE_LAWS:
            method.more_laws()
    else:
        return method.trouble(status)
    return ""
