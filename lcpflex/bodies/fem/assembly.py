"""Integrals over the elements of a planar mesh, by scikit-fem: mass, stiffness, geometric stiffness.

With the measure dA = thickness (or 2 pi r) dx dy, Lame's constants L and G, test functions v and a static state u0,

    M = rho int u . v dA      K = int L tr e(u) tr e(v) + 2 G e(u) : e(v) dA      K_g = int s_ij(u0) d_i u . d_j v dA

Plane stress has L = E nu / (1 - nu^2). About an axis of revolution (x along it, y the radius r) the strain u_r / r
along the hoop joins e and tr e. The rules of quadrature integrate straight-sided elements exactly (quadrilaterals:
parallelograms).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from lcpflex.basics import libs
from lcpflex.bodies.fem.planar_mesh import PlanarMesh
from lcpflex.errors import ModelError
from lcpflex.jit.kernel import FloatArray

if TYPE_CHECKING:
    from scipy.sparse import csc_matrix

__all__ = [
    "Solid",
    "geometric_stiffness",
    "gradients_at",
    "lame_constants",
    "mass_matrix",
    "shape_functions",
    "stiffness_matrix",
]

ORDERS = {  # of the quadrature: (mass, stiffness), a curved or skew element included; 2 more about an axis
    "ElementTriP1": (2, 1),
    "ElementTriP2": (6, 4),
    "ElementQuad1": (3, 3),
    "ElementQuad2": (7, 5),
}
MASS, STIFFNESS = 0, 1


@dataclass(frozen=True, slots=True, eq=False)
class Solid:
    """A mesh with its material.

    Attributes
    ----------
    mesh : of the section
    density : [kg/m^3]
    lame : L and G [Pa]
    thickness : [m]; None for a solid of revolution about y = 0
    plane_stress : whether there is no stress across the plane
    """

    mesh: PlanarMesh
    density: float
    lame: tuple[float, float]
    thickness: float | None
    plane_stress: bool = False


def lame_constants(youngs_modulus: float, poissons_ratio: float, plane_stress: bool) -> tuple[float, float]:
    """L and G [Pa], L that of plane stress where asked for."""
    lame = libs.plane_stress if plane_stress else libs.lame_parameters
    return lame(youngs_modulus, poissons_ratio)


def shape_functions(mesh: PlanarMesh, X: FloatArray) -> tuple[FloatArray, FloatArray]:
    """N (q, k) and its derivatives (q, k, 2) at places X (2, q) of the reference element."""
    element = getattr(libs.skfem, mesh.kind.element)()
    values = [element.lbasis(X, i) for i in range(mesh.kind.nodes)]
    N = np.column_stack([np.broadcast_to(value, X.shape[1]) for value, _ in values])
    dN = np.stack([np.broadcast_to(slope, X.shape).T for _, slope in values], axis=1)
    return N, dN


def gradients_at(solid: Solid, X: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Places (e, q, 2) [m], N (q, k) and its derivatives (e, q, k, 2) [1/m] at X (2, q) of the reference element."""
    mesh = _mesh(solid)
    element = getattr(libs.skfem, solid.mesh.kind.element)()
    basis = libs.skfem.Basis(mesh, element, quadrature=(X, np.full(X.shape[1], 1.0 / X.shape[1])))
    shape = (len(solid.mesh.cells), X.shape[1])
    slopes = [np.broadcast_to(field.grad, (2, *shape)) for (field,) in basis.basis]
    places = np.broadcast_to(np.asarray(basis.global_coordinates()), (2, *shape))
    N, _ = shape_functions(solid.mesh, X)
    return np.moveaxis(places, 0, -1), N, np.stack([np.moveaxis(one, 0, -1) for one in slopes], axis=2)


def mass_matrix(solid: Solid) -> csc_matrix[Any]:
    """(2 N, 2 N) consistent mass, degrees of freedom 2 i + direction [kg]."""
    basis = _basis(solid, MASS, vector=False)
    scalar = libs.skfem.BilinearForm(lambda u, v, w: solid.density * _depth(solid, w) * u * v).assemble(basis)
    return libs.sparse.kron(_by_nodes(solid, basis, scalar, 1), libs.sparse.identity(2), format="csc")


