"""What can be reduced: a model with a mesh, that says what kind of body it becomes."""

from __future__ import annotations

from typing import Any, NamedTuple, Protocol, TypeVar

from lcpflex.bodies.fem.finite_elements import FiniteElements

__all__ = ["Known", "Made", "Mesh"]

Made = TypeVar("Made")  # Body, or SpatialBody
Made_co = TypeVar("Made_co", covariant=True)


class Mesh(Protocol[Made_co]):
    """What can be reduced: Matrices, Continuum, SolidOfRevolution; in space Solid, SpatialMatrices."""

    @property
    def reduces_to(self) -> type[Made_co]:
        """The kind of body it becomes."""
        ...

    def finite_elements(self) -> FiniteElements:
        """The matrices of the mesh and its named nodes."""
        ...


class Known(NamedTuple):
    """What a body keeps of a model: its mesh, without the functions of the user that chose sets of nodes."""

    mesh: FiniteElements
    reduces_to: Any = None

    def finite_elements(self) -> FiniteElements:
        """The mesh."""
        return self.mesh
