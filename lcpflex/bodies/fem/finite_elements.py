"""A mesh as matrices with named nodes: what every reduction starts from."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from lcpflex.bodies.body import Resolution
from lcpflex.bodies.fem.elimination_order import rank_of
from lcpflex.jit.kernel import FloatArray, IntArray

if TYPE_CHECKING:
    from scipy.sparse import csc_matrix

    from lcpflex.bodies.fem.assembly import ElasticSolid

__all__ = ["FiniteElements", "rigid_motions"]


@dataclass(frozen=True, slots=True, eq=False, weakref_slot=True)
class FiniteElements:
    """A free-free mesh of N nodes with f degrees of freedom, in d = 2 or 3 dimensions; its makers have checked it.

    Attributes
    ----------
    mass, stiffness : (f, f) sparse, symmetric [kg], [N/m]
    damping : (f, f) or None [N s/m]
    places : (N, d) of the nodes in the body frame [m]; of an axisymmetric solid (along the axis, radius)
    dofs : (f,) ascending, d i + direction of node i; all d N but the radial ones on an axis of symmetry
    axisymmetric : rigid motion is the translation along the axis alone; forces at a node are those of its whole circle
    points : named nodes
    sets : named nodes, one or more, in any order: what reductions choose from
    chains : named surfaces in the plane: nodes in their order, solid on the left, and whether the chain is closed
    facets : (F, k) nodes of the facets of the surface in space, seen from outside, in the order of
        :attr:`lcpflex.bodies.fem.mesh.Kind.facets`; none where they are not known
    faces : named parts of it, as rows of ``facets``
    triangles : (T, 3) nodes of plane triangles of the surface, for pictures; None: those of the facets
    locate : place (x, y) or (x, y, z) -> nodes (k,), weights (k,) of the material there; None where only nodes are
        known
    resolution : what the elements can resolve; None where they are not known
    geometric : displacements (f,) of a static state -> its geometric stiffness as an (f, f) sparse matrix, a linear
        function of that state; None where the elements are not known
    excess : omega2 (k,), modes (f, k) of it -> (k,) by how much they are stiffer than with better elements,
        omega^2 / omega_2^2 - 1 [-]; None where the elements are not known, or known to lock
    solid : the elements and their material; None where they are not known
    finer : the next finer mesh of the same body, without names; None where the elements are not known
    """

    mass: csc_matrix[Any]
    stiffness: csc_matrix[Any]
    damping: csc_matrix[Any] | None
    places: FloatArray
    dofs: IntArray
    axisymmetric: bool = False
    points: Mapping[str, int] = field(default_factory=dict)
    sets: Mapping[str, IntArray] = field(default_factory=dict)
    chains: Mapping[str, tuple[IntArray, bool]] = field(default_factory=dict)
    facets: IntArray = field(default_factory=lambda: np.zeros((0, 3), dtype=np.int64))
    faces: Mapping[str, IntArray] = field(default_factory=dict)
    triangles: IntArray | None = None
    locate: Callable[..., tuple[IntArray, FloatArray]] | None = None
    geometric: Callable[[FloatArray], csc_matrix[Any]] | None = None
    resolution: Resolution | None = None
    excess: Callable[[FloatArray, FloatArray], FloatArray] | None = None
    finer: Callable[[], FiniteElements] | None = None
    solid: ElasticSolid | None = None

    @property
    def dimension(self) -> int:
        """2 or 3."""
        return int(self.places.shape[1])

    @property
    def node(self) -> IntArray:
        """(f,) to which each degree of freedom belongs."""
        return np.asarray(self.dofs // self.dimension)

    @property
    def rank(self) -> IntArray:
        """(f,) order of elimination; raises ModelError for a mesh in pieces."""
        return rank_of(self.stiffness, self.places, self.node, self.dofs % self.dimension)

    @property
    def centre(self) -> FloatArray:
        """(d,) mass centre of a mesh all of whose nodes can move [m]."""
        weight = np.asarray(self.mass[0 :: self.dimension, 0 :: self.dimension].sum(axis=0)).ravel()
        return np.asarray(weight @ self.places / weight.sum())

    @property
    def rigid(self) -> FloatArray:
        """(f, r) rigid motions: translations and rotations, in the plane about the origin, in space about the mass
        centre; (f, 1) along the axis if axisymmetric.
        """
        if self.dimension == 3:
            return rigid_motions(self.places - self.centre)
        whole = rigid_motions(self.places)
        return np.asarray(whole[self.dofs, :1] if self.axisymmetric else whole)

    def nodal(self, shapes: FloatArray) -> FloatArray:
        """(N, d, k) displacements of all nodes from those of the degrees of freedom (f, k)."""
        whole = np.zeros((self.places.size, shapes.shape[1]))
        whole[self.dofs] = shapes
        return whole.reshape(*self.places.shape, shapes.shape[1])


def rigid_motions(places: FloatArray) -> FloatArray:
    """(d N, 3 or 6) translations and infinitesimal rotations about the origin, in space e_i x place."""
    if places.shape[1] == 3:
        whole = np.zeros((len(places), 3, 6))
        whole[:, :, :3] = np.eye(3)
        whole[:, :, 3:] = np.cross(np.eye(3)[None], places[:, None]).transpose(0, 2, 1)
        return whole.reshape(-1, 6)
    rigid = np.zeros((places.size, 3))
    rigid[0::2, 0] = 1.0
    rigid[1::2, 1] = 1.0
    rigid[0::2, 2] = -places[:, 1]
    rigid[1::2, 2] = places[:, 0]
    return rigid
