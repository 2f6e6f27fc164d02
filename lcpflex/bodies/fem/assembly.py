"""Integrals over the elements of a mesh, by scikit-fem: mass, stiffness, geometric stiffness.

With the measure dA = thickness (or 2 pi r) dx dy, in space dV, Lame's constants L and G, test functions v and a static
state u0,

    M = rho int u . v dA      K = int L tr e(u) tr e(v) + 2 G e(u) : e(v) dA      K_g = int s_ij(u0) d_i u . d_j v dA

Plane stress has L = E nu / (1 - nu^2). About an axis of revolution (x along it, y the radius r) the strain u_r / r
along the hoop joins e and tr e. The rules of quadrature integrate straight-sided elements exactly (quadrilaterals:
parallelograms); in space the mass is exact for curved ones, too.

In the plane scikit-fem assembles forms. In space it gives shape functions and points of quadrature, and elements are
integrated in batches, G[ik, jl] = int d_k N_i d_l N_j dV with one product of matrices an element, and of it
K = L G + G_shear G^T + G_shear tr(G) 1: 5 times faster than forms on tetrahedra of ten nodes, 50 on hexahedra of 27.

Hexahedra of eight nodes have the incompatible modes of Taylor, Beresford and Wilson (1976): three bubbles 1 - xi_k^2,
whose gradients are those of the centre of the element, J_0^-T det J_0 / det J, so that it passes the patch test; they
have no mass and are condensed, K_uu - K_ub K_bb^-1 K_bu. Without them they lock in bending.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

import numpy as np

from lcpflex.basics import libs
from lcpflex.bodies.fem.mesh import Kind, Mesh, told_place
from lcpflex.errors import ModelError
from lcpflex.jit.kernel import FloatArray

if TYPE_CHECKING:
    from scipy.sparse import csc_matrix

__all__ = [
    "ElasticSolid",
    "bubble_amounts",
    "bubble_gradients",
    "geometric_stiffness",
    "gradients_at",
    "lame_constants",
    "mass_matrix",
    "own_order",
    "reference_corners",
    "shape_functions",
    "stiffness_matrix",
]

ORDERS = {  # of the quadrature: (mass, stiffness), a curved or skew element included; 2 more about an axis
    "ElementTriP1": (2, 1),
    "ElementTriP2": (6, 4),
    "ElementQuad1": (3, 3),
    "ElementQuad2": (7, 5),
    "ElementTetP1": (2, 1),
    "ElementTetP2": (7, 5),  # det J is of third order; the rule of order 4 has a negative weight
    "ElementHex1": (5, 3),
    "ElementHexS2": (9, 5),
    "ElementHex2": (9, 5),
}
AT_ONCE = 2**21  # numbers of a batch of elements in space: 16 MB
MASS, STIFFNESS = 0, 1
SUMMED = 16  # batches that are summed at once


class _Rule(NamedTuple):
    """Points of quadrature of the reference element."""

    X: FloatArray  # (3, q)
    weight: FloatArray  # (q,)
    N: FloatArray  # (q, k) shape functions there
    dN: FloatArray  # (q, k, 3) and their derivatives


_OfElements: TypeAlias = "Callable[[ElasticSolid, FloatArray, _Rule, int], FloatArray]"


@dataclass(frozen=True, slots=True, eq=False)
class ElasticSolid:
    """A mesh with its material.

    Attributes
    ----------
    mesh : of the section, or of the body in space
    density : [kg/m^3]
    lame : L and G [Pa]
    thickness : [m]; None for a solid of revolution about y = 0; 1 in space
    plane_stress : whether there is no stress across the plane
    """

    mesh: Mesh
    density: float
    lame: tuple[float, float]
    thickness: float | None
    plane_stress: bool = False


def lame_constants(youngs_modulus: float, poissons_ratio: float, plane_stress: bool) -> tuple[float, float]:
    """L and G [Pa], L that of plane stress where asked for."""
    lame = libs.plane_stress if plane_stress else libs.lame_parameters
    return lame(youngs_modulus, poissons_ratio)


def shape_functions(kind: Kind, X: FloatArray) -> tuple[FloatArray, FloatArray]:
    """N (q, k) and its derivatives (q, k, d) at places X (d, q) of the reference element."""
    element = getattr(libs.skfem, kind.element)()
    values = [element.lbasis(X, i) for i in own_order(kind)]
    N = np.column_stack([np.broadcast_to(value, X.shape[1]) for value, _ in values])
    dN = np.stack([np.broadcast_to(slope, X.shape).T for _, slope in values], axis=1)
    return N, dN


def reference_corners(kind: Kind) -> FloatArray:
    """(corners, d) of the reference element, in our order."""
    if kind.simplex:
        return np.vstack([np.zeros(kind.dimension), np.eye(kind.dimension)])
    square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    if kind.dimension == 2:
        return square
    return np.vstack([np.column_stack([square, np.full(4, height)]) for height in (0.0, 1.0)])


def own_order(kind: Kind) -> list[int]:
    """The numbers in scikit-fem of our nodes of an element, found by their places in the reference element."""
    if kind.dimension == 2:
        return list(range(kind.nodes))
    corners = reference_corners(kind)
    ours = np.array([corners[list(amid)].mean(axis=0) for amid in kind.middles])
    theirs = np.asarray(getattr(libs.skfem, kind.element)().doflocs)
    return [int(np.abs(theirs - place).sum(axis=1).argmin()) for place in ours]


def gradients_at(solid: ElasticSolid, X: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Places (e, q, d) [m], N (q, k) and its derivatives (e, q, k, d) [1/m] at X (d, q) of the reference element."""
    if solid.mesh.kind.dimension == 3:
        N, dN = shape_functions(solid.mesh.kind, X)
        corners = solid.mesh.places[solid.mesh.cells]
        return np.einsum("eki,qk->eqi", corners, N), N, _gradients(corners, dN)[0]
    mesh = _mesh(solid)
    element = getattr(libs.skfem, solid.mesh.kind.element)()
    basis = libs.skfem.Basis(mesh, element, quadrature=(X, np.full(X.shape[1], 1.0 / X.shape[1])))
    shape = (len(solid.mesh.cells), X.shape[1])
    slopes = [np.broadcast_to(field.grad, (2, *shape)) for (field,) in basis.basis]
    places = np.broadcast_to(np.asarray(basis.global_coordinates()), (2, *shape))
    N, _ = shape_functions(solid.mesh.kind, X)
    return np.moveaxis(places, 0, -1), N, np.stack([np.moveaxis(one, 0, -1) for one in slopes], axis=2)


