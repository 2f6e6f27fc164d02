"""A time-stepping scheme at work on a system: its memory, and what is to be said of its contact problems."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from lcpflex.dynamics.workspace import Workspace
from lcpflex.jit.dispatch import link
from lcpflex.jit.kernel import IntArray
from lcpflex.jit.struct import copy_parts
from lcpflex.model.layout import is_spatial
from lcpflex.solvers.contact.operators.sparse_factor import widen
from lcpflex.solvers.problem import LcpSolver
from lcpflex.steppers.cold_islands import give_start
from lcpflex.steppers.driver import Rescue, dense_limit, solver_hooks, solver_method
from lcpflex.steppers.law_run import begin_laws, law_trouble, law_warnings
from lcpflex.steppers.not_finite import not_finite
from lcpflex.steppers.options import CONTINUE, RAISE
from lcpflex.steppers.records import Records
from lcpflex.steppers.several_motions import SeveralMotions
from lcpflex.steppers.shared_loads import shared_loads
from lcpflex.steppers.status import RunStatus
from lcpflex.steppers.system import System
from lcpflex.steppers.unsolved import lagging_remarks, unsolved_large, unsolved_remarks

__all__ = ["FIRST_ROOM", "Support", "TimeStepping", "grown"]

FIRST_ROOM = 16  # contacts


def grown(room: int, needed: int) -> int:
    """Twice what is needed, where there is less room than that."""
    return 2 * needed if needed > room else room


def _same(scheme: Any, contacts: int) -> Any:
    return scheme


def _silent(scheme: Any, work: Workspace, steps: int | None) -> list[str]:
    return []


def _nothing(status: int, number: int, scheme: Any, work: Workspace) -> str:
    return ""


@dataclass(frozen=True, slots=True)
class Support:
    """What a run asks of a scheme beside its steps, where it has something to add.

    Attributes
    ----------
    grown
        (scheme, contacts) -> the struct of the scheme with room for more contacts.
    warnings
        (scheme, workspace, steps) -> warnings, of so many steps of one length; None: of steps under error control.
    trouble
        (status, number, scheme, workspace) -> why the run cannot go on, where the scheme alone knows; else empty.
    hint
        What may help where a contact problem is not solved.
    impulsive
        Whether an impact falls on the end of a step.
    """

    grown: Callable[[Any, int], Any] = _same
    warnings: Callable[[Any, Workspace, int | None], list[str]] = _silent
    trouble: Callable[[int, int, Any, Workspace], str] = _nothing
    hint: str = ""
    impulsive: bool = True


class TimeStepping:
    """State and memory of a scheme on a system.

    scheme: a struct as :mod:`lcpflex.steppers.scheme` has it.
    """

    def __init__(
        self,
        system: System,
        scheme: Any,
        solver: LcpSolver,
        support: Support = Support(),
        on_unsolved: str = CONTINUE,
        budget: int | None = None,
    ) -> None:
        self.system, self.scheme, self.support = system, scheme, support
        self.records = Records(system)
        self.work = system.workspace(FIRST_ROOM)
        self.work.impulses.solver.method = solver_method(solver, is_spatial(system.model))
        self.work.impulses.dense_limit = dense_limit(solver)
        self.work.impulses.strict_large = on_unsolved == RAISE
        self._budget = budget
        self._limit_factors()
        begin_laws(system, self.work)
        self.records.indentation = self.work.compliant.history.worst
        self.records.missed_friction = self.work.compliant.missed
        self._rescue = Rescue(solver, scheme.tolerance)
        self._several = SeveralMotions()
        self.solving = solver_hooks(self._rescue, system.watch, is_spatial(system.model))

    def link(self, loop: Callable[..., int]) -> Callable[..., int]:
        """``loop`` with the functions of the system and the solver in place."""
        return link(loop, {**self.system.hooks, **self.solving})

    @property
    def touching(self) -> IntArray:
        """Declared contacts that the last contact problem held."""
        return self.work.rows.table.law[: self.work.rows.n_contacts]

    def make_room(self, contacts: int) -> None:
        """Larger memory with the same content: for ``contacts``, and for the largest island so far.

        Where a sparse factor alone lacks room, or an island wants a start, it gets that, and the step goes on at the
        island that asked for it.
        """
        old = self.work
        if old.impulses.wants_start:
            give_start(old)
            return
        large = len(old.rows.white) > 0 or old.impulses.largest <= old.impulses.dense_limit
        if contacts <= len(old.rows.table.key) and old.impulses.most <= len(old.posed.problem.friction) and large:
            widen(old.impulses.large_solver.op.factor)
            return
        room = grown(len(old.rows.table.key), contacts)
        dense = grown(len(old.posed.problem.friction), old.impulses.most)
        dense = room if self.system.watch else dense  # who is told of problems is told of all
        work = self.work = self.system.workspace(room, before=old, dense=dense)
        held = int(old.impulses.n_held)
        copy_parts(old.rows.table, work.rows.table)  # of a step that has more problems than one
        work.impulses.n_held = held
        work.impulses.held_key[:, :held] = old.impulses.held_key[:, :held]
        work.impulses.held_gap[:, :held] = old.impulses.held_gap[:, :held]
        work.impulses.recalled[:] = old.impulses.recalled
        work.impulses.stopped, work.impulses.unsolved = old.impulses.stopped, old.impulses.unsolved
        work.free.span[:] = old.free.span
        work.impulses.doubtful[:] = old.impulses.doubtful
        work.impulses.doubtful_kind[:], work.impulses.n_doubtful = old.impulses.doubtful_kind, old.impulses.n_doubtful
        self.scheme = self.support.grown(self.scheme, room)
        self._limit_factors()

    def _limit_factors(self) -> None:
        """The budget of the user's for large islands, where there is one; in space, whatever a factor costs."""
        if self._budget is not None:
            self.work.impulses.large_solver.search.factor_limit = self._budget
            if is_spatial(self.system.model):
                self.work.impulses.large_solver.search.operation_limit = math.inf

    def remarks(self, steps: int | None = None) -> list[str]:
        """Warnings of the run so far; of steps of one length, after so many."""
        name = self.system.contact_name
        return [
            *law_warnings(self.system.names, self.work.compliant.history),
            *self.support.warnings(self.scheme, self.work, steps),
            *self._several.remarks(self.work, name),
            *self._rescue.remarks(name),
            *unsolved_remarks(self.records.recorder.counts, steps),
            *lagging_remarks(self.records.recorder.counts, name),
        ]

    def notes(self) -> list[str]:
        """What a reader may want to know of the run so far."""
        return shared_loads(self.system.model, self.work, self.system.contact_name)

    def trouble(self, status: int, number: int, time: float) -> str:
        """Why a loop that returned ``status`` cannot go on at ``time`` [s]; empty where it can after all."""
        if status == RunStatus.GROW_FACTOR:
            widen(self.work.impulses.large_solver.apart)
            return ""
        words = self.support.trouble(status, number, self.scheme, self.work)
        if words:
            return words
        if status == RunStatus.OUT_OF_RANGE:
            return law_trouble(self.system.names, self.work)
        if status in (RunStatus.SOLVER_FAILED, RunStatus.NOT_FINITE) and (named := not_finite(self.system, self.work)):
            return f"{RunStatus(status).sentence} ({named})"
        if status == RunStatus.SOLVER_FAILED and self.work.impulses.unsolved_large:
            return unsolved_large(self.work, self.scheme.tolerance) + self.support.hint
        if status == RunStatus.SOLVER_FAILED:
            if self._rescue(self.work, time):
                return ""
            return self._rescue.unsolved(self.work, number, self.scheme.tolerance) + self.support.hint
        return RunStatus(status).sentence
