"""A body from a user's own finite-element matrices."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from lcpflex.basics import libs
from lcpflex.bodies.body import Body, array_of, named
from lcpflex.bodies.fem.finite_elements import FiniteElements, rigid_motions
from lcpflex.bodies.fem.node_sets import node_numbers
from lcpflex.bodies.reduction.component_modes import free_interface
from lcpflex.bodies.reduction.damping import Damping
from lcpflex.bodies.reduction.interface import Interfaces
from lcpflex.errors import ModelError, ModelWarning
from lcpflex.jit.kernel import FloatArray, IntArray

if TYPE_CHECKING:
    from scipy.sparse import csc_matrix

__all__ = ["Matrices"]

SYMMETRIC = 1e-9  # largest asymmetry relative to the largest entry
SPEEDS = (0.3, 3e5)  # [m/s] of waves: ten times beyond materials, and room for scenes without units
RIGID = 1e-8  # largest K times rigid motion relative to |K| |rigid motion|


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

    def __post_init__(self) -> None:
        places = array_of("coordinates", self.coordinates, (-1, 2))
        if len(places) < 2 or not np.ptp(places, axis=0).max() > 0.0:
            raise ModelError(f"coordinates: {len(places)} node(s) at one place were given, expected a mesh")
        n = places.size
        mass = _symmetric("mass", self.mass, n)
        stiffness = _symmetric("stiffness", self.stiffness, n)
        _check_mass(mass)
        _check_free(stiffness, places)
        _check_units(mass, stiffness, places)
        sets = {name: _nodes(name, nodes, len(places)) for name, nodes in named("node_sets", self.node_sets).items()}
        checked = {"mass": mass, "stiffness": stiffness, "coordinates": places, "node_sets": sets}
        if self.damping is not None:
            checked["damping"] = _symmetric("damping", self.damping, n)
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


def _symmetric(name: str, matrix: Any, n: int) -> csc_matrix[Any]:
    """The matrix in compressed columns, exactly symmetric; refuses wrong shapes, NaN and asymmetry."""
    shape = getattr(matrix, "shape", None)
    if not libs.sparse.issparse(matrix):
        matrix = array_of(name, matrix, (n, n))
    elif shape != (n, n):
        raise ModelError(f"{name}: a matrix of shape {shape} was given, expected ({n}, {n}), two rows a node")
    try:
        columns = libs.sparse.csc_matrix(matrix, dtype=np.float64, copy=True)
    except (TypeError, ValueError) as error:
        raise ModelError(f"{name}: expected a matrix of real numbers ({error})") from None
    if not np.isfinite(columns.data).all():
        bad = columns.data[~np.isfinite(columns.data)][0]
        raise ModelError(f"{name}: a matrix with {bad} in it was given, expected finite numbers only")
    size = float(np.abs(columns.data).max(initial=0.0))
    apart = float(abs(columns - columns.T).max()) if size else 0.0
    if apart > SYMMETRIC * size:
        raise ModelError(f"{name}: the matrix is unsymmetric by {apart / size:.3g} of its largest entry, expected 0")
    even = (0.5 * (columns + columns.T)).tocsc()
    even.eliminate_zeros()
    even.sort_indices()
    return even


def _check_mass(mass: csc_matrix[Any]) -> None:
    """Mass must be positive and the same in x and y: a body falls alike in every attitude."""
    diagonal = mass.diagonal()
    if not diagonal.min() > 0.0:
        raise ModelError(f"mass: {diagonal.min():.6g} on its diagonal, expected a positive definite matrix")
    size = float(diagonal.max())
    along, across = mass[0::2, 0::2], mass[1::2, 1::2]
    if abs(along - across).max() > SYMMETRIC * size or abs(mass[0::2, 1::2]).max() > SYMMETRIC * size:
        raise ModelError("mass: it depends on the direction, expected equal x and y parts and no coupling between them")


def _check_free(stiffness: csc_matrix[Any], places: FloatArray) -> None:
    """K times each rigid motion must vanish."""
    names = ("translation along x", "translation along y", "rotation")
    rigid = rigid_motions(places - places.mean(axis=0))
    scale = (abs(stiffness) @ np.abs(rigid)).max(axis=0)
    for name, force, large in zip(names, np.abs(stiffness @ rigid).max(axis=0), scale, strict=True):
        if force > RIGID * large:
            raise ModelError(
                f"stiffness: it resists rigid {name} ({force / large:.3g} of its entries), expected a free-free body: "
                f"leave supports out of the matrices and hold the body by joints in the scene"
            )


def _check_units(mass: csc_matrix[Any], stiffness: csc_matrix[Any], places: FloatArray) -> None:
    """Warn of waves that no material has: c = h sqrt(K_ii / M_ii) / 2 to a factor of about 2, h to the next node."""
    linked = stiffness.tocoo()
    node, other = linked.row // 2, linked.col // 2
    arms = places[node] - places[other]
    distance = np.where(node == other, np.inf, np.hypot(arms[:, 0], arms[:, 1]))
    near = np.full(len(places), np.inf)
    np.minimum.at(near, node, distance)
    rate = np.sqrt(np.maximum(stiffness.diagonal()[0::2], 0.0) / mass.diagonal()[0::2])
    known = np.isfinite(near) & (near > 0.0)
    found = 0.5 * near[known] * rate[known]
    speed = float(np.median(found)) if len(found) else SPEEDS[0]
    if not SPEEDS[0] <= speed <= SPEEDS[1]:
        warnings.warn(
            f"stiffness, mass, coordinates: waves run at about {speed:.2g} m/s, which no material has: expected "
            "N/m, kg and m (of matrices in N, mm and t: a thousand times each, and coordinates by a thousand)",
            ModelWarning,
            stacklevel=4,
        )


def _nodes(name: str, nodes: int | Sequence[int], count: int) -> IntArray:
    given = node_numbers(f"node_sets[{name!r}]", nodes, count, "a node number or a sequence of them")
    ring = given[:-1] if len(given) > 2 and given[0] == given[-1] else given
    if len(np.unique(ring)) != len(ring):
        raise ModelError(f"node_sets[{name!r}]: a node appears twice, expected a simple chain")
    return given.astype(np.int64)
