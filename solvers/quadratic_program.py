"""Symmetric complementarity problems as quadratic programs, through any backend that qpsolvers knows.

With M symmetric and positive semidefinite, 0 <= z _|_ M z + q >= 0 is the optimality condition of

    min 1/2 z.M z + q.z   subject to z >= 0.

Backends stop near 1e-8, some at 1e-4. What they find out reliably is which unknowns are positive: that set is read
off, and the linear equations on it are solved, which gives full accuracy. Nothing is believed: the result passes the
residual test of the complementarity problem, or is not called solved.
"""

from __future__ import annotations

import math
import warnings
from dataclasses import dataclass
from typing import Any

import numpy as np

from lcpflex.compiled import FloatArray, IntArray
from lcpflex.errors import ModelError
from lcpflex.solvers.pivoting import block_pivots
from lcpflex.solvers.problem import Lcp, PosedProblem, Solution, Status, accept, check_tolerance

__all__ = ["QuadraticProgram", "equilibrium", "polish"]

# Settings close to what the backend can reach in double precision; a backend that is not listed runs with its own.
SETTINGS: dict[str, dict[str, Any]] = {
    "clarabel": {"tol_gap_abs": 1e-12, "tol_gap_rel": 1e-12, "tol_feas": 1e-12},
    "osqp": {"eps_abs": 1e-9, "eps_rel": 1e-9, "max_iter": 20000},
    "proxqp": {"eps_abs": 1e-12, "eps_rel": 0.0, "max_iter": 10000},
    "piqp": {"eps_abs": 1e-12, "eps_rel": 0.0},
}
NEGATIVE = 1e-8  # eigenvalue of the scaled matrix below which it is indefinite, and backends misbehave
FARTHEST = 1e8  # entry of a guess in scaled units, beyond which it is none
POLISHING = 5  # corrections on the active set: one to three suffice when the backend came near
EXCHANGES = 40  # solves for exchanging wrong signs after that
EXACT = 1e-14  # |min(z, w)| in scaled units that needs no more of this
RANK = 1e-12  # eigenvalue of M_AA, relative to the largest, below which contacts are redundant


@dataclass(frozen=True, slots=True)
class QuadraticProgram:
    """A quadratic-programming solver for frictionless contact (symmetric matrices).

    backend: name of a solver known to qpsolvers and installed ("clarabel" and "osqp" come with lcpflex); tolerance:
    largest accepted residual [-]. Raises ModelError for a backend that is not installed (the message lists those
    that are) and, in :meth:`solve`, for an unsymmetric matrix, such as that of Coulomb friction, which is not the
    gradient of any function; :class:`lcpflex.solvers.Lemke` solves those.
    """

    backend: str = "clarabel"
    tolerance: float = 1e-10

    def __post_init__(self) -> None:
        check_tolerance(self.tolerance)
        import qpsolvers

        if self.backend not in qpsolvers.available_solvers:
            installed = ", ".join(sorted(qpsolvers.available_solvers))
            raise ModelError(f"backend is {self.backend!r}: expected one of the installed {installed}")

    def refuses(self, problem: Lcp | PosedProblem) -> str:
        """Why the solver cannot take the problem; empty if it can."""
        lcp = problem if isinstance(problem, Lcp) else problem.lcp()
        if lcp.symmetric:
            return ""
        return (
            "M is not symmetric (friction makes it so): no quadratic program has this problem as its optimality "
            "condition; use Lemke(), which takes any matrix"
        )

    def solve(self, problem: Lcp | PosedProblem, guess: Solution | None = None) -> Solution:
        """Solve the problem; a guess only starts those backends that can use one."""
        if not isinstance(problem, Lcp):
            return problem.solve_by(self, guess)
        if reason := self.refuses(problem):
            raise ModelError(reason)
        if not problem.size or (problem.q >= 0.0).all():
            return accept(problem, np.zeros(problem.size), tolerance=self.tolerance, route="q >= 0")
        with np.errstate(all="ignore"):  # what overflows is not finite, and is not called solved
            return self._solve(problem, guess)

    def _solve(self, problem: Lcp, guess: Solution | None) -> Solution:
        """The backend's point on the scaled problem, polished and judged."""
        # In units in which each diagonal entry is 1: light and heavy bodies then look alike to the backend.
        diagonal = np.abs(np.diag(problem.M))
        scale = 1.0 / np.sqrt(np.where(diagonal > 0.0, diagonal, 1.0))
        M = (0.5 * problem.M + 0.5 * problem.M.T) * scale[:, None] * scale
        load = float(np.abs(scale * problem.q).max())
        q = scale * problem.q / load
        if reason := _not_convex(M, q):
            return self._failure(problem, reason)
        start = guess.z / (scale * load) if guess is not None and guess.z.shape == q.shape else None
        raw, iterations, message = self._run(M, q, _usable(start))
        if not np.isfinite(raw).all():
            return self._failure(problem, message or f"{self.backend} returned no point", iterations)
        direction = scale * np.maximum(raw, 0.0)  # of an unbounded program: the point has run away along a certificate
        polished = polish(M, q, np.maximum(raw, 0.0))
        candidates = [scale * load * np.maximum(z, 0.0) for z in (raw, polished)]
        residuals = [problem.residual(z) for z in candidates]
        best = int(np.argmin(residuals))
        return accept(
            problem,
            candidates[best],
            tolerance=self.tolerance,
            status=Status.SOLVED if not message else Status.NUMERICAL_FAILURE,
            iterations=iterations,
            route=self.backend + ("", " + active set")[best],
            message="" if min(residuals) <= self.tolerance else message,
            certificate=direction,
        )

    def _failure(self, problem: Lcp, message: str, iterations: int = 0) -> Solution:
        """The origin, with the reason why there is no better point."""
        return accept(
            problem,
            np.zeros(problem.size),
            tolerance=self.tolerance,
            status=Status.NUMERICAL_FAILURE,
            iterations=iterations,
            route=self.backend,
            message=message,
        )

    def _run(self, M: FloatArray, q: FloatArray, start: FloatArray | None) -> tuple[FloatArray, int, str]:
        """The backend's point (NaN if it has none), its iterations and, if it does not claim success, what it says."""
        import qpsolvers
        import scipy.sparse

        n = len(q)
        sparse = self.backend in qpsolvers.sparse_solvers
        P = scipy.sparse.csc_matrix(M) if sparse else M
        program = qpsolvers.Problem(P, q, lb=np.zeros(n))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # "solution may be inaccurate": the residual tells how much
            try:
                found = qpsolvers.solve_problem(
                    program, solver=self.backend, initvals=start, **SETTINGS.get(self.backend, {})
                )
            except Exception as error:  # each backend has exceptions of its own; what it says is passed on
                return np.full(n, math.nan), 0, f"{self.backend}: {type(error).__name__} {error}"
        iterations = int(found.extras.get("iterations", found.extras.get("iter", 0)) or 0)
        x = np.full(n, math.nan) if found.x is None else np.asarray(found.x, dtype=float).reshape(n)
        said = found.extras.get("status", "no solution found")
        return x, iterations, "" if found.found else f"{self.backend}: {said}"


