"""Free modes of a straight uniform line of equal finite elements: stretching and bending.

Everything is computed for unit element length and unit element mass; the physical size enters at the end. So the
numbers that the eigensolver sees do not depend on units, and a mesh gives the same shapes in any.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from lcpflex.basics import libs
from lcpflex.basics.blas import one_thread
from lcpflex.bodies.reduction.damping import signed
from lcpflex.bodies.reduction.eigenmodes import free_modes
from lcpflex.jit.kernel import FloatArray

__all__ = ["LineModes", "bending_modes", "interpolate", "mixed_mass", "stretching_modes"]

# Consistent mass of a cubic Hermite element in (w1, h theta1, w2, h theta2), per element mass
_HERMITE_MASS = (
    np.array([[156, 22, 54, -13], [22, 4, 13, -3], [54, 13, 156, -22], [-13, -3, -22, 4]], dtype=np.float64) / 420.0
)
# h^2 w'' = row 0 + xi row 1 / sqrt(1/3), xi in [-1, 1]: the strain energy is the sum of the two squares
_CURVATURE = np.array([[0, -1, 0, 1], [2 * 3**0.5, 3**0.5, -2 * 3**0.5, 3**0.5]], dtype=np.float64)
# integral of (linear shape) (Hermite shape), per element mass
_MIXED_MASS = np.array([[21, 3, 9, -2], [9, 2, 21, -3]], dtype=np.float64) / 60.0


class LineModes(NamedTuple):
    """Modes of a line of elements, at its nodes: stretch u (nodes, n), deflection w (nodes, n), rotation (nodes, n)."""

    omega2: FloatArray
    stretch: FloatArray
    deflection: FloatArray
    rotation: FloatArray


def stretching_modes(
    elements: int, length: float, mass: float, rigidity: float, count: int, lumped: bool
) -> tuple[FloatArray, FloatArray]:
    """The ``count`` lowest longitudinal modes of a free line of linear elements: closed form.

    With phase p_k = k pi / N the shapes are cos(p_k i) at node i = 0 ... N, and with h = L / N

        omega_k^2 = (EA / h) / (m / N) 2 (1 - cos p_k) / f_k,   f_k = (2 + cos p_k) / 3, or 1 if the mass is lumped

    Returns omega2 (count,) [rad^2/s^2] and shapes (nodes, count) [kg^-1/2], M-orthonormal.
    """
    order = np.arange(1, count + 1)
    multiple = np.outer(np.arange(elements + 1), order) % (2 * elements)  # exact: no phase error in long lines
    shapes = np.cos(np.pi * multiple / elements)
    phase = np.pi * order / elements
    inertia = np.ones(count) if lumped else (2.0 + np.cos(phase)) / 3.0
    stiffness = 4.0 * np.sin(0.5 * phase) ** 2  # 2 (1 - cos p) without cancellation
    element_mass = mass / elements
    omega2 = rigidity * elements / length / element_mass * stiffness / inertia
    weight = np.where(order == elements, float(elements), 0.5 * elements)  # sum of cos^2, ends halved
    return omega2, shapes / np.sqrt(element_mass * inertia * weight)


def bending_modes(
    elements: int, length: float, mass: float, rigidity: float, count: int
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """The ``count`` lowest bending modes of a free line of cubic Hermite elements, consistent mass.

    Returns omega2 (count,) [rad^2/s^2], deflection w (nodes, count) [kg^-1/2] and rotation w' (nodes, count).
    """
    n = 2 * (elements + 1)
    dofs = 2 * np.arange(elements)[:, None] + np.arange(4)
    rows = np.repeat(np.arange(2 * elements), 4)
    curvature = libs.sparse.csc_matrix(
        (np.tile(_CURVATURE.ravel(), elements), (rows, np.repeat(dofs, 2, axis=0).ravel()))
    )
    mass_matrix = libs.sparse.csc_matrix(
        (np.tile(_HERMITE_MASS.ravel(), elements), (np.repeat(dofs, 4, axis=1).ravel(), np.tile(dofs, 4).ravel()))
    )
    node = np.arange(elements + 1) - 0.5 * elements
    rigid = np.zeros((n, 2))
    rigid[0::2, 0] = 1.0
    rigid[0::2, 1] = node
    rigid[1::2, 1] = 1.0
    _, shapes = free_modes(mass_matrix, (curvature.T @ curvature).tocsc(), rigid, count)
    # Rounding in K hides low frequencies of many elements (omega^2 ~ N^-4); strains keep twice the digits.
    with one_thread(n):
        _, strain, turn = np.linalg.svd(np.asarray(curvature @ shapes), full_matrices=False)
    shapes = signed(shapes @ turn[::-1].T, np.arange(n) % 2 == 0)
    h = length / elements
    element_mass = mass / elements
    shapes = shapes / np.sqrt(element_mass)
    return strain[::-1] ** 2 * (rigidity / h**3 / element_mass), shapes[0::2], shapes[1::2] / h


def mixed_mass(stretch: FloatArray, deflection: FloatArray, rotation: FloatArray, mass: float, h: float) -> FloatArray:
    """(n, k) integrals <u w> of linear fields u with Hermite fields w; ``mass`` of one element, ``h`` its length."""
    total = np.zeros((stretch.shape[1], deflection.shape[1]))
    ends = (deflection[:-1], h * rotation[:-1], deflection[1:], h * rotation[1:])
    for end, part in enumerate((stretch[:-1], stretch[1:])):
        for k, shape in enumerate(ends):
            total += _MIXED_MASS[end, k] * (part.T @ shape)
    return mass * total


def interpolate(modes: LineModes, h: float, station: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Stretch u, deflection w and slope w' (k, n) at the stations (k,) along a line of elements of length h."""
    elements = len(modes.stretch) - 1
    place = np.minimum(np.maximum(station / h, 0.0), float(elements))
    first = np.minimum(place.astype(np.int64), elements - 1)
    s = (place - first)[:, None]
    second = first + 1
    stretch = (1.0 - s) * modes.stretch[first] + s * modes.stretch[second]
    w1, w2 = modes.deflection[first], modes.deflection[second]
    r1, r2 = h * modes.rotation[first], h * modes.rotation[second]
    rise = w2 - w1
    deflection = w1 + s * (r1 + s * (3.0 * rise - 2.0 * r1 - r2 + s * (r1 + r2 - 2.0 * rise)))
    slope = (r1 + s * (2.0 * (3.0 * rise - 2.0 * r1 - r2) + s * 3.0 * (r1 + r2 - 2.0 * rise))) / h
    return stretch, deflection, slope
