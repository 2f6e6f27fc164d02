"""A body from a user's own finite-element matrices."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt

from lcpflex.bodies.body import Body, array_of, named
from lcpflex.bodies.fem.checked_matrices import check_directions, check_free, check_units, symmetric
from lcpflex.bodies.fem.finite_elements import FiniteElements, rigid_motions
from lcpflex.bodies.fem.node_sets import node_numbers
from lcpflex.bodies.reduction.component_modes import free_interface
from lcpflex.bodies.reduction.damping import Damping
from lcpflex.bodies.reduction.interface import Interfaces
from lcpflex.errors import ModelError
from lcpflex.jit.kernel import IntArray

__all__ = ["Matrices"]

RIGID_MOTIONS = ("translation along x", "translation along y", "rotation")


@dataclass(frozen=True, slots=True, eq=False)
class Matrices:
    """A planar unsupported body given by mass and stiffness matrices of a mesh: M d'' + C d' + K d = forces.

    The degrees of freedom are the displacements (x, y) of each node, interleaved: 2 i and 2 i + 1 belong to node i.
    The body must be free-free: no supported nodes, K times a rigid motion is zero. Hold it by joints in the scene.

    Parameters
    ----------
    mass : (2 N, 2 N) symmetric positive definite, sparse or dense [kg]; the same in both directions
    stiffness : (2 N, 2 N) symmetric positive semidefinite with the three rigid motions as its only zero modes [N/m]
    coordinates : (N, 2) places of the nodes in the body frame [m]
    node_sets : name -> one node or a sequence of nodes. A single node is a named point; two nodes or more are a
        surface, a chain in the order given with the solid on its left (counter-clockwise around the body), which is
        closed if its last node is its first again. A set named "outline" is the surface of the body.
    damping : (2 N, 2 N) C, symmetric positive semidefinite [N s/m], or None. Only its part on the elastic modes
        is used: rigid motion is not damped by it.

    Raises
    ------
    ModelError
        For anything else: wrong shapes, NaN, unsymmetric matrices, a mass not positive, supports, unknown nodes.

    Warns
    -----
    ModelWarning
        If waves, as nodes next to each other tell their speed, are beyond any material: a unit is wrong.
    """

    mass: Any
    stiffness: Any
    coordinates: npt.ArrayLike
    node_sets: Mapping[str, int | Sequence[int]] = field(default_factory=dict)
    damping: Any = None

    reduces_to: ClassVar[type[Body]] = Body

    def __post_init__(self) -> None:
        places = array_of("coordinates", self.coordinates, (-1, 2))
        if len(places) < 2 or not np.ptp(places, axis=0).max() > 0.0:
            raise ModelError(f"coordinates: {len(places)} node(s) at one place were given, expected a mesh")
        n = places.size
        mass = symmetric("mass", self.mass, n, "two rows a node")
        stiffness = symmetric("stiffness", self.stiffness, n, "two rows a node")
        check_directions(mass, 2)
        check_free(stiffness, rigid_motions(places - places.mean(axis=0)), RIGID_MOTIONS)
        check_units(mass, stiffness, places)
        sets = {name: _nodes(name, nodes, len(places)) for name, nodes in named("node_sets", self.node_sets).items()}
        checked = {"mass": mass, "stiffness": stiffness, "coordinates": places, "node_sets": sets}
        if self.damping is not None:
            checked["damping"] = symmetric("damping", self.damping, n, "two rows a node")
        for name, value in checked.items():
            object.__setattr__(self, name, value)

    def reduce(
        self,
        modes: int | None = 8,
        damping: Damping | None = None,
        *,
        interfaces: Interfaces = (),
        residual_damping: float | None = None,
    ) -> Body:
        """The body with the ``modes`` lowest free-free modes of the mesh.

        The rotation shape psi of a point is that of the best linear field through the displacements of the node and
        its nearest neighbours: exact for rigid motion and uniform strain.

        Parameters
        ----------
        modes : at most 2 N - 3; None for all, 0 for a rigid body
        damping : damping ratio zeta of all modes, one for each (ascending frequencies), or :class:`Rayleigh`;
            None for the damping matrix of the mesh, no damping if there is none
        interfaces : where joints hold the body, springs or loads act on it, or something strikes it, as for
            :func:`free_interface`: residual modes behind the free ones make the compliance there that of the mesh.
            ``scene.add(mesh, modes=8)`` finds the interfaces itself
        residual_damping : damping ratio of the residual modes; None for that of the others, the last one of several

        Raises
        ------
        ModelError
            For more modes than the mesh has, nodes it does not have, an indefinite matrix, a mechanism, or damping that
            is negative, of the wrong length, or given here as well as by a matrix.
        """
        return free_interface(self, modes, damping=damping, interfaces=interfaces, residual_damping=residual_damping)

    def finite_elements(self) -> FiniteElements:
        """What every reduction starts from."""
        sets: Mapping[str, IntArray] = self.node_sets  # type: ignore[assignment]  # as __post_init__ stored them
        rings = {name: len(nodes) > 2 and bool(nodes[0] == nodes[-1]) for name, nodes in sets.items()}
        places = np.asarray(self.coordinates)
        return FiniteElements(
            mass=self.mass,
            stiffness=self.stiffness,
            damping=self.damping,
            places=places,
            dofs=np.arange(places.size),
            points={name: int(nodes[0]) for name, nodes in sets.items() if len(nodes) == 1},
            sets={name: np.unique(nodes) for name, nodes in sets.items()},
            chains={
                name: (nodes[:-1] if rings[name] else nodes, rings[name])
                for name, nodes in sets.items()
                if len(nodes) > 1
            },
        )


def _nodes(name: str, nodes: int | Sequence[int], count: int) -> IntArray:
    given = node_numbers(f"node_sets[{name!r}]", nodes, count, "a node number or a sequence of them")
    ring = given[:-1] if len(given) > 2 and given[0] == given[-1] else given
    if len(np.unique(ring)) != len(ring):
        raise ModelError(f"node_sets[{name!r}]: a node appears twice, expected a simple chain")
    return given.astype(np.int64)
