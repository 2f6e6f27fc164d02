"""Stress at the nodes of a planar mesh, by scikit-fem's shape functions.

Strains are taken where those of the element are best, at the points of reduced integration (Barlow points: the centre
of a linear triangle, three points of a quadratic one, 2 x 2 of quadrilaterals). They are extrapolated to the nodes of
the element by the polynomial through these points, and averaged over the elements that meet in a node. With Lame's
constants L and G,

    e = sym grad u,   sigma = L tr e + 2 G e

so nodal stress is a linear function of nodal displacements, made once as sparse derivatives. Within a quadratic
element, that stress is linear: the parabola of shear across a bar of n elements is 17 % / (n/2)^2 too high amid an even
n. That of linear triangles is constant: at a boundary it is half an element inside.
Source: Barlow 1976; Hinton & Campbell 1974.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from lcpflex.basics import libs
from lcpflex.bodies.fem.assembly import ElasticSolid, gradients_at
from lcpflex.jit.kernel import FloatArray

if TYPE_CHECKING:
    from scipy.sparse import csr_matrix

__all__ = ["NodalGradients", "nodal_gradients", "nodal_stress"]

_GAUSS = 0.5 + np.array([-0.5, 0.5]) / np.sqrt(3.0)
_SQUARE = np.stack(np.meshgrid(_GAUSS, _GAUSS)).reshape(2, 4)
POINTS = {  # of the elements of scikit-fem: Barlow points (2, q) of the reference element
    "ElementTriP1": np.full((2, 1), 1.0 / 3.0),
    "ElementTriP2": np.array([[1.0, 4.0, 1.0], [1.0, 1.0, 4.0]]) / 6.0,
    "ElementQuad1": _SQUARE,
    "ElementQuad2": _SQUARE,
}


class NodalGradients(NamedTuple):
    """Derivatives of a nodal field at the nodes."""

    x: csr_matrix[Any]  # (N, N) [1/m]
    y: csr_matrix[Any]
    hoop: csr_matrix[Any] | None  # (N, N) the field over the radius, about an axis of revolution


def nodal_gradients(solid: ElasticSolid) -> NodalGradients:
    """Of the mesh of ``solid``."""
    mesh = solid.mesh
    X = POINTS[mesh.kind.element]
    at, N, dN = gradients_at(solid, X)
    corners = np.asarray(getattr(libs.skfem, mesh.kind.element)().doflocs).T
    terms = X.shape[1]
    spread = _terms(corners, terms).T @ np.linalg.inv(_terms(X, terms).T)  # (nodes, q)
    slopes = np.einsum("aq,eqid->eaid", spread, dN)
    x, y = (_averaged(solid, slopes[..., d]) for d in range(2))
    if solid.thickness is not None:
        return NodalGradients(x, y, None)
    around = np.einsum("aq,qi,eq->eai", spread, N, 1.0 / at[..., 1])
    return NodalGradients(x, y, _averaged(solid, around))


def _terms(X: FloatArray, count: int) -> FloatArray:
    """(count, k) the first of 1, x, y, x y at k places."""
    return np.stack([np.ones(X.shape[1]), X[0], X[1], X[0] * X[1]])[:count]


def _averaged(solid: ElasticSolid, values: FloatArray) -> Any:
    """(N, N) from (elements, nodes a, nodes i): what the field at i does at a, the mean over the elements of a."""
    cells, count = solid.mesh.cells, len(solid.mesh.places)
    meet = np.bincount(cells.ravel(), minlength=count)
    rows, columns = np.broadcast_arrays(cells[:, :, None], cells[:, None, :])
    share = values / meet[rows]
    return libs.sparse.csr_matrix((share.ravel(), (rows.ravel(), columns.ravel())), shape=(count, count))


def nodal_stress(solid: ElasticSolid, gradients: NodalGradients, displacements: FloatArray) -> FloatArray:
    """(4, N, k) sigma_xx, sigma_yy, sigma_xy and sigma_zz [Pa] of nodal displacements (N, 2, k) [m].

    sigma_zz: across the plane, 0 in plane stress; along the hoop of a solid of revolution.
    """
    L, G = solid.lame
    u, v = displacements[:, 0], displacements[:, 1]
    xx, yy = gradients.x @ u, gradients.y @ v
    hoop = np.zeros_like(xx) if gradients.hoop is None else gradients.hoop @ v
    volume = L * (xx + yy + hoop)
    across = np.zeros_like(xx) if solid.plane_stress else volume + 2.0 * G * hoop
    return np.stack([volume + 2.0 * G * xx, volume + 2.0 * G * yy, G * (gradients.y @ u + gradients.x @ v), across])
