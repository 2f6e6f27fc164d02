"""Exponents s of small motions y exp(s t) under joints, (s^2 M + s D + K) y + J^T mu = 0, J y = 0.

Few coordinates: all exponents, of the motions that the joints leave free. Many: those nearest to 0, by Arnoldi's
method on the inverse about a small positive shift,

    [ K + s0 D + s0^2 M   J^T ] [ y  ]     [ -(M c2 + D c1 + s0 M c1) ]
    [ J                  -eps ] [ mu ]  =  [ 0                        ],    z = c1 + s0 y,    (y, z) = (A - s0 B)^-1 B c

of one sparse factor. eps gives redundant rows a solution; that joints hold all the same is checked.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from lcpflex.basics import libs
from lcpflex.errors import SolverError
from lcpflex.jit.kernel import FloatArray, IntArray

if TYPE_CHECKING:
    import numpy.typing as npt
    from scipy.sparse import csr_matrix

__all__ = ["all_exponents", "local_rate", "loose", "lowest_exponents", "nearest", "saddle"]

INDEPENDENT = 1e-10  # of joint rows
YIELDING = 1e-10  # compliance of joints, of that of the scaled coordinates
REFINED = 2  # times that a solution is corrected for the compliance of joints: each takes out all but its share
HELD = 1e-6  # of a motion: what joints let through at most
LEFT = 1e-8  # of all forces that act in a motion, cancelled or not: derivatives are known to 1e-10 or so of them
SPARE = 10  # exponents that are looked for besides, lest the last ones be half a pair
SHIFT = 1e-2  # of the slowest local frequency


def all_exponents(M: Any, D: Any, K: Any, free: FloatArray) -> npt.NDArray[np.complex128]:
    """(2 f,) of the motions ``free`` (ndof, f)."""
    M, D, K = (free.T @ (A @ free) for A in (M, D, K))
    zero, one = np.zeros_like(M), np.eye(len(M))
    found = np.linalg.eigvals(np.block([[zero, one], [-np.linalg.solve(M, K), -np.linalg.solve(M, D)]]))
    return np.asarray(found, dtype=np.complex128)


def loose(J: FloatArray, scale: FloatArray) -> FloatArray:
    """(ndof, f) basis of the motions that the joints leave free, orthonormal in parts of ``scale``."""
    _, sizes, rows = np.linalg.svd(J * scale)
    rank = int((sizes > INDEPENDENT * sizes.max(initial=0.0)).sum())
    return np.asarray(scale[:, None] * rows[rank:].T)


def saddle(Q: csr_matrix[Any], J: csr_matrix[Any], scale: FloatArray) -> Any:
    """Solves Q y + J^T mu = f, J y = g: a function of f (ndof,) and g (m,) that returns y and mu."""
    S = libs.sparse.diags(scale)
    Q, J = (S @ Q @ S).tocsr(), (J @ S).tocsr()
    lengths = np.sqrt(np.asarray(J.multiply(J).sum(axis=1)).ravel())
    rows = libs.sparse.diags(1.0 / np.where(lengths > 0.0, lengths, 1.0))
    J = (rows @ J).tocsr()
    stiff = float(np.median(np.abs(Q.diagonal())[np.abs(Q.diagonal()) > 0.0], axis=0)) if Q.nnz else 1.0
    J = J * stiff  # multipliers as large as forces are
    yielding = -YIELDING * stiff * libs.sparse.identity(J.shape[0])
    blocks: Any = [[Q, J.T], [J, None]], [[Q, J.T], [J, yielding]]
    exact = libs.sparse.bmat(blocks[0], format="csr")
    try:
        factor = libs.splu(libs.sparse.bmat(blocks[1], format="csc"))
    except RuntimeError as error:
        raise SolverError(f"the stiffness has no factor: {error}") from None
    n = len(scale)

    def solve(f: FloatArray, g: FloatArray) -> tuple[FloatArray, FloatArray]:
        right = np.concatenate([scale * f, stiff * (rows @ g)])
        x = factor.solve(right)
        for _ in range(REFINED):
            x += factor.solve(right - exact @ x)
        return scale * x[:n], stiff * (rows @ x[n:])

    return solve


def local_rate(M: csr_matrix[Any], K: csr_matrix[Any]) -> float:
    """The slowest rate [1/s] that the diagonals tell; 1 where nothing has a stiffness."""
    rates = np.sqrt(np.abs(K.diagonal()) / M.diagonal())
    rates = rates[rates > INDEPENDENT * rates.max(initial=0.0)]
    return float(rates.min(initial=np.inf)) if len(rates) else 1.0


def lowest_exponents(
    M: csr_matrix[Any], D: csr_matrix[Any], K: csr_matrix[Any], J: csr_matrix[Any], scale: FloatArray, count: int
) -> npt.NDArray[np.complex128]:
    """The 2 ``count`` exponents nearest to 0. Raises SolverError where they could not be found."""
    n = M.shape[0]
    rate = local_rate(M, K)
    shift = SHIFT * rate
    solve = saddle((K + shift * D + shift**2 * M).tocsr(), J, scale)
    none = np.zeros(J.shape[0])

    def inverse(c: FloatArray) -> FloatArray:
        c1, c2 = c[:n] * scale, c[n:] * scale * rate
        inertia = M @ (c2 + shift * c1) + D @ c1
        y = solve(-inertia, none)[0]
        return np.concatenate([y / scale, (c1 + shift * y) / (scale * rate)])

    operator = libs.LinearOperator((2 * n, 2 * n), matvec=inverse, dtype=np.float64)
    wanted = min(2 * count + SPARE, 2 * n - 2)
    start = inverse(inverse(np.cos(np.arange(2 * n) ** 2.0)))  # any that joints allow
    try:
        values, vectors = libs.eigs(operator, k=wanted, which="LM", v0=start / np.linalg.norm(start))
    except libs.ArpackError as error:
        raise SolverError(f"the exponents were not found: {error}") from None
    exponents = shift + 1.0 / values
    order = nearest(exponents, count)
    _check(M, D, K, J, scale, exponents[order], scale[:, None] * vectors[:n, order])
    return np.asarray(exponents[order], dtype=np.complex128)


def nearest(exponents: npt.NDArray[Any], count: int) -> IntArray:
    """The numbers of 2 ``count`` exponents, those nearest to 0, or of one less where the last one is half a pair."""
    order = np.argsort(np.abs(exponents), kind="stable")[: 2 * count]
    last = exponents[order[-1]]
    partner = np.abs(exponents[order] - last.conjugate()) <= INDEPENDENT * abs(last)
    return order if partner.any() else order[:-1]


def _check(M: Any, D: Any, K: Any, J: Any, scale: FloatArray, s: npt.NDArray[Any], y: npt.NDArray[Any]) -> None:
    """Raise SolverError where the motions y (n, k) of exponents s (k,) break joints, or the equations.

    Forces are compared without what joints can carry of them.
    """
    y = y / np.linalg.norm(y / scale[:, None], axis=0)
    through = np.abs(J @ y).max(axis=0, initial=0.0)
    lever = float(abs(J @ libs.sparse.diags(scale)).max()) if J.nnz else 1.0
    unheld = M @ y * s**2 + D @ y * s + K @ y
    acting = abs(M) @ np.abs(y) * np.abs(s) ** 2 + abs(D) @ np.abs(y) * np.abs(s) + abs(K) @ np.abs(y)
    project = saddle(libs.sparse.diags(1.0 / scale**2).tocsr(), J, scale)
    none = np.zeros(J.shape[0])
    left = [np.hypot(*(project(part, none)[0] / scale for part in (f.real, f.imag))).max() for f in unheld.T]
    share = np.array(left) / (scale[:, None] * acting).max(axis=0)
    if np.any(through > HELD * lever) or np.any(share > LEFT):
        raise SolverError(
            f"the exponents were not found: joints let through {through.max() / lever:.1e} of a motion, forces left "
            f"over are {share.max():.1e} of those that act"
        )
