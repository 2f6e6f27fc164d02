"""Choice between the two drivers of a step: compiled throughout, or its outer loop in Python.

The loop is Python where a Python function must be called in it: a solver that is not a kernel, a callback, a user's
own mechanics. Its source is the same (:func:`lcpflex.jit.dispatch.link`).
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from lcpflex.dynamics.impulse import AUTO, LEMKE, SOLUTION_KNOWN, WEDGED_KNOWN, measure, solve_lcp
from lcpflex.dynamics.workspace import Workspace
from lcpflex.errors import SolverError
from lcpflex.jit.dispatch import Hooks
from lcpflex.solvers.auto import Auto
from lcpflex.solvers.certificate import guarded_residual
from lcpflex.solvers.contact.problem import ContactProblem
from lcpflex.solvers.lcp.lemke import Lemke
from lcpflex.solvers.problem import Lcp, LcpSolver, Solution, Status
from lcpflex.solvers.user_solver import UserSolver, as_solver, own_part
from lcpflex.steppers.wedged import Wedged, parts

__all__ = [
    "Watch",
    "Rescue",
    "posed_lcp",
    "posed_problem",
    "put_solution",
    "solver_hooks",
    "solver_method",
]

Watch = Callable[[Workspace], None]

TRIALS = 10  # on perturbed data, for each problem: about as long as what has been tried before
MOST_RESCUES = 100  # at one instant: a repeated step that comes to other problems each time would not end


def solver_method(solver: LcpSolver) -> int:
    """How the compiled ``solve_lcp`` is to solve; for a solver that is not compiled in, as Auto would."""
    return LEMKE if type(solver) is Lemke else AUTO


def solver_hooks(solver: LcpSolver, watch: Watch | None = None) -> Hooks:
    """Replacement of the kernel ``solve_lcp`` by ``solver``, and of one that tells ``watch`` of each problem solved.

    None for Auto and Lemke, which are compiled in, as long as nobody watches.
    """
    compiled_in = type(solver) in (Auto, Lemke)  # not a class derived from them, which may do otherwise
    if watch is None:
        return {} if compiled_in else {solve_lcp: PythonSolve(solver)}
    return {solve_lcp: Watched(solve_lcp if compiled_in else PythonSolve(solver), watch)}


class Watched:
    """A way to solve the problem in the work memory, and somebody who is told of each one."""

    def __init__(self, solve: Callable[[Workspace], int], watch: Watch) -> None:
        self._solve, self._watch = solve, watch

    def __call__(self, work: Workspace) -> int:
        """0, or why it was not solved."""
        status = self._solve(work)
        self._watch(work)
        return status


class PythonSolve:
    """A solver behind the interface of the kernel; one of the library gets contacts, and its last answer as guess."""

    def __init__(self, solver: LcpSolver) -> None:
        self._solver = as_solver(solver)
        self._with_contacts = not isinstance(self._solver, UserSolver) or self._solver.takes == "problem"
        self._last: Solution | None = None

    def __call__(self, work: Workspace) -> int:
        """0, or why it was not solved."""
        if self._with_contacts:
            solution = self._solver.solve(posed_problem(work), self._last)
            self._last = solution if solution.solved else None
        else:
            solution = self._solver.solve(posed_lcp(work))
        _put(work, solution)
        return 0 if solution.solved else int(solution.status)


def _put(work: Workspace, solution: Solution) -> None:
    m = int(work.lcp_size)
    work.z[:m] = solution.z
    work.basis[:m] = solution.z > 0.0 if solution.active is None else solution.active
    work.certified = solution.residual
    work.pivots = solution.iterations
    work.relative_residual = getattr(solution, "strict", math.nan)


class Rescue:
    """The rest of the chain of Auto, for problems on which its compiled part failed. The step is then repeated.

    Where that fails as well, the best answer will do if it is right by its terms: see :mod:`lcpflex.steppers.wedged`.
    """

    def __init__(self, solver: LcpSolver, tolerance: float) -> None:
        self._solver, self._tolerance = as_solver(solver, tolerance), tolerance
        self._at, self._times = -1.0, 0
        self._wedged = Wedged()

    @property
    def solver(self) -> LcpSolver:
        """The solver of the run; one of the user's as an UserSolver with the tolerance of the run."""
        solver: LcpSolver = self._solver
        return solver

    def unsolved(self, work: Workspace, status: int, tolerance: float) -> str:
        """Why the contact problem in ``work`` does not count as solved, with what a solver of the user's says of it.

        Raises SolverError from what that solver raised.
        """
        words = _unsolved(work, status, tolerance)
        own = own_part(self._solver)
        if own is None or own.last is None or not own.last.error:
            return words
        words = f"{words}; {own.name} {own.last.error}"
        if own.last.cause is not None:
            raise SolverError(words) from own.last.cause
        return words

    def __call__(self, work: Workspace, at: float) -> bool:
        """Whether the problem posed in ``work`` at time ``at`` [s] was solved; the solution waits there."""
        if type(self._solver) not in (Auto, Lemke):
            return False
        self._times = self._times + 1 if at == self._at else 0
        self._at = at
        if self._times > MOST_RESCUES:
            return False
        points = [work.z[: int(work.lcp_size)].copy()]
        if type(self._solver) is Auto:
            solution = self._solver.attempt(posed_problem(work), None, TRIALS)
            # what fractions know to be solved, floats may refuse: once they have, it is not told to them again
            stands = self._times == 0 or guarded_residual(*parts(work, solution.z)) <= self._tolerance
            if solution.residual <= self._tolerance and stands:
                put_solution(work, solution)
                return True
            points.append(solution.z)
        best = self._wedged.best(work, points, self._tolerance)
        if best is None:
            return False
        self._wedged.note(work, at)
        work.z[: len(best)] = best
        work.known = WEDGED_KNOWN
        return True

    def remarks(self, name: Callable[[int], str]) -> list[str]:
        """The warning of problems that rounding did not let be solved any better; name: of a declared contact."""
        return self._wedged.remarks(name)


