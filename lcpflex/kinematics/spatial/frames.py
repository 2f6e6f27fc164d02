"""Rotations of many instants at once, for what is told of runs: numpy, where kernels take one at a time."""

from __future__ import annotations

import numpy as np

from lcpflex.jit.kernel import FloatArray

__all__ = ["matrices", "rotated", "small_rotations"]

SMALL = 1e-4  # [rad] below which the exponential is a series


def matrices(p: FloatArray) -> FloatArray:
    """A(p) (..., 3, 3) of unit quaternions p (..., 4), scalar first."""
    w, x, y, z = np.moveaxis(p, -1, 0)
    rows = (
        (1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)),
        (2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)),
        (2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)),
    )
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def rotated(p: FloatArray, s: FloatArray) -> FloatArray:
    """A(p) s: p (..., 4), s (..., 3)."""
    w, v = p[..., :1], p[..., 1:]
    t = 2.0 * np.cross(v, s)
    return np.asarray(s + w * t + np.cross(v, t))


def small_rotations(psi: FloatArray) -> FloatArray:
    """E(psi) = exp(psi~) (..., 3, 3) of rotation vectors psi (..., 3) [rad]."""
    angle = np.linalg.norm(psi, axis=-1, keepdims=True)
    half = 0.5 * angle
    share = np.where(angle < SMALL, 0.5 - angle * angle / 48.0, np.sin(half) / np.where(angle > 0.0, angle, 1.0))
    return matrices(np.concatenate([np.cos(half), share * psi], axis=-1))
