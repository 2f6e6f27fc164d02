"""From any basis of displacements to the own orthonormal basis of a body, without its rigid motions."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from lcpflex.bodies.reduction.eigenmodes import grams, judge, ritz
from lcpflex.errors import ModelError
from lcpflex.jit.kernel import FloatArray

if TYPE_CHECKING:
    from scipy.sparse import csc_matrix

__all__ = ["joined", "own_basis"]

DEPENDENT = 1e-13  # squared length, relative to the longest, below which a direction is rounding of the others


def own_basis(
    mass: csc_matrix[Any], stiffness: csc_matrix[Any], frame: FloatArray, basis: FloatArray, *, holds_rigid: bool
) -> tuple[FloatArray, FloatArray]:
    """(omega2, shapes) of the elastic motion in the span of a basis.

    Parameters
    ----------
    frame : (f, r) M-orthonormal rigid motions
    basis : (f, k) columns
    holds_rigid : whether the rigid motions are in its span: k - r elastic coordinates are in it then, at the most

    Raises
    ------
    ModelError
        If nothing elastic is left where there are columns for it, or some of it costs no energy.
    """
    if not basis.shape[1]:
        return np.zeros(0), basis
    gram, stiff = grams(mass, stiffness, basis)
    length = np.sqrt(np.diag(gram))
    scale = np.outer(length, length)
    gram, stiff = gram / scale, stiff / scale
    elastic = np.eye(len(gram))
    if holds_rigid:
        elastic = _complement(basis.T @ (mass @ frame) / length[:, None])
    squares, directions = np.linalg.eigh(_even(elastic.T @ gram @ elastic))
    kept = squares > DEPENDENT * squares.max(initial=0.0)
    turn = elastic @ (directions[:, kept] / np.sqrt(squares[kept]))
    turn = turn @ np.linalg.eigh(_even(turn.T @ stiff @ turn))[1]
    basis = basis @ (turn / length[:, None])
    basis -= frame @ (frame.T @ (mass @ basis))
    omega2, basis = ritz(stiffness, mass, basis)  # rounding of stiff columns has touched the soft combinations of them
    judge(float(omega2.min(initial=np.inf)), mass, stiffness, frame.shape[1])
    return omega2, basis


def _complement(rigid: FloatArray) -> FloatArray:
    """(k, k - r) orthonormal, orthogonal to the columns of (k, r)."""
    return np.asarray(np.linalg.qr(rigid, mode="complete").Q[:, rigid.shape[1] :])


def _even(matrix: FloatArray) -> FloatArray:
    return np.asarray(0.5 * (matrix + matrix.T))


def joined(low: tuple[FloatArray, FloatArray], high: tuple[FloatArray, FloatArray]) -> tuple[FloatArray, FloatArray]:
    """Two parts of one orthonormal basis that neither mass nor stiffness couples."""
    if len(low[0]) and len(high[0]) and not high[0].min() > 0.999 * low[0].max():
        raise ModelError(f"modes: {len(low[0])} were given, more than rounding lets apart from the static response")
    return np.concatenate([low[0], high[0]]), np.hstack([low[1], high[1]])
