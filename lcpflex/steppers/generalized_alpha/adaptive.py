"""Generalised-alpha time stepping with step control: the problems of a step in another loop.

The recursive acceleration a of the scheme stands for udot at t + (alpha_m - alpha_f) h; where the step changes from h
to h', a' = udot + (a - udot) h'/h keeps it of the order of the scheme.
"""

from __future__ import annotations

import math

from lcpflex.dynamics.instants import at_stop
from lcpflex.dynamics.workspace import Workspace
from lcpflex.jit.dispatch import link
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.jit.struct import allocate, copy_parts
from lcpflex.model.arrays import Model
from lcpflex.solvers.contact.compiled import recall_basis, remember_basis, solve_contacts
from lcpflex.solvers.problem import LcpSolver
from lcpflex.steppers.adaptive import (
    MOST_STRIKES,
    SETTLE,
    Backup,
    Limits,
    accept,
    add_differences,
    after_rejection,
    backup,
    doubling_error,
    end_there,
    next_length,
    position_tolerance,
    put_back,
    put_by,
    resume,
    threshold,
)
from lcpflex.steppers.clock import StepClock
from lcpflex.steppers.driver import Rescue, solver_hooks, solver_method
from lcpflex.steppers.event_driven.memory import copy_entry
from lcpflex.steppers.generalized_alpha.memory import (
    RESTART,
    SMOOTH,
    VELOCITY,
    AlphaMemory,
    Held,
    alpha_memory,
    copy_end,
    larger,
)
from lcpflex.steppers.generalized_alpha.smooth import AlphaSettings
from lcpflex.steppers.generalized_alpha.step import AGAIN, STEPPED, correct, give_up_smooth, predict
from lcpflex.steppers.moreau_jean.step import grown, record
from lcpflex.steppers.recorder import Tape
from lcpflex.steppers.run import Records
from lcpflex.steppers.several_motions import SeveralMotions
from lcpflex.steppers.status import RunStatus
from lcpflex.steppers.stepping_run import contact_trouble
from lcpflex.steppers.system import System
from lcpflex.steppers.unmet import closed_pairs, first_unmet

__all__ = ["ControlledGeneralizedAlpha"]

FRESH, LONG, FIRST, SECOND, ALONE = range(5)  # parts of a step


@kernel
def copy_held(source: Held, target: Held) -> None:
    """One list of contacts becomes another."""
    target.count = source.count
    for i in range(source.count):
        copy_entry(source.table, i, target.table, i)
        target.mode[i] = source.mode[i]
        target.load[i, 0] = source.load[i, 0]
        target.load[i, 1] = source.load[i, 1]


@kernel
def copy_memory(source: AlphaMemory, target: AlphaMemory) -> None:
    """What a step takes over from the one before."""
    for i in range(len(source.a)):
        target.a[i] = source.a[i]
        target.w[i] = source.w[i]
    copy_end(source.start, target.start)
    for law in range(len(source.recursive)):
        for i in range(2):
            target.recursive[law, i] = source.recursive[law, i]
    target.phase = source.phase
    target.turn = source.turn
    target.between = source.between
    target.skip = source.skip
    target.n_found = source.n_found
    target.warm = source.warm
    target.unsettled = source.unsettled
    copy_held(source.resting, target.resting)


@kernel
def scale_acceleration(clock: StepClock, length: float, memory: AlphaMemory) -> None:
    """Carry the recursive acceleration from steps of length clock.scaled to ``length``."""
    ratio = length / clock.scaled
    for i in range(len(memory.a)):
        memory.a[i] = memory.w[i] + ratio * (memory.a[i] - memory.w[i])
    for law in range(len(memory.recursive)):
        for i in range(2):
            now = memory.start.contact[law, i]
            memory.recursive[law, i] = now + ratio * (memory.recursive[law, i] - now)
    clock.scaled = length


@kernel
def with_step(settings: AlphaSettings, h: float, rebound: float, settle: float) -> AlphaSettings:
    """The same numbers for steps of length h, with thresholds of restitution."""
    return AlphaSettings(
        h,
        settings.alpha_m,
        settings.alpha_f,
        settings.gamma,
        settings.beta,
        settings.gap_tolerance,
        settings.velocity_threshold,
        settings.tolerance,
        rebound,
        settle,
    )


