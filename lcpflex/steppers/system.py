"""The mechanics as a stepper takes them: a compiled scene, or a user's own functions behind the same kernels."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from lcpflex.contact.detection import ALL, RIGID, ContactTable, contact_table
from lcpflex.contact.thickness import farthest, pass_thickness
from lcpflex.dynamics.compiled_function import CompiledFunction
from lcpflex.dynamics.compliant_contacts import CompliantContacts, compliant_contacts, sufficient_capacity
from lcpflex.dynamics.inertia import arrow
from lcpflex.dynamics.time_functions import Calls
from lcpflex.dynamics.workspace import Workspace, workspace
from lcpflex.force_laws.history import contact_memory
from lcpflex.force_laws.law import Law
from lcpflex.force_laws.layout import LawRow
from lcpflex.jit.dispatch import Hooks
from lcpflex.jit.kernel import FloatArray
from lcpflex.jit.struct import pack
from lcpflex.model.arrays import Model
from lcpflex.model.planar import N_RIGID
from lcpflex.solvers.contact.memory import ContactData, SolverMemory
from lcpflex.steppers.recorder import Recorder, recorder

__all__ = ["System"]

RECORD_CAPACITY = 256  # instants a recorder holds before the driver empties it


@dataclass(frozen=True, slots=True)
class System:
    """A model with its initial state, and the Python functions that stand in for kernels.

    ``hooks`` maps kernels (supply, forces, detect, ...) to replacements; empty, the run is
    compiled throughout. ``watch`` is told of each contact problem that was solved. ``names``: declared contacts.
    ``laws``: their continuous contact forces, None for rigid ones; empty, all are.
    """

    model: Model
    q: FloatArray
    u: FloatArray
    n_external: int
    hooks: Hooks
    dense: bool
    margin: float
    watch: Callable[[ContactData, SolverMemory], None] | None = None
    names: tuple[str, ...] = ()
    laws: tuple[Law | None, ...] = ()
    soft: tuple[int, ...] = ()  # 1 for each rigid contact that gives way by an elastic law; empty if none does
    functions: tuple[CompiledFunction, ...] = ()  # that the model calls by their addresses
    probe: Callable[[float], FloatArray] | None = None  # forces at the start as a function of time, of a user's system
    contact_modes: tuple[int, ...] = ()  # of each body: how many of its last modes are residual ones of contacts
    calls: Calls | None = None  # of Python functions of time, where there are any
    size: float = 0.0  # extent of the largest body [m]; 0 where bodies are unknown

    def __post_init__(self) -> None:
        object.__setattr__(self, "model", pack(self.model))

    @property
    def n_laws(self) -> int:
        """Number of declared contacts."""
        return len(self.model.contacts.friction)

    def contact_name(self, law: int) -> str:
        """What a text calls a declared contact: its name or, if it has none, its number in the order of declaration."""
        return repr(self.names[law]) if self.names else f"number {law + 1} in the order of declaration"

    @property
    def n_joint(self) -> int:
        """Number of joint rows."""
        return int(self.model.joints.row[-1])

    @property
    def is_compliant(self) -> tuple[int, ...]:
        """1 for each declared contact with a continuous force law, 0 for the others; empty if all are others."""
        return tuple(int(law is not None) for law in self.laws) if any(self.laws) else ()

    @property
    def n_surfaces(self) -> int:
        """Number of surfaces."""
        return len(self.model.contacts.surface_body)

    def table(self, capacity: int, collects: int = RIGID) -> ContactTable:
        """A table for ``capacity`` contacts, for the rigid ones alone."""
        return contact_table(capacity, self.n_surfaces, self.is_compliant, collects if self.is_compliant else ALL)

    def compliant(
        self,
        laws: Sequence[LawRow | None] | None = None,
        capacity: int | None = None,
        before: CompliantContacts | None = None,
    ) -> CompliantContacts:
        """Memory for the contacts with ``laws``, those of the scene if omitted, or more of it than ``before``."""
        bodies, contacts = self.model.bodies, self.model.contacts
        rows = [law.row() if law else None for law in self.laws] or [None] * self.n_laws if laws is None else laws
        if before is None:
            shortening = np.where(np.diff(bodies.shortening_start) > 0, np.diff(bodies.dof) - N_RIGID, 0)
            ndof = len(self.q) if self.dense else 0
            factors = arrow(len(bodies.dof) - 1, len(bodies.stiffness), shortening)
            shared = contact_memory(contacts, rows), np.array(bodies.dof), factors, np.zeros((ndof, ndof))
        else:
            shared = before.history, before.dof, before.arrow, before.dense
        history, dof, factors, dense = shared
        room = sufficient_capacity(contacts, rows) if capacity is None else capacity
        return compliant_contacts(rows, history, dof, self.n_joint, self.n_surfaces, factors, dense, room)

    def workspace(
        self, capacity: int, compliant: CompliantContacts | None = None, solver: SolverMemory | None = None
    ) -> Workspace:
        """Work memory for ``capacity`` simultaneous rigid contacts, beside the compliant ones.

        What the solver knows goes on in ``solver``.
        """
        given = self.compliant() if compliant is None else compliant
        return workspace(self.n_external, self.n_joint, self.table(capacity), given, solver)

    def recorder(self, table_capacity: int, points: int) -> Recorder:
        """An empty recorder."""
        # of contacts that give way, too, a depth is no penetration
        table = contact_table(table_capacity, self.n_surfaces, self.is_compliant or self.soft, ALL)
        contacts = self.model.contacts
        return recorder(
            len(self.q),
            self.n_laws,
            RECORD_CAPACITY,
            points,
            table,
            self.margin,
            pass_thickness(contacts),
            farthest(contacts, self.model.points),
            self._deflection(),
        )

    def _deflection(self) -> FloatArray:
        """How far a mode moves the surfaces of each body."""
        contacts = self.model.contacts
        deflection = np.zeros(max(1, len(self.model.bodies.mass)))
        for body, shapes in zip(contacts.surface_body, contacts.surface_deflection, strict=True):
            if body >= 0:
                deflection[body] = max(deflection[body], shapes.max(initial=0.0))
        return deflection
