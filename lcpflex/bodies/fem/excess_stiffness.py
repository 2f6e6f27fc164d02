"""How much too stiff elements make the modes of a mesh, estimated from these modes at little cost.

Better elements on the same mesh have a hump on each edge besides the displacements v of their own, u = v + w: for
linear ones 4 N_i N_j on the edge i-j of a triangle or tetrahedron and 4 s (1 - s) N on a quadrilateral or hexahedron, s
along the edge and N linear across; for quadratic ones that times N_i - N_j, or 1 - 2 s, which is cubic. What a mode v
of the mesh lacks is in

    (K_ww - omega^2 M_ww) w = -(K_wv - omega^2 M_wv) v

where omega^2 M_ww on the left is left out: it is small by (element size / wave length)^2. K_ww is well conditioned
whatever the size of the elements, so that a few steps of conjugate gradients solve it, preconditioned by the d x d
block of each edge. Ritz values omega_2^2 of all v and w together lie between those of the better elements and those of
the mesh, and the excess of stiffness is

    omega^2 / omega_2^2 - 1   [-]

which is at most that against quadratic, or cubic, elements. Pure bending, u_x = -x y, u_y = (x^2 + nu y^2) / 2, is of
the form v + w on straight-sided linear triangles and rectangles: there the excess is all of it.

Hexahedra bend with a curvature that jumps from one element to the next, which humps on edges hardly mend: of a plate
they see a thirtieth of it. There the excess is at least the energy of stress sigma* - sigma, sigma* the nodal mean,

    int (sigma* - sigma) : C^-1 : (sigma* - sigma) dV / omega^2   [-]

(Measured, of the excess over the next finer mesh: hexahedra of eight nodes .2 to .6, of 27 .4 to .7.)

Sources: the hierarchical error estimator of Bank & Smith 1993, SIAM J. Numer. Anal. 30, 921; that of recovered stress,
Zienkiewicz & Zhu 1987, Int. J. Numer. Methods Eng. 24, 337.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from lcpflex.basics import libs
from lcpflex.bodies.fem.assembly import (
    ElasticSolid,
    bubble_amounts,
    bubble_gradients,
    reference_corners,
    shape_functions,
)
from lcpflex.bodies.fem.mesh import Mesh
from lcpflex.bodies.fem.nodal_stress import nodal_gradients, nodal_stress
from lcpflex.jit.kernel import FloatArray

if TYPE_CHECKING:
    from scipy.sparse import csr_matrix

__all__ = ["excess_stiffness"]

STEPS = 8  # of conjugate gradients: ten come within 0.3 % of forty on graded triangles; fewer make the excess smaller
AT_ONCE = 2**21  # numbers of the strains of some elements: 16 MB
DEPENDENT = 1e-10  # of a Gram matrix of unit vectors: below, one is a combination of the others


@dataclass(frozen=True, slots=True, eq=False)
class _Fields:
    """Functions of some elements at their points of integration, times roots of weights: products are integrals.

    Attributes
    ----------
    strain : (m, s, c) of c functions, so that a^T a is the stiffness [N/m]
    moving : (m, s, c), so that a^T a is the mass [kg]
    """

    strain: FloatArray
    moving: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class _Humps:
    """The matrices of the humps on E edges, and their coupling with k modes.

    Attributes
    ----------
    stiffness : (d E, d E) K_ww [N/m]
    mass : (d E, d E) M_ww [kg]
    stiff, heavy : (d E, k) K_wv v and M_wv v
    """

    stiffness: csr_matrix[Any]
    mass: csr_matrix[Any]
    stiff: FloatArray
    heavy: FloatArray


def excess_stiffness(solid: ElasticSolid, omega2: FloatArray, shapes: FloatArray) -> FloatArray:
    """(k,) excess of stiffness of the lowest modes of a mesh, omega^2 / omega_2^2 - 1 [-].

    Parameters
    ----------
    solid : the mesh and its material
    omega2 : (k,) ascending [rad^2/s^2]
    shapes : (N, d, k) displacements of the nodes, M-orthonormal
    """
    humps = _humps(solid, shapes)
    w = _solved(humps.stiffness, omega2 * humps.heavy - humps.stiff, solid.mesh.kind.dimension)
    both = []
    for own, matrix, coupling in (
        (np.diag(omega2), humps.stiffness, humps.stiff),
        (np.eye(len(omega2)), humps.mass, humps.heavy),
    ):
        cross = coupling.T @ w
        both.append(np.block([[own, cross], [cross.T, w.T @ (matrix @ w)]]))
    found = omega2 / _ritz_values(*both)[: len(omega2)] - 1.0
    if solid.mesh.kind.corners == 8:
        found = np.maximum(found, _jumps(solid, shapes) / omega2)
    return np.asarray(found)


def _jumps(solid: ElasticSolid, shapes: FloatArray) -> FloatArray:
    """(k,) energy of the difference between the nodal means of stress and the stress [rad^2/s^2]."""
    mean = nodal_stress(solid, nodal_gradients(solid), shapes)[[0, 1, 3, 2, 4, 5]]  # in the order of :func:`_strain`
    X, weight = _rule(solid.mesh)
    N, dN = shape_functions(solid.mesh.kind, X)
    soft = np.linalg.inv(np.linalg.cholesky(_elasticity(solid, len(mean))))
    scaled = np.einsum("ab,bnk->nak", soft, mean)
    energy = np.zeros(shapes.shape[2])
    for some in _parts(solid.mesh):
        cells = solid.mesh.cells[some]
        det = np.linalg.det(np.einsum("mni,qnj->mqij", solid.mesh.places[cells], dN))
        of_mean = np.sqrt(det * weight)[:, :, None, None] * np.einsum("qn,mnak->mqak", N, scaled[cells], optimize=True)
        own = _fields(solid, some, shapes)[1].strain
        energy += ((of_mean.reshape(own.shape) - own) ** 2).sum(axis=(0, 1))
    return energy


def _humps(solid: ElasticSolid, shapes: FloatArray) -> _Humps:
    mesh = solid.mesh
    _, edge = np.unique(mesh.edge_keys(), return_inverse=True)
    edge = edge.reshape(len(mesh.cells), -1)
    d = mesh.kind.dimension
    row = (d * edge[:, :, None] + np.arange(d)).reshape(len(edge), -1)
    size = d * (int(edge.max()) + 1)
    stiffness, mass, stiff, heavy = [], [], [], []
    for some in _parts(mesh):
        hump, mode = _fields(solid, some, shapes)
        over = np.swapaxes(hump.strain, 1, 2), np.swapaxes(hump.moving, 1, 2)
        stiffness.append(over[0] @ hump.strain)
        mass.append(over[1] @ hump.moving)
        stiff.append(over[0] @ mode.strain)
        heavy.append(over[1] @ mode.moving)
    free = np.ones(size)
    if solid.thickness is None:
        free[2 * edge[_on_axis(mesh)] + 1] = 0.0  # nothing on an axis of symmetry leaves it

    def assembled(parts: list[FloatArray]) -> csr_matrix[Any]:
        values = np.concatenate(parts) * free[row][:, :, None] * free[row][:, None, :]
        first, second = np.broadcast_arrays(row[:, :, None], row[:, None, :])
        return libs.sparse.coo_matrix((values.ravel(), (first.ravel(), second.ravel())), shape=(size, size)).tocsr()

    def gathered(parts: list[FloatArray]) -> FloatArray:
        values = np.concatenate(parts)
        columns = [np.bincount(row.ravel(), values[..., k].ravel(), size) for k in range(shapes.shape[2])]
        return free[:, None] * np.column_stack(columns)

    return _Humps(assembled(stiffness), assembled(mass), gathered(stiff), gathered(heavy))


def _parts(mesh: Mesh) -> Iterator[slice]:
    each = _rule(mesh)[1].size * 3 * mesh.kind.dimension**2 * max(len(mesh.kind.pairs), mesh.kind.nodes)
    step = max(1, AT_ONCE // each)
    return (slice(first, first + step) for first in range(0, len(mesh.cells), step))


def _rule(mesh: Mesh) -> tuple[FloatArray, FloatArray]:
    """Points (d, q) and weights (q,) of quadrature, all positive."""
    order = 6 if mesh.kind.quadratic else 4
    if mesh.kind.dimension == 3:
        order = 5
    X, weight = libs.skfem.quadrature.get_quadrature(getattr(libs.skfem, mesh.kind.element)(), order)
    return X, weight


def _on_axis(mesh: Mesh) -> np.ndarray[Any, np.dtype[np.bool_]]:
    """(m, corners) edges that lie on y = 0."""
    return np.asarray((mesh.places[mesh.cells[:, mesh.kind.edges()[:, :2]], 1] == 0.0).all(axis=2))


def _fields(solid: ElasticSolid, some: slice, shapes: FloatArray) -> tuple[_Fields, _Fields]:
    """The humps, (m, s, d edges), and the modes, (m, s, k), of some elements."""
    mesh = solid.mesh
    d = mesh.kind.dimension
    X, weight = _rule(mesh)
    N, dN = shape_functions(mesh.kind, X)
    cells = mesh.cells[some]
    corners = mesh.places[cells]
    radius = np.einsum("mn,qn->mq", corners[..., 1], N) if solid.thickness is None else None
    J = np.einsum("mni,qnj->mqij", corners, dN)
    depth = solid.thickness if radius is None else 2.0 * math.pi * radius
    det = np.linalg.det(J)
    area = det * weight * depth
    slopes = np.linalg.inv(J)
    measure = np.sqrt(area)[:, :, None, None]

    def strain_of(gradients: FloatArray, values: FloatArray) -> FloatArray:
        strain = _strain(gradients, values, radius)
        root = np.linalg.cholesky(_elasticity(solid, strain.shape[2]))
        return (measure * (root.T @ strain)).reshape(len(area), -1, strain.shape[3])

    def of(values: FloatArray, derivatives: FloatArray) -> _Fields:
        moving = np.zeros((*area.shape, d, values.shape[1], d))
        for axis in range(d):
            moving[:, :, axis, :, axis] = values
        moving = math.sqrt(solid.density) * measure * moving.reshape(*area.shape, d, -1)
        gradients = np.einsum("qnj,mqji->mqni", derivatives, slopes, optimize=True)
        return _Fields(strain_of(gradients, values), moving.reshape(len(area), -1, moving.shape[3]))

    own = of(N, dN)
    nodal = shapes[cells].reshape(len(cells), -1, shapes.shape[2])
    hump = of(*_hump(mesh, X))
    if mesh.kind.quadratic:  # the cubic ones are odd: two elements must mean the same one on the edge they share
        first, second = np.moveaxis(cells[:, mesh.kind.edges()[:, :2]], 2, 0)
        sign = np.repeat(np.where(first < second, 1.0, -1.0), d, axis=1)[:, None]
        hump = _Fields(sign * hump.strain, sign * hump.moving)
    strain = own.strain @ nodal
    if mesh.kind.name == "hexahedron":  # its incompatible modes give way
        bubbles = strain_of(bubble_gradients(solid, corners, X), np.zeros((X.shape[1], 3)))
        strain = strain + bubbles @ (bubble_amounts(solid, corners) @ nodal)
    return hump, _Fields(strain, own.moving @ nodal)


def _hump(mesh: Mesh, X: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Values (q, e) and derivatives (q, e, d) of the humps on the edges of the reference element."""
    kind = mesh.kind
    N, dN = shape_functions(kind.linear, X)
    i, j = np.array(kind.pairs).T
    if kind.simplex:
        along, across = 4.0 * N[:, i] * N[:, j], np.ones((N.shape[0], len(i)))
        d_along = 4.0 * (N[:, i, None] * dN[:, j] + N[:, j, None] * dN[:, i])
        d_across = 0.0 * d_along
        odd, d_odd = N[:, i] - N[:, j], dN[:, i] - dN[:, j]
    else:
        corners = reference_corners(kind)
        step = corners[j] - corners[i]
        edge, axis = np.arange(len(i)), np.abs(step).argmax(axis=1)  # along which it runs
        s, way = X[axis].T, step[edge, axis]
        along, across = 4.0 * s * (1.0 - s), N[:, i] + N[:, j]
        d_along, d_odd = np.zeros((2, len(N), len(i), kind.dimension))
        d_along[:, edge, axis], d_odd[:, edge, axis] = 4.0 * (1.0 - 2.0 * s), -2.0 * way
        d_across, odd = dN[:, i] + dN[:, j], way * (1.0 - 2.0 * s)
    value, slope = along * across, d_along * across[:, :, None] + along[:, :, None] * d_across
    if kind.quadratic:
        value, slope = value * odd, slope * odd[:, :, None] + value[:, :, None] * d_odd
    return value, slope


