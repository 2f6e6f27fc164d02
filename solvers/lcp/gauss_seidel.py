"""Projected Gauss-Seidel iteration with relaxation (PSOR), row by row.

    z_i <- max(0, z_i - omega w_i / M_ii),   w_i = (M z + q)_i with the newest z

Converges for symmetric positive definite M and 0 < omega < 2, slowly where contacts are redundant or masses differ.
Rows whose diagonal is not positive are divided by their largest entry instead, without a guarantee. From time to time
the active set {d z > w} is handed to block pivoting, which ends the crawl to the last digits as soon as the set is
right. Source: Cottle, Pang & Stone 1992, section 5.2 (Cryer 1971).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from lcpflex.basics.options import keep_number
from lcpflex.jit.kernel import FloatArray, IntArray, kernel
from lcpflex.solvers.acceptance import accept
from lcpflex.solvers.arguments import check_guess, posed
from lcpflex.solvers.attention import is_called, listening
from lcpflex.solvers.certificate import natural_residual
from lcpflex.solvers.clock import grown
from lcpflex.solvers.lcp.lemke import lemke_workspace
from lcpflex.solvers.lcp.pivoting import block_pivots
from lcpflex.solvers.limits import keep_settings
from lcpflex.solvers.problem import Lcp, PosedProblem, Solution
from lcpflex.solvers.refusals import no_cones
from lcpflex.solvers.status import ITERATION_LIMIT, NUMERICAL_FAILURE, SOLVED, Status

__all__ = ["GaussSeidel", "projected_gauss_seidel"]

FIRST_LOOK = 8  # sweeps before the first look at the residual; each time twice as many
EXCHANGES = 5  # of the active set in one attempt to finish
RUNAWAY = 1e14  # growth of z that ends the iteration
SMALL = 1e-12  # part of the largest entry of a row below which its diagonal is no use


@kernel
def _sweep(M: FloatArray, q: FloatArray, n: int, omega: float, z: FloatArray) -> float:
    """One sweep; the largest |z_i| after it, inf if one is not finite."""
    largest = 0.0
    for i in range(n):
        row = M[i]
        w, top = q[i], 0.0
        for j in range(n):
            w += row[j] * z[j]
            top = max(top, abs(row[j]))
        divisor = row[i] if row[i] > SMALL * top else top
        if divisor > 0.0:
            z[i] = max(0.0, z[i] - omega * w / divisor)
        if not z[i] < np.inf:
            return np.inf
        largest = max(largest, z[i])
    return largest


@kernel
def _active_set(M: FloatArray, q: FloatArray, n: int, z: FloatArray, basis: IntArray) -> None:
    """basis[i] = 1 where d_i z_i > w_i."""
    for i in range(n):
        w, top = q[i], 0.0
        for j in range(n):
            w += M[i, j] * z[j]
            top = max(top, abs(M[i, j]))
        basis[i] = 1 if top * z[i] > w else 0


@kernel
def projected_gauss_seidel(
    M: FloatArray,
    q: FloatArray,
    n: int,
    z: FloatArray,
    omega: float,
    tolerance: float,
    limit: int,
    point: FloatArray,
    table: FloatArray,
    basis: IntArray,
) -> tuple[int, int, bool]:
    """Solve 0 <= z _|_ M z + q >= 0 from z on; returns (status, sweeps, whether block pivoting finished).

    M (cap, cap) and q (cap,): the leading n x n block and first n entries count and are not changed. z (cap,): in, the
    point to begin from, >= 0; out, the best point found. point (cap,), table, basis of ``lemke_workspace(cap)``: work;
    basis[:n] is 1 where z is basic if solved.
    """
    best, sweeps, next_look = natural_residual(M, q, z, n), 0, FIRST_LOOK
    if best <= tolerance:
        _active_set(M, q, n, z, basis)
        return SOLVED, sweeps, False
    start = 1.0
    for i in range(n):
        point[i] = z[i]
        start = max(start, z[i], abs(q[i]))
    while sweeps < limit and not is_called(basis):
        size = _sweep(M, q, n, omega, point)
        sweeps += 1
        if not size < RUNAWAY * start:
            return NUMERICAL_FAILURE, sweeps, False
        if sweeps < next_look and sweeps < limit:
            continue
        next_look = 2 * sweeps
        residual = natural_residual(M, q, point, n)
        if residual < best:
            best = residual
            for i in range(n):
                z[i] = point[i]
        _active_set(M, q, n, point, basis)
        if best <= tolerance:
            return SOLVED, sweeps, False
        candidate = table[n + 1]
        if block_pivots(M, q, n, candidate, table, basis, EXCHANGES)[0] > 0:
            residual = natural_residual(M, q, candidate, n)
            if residual < best:
                best = residual
                for i in range(n):
                    z[i] = candidate[i]
            if best <= tolerance:
                return SOLVED, sweeps, True
    return ITERATION_LIMIT, sweeps, False


@dataclass(frozen=True, slots=True)
class GaussSeidel:
    """Projected Gauss-Seidel iteration, for any matrix; made for symmetric positive definite ones.

    tolerance: largest accepted residual [-]; relaxation: omega in (0, 2); sweep_limit: largest number of sweeps. Raises
    ModelError for numbers out of their range. With friction posed as an LCP half of the diagonal is zero and the
    iteration seldom converges: :class:`BlockGaussSeidel` is made for that.
    """

    tolerance: float = 1e-10
    relaxation: float = 1.0
    sweep_limit: int = 2000

    def __post_init__(self) -> None:
        keep_settings(self, "sweep_limit", needed=True)
        keep_number(self, "relaxation", 0.0, 2.0, open_ends=True)

    def refuses(self, problem: Lcp | PosedProblem) -> str:
        """Why the solver cannot take the problem, as those with cones; empty if it can."""
        return no_cones(self, problem)

    def solve(self, problem: Lcp | PosedProblem, guess: Solution | None = None) -> Solution:
        """Iterate, from z of the guess if there is one.

        problem: an :class:`Lcp`, a :class:`ContactProblem` or another problem that is posed as one. guess: the
        solution of a similar problem to start from, or None.
        """
        check_guess(guess)
        if not isinstance(problem, Lcp) or problem.balanced()[1] is not None:
            return posed(problem).solve_by(self, guess)
        n = problem.size
        z = np.zeros(n)
        if guess is not None and guess.z.shape == (n,) and math.isfinite(float(guess.z.sum())):
            np.maximum(guess.z, 0.0, out=z)
        table, basis = lemke_workspace(n)
        basis, ear = listening(basis, n)
        start, point = z.copy(), np.zeros(n)

        def swept(most: int) -> tuple[int, int, bool]:
            z[:] = start
            return projected_gauss_seidel(
                *problem._data, n, z, self.relaxation, self.tolerance, most, point, table, basis
            )

        (code, sweeps, pivoted), cut = grown(swept, self.sweep_limit, n, lambda found: found[0] == ITERATION_LIMIT, ear)
        status = Status.TIME_LIMIT if cut else Status(code)
        return accept(
            problem,
            z,
            tolerance=self.tolerance,
            status=status,
            iterations=sweeps,
            route="Gauss-Seidel, finished by block pivoting" if pivoted else "Gauss-Seidel",
            active=basis[:n].copy() if status is Status.SOLVED else None,
        )