@kernel
def begin(
    model: Model,
    limits: Limits,
    clock: StepClock,
    q: FloatArray,
    u: FloatArray,
    work: Workspace,
    memory: AlphaMemory,
    tape: Tape,
    kept: Backup,
    kept_memory: AlphaMemory,
) -> None:
    """Choose the length of the next step and keep the state it starts from."""
    h = next_length(model, limits, clock)
    if memory.phase == SMOOTH and at_stop(model.signals, clock.time, limits.duration):
        memory.phase = RESTART  # forces may jump there, and the recursion with them
    clock.tried = h
    clock.part = ALONE if h <= limits.shortest else LONG
    put_by(q, u, work, tape, kept)
    copy_memory(memory, kept_memory)
    scale_acceleration(clock, h, memory)


@kernel
def undo(
    clock: StepClock,
    q: FloatArray,
    u: FloatArray,
    work: Workspace,
    memory: AlphaMemory,
    tape: Tape,
    kept: Backup,
    kept_memory: AlphaMemory,
) -> None:
    """Back to the start of the step."""
    put_back(q, u, work, tape, kept)
    copy_memory(kept_memory, memory)
    clock.scaled = clock.recent


@kernel
def touch_down(h: float, limits: Limits, clock: StepClock, memory: AlphaMemory) -> float:
    """Share of the step at which the pair closed that a position problem has moved out; above 1: none, or as found.

    A step that is to end at an impact must not end far behind: of a short contact little approach would be left.
    """
    approach = memory.approach
    if approach <= threshold(limits, clock) or clock.strikes >= MOST_STRIKES:
        return 2.0
    late = memory.struck_at / approach
    if late <= limits.shortest or late >= h:
        return 2.0
    clock.strikes += 1
    return 1.0 - late / h


@kernel
def advance_adaptive(
    model: Model,
    settings: AlphaSettings,
    limits: Limits,
    clock: StepClock,
    q: FloatArray,
    u: FloatArray,
    work: Workspace,
    memory: AlphaMemory,
    kept: Backup,
    kept_memory: AlphaMemory,
    tape: Tape,
    last_step: int,
) -> int:
    """Steps until their number reaches ``last_step`` or the duration is reached; DONE, or what is missing.

    A step that could not be finished goes on, at the next call, at the problem where it stopped.
    """
    while True:
        if clock.part == FRESH:
            t = clock.time
            ended = t >= limits.duration
            if clock.due <= t or (ended and clock.due < math.inf):
                if tape.n_instants >= len(tape.times) or tape.n_points + work.n_contacts > len(tape.spots):
                    return RunStatus.TAPE_FULL
                clock.number = record(model, clock.recent, t, q, u, work, tape)
                if clock.number > len(tape.table.key):
                    return RunStatus.GROW_TAPE
                clock.due = math.inf if ended else t + limits.interval
            if ended or clock.steps >= last_step:
                return RunStatus.DONE
            begin(model, limits, clock, q, u, work, memory, tape, kept, kept_memory)
        h = clock.tried
        part = clock.part
        length = h if part in (LONG, ALONE) else 0.5 * h
        now = clock.time + (length if part == SECOND else 0.0)
        scaled = with_step(settings, length, threshold(limits, clock), SETTLE if part == ALONE else 0.0)
        at = kept.long_q if part == LONG else q
        rate = kept.long_u if part == LONG else u
        clock.number = predict(model, scaled, now, at, rate, work, memory)
        if clock.number > len(work.table.key):
            return RunStatus.GROW
        if memory.warm == 1:
            recall_basis(work.problem, work.solver)
        clock.number = solve_contacts(work.problem, work.solver)
        status = AGAIN
        if clock.number != 0 or not work.solver.residual <= settings.tolerance:
            if give_up_smooth(memory):
                continue
            status = RunStatus.SOLVER_FAILED
        else:
            if memory.phase == VELOCITY:
                remember_basis(work.problem, work.solver)
            status = correct(model, scaled, now, at, rate, work, memory, tape)
        if status == AGAIN:
            continue
        if status != STEPPED and part == ALONE:
            return status
        if status == STEPPED and part == LONG:
            undo(clock, q, u, work, memory, tape, kept, kept_memory)
            scale_acceleration(clock, 0.5 * h, memory)
            memory.lifted = 0.0
            memory.approach = 0.0
            memory.struck_at = 0.0
            memory.stopped = 0.0
            clock.part = FIRST
            continue
        if status == STEPPED and part == FIRST:
            clock.part = SECOND
            continue
        error = 0.0
        sunk = 0.0
        if status == STEPPED and part == SECOND and doubling_error(limits, q, u, kept) <= 1.0:
            share = first_unmet(model, h, q, u, settings.gap_tolerance, work, tape, kept)
            share = min(share, touch_down(h, limits, clock, memory))
            late = (1.0 - share) * h
            if share < 0.0 or late > limits.shortest:
                clock.part = FRESH
                undo(clock, q, u, work, memory, tape, kept, kept_memory)
                if share < 0.0:
                    clock.number = -share
                    return RunStatus.GROW_TAPE
                end_there(limits, clock, h, share)
                continue
        if status == STEPPED:
            sunk = closed_pairs(model, q, u, 0.0, work, tape, kept)[0]
            if part == SECOND:
                error = doubling_error(limits, q, u, kept)
                # an impact in the second half is put at the end by both results: what has sunk by then tells
                sunk_unseen = max(sunk - clock.deepest, memory.lifted)
                error = max(error, sunk_unseen / position_tolerance(limits, q))
        else:
            error = math.inf
        clock.part = FRESH
        if not error <= 1.0:
            undo(clock, q, u, work, memory, tape, kept, kept_memory)
            after_rejection(limits, clock, h, error)
            continue
        if part == SECOND:
            add_differences(q, u, kept, tape)
        accept(limits, clock, h, error, part == ALONE, sunk)
        clock.fastest = max(clock.fastest, memory.approach)
        clock.stopped = max(clock.stopped, memory.stopped)
        resume(limits, clock)
        clock.strikes = 0


