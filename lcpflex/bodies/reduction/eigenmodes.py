"""Lowest modes and static response of meshes, free ones and held ones.

A free mesh has a singular stiffness, K R = 0 with the rigid motions R, and a flexibility on self-equilibrated loads,

    G = P^T K_c^-1 P,   P = 1 - M R R^T,   R^T M R = I

where K_c is K with the fewest supports that hold the mesh; they carry nothing, since P f is in equilibrium. G M has the
eigenvalues 1/omega^2 of the elastic modes and 0 of the rigid motions, so that Lanczos iterations find the lowest
elastic modes first, without a shift, from one sparse factor that serves static loads as well.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol, Self, TypeAlias

import numpy as np
import numpy.typing as npt

from lcpflex.basics import libs
from lcpflex.basics.blas import one_thread
from lcpflex.bodies.fem.sparse_factor import AT_ONCE, Factor, NotPositive, positive_factor
from lcpflex.bodies.reduction.block_lanczos import block_lanczos, check_modes, columns_of
from lcpflex.errors import ModelError
from lcpflex.jit.kernel import FloatArray, IntArray

if TYPE_CHECKING:
    from scipy.sparse import csc_matrix

BoolArray: TypeAlias = npt.NDArray[np.bool_]

__all__ = [
    "FULL_LIMIT",
    "Elastic",
    "FreeMesh",
    "check_mass",
    "check_memory",
    "fixed_modes",
    "free_modes",
    "grams",
    "held_up",
    "judge",
    "orthonormal_frame",
    "ritz",
    "softest",
]

DENSE_LIMIT = 1200  # up to this size the full eigenproblem costs less than a second
FULL_LIMIT = 6000  # degrees of freedom beyond which the full eigenproblem is refused
MEMORY = 5 * 2**30  # bytes that full columns may take: 8 with matrices and factor of 2e5 degrees of freedom in space
BALANCED = 1e-12  # part of a load beyond what inertia balances everywhere that is rounding
RESTARTS = 500  # of Lanczos iterations, which take about ten
EPS = float(np.finfo(np.float64).eps)


class Elastic(Protocol):
    """A mesh with f degrees of freedom, as reductions see it."""

    @property
    def mass(self) -> csc_matrix[Any]:
        """(f, f)."""
        ...

    @property
    def stiffness(self) -> csc_matrix[Any]:
        """(f, f)."""
        ...

    @property
    def rigid(self) -> FloatArray:
        """(f, r) rigid motions."""
        ...

    @property
    def rank(self) -> IntArray:
        """(f,) order of elimination."""
        ...


class FreeMesh:
    """A mesh without supports, ready for static loads and modes: f degrees of freedom, r rigid motions.

    Parameters
    ----------
    mass, stiffness : (f, f) symmetric
    rigid : (f, r) all rigid motions
    rank : (f,) in whose order the stiffness is factorised, here and now
    massless : (f,) degrees of freedom that are given no mass; they follow the others statically

    Raises
    ------
    ModelError
        If the mesh has mechanisms, an indefinite stiffness, or a mass that is not positive.
    """

    def __init__(
        self,
        mass: csc_matrix[Any],
        stiffness: csc_matrix[Any],
        rigid: FloatArray,
        rank: IntArray,
        massless: BoolArray | None = None,
    ) -> None:
        check_mass(mass)
        self._massless = np.zeros(len(rigid), dtype=bool) if massless is None else massless
        self.mass = mass if massless is None else _without(mass, massless)
        self.stiffness = stiffness
        self.frame = orthonormal_frame(self.mass, rigid)
        self._factor, self._free = self._held(mass, rigid, rank)

    @classmethod
    def of(cls, mesh: Elastic, massless: BoolArray | None = None) -> Self:
        """That of a mesh, which must be one piece."""
        return cls(mesh.mass, mesh.stiffness, mesh.rigid, mesh.rank, massless)

    def flexibility(self, loads: FloatArray) -> FloatArray:
        """G f of loads (f,) or (f, k); zeros for those that inertia balances everywhere, which deform nothing."""
        balanced = loads - self.mass @ (self.frame @ (self.frame.T @ loads))
        balanced *= ~(np.linalg.norm(balanced, axis=0) <= BALANCED * np.linalg.norm(loads, axis=0))
        out = np.zeros_like(balanced)
        out[self._free] = self._factor.solve(balanced[self._free])
        out -= self.frame @ (self.frame.T @ (self.mass @ out))
        return np.asarray(out)

    def responses(self, rows: IntArray) -> FloatArray:
        """(f, k) G f of unit loads at the rows (k,)."""
        out = np.empty((len(self.frame), len(rows)))
        for first in range(0, len(rows), AT_ONCE):
            some = rows[first : first + AT_ONCE]
            loads = np.zeros((len(out), len(some)))
            loads[some, np.arange(len(some))] = 1.0
            out[:, first : first + AT_ONCE] = self.flexibility(loads)
        return out

    def modes(self, count: int) -> tuple[FloatArray, FloatArray]:
        """The ``count`` lowest elastic modes.

        Returns
        -------
        omega2 : (count,) ascending [rad^2/s^2]
        shapes : (f, count) with shapes^T M shapes = I, shapes^T M R = 0

        Raises
        ------
        ModelError
            For more modes than can be found in memory, or zero modes beyond the rigid ones.
        """
        n, r = self.frame.shape
        wanted = max(count, 1)
        if wanted > n - r:
            return np.zeros(0), np.zeros((n, 0))
        if is_dense(n, wanted):
            with one_thread(n):
                values, vectors = self._all(wanted)
        else:
            values, vectors = lanczos(self.stiffness, self.mass, self.flexibility, wanted, self._factor.in_blocks)
        judge(float(values[0]), self.mass, self.stiffness, r)
        vectors = vectors[:, :count]
        for _ in range(2):
            vectors = vectors - self.frame @ (self.frame.T @ (self.mass @ vectors))
        found = ritz(self.stiffness, self.mass, vectors)
        if self._factor.in_blocks:
            check_modes(self.stiffness, self.mass, *found)
        return found

    def _all(self, count: int) -> tuple[FloatArray, FloatArray]:
        """From the full eigenproblem; what has no mass follows statically."""
        r = self.frame.shape[1]
        heavy, light = np.flatnonzero(~self._massless), np.flatnonzero(self._massless)
        K = self.stiffness.toarray()
        M = self.mass[heavy][:, heavy].toarray()
        if not len(light):
            return _full(K, M, r, count)
        follow = -libs.linalg.solve(K[np.ix_(light, light)], K[np.ix_(light, heavy)], assume_a="pos")
        condensed = K[np.ix_(heavy, heavy)] + K[np.ix_(heavy, light)] @ follow
        values, found = _full(0.5 * (condensed + condensed.T), M, r, count)
        vectors = np.empty((len(K), count))
        vectors[heavy] = found
        vectors[light] = follow @ found
        return values, vectors

    def _held(self, mass: csc_matrix[Any], rigid: FloatArray, rank: IntArray) -> tuple[Factor, IntArray]:
        try:
            return held_up(self.stiffness, rigid, rank)
        except NotPositive:
            pass
        try:
            positive_factor((self.stiffness + 1e3 * EPS * _top(mass, self.stiffness) * mass).tocsc(), rank)
        except NotPositive:
            raise ModelError("stiffness: the matrix is indefinite, expected a positive semidefinite one") from None
        raise ModelError(_mechanism(self.frame.shape[1]))


def held_up(stiffness: csc_matrix[Any], rigid: FloatArray, rank: IntArray) -> tuple[Factor, IntArray]:
    """Factors of the stiffness of a free mesh with the fewest supports, and the degrees of freedom they leave free.

    Raises
    ------
    NotPositive
        For a stiffness that is not positive definite beyond its rigid motions.
    """
    free = np.setdiff1d(np.arange(len(rigid)), _supports(rigid))
    return positive_factor(stiffness[free][:, free].tocsc(), rank[free]), free


def judge(lowest: float, mass: csc_matrix[Any], stiffness: csc_matrix[Any], rigid: int) -> None:
    """Refuse an elastic omega^2 that is negative or zero to rounding, which scatters zeros by some EPS of the highest.

    Raises
    ------
    ModelError
        For a negative one, or for a zero one.
    """
    top = _top(mass, stiffness)
    if lowest < -1e3 * EPS * top:
        raise ModelError(f"stiffness: it has the eigenvalue {lowest:.6g}, expected a positive semidefinite matrix")
    if lowest <= 10.0 * EPS * top:
        raise ModelError(_mechanism(rigid, f" (omega^2 = {lowest:.3g} after rounding)"))


def _top(mass: csc_matrix[Any], stiffness: csc_matrix[Any]) -> float:
    """At most the highest omega^2."""
    heavy = mass.diagonal() > 0.0
    return float((stiffness.diagonal()[heavy] / mass.diagonal()[heavy]).max())


def _full(K: FloatArray, M: FloatArray, first: int, count: int) -> tuple[FloatArray, FloatArray]:
    """Some of the eigenpairs of full matrices."""
    chosen = None if 2 * count > len(K) else (first, first + count - 1)  # all of them cost less than most of them
    try:
        values, vectors = libs.linalg.eigh(K, M, subset_by_index=chosen, overwrite_a=True, overwrite_b=True)
    except libs.linalg.LinAlgError as error:
        raise ModelError(f"mass: expected a positive definite matrix ({error})") from None
    kept = slice(first, first + count) if chosen is None else slice(0, count)
    return values[kept], vectors[:, kept]


def _mechanism(rigid: int, found: str = "") -> str:
    return (
        f"stiffness: it has more zero modes than the {rigid} rigid motions{found}, expected a body without mechanisms "
        "or loose parts, and not so slender and finely meshed across that its bending drowns in rounding (a Beam then)"
    )


def free_modes(
    mass: csc_matrix[Any], stiffness: csc_matrix[Any], rigid: FloatArray, count: int
) -> tuple[FloatArray, FloatArray]:
    """The ``count`` lowest elastic modes of banded matrices; see :meth:`FreeMesh.modes`."""
    return FreeMesh(mass, stiffness, rigid, np.arange(len(rigid))).modes(count)


def fixed_modes(
    mass: csc_matrix[Any], stiffness: csc_matrix[Any], factor: Factor, count: int
) -> tuple[FloatArray, FloatArray]:
    """The ``count`` lowest modes (omega2, shapes) of a mesh that is held; ``factor``: of its stiffness."""
    n = mass.shape[0]
    if count == 0:
        return np.zeros(0), np.zeros((n, 0))
    if is_dense(n, count):
        with one_thread(n):
            return _full(stiffness.toarray(), mass.toarray(), 0, count)
    found = ritz(stiffness, mass, lanczos(stiffness, mass, factor.solve, count, factor.in_blocks)[1])
    if factor.in_blocks:
        check_modes(stiffness, mass, *found)
    return found


def softest(mass: csc_matrix[Any], stiffness: csc_matrix[Any], factor: Factor) -> float:
    """An estimate from above of the lowest omega^2 of a mesh that is held, by a few steps of inverse iteration."""
    vector = np.cos(np.arange(mass.shape[0], dtype=np.float64) * 1.7)
    for _ in range(4):
        vector = factor.solve(mass @ vector)
        vector /= np.linalg.norm(vector)
    return float(vector @ (stiffness @ vector)) / float(vector @ (mass @ vector))


def lanczos(
    stiffness: csc_matrix[Any], mass: csc_matrix[Any], solve: Any, count: int, in_blocks: bool
) -> tuple[FloatArray, FloatArray]:
    """Lowest eigenpairs, by Lanczos iterations on the inverse of the stiffness; a fixed start gives the same bits."""
    n = mass.shape[0]
    check_memory("modes", n, columns_of(count) if in_blocks else 6 * count + 60)
    if in_blocks:
        return block_lanczos(mass, solve, count)
    inverse = libs.LinearOperator((n, n), matvec=solve, dtype=np.float64)
    start = solve(mass @ np.cos(np.arange(n, dtype=np.float64) * 1.7))  # any fixed vector with a part of every mode
    try:
        values, vectors = libs.eigsh(stiffness, k=count, M=mass, sigma=0.0, OPinv=inverse, v0=start, maxiter=RESTARTS)
    except libs.ArpackError as error:
        raise ModelError(f"stiffness, mass: their {count} lowest modes were not found ({error})") from None
    order = np.argsort(values, kind="stable")
    return values[order], vectors[:, order]


def ritz(stiffness: csc_matrix[Any], mass: csc_matrix[Any], vectors: FloatArray) -> tuple[FloatArray, FloatArray]:
    """(omega2, shapes) that diagonalise mass and stiffness on the span of independent vectors (f, k)."""
    if not vectors.shape[1]:
        return np.zeros(0), vectors
    gram, stiff = grams(mass, stiffness, vectors)
    with one_thread(len(gram)):
        omega2, turn = libs.linalg.eigh(stiff, gram)
    return omega2, vectors @ turn


def grams(mass: csc_matrix[Any], stiffness: csc_matrix[Any], vectors: FloatArray) -> tuple[FloatArray, FloatArray]:
    """(k, k) V^T M V and V^T K V, symmetric, of vectors (f, k); the products with a few columns at a time."""
    k = vectors.shape[1]
    both = np.empty((2, k, k))
    for first in range(0, k, AT_ONCE):
        part = slice(first, first + AT_ONCE)
        both[0, :, part] = vectors.T @ (mass @ vectors[:, part])
        both[1, :, part] = vectors.T @ (stiffness @ vectors[:, part])
    gram, stiff = 0.5 * (both + both.transpose(0, 2, 1))
    return gram, stiff


def is_dense(n: int, count: int) -> bool:
    """Whether ``count`` of n modes are taken from the full eigenproblem; raises ModelError if it is too large."""
    if n > DENSE_LIMIT and count + 3 <= n // 4:
        return False
    if n > FULL_LIMIT:
        raise ModelError(
            f"modes: {count} of a mesh with {n} degrees of freedom were asked for, which needs the full eigenproblem "
            f"(about {4 * 8 * n * n / 2**30:.1f} GiB), expected at most {FULL_LIMIT} degrees of freedom for that, or "
            f"less than {n // 4 - 2} modes"
        )
    return True


def check_memory(name: str, n: int, columns: int) -> None:
    """Refuse what would take more than MEMORY: so many full columns of n numbers."""
    needed = 8 * n * columns
    if needed > MEMORY:
        raise ModelError(
            f"{name}: {columns} full columns of {n} degrees of freedom would take {needed / 2**30:.2g} GiB, expected "
            f"at most {MEMORY / 2**30:.2g}: choose fewer nodes or modes"
        )


def orthonormal_frame(mass: csc_matrix[Any], rigid: FloatArray) -> FloatArray:
    """M-orthonormal basis of the rigid motions."""
    gram = rigid.T @ (mass @ rigid)
    scale = np.sqrt(np.abs(np.diag(gram)))
    try:
        lower = np.linalg.cholesky(gram / np.outer(scale, scale))
    except np.linalg.LinAlgError:
        raise ModelError("mass: its rigid-body part is not positive definite, expected a mass > 0") from None
    return np.asarray(np.linalg.solve(lower, (rigid / scale).T).T)


def _supports(rigid: FloatArray) -> IntArray:
    """Rows to hold so that no rigid motion (f, r) is left: those that resist them best, by pivoted elimination."""
    left = rigid / np.abs(rigid).max(axis=0)
    rows = []
    for _ in range(rigid.shape[1]):
        row = int(np.linalg.norm(left, axis=1).argmax())
        rows.append(row)
        along = left[row] / np.linalg.norm(left[row])
        left = left - np.outer(left @ along, along)
    return np.array(rows)


def _without(mass: csc_matrix[Any], massless: BoolArray) -> csc_matrix[Any]:
    keep = libs.sparse.diags_array(np.where(massless, 0.0, 1.0))
    return (keep @ mass @ keep).tocsc()


def check_mass(mass: csc_matrix[Any]) -> None:
    """Refuse a mass that is not positive definite, by the lowest Ritz value of a short Lanczos process.

    Scaled to a unit diagonal, masses of elements have all their eigenvalues near 1 (Wathen 1987), so that a negative
    one stands apart and is found in a few products; a factor would cost as much as that of the stiffness.
    """
    diagonal = mass.diagonal()
    if not diagonal.min() > 0.0:
        raise ModelError(f"mass: {diagonal.min():.6g} on its diagonal, expected a positive definite matrix")
    scale = 1.0 / np.sqrt(diagonal)
    n = len(scale)
    steps = min(n, 40)
    basis = np.zeros((steps + 1, n))
    start = np.cos(np.arange(n, dtype=np.float64) * 1.7)
    basis[0] = start / np.linalg.norm(start)
    main, off = np.zeros(steps), np.zeros(steps)
    for k in range(steps):
        product = scale * (mass @ (scale * basis[k]))
        main[k] = basis[k] @ product
        for _ in range(2):
            product -= basis[: k + 1].T @ (basis[: k + 1] @ product)
        off[k] = np.linalg.norm(product)
        if off[k] <= 1e-12 or k + 1 == steps:
            break
        basis[k + 1] = product / off[k]
    found = np.diag(main[: k + 1]) + np.diag(off[:k], 1) + np.diag(off[:k], -1)
    lowest = float(np.linalg.eigvalsh(found)[0])
    if lowest <= 0.0:
        raise ModelError(
            f"mass: it is indefinite (eigenvalue {lowest:.3g} of it scaled to a unit diagonal), expected a positive "
            "definite matrix"
        )