def _strain(gradients: FloatArray, values: FloatArray, radius: FloatArray | None) -> FloatArray:
    """(m, q, 3 or 6, d n) e_xx, e_yy, gamma_xy of n functions along x and y; in space e_xx, e_yy, e_zz, gamma_xy,
    gamma_yz, gamma_zx; with the hoop's u_r / r (m, q, 4, 2 n).
    """
    m, q, n, d = gradients.shape
    pairs = [(0, 1)] if d == 2 else [(0, 1), (1, 2), (2, 0)]
    strain = np.zeros((m, q, d + len(pairs) + (radius is not None), n, d))
    for axis in range(d):
        strain[:, :, axis, :, axis] = gradients[..., axis]
    for row, (a, b) in enumerate(pairs, start=d):
        strain[:, :, row, :, a] = gradients[..., b]
        strain[:, :, row, :, b] = gradients[..., a]
    if radius is not None:
        strain[:, :, 3, :, 1] = values / radius[:, :, None]
    return strain.reshape(m, q, -1, d * n)


def _elasticity(solid: ElasticSolid, strains: int) -> FloatArray:
    """Stress of the strains of :func:`_strain` [Pa]."""
    L, G = solid.lame
    direct = np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.0] if strains == 6 else [1.0, 1.0, 0.0, 1.0])
    return np.asarray((L * np.outer(direct, direct) + G * np.diag(1.0 + direct))[:strains, :strains])


