"""Symmetric complementarity problems as quadratic programs, through any backend that qpsolvers knows.

With M symmetric and positive semidefinite, 0 <= z _|_ M z + q >= 0 is the optimality condition of

    min 1/2 z.M z + q.z   subject to z >= 0                              (its box form, the dual of)
    min 1/2 |v|^2         subject to J v + q >= 0, where M = J J^T       (the velocity form: v = J^T z)

z is the multiplier of the latter, which a backend delivers too; both optima add up to zero, |v|^2 + q.z = z.w = 0. The
velocity form is posed where the factor J is known: its objective is the best conditioned there is.

Backends stop near 1e-8, some at 1e-4. What they find out reliably is which unknowns are positive: that set is read
off, and the linear equations on it are solved, which gives full accuracy. Nothing is believed: the result passes the
residual test of the complementarity problem, or is not called solved.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from lcpflex.compiled import FloatArray, IntArray
from lcpflex.errors import ModelError
from lcpflex.solvers.arguments import check_guess, posed
from lcpflex.solvers.clock import limited, out_of_time, remaining
from lcpflex.solvers.guard import guarded, words_of
from lcpflex.solvers.problem import NEARLY, Lcp, PosedProblem, Solution, Status, accept, keep_tolerance
from lcpflex.solvers.proofs import Proof, infeasibility, nearly_infeasible

__all__ = ["QuadraticProgram", "duality_gap", "equilibrium", "polish"]

# Settings close to what the backend can reach in double precision; a backend that is not listed runs with its own.
SETTINGS: dict[str, dict[str, Any]] = {
    "clarabel": {"tol_gap_abs": 1e-12, "tol_gap_rel": 1e-12, "tol_feas": 1e-12},
    "osqp": {"eps_abs": 1e-9, "eps_rel": 1e-9, "max_iter": 20000},
    "proxqp": {"eps_abs": 1e-12, "eps_rel": 0.0, "max_iter": 1000},
    "piqp": {"eps_abs": 1e-12, "eps_rel": 0.0},
}
# How a backend is told its limit of time; those that are not listed are asked only while there is time.
TIME_LIMITS = {"clarabel": "time_limit", "osqp": "time_limit", "scs": "time_limit_secs", "highs": "time_limit"}
DEFINITE_ONLY = ("quadprog",)  # backends that fail for a singular M, and are given a velocity form in any case
NEGATIVE = 1e-8  # eigenvalue of the scaled matrix below which it is indefinite, and backends misbehave
FARTHEST = 1e8  # entry of a guess in scaled units, beyond which it is none
POLISHING = 10  # corrections on the active set: one to three suffice when the backend came near
EXACT = 1e-14  # w on the active set that is rounding, relative to the terms it is made of
RANK = 1e-12  # eigenvalue of M_AA, relative to the largest, below which contacts are redundant


@dataclass(frozen=True, slots=True)
class QuadraticProgram:
    """A quadratic-programming solver for frictionless contact (symmetric matrices).

    backend: name of a solver known to qpsolvers and installed ("clarabel" and "osqp" come with lcpflex); tolerance:
    largest accepted residual [-]. The message of a solution states its duality gap. Raises ModelError for a backend
    that is not installed (the message lists those that are) and, in :meth:`solve`, for an unsymmetric matrix, such as
    that of Coulomb friction, which is not the gradient of any function; :class:`lcpflex.solvers.Lemke` solves those.
    """

    backend: str = "clarabel"
    tolerance: float = 1e-10

    def __post_init__(self) -> None:
        keep_tolerance(self)
        import qpsolvers

        if self.backend not in qpsolvers.available_solvers:
            installed = ", ".join(sorted(qpsolvers.available_solvers))
            raise ModelError(f"backend is {self.backend!r}: expected one of the installed {installed}")

    def refuses(self, problem: Lcp | PosedProblem) -> str:
        """Why the solver cannot take the problem; empty if it can."""
        lcp = problem if isinstance(problem, Lcp) else posed(problem).lcp()
        if lcp.symmetric:
            return ""
        return (
            "M is not symmetric (friction makes it so): no quadratic program has this problem as its optimality "
            "condition; use Lemke(), which takes any matrix"
        )

    def solve(self, problem: Lcp | PosedProblem, guess: Solution | None = None) -> Solution:
        """Solve the problem; a guess only starts those backends that can use one."""
        if not isinstance(problem, Lcp):
            return posed(problem).solve_by(self, guess)
        check_guess(guess)
        if reason := self.refuses(problem):
            raise ModelError(reason)
        if not problem.size or (problem.q >= 0.0).all():
            return accept(problem, np.zeros(problem.size), tolerance=self.tolerance, route="q >= 0")
        with np.errstate(all="ignore"):  # what overflows is not finite, and is not called solved
            return guarded(self.backend, problem, self.tolerance, lambda: self._solve(problem, guess))

    def _solve(self, problem: Lcp, guess: Solution | None) -> Solution:
        """The backend's point on the scaled problem, polished and judged."""
        # In units in which each diagonal entry is 1: light and heavy bodies then look alike to the backend.
        diagonal = np.abs(np.diag(problem.M))
        scale = 1.0 / np.sqrt(np.where(diagonal > 0.0, diagonal, 1.0))
        M = (0.5 * problem.M + 0.5 * problem.M.T) * scale[:, None] * scale
        load = float(np.abs(scale * problem.q).max())
        q = scale * problem.q / load
        if reason := _not_convex(M, q):
            return self._judged(problem, np.zeros(len(q)), self.backend, 0, reason)
        J = None if problem.factor is None else scale[:, None] * problem.factor
        start = guess.z / (scale * load) if guess is not None and guess.z.shape == q.shape else None
        best, residual, route, iterations, near = np.zeros(len(q)), math.inf, self.backend, 0, False
        for form in (None,) if J is None else (J, None):  # a factor need not be one of M to the last digit
            if form is None and J is not None and out_of_time():
                break
            answer = self._ask(M, q, form, _usable(start))
            iterations += answer.iterations
            for z, how in self._points(M, q, answer):
                trial = scale * load * z
                if problem.residual(trial) < residual:
                    best, residual, route = trial, problem.residual(trial), self.backend + answer.form + how
                if residual <= self.tolerance and how:
                    return self._judged(problem, best, route, iterations, answer.said)
            for ray in self._rays(M, q, answer):
                if nearly_infeasible(*problem.data, scale * ray):
                    near = True
                    proof = infeasibility(problem, scale * ray)
                    if proof is not None:
                        return self._judged(problem, best, route, iterations, answer.said, proof)
        said = "; ".join(part for part in (answer.said, NEARLY * near) if part)
        return self._judged(problem, best, route, iterations, said)

    def _judged(
        self,
        problem: Lcp,
        z: FloatArray,
        route: str,
        iterations: int,
        said: str,
        proof: Proof | None = None,
    ) -> Solution:
        """The point, with the duality gap or what the backend said."""
        solved = problem.residual(z) <= self.tolerance
        return accept(
            problem,
            z,
            tolerance=self.tolerance,
            status=Status.SOLVED if solved else Status.TIME_LIMIT if out_of_time() else Status.NUMERICAL_FAILURE,
            iterations=iterations,
            route=route,
            message=f"duality gap {duality_gap(problem, z):.1e}" if solved else said,
            proof=proof,
        )

    def _points(self, M: FloatArray, q: FloatArray, answer: _Answer) -> Iterator[tuple[FloatArray, str]]:
        """The backend's z, then solutions on the active sets that its z, and its z and w, show."""
        if not np.isfinite(answer.z).all():
            return
        z = np.maximum(answer.z, 0.0)
        yield z, ""
        if out_of_time():
            return
        yield polish(M, q, z), ", active set"
        if np.isfinite(answer.w).all():
            yield polish(M, q, z, answer.w), ", active set"

    def _rays(self, M: FloatArray, q: FloatArray, answer: _Answer) -> Iterator[FloatArray]:
        """Directions u >= 0 that may have M u = 0 and q.u < 0, which proves that there is no solution.

        The backend's own and the point that ran away, made exact as near-solutions of min 1/2 u.M u + 1/2 (q.u + 1)^2,
        u >= 0; then what the backend finds for that program, which always has a solution, with the minimum 0 if there
        is such a direction.
        """
        if out_of_time():
            return
        norm = float(q @ q)
        extended, pull = M + np.outer(q, q) / norm, q / norm
        for ray in (answer.ray, answer.z):
            gain = -float(q @ np.maximum(ray, 0.0))
            if math.isfinite(gain) and gain > 0.0:
                yield polish(extended, pull, np.maximum(ray, 0.0) * (norm / gain))
        for ray, _ in self._points(extended, pull, self._ask(extended, pull, None, None)):
            yield ray

    def _ask(self, M: FloatArray, q: FloatArray, J: FloatArray | None, start: FloatArray | None) -> _Answer:
        """What the backend answers to the problem in its velocity form if J is known, else in its box form."""
        import qpsolvers
        import scipy.sparse

        n = len(q)
        if J is None and self.backend in DEFINITE_ONLY:
            values, vectors = np.linalg.eigh(M)
            J = vectors * np.sqrt(np.maximum(values, 0.0))
        stored = scipy.sparse.csc_matrix if self.backend in qpsolvers.sparse_solvers else np.asarray
        if J is None:
            program = qpsolvers.Problem(stored(M), q, lb=np.zeros(n))
        else:
            k = J.shape[1]
            program = qpsolvers.Problem(stored(np.eye(k)), np.zeros(k), stored(-J), q)
            start = None if start is None else J.T @ start
        settings = dict(SETTINGS.get(self.backend, {}))
        if limited() and self.backend in TIME_LIMITS:
            settings[TIME_LIMITS[self.backend]] = max(remaining(), 1e-6)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # "solution may be inaccurate": the residual tells how much
            try:
                found = qpsolvers.solve_problem(program, solver=self.backend, initvals=start, **settings)
            except (KeyboardInterrupt, SystemExit):
                raise
            except BaseException as error:  # each backend has its own, a panic in Rust is no Exception
                return _Answer.none(n, f"{self.backend}: {words_of(error)}")
        extras = found.extras
        info = extras.get("info", None)
        said = extras.get("status", getattr(info, "status", "no solution found"))
        said = "" if found.found else f"{self.backend}: {said}"
        count = getattr(info, "iter", 0)
        iterations = int(count) if isinstance(count, int) else 0
        if J is None:
            z, w = _vector(found.x, n), -_vector(found.z_box, n)
            return _Answer(z, w, _vector(extras.get("dual_inf_cert"), n), iterations, said)
        z, v = _vector(found.z, n), _vector(found.x, J.shape[1])
        return _Answer(z, J @ v + q, _vector(extras.get("prim_inf_cert"), n), iterations, said, " (velocity form)")