def mass_matrix(solid: ElasticSolid) -> csc_matrix[Any]:
    """(d N, d N) consistent mass, degrees of freedom d i + direction [kg]."""
    if solid.mesh.kind.dimension == 3:
        return libs.sparse.kron(_spatial(solid, MASS, _element_mass), libs.sparse.identity(3), format="csc")
    basis = _basis(solid, MASS, vector=False)
    scalar = libs.skfem.BilinearForm(lambda u, v, w: solid.density * _depth(solid, w) * u * v).assemble(basis)
    return libs.sparse.kron(_by_nodes(solid, basis, scalar, 1), libs.sparse.identity(2), format="csc")


def stiffness_matrix(solid: ElasticSolid) -> csc_matrix[Any]:
    """(d N, d N) stiffness [N/m]."""
    if solid.mesh.kind.dimension == 3:
        return _spatial(solid, STIFFNESS, _element_stiffness)
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


def geometric_stiffness(solid: ElasticSolid, displacements: FloatArray) -> csc_matrix[Any]:
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


def _spatial(solid: ElasticSolid, purpose: int, of_elements: _OfElements) -> csc_matrix[Any]:
    """The sum of matrices of elements (m, k, k), some at a time, exactly symmetric."""
    mesh = solid.mesh
    kind, count = mesh.kind, len(mesh.places)
    rule = _rule(kind, purpose)
    width = 1 if purpose == MASS else 3
    size = max(1, AT_ONCE // max((width * kind.nodes) ** 2, 3 * len(rule.N) * kind.nodes))
    total = libs.sparse.csc_matrix((width * count, width * count))
    for group in range(0, len(mesh.cells), SUMMED * size):
        rows, columns, values = [], [], []
        for first in range(group, min(group + SUMMED * size, len(mesh.cells)), size):
            cells = mesh.cells[first : first + size]
            found = of_elements(solid, mesh.places[cells], rule, first)
            own = (width * cells[:, :, None] + np.arange(width, dtype=cells.dtype)).reshape(len(cells), -1)
            own = own.astype(np.int32)
            rows.append(np.repeat(own, own.shape[1], axis=1).ravel())
            columns.append(np.tile(own, own.shape[1]).ravel())
            values.append(found.ravel())
        triples = (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns)))
        total = total + libs.sparse.coo_matrix(triples, shape=total.shape).tocsc()
    return (0.5 * (total + total.T)).tocsc()


