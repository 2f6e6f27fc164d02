"""Integrals over the elements of a planar mesh: mass, stiffness, geometric stiffness; and where a place lies.

With shape functions N_a (of scikit-fem), their gradients d N_a and the measure dA = thickness (or 2 pi r) dx dy,

    M_ab = rho int N_a N_b dA        K = int B^T D B dA        K_g,ab = int sigma_ij d_i N_a d_j N_b dA

B maps displacements to the strains e_xx, e_yy, gamma_xy, and, about an axis of revolution (x along it, y the radius r),
e_hoop = u_r / r. The rules of Gauss integrate straight-sided elements exactly (quadrilaterals: parallelograms).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from lcpflex.bodies.planar_mesh import PlanarMesh
from lcpflex.compiled import FloatArray, IntArray
from lcpflex.errors import ModelError

if TYPE_CHECKING:
    from scipy.sparse import csc_matrix

__all__ = ["Solid", "elastic_law", "geometric_stiffness", "mass_matrix", "shape_functions", "stiffness_matrix"]

CHUNK = 4096  # elements at a time: what is integrated stays within a few tens of megabytes
ORDERS = {  # of the quadrature: (mass, stiffness), a curved or skew element included; 2 more about an axis
    "ElementTriP1": (2, 1),
    "ElementTriP2": (6, 4),
    "ElementQuad1": (3, 3),
    "ElementQuad2": (7, 5),
}


@dataclass(frozen=True, slots=True, eq=False)
class Solid:
    """A mesh with its material.

    Attributes
    ----------
    mesh : of the section
    density : [kg/m^3]
    law : (3, 3) stresses s_xx, s_yy, s_xy of the strains e_xx, e_yy, gamma_xy [Pa]; (4, 4) with the hoop last
    thickness : [m]; None for a solid of revolution about y = 0
    """

    mesh: PlanarMesh
    density: float
    law: FloatArray
    thickness: float | None


@dataclass(frozen=True, slots=True, eq=False)
class Points:
    """Some elements at their points of integration.

    Attributes
    ----------
    cells : (m, k)
    shape : (q, k) N
    gradient : (m, q, k, 2) d N / d (x, y)
    measure : (m, q) weight times dA [m^3]
    radius : (m, q) y [m]
    """

    cells: IntArray
    shape: FloatArray
    gradient: FloatArray
    measure: FloatArray
    radius: FloatArray


def elastic_law(youngs_modulus: float, poissons_ratio: float, plane_strain: bool | None) -> FloatArray:
    """(3, 3) law of plane strain or plane stress; (4, 4) of a solid of revolution for None [Pa]."""
    E, nu = youngs_modulus, poissons_ratio
    shear = E / (2.0 * (1.0 + nu))
    if plane_strain is False:
        factor = E / (1.0 - nu * nu)
        return np.array([[factor, nu * factor, 0.0], [nu * factor, factor, 0.0], [0.0, 0.0, shear]])
    lame = E * nu / ((1.0 + nu) * (1.0 - 2.0 * nu))
    direct = [0, 1] if plane_strain else [0, 1, 3]
    law = np.zeros((3, 3) if plane_strain else (4, 4))
    law[np.ix_(direct, direct)] = lame
    law[direct, direct] += 2.0 * shear
    law[2, 2] = shear
    return law


def shape_functions(mesh: PlanarMesh, X: FloatArray) -> tuple[FloatArray, FloatArray]:
    """N (q, k) and its derivatives (q, k, 2) at places X (2, q) of the reference element."""
    import skfem

    element = getattr(skfem, mesh.kind.element)()
    values = [element.lbasis(X, i) for i in range(mesh.kind.nodes)]
    N = np.column_stack([np.broadcast_to(value, X.shape[1]) for value, _ in values])
    dN = np.stack([np.broadcast_to(slope, X.shape).T for _, slope in values], axis=1)
    return N, dN


def mass_matrix(solid: Solid) -> csc_matrix[Any]:
    """(2 N, 2 N) consistent mass, degrees of freedom 2 i + direction [kg]."""
    from scipy.sparse import identity, kron

    nodes = solid.mesh.kind.nodes
    parts = [
        (solid.density * at.measure) @ np.einsum("qa,qb->qab", at.shape, at.shape).reshape(len(at.shape), -1)
        for at in _points(solid, 0)
    ]
    blocks = np.concatenate(parts).reshape(-1, nodes, nodes)
    return kron(_assembled(solid.mesh.cells, blocks, len(solid.mesh.places)), identity(2), format="csc")


def stiffness_matrix(solid: Solid) -> csc_matrix[Any]:
    """(2 N, 2 N) stiffness [N/m]."""
    blocks = np.concatenate([_stiffness(solid.law, at) for at in _points(solid, 1)])
    return _assembled(_dofs(solid.mesh.cells), blocks, solid.mesh.places.size)


def geometric_stiffness(solid: Solid, displacements: FloatArray) -> csc_matrix[Any]:
    """(2 N, 2 N) geometric stiffness of the stress of the nodal displacements (2 N,) [N/m], linear in them."""
    from scipy.sparse import identity, kron

    nodal = displacements.reshape(-1, 2)
    parts = []
    for at in _points(solid, 1):
        strain = np.einsum("mqsj,mj->mqs", _strains(at, len(solid.law)), nodal[at.cells].reshape(len(at.cells), -1))
        stress = (strain @ solid.law) * at.measure[..., None]
        tensor = stress[..., [0, 2, 2, 1]].reshape(*stress.shape[:2], 2, 2)
        parts.append(np.einsum("mqai,mqij,mqbj->mab", at.gradient, tensor, at.gradient, optimize=True))
    count = len(nodal)
    whole = kron(_assembled(solid.mesh.cells, np.concatenate(parts), count), identity(2), format="csc")
    return whole if solid.thickness is not None else (whole + _hoop(solid, nodal)).tocsc()


def _hoop(solid: Solid, nodal: FloatArray) -> csc_matrix[Any]:
    """What the hoop stress adds in the radial direction: int s_hoop N_a N_b / r^2 dA."""
    from scipy.sparse import csc_matrix, kron

    parts = []
    for at in _points(solid, 1):
        strain = np.einsum("mqsj,mj->mqs", _strains(at, 4), nodal[at.cells].reshape(len(at.cells), -1))
        weight = (strain @ solid.law)[..., 3] * at.measure / at.radius**2
        parts.append(np.einsum("mq,qa,qb->mab", weight, at.shape, at.shape, optimize=True))
    radial = csc_matrix(np.diag([0.0, 1.0]))
    return kron(_assembled(solid.mesh.cells, np.concatenate(parts), len(nodal)), radial, format="csc")


def _points(solid: Solid, purpose: int) -> Iterator[Points]:
    """The elements in chunks; refuses an element with a fold."""
    import skfem
    from skfem.quadrature import get_quadrature

    mesh = solid.mesh
    order = ORDERS[mesh.kind.element][purpose] + (2 if solid.thickness is None else 0)
    X, weights = get_quadrature(getattr(skfem, mesh.kind.element), order)
    N, dN = shape_functions(mesh, X)
    for start in range(0, len(mesh.cells), CHUNK):
        cells = mesh.cells[start : start + CHUNK]
        corners = mesh.places[cells]
        jacobian = np.einsum("qka,mkb->mqab", dN, corners, optimize=True)
        det = jacobian[..., 0, 0] * jacobian[..., 1, 1] - jacobian[..., 0, 1] * jacobian[..., 1, 0]
        _refuse_folds(mesh, det, start)
        adjugate = np.stack([jacobian[..., 1, 1], -jacobian[..., 0, 1], -jacobian[..., 1, 0], jacobian[..., 0, 0]], -1)
        inverse = adjugate.reshape(*det.shape, 2, 2) / det[..., None, None]  # d xi_a / d x_b, as rows b
        radius = corners[..., 1] @ N.T
        depth = 2.0 * math.pi * radius if solid.thickness is None else solid.thickness
        yield Points(cells, N, np.einsum("qka,mqba->mqkb", dN, inverse, optimize=True), weights * det * depth, radius)


def _refuse_folds(mesh: PlanarMesh, det: FloatArray, start: int) -> None:
    worst = det.min(axis=1)
    if worst.min() > 0.0:
        return
    bad = int(worst.argmin())
    x, y = mesh.places[mesh.cells[start + bad, : mesh.kind.corners]].mean(axis=0)
    raise ModelError(
        f"{mesh.source}: element {start + bad} at ({x:.6g}, {y:.6g}) is folded (its area changes sign inside), "
        f"expected a convex element with the nodes amid its edges near their middles"
    )


def _strains(at: Points, rows: int) -> FloatArray:
    """(m, q, rows, 2 k) B."""
    m, q, k, _ = at.gradient.shape
    B = np.zeros((m, q, rows, 2 * k))
    B[:, :, 0, 0::2] = at.gradient[..., 0]
    B[:, :, 1, 1::2] = at.gradient[..., 1]
    B[:, :, 2, 0::2] = at.gradient[..., 1]
    B[:, :, 2, 1::2] = at.gradient[..., 0]
    if rows == 4:
        B[:, :, 3, 1::2] = at.shape / at.radius[..., None]
    return B


def _stiffness(law: FloatArray, at: Points) -> FloatArray:
    """(m, 2 k, 2 k) of each element."""
    B = _strains(at, len(law))
    m, q, rows, k = B.shape
    stress = (law @ B) * at.measure[..., None, None]
    return np.asarray(B.reshape(m, q * rows, k).transpose(0, 2, 1) @ stress.reshape(m, q * rows, k))


def _dofs(cells: IntArray) -> IntArray:
    return np.asarray((2 * cells[:, :, None] + [0, 1]).reshape(len(cells), -1))


def _assembled(cells: IntArray, blocks: FloatArray, count: int) -> csc_matrix[Any]:
    """The sum of the blocks (m, k, k) at the rows and columns ``cells`` (m, k), exactly symmetric."""
    from scipy.sparse import coo_matrix

    number = cells.astype(np.int32)
    k = cells.shape[1]
    rows, columns = np.repeat(number, k, axis=1).ravel(), np.tile(number, k).ravel()
    even = 0.5 * (blocks + blocks.transpose(0, 2, 1))
    whole = coo_matrix((even.ravel(), (rows, columns)), shape=(count, count)).tocsc()
    whole.sum_duplicates()
    return (0.5 * (whole + whole.T)).tocsc()