@dataclass(frozen=True, slots=True, eq=False)
class _Answer:
    """What a backend delivers, NaN where it has nothing: z and w (n,), a ray (n,), and why it failed if it did."""

    z: FloatArray
    w: FloatArray
    ray: FloatArray
    iterations: int
    said: str
    form: str = ""

    @classmethod
    def none(cls, n: int, said: str) -> _Answer:
        """No point at all."""
        nothing = np.full(n, math.nan)
        return cls(nothing, nothing, nothing, 0, said)


def duality_gap(problem: Lcp, z: npt.ArrayLike) -> float:
    """What the optima of the two programs lack of adding up to zero, relative: |z.w| / (|z|.|M z| + |z|.|q|).

    z (n,); dimensionless, 0 for a solution and for z = 0, inf for a z that holds NaN or inf. Raises ModelError if z has
    another shape.
    """
    if not math.isfinite(problem.residual(z)):
        return math.inf
    point = np.asarray(z, dtype=float)
    with np.errstate(all="ignore"):
        force = problem.M @ point
        size = float(np.abs(point) @ (np.abs(force) + np.abs(problem.q)))
        gap = abs(float(point @ (force + problem.q)))
    if not (math.isfinite(size) and math.isfinite(gap)):
        return math.inf
    return gap / size if size > 0.0 else 0.0


