"""A mesh as matrices with named nodes: what every reduction starts from."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from lcpflex.bodies.body import Resolution
from lcpflex.jit.kernel import FloatArray, IntArray

if TYPE_CHECKING:
    from scipy.sparse import csc_matrix

    from lcpflex.bodies.fem.assembly import Solid

__all__ = ["FiniteElements", "rigid_motions"]


@dataclass(frozen=True, slots=True, eq=False)
class FiniteElements:
    """A free-free mesh of N nodes with f degrees of freedom, planar or axisymmetric; its makers have checked it.

    Attributes
    ----------
    mass, stiffness : (f, f) sparse, symmetric [kg], [N/m]
    damping : (f, f) or None [N s/m]
    places : (N, 2) of the nodes in the body frame [m]; of an axisymmetric solid (along the axis, radius)
    dofs : (f,) ascending, 2 i + direction of node i; all 2 N but the radial ones on an axis of symmetry
    axisymmetric : rigid motion is the translation along the axis alone; forces at a node are those of its whole circle
    points : named nodes
    sets : named nodes, one or more, in any order: what reductions choose from
    chains : named surfaces: nodes in their order, solid on the left, and whether the chain is closed
    locate : place (x, y) -> nodes (k,), weights (k,) of the material there; None where only nodes are known
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
    locate: Callable[[float, float], tuple[IntArray, FloatArray]] | None = None
    geometric: Callable[[FloatArray], csc_matrix[Any]] | None = None
    resolution: Resolution | None = None
    excess: Callable[[FloatArray, FloatArray], FloatArray] | None = None
    finer: Callable[[], FiniteElements] | None = None
    solid: Solid | None = None

    @property
    def rigid(self) -> FloatArray:
        """(f, 3) rigid motions along x, along y and about the origin; (f, 1) along the axis if axisymmetric."""
        whole = rigid_motions(self.places)
        return np.asarray(whole[self.dofs, :1] if self.axisymmetric else whole)

    def nodal(self, shapes: FloatArray) -> FloatArray:
        """(N, 2, k) displacements of all nodes from those of the degrees of freedom (f, k)."""
        whole = np.zeros((self.places.size, shapes.shape[1]))
        whole[self.dofs] = shapes
        return whole.reshape(len(self.places), 2, shapes.shape[1])


def rigid_motions(places: FloatArray) -> FloatArray:
    """(2 N, 3) translations and infinitesimal rotation about the origin."""
    rigid = np.zeros((places.size, 3))
    rigid[0::2, 0] = 1.0
    rigid[1::2, 1] = 1.0
    rigid[0::2, 2] = -places[:, 1]
    rigid[1::2, 2] = places[:, 0]
    return rigid