def _not_convex(M: FloatArray, q: FloatArray) -> str:
    """Why a backend must not be given the scaled problem; empty if it may."""
    if not (np.isfinite(M).all() and np.isfinite(q).all()):
        return "the numbers of the problem overflow when they are scaled"
    try:
        np.linalg.cholesky(M + NEGATIVE * np.eye(len(M)))
    except np.linalg.LinAlgError:
        return "M is indefinite: its quadratic program is not convex, and no backend solves those; use Lemke()"
    return ""


def _usable(start: FloatArray | None) -> FloatArray | None:
    """The guess, unless a backend would lose its way from there."""
    if start is None or not np.isfinite(start).all() or np.abs(start).max(initial=0.0) > FARTHEST:
        return None
    return start


def polish(M: FloatArray, q: FloatArray, z: FloatArray) -> FloatArray:
    """Solve on the active set z > w of a near-solution, for a few corrections of that set.

    M (n, n), q (n,): symmetric positive semidefinite, with a diagonal near 1; z (n,) >= 0. Redundant contacts share
    their load as z does: the equations are solved with the least change of z. Where that is not enough, because M_AA
    is nearly singular or the set is far off, wrong signs are exchanged (:func:`block_pivots`).
    """
    best, least = z, _violation(M, q, z)
    for _ in range(POLISHING):
        active = np.flatnonzero(z > M @ z + q)
        z = equilibrium(M, q, z, active)
        violation = _violation(M, q, np.maximum(z, 0.0))
        if violation < least:
            best, least = np.maximum(z, 0.0), violation
        elif violation > 0.5 * least:
            break
    if least > EXACT * (1.0 + float(np.abs(best).max(initial=0.0))):
        n = len(q)
        pivoted, basis = np.zeros(n), np.zeros(2 * n, dtype=np.int64)
        basis[:n] = best > M @ best + q
        solves, _ = block_pivots(np.ascontiguousarray(M), q, n, pivoted, np.empty((n + 1, n + 1)), basis, EXCHANGES)
        if solves > 0 and _violation(M, q, pivoted) < least:
            return pivoted
    return best


def equilibrium(M: FloatArray, q: FloatArray, z: FloatArray, active: IntArray) -> FloatArray:
    """w = 0 on the active set and z = 0 elsewhere, by the least change of z (n,)."""
    trial = np.zeros_like(z)
    trial[active] = z[active]
    block = M[np.ix_(active, active)]
    if not active.size or not np.isfinite(block).all():
        return trial
    values, vectors = np.linalg.eigh(block)
    kept = values > RANK * values[-1]
    inverse = vectors[:, kept] / values[kept]
    for _ in range(2):  # the second pass takes out the rounding of the first
        trial[active] -= inverse @ (vectors[:, kept].T @ (M @ trial + q)[active])
    return trial


def _violation(M: FloatArray, q: FloatArray, z: FloatArray) -> float:
    """Largest entry of |min(z, w)|, inf if it is not a number."""
    violation = float(np.abs(np.minimum(z, M @ z + q)).max())
    return violation if math.isfinite(violation) else math.inf