def _rule(kind: Kind, purpose: int) -> _Rule:
    order = ORDERS[kind.element][purpose]
    X, weight = libs.skfem.quadrature.get_quadrature(getattr(libs.skfem, kind.element)(), order)
    return _Rule(X, np.asarray(weight), *shape_functions(kind, X))


def _element_mass(solid: ElasticSolid, corners: FloatArray, rule: _Rule, first: int) -> FloatArray:
    """(m, k, k) rho int N_i N_j dV of the elements from ``first`` on."""
    measure = solid.density * _gradients(corners, rule.dN, (solid, first))[1] * rule.weight
    pairs = (rule.N[:, :, None] * rule.N[:, None, :]).reshape(len(rule.N), -1)
    return np.asarray((measure @ pairs).reshape(len(corners), rule.N.shape[1], -1))


def _element_stiffness(solid: ElasticSolid, corners: FloatArray, rule: _Rule, first: int) -> FloatArray:
    """(m, 3 k, 3 k) stiffness of the elements from ``first`` on."""
    slopes, det = _gradients(corners, rule.dN, (solid, first))
    if solid.mesh.kind.name != "hexahedron":
        return _elastic_energy(solid, slopes, det * rule.weight)
    whole, own = _with_bubbles(solid, corners, rule, (slopes, det)), 3 * slopes.shape[2]
    return np.asarray(whole[:, :own, :own] + whole[:, :own, own:] @ _condensed(whole, own))


def _with_bubbles(
    solid: ElasticSolid, corners: FloatArray, rule: _Rule, at: tuple[FloatArray, FloatArray]
) -> FloatArray:
    """(m, 33, 33) stiffness of hexahedra, the bubbles behind the nodes; at: their :func:`_gradients`."""
    both = np.concatenate([at[0], bubble_gradients(solid, corners, rule.X)], axis=2)
    return _elastic_energy(solid, both, at[1] * rule.weight)


def _condensed(whole: FloatArray, own: int) -> FloatArray:
    """(m, 9, 24) -K_bb^-1 K_bu."""
    return -np.asarray(np.linalg.solve(whole[:, own:, own:], whole[:, own:, :own]))


def bubble_amounts(solid: ElasticSolid, corners: FloatArray) -> FloatArray:
    """(m, 9, 24) amounts of the bubbles by the nodal displacements of hexahedra with nodes (m, 8, 3).

    Three bubbles along x, y and z each: row 3 k + i is bubble k along i.
    """
    rule, found = _rule(solid.mesh.kind, STIFFNESS), np.empty((len(corners), 9, 24))
    size = AT_ONCE // 33**2
    for first in range(0, len(corners), size):
        some = corners[first : first + size]
        whole = _with_bubbles(solid, some, rule, _gradients(some, rule.dN))
        found[first : first + size] = _condensed(whole, 24)
    return found


def _elastic_energy(solid: ElasticSolid, slopes: FloatArray, measure: FloatArray) -> FloatArray:
    """(m, 3 k, 3 k) L G + G_shear G^T + G_shear tr(G) 1 of gradients (m, q, k, 3) and weights times volumes (m, q)."""
    L, shear = solid.lame
    m, q, k, _ = slopes.shape
    flat = slopes.reshape(m, q, 3 * k)
    G = ((flat * measure[:, :, None]).transpose(0, 2, 1) @ flat).reshape(m, k, 3, k, 3)
    found = L * G + shear * G.transpose(0, 1, 4, 3, 2)
    trace = shear * np.einsum("mikjk->mij", G)
    for axis in range(3):
        found[:, :, axis, :, axis] += trace
    return np.asarray(found.reshape(m, 3 * k, 3 * k))


