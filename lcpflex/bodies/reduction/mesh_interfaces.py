"""Residual modes of meshes: unit forces and moments at interfaces as nodal loads, and the compliance of the whole mesh.

The rotation of the material at a node is a linear function of the displacements about it, psi = b^T d, so that a unit
moment there is the load b: work is displacement times force, and rotation times moment.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Any

import numpy as np

from lcpflex.bodies.fem.finite_elements import FiniteElements
from lcpflex.bodies.fem.nodal_material import Nodes, displacement_rows, material_weights, neighbours, nodes_at
from lcpflex.bodies.fem.node_sets import chosen_nodes
from lcpflex.bodies.reduction.eigenmodes import Elastic, FreeMesh
from lcpflex.bodies.reduction.interface import Interface, Interfaces, interfaces_of
from lcpflex.bodies.reduction.kept_factor import KeptMesh, free_mesh
from lcpflex.errors import ModelError, shown
from lcpflex.jit.kernel import FloatArray, IntArray

__all__ = ["MeshStatics", "interface_loads", "of_mesh"]


def interface_loads(mesh: FiniteElements, interfaces: Sequence[Interface]) -> FloatArray:
    """(f, k) unit loads of the interfaces: forces, and a moment at a point that has one.

    A named set of several nodes has a force at each of them, and no moment.

    Raises
    ------
    ModelError
        For names, nodes and places that the mesh does not have.
    """
    columns = []
    near_to = neighbours(mesh)
    for k, interface in enumerate(interfaces):
        places = _places(mesh, f"interfaces[{k}]", interface)
        for place in places:
            loads = displacement_rows(mesh, place, near_to)
            if interface.forces:
                along = np.eye(2) if interface.along is None else np.array(interface.along)[:, None]
                columns.append(loads[:, :2] @ along)
            if interface.moment and len(places) == 1:
                columns.append(loads[:, 2:])
    every = np.hstack(columns) if columns else np.zeros((len(mesh.dofs), 0))
    return np.asarray(every[:, np.abs(every).any(axis=0)])  # none across an axis of symmetry


def _places(mesh: FiniteElements, name: str, interface: Interface) -> list[Nodes]:
    """The nodes of an interface, one by one, or the material between nodes."""
    place: Any = interface.place
    if isinstance(place, tuple):
        x, y = place
        return [nodes_at(mesh, name, (x, y))]
    if isinstance(place, float):
        raise ModelError(f"{name}: {shown(place)} was given, expected a name, a place (x, y) or the number of a node")
    return [(np.array([node]), np.ones(1)) for node in chosen_nodes(mesh, name, place)]


def of_mesh(given: Interfaces) -> tuple[Interface, ...]:
    """The interfaces that were given. Nodes by their numbers are contact nodes, on which forces act and no moments."""
    return interfaces_of(given, lambda one: Interface(one, moment=not isinstance(one, int | np.integer)))


class MeshStatics:
    """Static compliance of a whole mesh; its stiffness is factorised when that is first asked for.

    loads : place -> (f, 3) or (f, 6) unit forces and moments there; None: in the plane, at a place (x, y)
    of_surfaces : whether scenes ask for that of single nodes of a surface that touches. In space they ask it of bodies
        that they have reduced themselves alone: what a node gives way grows as the mesh gets finer (Boussinesq), and of
        a face that rests on many nodes it tells nothing
    """

    of_surfaces = False

    def __init__(self, mesh: Elastic, loads: Callable[..., FloatArray] | None = None) -> None:
        self._mesh = mesh
        self._loads = _PlanarLoads(mesh) if loads is None and isinstance(mesh, FiniteElements) else loads
        self._known: dict[Any, FloatArray] = {}
        self.known: dict[Any, Any] = {}

    @cached_property
    def _free(self) -> FreeMesh:
        return free_mesh(self._mesh)

    def __getstate__(self) -> dict[str, Any]:
        """Without the factor, which no copy can share."""
        return {name: value for name, value in vars(self).items() if name != "_free"}

    def compliance(self, *place: Any) -> FloatArray:
        """(3, 3), in space (6, 6): displacement [m] and rotation [rad] at a place by unit forces and moments there.

        place: x, y; in space the place of an :class:`Interface`.
        """
        if place not in self._known:
            free = self._free
            shared = free.compliances if isinstance(free, KeptMesh) else self._known  # of all bodies of the mesh
            if place not in shared:
                assert self._loads is not None
                loads = self._loads(*place)
                found = loads.T @ free.flexibility(loads)
                shared[place] = np.asarray(0.5 * (found + found.T))
            self._known[place] = shared[place]
        return self._known[place]

    def enough(self, place: tuple[Any, ...], rows: FloatArray, share: float) -> int:
        """0: how many modes miss a share of it is not known without them."""
        return 0


class _PlanarLoads:
    """Unit forces and a unit moment at places of a planar mesh."""

    def __init__(self, mesh: FiniteElements) -> None:
        self._mesh = mesh

    @cached_property
    def _near_to(self) -> Callable[[int], IntArray]:
        return neighbours(self._mesh)

    def __getstate__(self) -> dict[str, Any]:
        """Without what can be made again."""
        return {name: value for name, value in vars(self).items() if name != "_near_to"}

    def __call__(self, x: float, y: float) -> FloatArray:
        """(f, 3)."""
        return displacement_rows(self._mesh, material_weights(self._mesh, x, y), self._near_to)
