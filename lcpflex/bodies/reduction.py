"""From mass and stiffness matrices to free-interface modes and their inertia integrals.

The elastic modes of the unsupported body, K v = omega^2 M v with V^T M V = I, are M-orthogonal to its rigid motions
R = [1_x, 1_y, J x]. So the frame is the one of Buckens (Tisserand): S = <Phi> = 0 and c = <Phi^T J x> = 0.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
import numpy.typing as npt

from lcpflex.bodies.body import Displacement, array_of, whole_number
from lcpflex.compiled import FloatArray
from lcpflex.errors import ModelError, in_range

if TYPE_CHECKING:
    from scipy.sparse import csc_matrix

__all__ = [
    "Damping",
    "Rayleigh",
    "check_damping",
    "count_of_modes",
    "free_modes",
    "modal_damping",
    "sampled",
    "signed",
    "skew",
    "vanish",
]

DENSE_LIMIT = 1200  # up to this size the full eigenproblem costs less than a second
ORTHOGONAL = 1e-9  # largest <Phi> and <Phi^T J x>, relative to the mass and inertia they belong to
EPS = float(np.finfo(np.float64).eps)


@dataclass(frozen=True, slots=True)
class Rayleigh:
    """Damping C = alpha M + beta K of the deformation: 2 zeta_k omega_k = alpha + beta omega_k^2.

    Parameters
    ----------
    alpha : >= 0 [1/s]
    beta : >= 0 [s]
    """

    alpha: float
    beta: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "alpha", in_range("alpha", self.alpha, 0.0, math.inf))
        object.__setattr__(self, "beta", in_range("beta", self.beta, 0.0, math.inf))


Damping: TypeAlias = float | Sequence[float] | npt.NDArray[np.float64] | Rayleigh


def modal_damping(damping: Damping, omega: FloatArray) -> FloatArray:
    """(n,) 2 zeta_k omega_k [1/s] of modes with the angular frequencies omega (n,).

    ``damping`` is one damping ratio zeta for all modes, one for each, or :class:`Rayleigh`.

    Raises
    ------
    ModelError
        For a negative or non-finite ratio, or a wrong number of them.
    """
    if isinstance(damping, Rayleigh):
        return np.asarray(damping.alpha + damping.beta * omega**2)
    if np.ndim(damping) == 0:
        return 2.0 * in_range("damping", damping, 0.0, math.inf) * omega
    ratios = array_of("damping", damping, (len(omega),))
    if len(ratios) and ratios.min() < 0.0:
        raise ModelError(f"damping: a ratio of {ratios.min()!r} was given, expected ratios >= 0")
    return 2.0 * ratios * omega


def check_damping(damping: Damping, modes: int) -> None:
    """Refuse a damping that does not fit, before the eigenproblem is solved."""
    modal_damping(damping, np.ones(modes))


def sampled(displacement: Displacement, places: FloatArray, columns: int = 2) -> FloatArray:
    """Values of a displacement field: (k, 2) of a function at the places (k, 2), or the given (nodes, columns) array.

    Raises
    ------
    ModelError
        If the function raises or gives anything but two finite numbers, or the array has another shape.
    """
    if not callable(displacement):
        return array_of("displacement", displacement, (-1, columns))
    values = np.empty((len(places), 2))
    for k, (x, y) in enumerate(places):
        try:
            value = displacement(float(x), float(y))
        except Exception as error:
            raise ModelError(f"displacement: the function raised {error!r} at ({x:g}, {y:g})") from error
        values[k] = array_of(f"displacement at ({x:g}, {y:g})", value, (2,))
    return values


def count_of_modes(modes: int | None, available: int) -> int:
    """The number of modes to keep, ``None`` for all; raises :class:`ModelError` if the mesh has fewer."""
    if modes is None:
        return available
    return whole_number("modes", modes, 0, available, f" (the mesh has {available} elastic modes)")


def signed(shapes: FloatArray, translations: npt.NDArray[np.bool_] | None = None) -> FloatArray:
    """Fix the sign of each column: the first displacement above half of the largest is positive."""
    looked_at = np.abs(shapes if translations is None else shapes[translations])
    first = (looked_at > 0.5 * looked_at.max(axis=0, initial=0.0)).argmax(axis=0) if shapes.size else []
    rows = np.arange(len(shapes)) if translations is None else np.flatnonzero(translations)
    leading = shapes[rows[first], np.arange(shapes.shape[1])] if shapes.size else np.zeros(0)
    return np.asarray(shapes * np.where(leading < 0.0, -1.0, 1.0))


def skew(coupling: FloatArray) -> FloatArray | None:
    """The skew part of D, or None where D vanishes to rounding (|D_kl| <= 1 in an orthonormal basis)."""
    if not coupling.size or np.abs(coupling).max() <= 1e-10:
        return None
    return np.asarray(0.5 * (coupling - coupling.T))


def vanish(name: str, integrals: FloatArray, scale: float) -> FloatArray:
    """Zeros in the place of integrals that vanish to rounding; raises :class:`ModelError` if they do not."""
    worst = float(np.abs(integrals).max(initial=0.0))
    if not worst <= ORTHOGONAL * scale:
        raise ModelError(
            f"{name}: {worst / scale:.3g} of its scale, expected 0 to rounding: the modes found are not orthogonal to "
            f"the rigid motions (fewer modes, or a stiffness and mass with fewer orders of magnitude, may help)"
        )
    return np.zeros_like(integrals)


def free_modes(
    mass: csc_matrix[Any], stiffness: csc_matrix[Any], rigid: FloatArray, count: int, smooth: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """The ``count`` lowest elastic modes of an unsupported mesh, rigid motions removed.

    Small meshes, and requests for many modes, go to the full eigenproblem; large ones to shift-and-invert Lanczos
    with a fixed start vector, shifted below zero by the Rayleigh quotient of smooth trial fields.

    Parameters
    ----------
    mass, stiffness : (n, n) symmetric
    rigid : (n, r) all rigid motions of the mesh, K rigid = 0
    count : number of modes, <= n - r
    smooth : (n, f) smooth fields that bend the mesh, an estimate of its lowest modes

    Returns
    -------
    omega2 : (count,) ascending [rad^2/s^2]
    shapes : (n, count) with shapes^T M shapes = I, shapes^T M rigid = 0

    Raises
    ------
    ModelError
        If the mass is not positive definite or the stiffness is indefinite, or has zero modes beyond the rigid ones.
    """
    n, r = rigid.shape
    frame = _orthonormal(mass, rigid)
    if count == 0:
        wanted = min(n, r + 1) - r  # the stiffness is judged by the first elastic mode, if there is one
    else:
        wanted = count
    if n <= DENSE_LIMIT or wanted + r > n // 4:
        values, vectors = _all_of(mass, stiffness, wanted + r)
    else:
        values, vectors = _lowest(mass, stiffness, wanted + r, _shift(mass, stiffness, frame, smooth))
    _judge(values, r, float((stiffness.diagonal() / mass.diagonal()).max()))
    return _cleaned(mass, stiffness, frame, vectors[:, r : r + count])


def _judge(values: FloatArray, rigid: int, top: float) -> None:
    """Refuse a stiffness with negative eigenvalues or with more zero ones than there are rigid motions.

    ``top`` is at most the largest eigenvalue: rounding scatters the zeros by some multiples of EPS top.
    """
    if values[0] < -1e3 * EPS * top:
        raise ModelError(f"stiffness: it has the eigenvalue {values[0]:.6g}, expected a positive semidefinite matrix")
    scatter = max(float(np.abs(values[:rigid]).max(initial=0.0)), EPS * top)
    if len(values) > rigid and values[rigid] <= 10.0 * scatter:
        raise ModelError(
            f"stiffness: it has more zero modes than the {rigid} rigid motions (omega^2 = {values[rigid]:.3g} after "
            f"rounding), expected a body without mechanisms or loose parts"
        )


def _cleaned(
    mass: csc_matrix[Any], stiffness: csc_matrix[Any], frame: FloatArray, vectors: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Take rounding out of the modes: no rigid part, orthonormal, and Ritz values of what is left."""
    for _ in range(2):
        vectors = vectors - frame @ (frame.T @ (mass @ vectors))
    if not vectors.shape[1]:
        return np.zeros(0), vectors
    from scipy.linalg import eigh

    gram = vectors.T @ (mass @ vectors)
    ritz = vectors.T @ (stiffness @ vectors)
    omega2, turn = eigh(0.5 * (ritz + ritz.T), 0.5 * (gram + gram.T))
    return omega2, vectors @ turn