def _vector(value: Any, n: int) -> FloatArray:
    """A backend's vector (n,) if it is one, else NaN."""
    if value is None or np.size(value) != n:
        return np.full(n, math.nan)
    return np.array(value, dtype=float).reshape(n)


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


def polish(M: FloatArray, q: FloatArray, z: FloatArray, w: FloatArray | None = None) -> FloatArray:
    """Solve on the active set z > w of a near-solution, for a few corrections of that set.

    M (n, n), q (n,): symmetric positive semidefinite, with a diagonal near 1; z (n,) >= 0; w (n,): M z + q if left out.
    Redundant contacts share their load as z does: the equations are solved with the least change of z.
    """
    best, least, solved = z, _violation(M, q, z), None
    for _ in range(POLISHING):
        active = np.flatnonzero(z > (M @ z + q if w is None else w))
        if solved is not None and np.array_equal(active, solved):
            break
        z, w, solved = _yielding(M, q, equilibrium(M, q, z, active), active), None, active
        violation = _violation(M, q, np.maximum(z, 0.0))
        if violation < least:
            best, least = np.maximum(z, 0.0), violation
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


def _yielding(M: FloatArray, q: FloatArray, z: FloatArray, active: IntArray) -> FloatArray:
    """z, unless w = 0 contradicts itself on the active set: then further, until one unknown of it is zero.

    What is left of w on A after least squares is a direction in which M_AA z stays and the objective falls.
    """
    rest = np.zeros_like(z)
    rest[active] = (M @ z + q)[active]
    if not np.abs(rest).max(initial=0.0) > EXACT * (1.0 + np.abs(z).sum()):
        return z
    falling = np.flatnonzero((rest > 0.0) & (z > 0.0))
    if not falling.size:
        return z
    steps = z[falling] / rest[falling]
    first = int(np.argmin(steps))
    z = z - steps[first] * rest
    z[falling[first]] = 0.0
    return z


def _violation(M: FloatArray, q: FloatArray, z: FloatArray) -> float:
    """Largest entry of |min(z, w)|, inf if it is not a number."""
    violation = float(np.abs(np.minimum(z, M @ z + q)).max())
    return violation if math.isfinite(violation) else math.inf
