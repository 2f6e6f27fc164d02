"""Quadratic programs with bounds as the backends of qpsolvers take them, and what they answer.

min 1/2 z.M z + q.z, lower <= z <= upper: as it is (box form); or, where the bounds are 0 and inf and J with M = J J^T
is known, its dual min 1/2 |v|^2, J v + q >= 0 (velocity form), of which z is the multiplier.
"""

from __future__ import annotations

import math
import warnings
from dataclasses import dataclass
from typing import Any

import numpy as np

from lcpflex.basics import libs
from lcpflex.jit.kernel import FloatArray
from lcpflex.solvers.clock import limited, remaining
from lcpflex.solvers.guard import words_of

__all__ = ["Answer", "Program"]

# Settings close to what the backend can reach in double precision; a backend that is not listed runs with its own.
SETTINGS: dict[str, dict[str, Any]] = {
    "clarabel": {"tol_gap_abs": 1e-12, "tol_gap_rel": 1e-12, "tol_feas": 1e-12},
    "osqp": {"eps_abs": 1e-9, "eps_rel": 1e-9, "max_iter": 20000},
    "proxqp": {"eps_abs": 1e-12, "eps_rel": 0.0, "max_iter": 1000},
    "piqp": {"eps_abs": 1e-12, "eps_rel": 0.0},
}
# How a backend is told its limit of time; those that are not listed are asked only while there is time.
TIME_LIMITS = {"clarabel": "time_limit", "osqp": "time_limit", "scs": "time_limit_secs", "highs": "time_limit"}
# Backends that fail for a singular M: they are given a velocity form in any case, and where there is none an M that is
# definite by RIDGE: polishing takes that out again.
DEFINITE_ONLY = ("quadprog",)
RIDGE = 1e-9
FARTHEST = 1e8  # entry of a guess in scaled units, beyond which it is none


@dataclass(frozen=True, slots=True, eq=False)
class Answer:
    """What a backend delivers, NaN where it has nothing: z and w (n,), a ray (n,), and why it failed if it did."""

    z: FloatArray
    w: FloatArray
    ray: FloatArray
    iterations: int = 0
    said: str = ""
    form: str = ""

    @classmethod
    def none(cls, n: int, said: str) -> Answer:
        """No point at all."""
        nothing = np.full(n, math.nan)
        return cls(nothing, nothing, nothing, 0, said)


