"""A mesh in space cut by a plane n . x = c: the mass of the part beyond it, and the section that is cut.

Elements that the plane cuts are taken apart into tetrahedra of their reference element, with n . x linear in each of
them, and these are clipped. That is exact for elements with straight edges (of hexahedra: parallelepipeds); pieces of
others are divided by eight first, with an error of second order in their size.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from lcpflex.basics import libs
from lcpflex.bodies.fem.assembly import ElasticSolid, mass_matrix, reference_corners, shape_functions
from lcpflex.errors import ModelError, shown
from lcpflex.jit.kernel import FloatArray, IntArray

if TYPE_CHECKING:
    from scipy.sparse import csr_matrix

__all__ = ["PlaneCut", "plane_cut"]

ON = 1e-9  # of the size of the mesh: what is so near to the plane is in it
NEAR = 1e-7  # of the size of the mesh, at which the section beside a plane between elements is taken
STEP = 1e-3  # of the area of a section: two so near to each other differ by more at a neck
AFFINE = 1e-9  # of the size of an element: straight edges, and faces that are parallel
AT_ONCE = 2**9  # tetrahedra of some hundred points each: tens of MB
ORDERS = {  # of the quadrature of pieces: N_i N_j det J, of 20 and 27 nodes where both fields are quadratic
    "tetra": 2, "tetra10": 7, "hexahedron": 10, "hexahedron20": 8, "hexahedron27": 8,
}  # fmt: skip
OF_SECTION = 4
CUBE = ((0, 1, 2, 6), (0, 2, 3, 6), (0, 3, 7, 6), (0, 7, 4, 6), (0, 4, 5, 6), (0, 5, 1, 6))  # tetrahedra of its corners
EIGHTH = (  # tetrahedra of its corners 0 to 3 and the middles of its edges 01, 02, 03, 12, 13, 23
    (0, 4, 5, 6), (4, 1, 7, 8), (5, 7, 2, 9), (6, 8, 9, 3), (4, 5, 6, 9), (4, 6, 8, 9), (4, 8, 7, 9), (4, 7, 5, 9),
)  # fmt: skip
EDGES = ((0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3))


class PlaneCut(NamedTuple):
    """Of a mesh of N nodes.

    normal, c : of the plane
    on : [m] what is so near to the plane is in it, not beyond
    mass : (N, N) consistent mass of the part with n . x > c [kg]
    at : (k, N) shape functions at points of the section
    area : (k,) of the undeformed section that they stand for [m^2]
    """

    normal: FloatArray
    c: float
    on: float
    mass: csr_matrix[Any]
    at: csr_matrix[Any]
    area: FloatArray

    def beyond(self, places: FloatArray) -> Any:
        """(k,) whether undeformed places (k, 3) are beyond the plane."""
        return places @ self.normal - self.c > self.on


class Pieces(NamedTuple):
    """Simplices within elements: of d + 1 corners in the reference element."""

    cell: IntArray  # (p,)
    corners: FloatArray  # (p, d + 1, 3)


def plane_cut(solid: ElasticSolid, normal: FloatArray, c: float) -> PlaneCut:
    """normal: unit vector n; c: [m]. Raises ModelError for a plane that does not cut the mesh."""
    mesh = solid.mesh
    side = mesh.places @ normal - c
    on = ON * mesh.size
    if not (side.min() < -on and side.max() > on):
        low, high = float(side.min() + c), float(side.max() + c)
        raise ModelError(f"x: {shown(c)} was given, expected a plane through the body, between {low:g} and {high:g} m")
    of_cells = side[mesh.cells]
    whole = of_cells.min(axis=1) >= -on
    cut = np.flatnonzero(~whole & (of_cells.max(axis=1) > on))
    beyond, _ = _clipped(solid, cut, np.where(np.abs(side) > on, side, 0.0))
    mass = mass_matrix(replace(solid, mesh=replace(mesh, cells=mesh.cells[whole])))[::3, ::3]
    for first in range(0, len(beyond.cell), AT_ONCE):
        some = Pieces(beyond.cell[first : first + AT_ONCE], beyond.corners[first : first + AT_ONCE])
        at, volume = _samples(solid, some, ORDERS[mesh.kind.name])
        mass = mass + at.T @ libs.sparse.diags_array(solid.density * volume) @ at
    return PlaneCut(normal, c, on, mass.tocsr(), *_section(solid, side, on))


def _section(solid: ElasticSolid, side: FloatArray, on: float) -> tuple[csr_matrix[Any], FloatArray]:
    """Samples of what lies in the plane; where nodes do, half of those on either side of it, at a neck the fewer."""
    beside = NEAR * solid.mesh.size if (np.abs(side) <= on).any() else 0.0
    found = []
    for shifted in (side - beside, side + beside)[: 2 if beside else 1]:
        of_cells = shifted[solid.mesh.cells]
        cut = np.flatnonzero((of_cells.min(axis=1) < 0.0) & (of_cells.max(axis=1) > 0.0))
        found.append(_samples(solid, _clipped(solid, cut, shifted)[1], OF_SECTION))
    found.sort(key=lambda one: float(one[1].sum()))
    (at, area), (other, larger) = found[0], found[-1]
    if not beside or area.sum() < (1.0 - STEP) * larger.sum():
        return at, area
    return libs.sparse.vstack([at, other], format="csr"), 0.5 * np.concatenate([area, larger])


def _clipped(solid: ElasticSolid, cut: IntArray, side: FloatArray) -> tuple[Pieces, Pieces]:
    """The tetrahedra beyond the plane, and the triangles in it, of the elements ``cut``."""
    mesh = solid.mesh
    fine = ~_affine(mesh.kind, mesh.places[mesh.cells[cut]])
    parts = [_clip(_tetrahedra(mesh.kind, own), solid, cut[fine == own], side) for own in (False, True)]
    return _joined([part[0] for part in parts]), _joined([part[1] for part in parts])


def _affine(kind: Any, nodes: FloatArray) -> Any:
    """(m,) whether the map of each element from its reference element is linear."""
    corners = reference_corners(kind)
    reference = np.array([corners[list(amid)].mean(axis=0) for amid in kind.middles])
    terms = np.column_stack([np.ones(len(reference)), reference])
    linear = terms @ np.linalg.pinv(terms)
    off = nodes - np.einsum("ab,mbi->mai", linear, nodes)
    return np.abs(off).max(axis=(1, 2), initial=0.0) <= AFFINE * np.ptp(nodes, axis=1).max(axis=1)


def _tetrahedra(kind: Any, divided: bool) -> FloatArray:
    """(t, 4, 3) of the reference element, each divided by eight where asked for."""
    corners = reference_corners(kind)
    found = corners[None] if kind.simplex else corners[np.array(CUBE)]
    if divided:
        middles = np.stack([found[:, list(edge)].mean(axis=1) for edge in EDGES], axis=1)
        found = np.concatenate([found, middles], axis=1)[:, np.array(EIGHTH)].reshape(-1, 4, 3)
    return np.asarray(found)


def _clip(tetrahedra: FloatArray, solid: ElasticSolid, cells: IntArray, side: FloatArray) -> tuple[Pieces, Pieces]:
    """See :func:`_clipped`."""
    N, _ = shape_functions(solid.mesh.kind, tetrahedra.reshape(-1, 3).T)
    height = (side[solid.mesh.cells[cells]] @ N.T).reshape(-1, 4)
    owner = np.repeat(cells, len(tetrahedra))
    corners = np.tile(tetrahedra, (len(cells), 1, 1))
    order = np.argsort(-height, axis=1)  # those beyond first
    height = np.take_along_axis(height, order, axis=1)
    corners = np.take_along_axis(corners, order[:, :, None], axis=1)
    count = (height > 0.0).sum(axis=1)
    whole = count == 4
    solids, faces = [Pieces(owner[whole], corners[whole])], [Pieces(owner[:0], corners[:0, :3])]
    for beyond in (1, 2, 3):
        own = count == beyond
        for kind, into in ((_SOLIDS, solids), (_FACES, faces)):
            for piece in kind[beyond]:
                into.append(Pieces(owner[own], _corners_of(piece, corners[own], height[own])))
    return _joined(solids), _joined(faces)


# corners of pieces: a corner k of the tetrahedron as (k, k), the cut of the edge from i beyond to k as (i, k)
_SOLIDS = {
    1: (((0, 0), (0, 1), (0, 2), (0, 3)),),
    2: (
        ((0, 0), (0, 2), (0, 3), (1, 3)),
        ((0, 0), (0, 2), (1, 2), (1, 3)),
        ((0, 0), (1, 1), (1, 2), (1, 3)),
    ),
    3: (
        ((0, 0), (1, 1), (2, 2), (2, 3)),
        ((0, 0), (1, 1), (1, 3), (2, 3)),
        ((0, 0), (0, 3), (1, 3), (2, 3)),
    ),
}
_FACES = {
    1: (((0, 1), (0, 2), (0, 3)),),
    2: (((0, 2), (0, 3), (1, 3)), ((0, 2), (1, 3), (1, 2))),
    3: (((0, 3), (1, 3), (2, 3)),),
}


def _corners_of(piece: Any, corners: FloatArray, height: FloatArray) -> FloatArray:
    """(m, d + 1, 3) of one piece of tetrahedra (m, 4, 3) with heights (m, 4) over the plane."""
    found = []
    for i, k in piece:
        share = height[:, i] / (height[:, i] - height[:, k]) if i != k else np.zeros(len(height))
        found.append(corners[:, i] + share[:, None] * (corners[:, k] - corners[:, i]))
    return np.stack(found, axis=1)


def _joined(parts: list[Pieces]) -> Pieces:
    return Pieces(np.concatenate([part.cell for part in parts]), np.concatenate([part.corners for part in parts]))


def _samples(solid: ElasticSolid, pieces: Pieces, order: int) -> tuple[csr_matrix[Any], FloatArray]:
    """Shape functions (k, N) at points of quadrature of pieces, and the volume [m^3] or area [m^2] of each (k,)."""
    mesh = solid.mesh
    sides = pieces.corners.shape[1] - 1
    X, weight = _rule(sides, order)
    spread = np.vstack([1.0 - X.sum(axis=0), X])  # (d + 1, q) shares of the corners
    at = np.einsum("pci,cq->pqi", pieces.corners, spread)
    N, dN = shape_functions(mesh.kind, at.reshape(-1, 3).T)
    cells = mesh.cells[np.repeat(pieces.cell, len(weight))]
    J = np.einsum("pni,pnj->pij", mesh.places[cells], dN)
    edges = np.repeat(pieces.corners[:, 1:] - pieces.corners[:, :1], len(weight), axis=0)
    moved = np.einsum("pij,pkj->pki", J, edges)
    if sides == 2:
        measure = np.linalg.norm(np.cross(moved[:, 0], moved[:, 1]), axis=1)
    else:
        measure = np.abs(np.linalg.det(moved))
    rows = np.repeat(np.arange(len(N)), N.shape[1])
    shape = (len(N), len(mesh.places))
    whole = libs.sparse.csr_matrix((N.ravel(), (rows, cells.ravel())), shape=shape)
    return whole, measure * np.tile(weight, len(pieces.cell))


def _rule(d: int, order: int) -> tuple[FloatArray, FloatArray]:
    """Points (d, q) and weights (q,) of the reference triangle or tetrahedron: products of Gauss' rules, collapsed.

    For the order 10 of skew hexahedra scikit-fem has none.
    """
    X: FloatArray = np.zeros((0, 1))
    weight: FloatArray = np.ones(1)
    for power in range(d):  # the rest of the edge, (1 - x)^power of it
        x, w = np.polynomial.legendre.leggauss((order + power) // 2 + 1)
        x, w = 0.5 * (x + 1.0), 0.5 * w * (0.5 * (1.0 - x)) ** power
        inner = np.tile(X, len(x)) * np.repeat(1.0 - x, X.shape[1])
        X = np.asarray(np.vstack([np.repeat(x, X.shape[1])[None], inner]))
        weight = np.asarray(np.kron(w, weight), dtype=np.float64)
    return X, weight
