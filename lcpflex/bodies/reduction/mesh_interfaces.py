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
from lcpflex.bodies.reduction.eigenmodes import FreeMesh
from lcpflex.bodies.reduction.interface import Interface, Interfaces, interfaces_of
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
    place = interface.place
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
    """Static compliance of a whole mesh; its stiffness is factorised when that is first asked for."""

    def __init__(self, mesh: FiniteElements) -> None:
        self._mesh = mesh
        self._known: dict[tuple[float, float], FloatArray] = {}
        self.known: dict[Any, Any] = {}

    @cached_property
    def _free(self) -> FreeMesh:
        return FreeMesh.of(self._mesh)

    @cached_property
    def _near_to(self) -> Callable[[int], IntArray]:
        return neighbours(self._mesh)

    def __getstate__(self) -> dict[str, Any]:
        """Without the factor, which no copy can share."""
        return {name: value for name, value in vars(self).items() if name not in ("_free", "_near_to")}

    def compliance(self, x: float, y: float) -> FloatArray:
        """(3, 3) displacement (x, y) [m] and rotation [rad] at a place by unit forces and a unit moment there."""
        if (x, y) not in self._known:
            loads = displacement_rows(self._mesh, material_weights(self._mesh, x, y), self._near_to)
            found = loads.T @ self._free.flexibility(loads)
            self._known[x, y] = np.asarray(0.5 * (found + found.T))
        return self._known[x, y]

    def enough(self, x: float, y: float, rows: FloatArray, share: float) -> int:
        """0: how many modes miss a share of it is not known without them."""
        return 0
