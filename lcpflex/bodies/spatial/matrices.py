"""A body of space from the finite-element matrices of a solid."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
import numpy.typing as npt

from lcpflex.basics.arguments import array_of, mapping_of, numbers
from lcpflex.bodies.fem.checked_facets import check_facets
from lcpflex.bodies.fem.checked_matrices import check_directions, check_free, check_units, symmetric
from lcpflex.bodies.fem.finite_elements import FiniteElements, rigid_motions
from lcpflex.bodies.fem.node_sets import node_numbers
from lcpflex.bodies.spatial.body import SpatialBody
from lcpflex.bodies.spatial.solid_reduction import reduce_solid
from lcpflex.errors import ModelError, ModelWarning
from lcpflex.jit.kernel import FloatArray, IntArray

if TYPE_CHECKING:
    from scipy.sparse import csc_matrix

__all__ = ["SpatialMatrices"]

FACET_NODES = (3, 4, 6, 8, 9)
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
    faces : name -> (F, 3, 4, 6, 8 or 9) nodes of the facets of a part of the surface, corners first, counter-clockwise
        seen from outside, then those amid their edges, then the middle. The name is one of a node set, too, whose nodes
        weigh by area, and tells the normals of ``reduce(rows="normal")``

    Raises
    ------
    ModelError
        For anything else: wrong shapes, NaN, unsymmetric matrices, a mass not positive, supports, unknown nodes,
        facets that are clockwise seen from outside, not convex, given twice, cover one another, or have the nodes amid
        their edges in another order.

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
    faces: Mapping[str, npt.ArrayLike] = field(default_factory=dict)

    reduces_to: ClassVar[type[SpatialBody]] = SpatialBody

    def __post_init__(self) -> None:
        places = array_of("coordinates", self.coordinates, (-1, 3))
        _check_spread(places)
        n = places.size
        layout = "three rows a node"
        mass = symmetric("mass", self.mass, n, layout)
        stiffness = symmetric("stiffness", self.stiffness, n, layout)
        check_directions(mass, 3)
        _check_lumped(mass)
        check_free(stiffness, rigid_motions(places - places.mean(axis=0)), RIGID_MOTIONS)
        check_units(mass, stiffness, places)
        sets = {
            name: node_numbers(f"node_sets[{name!r}]", nodes, len(places), "a node number or a sequence of them")
            for name, nodes in mapping_of("node_sets", self.node_sets).items()
        }
        for name, nodes in sets.items():
            if len(np.unique(nodes)) != len(nodes):
                raise ModelError(f"node_sets[{name!r}]: a node appears twice, expected each once")
        faces = _faces(mapping_of("faces", self.faces), len(places), sets)
        check_facets(faces, stiffness, places)
        checked = {"mass": mass, "stiffness": stiffness, "coordinates": places, "node_sets": sets, "faces": faces}
        if self.damping is not None:
            checked["damping"] = symmetric("damping", self.damping, n, layout)
        if self.triangles is not None:
            checked["triangles"] = _facets("triangles", self.triangles, len(places), (3,))
        for name, value in checked.items():
            object.__setattr__(self, name, value)

    def finite_elements(self) -> FiniteElements:
        """What every reduction starts from."""
        places, sets = np.asarray(self.coordinates), self.node_sets
        faces: Mapping[str, IntArray] = self.faces  # type: ignore[assignment]  # as __post_init__ stored them
        facets, rows = _without_copies(faces)
        return FiniteElements(
            mass=self.mass,
            stiffness=self.stiffness,
            damping=self.damping,
            places=places,
            dofs=np.arange(places.size),
            points={name: int(nodes[0]) for name, nodes in sets.items() if len(nodes) == 1},  # type: ignore[arg-type,index]
            sets={name: np.unique(nodes) for name, nodes in sets.items()}
            | {name: np.unique(one) for name, one in faces.items()},
            facets=facets,
            faces=rows,
            triangles=self.triangles,  # type: ignore[arg-type]
        )

    reduce = reduce_solid


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


def _faces(given: Mapping[Any, Any], count: int, sets: Mapping[str, IntArray]) -> dict[str, IntArray]:
    """Facets of each name, of as many nodes each as those of the others."""
    faces = {name: _facets(f"faces[{name!r}]", value, count, FACET_NODES) for name, value in given.items()}
    for name in faces:
        if name in sets:
            raise ModelError(f"faces: the name {name!r} was given, expected another one: a node set has it")
    kinds = sorted({one.shape[1] for one in faces.values()})
    if len(kinds) > 1:
        raise ModelError(f"faces: facets of {kinds} nodes were given, expected those of one kind of element")
    return faces


def _without_copies(faces: Mapping[str, IntArray]) -> tuple[IntArray, dict[str, IntArray]]:
    """The facets of all faces, each once: faces may share some; and which of them each face has."""
    if not faces:
        return np.zeros((0, 3), dtype=np.int64), {}
    every = np.concatenate(list(faces.values()))
    _, first, number = np.unique(np.sort(every, axis=1), axis=0, return_index=True, return_inverse=True)
    ends = np.cumsum([len(one) for one in faces.values()])
    rows = np.split(number.ravel(), ends[:-1])
    return every[first], {name: np.unique(own) for name, own in zip(faces, rows, strict=True)}


def _facets(name: str, value: Any, count: int, wide: tuple[int, ...]) -> IntArray:
    """(F, k) node numbers, k one of ``wide``."""
    columns = np.shape(numbers(value))[1:2] if numbers(value) is not None else ()
    given = array_of(name, value, (-1, columns[0] if columns and columns[0] in wide else wide[0]))
    outside = given[(given < 0) | (given >= count) | (given != np.floor(given))]
    if len(outside):
        raise ModelError(f"{name}: node {outside[0]:g} was given, expected node numbers from 0 to {count - 1}")
    facets = given.astype(np.int64)
    ordered = np.sort(facets, axis=1)
    twice = np.flatnonzero((ordered[:, 1:] == ordered[:, :-1]).any(axis=1))
    if len(twice) and name != "triangles":
        raise ModelError(f"{name}: facet {twice[0]} has a node twice, expected {facets.shape[1]} different ones")
    facets.setflags(write=False)
    return facets