def _all_of(mass: csc_matrix[Any], stiffness: csc_matrix[Any], count: int) -> tuple[FloatArray, FloatArray]:
    """The ``count`` lowest eigenpairs from the full eigenproblem."""
    from scipy.linalg import LinAlgError, eigh

    n = mass.shape[0]
    some = None if count == n else (0, count - 1)
    try:
        values, vectors = eigh(stiffness.toarray(), mass.toarray(), subset_by_index=some)
    except LinAlgError as error:
        raise ModelError(f"mass: expected a positive definite matrix ({error})") from None
    return values, vectors


def _lowest(
    mass: csc_matrix[Any], stiffness: csc_matrix[Any], count: int, shift: float
) -> tuple[FloatArray, FloatArray]:
    """The ``count`` lowest eigenpairs by Lanczos on (K + shift M)^-1 M, a definite matrix."""
    from scipy.sparse.linalg import ArpackError, LinearOperator, eigsh

    _positive_factor("mass", mass)
    factor = _positive_factor("stiffness", (stiffness + shift * mass).tocsc())
    n = mass.shape[0]
    inverse = LinearOperator((n, n), matvec=factor.solve, dtype=np.float64)
    start = np.cos(np.arange(n, dtype=np.float64) * 1.7)  # any fixed vector with a part of every mode
    try:
        values, vectors = eigsh(stiffness, k=count, M=mass, sigma=-shift, OPinv=inverse, v0=start, tol=0.0)
    except ArpackError as error:
        raise ModelError(f"stiffness, mass: their {count} lowest modes were not found ({error})") from None
    order = np.argsort(values, kind="stable")
    return values[order], vectors[:, order]


