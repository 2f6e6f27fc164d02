"""What inertia integrals of a spatial body must be, whoever gives them."""

from __future__ import annotations

from typing import Any

import numpy as np

from lcpflex.basics import libs
from lcpflex.basics.arguments import array_of
from lcpflex.errors import ModelError, shown
from lcpflex.jit.kernel import FloatArray

__all__ = ["axes_of", "check_inertia", "check_products", "even", "skew_part"]

SYMMETRIC = 1e-9  # largest asymmetry relative to the largest entry
TRIANGLE = 1e-6  # of the trace: by how much rounded data may miss the triangle inequality
THIN = 1e-10  # smallest over largest principal moment, below which a rotation is not resisted
ORTHONORMAL = 1e-9  # of axes


def even(name: str, matrix: FloatArray) -> FloatArray:
    """The symmetric part; refuses a matrix (k, k) that is not symmetric to rounding."""
    size = float(np.abs(matrix).max(initial=0.0))
    apart = float(np.abs(matrix - matrix.T).max(initial=0.0))
    if apart > SYMMETRIC * size:
        raise ModelError(f"{name}: the matrix is unsymmetric by {apart / size:.3g} of its largest entry, expected 0")
    return np.asarray(0.5 * (matrix + matrix.T))


def check_inertia(mass: float, moment: FloatArray, second: FloatArray, S: FloatArray, first: FloatArray) -> None:
    """Refuse integrals that no distribution of mass can have, and mass on a line or in a point.

    Raises
    ------
    ModelError
        Naming what is wrong with them, and by how much.
    """
    central = second - np.outer(moment, moment) / mass
    trace = float(np.trace(central))
    if not trace > THIN * float(np.trace(second)):
        raise ModelError(
            "inertia: it is that of a point mass about its mass centre, expected more: nothing resists a rotation of "
            "it. Give a Sphere of a small radius: one of 1e-3 of a pendulum's length changes its period by 2e-7"
        )
    own = np.linalg.eigvalsh(central)  # of P0 about the centre; the principal moments are sums of two of them
    if own[0] < -TRIANGLE * trace:
        a, b, c = trace - own
        raise ModelError(
            f"inertia: the principal moments about the mass centre are {c:.6g}, {b:.6g}, {a:.6g} kg m^2, expected each "
            "to be at most the sum of the two others (products of inertia belong into the matrix with a minus sign)"
        )
    if own[0] + own[1] < THIN * trace:
        raise ModelError(
            f"inertia: the principal moments about the mass centre are {own[0] + own[1]:.3g}, {trace - own[1]:.6g}, "
            f"{trace - own[0]:.6g} kg m^2, expected the smallest to be above {THIN:g} of the largest: nothing resists "
            "a rotation about the line that the mass lies on. Give it a radius"
        )
    _check_coupling(mass, moment, second, S, first)


def _check_coupling(mass: float, moment: FloatArray, second: FloatArray, S: FloatArray, first: FloatArray) -> None:
    """The frame must keep inertia while the modes follow freely: M_rr - M_rf M_fr is positive definite."""
    if not len(S):
        return
    rigid = np.zeros((6, 6))
    rigid[:3, :3] = mass * np.eye(3)
    rigid[3:, :3] = skew(moment)
    rigid[:3, 3:] = rigid[3:, :3].T
    rigid[3:, 3:] = np.trace(second) * np.eye(3) - second
    coupled = np.hstack([S, skew_part(first)])
    scale = 1.0 / np.sqrt(np.diag(rigid))
    left = (rigid - coupled.T @ coupled) * np.outer(scale, scale)
    least = float(np.linalg.eigvalsh(left)[0])
    if not least > 1e-13:
        raise ModelError(
            f"S, first: the modes carry more mass or inertia than the body has (by {-least:.3g}), expected "
            "<Phi> and <x Phi^T> of modes with <Phi_l . Phi_k> = 1 or 0"
        )


def check_products(products: FloatArray, n: int) -> FloatArray:
    """(n2, n2, 9) with exact symmetry, P2_kl = P2_lk^T; refuses what no orthonormal modes have.

    Raises
    ------
    ModelError
        For more modes than there are, no such symmetry, or traces <Phi_l . Phi_k> that are not 1 and 0.
    """
    n2 = len(products)
    if products.shape[1] != n2 or n2 > n:
        raise ModelError(
            f"products: an array of shape {products.shape} was given, expected shape (n2, n2, 9) with n2 <= {n} modes"
        )
    if not n2:
        return products
    pairs = products.reshape(n2, n2, 3, 3)
    mirrored = pairs.transpose(1, 0, 3, 2)
    apart = float(np.abs(pairs - mirrored).max())
    if apart > 1e-8:
        raise ModelError(f"products: [l, k, 3 i + j] and [k, l, 3 j + i] differ by {apart:.3g}, expected equal ones")
    found = 0.5 * (pairs + mirrored)
    off = float(np.abs(np.trace(found, axis1=2, axis2=3) - np.eye(n2)).max())
    if off > 1e-7:
        raise ModelError(f"products: <Phi_l . Phi_k> misses 1 and 0 by {off:.3g}, expected orthonormal modes")
    whole = found.reshape(n2, n2, 9)
    whole.setflags(write=False)
    return whole


def skew(a: FloatArray) -> FloatArray:
    """(3, 3) a~ with a~ b = a x b."""
    return np.array([[0.0, -a[2], a[1]], [a[2], 0.0, -a[0]], [-a[1], a[0], 0.0]])


def skew_part(first: FloatArray) -> FloatArray:
    """(n, 3) c_k = <x x Phi_k> of P1 (n, 9)."""
    P = first.reshape(-1, 3, 3)
    return np.stack([P[:, 1, 2] - P[:, 2, 1], P[:, 2, 0] - P[:, 0, 2], P[:, 0, 1] - P[:, 1, 0]], axis=1)


def axes_of(name: str, value: Any) -> FloatArray:
    """(3, 3) with three orthonormal directions as columns: of a matrix, a rotation of scipy, or None for those at hand.

    Raises
    ------
    ModelError
        For axes that are not orthonormal to 1e-9, or left-handed; and for four numbers, whose order nothing tells.
    """
    if value is None:
        return np.eye(3)
    if isinstance(value, libs.Rotation):
        value = value.as_matrix()
    axes = array_of(name, value, (3, 3))
    off = float(np.abs(axes.T @ axes - np.eye(3)).max())
    if off > ORTHONORMAL:
        raise ModelError(
            f"{name}: {shown(axes.tolist())} was given, whose columns are off orthonormal ones by {off:.3g}, expected "
            "unit directions at right angles to each other, to 1e-9"
        )
    if np.linalg.det(axes) < 0.0:
        raise ModelError(f"{name}: {shown(axes.tolist())} was given, which is left-handed, expected right-handed axes")
    return axes
