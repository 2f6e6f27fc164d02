"""How much too stiff elements make the modes of a mesh, estimated from these modes at little cost.

Better elements on the same mesh have a hump on each edge besides the displacements v of their own, u = v + w: for
linear ones 4 N_i N_j on the edge i-j of a triangle and 4 s (1 - s) N on a quadrilateral, s along the edge and N linear
across; for quadratic ones that times N_i - N_j, or 1 - 2 s, which is cubic. What a mode v of the mesh lacks is in

    (K_ww - omega^2 M_ww) w = -(K_wv - omega^2 M_wv) v

where omega^2 M_ww on the left is left out: it is small by (element size / wave length)^2. K_ww is well conditioned
whatever the size of the elements, so that a few steps of conjugate gradients solve it, preconditioned by the 2 x 2
block of each edge. Ritz values omega_2^2 of all v and w together lie between those of the better elements and those of
the mesh, and the excess of stiffness is

    omega^2 / omega_2^2 - 1   [-]

which is at most that against quadratic, or cubic, elements. Pure bending, u_x = -x y, u_y = (x^2 + nu y^2) / 2, is of
the form v + w on straight-sided linear triangles and rectangles: there the excess is all of it.

Source: the hierarchical error estimator of Bank & Smith 1993, SIAM J. Numer. Anal. 30, 921.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from lcpflex.basics import libs
from lcpflex.bodies.fem.assembly import Solid, shape_functions
from lcpflex.bodies.fem.planar_mesh import KINDS, PlanarMesh
from lcpflex.jit.kernel import FloatArray

if TYPE_CHECKING:
    from scipy.sparse import csr_matrix

__all__ = ["excess_stiffness"]

STEPS = 8  # of conjugate gradients: ten come within 0.3 % of forty on graded triangles; fewer make the excess smaller
AT_ONCE = 4096  # elements: what is computed of them at a time stays small
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
    stiffness : (2 E, 2 E) K_ww [N/m]
    mass : (2 E, 2 E) M_ww [kg]
    stiff, heavy : (2 E, k) K_wv v and M_wv v
    """

    stiffness: csr_matrix[Any]
    mass: csr_matrix[Any]
    stiff: FloatArray
    heavy: FloatArray


def excess_stiffness(solid: Solid, omega2: FloatArray, shapes: FloatArray) -> FloatArray:
    """(k,) excess of stiffness of the lowest modes of a mesh, omega^2 / omega_2^2 - 1 [-].

    Parameters
    ----------
    solid : the mesh and its material
    omega2 : (k,) ascending [rad^2/s^2]
    shapes : (N, 2, k) displacements of the nodes, M-orthonormal
    """
    humps = _humps(solid, shapes)
    w = _solved(humps.stiffness, omega2 * humps.heavy - humps.stiff)
    both = []
    for own, matrix, coupling in (
        (np.diag(omega2), humps.stiffness, humps.stiff),
        (np.eye(len(omega2)), humps.mass, humps.heavy),
    ):
        cross = coupling.T @ w
        both.append(np.block([[own, cross], [cross.T, w.T @ (matrix @ w)]]))
    return np.asarray(omega2 / _ritz_values(*both)[: len(omega2)] - 1.0)


def _humps(solid: Solid, shapes: FloatArray) -> _Humps:
    mesh = solid.mesh
    _, edge = np.unique(mesh.edge_keys(), return_inverse=True)
    edge = edge.reshape(len(mesh.cells), -1)
    row = (2 * edge[:, :, None] + np.arange(2)).reshape(len(edge), -1)
    size = 2 * (int(edge.max()) + 1)
    stiffness, mass, stiff, heavy = [], [], [], []
    for some in _parts(len(edge)):
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


def _parts(count: int) -> Iterator[slice]:
    return (slice(first, first + AT_ONCE) for first in range(0, count, AT_ONCE))


def _on_axis(mesh: PlanarMesh) -> np.ndarray[Any, np.dtype[np.bool_]]:
    """(m, corners) edges that lie on y = 0."""
    return np.asarray((mesh.places[mesh.cells[:, mesh.kind.edges()[:, :2]], 1] == 0.0).all(axis=2))


