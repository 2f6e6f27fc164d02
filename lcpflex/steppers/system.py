"""The mechanics as a stepper takes them: a compiled scene, or a user's own functions behind the same kernels."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from lcpflex.compiled import FloatArray
from lcpflex.contact.force_law import Law
from lcpflex.dynamics.workspace import Workspace, workspace
from lcpflex.model import Model
from lcpflex.packed import pack
from lcpflex.steppers.tape import Tape, tape

__all__ = ["System"]

RECORD_CAPACITY = 256  # instants a tape holds before the driver empties it


@dataclass(frozen=True, slots=True)
class System:
    """A model with its initial state, and the Python functions that stand in for kernels.

    ``hooks`` maps the names of kernels (supply, forces, detect, ...) to replacements; empty, the run is
    compiled throughout. ``watch`` is told of each contact problem that was solved. ``names``: declared contacts.
    ``laws``: their continuous contact forces, None for those by complementarity; empty, all are.
    """

    model: Model
    q: FloatArray
    u: FloatArray
    n_external: int
    hooks: Mapping[str, Callable[..., Any]]
    dense: bool
    margin: float
    watch: Callable[[Workspace], None] | None = None
    names: tuple[str, ...] = ()
    laws: tuple[Law | None, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "model", pack(self.model))

    @property
    def n_laws(self) -> int:
        """Number of declared contacts."""
        return len(self.model.contacts.friction)

    @property
    def n_joint(self) -> int:
        """Number of joint rows."""
        return int(self.model.joints.row[-1])

    def workspace(self, capacity: int) -> Workspace:
        """Work memory for ``capacity`` simultaneous contacts."""
        bodies = self.model.bodies
        return workspace(
            bodies.dof,
            self.n_external,
            self.n_joint,
            len(bodies.stiffness),
            capacity,
            len(self.model.contacts.surface_body),
            self.dense,
        )

    def tape(self, table_capacity: int, spots: int) -> Tape:
        """An empty tape."""
        surfaces = len(self.model.contacts.surface_body)
        return tape(len(self.q), self.n_laws, RECORD_CAPACITY, spots, table_capacity, surfaces, self.margin)
