"""Event-driven stepping: smooth motion of high order between events that are located in time.

Between events the index sets are fixed and the motion is an ordinary differential equation, advanced by a Runge-Kutta
pair 5(4) with error control (:mod:`lcpflex.steppers.event_segment`). At an event (a gap closes, a contact force
vanishes, slip stops, stick breaks, a foot leaves its segment) impacts are resolved and the sets chosen anew
(:mod:`lcpflex.steppers.event_sets`). Source: Pfeiffer & Glocker 1996.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from lcpflex.compiled import FloatArray
from lcpflex.contact.detection import ContactTable
from lcpflex.dynamics.acceleration import ContactSets, assemble, lay_rows, position_errors, project
from lcpflex.dynamics.impulse import METHOD
from lcpflex.errors import ModelError, in_range
from lcpflex.solvers.auto import Auto
from lcpflex.solvers.problem import LcpSolver
from lcpflex.steppers.driver import Rescue, link, solver_hooks, solver_method, unsolved
from lcpflex.steppers.event_loop import (
    CHATTER,
    DONE,
    EVENTS_FULL,
    GROW,
    GROW_TAPE,
    MOST_EVENTS,
    SOLVER_FAILED,
    STEP_TOO_SHORT,
    STEPPING,
    TAPE_FULL,
    advance,
    record,
)
from lcpflex.steppers.event_memory import (
    CONTACTS,
    DETAIL,
    EVENT_KINDS,
    EVENTS,
    LAST_EVENT,
    PHASE,
    STEP,
    STEPS,
    TIME,
    EventSettings,
    event_memory,
)
from lcpflex.steppers.event_segment import first_closing, gap_above, locate_gap, measure, search, slope, step
from lcpflex.steppers.event_sets import choose, collide, gather
from lcpflex.steppers.run import Records
from lcpflex.steppers.system import System
from lcpflex.steppers.tape import store_contacts

__all__ = ["EventDriven", "EventDrivenRun"]


class EventDrivenRun:
    """An event-driven run in progress (see :class:`EventDriven`)."""

    def __init__(self, system: System, stepper: EventDriven, duration: float, interval: float) -> None:
        self.system = system
        self.records = Records(system)
        self.duration = duration
        self._events: list[tuple[float, str, int, float]] = []
        self._settings = EventSettings(
            duration,
            interval,
            stepper.rtol,
            stepper.atol,
            stepper.max_step,
            stepper.gap_tolerance,
            stepper.velocity_threshold,
            stepper.solver_tolerance,
        )
        self._rescue = Rescue(stepper.solver, stepper.solver_tolerance)
        self._work = system.workspace(16)
        self._work.solving[METHOD] = solver_method(stepper.solver)
        self._memory = event_memory(system, 16)
        self._memory.clock[STEP] = 0.0 if stepper.first_step is None else stepper.first_step
        self._memory.clock[LAST_EVENT] = -math.inf
        hooks = {**system.hooks, **solver_hooks(stepper.solver, system.watch)}
        self._advance = link([*_PARTS, advance], hooks)

    @property
    def q(self) -> FloatArray:
        """Configuration reached (ndof,)."""
        return self._memory.y[: len(self.system.q)]

    @property
    def u(self) -> FloatArray:
        """Velocity reached (ndof,)."""
        n = len(self.system.q)
        return self._memory.y[n : 2 * n]

    @property
    def time(self) -> float:
        """Time reached [s]."""
        return float(self._memory.clock[TIME])

    @property
    def steps(self) -> int:
        """Steps made."""
        return int(self._memory.number[STEPS])

    @property
    def finished(self) -> bool:
        """Whether the run has reached its end and stored it."""
        return self.time >= self.duration and int(self._memory.number[PHASE]) == STEPPING

    @property
    def touching(self) -> list[int]:
        """Declared contacts of the present sets."""
        return sorted(set(self._work.table.law[: int(self._memory.number[CONTACTS])].tolist()))

    @property
    def events(self) -> list[tuple[float, str, int, float]]:
        """Time [s], kind, declared contact and energy change [J] of every event so far."""
        count = int(self._memory.number[EVENTS])
        for time, kind, law, change in self._memory.events[:count].tolist():
            self._events.append((time, EVENT_KINDS[int(kind)], int(law), change))
        self._memory.number[EVENTS] = 0
        return self._events

    def advance(self, n_steps: int) -> str:
        """Make up to n_steps steps; empty, or why the run cannot go on."""
        target = self.steps + n_steps
        while True:
            status = self._advance(
                self.system.model, self._settings, self._work, self._memory, self.records.tape, target
            )
            detail = self._memory.clock[DETAIL]
            if status == DONE:
                return ""
            if status == TAPE_FULL:
                self.records.empty()
            elif status == GROW_TAPE:
                self.records.grow(int(detail))
            elif status == GROW:
                self._grow(2 * int(detail))
            elif status == EVENTS_FULL:
                _ = self.events
            elif status == SOLVER_FAILED:
                if self._rescue(self._work, self.time):
                    continue
                return unsolved(self._work, int(detail), self._settings.tolerance)
            elif status == CHATTER:
                return f"more than {MOST_EVENTS} events at one instant: the contacts named here switch without end"
            elif status == STEP_TOO_SHORT:
                return "no step is short enough: the forces are not smooth, or the state grows without bound"
            else:
                return "the state is no longer finite"

    def _grow(self, capacity: int) -> None:
        """Larger tables with the same content."""
        old_work, old = self._work, self._memory
        self._work = self.system.workspace(capacity)
        self._work.solving[:] = old_work.solving
        new = event_memory(self.system, capacity)
        _copy(old_work.table, self._work.table, ContactTable._fields)
        _copy(old.sets, new.sets, ContactSets._fields)
        for name in ("y", "clock", "number", "events"):
            getattr(new, name)[...] = getattr(old, name)
        self._memory = new


_PARTS: list[Callable[..., Any]] = [
    lay_rows,
    assemble,
    position_errors,
    project,
    slope,
    step,
    gap_above,
    locate_gap,
    first_closing,
    measure,
    search,
    collide,
    choose,
    gather,
    store_contacts,
    record,
]  # those that call what may be replaced, callees first


def _copy(old: Any, new: Any, fields: tuple[str, ...]) -> None:
    """Entries of one table of arrays into the first ones of a larger one."""
    for name in fields:
        source = getattr(old, name)
        getattr(new, name)[tuple(slice(size) for size in source.shape)] = source


@dataclass(frozen=True, slots=True)
class EventDriven:
    """Event-driven stepping with adaptive Runge-Kutta steps of order 5(4).

    Attributes
    ----------
    rtol, atol
        Tolerances of a step: root mean square of error / (atol + rtol |y|) over q and u at most 1.
    max_step
        Longest step [s].
    first_step
        First step [s]; chosen if omitted.
    gap_tolerance
        Gaps up to this count as closed at an event, deeper penetration of an open pair as an event [m].
    velocity_threshold
        Slower approach than this [m/s] is stopped instead of reflected (e_N = 0), which ends the infinitely many
        impacts of a bouncing body; a thousandth of it is the slip below which a contact may stick.
    solver
        Any object with ``solve(problem)``; ``Auto()`` and ``Lemke()`` keep the whole loop compiled.
    solver_tolerance
        Largest natural-map residual accepted.

    Raises
    ------
    ModelError
        For a number out of its range.
    """

    rtol: float = 1e-8
    atol: float = 1e-10
    max_step: float = math.inf
    first_step: float | None = None
    gap_tolerance: float = 1e-9
    velocity_threshold: float = 1e-6
    solver: LcpSolver = field(default_factory=Auto)
    solver_tolerance: float = 1e-9

    def __post_init__(self) -> None:
        for name in ("rtol", "atol", "gap_tolerance", "velocity_threshold", "solver_tolerance"):
            in_range(name, getattr(self, name), 0.0, math.inf, open_ends=True)
        if not (isinstance(self.max_step, (int, float)) and self.max_step > 0.0):
            raise ModelError(f"max_step: {self.max_step!r} was given, expected a number > 0 (seconds)")
        if self.first_step is not None:
            in_range("first_step", self.first_step, 0.0, math.inf, open_ends=True)
        if not hasattr(self.solver, "solve"):
            raise ModelError(f"solver: {self.solver!r} was given, expected an object with solve(), such as Auto()")

    def start(self, system: System, duration: float, interval: float) -> EventDrivenRun:
        """A run over ``duration`` [s] that stores an instant every ``interval`` [s], and before and after impacts."""
        return EventDrivenRun(system, self, duration, interval)
