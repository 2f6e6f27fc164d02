"""A body from a user's own finite-element matrices."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from lcpflex.bodies.body import Body, Chain, Displacement, MaterialPoint, Outline, array_of, named
from lcpflex.bodies.reduction import (
    Damping,
    check_damping,
    count_of_modes,
    free_modes,
    modal_damping,
    sampled,
    signed,
    skew,
    vanish,
)
from lcpflex.compiled import FloatArray, IntArray
from lcpflex.errors import ModelError, in_range

if TYPE_CHECKING:
    from scipy.sparse import csc_matrix

__all__ = ["Matrices"]

SYMMETRIC = 1e-9  # largest asymmetry relative to the largest entry
RIGID = 1e-8  # largest K times rigid motion relative to |K| |rigid motion|
NEIGHBOURS = 8  # nodes from which the rotation of the material at a node is estimated


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
        sets = {name: _nodes(name, nodes, len(places)) for name, nodes in named("node_sets", self.node_sets).items()}
        checked = {"mass": mass, "stiffness": stiffness, "coordinates": places, "node_sets": sets}
        if self.damping is not None:
            checked["damping"] = _symmetric("damping", self.damping, n)
        for name, value in checked.items():
            object.__setattr__(self, name, value)

    def reduce(self, modes: int | None = 8, damping: Damping | None = None) -> Body:
        """The body with the ``modes`` lowest free-free modes of the mesh.

        The rotation shape psi of a point is that of the best linear field through the displacements of the node and
        its nearest neighbours: exact for rigid motion and uniform strain.

        Parameters
        ----------
        modes : at most 2 N - 3; None for all, 0 for a rigid body
        damping : damping ratio zeta of all modes, one for each (ascending frequencies), or :class:`Rayleigh`;
            None for the damping matrix of the mesh, no damping if there is none

        Raises
        ------
        ModelError
            For more modes than the mesh has, an indefinite matrix, a mechanism, or damping that is negative, of the
            wrong length, or given here as well as by a matrix.
        """
        places = np.asarray(self.coordinates)
        n = count_of_modes(modes, places.size - 3)
        if damping is not None:
            if self.damping is not None:
                raise ModelError(f"damping: {damping!r} was given besides a damping matrix, expected one of the two")
            check_damping(damping, n)
        rigid = _rigid_motions(places)
        omega2, shapes = free_modes(self.mass, self.stiffness, rigid, n, _smooth_fields(places))
        shapes = signed(shapes)
        return self._body(places, rigid, omega2, shapes, damping)

    def _body(
        self, places: FloatArray, rigid: FloatArray, omega2: FloatArray, shapes: FloatArray, damping: Damping | None
    ) -> Body:
        """Inertia integrals: products with the mass matrix."""
        weighed = self.mass @ np.column_stack([rigid, places.ravel(), shapes])
        total = float(rigid[:, 0] @ weighed[:, 0])
        moment = rigid[:, :2].T @ weighed[:, 3]
        second = float(places.ravel() @ weighed[:, 3])
        S = vanish("S", shapes.T @ weighed[:, :2], math.sqrt(total))
        c = vanish("c", shapes.T @ weighed[:, 2], math.sqrt(second))
        turned = np.empty_like(shapes)  # J^T Phi
        turned[0::2] = shapes[1::2]
        turned[1::2] = -shapes[0::2]
        diagonal, cross = self._damping(omega2, shapes, damping)
        nodal = shapes.reshape(len(places), 2, len(omega2))
        material = _material(places, nodal, self.stiffness)
        sets: Mapping[str, IntArray] = self.node_sets  # type: ignore[assignment]  # as __post_init__ stored them
        return Body(
            mass=total,
            inertia=second,
            moment=moment,
            S=S,
            a=shapes.T @ weighed[:, 3],
            c=c,
            stiffness=omega2,
            damping=diagonal,
            coupling=skew(weighed[:, 4:].T @ turned),
            cross_damping=cross,
            points={name: material(int(nodes[0])) for name, nodes in sets.items() if len(nodes) == 1},
            surfaces={name: _chain(nodes, material) for name, nodes in sets.items() if len(nodes) > 1},
            locate=_locator(places, material),
            products=lambda displacement: _products(displacement, places, weighed),
        )

    def _damping(
        self, omega2: FloatArray, shapes: FloatArray, damping: Damping | None
    ) -> tuple[FloatArray, FloatArray | None]:
        """Diagonal and off-diagonal part of the modal damping matrix [1/s]."""
        if self.damping is None:
            return modal_damping(0.0 if damping is None else damping, np.sqrt(omega2)), None
        modal = shapes.T @ (self.damping @ shapes)
        modal = 0.5 * (modal + modal.T)
        diagonal = np.diag(modal).copy()
        if not len(diagonal):
            return diagonal, None
        worst, largest = np.linalg.eigvalsh(modal)[[0, -1]]
        if worst < -1e-9 * max(largest, 0.0) or diagonal.min() < -1e-12 * max(largest, 0.0):
            raise ModelError(f"damping: the matrix feeds energy into the modes ({worst:.6g} 1/s), expected >= 0")
        diagonal = np.maximum(diagonal, 0.0)
        cross = modal - np.diag(np.diag(modal))
        scale = np.sqrt(np.outer(diagonal, diagonal))
        proportional = bool((np.abs(cross) <= 1e-9 * scale + 1e-14 * max(largest, 0.0)).all())
        return diagonal, None if proportional else cross


def _symmetric(name: str, matrix: Any, n: int) -> csc_matrix[Any]:
    """The matrix in compressed columns, exactly symmetric; refuses wrong shapes, NaN and asymmetry."""
    from scipy.sparse import csc_matrix, issparse

    shape = getattr(matrix, "shape", None)
    if not issparse(matrix):
        matrix = array_of(name, matrix, (n, n))
    elif shape != (n, n):
        raise ModelError(f"{name}: a matrix of shape {shape} was given, expected ({n}, {n}), two rows a node")
    try:
        columns = csc_matrix(matrix, dtype=np.float64, copy=True)
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
    rigid = _rigid_motions(places - places.mean(axis=0))
    scale = (abs(stiffness) @ np.abs(rigid)).max(axis=0)
    for name, force, large in zip(names, np.abs(stiffness @ rigid).max(axis=0), scale, strict=True):
        if force > RIGID * large:
            raise ModelError(
                f"stiffness: it resists rigid {name} ({force / large:.3g} of its entries), expected a free-free body: "
                f"leave supports out of the matrices and hold the body by joints in the scene"
            )


def _nodes(name: str, nodes: int | Sequence[int], count: int) -> IntArray:
    given = np.atleast_1d(np.asarray(nodes))
    if given.ndim != 1 or not len(given) or not np.issubdtype(given.dtype, np.integer):
        raise ModelError(f"node_sets[{name!r}]: {nodes!r} was given, expected a node number or a sequence of them")
    if given.min() < 0 or given.max() >= count:
        bad = int(given.min() if given.min() < 0 else given.max())
        raise ModelError(f"node_sets[{name!r}]: node {bad} was given, expected nodes from 0 to {count - 1}")
    ring = given[:-1] if len(given) > 2 and given[0] == given[-1] else given
    if len(np.unique(ring)) != len(ring):
        raise ModelError(f"node_sets[{name!r}]: a node appears twice, expected a simple chain")
    return given.astype(np.int64)


def _rigid_motions(places: FloatArray) -> FloatArray:
    """(2 N, 3) translations and infinitesimal rotation about the origin."""
    rigid = np.zeros((places.size, 3))
    rigid[0::2, 0] = 1.0
    rigid[1::2, 1] = 1.0
    rigid[0::2, 2] = -places[:, 1]
    rigid[1::2, 2] = places[:, 0]
    return rigid


def _smooth_fields(places: FloatArray) -> FloatArray:
    """(2 N, 6) displacements x^2, x y, y^2 along x and along y, about the middle."""
    x, y = (places - places.mean(axis=0)).T / float(np.ptp(places, axis=0).max())
    fields = np.zeros((places.size, 6))
    for k, values in enumerate((x * x, x * y, y * y)):
        fields[0::2, k] = values
        fields[1::2, k + 3] = values
    return fields


def _material(places: FloatArray, nodal: FloatArray, stiffness: csc_matrix[Any]) -> Callable[[int], MaterialPoint]:
    """Node -> material point, with the rotation of the material estimated from its neighbours in the mesh."""

    def material(node: int) -> MaterialPoint:
        columns = slice(stiffness.indptr[2 * node], stiffness.indptr[2 * node + 2])
        linked = np.unique(stiffness.indices[columns] // 2)
        linked = linked[linked != node]
        arms = places[linked] - places[node]
        distance = np.hypot(arms[:, 0], arms[:, 1])
        near = np.argsort(distance, kind="stable")[:NEIGHBOURS]
        moves = nodal[linked[near]] - nodal[node]
        return MaterialPoint(places[node], nodal[node].T.copy(), _rotation(arms[near], moves))

    return material


def _rotation(arms: FloatArray, moves: FloatArray) -> FloatArray:
    """(n,) rotation of the linear field that fits the relative displacements (k, 2, n) at the arms (k, 2)."""
    modes = moves.shape[2]
    if not len(arms) or not modes:
        return np.zeros(modes)
    spread = np.linalg.svd(arms, compute_uv=False)
    if len(spread) < 2 or spread[1] <= 1e-6 * spread[0]:  # all on one line: the rotation of that line
        turning = arms[:, 0, None] * moves[:, 1] - arms[:, 1, None] * moves[:, 0]
        return np.asarray(turning.sum(axis=0) / np.sum(arms**2))
    gradient = np.linalg.lstsq(arms, moves.reshape(len(arms), 2 * modes), rcond=None)[0].reshape(2, 2, modes)
    return np.asarray(0.5 * (gradient[0, 1] - gradient[1, 0]))


def _chain(nodes: IntArray, material: Callable[[int], MaterialPoint]) -> Outline:
    closed = len(nodes) > 2 and nodes[0] == nodes[-1]
    return Chain(tuple(material(int(node)) for node in (nodes[:-1] if closed else nodes)), bool(closed))


def _locator(places: FloatArray, material: Callable[[int], MaterialPoint]) -> Callable[[float, float], MaterialPoint]:
    """The node at (x, y): a mesh given by matrices has no material between its nodes that is known."""
    slack = 1e-9 * float(np.ptp(places, axis=0).max())

    def locate(x: float, y: float) -> MaterialPoint:
        at = (in_range("x", x, -math.inf, math.inf), in_range("y", y, -math.inf, math.inf))
        distance = np.hypot(places[:, 0] - at[0], places[:, 1] - at[1])
        nearest = int(distance.argmin())
        if distance[nearest] > slack:
            near = tuple(float(value) for value in places[nearest])
            raise ModelError(f"x, y: {at} was given, expected the place of a node; node {nearest} at {near} is nearest")
        return material(nearest)

    return locate


def _products(displacement: Displacement, places: FloatArray, weighed: FloatArray) -> FloatArray:
    """<[1_x, 1_y, J x, Phi]^T d> of nodal values d (nodes, 2), with the mass matrix of the mesh."""
    values = sampled(displacement, places)
    if len(values) != len(places):
        raise ModelError(f"displacement: {len(values)} nodal values were given, expected {len(places)}")
    sums = weighed.T @ values.ravel()
    return np.concatenate([sums[:3], sums[4:]])
