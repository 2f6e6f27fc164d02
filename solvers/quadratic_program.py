"""Symmetric complementarity problems as quadratic programs, through any backend that qpsolvers knows.

With M symmetric and positive semidefinite, 0 <= z _|_ M z + q >= 0 is the optimality condition of

    min 1/2 z.M z + q.z   subject to z >= 0                              (its box form, the dual of)
    min 1/2 |v|^2         subject to J v + q >= 0, where M = J J^T       (the velocity form: v = J^T z)

z is the multiplier of the latter, which a backend delivers too; both optima add up to zero, |v|^2 + q.z = z.w = 0. The
velocity form is posed where the factor J is known: its objective is the best conditioned there is. Boxed and mixed
problems are the box form with other bounds, lower <= z <= upper, those of free unknowns infinite: they are posed as
they are, not as the LCP that they can be brought to, which two bounds of an unknown make unsymmetric.

Backends stop near 1e-8, some at 1e-4. What they find out reliably is which unknowns are between their bounds: that set
is read off, and the linear equations on it are solved, which gives full accuracy. Nothing is believed: the result
passes the residual test of the complementarity problem, or is not called solved.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import numpy.typing as npt

from lcpflex.basics import libs
from lcpflex.errors import ModelError, shown
from lcpflex.jit.kernel import FloatArray
from lcpflex.solvers.acceptance import accept
from lcpflex.solvers.arguments import check_guess, posed
from lcpflex.solvers.certificate import is_symmetric
from lcpflex.solvers.clock import out_of_time
from lcpflex.solvers.guard import guarded
from lcpflex.solvers.lcp.polishing import equilibrium, polish, shortest
from lcpflex.solvers.lcp.proofs import NEAR, NEARLY, Proof, infeasibility
from lcpflex.solvers.limits import keep_settings
from lcpflex.solvers.mixed.problems import BoxedLcp, MixedLcp
from lcpflex.solvers.problem import Lcp, PosedProblem, Solution, Status
from lcpflex.solvers.program_backends import Answer, Program
from lcpflex.solvers.refusals import no_cones

__all__ = ["QuadraticProgram", "duality_gap", "equilibrium", "polish"]

NEGATIVE = 1e-8  # eigenvalue of the scaled matrix below which it is indefinite, and backends misbehave
FAR = 1e6  # bound in scaled units that hardly any solution reaches
UNSYMMETRIC = (
    "M is not symmetric (friction makes it so): no quadratic program has this problem as its optimality condition; "
    "use Lemke(), which takes any matrix"
)


@dataclass(frozen=True, slots=True)
class QuadraticProgram:
    """A quadratic-programming solver for frictionless contact (symmetric matrices), with bounds of every kind.

    backend: name of a solver known to qpsolvers and installed ("clarabel" and "osqp" come with lcpflex); tolerance:
    largest accepted residual [-]. The message of a solution states its duality gap. Raises ModelError for a backend
    that is not installed (the message lists those that are) and, in :meth:`solve`, for an unsymmetric matrix, such as
    that of Coulomb friction, which is not the gradient of any function; :class:`lcpflex.solvers.Lemke` solves those.

    A :class:`BoxedLcp` or :class:`MixedLcp` whose M is symmetric and positive semidefinite is posed with its bounds as
    they are; its ``certificate`` is in the unknowns of its ``exact_system``. Others are taken if what is left of them
    without their free unknowns is a symmetric LCP.
    """

    only_frictionless: ClassVar[bool] = True

    backend: str = "clarabel"
    tolerance: float = 1e-10

    def __post_init__(self) -> None:
        keep_settings(self)
        if not isinstance(self.backend, str) or self.backend not in libs.qpsolvers.available_solvers:
            installed = ", ".join(sorted(libs.qpsolvers.available_solvers))
            raise ModelError(f"backend is {shown(self.backend)}: expected one of the installed {installed}")

    def refuses(self, problem: Lcp | PosedProblem) -> str:
        """Why the solver cannot take the problem; empty if it can."""
        if isinstance(problem, Lcp):
            return "" if problem.symmetric else UNSYMMETRIC
        if reason := no_cones(self, problem):
            return reason
        box = _box(problem)
        reason = UNSYMMETRIC if box is None else _no_program(box)
        return reason if reason and not _symmetric_without_free(problem, box) else ""

    def solve(self, problem: Lcp | PosedProblem, guess: Solution | None = None) -> Solution:
        """Solve the problem; a guess only starts those backends that can use one."""
        box = problem if isinstance(problem, Lcp) else _box(problem)
        if box is None:
            return posed(problem).solve_by(self, guess)
        check_guess(guess)
        if reason := self.refuses(problem):
            raise ModelError(reason)
        if isinstance(box, BoxedLcp) and _no_program(box):
            return box.solve_by(self, guess)
        rest = np.zeros(box.size) if isinstance(box, Lcp) else np.clip(np.zeros(box.size), box.lower, box.upper)
        if (box.q >= 0.0).all() if isinstance(box, Lcp) else box.residual(rest) == 0.0:
            return accept(box, rest, tolerance=self.tolerance, route="q >= 0" if isinstance(box, Lcp) else "at rest")
        with np.errstate(all="ignore"):  # what overflows is not finite, and is not called solved
            return guarded(self.backend, box, self.tolerance, lambda: self._solve(_Scaled.of(box), guess))

    def _solve(self, form: _Scaled, guess: Solution | None) -> Solution:
        """The backend's point on the scaled problem, polished and judged."""
        problem, program = form.problem, form.program
        if reason := _not_convex(program.M, program.q):
            return self._judged(problem, form.outward(program.within(np.zeros(problem.size))), self.backend, 0, reason)
        start = guess.z / form.unit if guess is not None and guess.z.shape == form.unit.shape else None
        best, residual, route, iterations, near = np.zeros(problem.size), math.inf, self.backend, 0, False
        for turn, (asked, factor) in enumerate(form.posings()):
            if turn and out_of_time():
                break
            answer = asked.ask(self.backend, factor, start)
            iterations += answer.iterations
            for z, how in _points(program, answer):
                trial = form.outward(z)
                off = problem.residual(trial)
                if off < residual:
                    best, residual, route = trial, off, self.backend + answer.form + how
                if residual <= self.tolerance and how:
                    return self._judged(problem, best, route, iterations, answer.said)
            for ray in self._rays(program, answer):
                if form.nearly_proves(ray):
                    near = True
                    proof = infeasibility(problem, form.farkas(ray))
                    if proof is not None:
                        return self._judged(problem, best, route, iterations, answer.said, proof)
        said = "; ".join(part for part in (answer.said, NEARLY * near) if part)
        return self._judged(problem, best, route, iterations, said)

    def _judged(
        self,
        problem: Lcp | BoxedLcp,
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

    def _rays(self, program: Program, answer: Answer) -> Iterator[FloatArray]:
        """Directions u that may have M u = 0 and q.u < 0 and meet no bound: they prove that there is no solution.

        The backend's own and the point that ran away, made exact as near-solutions of the program of rays; then what
        the backend finds for that program.
        """
        if out_of_time() or not program.q.any():
            return
        rays = program.of_rays()
        for ray in (answer.ray, answer.z):
            gain = -float(program.q @ rays.within(ray))
            if math.isfinite(gain) and gain > 0.0:
                near = rays.within(ray) * (float(program.q @ program.q) / gain)
                yield polish(rays.M, rays.q, near, None, rays.lower, rays.upper)
        for ray, _ in _points(rays, rays.ask(self.backend, None, None)):
            yield ray


@dataclass(frozen=True, slots=True, eq=False)
class _Scaled:
    """A problem in units in which each diagonal entry is 1: light and heavy bodies then look alike to the backend.

    z = unit z' (n,), unit = scale times the load; factor (n, k): that of the scaled matrix, if it is known.
    """

    problem: Lcp | BoxedLcp
    program: Program
    scale: FloatArray
    unit: FloatArray
    factor: FloatArray | None

    @classmethod
    def of(cls, problem: Lcp | BoxedLcp) -> _Scaled:
        """The problem with the largest of its loads at 1: q, and the bounds that keep unknowns away from 0."""
        n = problem.size
        scale = _scale(problem.M)
        M = (0.5 * problem.M + 0.5 * problem.M.T) * scale[:, None] * scale
        load = float(np.abs(scale * problem.q).max())
        J, lower, upper = None, np.zeros(n), np.full(n, np.inf)
        if isinstance(problem, BoxedLcp):
            rest = np.clip(np.zeros(n), problem.lower, problem.upper) / scale
            load = max(load, float(np.abs(rest).max()))
            lower, upper = problem.lower / (scale * load), problem.upper / (scale * load)
        elif problem.factor is not None:
            J = scale[:, None] * problem.factor
        return cls(problem, Program(M, scale * problem.q / load, lower, upper), scale, scale * load, J)

    def posings(self) -> list[tuple[Program, FloatArray | None]]:
        """What to ask, in this order: by the factor if there is one, without bounds that are far away, as it is.

        A factor need not be one of M to the last digit; far bounds spoil the accuracy of interior points.
        """
        full, (lower, upper) = self.program, (self.program.lower, self.program.upper)
        asked: list[tuple[Program, FloatArray | None]] = [] if self.factor is None else [(full, self.factor)]
        low, high = np.where(lower < -FAR, -np.inf, lower), np.where(upper > FAR, np.inf, upper)
        if not (np.array_equal(low, lower) and np.array_equal(high, upper)):
            asked.append((Program(full.M, full.q, low, high), None))
        return [*asked, (full, None)]

    def outward(self, z: FloatArray) -> FloatArray:
        """The point in the units of the problem; on its bounds exactly where it is on them here."""
        point = self.unit * z
        if isinstance(self.problem, Lcp):
            return point
        lower, upper = self.problem.lower, self.problem.upper
        point = np.where(z <= self.program.lower, lower, np.where(z >= self.program.upper, upper, point))
        return np.clip(point, lower, upper)

    def nearly_proves(self, ray: FloatArray) -> bool:
        """Whether the direction (n,), scaled, is worth a look in fractions."""
        u = self.scale * ray
        if isinstance(self.problem, Lcp):
            return self.problem._nearly_infeasible(u)
        length = float(np.abs(ray).max())
        pushes = float(np.abs(self.program.M @ ray).max())
        return bool(0.0 < length < np.inf and pushes <= NEAR * length and self.problem.q @ u < 0.0)

    def farkas(self, ray: FloatArray) -> FloatArray:
        """The direction as Farkas' vector: of an LCP itself, of a box in the unknowns of its exact system."""
        u = self.scale * ray
        if isinstance(self.problem, Lcp):
            return u
        below, above = np.isfinite(self.problem.lower), np.isfinite(self.problem.upper)
        mirrored = np.where(above & ~below, -u, u)
        return np.concatenate([mirrored[below | above], np.zeros((below & above).sum()), u[~(below | above)]])


def _points(program: Program, answer: Answer) -> Iterator[tuple[FloatArray, str]]:
    """The backend's z, then solutions on the active sets that its z, and its z and w, show."""
    if not np.isfinite(answer.z).all():
        return
    M, q, lower, upper = program.M, program.q, program.lower, program.upper
    free = (lower == -np.inf) & (upper == np.inf)
    z = program.within(answer.z)
    yield z, ""
    if out_of_time():
        return
    yield shortest(M, polish(M, q, z, None, lower, upper), free), ", active set"
    if np.isfinite(answer.w).all():
        yield shortest(M, polish(M, q, z, answer.w, lower, upper), free), ", active set"


def duality_gap(problem: Lcp | BoxedLcp | MixedLcp, z: npt.ArrayLike) -> float:
    """What the optima of the two programs lack of adding up to zero, relative: |z.w| / (|z|.|M z| + |z|.|q|).

    Of boxed problems (z - b).w instead of z.w, where b is the bound that w pushes against, 0 where there is none, and
    |z| + |b| instead of |z|.
    z (n,); dimensionless, 0 for a solution and for z = 0 of an LCP, inf for a z that holds NaN or inf. Raises
    ModelError if z has another shape.
    """
    if not math.isfinite(problem.residual(z)):
        return math.inf
    point, box = np.asarray(z, dtype=float), _box(problem)
    with np.errstate(all="ignore"):
        force = problem.M @ point
        total = force + problem.q
        bound = np.zeros(len(point))
        if box is not None:
            pushed = np.where(total > 0.0, box.lower, np.where(total < 0.0, box.upper, 0.0))
            bound = np.where(np.isfinite(pushed), pushed, 0.0)
        size = float((np.abs(point) + np.abs(bound)) @ (np.abs(force) + np.abs(problem.q)))
        gap = abs(float((point - bound) @ total))
    if not (math.isfinite(size) and math.isfinite(gap)):
        return math.inf
    return gap / size if size > 0.0 else 0.0


def _box(problem: object) -> BoxedLcp | None:
    """The bounds of a problem that has them."""
    return problem.boxed if isinstance(problem, MixedLcp) else problem if isinstance(problem, BoxedLcp) else None


def _symmetric_without_free(problem: PosedProblem, box: BoxedLcp | None) -> bool:
    """Whether the LCP is a quadratic program though the problem is none: so are some without their free unknowns."""
    if box is not None:
        below, above = np.isfinite(box.lower), np.isfinite(box.upper)
        if (below | above).all() or (below & above).any():
            return False
    return posed(problem).lcp().symmetric


def _scale(M: FloatArray) -> FloatArray:
    diagonal = np.abs(np.diag(M))
    return np.asarray(1.0 / np.sqrt(np.where(diagonal > 0.0, diagonal, 1.0)))


def _no_program(box: BoxedLcp) -> str:
    """Why a box is no convex quadratic program as it is; empty if it is one."""
    scale = _scale(box.M)
    with np.errstate(all="ignore"):
        M, q = box.M * scale[:, None] * scale, box.q * scale
    if not is_symmetric(M, box.size):
        return UNSYMMETRIC
    return _not_convex(0.5 * M + 0.5 * M.T, q)


def _not_convex(M: FloatArray, q: FloatArray) -> str:
    """Why a backend must not be given the scaled problem; empty if it may."""
    if not (np.isfinite(M).all() and np.isfinite(q).all()):
        return "the numbers of the problem overflow when they are scaled"
    try:
        np.linalg.cholesky(M + NEGATIVE * np.eye(len(M)))
    except np.linalg.LinAlgError:
        return "M is indefinite: its quadratic program is not convex, and no backend solves those; use Lemke()"
    return ""
