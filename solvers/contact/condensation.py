"""Contact problems of other libraries in the form of this one: bodies eliminated, rows in order.

M v = H r + G y + f,  G^T v + b = 0,  u = H^T v + w   becomes   u = W r + q, where W = H^T K H and
q = H^T (K f + v_b) + w: K and v_b solve the equations of the bodies with their joints.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from lcpflex.basics import libs
from lcpflex.errors import ModelError
from lcpflex.jit.kernel import FloatArray
from lcpflex.solvers.contact.coupling import MOST_BLOCKS
from lcpflex.solvers.contact.matrices import as_dense, is_sparse
from lcpflex.solvers.contact.problem import ContactProblem
from lcpflex.solvers.contact.spatial import MOST_ENTRIES, SpatialContactProblem

__all__ = ["condensed", "condensed_sparse", "contact_problem", "multiplied_out", "planar_rows"]

COLUMNS = 64  # of the solves with sparse equations that are dense at a time
SMALL = 200  # rows up to which a sparse matrix saves nothing
SINGULAR = "M is singular: expected bodies whose motion can be eliminated"
CONDITION = 1e-14  # reciprocal condition number below which the equations of the bodies are singular


def condensed(
    M: FloatArray,
    H: FloatArray,
    f: FloatArray,
    w: FloatArray,
    G: FloatArray | None = None,
    b: FloatArray | None = None,
) -> tuple[FloatArray, FloatArray]:
    """W (m, m) and q (m,) of M (n, n), H (n, m), f (n,), w (m,), and of joints G (n, p), b (p,).

    Raises ModelError for singular equations.
    """
    n, p = len(M), 0 if G is None else G.shape[1]
    K = np.zeros((n + p, n + p))
    K[:n, :n] = M
    load = np.zeros((n + p, H.shape[1] + 1))
    load[:n, :-1], load[:n, -1] = H, f
    if G is not None and b is not None:
        K[:n, n:], K[n:, :n] = -G, G.T
        load[n:, -1] = -b
    if not n:
        return np.zeros((H.shape[1], H.shape[1])), w.copy()
    scale = 1.0 / np.sqrt(np.maximum(np.abs(K).max(axis=1), np.finfo(float).tiny))
    K = scale[:, None] * K * scale
    factorise: Any = libs.linalg.get_lapack_funcs("getrf", (K,))
    factor, pivots, zero = factorise(K)
    if zero or not _rcond(factor, float(np.abs(K).sum(axis=0).max())) > CONDITION:
        raise ModelError("M, with its joints, is singular: expected bodies whose motion can be eliminated")
    v = scale[:, None] * libs.linalg.lu_solve((factor, pivots), scale[:, None] * load)
    W = H.T @ v[:n, :-1]
    if np.allclose(M, M.T, rtol=1e-12, atol=0.0):
        W = 0.5 * (W + W.T)
    return W, H.T @ v[:n, -1] + w


def condensed_sparse(M: Any, H: Any, f: FloatArray, w: FloatArray) -> tuple[Any, FloatArray]:
    """The same of sparse M and H, without joints, where M couples few coordinates: W is sparse too.

    Raises ModelError for singular equations.
    """
    M, H = libs.sparse.csc_array(M), libs.sparse.csc_array(H)
    diagonal, peaks = np.abs(M.diagonal()), as_dense(abs(M).max(axis=1)).ravel()
    size = np.where(diagonal > 0.0, diagonal, peaks)  # of coordinates in any units
    scale: Any = libs.sparse.diags_array(1.0 / np.sqrt(np.maximum(size, np.finfo(float).tiny)))
    load = libs.sparse.csc_array(scale @ H)
    try:
        factor = libs.splu(libs.sparse.csc_array(scale @ M @ scale))
    except RuntimeError:
        raise ModelError(SINGULAR) from None
    if not np.abs(factor.U.diagonal()).min(initial=1.0) > CONDITION:  # of rows of size 1
        raise ModelError(SINGULAR)
    caused = [factor.solve(load[:, first : first + COLUMNS].toarray()) for first in range(0, H.shape[1], COLUMNS)]
    moved = libs.sparse.hstack([libs.sparse.csc_array(part) for part in caused], format="csc")
    W = libs.sparse.csr_array(load.T @ moved)
    if abs(M - M.T).max() <= 1e-12 * peaks.max():
        W = libs.sparse.csr_array(0.5 * (W + W.T))
    return W, load.T @ factor.solve(scale @ f) + w


def _rcond(factor: FloatArray, norm: float) -> float:
    """The reciprocal condition number of an LU factorisation."""
    if not np.isfinite(factor).all():
        return 0.0
    estimate: Any = libs.linalg.get_lapack_funcs("gecon", (factor,))
    return float(estimate(factor, norm)[0])


def contact_problem(W: Any, q: FloatArray, mu: FloatArray, dimension: int) -> ContactProblem | SpatialContactProblem:
    """Of W, q with rows (n, t) or (n, t1, t2) of each contact in turn; in the plane tangents without friction go.

    W: dense or scipy sparse, which stays so beyond 200 rows. Raises ModelError for sizes that do not fit.
    """
    rows = dimension * len(mu)
    if dimension not in (2, 3) or W.shape != (rows, rows) or q.shape != (rows,):
        raise ModelError(
            f"spacedim is {dimension}, W has shape {W.shape}, q {q.shape} and mu {mu.shape}: "
            "expected 2 or 3 rows for each coefficient"
        )
    if is_sparse(W) and rows <= SMALL:
        W = W.toarray()
    if dimension == 3:
        return SpatialContactProblem(W, q, mu)
    order = np.concatenate([np.arange(0, rows, 2), 2 * np.flatnonzero(mu) + 1])
    chosen = W.tocsr()[order][:, order] if is_sparse(W) else W[np.ix_(order, order)]
    return ContactProblem(chosen, q[order], mu)


def planar_rows(problem: ContactProblem) -> tuple[Any, FloatArray]:
    """W (2 k, 2 k) and q (2 k,) with rows (n, t) of each contact in turn, zero for tangents without friction.

    W is a CSR array. Raises ModelError where only the factor is known and bodies touch too many contacts to multiply it
    out.
    """
    rows = 2 * len(problem.friction)
    order = np.concatenate([np.arange(0, rows, 2), 2 * problem.tangent + 1])
    matrix = multiplied_out(problem)
    entries, q = libs.sparse.coo_array(matrix), np.zeros(rows)
    q[order] = problem.free
    places = order[entries.row], order[entries.col]
    return libs.sparse.csr_array((entries.data, places), shape=(rows, rows)), q


def multiplied_out(problem: ContactProblem | SpatialContactProblem) -> Any:
    """The Delassus operator of a problem in its own rows, dense or sparse.

    Raises ModelError where only the factor is known and bodies touch too many contacts to multiply it out.
    """
    matrix = problem.matrix() if isinstance(problem, SpatialContactProblem) else problem.sparse_delassus()
    if matrix is None:
        most = MOST_ENTRIES if isinstance(problem, SpatialContactProblem) else 4 * MOST_BLOCKS
        raise ModelError(f"factor @ factor.T has more than {most} entries: expected fewer, or delassus")
    return matrix
