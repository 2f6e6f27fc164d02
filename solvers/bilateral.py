"""Bilateral rows that are many, redundant, or cannot be eliminated, by the pseudoinverse."""

from __future__ import annotations

import numpy as np

from lcpflex.jit.kernel import FloatArray
from lcpflex.solvers.mixed.boxes import CANCELLED

__all__ = ["OUTSIDE", "eliminated", "sum_of"]

DEPENDENT = 1e-12  # singular value, relative, below which a bilateral row depends on others
OUTSIDE = 1e-9  # part of a column that is left over where it is outside of the range of the bilateral rows


def sum_of(A: FloatArray, left: FloatArray, right: FloatArray) -> FloatArray:
    """A + left @ right without its rounding."""
    return _cleared(A + left @ right, np.abs(A) + np.abs(left) @ np.abs(right))


def _cleared(total: FloatArray, terms: FloatArray) -> FloatArray:
    """The sums, 0 where nothing but rounding of their terms is left: it would pass for a push that nothing resists."""
    return np.asarray(np.where(np.abs(total) > CANCELLED * terms, total, 0.0))


def eliminated(MFF: FloatArray, MFB: FloatArray, qF: FloatArray) -> tuple[FloatArray | None, FloatArray, float]:
    """z_F = offset + gain x_B from M_FF z_F + M_FB x_B + q_F = 0, the shortest where rows are redundant.

    Also how far q_F contradicts the rows, relative. The gain is None where M_FF is singular in a way that would
    constrain x_B.
    """
    scale = np.sqrt(np.maximum(np.abs(MFF).max(axis=1, initial=0.0), np.finfo(float).tiny))
    try:
        inverse = np.linalg.pinv(MFF / np.outer(scale, scale), rcond=DEPENDENT) / np.outer(scale, scale)
    except np.linalg.LinAlgError:  # numbers too far apart for the singular values: the LCP takes them as they are
        return None, np.zeros(len(qF)), 0.0
    gain, offset = -inverse @ MFB, -inverse @ qF
    for _ in range(2):  # of the rounding of the inverse
        gain -= inverse @ (MFB + MFF @ gain)
        offset -= inverse @ (qF + MFF @ offset)
    size = np.abs(inverse)
    gain, offset = _cleared(gain, size @ np.abs(MFB)), _cleared(offset, size @ np.abs(qF))
    left = np.abs(MFB + MFF @ gain).max(initial=0.0)
    if left > OUTSIDE * np.abs(MFB).max(initial=0.0):
        return None, offset, 0.0
    load = np.abs(qF).max(initial=0.0)
    return gain, offset, float(np.abs(qF + MFF @ offset).max(initial=0.0) / load) if load > 0.0 else 0.0