def _fields(solid: Solid, some: slice, shapes: FloatArray) -> tuple[_Fields, _Fields]:
    """The humps, (m, s, 2 edges), and the modes, (m, s, k), of some elements."""
    mesh = solid.mesh
    X, weight = libs.skfem.quadrature.get_quadrature(
        getattr(libs.skfem, mesh.kind.element)(), 6 if mesh.kind.quadratic else 4
    )
    N, dN = shape_functions(mesh, X)
    cells = mesh.cells[some]
    corners = mesh.places[cells]
    radius = np.einsum("mn,qn->mq", corners[..., 1], N) if solid.thickness is None else None
    J = np.einsum("mni,qnj->mqij", corners, dN)
    depth = solid.thickness if radius is None else 2.0 * math.pi * radius
    area = np.linalg.det(J) * weight * depth
    slopes = np.linalg.inv(J)

    def of(values: FloatArray, derivatives: FloatArray) -> _Fields:
        strain = _strain(np.einsum("qnj,mqji->mqni", derivatives, slopes, optimize=True), values, radius)
        root = np.linalg.cholesky(_elasticity(solid, strain.shape[2]))
        moving = np.zeros((*area.shape, 2, values.shape[1], 2))
        moving[:, :, 0, :, 0] = moving[:, :, 1, :, 1] = values
        measure = np.sqrt(area)[:, :, None, None]
        strain = measure * (root.T @ strain)
        moving = math.sqrt(solid.density) * measure * moving.reshape(*area.shape, 2, -1)
        return _Fields(*(field.reshape(len(area), -1, field.shape[3]) for field in (strain, moving)))

    own = of(N, dN)
    nodal = shapes[cells].reshape(len(cells), -1, shapes.shape[2])
    hump = of(*_hump(mesh, X))
    if mesh.kind.quadratic:  # the cubic ones are odd: two elements must mean the same one on the edge they share
        first, second = np.moveaxis(cells[:, mesh.kind.edges()[:, :2]], 2, 0)
        sign = np.repeat(np.where(first < second, 1.0, -1.0), 2, axis=1)[:, None]
        hump = _Fields(sign * hump.strain, sign * hump.moving)
    return hump, _Fields(own.strain @ nodal, own.moving @ nodal)


def _hump(mesh: PlanarMesh, X: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Values (q, e) and derivatives (q, e, 2) of the humps on the edges 0-1, 1-2, ... of the reference element."""
    triangle = mesh.kind.corners == 3
    N, dN = shape_functions(replace(mesh, kind=KINDS["triangle" if triangle else "quad"]), X)
    i, j = mesh.kind.edges()[:, :2].T
    if triangle:
        along, across = 4.0 * N[:, i] * N[:, j], np.ones((N.shape[0], 3))
        d_along, d_across = 4.0 * (N[:, i, None] * dN[:, j] + N[:, j, None] * dN[:, i]), 0.0 * dN
        odd, d_odd = N[:, i] - N[:, j], dN[:, i] - dN[:, j]
    else:
        edge, axis = np.arange(4), np.arange(4) % 2  # along which it runs, the first two forwards
        s, way = X[axis].T, np.array([1.0, 1.0, -1.0, -1.0])
        along, across = 4.0 * s * (1.0 - s), N[:, i] + N[:, j]
        d_along, d_odd = np.zeros((2, *dN.shape))
        d_along[:, edge, axis], d_odd[:, edge, axis] = 4.0 * (1.0 - 2.0 * s), -2.0 * way
        d_across, odd = dN[:, i] + dN[:, j], way * (1.0 - 2.0 * s)
    value, slope = along * across, d_along * across[:, :, None] + along[:, :, None] * d_across
    if mesh.kind.quadratic:
        value, slope = value * odd, slope * odd[:, :, None] + value[:, :, None] * d_odd
    return value, slope


def _strain(gradients: FloatArray, values: FloatArray, radius: FloatArray | None) -> FloatArray:
    """(m, q, 3, 2 n) e_xx, e_yy, gamma_xy of n functions along x and y; with the hoop's u_r / r (m, q, 4, 2 n)."""
    m, q, n, _ = gradients.shape
    strain = np.zeros((m, q, 3 if radius is None else 4, n, 2))
    strain[:, :, 0, :, 0] = strain[:, :, 2, :, 1] = gradients[..., 0]
    strain[:, :, 1, :, 1] = strain[:, :, 2, :, 0] = gradients[..., 1]
    if radius is not None:
        strain[:, :, 3, :, 1] = values / radius[:, :, None]
    return strain.reshape(m, q, -1, 2 * n)


def _elasticity(solid: Solid, strains: int) -> FloatArray:
    """Stress of the strains of :func:`_strain` [Pa]."""
    L, G = solid.lame
    direct = np.array([1.0, 1.0, 0.0, 1.0])
    return np.asarray((L * np.outer(direct, direct) + G * np.diag(1.0 + direct))[:strains, :strains])


def _solved(matrix: csr_matrix[Any], right: FloatArray) -> FloatArray:
    """x of A x = b (2 E, k), by some steps of conjugate gradients; rows without entries keep x = 0."""
    own = matrix.diagonal()
    cross = matrix.diagonal(1)[::2]
    first, second = own[::2], own[1::2]
    second = np.where(second > 0.0, second, 1.0)
    det = first * second - cross**2

    def relaxed(r: FloatArray) -> FloatArray:
        out = np.empty_like(r)
        out[::2] = (second[:, None] * r[::2] - cross[:, None] * r[1::2]) / det[:, None]
        out[1::2] = (first[:, None] * r[1::2] - cross[:, None] * r[::2]) / det[:, None]
        return out

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