def bubble_gradients(solid: ElasticSolid, corners: FloatArray, X: FloatArray) -> FloatArray:
    """(m, q, 3, 3) gradients at X (3, q) of the bubbles 1 - xi_k^2, xi = 2 X - 1, of hexahedra."""
    det = _gradients(corners, shape_functions(solid.mesh.kind, X)[1])[1]
    at_centre = shape_functions(solid.mesh.kind, np.full((3, 1), 0.5))[1]
    J = np.einsum("mni,nj->mij", corners, at_centre[0])
    slope = -4.0 * (2.0 * X - 1.0)  # of each bubble along its own axis of the reference element
    ratio = np.linalg.det(J)[:, None] / det
    return np.asarray(np.einsum("kq,mki,mq->mqki", slope, np.linalg.inv(J), ratio))


def _gradients(
    corners: FloatArray, dN: FloatArray, at: tuple[ElasticSolid, int] | None = None
) -> tuple[FloatArray, FloatArray]:
    """Gradients (m, q, k, 3) [1/m] and det J (m, q) of elements with nodes (m, k, 3); refuses a fold.

    at: the solid, and the number of the first element, of which messages speak.
    """
    J = np.einsum("mni,qnj->mqij", corners, dN, optimize=True)
    det = np.linalg.det(J)
    if at is not None and not det.min() > 0.0:
        _refuse_folds(at[0].mesh, det, at[1])
    return dN @ np.linalg.inv(J), det


def _basis(solid: ElasticSolid, purpose: int, vector: bool) -> Any:
    """The shape functions at the points of integration; refuses an element with a fold."""
    kind = solid.mesh.kind
    mesh = _mesh(solid)
    element = getattr(libs.skfem, kind.element)()
    order = ORDERS[kind.element][purpose] + (2 if solid.thickness is None else 0)
    basis = libs.skfem.Basis(mesh, libs.skfem.ElementVector(element) if vector else element, intorder=order)
    det = basis.mapping.detDF(basis.X)
    _refuse_folds(solid.mesh, np.broadcast_to(det, (len(solid.mesh.cells), det.shape[-1])))
    return basis


def _mesh(solid: ElasticSolid) -> Any:
    """The mesh as one of scikit-fem."""
    kind = getattr(libs.skfem, solid.mesh.kind.mesh)
    return kind(solid.mesh.places.T.copy(), solid.mesh.cells.T.copy(), sort_t=False)


def _depth(solid: ElasticSolid, w: Any) -> Any:
    """Thickness, or circumference [m]."""
    return 2.0 * math.pi * w.x[1] if solid.thickness is None else solid.thickness


def _numbers(solid: ElasticSolid, basis: Any, directions: int) -> Any:
    """(f,) our number, directions * node + direction, of each degree of freedom of scikit-fem."""
    ours = directions * solid.mesh.cells.T[:, None, :] + np.arange(directions)[None, :, None]
    number = np.empty(basis.N, dtype=np.int64)
    number[basis.element_dofs] = ours.reshape(basis.element_dofs.shape)
    return number


def _by_nodes(solid: ElasticSolid, basis: Any, matrix: Any, directions: int) -> csc_matrix[Any]:
    """A matrix of scikit-fem in the order of our nodes, exactly symmetric."""
    order = np.argsort(_numbers(solid, basis, directions))
    ours = matrix.tocsc()[order][:, order]
    return (0.5 * (ours + ours.T)).tocsc()


def _refuse_folds(mesh: Mesh, det: FloatArray, first: int = 0) -> None:
    """Refuse elements from ``first`` on whose det J (m, q) changes sign."""
    worst = det.min(axis=-1)
    if worst.min() > 0.0:
        return
    bad = first + int(worst.argmin())
    place = mesh.places[mesh.cells[bad, : mesh.kind.corners]].mean(axis=0)
    measure = "area" if mesh.kind.dimension == 2 else "volume"
    raise ModelError(
        f"{mesh.source}: element {bad} at {told_place(place)} is folded (its {measure} changes sign inside), "
        f"expected a convex element with the nodes amid its edges near their middles"
    )