def stiffness_matrix(solid: Solid) -> csc_matrix[Any]:
    """(2 N, 2 N) stiffness [N/m]."""
    L, G = solid.lame
    helpers = libs.skfem_helpers
    ddot, div, sym_grad = helpers.ddot, helpers.div, helpers.sym_grad

    def form(u: Any, v: Any, w: Any) -> Any:
        if solid.thickness is not None:
            return solid.thickness * (L * div(u) * div(v) + 2.0 * G * ddot(sym_grad(u), sym_grad(v)))
        hoop, other = u[1] / w.x[1], v[1] / w.x[1]
        direct = L * (div(u) + hoop) * (div(v) + other)
        return _depth(solid, w) * (direct + 2.0 * G * (ddot(sym_grad(u), sym_grad(v)) + hoop * other))

    basis = _basis(solid, STIFFNESS, vector=True)
    return _by_nodes(solid, basis, libs.skfem.BilinearForm(form).assemble(basis), 2)


def geometric_stiffness(solid: Solid, displacements: FloatArray) -> csc_matrix[Any]:
    """(2 N, 2 N) geometric stiffness of the stress of the nodal displacements (2 N,) [N/m], linear in them."""
    L, G = solid.lame
    helpers = libs.skfem_helpers
    basis = _basis(solid, STIFFNESS, vector=False)
    vector = basis.with_element(libs.skfem.ElementVector(basis.elem))
    state = vector.interpolate(displacements[np.argsort(_numbers(solid, vector, 2))])
    strain = helpers.sym_grad(state)
    hoop = state[1] / basis.global_coordinates()[1] if solid.thickness is None else np.zeros_like(strain[0, 0])
    volume = L * (helpers.trace(strain) + hoop)
    stress = helpers.eye(volume, 2) + 2.0 * G * strain

    def along(u: Any, v: Any, w: Any) -> Any:
        return _depth(solid, w) * helpers.dot(helpers.mul(w.stress, helpers.grad(u)), helpers.grad(v))

    def around(u: Any, v: Any, w: Any) -> Any:
        return _depth(solid, w) * w.stress * u * v / w.x[1] ** 2

    both = _by_nodes(solid, basis, libs.skfem.BilinearForm(along).assemble(basis, stress=stress), 1)
    whole = libs.sparse.kron(both, libs.sparse.identity(2), format="csc")
    if solid.thickness is not None:
        return whole
    stress = volume + 2.0 * G * hoop
    radial = _by_nodes(solid, basis, libs.skfem.BilinearForm(around).assemble(basis, stress=stress), 1)
    return (whole + libs.sparse.kron(radial, libs.sparse.csc_matrix(np.diag([0.0, 1.0])), format="csc")).tocsc()


def _basis(solid: Solid, purpose: int, vector: bool) -> Any:
    """The shape functions at the points of integration; refuses an element with a fold."""
    kind = solid.mesh.kind
    mesh = _mesh(solid)
    element = getattr(libs.skfem, kind.element)()
    order = ORDERS[kind.element][purpose] + (2 if solid.thickness is None else 0)
    basis = libs.skfem.Basis(mesh, libs.skfem.ElementVector(element) if vector else element, intorder=order)
    _refuse_folds(solid.mesh, basis.mapping.detDF(basis.X))
    return basis


def _mesh(solid: Solid) -> Any:
    """The mesh as one of scikit-fem."""
    kind = getattr(libs.skfem, solid.mesh.kind.mesh)
    return kind(solid.mesh.places.T.copy(), solid.mesh.cells.T.copy(), sort_t=False)


def _depth(solid: Solid, w: Any) -> Any:
    """Thickness, or circumference [m]."""
    return 2.0 * math.pi * w.x[1] if solid.thickness is None else solid.thickness


def _numbers(solid: Solid, basis: Any, directions: int) -> Any:
    """(f,) our number, directions * node + direction, of each degree of freedom of scikit-fem."""
    ours = directions * solid.mesh.cells.T[:, None, :] + np.arange(directions)[None, :, None]
    number = np.empty(basis.N, dtype=np.int64)
    number[basis.element_dofs] = ours.reshape(basis.element_dofs.shape)
    return number


def _by_nodes(solid: Solid, basis: Any, matrix: Any, directions: int) -> csc_matrix[Any]:
    """A matrix of scikit-fem in the order of our nodes, exactly symmetric."""
    order = np.argsort(_numbers(solid, basis, directions))
    ours = matrix.tocsc()[order][:, order]
    return (0.5 * (ours + ours.T)).tocsc()


def _refuse_folds(mesh: PlanarMesh, det: FloatArray) -> None:
    worst = np.broadcast_to(det, (len(mesh.cells), det.shape[-1])).min(axis=1)
    if worst.min() > 0.0:
        return
    bad = int(worst.argmin())
    x, y = mesh.places[mesh.cells[bad, : mesh.kind.corners]].mean(axis=0)
    raise ModelError(
        f"{mesh.source}: element {bad} at ({x:.6g}, {y:.6g}) is folded (its area changes sign inside), "
        f"expected a convex element with the nodes amid its edges near their middles"
    )
