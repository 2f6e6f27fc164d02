"""A time-stepping scheme at work on a system: its memory, and what is to be said of its contact problems."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from lcpflex.dynamics.workspace import Workspace
from lcpflex.jit.dispatch import link
from lcpflex.jit.kernel import IntArray
from lcpflex.solvers.problem import LcpSolver
from lcpflex.steppers.driver import Rescue, solver_hooks, solver_method
from lcpflex.steppers.law_run import begin_laws, law_trouble, law_warnings
from lcpflex.steppers.records import Records
from lcpflex.steppers.several_motions import SeveralMotions
from lcpflex.steppers.status import RunStatus
from lcpflex.steppers.step_error import carried
from lcpflex.steppers.system import System

__all__ = ["Support", "TimeStepping"]


def _same(scheme: Any, contacts: int) -> Any:
    return scheme


def _silent(scheme: Any, work: Workspace, steps: int) -> list[str]:
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
    carried
        (workspace) -> what a step takes over from the one before: arrays and structs.
    warnings
        (scheme, workspace, steps) -> warnings, of so many steps of one length.
    trouble
        (status, number, scheme, workspace) -> why the run cannot go on, where the scheme alone knows; else empty.
    hint
        What may help where a contact problem is not solved.
    impulsive
        Whether an impact falls on the end of a step.
    """

    grown: Callable[[Any, int], Any] = _same
    carried: Callable[[Workspace], tuple[Any, ...]] = carried
    warnings: Callable[[Any, Workspace, int], list[str]] = _silent
    trouble: Callable[[int, int, Any, Workspace], str] = _nothing
    hint: str = ""
    impulsive: bool = True


class TimeStepping:
    """State and memory of a scheme on a system.

    scheme: a struct as :mod:`lcpflex.steppers.scheme` has it.
    """

    def __init__(self, system: System, scheme: Any, solver: LcpSolver, support: Support = Support()) -> None:
        self.system, self.scheme, self.support = system, scheme, support
        self.records = Records(system)
        self.work = system.workspace(16)
        self.work.solver.method = solver_method(solver)
        begin_laws(system, self.work)
        self.records.indentation = self.work.compliant.history.worst
        self.records.missed_friction = self.work.compliant.missed
        self._rescue = Rescue(solver, scheme.tolerance)
        self._several = SeveralMotions()
        self.solving = solver_hooks(self._rescue.solver, system.watch)

    def link(self, loop: Callable[..., int]) -> Callable[..., int]:
        """``loop`` with the functions of the system and the solver in place."""
        return link(loop, {**self.system.hooks, **self.solving})

    @property
    def touching(self) -> IntArray:
        """Declared contacts that the last contact problem held."""
        return self.work.table.law[: self.work.n_contacts]

    def make_room(self, contacts: int) -> None:
        """Larger memory with the same content."""
        old = self.work
        work = self.work = self.system.workspace(contacts, old.compliant, old.solver)
        held = int(old.n_held)
        work.n_held = held
        work.held_key[:, :held] = old.held_key[:, :held]
        work.held_gap[:, :held] = old.held_gap[:, :held]
        work.stopped = old.stopped
        work.span[:] = old.span
        work.doubtful[:] = old.doubtful
        work.n_doubtful, work.doubtful_kind = old.n_doubtful, old.doubtful_kind
        self.scheme = self.support.grown(self.scheme, contacts)

    def remarks(self, steps: int | None = None) -> list[str]:
        """Warnings of the run so far; of steps of one length, after so many."""
        name = self.system.contact_name
        return [
            *law_warnings(self.system.names, self.work.compliant.history),
            *(self.support.warnings(self.scheme, self.work, steps) if steps is not None else []),
            *self._several.remarks(self.work, name),
            *self._rescue.remarks(name),
        ]

    def trouble(self, status: int, number: int, time: float) -> str:
        """Why a loop that returned ``status`` cannot go on at ``time`` [s]; empty where it can after all."""
        words = self.support.trouble(status, number, self.scheme, self.work)
        if words:
            return words
        if status == RunStatus.OUT_OF_RANGE:
            return law_trouble(self.system.names, self.work)
        if status == RunStatus.SOLVER_FAILED:
            if self._rescue(self.work, time):
                return ""
            return self._rescue.unsolved(self.work, number, self.scheme.tolerance) + self.support.hint
        return RunStatus(status).sentence