def _positive_factor(name: str, matrix: csc_matrix[Any]) -> Any:
    """Sparse LU factors of a symmetric matrix that is positive definite: pivots on the diagonal, all > 0."""
    from scipy.sparse.linalg import splu

    try:
        factor = splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    except RuntimeError as error:
        raise ModelError(f"{name}: expected a matrix that is not singular ({error})") from None
    on_diagonal = np.array_equal(factor.perm_r, factor.perm_c)
    if not on_diagonal or not factor.U.diagonal().min() > 0.0:
        expected = "positive definite" if name == "mass" else "positive semidefinite"
        raise ModelError(f"{name}: the matrix that was given is indefinite, expected a {expected} one")
    return factor


def _orthonormal(mass: csc_matrix[Any], rigid: FloatArray) -> FloatArray:
    """M-orthonormal basis of the rigid motions."""
    gram = rigid.T @ (mass @ rigid)
    scale = np.sqrt(np.abs(np.diag(gram)))
    try:
        lower = np.linalg.cholesky(gram / np.outer(scale, scale))
    except np.linalg.LinAlgError:
        raise ModelError("mass: its rigid-body part is not positive definite, expected a mass > 0") from None
    return np.asarray(np.linalg.solve(lower, (rigid / scale).T).T)


def _shift(mass: csc_matrix[Any], stiffness: csc_matrix[Any], frame: FloatArray, smooth: FloatArray) -> float:
    """Smallest Ritz value of the trial fields: of the size of the lowest elastic eigenvalue."""
    trial = smooth - frame @ (frame.T @ (mass @ smooth))
    squares = np.einsum("ij,ij->j", trial, mass @ trial)
    kept = trial[:, squares > 1e-10 * squares.max()]
    ritz = np.einsum("ij,ij->j", kept, stiffness @ kept) / np.einsum("ij,ij->j", kept, mass @ kept)
    if not ritz.size or not ritz.max() > 0.0:
        raise ModelError("stiffness: smooth bending costs no energy, expected a positive semidefinite matrix")
    return float(ritz[ritz > 1e-9 * ritz.max()].min())
