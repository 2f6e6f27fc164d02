"""The default solver: the cheapest method that can be trusted with the problem, then the next one, and the next.

A problem that resembles the last one is nearly always solved by the basis of the last one, at the cost of one linear
solve. Failing that, symmetric problems go to principal pivoting, others to Lemke's algorithm. What neither solves goes
down a chain in which each method can do what those before it cannot: the copositive form of friction (Lemke's
guarantee), Newton's method, the linear program that proves that there is no solution, enumeration of all active sets,
and for contacts Newton's method on perturbed data. Each answer is judged on the original data, proofs in exact
arithmetic; the route tells who gave it, and who failed before.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from lcpflex.errors import ModelError, SolverError, shown
from lcpflex.jit.kernel import FloatArray, IntArray, kernel
from lcpflex.solvers.arguments import check_guess, check_solver, posed
from lcpflex.solvers.clock import check_time_limit, expired, out_of_time, within
from lcpflex.solvers.contact.lcp_forms import from_copositive
from lcpflex.solvers.contact.parts import solved_by_parts
from lcpflex.solvers.contact.problem import ContactProblem, aligned
from lcpflex.solvers.guard import ENDED, FAILED, guarded, joined
from lcpflex.solvers.lcp.enumeration import Enumeration
from lcpflex.solvers.lcp.farkas import candidate
from lcpflex.solvers.lcp.lemke import Lemke, lemke, pivot_budget
from lcpflex.solvers.lcp.newton import MinMapNewton
from lcpflex.solvers.lcp.perturbed import PERTURBED, TRIALS, perturbed_newton
from lcpflex.solvers.lcp.pivoting import block_pivots
from lcpflex.solvers.lcp.principal_pivoting import PrincipalPivoting, principal_pivoting
from lcpflex.solvers.lcp.proofs import FULL, exact_solution
from lcpflex.solvers.lcp.repairing import repaired
from lcpflex.solvers.lcp.tableau import EXTRA
from lcpflex.solvers.limits import keep_settings
from lcpflex.solvers.problem import NEARLY, Lcp, LcpSolver, PosedProblem, Problem, Solution, accept, confirmed
from lcpflex.solvers.refusals import has_cones
from lcpflex.solvers.status import SOLVED, Status

if TYPE_CHECKING:
    from lcpflex.solvers.contact.many import Search

__all__ = ["TARGET", "Auto", "auto", "auto_workspace", "solve_lcp"]

FLIPS = 5  # exchanges after which a basis from elsewhere was no help
TARGET = 1e-10  # residual of a solution
SMALL = 60  # unknowns up to which parts are looked for only where the whole is not solved at once
PIVOTED = 300  # unknowns up to which Lemke's method is cheaper than what else is done for many contacts
MANY = 900  # unknowns up to which it is the last word: ten seconds
NEAR = 1e-3  # residual below which a problem is not suspected of having no solution
TOO_MANY = 3000  # unknowns from which no dense matrix is tried
PROGRAM = "linear program of Farkas"
EXACT = "search in whole numbers"
FACTORS = 600  # sparse factors that one problem of many contacts may take, unless the user says otherwise
SEARCH = 5e5  # entries that it may compute: a third of a second

KEPT = (Status.INACCURATE, Status.RIGHT_TO_TERMS, Status.TIME_LIMIT)  # what a point is, whoever failed besides

Step = tuple[str, Callable[[], Solution]]  # with its name in the route


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
        if isinstance(problem, ContactProblem):
            return _to_last_digits(problem, self._contact(problem, guess, trials), self.tolerance)
        if has_cones(problem):
            from lcpflex.solvers.contact.cones.chain import solved_in_cones  # the plane needs none of it

            found = solved_in_cones(problem, guess, self.tolerance)  # type: ignore[arg-type]
            return _to_last_digits(problem, found, self.tolerance)
        if not isinstance(problem, Lcp):
            return posed(problem).solve_by(self, guess)
        first = self._first(problem, guess)
        if first.settled:
            return first
        steps = self._last_steps(problem)
        if problem.size <= FULL:  # up to LARGEST the enumeration asks it too, where floats find nothing
            steps.append((EXACT, lambda: self._exact(problem)))
        return _descend(problem, first, steps, self.tolerance)

    def _first(self, problem: Lcp, guess: Solution | None) -> Solution:
        """By pivoting, and by exchanges row by row where that looked at the large rows alone."""
        found = self._pivoted(problem, guess)
        if found.settled:
            return found
        mended = repaired(problem, found, self.tolerance)
        return found if mended is None else _after(found, mended)

    def _pivoted(self, problem: Lcp, guess: Solution | None) -> Solution:
        """By the basis of the guess, else by principal pivoting where M is symmetric, and by Lemke."""
        if not problem.symmetric:
            return _lemke(self.tolerance).solve(problem, guess)
        found = _principal(self.tolerance).solve(problem, guess)
        if found.settled:
            return found
        steps: list[Step] = [("lemke", lambda: Lemke(self.tolerance).solve(problem))]
        return _descend(problem, found, steps, self.tolerance)

    def _contact(self, problem: ContactProblem, guess: Solution | None, trials: int) -> Solution:
        """Contact with friction: as a whole where that is cheap, else part by part."""
        keys = problem.unknown_keys
        guess = aligned(guess, keys)
        if problem.size <= SMALL:
            return replace(self._few(problem, guess, trials, whole=True), keys=keys)
        from lcpflex.solvers.contact.many import Search  # which the steps of a run do not need

        search = Search(problem, guess, self.tolerance, self.factors)
        if search.run(search.swept):
            return replace(search.solution(), keys=keys)
        swept = search.solution()
        found = self._by_parts(problem, swept, replace(swept, keys=keys), trials)
        return replace(self._many(search, trials) if found is None else found, keys=keys)

    def _few(self, problem: ContactProblem, guess: Solution | None, trials: int, whole: bool) -> Solution:
        """A few contacts, as one LCP. whole: whether they may fall into parts."""
        swept = None
        if problem.delassus is None:
            swept = _swept(problem, guess, self.tolerance)
            if swept.solved or out_of_time():
                return swept if swept.solved else replace(swept, route=joined(swept))
        found = self._first(problem.lcp(), guess)
        if not found.settled:
            apart = self._by_parts(problem, found, guess, trials) if whole else None
            found = self._dense(problem, found, trials) if apart is None else apart
        found = self._told(problem, found)
        return found if swept is None else _best(swept, found)

    def _by_parts(
        self, problem: ContactProblem, first: Solution, guess: Solution | None, trials: int
    ) -> Solution | None:
        """After a first attempt at the whole, each of its parts by itself; None if there is but one."""
        apart = solved_by_parts(problem, guess, self.tolerance, lambda part, its: self._part(part, its, trials))
        if apart is None:
            return None
        return replace(_best(first, apart), route=f"{joined(first)} > {apart.route}")

    def _part(self, part: ContactProblem, guess: Solution | None, trials: int) -> Solution:
        """Contacts that do not fall into parts."""
        if part.size > SMALL:
            from lcpflex.solvers.contact.many import Search

            search = Search(part, guess, self.tolerance, self.factors)
            return search.solution() if search.run(search.swept) else self._many(search, trials)
        return self._few(part, guess, trials, whole=False)

    def _many(self, search: Search, trials: int) -> Solution:
        """Many contacts on which a few sweeps did not settle; by pivoting too where they are not too many for it."""
        problem, pivoted = search.problem, None
        search.run(search.finished)
        if not search.done and problem.size <= PIVOTED and not out_of_time():
            pivoted = self._first(problem.lcp(), None)
            if pivoted.settled:
                return self._told(problem, _after(search.solution(), pivoted))
        search.run(search.swept_on, search.relaxed, search.finished, search.newton)
        found = search.solution() if pivoted is None else _best(pivoted, search.solution())
        if search.done or problem.size > TOO_MANY or out_of_time():
            return found
        return self._told(problem, self._last_word(problem, found, pivoted, trials))

    def _last_word(self, problem: ContactProblem, first: Solution, pivoted: Solution | None, trials: int) -> Solution:
        """Where all else failed: dense pivoting up to MANY unknowns, beyond the proof that there is no solution."""
        if problem.size > MANY:
            if first.residual < NEAR:
                return first
            steps: list[Step] = [(PROGRAM, lambda: self._infeasible(problem.lcp()))]
            return _descend(problem.lcp(), first, steps, self.tolerance)
        if pivoted is None:
            pivoted = self._first(problem.lcp(), None)
        return _best(first, pivoted if pivoted.settled else self._dense(problem, pivoted, trials))

    def _dense(self, problem: ContactProblem, first: Solution, trials: int) -> Solution:
        """After a first attempt at the LCP, all that can be tried on it."""
        lcp = problem.lcp()
        steps: list[Step] = []
        if len(problem.tangent):
            steps.append(("lemke on the copositive form", lambda: self._copositive(problem, lcp)))
        if problem.size <= SMALL:
            steps.append(("block Gauss-Seidel", lambda: _swept(problem, None, self.tolerance)))
        steps += self._last_steps(lcp)
        steps.append((PERTURBED, lambda: perturbed_newton(lcp, problem.unknown_units.d, self.tolerance, trials)))
        return _descend(lcp, first, steps, self.tolerance)

    def _told(self, problem: ContactProblem, found: Solution) -> Solution:
        """What was found for the LCP, said of the contacts."""
        if found.status is Status.NOT_UNIQUE:
            found = problem.told_apart(problem.lcp(), found, self.tolerance)
        return confirmed(problem, found)

    def _copositive(self, problem: ContactProblem, lcp: Lcp) -> Solution:
        """Lemke on the form of friction for which its path ends in a solution whenever theory knows one."""
        tangent, normals = problem.tangent, len(problem.friction)
        found = Lemke(self.tolerance).solve(problem.copositive_lcp())
        z = np.zeros(lcp.size)
        from_copositive(found.z, *lcp._data, problem._data[2], tangent, normals, len(tangent), z)
        return accept(
            lcp,
            z,
            tolerance=self.tolerance,
            status=found.status,
            iterations=found.iterations,
            route="lemke on the copositive form",
        )

    def _last_steps(self, problem: Lcp) -> list[Step]:
        """What can be tried on any matrix, and the proof that there is nothing to be found."""
        enumeration = Enumeration(self.tolerance)
        steps: list[Step] = [
            ("min-map Newton", lambda: MinMapNewton(self.tolerance).solve(problem)),
            (PROGRAM, lambda: self._infeasible(problem)),
        ]
        if not enumeration.refuses(problem):
            steps.append(("enumeration", lambda: enumeration.solve(problem)))
        return steps

    def _exact(self, problem: Lcp) -> Solution:
        """The search without rounding: a solution that floats can hold, or the proof that there is none."""
        proof, z = exact_solution(problem, SEARCH)
        point = np.zeros(problem.size) if z is None else z
        return accept(
            problem, point, tolerance=self.tolerance, status=Status.NUMERICAL_FAILURE, route=EXACT, proof=proof
        )

    def _infeasible(self, problem: Lcp) -> Solution:
        u = candidate(*problem._data)
        return accept(problem, np.zeros(problem.size), tolerance=self.tolerance, route=PROGRAM, certificate=u)


def _to_last_digits(problem: Lcp | PosedProblem, found: Solution, tolerance: float) -> Solution:
    if not (found.solved and found.strict > tolerance):
        return found
    from lcpflex.solvers.contact.last_digits import with_last_digits  # which the steps of a run do not need

    return with_last_digits(problem, found, tolerance)


def _swept(problem: ContactProblem, guess: Solution | None, tolerance: float) -> Solution:
    from lcpflex.solvers.contact.block_gauss_seidel import BlockGaussSeidel  # which the steps of a run do not need

    return BlockGaussSeidel(tolerance).solve(problem, guess)


_lemke = lru_cache(Lemke)  # its settings checked once
_principal = lru_cache(PrincipalPivoting)


def _descend(problem: Problem, first: Solution, steps: list[Step], tolerance: float) -> Solution:
    """One step after the other until one settles the problem; else the best point, and why the first method failed."""
    best, tried = first, [first]
    for name, step in steps:
        if out_of_time():
            iterations = sum(found.iterations for found in tried)
            return expired(replace(best, route=joined(*tried), iterations=iterations))
        found = guarded(name, problem, tolerance, step)
        tried.append(found)
        if _is_better(found, best):
            best = found
        if found.settled:
            break
    route, iterations = joined(*tried), sum(found.iterations for found in tried)
    if best.settled or best.status in KEPT:
        return replace(best, route=route, iterations=iterations)
    names = " > ".join(name.removesuffix(FAILED) for found in tried for name in found.route.split(" > "))
    reasons = [f"{first.status.words}: nothing of {names} found a solution or proved that none is"]
    reasons += [found.message for found in tried if ENDED in found.message]
    if any(NEARLY in found.message for found in tried):
        reasons.append(NEARLY)
    message = "; ".join(dict.fromkeys(reasons))
    return replace(best, status=first.status, route=route, iterations=iterations, message=message)


def _is_better(found: Solution, best: Solution) -> bool:
    """Whether one settles the problem, or is right to its terms and the other is not, or else has less left."""
    if found.settled or best.settled:
        return not best.settled
    ranks = [one.status is Status.RIGHT_TO_TERMS for one in (found, best)]
    return ranks[0] if ranks[0] != ranks[1] else found.residual < best.residual


def _after(first: Solution, found: Solution) -> Solution:
    """The second, with the route and the iterations of both."""
    route = f"{joined(first)} > {joined(found)}"
    return replace(found, route=route, iterations=first.iterations + found.iterations)


def _best(first: Solution, found: Solution) -> Solution:
    """The same, at the point of the first where that one is better; why it is no solution is what the second says."""
    told = _after(first, found)
    if not _is_better(first, found):
        return told
    kept = replace(first, route=told.route, iterations=told.iterations)
    if first.status in KEPT:
        return kept
    return replace(kept, status=told.status, message=told.message)


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
