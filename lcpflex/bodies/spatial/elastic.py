"""A mesh in space as every reduction sees it: matrices, rigid motions, integrals of its fields, and its points.

Solid elements and beams differ in what their degrees of freedom mean; what they have in common is here. The place of
the material is x, its displacement N(x) d with the degrees of freedom d (f,).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from lcpflex.bodies.spatial.body import SpatialPoint
from lcpflex.jit.kernel import FloatArray, IntArray

if TYPE_CHECKING:
    from scipy.sparse import csc_matrix

__all__ = ["ElasticMesh", "Integrals", "PointOperator", "Surface", "load_columns", "material"]


class PointOperator(NamedTuple):
    """How the material at a point follows from degrees of freedom: displacement u^T d[rows], rotation psi^T d[rows]."""

    place: FloatArray  # (3,) [m]
    rows: IntArray  # (k,)
    u: FloatArray  # (k, 3)
    psi: FloatArray  # (k, 3); zeros where the rotation is not known
    turns: bool = True  # whether it is
    spread: tuple[IntArray, FloatArray] | None = None  # the nodes and weights it is the mean of, where it is one


class Integrals(NamedTuple):
    """Of shapes (f, n) and the place x, about an origin; < . > is the integral of rho ( . ) dV."""

    mass: float
    moment: FloatArray  # (3,) <x>
    second: FloatArray  # (3, 3) <x x^T>
    S: FloatArray  # (n, 3) <Phi_k>
    first: FloatArray  # (n, 3, 3) <x Phi_k^T>
    products: FloatArray  # (n2, n2, 3, 3) <Phi_l Phi_k^T> of the first n2


class Surface(NamedTuple):
    """What is drawn: triangles between vertices."""

    vertices: FloatArray  # (N, 3) [m]
    triangles: IntArray  # (T, 3)
    phi: Callable[[FloatArray], FloatArray]  # (N, n, 3) of shapes (f, n)


@dataclass(frozen=True, slots=True, eq=False)
class ElasticMesh:
    """A free-free mesh with f degrees of freedom; its makers have checked it.

    Attributes
    ----------
    mass, stiffness : (f, f) sparse, symmetric
    damping : (f, f) or None
    rigid : (f, 6) translations along x, y, z and rotations about axes through ``centre``
    rank : (f,) order of elimination
    centre : (3,) mass centre [m]
    integrals : shapes (f, n), n2, origin (3,) -> :class:`Integrals` about the origin
    locate : place (x, y, z) -> point; raises ModelError off the mesh
    nodes : node numbers, weights or None -> point; None where it has none
    points : names of points, and the operators there
    surface : what is drawn; None: not known
    faces : names of parts of the surface, and their facets (F, k): rows of the vertices of ``surface``
    """

    mass: csc_matrix[Any]
    stiffness: csc_matrix[Any]
    damping: csc_matrix[Any] | None
    rigid: FloatArray
    rank: IntArray
    centre: FloatArray
    integrals: Callable[[FloatArray, int, FloatArray], Integrals]
    locate: Callable[[float, float, float], PointOperator]
    nodes: Callable[[Any, Any], PointOperator] | None = None
    points: dict[str, Callable[[], PointOperator]] = field(default_factory=dict)
    surface: Surface | None = None
    faces: dict[str, IntArray] = field(default_factory=dict)


def material(operator: PointOperator, shapes: FloatArray, origin: FloatArray, made_at: Any) -> SpatialPoint:
    """The material point of a body with the shapes (f, n), its place from the origin of the frame."""
    local = shapes[operator.rows].T
    turns = operator.turns or not len(local)  # a rigid body turns as a whole
    place, u, psi = operator.place - origin, local @ operator.u, local @ operator.psi
    return SpatialPoint(place, u, psi, turns, made_at, operator.spread)


def load_columns(operators: list[tuple[PointOperator, bool]], f: int) -> FloatArray:
    """(f, k) loads on the mesh by unit forces at points, and unit moments where that is asked for and tells."""
    columns = []
    for operator, moments in operators:
        for parts in (operator.u, operator.psi) if moments and operator.turns else (operator.u,):
            block = np.zeros((f, 3))
            np.add.at(block, operator.rows, parts)
            columns.append(block)
    return np.hstack(columns) if columns else np.zeros((f, 0))
