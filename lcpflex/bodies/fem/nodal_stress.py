"""Stress at the nodes of a mesh, in the plane and in space.

Strains are taken where those of the element are best, at the points of reduced integration (Barlow points: the centre
of a linear triangle or tetrahedron, three or four points of a quadratic one, 2 x 2 of quadrilaterals, 2 x 2 x 2 of
hexahedra). They are extrapolated to the nodes of the element by the polynomial through these points, and averaged over
the elements that meet in a node. With Lame's constants L and G,

    e = sym grad u,   sigma = L tr e + 2 G e

so nodal stress is a linear function of nodal displacements, made once as sparse derivatives. Hexahedra of eight nodes
have their incompatible modes in u, by the amounts that the displacements of their nodes tell. Within a quadratic
element, that stress is linear: the parabola of shear across a bar of n elements is 17 % / (n/2)^2 too high amid an even
n. That of linear triangles and tetrahedra is constant: at a boundary it is half an element inside.
Source: Barlow 1976; Hinton & Campbell 1974.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from lcpflex.basics import libs
from lcpflex.bodies.fem.assembly import ElasticSolid, bubble_amounts, bubble_gradients, gradients_at, own_order
from lcpflex.jit.kernel import FloatArray, IntArray

if TYPE_CHECKING:
    from scipy.sparse import csr_matrix

__all__ = ["NodalGradients", "nodal_gradients", "nodal_stress"]

_GAUSS = 0.5 + np.array([-0.5, 0.5]) / np.sqrt(3.0)
_SQUARE = np.stack(np.meshgrid(_GAUSS, _GAUSS)).reshape(2, 4)
_CUBE = np.stack(np.meshgrid(_GAUSS, _GAUSS, _GAUSS)).reshape(3, 8)
_FOUR = (1.0 - 1.0 / np.sqrt(5.0)) / 4.0  # of the rule of order 2 on tetrahedra: three coordinates, the fourth the rest
POINTS = {  # of the elements of scikit-fem: Barlow points (d, q) of the reference element
    "ElementTriP1": np.full((2, 1), 1.0 / 3.0),
    "ElementTriP2": np.array([[1.0, 4.0, 1.0], [1.0, 1.0, 4.0]]) / 6.0,
    "ElementQuad1": _SQUARE,
    "ElementQuad2": _SQUARE,
    "ElementTetP1": np.full((3, 1), 0.25),
    "ElementTetP2": np.column_stack([np.full(3, _FOUR), _FOUR + (1.0 - 4.0 * _FOUR) * np.eye(3)]),
    "ElementHex1": _CUBE,
    "ElementHexS2": _CUBE,
    "ElementHex2": _CUBE,
}


class NodalGradients(NamedTuple):
    """Derivatives at the nodes of a field of N' functions: of N nodes, and behind them of three bubbles an element."""

    along: tuple[csr_matrix[Any], ...]  # (N, N') by x, y, and z in space [1/m]
    hoop: csr_matrix[Any] | None = None  # (N, N) the field over the radius, about an axis of revolution
    bubbles: FloatArray | None = None  # (m, 9, 24) their amounts by the displacements of the nodes of an element


def nodal_gradients(solid: ElasticSolid) -> NodalGradients:
    """Of the mesh of ``solid``."""
    mesh = solid.mesh
    X = POINTS[mesh.kind.element]
    at, N, dN = gradients_at(solid, X)
    nodes = np.asarray(getattr(libs.skfem, mesh.kind.element)().doflocs)[own_order(mesh.kind)].T
    terms = X.shape[1]
    spread = _terms(nodes, terms).T @ np.linalg.inv(_terms(X, terms).T)  # (nodes, q)
    owners, bubbles = mesh.cells, None
    if mesh.kind.name == "hexahedron":
        corners = mesh.places[mesh.cells]
        bubbles = bubble_amounts(solid, corners)
        dN = np.concatenate([dN, bubble_gradients(solid, corners, X)], axis=2)
        owners = np.hstack([owners, len(mesh.places) + np.arange(3 * len(owners)).reshape(-1, 3)])
    slopes = np.einsum("aq,eqid->eaid", spread, dN)
    along = tuple(_averaged(solid, slopes[..., d], owners) for d in range(mesh.kind.dimension))
    if solid.thickness is not None:
        return NodalGradients(along, None, bubbles)
    around = np.einsum("aq,qi,eq->eai", spread, N, 1.0 / at[..., 1])
    return NodalGradients(along, _averaged(solid, around, owners))


def _terms(X: FloatArray, count: int) -> FloatArray:
    """(count, k) the first of 1, x, y, x y at k places; in space of 1, x, y, z, x y, y z, z x, x y z."""
    one = np.ones(X.shape[1])
    if len(X) == 2:
        return np.stack([one, X[0], X[1], X[0] * X[1]])[:count]
    x, y, z = X
    return np.stack([one, x, y, z, x * y, y * z, z * x, x * y * z])[:count]


def _averaged(solid: ElasticSolid, values: FloatArray, owners: IntArray) -> Any:
    """(N, N') from (elements, nodes a, functions i): what the field of i does at a, the mean over the elements of a.

    owners: (elements, functions) the columns.
    """
    cells, count = solid.mesh.cells, len(solid.mesh.places)
    meet = np.bincount(cells.ravel(), minlength=count)
    rows, columns = np.broadcast_arrays(cells[:, :, None], owners[:, None, :])
    share = values / meet[rows]
    shape = (count, max(count, int(owners.max()) + 1))
    return libs.sparse.csr_matrix((share.ravel(), (rows.ravel(), columns.ravel())), shape=shape)


def nodal_stress(solid: ElasticSolid, gradients: NodalGradients, displacements: FloatArray) -> FloatArray:
    """(4, N, k) sigma_xx, sigma_yy, sigma_xy and sigma_zz [Pa] of nodal displacements (N, 2, k) [m].

    sigma_zz: across the plane, 0 in plane stress; along the hoop of a solid of revolution. In space (6, N, k) with
    sigma_yz and sigma_zx, of (N, 3, k).
    """
    L, G = solid.lame
    u = _with_bubbles(solid, gradients, displacements)
    d = u.shape[1]

    def slope(i: int, by: int) -> FloatArray:
        return np.asarray(gradients.along[by] @ u[:, i])

    xx, yy = slope(0, 0), slope(1, 1)
    if d == 3:
        zz = slope(2, 2)
    else:
        zz = np.zeros_like(xx) if gradients.hoop is None else gradients.hoop @ u[:, 1]
    volume = L * (xx + yy + zz)
    across = np.zeros_like(xx) if solid.plane_stress else volume + 2.0 * G * zz
    shear = [G * (slope(i, j) + slope(j, i)) for i, j in ((0, 1), (1, 2), (2, 0))[: 2 * d - 3]]
    return np.stack([volume + 2.0 * G * xx, volume + 2.0 * G * yy, shear[0], across, *shear[1:]])


def _with_bubbles(solid: ElasticSolid, gradients: NodalGradients, displacements: FloatArray) -> FloatArray:
    """(N', d, k) the amounts of the bubbles behind the nodal displacements, where there are some."""
    if gradients.bubbles is None:
        return displacements
    k = displacements.shape[2]
    amounts = gradients.bubbles @ displacements[solid.mesh.cells].reshape(len(gradients.bubbles), -1, k)
    return np.concatenate([displacements, amounts.reshape(-1, 3, k)])