def _solved(matrix: csr_matrix[Any], right: FloatArray, d: int) -> FloatArray:
    """x of A x = b (d E, k), by some steps of conjugate gradients; rows without entries keep x = 0."""
    blocks = np.empty((matrix.shape[0] // d, d, d))
    for a in range(d):
        for b in range(a, d):
            blocks[:, a, b] = blocks[:, b, a] = matrix.diagonal(b - a)[a::d]
    for a in range(d):
        blocks[:, a, a] = np.where(blocks[:, a, a] > 0.0, blocks[:, a, a], 1.0)
    inverse = np.linalg.inv(blocks)

    def relaxed(r: FloatArray) -> FloatArray:
        return np.asarray((inverse @ r.reshape(len(blocks), d, -1)).reshape(r.shape))

    x, left = np.zeros_like(right), right.copy()
    step = relaxed(left)
    square = (left * step).sum(axis=0)
    for _ in range(STEPS):
        if not square.max() > 0.0:
            break
        product = matrix @ step
        length = square / np.maximum((step * product).sum(axis=0), np.finfo(float).tiny)
        x += length * step
        left -= length * product
        better = relaxed(left)
        before, square = square, (left * better).sum(axis=0)
        step = better + square / np.maximum(before, np.finfo(float).tiny) * step
    return x


def _ritz_values(stiffness: FloatArray, mass: FloatArray) -> FloatArray:
    """Ascending omega^2 of small matrices, K positive semidefinite; dependent vectors count once."""
    own = np.diag(stiffness)
    scale = np.where(own > 0.0, 1.0 / np.sqrt(np.where(own > 0.0, own, 1.0)), 0.0)
    size, turn = np.linalg.eigh(stiffness * np.outer(scale, scale))
    kept = size > DEPENDENT
    basis = scale[:, None] * turn[:, kept] / np.sqrt(size[kept])
    return np.asarray(1.0 / np.linalg.eigvalsh(basis.T @ mass @ basis)[::-1])
