"""The mechanics as a stepper takes them: a compiled scene, or a user's own functions behind the same kernels."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from lcpflex.contact.detection import ALL, RIGID, ContactTable
from lcpflex.contact.rule_pairs import RulePairs, give_laws, make_room, rule_pairs
from lcpflex.contact.table import room_in_space, table_maker
from lcpflex.contact.thickness import farthest, surface_thickness, thinnest
from lcpflex.dynamics.compiled_function import CompiledFunction
from lcpflex.dynamics.compliant_contacts import CompliantContacts, compliant_contacts, sufficient_capacity
from lcpflex.dynamics.inertia import model_factors
from lcpflex.dynamics.joint_factor import JointPattern, joint_pattern
from lcpflex.dynamics.reaction_memory import Reactions, reactions
from lcpflex.dynamics.time_functions import Calls
from lcpflex.dynamics.workspace import Workspace, workspace
from lcpflex.force_laws.history import contact_memory
from lcpflex.force_laws.law import Law
from lcpflex.force_laws.layout import LawRow
from lcpflex.jit.dispatch import Hooks
from lcpflex.jit.kernel import FloatArray
from lcpflex.jit.leaf import load_space
from lcpflex.jit.struct import pack, put_array
from lcpflex.model.arrays import Model
from lcpflex.model.layout import is_spatial
from lcpflex.solvers.contact.memory import ContactData, SolverMemory
from lcpflex.steppers.rates import rates
from lcpflex.steppers.recorder import Recorder, recorder

__all__ = ["System"]

RECORD_CAPACITY = 256  # instants a recorder holds before the driver empties it
SENSED_CAPACITY = 1024  # the same where sensors are measured on them, which costs as much for few as for many
LEAST_INSTANTS, RECORD_WORDS = 8, 1 << 19  # of many contacts fewer, about so many in all
TOUCHING = 5e-9  # of the margin: gaps up to that touch where no force is known, as at the start


@dataclass(frozen=True, slots=True)
class System:
    """A model with its initial state, and the Python functions that stand in for kernels.

    ``hooks`` maps kernels (supply, forces, detect, ...) to replacements; empty, the run is
    compiled throughout. ``watch`` is told of each contact problem that was solved. ``names``: declared contacts.
    ``laws``: their continuous contact forces, None for rigid ones; empty, all are. ``bodies``: names of the bodies.
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
    bodies: tuple[str, ...] = ()
    laws: tuple[Law | None, ...] = ()
    soft: tuple[int, ...] = ()  # 1 for each rigid contact that gives way by an elastic law; empty if none does
    functions: tuple[CompiledFunction, ...] = ()  # that the model calls by their addresses
    probe: Callable[[float], FloatArray] | None = None  # forces at the start as a function of time, of a user's system
    residual_modes: tuple[int, ...] = ()  # of each body that has some for its contacts: how many of its last modes are
    calls: Calls | None = None  # of Python functions of time, where there are any
    size: float = 0.0  # extent of the largest body [m]; 0 where bodies are unknown
    rule_surfaces: tuple[str, ...] = ()  # labels of the surfaces between which a rule holds that is not listed
    pairs: RulePairs | None = None  # of that rule, with a law for each that has touched; made for this system
    intervals: tuple[float, ...] = ()  # between the instants of sensors [s], of each rate but that of the record
    pattern: JointPattern = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        model = pack(self.model)
        pairs = rule_pairs(model.contacts) if self.pairs is None else self.pairs
        object.__setattr__(self, "pattern", joint_pattern(self.model))
        object.__setattr__(self, "model", model)
        object.__setattr__(self, "pairs", pairs)
        give_laws(model.contacts, len(pairs.pair))
        if self.hooks and is_spatial(self.model):
            load_space()

    @property
    def n_laws(self) -> int:
        """Number of declared contacts; with a rule, that law and those of pairs that have touched, or may yet."""
        return len(self.model.contacts.friction)

    def contact_name(self, law: int) -> str:
        """What a text calls a contact: its name or, if it has none, its number in the order of declaration."""
        named = self.names or self.rule_surfaces
        return repr(self.name_of(law)) if named else f"number {law + 1} in the order of declaration"

    def body_name(self, body: int) -> str:
        """What a text calls a body, of a system that has some."""
        return repr(self.bodies[body])

    def name_of(self, law: int) -> str:
        """Name of a declared contact, or of a pair by the rule."""
        if law < len(self.names):
            return self.names[law]
        a, b = self.rule_pairs.pair[law].tolist()
        return f"{self.rule_surfaces[a]}/{self.rule_surfaces[b]}" if a >= 0 else "contact_all"

    @property
    def rule_pairs(self) -> RulePairs:
        """Pairs by the rule that have touched."""
        assert self.pairs is not None
        return self.pairs

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

    def more_laws(self) -> int:
        """Room for twice as many laws; returns their number."""
        laws = 2 * self.n_laws
        make_room(self.rule_pairs, laws)
        give_laws(self.model.contacts, laws)
        return laws

    def take_pairs(self, pairs: RulePairs) -> None:
        """Go on with the pairs of a run that is restored."""
        object.__setattr__(self, "pairs", pairs)
        give_laws(self.model.contacts, len(pairs.pair))

    def table(self, capacity: int, collects: int = RIGID, touching: float = math.inf) -> ContactTable:
        """A table for ``capacity`` contacts, for the rigid ones alone.

        ``touching``: gap up to which a pair of a rule gets a law of its own [m].
        """
        laws = self._by_law(self.is_compliant)
        return self._table(capacity, laws, collects if laws else ALL, self.pairs, touching)

    def held(self, capacity: int) -> ContactTable:
        """A table for entries of others: nothing is detected with it, and copies of it share nothing."""
        return self._table(capacity, self._by_law(self.is_compliant))

    def _table(
        self,
        capacity: int,
        laws: tuple[int, ...],
        collects: int = ALL,
        pairs: RulePairs | None = None,
        touching: float = math.inf,
    ) -> Any:
        make, room = table_maker(is_spatial(self.model)), room_in_space(self.model.contacts)
        return make(capacity, self.n_surfaces, laws, collects, pairs, touching, **room)

    def _by_law(self, values: tuple[int, ...]) -> tuple[int, ...]:
        """With a 0 for the rule and each pair of it."""
        return values + (0,) * (self.n_laws - len(values)) if values else ()

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
            ndof = len(self.u) if self.dense else 0
            arrow = model_factors(self.model)
            shared = contact_memory(contacts, rows), np.array(bodies.dof), arrow, np.zeros((ndof, ndof))
        else:
            shared = before.history, before.rows.dof, before.rows.arrow, before.rows.dense
        history, dof, arrow, dense = shared
        room = sufficient_capacity(contacts, rows) if capacity is None else capacity
        in_space = is_spatial(self.model)
        surfaces = self.n_surfaces, room_in_space(contacts)
        made = compliant_contacts(rows, history, dof, self.pattern, surfaces, arrow, dense, room, in_space)
        self.tell_surfaces(made.rows.table)
        return made

    def workspace(
        self,
        capacity: int,
        compliant: CompliantContacts | None = None,
        before: Workspace | None = None,
        dense: int | None = None,
    ) -> Workspace:
        """Work memory for ``capacity`` simultaneous rigid contacts, beside the compliant ones.

        ``dense``: contacts of the largest island that is solved as one dense problem; all by default. What the solver
        knows in ``before`` goes on, and its compliant contacts where none are given.
        """
        given = compliant or (self.compliant() if before is None else before.compliant)
        room = capacity if dense is None else dense
        return workspace(self.n_external, len(self.q), self.pattern, self.table(capacity), given, room, before)

    def recorder(self, table_capacity: int, points: int) -> Recorder:
        """An empty recorder."""
        # of contacts that give way, too, a depth is no penetration
        laws = self._by_law(self.is_compliant or self.soft)
        table = self._table(table_capacity, laws, ALL, self.pairs, TOUCHING * self.margin)
        self.tell_surfaces(table)
        contacts = self.model.contacts
        thickness = surface_thickness(contacts)
        return recorder(
            len(self.q),
            len(self.u),
            self.n_laws,
            self._capacity(),
            points,
            table,
            self.margin,
            thickness,
            thinnest(contacts, thickness),
            farthest(contacts, self.model.points),
            self._deflection(),
            self.reactions(),
            rates(self.intervals),
        )

    def tell_surfaces(self, table: ContactTable) -> None:
        """Which surface of each contact is the first, and whose: in space a table that forces are summed up by."""
        contacts: Any = self.model.contacts
        if is_spatial(self.model):
            put_array(table, "first", np.array(contacts.law_surface[:, 0]))
            put_array(table, "owner", np.array(contacts.surface_body))

    def _capacity(self) -> int:
        """Instants that a recorder holds."""
        most, words = (SENSED_CAPACITY, len(self.q)) if self.intervals else (RECORD_CAPACITY, 1)
        return max(LEAST_INSTANTS, min(most, RECORD_WORDS // max(self.n_laws, words)))

    def reactions(self) -> Reactions:
        """Memory for the reactions of the joints; a user's own system tells no points that they act at."""
        return reactions(self.model.joints, len(self.model.bodies.dof) - 1, self.size, 1 + len(self.intervals))

    def _deflection(self) -> FloatArray:
        """How far a mode moves the surfaces of each body."""
        contacts = self.model.contacts
        deflection = np.zeros(max(1, len(self.model.bodies.mass)))
        for body, shapes in zip(contacts.surface_body, contacts.surface_deflection, strict=True):
            if body >= 0:
                deflection[body] = max(deflection[body], shapes.max(initial=0.0))
        return deflection
