"""Mass and stiffness matrices of a user: symmetric, free-free, in units that some material has."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from lcpflex.basics import libs
from lcpflex.bodies.body import array_of
from lcpflex.errors import ModelError, ModelWarning
from lcpflex.jit.kernel import FloatArray

if TYPE_CHECKING:
    from scipy.sparse import csc_matrix

__all__ = ["check_directions", "check_free", "check_units", "symmetric"]

SYMMETRIC = 1e-9  # largest asymmetry relative to the largest entry
SPEEDS = (0.3, 3e5)  # [m/s] of waves: ten times beyond materials, and room for scenes without units
RIGID = 1e-8  # largest K times rigid motion relative to |K| |rigid motion|


def symmetric(name: str, matrix: Any, n: int, layout: str) -> csc_matrix[Any]:
    """The matrix in compressed columns, exactly symmetric; refuses wrong shapes, NaN and asymmetry."""
    shape = getattr(matrix, "shape", None)
    if not libs.sparse.issparse(matrix):
        matrix = array_of(name, matrix, (n, n))
    elif shape != (n, n):
        raise ModelError(f"{name}: a matrix of shape {shape} was given, expected ({n}, {n}), {layout}")
    try:
        columns = libs.sparse.csc_matrix(matrix, dtype=np.float64, copy=True)
    except (TypeError, ValueError) as error:
        raise ModelError(f"{name}: expected a matrix of real numbers ({error})") from None
    if not np.isfinite(columns.data).all():
        bad = columns.data[~np.isfinite(columns.data)][0]
        raise ModelError(f"{name}: a matrix with {bad} in it was given, expected finite numbers only")
    size = float(np.abs(columns.data).max(initial=0.0))
    apart = float(abs(columns - columns.T).max()) if size else 0.0
    if apart > SYMMETRIC * size:
        raise ModelError(f"{name}: the matrix is unsymmetric by {apart / size:.3g} of its largest entry, expected 0")
    even = (0.5 * (columns + columns.T)).tocsc()
    even.eliminate_zeros()
    even.sort_indices()
    return even


def check_directions(mass: csc_matrix[Any], d: int) -> None:
    """Mass must be positive and the same in all d directions: a body falls alike in every attitude."""
    diagonal = mass.diagonal()
    if not diagonal.min() > 0.0:
        raise ModelError(f"mass: {diagonal.min():.6g} on its diagonal, expected a positive definite matrix")
    size = float(diagonal.max())
    along = mass[0::d, 0::d]
    alike = all(abs(along - mass[i::d, i::d]).max() <= SYMMETRIC * size for i in range(1, d))
    apart = all(abs(mass[i::d, j::d]).max() <= SYMMETRIC * size for j in range(d) for i in range(j))
    if not (alike and apart):
        axes = "x and y" if d == 2 else "x, y and z"
        raise ModelError(f"mass: it depends on the direction, expected equal {axes} parts and no coupling between them")


def check_free(stiffness: csc_matrix[Any], rigid: FloatArray, names: Sequence[str]) -> None:
    """K times each rigid motion, a column of (n, r), must vanish."""
    scale = (abs(stiffness) @ np.abs(rigid)).max(axis=0)
    for name, force, large in zip(names, np.abs(stiffness @ rigid).max(axis=0), scale, strict=True):
        if force > RIGID * large:
            raise ModelError(
                f"stiffness: it resists rigid {name} ({force / large:.3g} of its entries), expected a free-free body: "
                f"leave supports out of the matrices and hold the body by joints in the scene"
            )


def check_units(mass: csc_matrix[Any], stiffness: csc_matrix[Any], places: FloatArray) -> None:
    """Warn of waves that no material has: c = h sqrt(K_ii / M_ii) / 2 to a factor of about 2, h to the next node."""
    d = places.shape[1]
    linked = stiffness.tocoo()
    node, other = linked.row // d, linked.col // d
    arms = places[node] - places[other]
    distance = np.where(node == other, np.inf, np.sqrt((arms * arms).sum(axis=1)))
    near = np.full(len(places), np.inf)
    np.minimum.at(near, node, distance)
    rate = np.sqrt(np.maximum(stiffness.diagonal()[0::d], 0.0) / mass.diagonal()[0::d])
    known = np.isfinite(near) & (near > 0.0)
    found = 0.5 * near[known] * rate[known]
    speed = float(np.median(found)) if len(found) else SPEEDS[0]
    if not SPEEDS[0] <= speed <= SPEEDS[1]:
        warnings.warn(
            f"stiffness, mass, coordinates: waves run at about {speed:.2g} m/s, which no material has: expected "
            "N/m, kg and m (of matrices in N, mm and t: a thousand times each, and coordinates by a thousand)",
            ModelWarning,
            stacklevel=4,
        )
