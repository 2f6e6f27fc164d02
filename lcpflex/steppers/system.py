"""The mechanics as a stepper takes them: a compiled scene, or a user's own functions behind the same kernels."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from lcpflex.contact.detection import ALL, SET_VALUED, ContactTable, contact_table
from lcpflex.contact.thickness import farthest, pass_thickness
from lcpflex.dynamics.compiled_function import CompiledFunction
from lcpflex.dynamics.law_memory import LawContacts, law_contacts
from lcpflex.dynamics.time_functions import Calls
from lcpflex.dynamics.workspace import Workspace, workspace
from lcpflex.force_laws.law import Law
from lcpflex.jit.dispatch import Hooks
from lcpflex.jit.kernel import FloatArray
from lcpflex.jit.struct import pack
from lcpflex.model.arrays import Model
from lcpflex.model.planar import N_RIGID
from lcpflex.solvers.contact.memory import ContactData, SolverMemory
from lcpflex.steppers.recorder import Tape, tape

__all__ = ["System"]

RECORD_CAPACITY = 256  # instants a tape holds before the driver empties it


@dataclass(frozen=True, slots=True)
class System:
    """A model with its initial state, and the Python functions that stand in for kernels.

    ``hooks`` maps kernels (supply, forces, detect, ...) to replacements; empty, the run is
    compiled throughout. ``watch`` is told of each contact problem that was solved. ``names``: declared contacts.
    ``laws``: their continuous contact forces, None for those by complementarity; empty, all are.
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
    soft: tuple[int, ...] = ()  # 1 for each set-valued contact that gives way by an elastic law; empty if none does
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
    def by_law(self) -> tuple[int, ...]:
        """1 for each declared contact with a continuous force law, 0 for the others; empty if all are others."""
        return tuple(int(law is not None) for law in self.laws) if any(self.laws) else ()

    @property
    def n_surfaces(self) -> int:
        """Number of surfaces."""
        return len(self.model.contacts.surface_body)

    def table(self, capacity: int, collects: int = SET_VALUED) -> ContactTable:
        """A table for ``capacity`` contacts, for the set-valued ones alone."""
        return contact_table(capacity, self.n_surfaces, self.by_law, collects if self.by_law else ALL)

    def law_contacts(self) -> LawContacts:
        """Memory for the contacts by law."""
        rows = [law.row() if law else None for law in self.laws] or [None] * self.n_laws
        return law_contacts(self.model.contacts, rows, self.model.bodies.dof, self.n_joint, self.n_surfaces)

    def workspace(
        self, capacity: int, laws: LawContacts | None = None, solver: SolverMemory | None = None
    ) -> Workspace:
        """Work memory for ``capacity`` simultaneous contacts.

        What those by law remember goes on in ``laws``, and what the solver knows in ``solver``.
        """
        bodies = self.model.bodies
        return workspace(
            bodies.dof,
            self.n_external,
            self.n_joint,
            len(bodies.stiffness),
            self.table(capacity),
            self.law_contacts() if laws is None else laws,
            self.dense,
            np.where(np.diff(bodies.shortening_start) > 0, np.diff(bodies.dof) - N_RIGID, 0),
            solver,
        )

    def tape(self, table_capacity: int, spots: int) -> Tape:
        """An empty tape."""
        # of contacts that give way, too, a depth is no penetration
        table = contact_table(table_capacity, self.n_surfaces, self.by_law or self.soft, ALL)
        contacts = self.model.contacts
        return tape(
            len(self.q),
            self.n_laws,
            RECORD_CAPACITY,
            spots,
            table,
            self.margin,
            pass_thickness(contacts),
            farthest(contacts, self.model.points),
            self._sway(),
        )

    def _sway(self) -> FloatArray:
        """How far a mode moves the surfaces of each body."""
        contacts = self.model.contacts
        sway = np.zeros(max(1, len(self.model.bodies.mass)))
        for body, shapes in zip(contacts.surface_body, contacts.surface_sway, strict=True):
            if body >= 0:
                sway[body] = max(sway[body], shapes.max(initial=0.0))
        return sway
