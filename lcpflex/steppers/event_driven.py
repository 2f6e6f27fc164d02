"""Event-driven stepping: smooth motion of high order between events that are located in time.

Between events the index sets are fixed and the motion is an ordinary differential equation, advanced by a Runge-Kutta
pair 5(4) with error control (:mod:`lcpflex.steppers.event_segment`). At an event (a gap closes, a contact force vanishes, slip
stops, stick breaks, a foot leaves its segment) impacts are resolved and the sets chosen anew
(:mod:`lcpflex.steppers.event_sets`). Source: Pfeiffer & Glocker 1996.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

from lcpflex.compiled import FloatArray, kernel
from lcpflex.contact.detection import ContactTable
from lcpflex.contact.kinematics import contact_point
from lcpflex.dynamics.acceleration import SMOOTH, STICKING, ContactSets, assemble, lay_rows, project, project_position
from lcpflex.dynamics.delassus import row_velocity
from lcpflex.dynamics.mechanics import energies
from lcpflex.dynamics.workspace import Workspace
from lcpflex.errors import ModelError, in_range
from lcpflex.model import SLIP, STICK, Model
from lcpflex.solvers.lemke import Lemke
from lcpflex.steppers.driver import LcpSolver, link, solver_hooks
from lcpflex.steppers.event_memory import (
    CAUSE,
    CLOSING,
    CONTACTS,
    DETAIL,
    EVENT_CAPACITY,
    EVENT_KINDS,
    EVENTS,
    HITS,
    LAST_EVENT,
    PHASE,
    SHARE,
    STEPS,
    STORED,
    STUCK,
    TAKEN,
    TIME,
    EventMemory,
    EventSettings,
    event_memory,
)
from lcpflex.steppers.event_segment import (
    SLIP_PART,
    event_function,
    first_closing,
    locate,
    search,
    slope,
    step,
)
from lcpflex.steppers.event_sets import GROW, RESOLVED, choose, collide, resolve, try_sticking
from lcpflex.steppers.run import Records
from lcpflex.steppers.runge_kutta import copy_state, interpolate
from lcpflex.steppers.system import System
from lcpflex.steppers.tape import Tape, note_contact, store_contacts, store_state

__all__ = ["EventDriven", "EventDrivenRun", "advance"]

# what the compiled loop returns
DONE = 0
TAPE_FULL = 1
GROW_TAPE = 3
SOLVER_FAILED = 4
NOT_FINITE = 5
EVENTS_FULL = 6
CHATTER = 7
STEP_TOO_SHORT = 8

# where it is, number[PHASE]
FIRST, STEPPING, EMITTING, CLOSING_STEP, BEFORE, RESOLVING, AFTER = range(7)

SAME_TIME = 1e-13  # relative: events so close count as one instant
MOST_EVENTS = 200  # at one instant


@kernel
def record(
    model: Model, settings: EventSettings, t: float, y: FloatArray, work: Workspace, memory: EventMemory, tape: Tape
) -> int:
    """Store the state y of time t with its contact forces; returns DONE, or why there is no room."""
    ndof = len(memory.u)
    q = y[:ndof]
    u = y[ndof : 2 * ndof]
    n = memory.number[CONTACTS]
    if tape.filled[0] >= len(tape.times) or (tape.filled[1] + n > len(tape.spots) and tape.filled[1] > 0):
        return TAPE_FULL
    needed = store_contacts(model, q, tape)
    if needed > len(tape.table.key) or n > len(tape.spots):
        memory.clock[DETAIL] = max(needed, n)
        return GROW_TAPE
    slope(model, t, y, work, memory, memory.slope)
    base = 2 * ndof
    tape.sums[0] = y[base]
    tape.sums[2] = y[base + 1]
    tape.sums[3] = y[base + 2]
    row = tape.filled[0]
    for law in range(len(tape.total_impulse)):
        tape.total_impulse[law, 0] = y[base + 3 + 2 * law]
        tape.total_impulse[law, 1] = y[base + 4 + 2 * law]
        if tape.gap[row, law] < 0.0:
            tape.worst[1] = max(tape.worst[1], -tape.gap[row, law])
    for k in range(n):
        r = work.step_size[0] + k
        force_t = 0.0
        state = STICK if memory.sets.mode[k] == STICKING else SLIP
        if memory.sets.mode[k] != SMOOTH:
            tangent = work.step_size[0] + n + memory.sets.tangent_of[k]
            force_t = work.p[tangent]
            slip = row_velocity(work.rows, work.row_body, tangent, work.dof, u)
            if abs(slip) <= SLIP_PART * settings.velocity_threshold:
                state = STICK
        place = contact_point(model, q, work.table, k)
        note_contact(tape, work.table.law[k], place, work.table.normal[k], work.p[r], force_t, state)
    kinetic, elastic, potential = energies(model, q, u, work)
    store_state(tape, t, q, u, kinetic, elastic, potential)
    return DONE


@kernel
def record_time(settings: EventSettings, memory: EventMemory) -> float:
    """When the next instant is to be stored [s]; the end of the present step if all steps are."""
    if settings.interval > 0.0:
        return min(memory.number[STORED] * settings.interval, settings.duration)
    return memory.clock[TIME] + memory.clock[SHARE] * memory.clock[TAKEN]


@kernel
def emit(model: Model, settings: EventSettings, work: Workspace, memory: EventMemory, tape: Tape) -> int:
    """Store the instants that are due up to the end of the step, or to the event in it."""
    share = memory.clock[SHARE]
    end = memory.clock[TIME] + share * memory.clock[TAKEN]
    slack = 1e-12 * settings.duration
    while True:
        t = record_time(settings, memory)
        if t > end + slack or memory.number[STORED] < 0:
            return DONE
        at = min((t - memory.clock[TIME]) / memory.clock[TAKEN], share)
        interpolate(memory.y, memory.slopes, memory.clock[TAKEN], at, memory.at)
        status = record(model, settings, min(t, end), memory.at, work, memory, tape)
        if status != DONE:
            return status
        last = t >= settings.duration * (1.0 - 1e-12)
        memory.number[STORED] = -1 if last else memory.number[STORED] + 1
        if settings.interval <= 0.0:
            return DONE


@kernel
def close_step(model: Model, settings: EventSettings, work: Workspace, memory: EventMemory, tape: Tape) -> int:
    """Go to the end of the step or to the event in it, back onto the constraints; the next phase."""
    ndof = len(memory.u)
    clock = memory.clock
    if clock[SHARE] < 1.0:
        interpolate(memory.y, memory.slopes, clock[TAKEN], clock[SHARE], memory.at)
        copy_state(memory.at, memory.y)
    else:
        copy_state(memory.end, memory.y)
    clock[TIME] += clock[SHARE] * clock[TAKEN]
    if clock[TIME] > settings.duration * (1.0 - 1e-14):
        clock[TIME] = settings.duration
    q = memory.y[:ndof]
    u = memory.y[ndof : 2 * ndof]
    joint_drift, gap_drift = project(model, clock[TIME], q, u, memory.number[CONTACTS], work, memory.sets)
    tape.worst[1] = max(tape.worst[1], gap_drift)
    tape.worst[2] = max(tape.worst[2], joint_drift)
    memory.number[STEPS] += 1
    if memory.number[CAUSE] < 0:
        return STEPPING
    again = clock[TIME] - clock[LAST_EVENT] <= SAME_TIME * settings.duration
    memory.number[STUCK] = memory.number[STUCK] + 1 if again else 0
    clock[LAST_EVENT] = clock[TIME]
    return BEFORE if memory.number[CAUSE] == CLOSING else RESOLVING


@kernel
def settle(model: Model, settings: EventSettings, work: Workspace, memory: EventMemory, tape: Tape) -> int:
    """Resolve the event; DONE with the next phase set, or why not."""
    if memory.number[EVENTS] >= EVENT_CAPACITY:
        return EVENTS_FULL
    if memory.number[STUCK] > MOST_EVENTS:
        return CHATTER
    status = resolve(model, settings, work, memory, tape)
    if status != RESOLVED:
        return status
    first = memory.number[STORED] == 0
    if first and memory.number[HITS] == 0:
        tape.filled[0] = 0  # the state before was no other
        tape.filled[1] = 0
    memory.number[PHASE] = AFTER if first or memory.number[HITS] == 1 else STEPPING
    return DONE


@kernel
def advance(
    model: Model, settings: EventSettings, work: Workspace, memory: EventMemory, tape: Tape, last_step: int
) -> int:
    """Steps until their number is ``last_step`` or the duration is reached; DONE, or what is missing. Calling again goes on."""
    number = memory.number
    while True:
        phase = number[PHASE]
        status = DONE
        if phase == STEPPING:
            if number[STEPS] >= last_step or memory.clock[TIME] >= settings.duration:
                return DONE
            if not step(model, settings, work, memory):
                return STEP_TOO_SHORT
            if not search(model, settings, work, memory):
                return GROW
            number[PHASE] = EMITTING
        elif phase == EMITTING:
            status = emit(model, settings, work, memory, tape)
            number[PHASE] = CLOSING_STEP if status == DONE else EMITTING
        elif phase == CLOSING_STEP:
            number[PHASE] = close_step(model, settings, work, memory, tape)
            for i in range(2 * len(memory.u)):
                if not math.isfinite(memory.y[i]):
                    return NOT_FINITE
        elif phase == RESOLVING:
            status = settle(model, settings, work, memory, tape)
        else:  # FIRST, BEFORE or AFTER
            if number[STEPS] >= last_step:
                return DONE
            status = record(model, settings, memory.clock[TIME], memory.y, work, memory, tape)
            if status == DONE:
                if phase == AFTER:
                    number[STORED] = max(number[STORED], 1) if number[STORED] >= 0 else -1
                number[PHASE] = STEPPING if phase == AFTER else RESOLVING
        if status != DONE:
            return status


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
        self._work = system.workspace(16)
        self._memory = event_memory(system, 16)
        self._memory.clock[1] = 0.0 if stepper.first_step is None else stepper.first_step
        self._memory.clock[LAST_EVENT] = -math.inf
        hooks = {**system.hooks, **solver_hooks(stepper.solver)}
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
                return (
                    f"the contact problem of size {self._work.step_size[3]} was not solved: status {int(detail)}, "
                    f"natural-map residual {self._work.certificate[0]:.3g} (tolerance {self._settings.tolerance:g})"
                )
            elif status == CHATTER:
                return f"more than {MOST_EVENTS} events at one instant: the contacts named here switch without end"
            elif status == STEP_TOO_SHORT:
                return "no step is short enough for the tolerances: the forces are not smooth, or the state grows without bound"
            else:
                return "the state is no longer finite"

    def _grow(self, capacity: int) -> None:
        """Larger tables with the same content."""
        old_work, old = self._work, self._memory
        self._work = self.system.workspace(capacity)
        new = event_memory(self.system, capacity)
        _copy(old_work.table, self._work.table, ContactTable._fields)
        _copy(old.sets, new.sets, ContactSets._fields)
        for name in ("y", "clock", "number", "events"):
            getattr(new, name)[...] = getattr(old, name)
        self._memory = new


_PARTS: list[Any] = [
    lay_rows,
    assemble,
    project_position,
    project,
    slope,
    step,
    event_function,
    locate,
    first_closing,
    search,
    collide,
    try_sticking,
    choose,
    resolve,
    store_contacts,
    record,
    emit,
    close_step,
    settle,
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
        Any object with ``solve(problem)``; ``Lemke()`` keeps the whole loop compiled.
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
    solver: LcpSolver = field(default_factory=Lemke)
    solver_tolerance: float = 1e-9

    def __post_init__(self) -> None:
        for name in ("rtol", "atol", "gap_tolerance", "velocity_threshold", "solver_tolerance"):
            in_range(name, getattr(self, name), 0.0, math.inf, open_ends=True)
        if not (isinstance(self.max_step, (int, float)) and self.max_step > 0.0):
            raise ModelError(f"max_step: {self.max_step!r} was given, expected a number > 0 (seconds)")
        if self.first_step is not None:
            in_range("first_step", self.first_step, 0.0, math.inf, open_ends=True)
        if not hasattr(self.solver, "solve"):
            raise ModelError(f"solver: {self.solver!r} was given, expected an object with solve(problem), such as Lemke()")

    def start(self, system: System, duration: float, interval: float) -> EventDrivenRun:
        """A run over ``duration`` [s] that stores an instant every ``interval`` [s], and before and after impacts."""
        return EventDrivenRun(system, self, duration, interval)
