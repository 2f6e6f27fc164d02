"""Orientations as users give them, and as a configuration holds them."""

from __future__ import annotations

from typing import Any

import numpy as np

from lcpflex.basics.arguments import numbers
from lcpflex.errors import ModelError, shown
from lcpflex.jit.kernel import FloatArray

__all__ = ["matrix_of", "quaternion_of"]

ORTHONORMAL = 1e-6  # how far the axes of a given matrix may be from unit vectors at right angles


def matrix_of(name: str, orientation: Any) -> FloatArray:
    """A (3, 3): its columns are the axes of the body in world axes.

    orientation: a scipy Rotation, such a matrix, or None for axes along those of the world.

    Raises
    ------
    ModelError
        For anything else: several rotations, axes that are not at right angles, left-handed ones, and four bare
        numbers, of which nobody could tell where the scalar is.
    """
    from scipy.spatial.transform import Rotation

    if orientation is None:
        return np.eye(3)
    if isinstance(orientation, Rotation):
        matrix = np.asarray(orientation.as_matrix())
        if matrix.shape != (3, 3):
            raise ModelError(f"{name}: {len(matrix)} rotations were given, expected one")
        if not np.isfinite(matrix).all():
            raise ModelError(f"{name}: a Rotation that is not finite was given, expected a rotation")
        return matrix
    given = numbers(orientation)
    if given is not None and given.shape == (4,):
        raise ModelError(
            f"{name}: four numbers were given, {shown(orientation)}, expected a scipy Rotation, such as "
            "Rotation.from_quat(...), or a 3 x 3 matrix: scipy writes the scalar of a quaternion last, others first"
        )
    if given is None or given.shape != (3, 3) or not np.isfinite(given).all():
        raise ModelError(f"{name}: {shown(orientation)} was given, expected a scipy Rotation, a 3 x 3 matrix or None")
    off = float(np.abs(given.T @ given - np.eye(3)).max())
    if off > ORTHONORMAL:
        raise ModelError(
            f"{name}: a matrix was given whose axes are off unit vectors at right angles by {off:.3g}, expected a "
            f"rotation matrix (up to {ORTHONORMAL:g})"
        )
    if np.linalg.det(given) < 0.0:
        raise ModelError(f"{name}: a left-handed frame was given (determinant -1), expected a rotation matrix")
    return np.asarray(Rotation.from_matrix(given).as_matrix())


def quaternion_of(matrix: FloatArray) -> FloatArray:
    """(4,) unit quaternion of a rotation matrix, scalar first and >= 0."""
    from scipy.spatial.transform import Rotation

    x, y, z, w = Rotation.from_matrix(matrix).as_quat()
    p = np.array([w, x, y, z])
    return np.asarray((p if w >= 0.0 else -p) / np.linalg.norm(p))