def put_solution(work: Workspace, solution: Solution) -> None:
    """Leave in ``work`` what is known to solve the problem posed there, for when it is posed again."""
    _put(work, solution)
    work.known = SOLUTION_KNOWN


def posed_lcp(work: Workspace) -> Lcp:
    """The LCP in ``work``, measured as the compiled solver would."""
    m = int(work.lcp_size)
    measure(work)
    return Lcp(work.M[:m, :m], work.q[:m]).measured_in(work.units[:m].copy())


def posed_problem(work: Workspace) -> Lcp | ContactProblem:
    """The contacts behind the LCP in ``work``, read off the form of :func:`assemble_friction_lcp`.

    Posed on index sets, the Delassus matrix holds the friction of sliding contacts in its normal columns and is
    unsymmetric. Contacts that share a key (two at one place) come as an LCP, and so does a problem that is shifted, as
    the expansion of Poisson's impact is.
    """
    n = int(work.n_contacts)
    n_tangent = (int(work.lcp_size) - n) // 2
    m = n + n_tangent
    keys = tuple(work.table.key[:n].tolist())
    if len(set(keys)) < n or work.q[m : m + n_tangent].any():
        return posed_lcp(work)
    twice_mu = work.M[m : m + n_tangent, :n]
    tangent = twice_mu.argmax(axis=1) if n else np.zeros(0, dtype=np.int64)
    friction = np.zeros(n)
    friction[tangent] = 0.5 * twice_mu[np.arange(n_tangent), tangent]
    delassus = work.M[:m, :m].copy()
    delassus[:, tangent] += delassus[:, n:] * friction[tangent]
    if n_tangent == work.n_tangents and np.allclose(delassus, work.Gc[:m, :m], rtol=1e-12, atol=0.0):
        delassus = work.Gc[:m, :m]  # the same without the rounding
    return ContactProblem(delassus, work.q[:m], friction, keys)


def _unsolved(work: Workspace, status: int, tolerance: float) -> str:
    """Why the contact problem in ``work`` does not count as solved."""
    found = Status(status) if status else Status.INACCURATE
    return (
        f"the contact problem of size {work.lcp_size} was not solved: {found.name.lower().replace('_', ' ')}, "
        f"natural-map residual {work.certified:.3g} (tolerance {tolerance:g})"
    )
