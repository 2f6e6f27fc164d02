"""Moreau-Jean time stepping with step control: the halves of :mod:`lcpflex.steppers.moreau_jean.step` in a loop."""

from __future__ import annotations

import math

from lcpflex.dynamics.contact_forces_history import update_history
from lcpflex.dynamics.workspace import Workspace
from lcpflex.jit.dispatch import link
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.jit.struct import allocate
from lcpflex.model.arrays import Model
from lcpflex.solvers.problem import LcpSolver
from lcpflex.steppers.adaptive import (
    Backup,
    Limits,
    accept,
    add_differences,
    after_impact,
    after_rejection,
    backup,
    doubling_error,
    end_there,
    next_length,
    position_tolerance,
    put_back,
    put_by,
    threshold,
    unmet,
)
from lcpflex.steppers.clock import StepClock
from lcpflex.steppers.driver import Rescue, solver_hooks, solver_method
from lcpflex.steppers.law_run import begin_laws, law_trouble, law_warnings
from lcpflex.steppers.moreau_jean.step import Settings, grown, record, spots_of, whole_step
from lcpflex.steppers.recorder import Tape
from lcpflex.steppers.run import Records
from lcpflex.steppers.several_motions import SeveralMotions
from lcpflex.steppers.status import RunStatus
from lcpflex.steppers.stepping_run import contact_trouble
from lcpflex.steppers.system import System
from lcpflex.steppers.unmet import closed_pairs, first_unmet

__all__ = ["ControlledMoreauJean"]


@kernel
def advance_adaptive(
    model: Model,
    settings: Settings,
    limits: Limits,
    clock: StepClock,
    q: FloatArray,
    u: FloatArray,
    work: Workspace,
    kept: Backup,
    tape: Tape,
    last_step: int,
) -> int:
    """Steps until their number reaches ``last_step`` or the duration is reached; DONE, or what is missing."""
    while True:
        t = clock.time
        ended = t >= limits.duration
        if clock.due <= t or (ended and clock.due < math.inf):
            if tape.n_instants >= len(tape.times) or tape.n_points + spots_of(work) > len(tape.spots):
                return RunStatus.TAPE_FULL
            clock.number = record(model, clock.recent, t, q, u, work, tape)
            if clock.number > len(tape.table.key):
                return RunStatus.GROW_TAPE
            clock.due = math.inf if ended else t + limits.interval
        if ended or clock.steps >= last_step:
            return RunStatus.DONE
        h = next_length(model, limits, clock)
        alone = h <= limits.shortest  # not controlled
        put_by(q, u, work, tape, kept)
        status: int = RunStatus.DONE
        for part in range(3):
            if alone and part > 0:
                break
            if part < 2:
                work.stopped = clock.stopped  # what a trial has stopped counts for nothing
            length = h if alone or part == 0 else 0.5 * h
            now = t + length if part == 2 else t
            trial = not alone and part == 0
            scaled = Settings(
                length, settings.theta, settings.activation, settings.gap_tolerance, settings.projection,
                settings.tolerance, threshold(limits, clock),
            )  # fmt: skip
            status = whole_step(
                model, scaled, now, kept.long_q if trial else q, kept.long_u if trial else u, work, tape, clock
            )
            if status != RunStatus.DONE:
                break
            if trial:
                put_back(q, u, work, tape, kept)
        error = math.inf
        closing = (0.0, 0.0, 0.0)
        if status == RunStatus.DONE:
            error = 0.0 if alone else doubling_error(limits, q, u, kept)
        if error <= 1.0 and not alone:
            share = first_unmet(model, h, q, u, settings.gap_tolerance, work, tape, kept)
            if share < 0.0:
                put_back(q, u, work, tape, kept)
                clock.number = -share
                return RunStatus.GROW_TAPE
            if (1.0 - share) * h > limits.shortest:
                put_back(q, u, work, tape, kept)
                end_there(limits, clock, h, share)
                continue
        if error <= 1.0:
            closing = closed_pairs(model, q, u, settings.gap_tolerance, work, tape, kept)
        if error <= 1.0 and not alone:
            # one that has gone far beyond what it closed with
            late = max(closing[0] - clock.deepest, unmet(model, q, work.compliant, tape.table))
            error = max(error, late / position_tolerance(limits, q))
        if status == RunStatus.GROW or (alone and status != RunStatus.DONE):
            if status != RunStatus.NOT_FINITE:
                put_back(q, u, work, tape, kept)
            return status
        if not error <= 1.0:
            put_back(q, u, work, tape, kept)
            after_rejection(limits, clock, h, error)
            continue
        if not alone:
            add_differences(q, u, kept, tape)
        accept(limits, clock, h, error, alone, closing[0])
        clock.stopped = work.stopped
        after_impact(limits, clock, closing[1], closing[2] * limits.shortest / h, alone)
        if not update_history(model, clock.time, q, u, 0.0, False, work.compliant.states, work):
            return RunStatus.OUT_OF_RANGE


class ControlledMoreauJean:
    """A Moreau-Jean run's state and memory, with step control."""

    def __init__(self, system: System, settings: Settings, limits: Limits, solver: LcpSolver) -> None:
        self.records = Records(system)
        self.work = system.workspace(16)
        self.work.solver.method = solver_method(solver)
        begin_laws(system, self.work)
        self.records.indentation = self.work.compliant.history.worst
        self.records.missed_friction = self.work.compliant.missed
        self.clock = allocate(StepClock, {})
        self.clock.step = self.clock.recent = min(max(settings.step, limits.shortest), limits.longest)
        self._system, self._settings = system, settings
        self._q, self._u = system.q.copy(), system.u.copy()
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
            self._kept,
            self.records.tape,
            last_step,
        )
        return status

    def remarks(self) -> list[str]:
        """Contacts out of the range of their laws or off them, steps that might have gone another way."""
        names = self._system.names
        return [
            *law_warnings(names, self.work.compliant.history),
            *self._several.remarks(self.work, self._system.contact_name),
            *self._rescue.remarks(self._system.contact_name),
        ]

    def make_room(self, contacts: int) -> None:
        """Larger memory; between steps nothing needs to be kept of what undoes one."""
        self.work = grown(self._system, self.work, contacts)
        self._kept = backup(self._system, contacts)

    def trouble(self, status: int, time: float) -> str:
        """Why the loop cannot go on; empty where it can after all."""
        if status == RunStatus.OUT_OF_RANGE:
            return law_trouble(self._system.names, self.work)
        return contact_trouble(self.work, self._rescue, status, int(self.clock.number), self._settings.tolerance, time)
