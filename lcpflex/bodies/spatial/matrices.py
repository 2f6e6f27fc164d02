"""A body of space from the finite-element matrices of a solid."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
import numpy.typing as npt

from lcpflex.basics.arguments import array_of, mapping_of, sequence_of, unknown
from lcpflex.bodies.fem.checked_matrices import check_directions, check_free, check_units, symmetric
from lcpflex.bodies.fem.node_sets import node_numbers
from lcpflex.bodies.reduction.again import reduction_by
from lcpflex.bodies.reduction.damping import Damping, check_damping
from lcpflex.bodies.reduction.eigenmodes import rank_of
from lcpflex.bodies.reduction.mesh_body import NO_RESIDUAL, Residual
from lcpflex.bodies.spatial.bases import boundary_basis, elastic_count, free_basis, given_basis
from lcpflex.bodies.spatial.body import SpatialBody
from lcpflex.bodies.spatial.elastic import ElasticMesh, Integrals, PointOperator, Surface, load_columns
from lcpflex.bodies.spatial.flexible import check_deformation, flexible_body
from lcpflex.bodies.spatial.nodes import NodePoints
from lcpflex.errors import ModelError, ModelWarning, in_range
from lcpflex.jit.kernel import FloatArray, IntArray

if TYPE_CHECKING:
    from scipy.sparse import csc_matrix

__all__ = ["SpatialMatrices"]

NodeChoice: TypeAlias = str | int | Sequence[str] | Sequence[int] | npt.NDArray[np.integer]
RIGID_MOTIONS = ("translation along x", "translation along y", "translation along z",
                 "rotation about x", "rotation about y", "rotation about z")  # fmt: skip


@dataclass(frozen=True, slots=True, eq=False)
class SpatialMatrices:
    """A solid body given by mass and stiffness matrices of its mesh: M d'' + C d' + K d = forces.

    The degrees of freedom are the displacements (x, y, z) of each node, interleaved: 3 i, 3 i + 1, 3 i + 2 belong to
    node i. The body must be free-free: K times a rigid motion is zero. The mass must be the consistent one of solid
    elements whose geometry is in their own space (isoparametric ones): all inertia integrals are products with it, and
    so exact. Row sums (lumping) make the moments of inertia of coarse meshes too large, by 31 % for 6 x 3 x 2 cubic
    elements.

    Parameters
    ----------
    mass : (3 N, 3 N) symmetric positive definite, sparse or dense [kg]; the same in all directions
    stiffness : (3 N, 3 N) symmetric positive semidefinite with the six rigid motions as its only zero modes [N/m]
    coordinates : (N, 3) places of the nodes [m]
    node_sets : name -> one node or a sequence of nodes: points of the body. A joint on a set (the rim of a hole, a
        face) moves with the mean of its nodes, one on a single node with the best linear field around it
    damping : (3 N, 3 N) C, symmetric positive semidefinite [N s/m], or None
    triangles : (T, 3) nodes of the triangles of the surface, counter-clockwise seen from outside: for pictures

    Raises
    ------
    ModelError
        For anything else: wrong shapes, NaN, unsymmetric matrices, a mass not positive, supports, unknown nodes.

    Warns
    -----
    ModelWarning
        If waves, as nodes next to each other tell their speed, are beyond any material: a unit is wrong. And for a
        diagonal mass matrix, which is lumped.
    """

    mass: Any
    stiffness: Any
    coordinates: npt.ArrayLike
    node_sets: Mapping[str, int | Sequence[int]] = field(default_factory=dict)
    damping: Any = None
    triangles: npt.ArrayLike | None = None

    def __post_init__(self) -> None:
        places = array_of("coordinates", self.coordinates, (-1, 3))
        _check_spread(places)
        n = places.size
        layout = "three rows a node"
        mass = symmetric("mass", self.mass, n, layout)
        stiffness = symmetric("stiffness", self.stiffness, n, layout)
        check_directions(mass, 3)
        _check_lumped(mass)
        check_free(stiffness, _rigid_motions(places - places.mean(axis=0)), RIGID_MOTIONS)
        check_units(mass, stiffness, places)
        sets = {
            name: node_numbers(f"node_sets[{name!r}]", nodes, len(places), "a node number or a sequence of them")
            for name, nodes in mapping_of("node_sets", self.node_sets).items()
        }
        for name, nodes in sets.items():
            if len(np.unique(nodes)) != len(nodes):
                raise ModelError(f"node_sets[{name!r}]: a node appears twice, expected each once")
        checked = {"mass": mass, "stiffness": stiffness, "coordinates": places, "node_sets": sets}
        if self.damping is not None:
            checked["damping"] = symmetric("damping", self.damping, n, layout)
        if self.triangles is not None:
            checked["triangles"] = _triangles(self.triangles, len(places))
        for name, value in checked.items():
            object.__setattr__(self, name, value)

    def reduce(
        self,
        modes: int | None = 8,
        damping: Damping | None = None,
        *,
        interfaces: Sequence[NodeChoice] = (),
        boundary: NodeChoice | None = None,
        clamped: NodeChoice | None = None,
        basis: npt.ArrayLike | None = None,
        second_order: int | None = None,
        residual_damping: float | None = None,
        deformation: str = "linear",
    ) -> SpatialBody:
        """The body with a few modes of the mesh.

        Without more: the lowest free-free modes, in the mean frame, whose origin is **moved to the mass centre**:
        ``body.origin`` is its place in the coordinates of the mesh. Frequencies are those of the mesh or above them,
        mass and inertia are exact.

        Parameters
        ----------
        modes : how many, at most 3 N - 6; None for all, 0 for a rigid body. With ``boundary``: of the mesh held there.
            With ``basis`` it is not used
        damping : damping ratio zeta of all modes, one for each (ascending frequencies), or :class:`Rayleigh`;
            None for the damping matrix of the mesh, no damping if there is none
        interfaces : where joints, springs or loads act: names of sets, node numbers, or lists of numbers. Residual
            modes behind the others, the static response to three forces and three moments at each (forces alone at
            numbered nodes and sets on one line), make the compliance there that of the mesh
        boundary : nodes whose displacements are all kept, by constraint modes (Craig and Bampton 1968); at least
            three that are not on one line
        clamped : nodes that the frame rides on: they do not move in it, the modes are those of the mesh held there, and
            the origin stays that of the coordinates. None for the mean frame
        basis : (3 N, k) columns of displacements: the body can move as their span, without the rigid motions in it
        second_order : of how many of the first modes products are kept, which tell in second order how the inertia
            follows the deformation; None for 12, all if they are fewer or the frame is clamped, where the mass matrix
            may be indefinite with less (a warning says so). The cost of a step grows with its square
        residual_damping : damping ratio of the residual modes; None for that of the others, the last one of several
        deformation : "linear" is the only one: the material moves by linear functions of the modal coordinates, and
            neither spin nor axial force stiffen the body

        Raises
        ------
        ModelError
            For more modes than the mesh has, nodes it does not have, an indefinite matrix, a mechanism, nodes that do
            not hold the mesh, or damping that is negative, of the wrong length, or given here as well as by a matrix.
        """
        check_deformation(deformation)
        mesh = self._elastic()
        held = None if clamped is None else _rows(self._chosen("clamped", clamped))
        residual = NO_RESIDUAL
        chosen = [name for name, value in (("boundary", boundary), ("basis", basis)) if value is not None]
        held_at = _listed(interfaces)
        operators = [self._interface(one) for one in held_at]
        if len(chosen) + bool(operators) > 1:
            raise ModelError(
                f"{', '.join([*chosen, *(['interfaces'] if operators else [])])}: all were given, expected one of them"
            )
        if residual_damping is not None:
            in_range("residual_damping", residual_damping, 0.0, np.inf)
        if basis is not None:
            found = given_basis(mesh, array_of("basis", basis, (len(mesh.rank), -1)), held)
        elif boundary is not None:
            rows = _rows(self._chosen("boundary", boundary))
            found = boundary_basis(mesh, rows, modes, held)
            most = len(mesh.rank) - len(rows if held is None else np.union1d(rows, held))
            n = most if modes is None else modes
        else:
            if damping is not None and modes is not None:
                check_damping(damping, min(modes, elastic_count(mesh, held)) if isinstance(modes, int) else 0)
            found, n = free_basis(mesh, load_columns(operators, len(mesh.rank)), modes, held)
            most = elastic_count(mesh, held)
            residual = Residual(len(found[0]) - n, 0, residual_damping)
        again = None
        if basis is None:
            again = reduction_by(
                self.reduce, n, most, damping, interfaces=held_at, boundary=boundary, clamped=clamped,
                second_order=second_order, residual_damping=residual_damping,
            )  # fmt: skip
        return flexible_body(mesh, found, damping, residual, second_order, clamped=held is not None, reduction=again)

    def _elastic(self) -> ElasticMesh:
        """What every reduction starts from."""
        places = np.asarray(self.coordinates)
        scalar = self.mass[0::3, 0::3].tocsc()
        weight = np.asarray(scalar.sum(axis=0)).ravel()
        centre = weight @ places / weight.sum()
        points = NodePoints(places, self.stiffness)
        dof = np.arange(places.size)
        surface = Surface(places, np.zeros((0, 3), np.int64) if self.triangles is None else self.triangles, _nodal)  # type: ignore[arg-type]
        return ElasticMesh(
            mass=self.mass,
            stiffness=self.stiffness,
            damping=self.damping,
            rigid=_rigid_motions(places - centre),
            rank=rank_of(self.stiffness, places, dof // 3, dof % 3),
            centre=centre,
            integrals=partial(_integrals, scalar, places),
            locate=points.at,
            nodes=points.of_nodes,
            points={name: partial(points.of_nodes, nodes) for name, nodes in self.node_sets.items()},
            surface=surface,
        )

    def _chosen(self, argument: str, choice: NodeChoice) -> IntArray:
        """The nodes of a name, names, a number or numbers; each once."""
        listed = [choice] if isinstance(choice, str | int | np.integer) else choice
        expected = "the name of a node set, several, or node numbers"
        found = sequence_of(argument, listed, expected)
        if found and all(isinstance(one, str) for one in found):
            for one in found:
                if one not in self.node_sets:
                    raise ModelError(f"{argument}: {unknown(one, self.node_sets)}, the node sets of the mesh")
            return np.unique(np.concatenate([np.asarray(self.node_sets[one]) for one in found])).astype(np.int64)
        return np.unique(node_numbers(argument, listed, len(np.asarray(self.coordinates)), expected)).astype(np.int64)

    def _interface(self, choice: NodeChoice) -> tuple[PointOperator, bool]:
        """The point of an interface, and whether moments act there."""
        nodes = self._chosen("interfaces", choice)
        points = NodePoints(np.asarray(self.coordinates), self.stiffness)
        return points.of_nodes(nodes), not isinstance(choice, int | np.integer)


def _listed(interfaces: Any) -> list[Any]:
    if isinstance(interfaces, str):
        return [interfaces]
    return sequence_of("interfaces", interfaces, "a list of node sets, such as ['hole', 'face']", 10_000)


def _integrals(
    scalar: csc_matrix[Any], places: FloatArray, shapes: FloatArray, n2: int, origin: FloatArray
) -> Integrals:
    """Products with the scalar mass matrix m^, M = m^ (x) I3: x and every mode are fields of the element space."""
    x = places - origin
    n = shapes.shape[1]
    phi = shapes.reshape(len(x), 3, n)
    weighed = scalar @ x
    weight = np.asarray(scalar.sum(axis=0)).ravel()
    low = np.ascontiguousarray(phi[:, :, :n2]).reshape(len(x), 3 * n2)
    products = (low.T @ (scalar @ low)).reshape(3, n2, 3, n2)
    second = x.T @ weighed
    return Integrals(
        mass=float(weight.sum()),
        moment=weight @ x,
        second=0.5 * (second + second.T),
        S=np.einsum("a,ajk->kj", weight, phi),
        first=np.einsum("ai,ajk->kij", weighed, phi),
        products=products.transpose(1, 3, 0, 2),
    )


def _nodal(shapes: FloatArray) -> FloatArray:
    """(N, n, 3) displacements of the nodes."""
    return np.ascontiguousarray(shapes.reshape(len(shapes) // 3, 3, shapes.shape[1]).transpose(0, 2, 1))


def _rows(nodes: IntArray) -> IntArray:
    return np.asarray((3 * nodes[:, None] + np.arange(3)).ravel())


def _rigid_motions(places: FloatArray) -> FloatArray:
    """(3 N, 6) translations, and infinitesimal rotations e_i x place about the origin."""
    rigid = np.zeros((len(places), 3, 6))
    rigid[:, :, :3] = np.eye(3)
    rigid[:, :, 3:] = np.cross(np.eye(3)[None], places[:, None]).transpose(0, 2, 1)
    return rigid.reshape(-1, 6)


def _check_spread(places: FloatArray) -> None:
    if len(places) < 3 or np.linalg.matrix_rank(places - places.mean(axis=0), tol=1e-9 * float(np.ptp(places))) < 2:
        raise ModelError(f"coordinates: {len(places)} node(s) on one line were given, expected a mesh of a solid")


def _check_lumped(mass: csc_matrix[Any]) -> None:
    """Warn of a diagonal mass: its moments of inertia are those of point masses at the nodes."""
    if mass.nnz == mass.shape[0]:
        warnings.warn(
            "mass: a diagonal matrix was given, expected the consistent one: the row sums of coarse meshes make the "
            "moments of inertia too large, by 31 % for a block of 6 x 3 x 2 cubes",
            ModelWarning,
            stacklevel=4,
        )


def _triangles(value: Any, count: int) -> IntArray:
    """(T, 3) node numbers."""
    given = array_of("triangles", value, (-1, 3))
    outside = given[(given < 0) | (given >= count) | (given != np.floor(given))]
    if len(outside):
        raise ModelError(f"triangles: node {outside[0]:g} was given, expected node numbers from 0 to {count - 1}")
    triangles = given.astype(np.int64)
    triangles.setflags(write=False)
    return triangles
