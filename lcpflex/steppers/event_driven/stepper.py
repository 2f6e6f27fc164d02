"""Event-driven stepping: smooth motion of high order between events that are located in time.

Between events the index sets are fixed and the motion is an ordinary differential equation, advanced by a Runge-Kutta
pair 5(4) with error control (:mod:`lcpflex.steppers.event_driven.segment`). At an event (a gap closes, a contact force
vanishes, slip stops, stick breaks, a foot leaves its segment) impacts are resolved and the sets chosen anew
(:mod:`lcpflex.steppers.event_driven.sets`). Source: Pfeiffer & Glocker 1996.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any, ClassVar

from lcpflex.basics.options import keep_at_least, keep_number, keep_number_or_none
from lcpflex.dynamics.impact_laws import KNOWN, ImpactLaw, Newton, Stronge
from lcpflex.dynamics.islands import forget_islands
from lcpflex.errors import ModelError, shown
from lcpflex.jit.dispatch import link
from lcpflex.jit.kernel import IntArray
from lcpflex.jit.struct import copy_parts, lengthen, numbers_of
from lcpflex.model.layout import is_spatial, sums_of_contacts
from lcpflex.solvers.auto import Auto
from lcpflex.solvers.contact.cones.mixed_problem import own_pulls
from lcpflex.solvers.contact.posed import own_pull, posed_lcp, put_solution
from lcpflex.solvers.lcp.enumeration import Enumeration
from lcpflex.solvers.problem import LcpSolver, Status
from lcpflex.steppers.driver import Rescue, solver_hooks, solver_method
from lcpflex.steppers.event_driven.loop import (
    CHOOSING,
    COLLIDING,
    MOST_EVENTS,
    STEPPING,
    advance,
)
from lcpflex.steppers.event_driven.memory import (
    CONE,
    EVENT_CAPACITY,
    EVENT_KINDS,
    SLIDING,
    WINDOW,
    EventSettings,
    event_memory,
    more_impulses,
)
from lcpflex.steppers.event_driven.remarks import event_remarks, shared_load
from lcpflex.steppers.event_driven.thresholds import SLIP_PART, SPATIAL_SLIP_PART, Thresholds
from lcpflex.steppers.law_run import begin_laws, law_trouble, law_warnings, refuse_states
from lcpflex.steppers.named import listed
from lcpflex.steppers.not_finite import not_finite
from lcpflex.steppers.options import keep_solver
from lcpflex.steppers.records import Records
from lcpflex.steppers.run import Run
from lcpflex.steppers.scales import given_or, scales_of
from lcpflex.steppers.shared_loads import shared_loads
from lcpflex.steppers.state_numbers import tolerance_of_numbers
from lcpflex.steppers.status import RunStatus
from lcpflex.steppers.system import System
from lcpflex.steppers.time_stepping import FIRST_ROOM, grown
from lcpflex.steppers.user_functions import watch_pair_laws

__all__ = ["EventDriven"]


class EventDrivenSteps:
    """Steps between events, for a run (see :class:`EventDriven`)."""

    fixed_step = 0.0

    def __init__(self, system: System, stepper: EventDriven, duration: float, interval: float) -> None:
        self.system = system
        self.records = Records(system)
        self.duration = duration
        self._events: list[tuple[float, str, int, float]] = []
        self._in_space = is_spatial(system.model)
        scales = scales_of(system, duration)
        slow = given_or(stepper.velocity_threshold, 1e-6 * scales.speed)
        settings = EventSettings(
            duration,
            interval,
            stepper.rtol,
            tolerance_of_numbers(stepper.atol, stepper.rtol, system, scales, system.n_laws),
            stepper.max_step,
            scales.gap(stepper.gap_tolerance, located=True),
            slow,
            stepper.solver_tolerance,
            stepper.impact.code,
            stepper.impact.sequential,
            WINDOW / scales.most_events(stepper.most_events),
            system.margin,
            (SPATIAL_SLIP_PART if self._in_space else SLIP_PART) * slow,
            math.inf,
        )
        self._thresholds = Thresholds(settings)
        self._impact = stepper.impact
        self._first_jam = ""
        self._proven = True  # that there was no solution where none was found
        self._rescue = Rescue(stepper.solver, stepper.solver_tolerance)
        self._work = system.workspace(FIRST_ROOM)
        self._work.impulses.solver.method = solver_method(stepper.solver, is_spatial(system.model))
        self.clock = event_memory(system, FIRST_ROOM, 64, FIRST_ROOM)
        self.clock.step = 0.0 if stepper.first_step is None else stepper.first_step
        self.clock.last_event = -math.inf
        self.clock.gentlest = math.inf
        begin_laws(system, self._work)
        self.records.indentation = self._work.compliant.history.worst
        self._solving = solver_hooks(self._rescue, system.watch, is_spatial(system.model))
        self._advance = link(advance, {**system.hooks, **self._solving})

    @property
    def finished(self) -> bool:
        """Whether the run has reached its end and stored it."""
        return self.clock.time >= self.duration and self.clock.phase == STEPPING

    @property
    def touching(self) -> IntArray:
        """Declared contacts of the present sets."""
        at_event = self.clock.phase in (COLLIDING, CHOOSING)
        count = int(self.clock.n_found if at_event else self.clock.n_contacts)
        return self._work.rows.table.law[:count]

    @property
    def events(self) -> list[tuple[float, str, int, float]]:
        """Time [s], kind, declared contact and energy change [J] of every event so far."""
        count = self.clock.n_events
        for time, kind, law, change in self.clock.events[:count].tolist():
            self._events.append((time, EVENT_KINDS[int(kind)], int(law), change))
        self.clock.n_events = 0
        return self._events

    @property
    def motion(self) -> tuple[Any, Any]:
        """Configuration and velocity from which the step that is due begins."""
        nq, y = len(self.system.q), self.clock.y
        return y[:nq], y[nq : nq + len(self.system.u)]

    def loop(self, target: int) -> int:
        """Steps until there are ``target`` of them or the duration is reached; what the loop returned."""
        status: int = self._advance(
            self.system.model, self._thresholds.settings, self._work, self.clock, self.records.recorder, target
        )
        return status

    def trouble(self, status: int) -> str:
        """Why the loop cannot go on; empty where it can after all."""
        if status == RunStatus.EVENTS_FULL:
            _ = self.events
        elif status == RunStatus.CALM:
            self._thresholds.fall()
        elif status == RunStatus.SOLVER_FAILED:
            if named := not_finite(self.system, self._work):
                return f"{RunStatus.SOLVER_FAILED.sentence} ({named})"
            if not (self._rescued() or self._jam()):
                return self._rescue.unsolved(self._work, int(self.clock.number), self._thresholds.settings.tolerance)
        elif status not in (RunStatus.TOO_OFTEN, RunStatus.CHATTER) or not self._calm(status):
            return self._sentence(status)
        return ""

    def _sentence(self, status: int) -> str:
        if status == RunStatus.HIT_TOGETHER:
            return (
                f"{self._impact} integrates the impact of one contact, but contacts that influence each other "
                "close together here: use Stronge(sequential=True), Poisson() or Newton()"
            )
        if status == RunStatus.TOO_OFTEN:
            # changes between sticking and slipping are none of the events that are told
            laws = sorted({event[2] for event in self.events[-WINDOW:]}) or sorted(set(self.touching))
            of = f", of {listed(laws, self.system.contact_name)}," if laws else ""
            return (
                f"the last {WINDOW} events{of} followed each other at more than "
                f"{self._thresholds.most}: MoreauJean(step=...) takes the impacts of a step together"
            )
        if status == RunStatus.CHATTER:
            return (
                f"more than {MOST_EVENTS} events at one instant: the contacts named here switch without end, and no "
                "threshold that may rise ends that: MoreauJean(step=...) takes what contacts do in a step together"
            )
        if status == RunStatus.OUT_OF_RANGE:
            return law_trouble(self.system.names, self._work)
        if status == RunStatus.NOT_FINITE:
            named = not_finite(self.system, self._work)
            return f"the state is no longer finite{f' ({named})' if named else ''}"
        return RunStatus(status).sentence

    def _calm(self, status: int) -> bool:
        """Raise a threshold where events accumulate too fast, and count them anew; False where none may be raised.

        Where most of them have changed no state, the record does not tell of them: what the last was located by does.
        """
        memory = self.clock
        located = min(memory.stuck, WINDOW) if status == RunStatus.CHATTER else WINDOW
        since = memory.time if status == RunStatus.CHATTER else float(memory.recent.min())
        told = sum(event[0] >= since for event in self.events[-WINDOW:])
        slips = None if 2 * told > located else memory.cause in (CONE, SLIDING)
        if not self._thresholds.rise(self.events, memory.time, memory.fastest, memory.gentlest, slips):
            return False
        memory.gentlest = math.inf
        memory.located = memory.too_many = memory.stuck = 0
        return True

    def _rescued(self) -> bool:
        """Whether another way has solved the problem; in space those on index sets have no other one."""
        if self._in_space and (self.clock.phase == CHOOSING or self._work.posed.shifted == 1):
            return False
        return self._rescue(self._work, self.clock.time)

    def _jam(self) -> bool:
        """Where the acceleration level has no solution: let an impact without collision follow, at most ten.

        A solution that the solver has missed is taken instead where all sets can be tried.
        """
        memory, work = self.clock, self._work
        sets: Any = memory.sets
        if memory.phase != CHOOSING or memory.nudges >= MOST_JAMS:
            return False
        if self._in_space:
            self._proven &= work.posed.problem.n_contacts == 1
            pull = own_pulls(sets.problem)
        elif work.impulses.solver.size <= MOST_TRIED:  # is there really none?
            solution = Enumeration().solve(posed_lcp(work.posed.problem, work.impulses.solver))
            if solution.solved:
                put_solution(work.posed.problem, work.impulses.solver, solution)
                return True
            self._proven &= solution.status in (Status.NO_SOLUTION, Status.INFEASIBLE)
        else:
            self._proven = False
        if not self._in_space:
            pull = own_pull(work.posed.problem)
        islands = work.posed.islands
        first = islands.start[islands.next]
        # < 0: its own force pulls this contact in
        memory.target = int(islands.contact[first + pull.argmin()])
        forget_islands(islands)
        memory.nudges += 1
        memory.nudging = 1
        memory.jams += 1
        memory.phase = COLLIDING
        if memory.jams == 1:
            self.clock.first_jam = self.clock.time
            self._first_jam = self.system.contact_name(work.rows.table.law[memory.target])
        return True

    def remarks(self) -> tuple[list[str], list[str]]:
        """What the run has met so far that a reader must know, and what it may want to know."""
        warnings = [
            *law_warnings(self.system.names, self._work.compliant.history),
            *event_remarks(self.clock, self.system.contact_name, self._proven, self._first_jam),
            *self._overlap(),
            *self._thresholds.remarks(self.system.contact_name),
            *self._rescue.remarks(self.system.contact_name),
        ]
        name = self.system.contact_name
        return warnings, [*shared_load(self.clock, name), *shared_loads(self.system.model, self._work, name)]

    def _overlap(self) -> list[str]:
        deepest = self.clock.deepest
        if deepest <= DEEP * self._thresholds.settings.gap_tolerance:
            return []
        return [f"bodies overlapped by {deepest:.3g} m without an impact: shorter steps (max_step) may find it"]

    def make_room(self, needed: int) -> None:
        """Larger tables with the same content: of contacts, of what is near (negative), of the largest island."""
        old_work, old = self._work, self.clock
        capacity, near = max(len(old.seen.key), 2 * needed), max(len(old.near.key), -2 * needed)
        dense = grown(len(old_work.posed.problem.friction), old_work.impulses.most)
        self._work = self.system.workspace(capacity, before=old_work, dense=dense)
        new = event_memory(self.system, capacity, near, dense)
        copy_parts(old_work.rows.table, self._work.rows.table)
        copy_parts(old.sets, new.sets)
        for name in CARRIED:
            getattr(new, name)[...] = getattr(old, name)
        numbers_of(new)[:] = numbers_of(old)
        self.clock = new

    def more_laws(self) -> None:
        """Room for more pairs under a rule that have touched."""
        memory, old = self.clock, self.system.n_laws
        self.records.more_laws(memory, self._work)
        new = self.system.n_laws
        sums = sums_of_contacts(self.system.model)
        more_impulses(memory, sums * (new - old))
        lengthen(memory, "events", len(memory.events), EVENT_CAPACITY + 3 * new)
        memory.taken[old:] = -1
        self._thresholds.more_laws(sums * (new - old))


# what of the memory goes on as it is where tables grow
CARRIED = (
    "y", "events", "recent", "law_state", "law_work", "taken", "tied", "struck_key", "struck_time",
)  # fmt: skip
DEEP = 2e3  # gap tolerances: deeper overlap than may be at the start
MOST_JAMS = 10  # impacts without collision at one instant
MOST_TRIED = 12  # unknowns of problems that are proven to have no solution


@dataclass(frozen=True, slots=True)
class EventDriven:
    """Event-driven stepping with adaptive Runge-Kutta steps of order 5(4).

    Attributes
    ----------
    rtol, atol
        Tolerances of a step: root mean square of error / (atol + rtol |y|) over q and u at most 1. atol None: a
        hundredth of rtol times what is usual in the scene, of lengths, angles and velocities each.
    max_step
        Longest step [s].
    first_step
        First step [s]; chosen if omitted.
    gap_tolerance
        Gaps up to this count as closed at an event, deeper penetration of an open pair as an event [m].
        None: 1e-9 of the size of the scene (extent of the largest body), and at least 6.7e-12 of the largest
        coordinate: rounding of places, which is more where bodies are farther from the origin than 150 such sizes.
    velocity_threshold
        Slower approach than this [m/s] is stopped instead of reflected (e_N = 0), which ends the infinitely many
        impacts of a bouncing body; a thousandth of it, in space a hundredth, is the slip below which a contact may
        stick. None: 1e-6 of the
        speed of the scene, the larger of sqrt(gravity size) / pi and the fastest initial speed of a body.
    impact
        :class:`Newton`, :class:`Poisson` or :class:`Stronge`: the meaning of the restitution of the contacts.
    most_events
        Events a second of simulated time, over the last 1000, beyond which the velocity threshold, or the slip below
        which a contact may stick, rises for a while to end them, with a warning. If none of at most a hundredth of the
        largest velocity of a contact would, the run ends. None: 1e5 in the time in which the speed of the scene passes
        its size (a second, where these are 1 m/s and 1 m); 1e7 in a run without gravity or initial motion.
    solver
        One of this package, a function of (M, q) or of (problem) that returns z, or an object with ``solve(problem)``:
        see :class:`lcpflex.solvers.UserSolver`. ``Auto()`` and ``Lemke()`` keep the whole loop compiled.
    solver_tolerance
        Largest natural-map residual accepted.

    Raises
    ------
    ModelError
        For a number out of its range.
    """

    rtol: float = 1e-8
    atol: float | None = None
    max_step: float = math.inf
    first_step: float | None = None
    gap_tolerance: float | None = None
    velocity_threshold: float | None = None
    impact: ImpactLaw = field(default_factory=Newton)
    most_events: float | None = None
    solver: LcpSolver = field(default_factory=Auto)
    solver_tolerance: float = 1e-9
    keeps_dense: ClassVar[bool] = True  # that a negative interval asks for the dense output, see ``start``

    def __post_init__(self) -> None:
        keep_number(self, "rtol", 0.0, math.inf, open_ends=True)
        for name in ("atol", "gap_tolerance", "velocity_threshold", "most_events"):
            keep_number_or_none(self, name, 0.0, math.inf, open_ends=True)
        keep_at_least(self, "max_step", 0.0, "a number > 0 (seconds)", open_end=True)
        if self.first_step is not None:
            keep_number(self, "first_step", 0.0, math.inf, open_ends=True)
        if not isinstance(self.impact, ImpactLaw):
            raise ModelError(f"impact: {shown(self.impact)} was given, expected {KNOWN}")
        keep_solver(self)

    def start(self, system: System, duration: float, interval: float) -> Run:
        """A run over ``duration`` [s] that stores an instant every ``interval`` [s], and before and after events.

        0 stores the end of each step; a negative number its middle as well, which with the velocities tells its path.

        system: what a scene or a system of the user's own is compiled to.
        """
        tangential = system.model.contacts.tangential_restitution
        if not self.impact.tangential and tangential.any():
            raise ModelError(
                f"impact: {self.impact} was given for a contact with tangential restitution {tangential.max():g}, "
                "expected Newton(), the one law that knows it"
            )
        if is_spatial(system.model) and isinstance(self.impact, Stronge):
            raise ModelError(
                f"impact: {self.impact} was given for a spatial scene, expected Newton() or Poisson(): with two "
                "tangents the slip turns while the impulse grows, which this law is not integrated for"
            )
        refuse_states(system)
        run = Run(EventDrivenSteps(system, self, duration, interval))
        watch_pair_laws(run.records, system)
        return run