class ControlledGeneralizedAlpha:
    """A generalised-alpha run's state and memory, with step control."""

    def __init__(self, system: System, settings: AlphaSettings, limits: Limits, solver: LcpSolver) -> None:
        self.records = Records(system)
        self.work = system.workspace(16)
        self.work.solver.method = solver_method(solver)
        self.clock = allocate(StepClock, {})
        first = min(max(settings.step, limits.shortest), limits.longest)
        self.clock.step = self.clock.recent = self.clock.scaled = first
        self._system, self._settings = system, settings
        self._q, self._u = system.q.copy(), system.u.copy()
        self._memory, self._kept_memory = alpha_memory(system, 16), alpha_memory(system, 16)
        self._kept = backup(system, 16)
        self._rescue = Rescue(solver, settings.tolerance)
        self._several = SeveralMotions()
        self._solving = solver_hooks(self._rescue.solver, system.watch)
        self._advance = link(advance_adaptive, {**system.hooks, **self._solving})

    def loop(self, limits: Limits, last_step: int) -> int:
        """Steps until there are ``last_step`` of them; see ``advance_adaptive``."""
        status: int = self._advance(
            self._system.model,
            self._settings,
            limits,
            self.clock,
            self._q,
            self._u,
            self.work,
            self._memory,
            self._kept,
            self._kept_memory,
            self.records.tape,
            last_step,
        )
        return status

    def remarks(self) -> list[str]:
        """Steps that might have gone another way, or whose contact problem rounding leaves unsolved."""
        name = self._system.contact_name
        return [*self._several.remarks(self.work, name), *self._rescue.remarks(name)]

    def make_room(self, contacts: int) -> None:
        """Larger memory with the same content: a step that is under way goes on."""
        self.work = grown(self._system, self.work, contacts)
        self._memory = larger(self._system, self._memory, contacts)
        self._kept_memory = larger(self._system, self._kept_memory, contacts)
        kept = backup(self._system, contacts)
        copy_parts(self._kept, kept)
        self._kept = kept

    def trouble(self, status: int, time: float) -> str:
        """Why the loop cannot go on; empty where it can after all."""
        return contact_trouble(self.work, self._rescue, status, int(self.clock.number), self._settings.tolerance, time)
