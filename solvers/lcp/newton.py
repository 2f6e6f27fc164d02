"""Semismooth Newton method on the min-map, min(d_i z_i, w_i) = 0 with d_i the largest |M_ij| of row i.

Where d z > w the equation is w_i = 0, elsewhere z_i = 0; a Newton step solves the one linear system
M_AA z_A = -q_A, z = 0 off A. The step is shortened until the merit 1/2 |min(d z, w)|^2 falls; where no length does, the
step is that of a proximal problem, (M + r D) z + q - r D z_k, which is regular for r large enough, and r is lowered
again. Finite for P-matrices near a solution, and usually fast; without a guarantee elsewhere.
Sources: Pang 1990; Fischer & Kanzow 1996 (finite termination).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lcpflex.jit.kernel import FloatArray, IntArray, kernel
from lcpflex.solvers.acceptance import accept
from lcpflex.solvers.arguments import check_guess, posed
from lcpflex.solvers.attention import is_called, listening
from lcpflex.solvers.certificate import natural_residual
from lcpflex.solvers.clock import grown
from lcpflex.solvers.lcp.pivoting import solve_active
from lcpflex.solvers.limits import keep_settings
from lcpflex.solvers.problem import Lcp, PosedProblem, Solution
from lcpflex.solvers.refusals import no_cones
from lcpflex.solvers.status import ITERATION_LIMIT, NUMERICAL_FAILURE, SOLVED, Status

__all__ = ["MinMapNewton", "min_map_newton", "newton_workspace"]

STARTS = 3  # points it may begin from
HALVINGS = 10  # of a step
SUFFICIENT = 1e-4  # part of the promised decrease of the merit that a step must give
PATIENCE = 3  # full steps allowed to let the merit grow: they end many cycles of halvings
STALE = 30  # iterations without a better point before the next start
ROUNDED = 1e-14  # residual at which nothing more can be gained


def newton_workspace(capacity: int) -> tuple[FloatArray, FloatArray, IntArray]:
    """Work arrays (vectors, table, basis) of :func:`min_map_newton` for problems of up to ``capacity`` unknowns."""
    return (
        np.zeros((6, capacity)),
        np.zeros((2 * capacity + 3, capacity + 3)),
        np.zeros(3 * capacity + 1, dtype=np.int64),
    )


@kernel
def _min_map(M: FloatArray, q: FloatArray, n: int, z: FloatArray, d: FloatArray, w: FloatArray) -> float:
    """w = M z + q and the merit 1/2 |min(d z, w) / d|^2, inf if it is not finite."""
    merit = 0.0
    for i in range(n):
        total = q[i]
        for j in range(n):
            total += M[i, j] * z[j]
        w[i] = total
        least = min(d[i] * z[i], total) / d[i]
        merit += 0.5 * least * least
    return merit if merit < np.inf else np.inf


@kernel
def _begin(M: FloatArray, q: FloatArray, n: int, start: int, d: FloatArray, z: FloatArray) -> None:
    """Row sizes d, and a point to begin from: zero, each contact by itself, or all of them pressed."""
    for i in range(n):
        d[i] = 0.0
        for j in range(n):
            d[i] = max(d[i], abs(M[i, j]))
        if d[i] == 0.0:
            d[i] = 1.0
        if start == 0:
            z[i] = 0.0
        elif start == 1:
            z[i] = max(-q[i], 0.0) / (M[i, i] if M[i, i] > 0.0 else d[i])
        else:
            z[i] = (abs(q[i]) + 1e-3) / d[i]


@kernel
def _newton_point(
    M: FloatArray,
    q: FloatArray,
    n: int,
    z: FloatArray,
    d: FloatArray,
    w: FloatArray,
    proximity: float,
    target: FloatArray,
    shifted: FloatArray,
    table: FloatArray,
    basis: IntArray,
) -> None:
    """The point a full step leads to, of the problem itself or of the proximal one; ``target`` (n,)."""
    regular = table[n + 3 :]
    for i in range(n):
        basis[i] = 1 if d[i] * z[i] > w[i] else 0
        shifted[i] = q[i] - proximity * d[i] * z[i]
        for j in range(n):
            regular[i, j] = M[i, j]
        regular[i, i] += proximity * d[i]
    solve_active(regular, shifted, n, target, table, basis)


@kernel
def _step(
    M: FloatArray,
    q: FloatArray,
    n: int,
    z: FloatArray,
    d: FloatArray,
    merit: float,
    full: bool,
    target: FloatArray,
    trial: FloatArray,
    w: FloatArray,
) -> float:
    """Move z towards ``target`` as far as the merit falls, or all the way if ``full``; the merit there, -1 if nowhere.

    w belongs to the new z.
    """
    length = 1.0
    for _ in range(HALVINGS):
        for i in range(n):
            trial[i] = z[i] + length * (target[i] - z[i])
        reached = _min_map(M, q, n, trial, d, w)
        if reached <= (1.0 - SUFFICIENT * length) * merit or (full and reached < np.inf):
            for i in range(n):
                z[i] = trial[i]
            return reached
        length *= 0.5
    return -1.0


@kernel
def min_map_newton(
    M: FloatArray,
    q: FloatArray,
    n: int,
    z: FloatArray,
    warm: bool,
    tolerance: float,
    limit: int,
    vectors: FloatArray,
    table: FloatArray,
    basis: IntArray,
) -> tuple[int, int]:
    """Solve 0 <= z _|_ M z + q >= 0; returns (status, iterations), status as the integers of :class:`Status`.

    M (cap, cap) and q (cap,): the leading n x n block and first n entries count and are not changed. z (cap,): with
    ``warm`` the point to begin from; out, the best point found. vectors, table, basis: of ``newton_workspace(cap)``;
    basis[:n] is 1 where z is basic if solved. limit: iterations from all starts together.
    """
    d, w, target, shifted, trial, point = vectors[0], vectors[1], vectors[2], vectors[3], vectors[4], vectors[5]
    best, count = np.inf, 0
    first = -1 if warm else 0
    for start in range(first, STARTS):
        _begin(M, q, n, max(start, 0), d, point)
        if start < 0:
            for i in range(n):
                point[i] = z[i]
        merit = _min_map(M, q, n, point, d, w)
        proximity, patience, stale = 0.0, PATIENCE, 0
        while count < limit and merit < np.inf and stale < STALE and not is_called(basis):
            count += 1
            _newton_point(M, q, n, point, d, w, proximity, target, shifted, table, basis)
            reached = _step(M, q, n, point, d, merit, patience > 0 and proximity == 0.0, target, trial, w)
            if reached < 0.0:
                merit = _min_map(M, q, n, point, d, w)
                proximity = max(10.0 * proximity, 1e-4)
                if proximity > 1e8:
                    break
                stale += 1
                continue
            if reached > merit:
                patience -= 1
            proximity = 0.1 * proximity if proximity > 1e-8 else 0.0
            merit = reached
            stale += 1
            for i in range(n):
                trial[i] = max(point[i], 0.0)
            residual = natural_residual(M, q, trial, n)
            if residual < best:
                stale = stale if residual > 0.5 * best else 0
                best = residual
                for i in range(n):
                    z[i] = trial[i]
            if best <= tolerance:
                for i in range(n):
                    basis[i] = 1 if d[i] * point[i] > w[i] else 0
                return SOLVED, count
        if count >= limit:
            return ITERATION_LIMIT, count
    return NUMERICAL_FAILURE, count


@dataclass(frozen=True, slots=True)
class MinMapNewton:
    """Semismooth Newton method, for any matrix.

    tolerance: largest accepted residual [-]. iteration_limit: from all starting points together, None for 200 + n.
    Raises ModelError for a tolerance or limit that is not positive. Without a guarantee; a guess near the solution
    usually takes two iterations.
    """

    tolerance: float = 1e-10
    iteration_limit: int | None = None

    def __post_init__(self) -> None:
        keep_settings(self, "iteration_limit")

    def refuses(self, problem: Lcp | PosedProblem) -> str:
        """Why the solver cannot take the problem, as those with cones; empty if it can."""
        return no_cones(self, problem)

    def solve(self, problem: Lcp | PosedProblem, guess: Solution | None = None) -> Solution:
        """Solve the problem, beginning from z of the guess if there is one."""
        check_guess(guess)
        if not isinstance(problem, Lcp) or problem.balanced()[1] is not None:
            return posed(problem).solve_by(self, guess)
        n = problem.size
        z = np.zeros(n)
        warm = guess is not None and guess.z.shape == (n,) and bool(np.isfinite(guess.z).all())
        if warm:
            z[:] = guess.z  # type: ignore[union-attr]
        vectors, table, basis = newton_workspace(n)
        basis, ear = listening(basis, n)
        limit = 200 + n if self.iteration_limit is None else self.iteration_limit
        start = z.copy()

        def iterated(most: int) -> tuple[int, int]:
            z[:] = start
            return min_map_newton(*problem._data, n, z, warm, self.tolerance, most, vectors, table, basis)

        (code, count), cut = grown(iterated, limit, n, lambda found: found[0] == ITERATION_LIMIT, ear)
        status = Status.TIME_LIMIT if cut else Status(code)
        return accept(
            problem,
            z,
            tolerance=self.tolerance,
            status=status,
            iterations=count,
            route="min-map Newton",
            active=basis[:n].copy() if status is Status.SOLVED else None,
        )
