"""Elements of straight beams in space: stretching, torsion, and bending in two planes, with shear or without.

A node has the degrees of freedom (u, v, w, h phi, h b, h c), all lengths, with the length h of an element, the rotation
phi about the axis x, and the slopes b, c of the section in the planes xy and xz. The material at (y, z) of a section
moves by

    N d = (u - y b - z c,  v - z phi,  w + y phi)  and turns by  (phi, -c, b)

u and phi are linear between nodes; v, b and w, c are what a beam does that is loaded at nodes alone, with the shear
parameter s = 12 E I / (k G A h^2) (Friedman & Kosmatka 1993). For s = 0 they are Hermite's cubics, b = v'.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from lcpflex.basics import libs
from lcpflex.jit.kernel import FloatArray, IntArray

if TYPE_CHECKING:
    from scipy.sparse import csc_matrix

__all__ = [
    "DOFS",
    "BeamMesh",
    "bending_shapes",
    "gauss_points",
    "gradients",
    "scattered",
    "section_fields",
    "shapes_on_axis",
    "strains",
]

DOFS = 6  # of a node
GAUSS = 4  # points of an element: exact for products of two cubics, or of one with a place
U, V, W, PHI, B, C = range(DOFS)  # degrees of freedom of a node
SHEARED = np.array([-1.0, -0.5, 1.0, -0.5])  # h times the shear strain of (v1, h b1, v2, h b2), over s / (1 + s)


class BeamMesh(NamedTuple):
    """A line of equal elements along x, its middle at the origin."""

    elements: int
    length: float
    shear: tuple[float, float]  # s of bending in the planes xy and xz

    @property
    def h(self) -> float:
        """Length of an element [m]."""
        return self.length / self.elements

    @property
    def nodes(self) -> FloatArray:
        """(elements + 1,) places of the nodes on the axis [m]."""
        return np.asarray(self.length * (np.arange(self.elements + 1) / self.elements - 0.5))

    def at(self, x: FloatArray | float) -> tuple[IntArray, FloatArray]:
        """Element (k,) of places on the axis, that behind of a node but the last, and xi (k,) in it."""
        along = (np.atleast_1d(x) + 0.5 * self.length) / self.h
        element = np.clip(along.astype(np.int64), 0, self.elements - 1)
        return element, along - element

    def rows(self, element: IntArray | int) -> IntArray:
        """(12,) or (k, 12) degrees of freedom of elements."""
        return np.asarray(DOFS * np.asarray(element)[..., None] + np.arange(2 * DOFS))


def bending_shapes(xi: FloatArray, s: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Deflection v, slope h b and curvature h^2 b' (k, 4) of (v1, h b1, v2, h b2), at xi (k,) in [0, 1]."""
    m = 1.0 / (1.0 + s)
    x, one = xi, np.ones_like(xi)
    v = [2 * x**3 - 3 * x**2 - s * x + 1 + s, x**3 - (2 + s / 2) * x**2 + (1 + s / 2) * x,
         -(2 * x**3 - 3 * x**2 - s * x), x**3 - (1 - s / 2) * x**2 - s / 2 * x]  # fmt: skip
    slope = [6 * (x**2 - x), 3 * x**2 - (4 + s) * x + 1 + s, -6 * (x**2 - x), 3 * x**2 - (2 - s) * x]
    bent = [6 * (2 * x - 1), 6 * x - (4 + s) * one, -6 * (2 * x - 1), 6 * x - (2 - s) * one]
    return m * np.stack(v, 1), m * np.stack(slope, 1), m * np.stack(bent, 1)


def gauss_points(mesh: BeamMesh) -> tuple[IntArray, FloatArray, FloatArray]:
    """Element (k,), place xi in it (k,), and length dx (k,) that the point stands for [m]."""
    x, w = np.polynomial.legendre.leggauss(GAUSS)
    element = np.repeat(np.arange(mesh.elements), GAUSS)
    return element, np.tile(0.5 * (x + 1.0), mesh.elements), np.tile(0.5 * mesh.h * w, mesh.elements)


