"""The default solver: the cheapest method that can be trusted with the problem, then the next one, and the next.

A problem that resembles the last one is nearly always solved by the basis of the last one, at the cost of one linear
solve. Failing that, symmetric problems go to principal pivoting, others to Lemke's algorithm, many contacts to sweeps.
What these do not solve goes down :mod:`lcpflex.solvers.user_table`, in which each row can do what those before it
cannot. Each answer is judged on the original data, proofs in exact arithmetic; the route tells who gave it, and who
failed before.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from lcpflex.errors import ModelError, SolverError, shown
from lcpflex.jit.kernel import FloatArray, IntArray, kernel
from lcpflex.solvers.arguments import check_guess, check_solver, posed
from lcpflex.solvers.clock import check_time_limit, within
from lcpflex.solvers.contact.problem import ContactProblem, aligned
from lcpflex.solvers.lcp.lemke import lemke, pivot_budget
from lcpflex.solvers.lcp.perturbed import TRIALS
from lcpflex.solvers.lcp.pivoting import block_pivots
from lcpflex.solvers.lcp.principal_pivoting import principal_pivoting
from lcpflex.solvers.lcp.tableau import EXTRA
from lcpflex.solvers.limits import keep_settings
from lcpflex.solvers.problem import Lcp, LcpSolver, PosedProblem, Solution
from lcpflex.solvers.refusals import has_cones
from lcpflex.solvers.status import SOLVED
from lcpflex.solvers.user_table import LCP, PLANE, SPACE, Case, solve_by_table

__all__ = ["TARGET", "Auto", "auto", "auto_workspace", "solve_lcp"]

FLIPS = 5  # exchanges after which a basis from elsewhere was no help
TARGET = 1e-10  # residual of a solution
FACTORS = 600  # sparse factors that one problem of many contacts may take, unless the user says otherwise


@kernel
def auto(
    M: FloatArray,
    q: FloatArray,
    n: int,
    z: FloatArray,
    table: FloatArray,
    basis: IntArray,
    symmetric: bool,
    warm: bool,
) -> tuple[int, int]:
    """The compiled part of the chain: basis of the last problem, principal pivoting, Lemke; (status, iterations).

    M (cap, cap) and q (cap,): the leading n x n block and first n entries count and are not changed. Out: z (cap,).
    table, basis: of ``auto_workspace(cap)``; basis[:n] is 1 where z is basic if solved, and with ``warm`` it holds the
    basis to start from. symmetric: whether M is known to be.
    """
    done = 0
    if symmetric:
        status, done = principal_pivoting(M, q, n, z, table, basis, warm, TARGET, 100 + 20 * n)
        if status == SOLVED:
            return status, done
    elif warm:
        done, residual = block_pivots(M, q, n, z, table, basis, FLIPS)
        if done > 0 and residual <= TARGET:
            return SOLVED, done
    status, pivots = lemke(M, q, n, z, table, basis, pivot_budget(n))
    return status, max(done, 0) + pivots


def auto_workspace(capacity: int) -> tuple[FloatArray, IntArray]:
    """Work arrays (table, basis) of :func:`auto` for problems of up to ``capacity`` unknowns."""
    return np.zeros((capacity + EXTRA, capacity + 1)), np.zeros(4 * capacity + 3, dtype=np.int64)


@dataclass(frozen=True, slots=True)
class Auto:
    """The default solver, for every problem.

    tolerance: largest accepted residual [-]. budget: seconds that one solve may take, None for no limit of time (then
    answers do not depend on the machine's speed); factors: sparse factorisations that a contact problem of more than 60
    unknowns may take. What does not reach the tolerance within them is returned as the best point, with its residual.
    Raises ModelError for numbers that make no sense.

    Guaranteed for positive (semi)definite and P-matrices and for planar friction posed as a :class:`ContactProblem`,
    as far as rounding allows. For other matrices all that can be tried is tried; without a solution the status is
    INFEASIBLE with its proof, NO_SOLUTION up to 16 unknowns (up to 48 where the search is short), else what stopped
    the first method.
    """

    tolerance: float = 1e-10
    budget: float | None = None
    factors: int = FACTORS

    def __post_init__(self) -> None:
        keep_settings(self, "factors", needed=True)
        object.__setattr__(self, "budget", check_time_limit("budget", self.budget))

    def refuses(self, problem: Lcp | PosedProblem) -> str:
        """Empty: it takes every problem."""
        return ""

    def solve(self, problem: Lcp | PosedProblem, guess: Solution | None = None) -> Solution:
        """The certified solution, or the best point of the whole chain with the reason why it is none.

        guess: the solution of a similar problem; its basis is tried first, matched by contact where problems have keys.
        """
        if self.budget is None:
            return self.attempt(problem, guess, TRIALS)
        with within(self.budget):
            return self.attempt(problem, guess, TRIALS)

    def attempt(self, problem: Lcp | PosedProblem, guess: Solution | None, trials: int) -> Solution:
        """The same with at most so many trials on perturbed data: a run has no seconds for each of its steps.

        problem: an :class:`Lcp`, a :class:`ContactProblem` or another problem that is posed as one. guess: the
        solution of a similar problem to start from, or None.
        """
        check_guess(guess)
        if isinstance(problem, Lcp):
            return solve_by_table(Case(LCP, problem, guess, self.tolerance, self.factors, trials))
        planar = isinstance(problem, ContactProblem)
        if not (planar or has_cones(problem)):
            return posed(problem).solve_by(self, guess)
        keys = problem.unknown_keys  # type: ignore[attr-defined]
        guess, kind = (aligned(guess, keys), PLANE) if planar else (guess, SPACE)
        return replace(solve_by_table(Case(kind, problem, guess, self.tolerance, self.factors, trials)), keys=keys)


def _check_alone(problem: Any) -> None:
    """Raise ModelError for what was given without q and is no problem."""
    try:
        posed(problem)
    except ModelError:
        words = f"expected a vector, or a problem instead of M ({shown(problem)} was given)"
        raise ModelError(f"q is None: {words}") from None


def solve_lcp(
    M: npt.ArrayLike | Lcp | PosedProblem,
    q: npt.ArrayLike | None = None,
    *,
    solver: LcpSolver | None = None,
    guess: Solution | None = None,
) -> Solution:
    """Solve 0 <= z _|_ M z + q >= 0, or any problem of this package.

    Parameters
    ----------
    M, q
        Matrix (n, n) and vector (n,); or a problem alone: Lcp, MixedLcp, BoxedLcp, ContactProblem.
    solver
        :class:`Auto` by default.
    guess
        The solution of a similar problem.

    Raises
    ------
    ModelError
        For data that are no problem.
    SolverError
        If the problem was not solved; its ``solution`` holds the best point, the reason, and the proof if none exists.
    """
    if q is None:
        if not isinstance(M, Lcp):
            _check_alone(M)
        problem = M
    else:
        problem = Lcp(M, q)  # type: ignore[arg-type]
    if solver is not None:
        check_solver(solver)
    check_guess(guess)
    solution = (Auto() if solver is None else solver).solve(problem, guess)  # type: ignore[arg-type]
    if not solution.solved:
        status = solution.status.words
        told = solution.message.startswith(status)  # most messages name it themselves
        raise SolverError(solution.message if told else f"{status}: {solution.message}", solution)
    return solution