@dataclass(frozen=True, slots=True, eq=False)
class Program:
    """min 1/2 z.M z + q.z, lower <= z <= upper, with a diagonal and a load near 1; all (n,), M (n, n)."""

    M: FloatArray
    q: FloatArray
    lower: FloatArray
    upper: FloatArray

    @property
    def one_sided(self) -> bool:
        """Whether it is an LCP: the bounds are 0 and inf."""
        return not self.lower.any() and bool((self.upper == np.inf).all())

    def within(self, z: FloatArray) -> FloatArray:
        """The nearest point within the bounds."""
        return np.asarray(np.minimum(np.maximum(z, self.lower), self.upper))

    def of_rays(self) -> Program:
        """That of the directions in which its unknowns can go on for ever, whose best one falls as far as it is long.

        min 1/2 u.M u + 1/2 |q|^2 (1 + q.u / |q|^2)^2 has a solution, with the minimum 0 if M u = 0 and q.u < 0 for one
        of them: then the program itself has none.
        """
        norm = float(self.q @ self.q)
        lower = np.where(self.lower == -np.inf, -np.inf, 0.0)
        upper = np.where(self.upper == np.inf, np.inf, 0.0)
        return Program(self.M + np.outer(self.q, self.q) / norm, self.q / norm, lower, upper)

    def ask(self, backend: str, J: FloatArray | None, start: FloatArray | None) -> Answer:
        """What the backend answers to the velocity form if J is known, else to the box form.

        Unknowns whose bounds are equal are none: interior points need an interior.
        """
        moving = self.lower < self.upper
        if J is None and not moving.all():
            return self._of_some(backend, np.flatnonzero(moving), start)
        n = len(self.q)
        if not (np.isfinite(self.lower).any() or np.isfinite(self.upper).any()):
            return Answer(np.zeros(n), np.zeros(n), np.full(n, math.nan))  # polishing solves the linear equations
        start = usable(start)
        if J is None and backend in DEFINITE_ONLY and self.one_sided:
            values, vectors = np.linalg.eigh(self.M)
            J = vectors * np.sqrt(np.maximum(values, 0.0))
        if J is None:
            return self._boxed(backend, start)
        return self._velocities(backend, J, None if start is None else J.T @ start)

    def _of_some(self, backend: str, moving: Any, start: FloatArray | None) -> Answer:
        """The answer of the program in the ``moving`` unknowns, the others on their bounds."""
        n = len(self.q)
        z, w, ray = self.lower.copy(), np.full(n, math.nan), np.zeros(n)
        if not moving.size:
            return Answer(z, w, ray)
        fixed = np.where(self.lower < self.upper, 0.0, self.lower)
        part = Program(
            self.M[np.ix_(moving, moving)],
            (self.q + self.M @ fixed)[moving],
            self.lower[moving],
            self.upper[moving],
        )
        found = part.ask(backend, None, None if start is None else start[moving])
        z[moving], ray[moving] = found.z, found.ray
        if np.isfinite(z).all():
            w = self.M @ z + self.q
        w[moving] = found.w
        return Answer(z, w, ray, found.iterations, found.said, found.form)

    def _boxed(self, backend: str, start: FloatArray | None) -> Answer:
        n = len(self.q)
        M = self.M + RIDGE * np.eye(n) if backend in DEFINITE_ONLY else self.M
        upper = None if (self.upper == np.inf).all() else self.upper
        lower = None if upper is not None and (self.lower == -np.inf).all() else self.lower
        found = _asked(backend, libs.qpsolvers.Problem(_stored(backend, M), self.q, lb=lower, ub=upper), start)
        if isinstance(found, str):
            return Answer.none(n, found)
        ray = _vector(found.extras.get("dual_inf_cert"), n)
        return Answer(_vector(found.x, n), -_vector(found.z_box, n), ray, *_told(backend, found))

    def _velocities(self, backend: str, J: FloatArray, start: FloatArray | None) -> Answer:
        n, k = J.shape
        program = libs.qpsolvers.Problem(_stored(backend, np.eye(k)), np.zeros(k), _stored(backend, -J), self.q)
        found = _asked(backend, program, start)
        if isinstance(found, str):
            return Answer.none(n, found)
        z, w = _vector(found.z, n), J @ _vector(found.x, k) + self.q
        ray = _vector(found.extras.get("prim_inf_cert"), n)
        return Answer(z, w, ray, *_told(backend, found), " (velocity form)")


def usable(start: FloatArray | None) -> FloatArray | None:
    """The guess, unless a backend would lose its way from there."""
    if start is None or not np.isfinite(start).all() or np.abs(start).max(initial=0.0) > FARTHEST:
        return None
    return start


def _stored(backend: str, matrix: FloatArray) -> Any:
    """The matrix as the backend wants it."""
    return libs.sparse.csc_matrix(matrix) if backend in libs.qpsolvers.sparse_solvers else np.asarray(matrix)


def _asked(backend: str, program: Any, start: FloatArray | None) -> Any:
    """The backend's solution, or what it said when it raised an exception."""
    settings = dict(SETTINGS.get(backend, {}))
    if limited() and backend in TIME_LIMITS:
        settings[TIME_LIMITS[backend]] = max(remaining(), 1e-6)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # "solution may be inaccurate": the residual tells how much
        try:
            return libs.qpsolvers.solve_problem(program, solver=backend, initvals=start, **settings)
        except (KeyboardInterrupt, SystemExit):
            raise
        except BaseException as error:  # each backend has its own, a panic in Rust is no Exception
            return f"{backend}: {words_of(error)}"


def _told(backend: str, found: Any) -> tuple[int, str]:
    """Iterations, and why the backend did not succeed, empty if it did."""
    info = found.extras.get("info", None)
    said = found.extras.get("status", getattr(info, "status", "no solution found"))
    count = getattr(info, "iter", 0)
    return int(count) if isinstance(count, int) else 0, "" if found.found else f"{backend}: {said}"


def _vector(value: Any, n: int) -> FloatArray:
    """A backend's vector (n,) if it is one, else NaN."""
    if value is None or np.size(value) != n:
        return np.full(n, math.nan)
    return np.array(value, dtype=float).reshape(n)