def section_fields(mesh: BeamMesh, xi: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Displacement and rotation of sections, each (k, 3, 12), by the degrees of freedom of their element.

    The material at (y, z) moves by displacement + rotation x (0, y, z).
    """
    h = mesh.h
    move, turn = np.zeros((2, len(xi), 3, 2 * DOFS))
    ends = np.stack([1.0 - xi, xi], axis=1)
    first, second = np.array([0, DOFS])[:, None] + np.arange(DOFS)
    move[:, 0, [first[U], second[U]]] = ends
    turn[:, 0, [first[PHI], second[PHI]]] = ends / h
    for axis, across, slope, s, about, sign in ((1, V, B, mesh.shear[0], 2, 1.0), (2, W, C, mesh.shear[1], 1, -1.0)):
        v, b, _ = bending_shapes(xi, s)
        columns = [first[across], first[slope], second[across], second[slope]]
        move[:, axis, columns] = v
        turn[:, about, columns] = sign * b / h
    return move, turn


def shapes_on_axis(
    shapes: FloatArray, length: float, shear: tuple[float, float], x: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Displacement and rotation (k, 3, n) of sections at x (k,) by modes that are known at nodes (nodes, 6, n)."""
    mesh = BeamMesh(len(shapes) - 1, length, shear)
    element, xi = mesh.at(x)
    own = np.concatenate([shapes[element], shapes[element + 1]], axis=1)
    move, turn = (np.einsum("gik,gkn->gin", field, own) for field in section_fields(mesh, xi))
    return move, turn


def gradients(mesh: BeamMesh, xi: FloatArray) -> FloatArray:
    """(k, 3, 12) twist phi' and slopes v', w' of the axis, by the degrees of freedom of their element.

    v' = b + the shear strain, which :func:`strains` has.
    """
    h = mesh.h
    rates = np.zeros((len(xi), 3, 2 * DOFS))
    rates[:, 0, [PHI, DOFS + PHI]] = np.array([-1.0, 1.0]) / h**2
    for row, across, slope, s in ((1, V, B, mesh.shear[0]), (2, W, C, mesh.shear[1])):
        sheared = s / (1.0 + s) * SHEARED
        rates[:, row, [across, slope, DOFS + across, DOFS + slope]] = (bending_shapes(xi, s)[1] + sheared) / h
    return rates


def strains(mesh: BeamMesh, axial: float, torsion: float, bending: tuple[float, float]) -> csc_matrix[Any]:
    """(rows, f) sparse E with the strain energy |E d|^2 / 2, of E A, G I_t, and E I in the planes xy and xz.

    The shear strain v' - b is constant in an element: -s m / 2 of (2 v1 - 2 v2 + h b1 + h b2) / h, m = 1 / (1 + s), and
    k G A = 12 E I / (s h^2).
    """
    h = mesh.h
    x, w = np.polynomial.legendre.leggauss(2)
    xi = 0.5 * (x + 1.0)
    parts = []
    for stiffness, dof in ((axial / h, U), (torsion / h**3, PHI)):
        row = np.zeros(2 * DOFS)
        row[[dof, DOFS + dof]] = [-1.0, 1.0]
        parts.append(np.sqrt(stiffness) * row)
    for rigidity, across, slope, s in zip(bending, (V, W), (B, C), mesh.shear, strict=True):
        columns = [across, slope, DOFS + across, DOFS + slope]
        for weight, bent in zip(0.5 * w, bending_shapes(xi, s)[2], strict=True):
            row = np.zeros(2 * DOFS)
            row[columns] = np.sqrt(weight * rigidity / h**3) * bent
            parts.append(row)
        if s > 0.0:
            row = np.zeros(2 * DOFS)
            row[columns] = np.sqrt(12.0 * rigidity * s / h**3) / (1.0 + s) * -SHEARED
            parts.append(row)
    block = np.array(parts)
    return scattered(mesh, np.tile(block, (mesh.elements, 1, 1)), np.arange(mesh.elements))


def scattered(mesh: BeamMesh, blocks: FloatArray, element: IntArray) -> csc_matrix[Any]:
    """(k r, f) sparse, of rows (k, r, 12) that belong to the elements (k,)."""
    k, r, _ = blocks.shape
    rows = np.repeat(np.arange(k * r), 2 * DOFS)
    columns = np.repeat(mesh.rows(element)[:, None], r, axis=1)
    shape = (k * r, DOFS * (mesh.elements + 1))
    matrix: csc_matrix[Any] = libs.sparse.csc_matrix((blocks.ravel(), (rows, columns.ravel())), shape=shape)
    matrix.eliminate_zeros()
    return matrix
