"""Rows in coordinates in which the matrix of the step is the identity: what large contact problems are made of.

With the arrow A = [[R, B^T], [B, D]] of a body (:mod:`lcpflex.dynamics.inertia`), D = C C^T and the Schur complement
R - B^T D^-1 B = L L^T, the row w = [w_R, w_f] turns into

    [ L^-1 (w_R - B^T D^-1 w_f),  C^-1 w_f ],

so that products of such rows are those of w A^-1 w^T.
"""

from __future__ import annotations

import math

from lcpflex.dynamics.inertia import Arrow
from lcpflex.jit.kernel import FloatArray, IntArray, kernel
from lcpflex.model.arrays import Bodies
from lcpflex.model.planar import N_RIGID

__all__ = ["whiten", "whiten_rows"]


@kernel
def whiten(bodies: Bodies, work: Arrow, b: int, row: FloatArray, out: FloatArray) -> None:
    """out (3 + n,) of a row (3 + n,) of body b, for the matrix factorised last; not of a user's own system."""
    first = bodies.dof[b] - N_RIGID * b
    n = bodies.dof[b + 1] - bodies.dof[b] - N_RIGID
    x, y, t = row[0], row[1], row[2]
    if work.full[b] != 0:
        start = work.dense_start[b]
        lower = work.dense[start : start + n * n].reshape((n, n))
        for k in range(n):
            modal, eased = row[N_RIGID + k], work.eased[first + k]
            x -= eased[0] * modal
            y -= eased[1] * modal
            t -= eased[2] * modal
            for j in range(k):
                modal -= lower[k, j] * out[N_RIGID + j]
            out[N_RIGID + k] = modal / lower[k, k] if lower[k, k] > 0.0 else 0.0  # a dependent one
    else:
        for k in range(n):
            modal, couple = row[N_RIGID + k], work.couple[first + k]
            scaled = work.diagonal[first + k] * modal
            x -= couple[0] * scaled
            y -= couple[1] * scaled
            t -= couple[2] * scaled
            out[N_RIGID + k] = math.sqrt(work.diagonal[first + k]) * modal
    rigid = work.rigid[b]
    out[0] = x / rigid[0, 0]
    out[1] = (y - rigid[1, 0] * out[0]) / rigid[1, 1]
    out[2] = (t - rigid[2, 0] * out[0] - rigid[2, 1] * out[1]) / rigid[2, 2]


@kernel
def whiten_rows(
    bodies: Bodies, work: Arrow, rows: FloatArray, row_body: IntArray, first: int, last: int, white: FloatArray
) -> None:
    """white[r] of rows[r], first <= r < last; both (rows, 2, width), by body."""
    for r in range(first, last):
        for i in range(2):
            b = row_body[r, i]
            if b >= 0:
                whiten(bodies, work, b, rows[r, i], white[r, i])
