"""Choice between the two drivers of a step: compiled throughout, or its outer loop in Python.

The loop is Python where a Python function must be called in it: a solver that is not a kernel, a callback, a user's
own mechanics. Its source is the same (:func:`lcpflex.jit.dispatch.link`).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from typing import Any

import numpy as np

from lcpflex.dynamics.contact_problem import pose_island
from lcpflex.dynamics.workspace import DENSE, NO_LIMIT, Workspace
from lcpflex.errors import ModelError, SolverError
from lcpflex.jit.dispatch import Hooks
from lcpflex.solvers.auto import TARGET, Auto
from lcpflex.solvers.certificate import guarded_residual
from lcpflex.solvers.contact.algebra import PLANAR
from lcpflex.solvers.contact.compiled import AUTO, METHODS, solve_contacts
from lcpflex.solvers.contact.memory import ContactData, SolverMemory
from lcpflex.solvers.contact.posed import (
    lagging,
    measured,
    posed_lcp,
    posed_problem,
    put_solution,
    put_tried,
    put_wedged,
    take_solution,
    tried_point,
)
from lcpflex.solvers.problem import LcpSolver, Solution, Status
from lcpflex.solvers.refusals import has_cones
from lcpflex.solvers.user_solver import UserSolver, as_solver, own_part
from lcpflex.steppers.island_problems import tell_island
from lcpflex.steppers.wedged import Wedged

__all__ = [
    "Watch",
    "Rescue",
    "dense_limit",
    "solver_hooks",
    "solver_method",
]

Watch = Callable[[ContactData, SolverMemory], None]

TRIALS = 10  # on perturbed data, for each problem: about as long as what has been tried before
MOST_RESCUES = 100  # of an island at one instant: a repeated step that comes to other problems each time would not end


def solver_method(solver: LcpSolver, in_space: bool = False) -> int:
    """How the compiled ``solve_contacts`` is to solve; for a solver that is not compiled in, as Auto would.

    In space, where Auto alone is, others are to be given each problem. Raises ModelError for one that takes no cones.
    """
    if not in_space:
        return METHODS.get(type(solver), AUTO)
    from lcpflex.solvers.contact.cones.memory import COMPILED, POSED  # which the plane does without
    from lcpflex.solvers.contact.spatial import SpatialContactProblem

    if type(solver) is Auto:
        return COMPILED
    taker = as_solver(solver)
    asked = getattr(taker, "refuses", None)
    if reason := asked(SpatialContactProblem(np.eye(3), np.zeros(3), np.ones(1))) if callable(asked) else "":
        raise ModelError(f"solver: {reason}")
    return POSED


def dense_limit(solver: LcpSolver) -> int:
    """Contacts of the largest island that ``solver`` is given as one dense problem; any but Auto gets all of them."""
    return DENSE if type(solver) is Auto else NO_LIMIT


def solver_hooks(rescue: Rescue, watch: Watch | None = None, in_space: bool = False) -> Hooks:
    """Replacement of the kernel ``solve_contacts`` by the solver of a run, and by one that tells ``watch`` of problems.

    None for solvers that are compiled in, as long as nobody watches. In space the kernel is ``solve_cones``.
    """
    kernel: Any = solve_contacts
    solver = rescue.solver
    if in_space:
        from lcpflex.solvers.contact.cones.dense import solve_cones

        kernel = solve_cones
    compiled_in = type(solver) is Auto if in_space else type(solver) in METHODS  # not a class derived from one
    if watch is None:
        return {} if compiled_in else {kernel: PythonSolve(solver, rescue.note)}
    watched = Watched(kernel if compiled_in else PythonSolve(solver, rescue.note), watch)
    return {kernel: watched, tell_island: watched.tell}


class Watched:
    """A way to solve contact problems, and somebody who is told of each one."""

    def __init__(self, solve: Callable[[ContactData, SolverMemory], int], watch: Watch) -> None:
        self._solve, self._watch = solve, watch

    def __call__(self, data: ContactData, memory: SolverMemory) -> int:
        """0, or why it was not solved."""
        status = self._solve(data, memory)
        self._watch(data, memory)
        return status

    def tell(self, work: Workspace, i: int) -> None:
        """Pose island i densely, for the one who is told: it was solved in another form."""
        if not isinstance(work.posed.problem, ContactData):
            from lcpflex.steppers.spatial.island_problems import pose_begun

            pose_begun(work, i)
            self._watch(work.posed.problem, work.impulses.solver)
            return
        pose_island(work, i, PLANAR)
        judged = work.impulses.large_solver.judged
        work.impulses.solver.residual, work.impulses.solver.strict = judged.residual, judged.strict
        work.impulses.solver.iterations = work.impulses.large_solver.newton.factors
        self._watch(work.posed.problem, work.impulses.solver)


class PythonSolve:
    """A solver behind the interface of the kernel; one of the library gets contacts, and its last answer as guess.

    note: is told of each answer that does not solve its problem.
    """

    def __init__(self, solver: LcpSolver, note: Callable[[Solution], None]) -> None:
        self._solver, self._note = as_solver(solver), note
        self._tolerance = float(getattr(self._solver, "tolerance", TARGET))
        self._with_contacts = not isinstance(self._solver, UserSolver) or self._solver.takes == "problem"
        self._last: Solution | None = None

    def __call__(self, data: ContactData, memory: SolverMemory) -> int:
        """0, or why it was not solved."""
        if self._with_contacts:
            solution = self._solver.solve(posed_problem(data, memory), self._last)
            self._last = solution if solution.solved else None
        else:
            solution = self._solver.solve(posed_lcp(data, memory))
        take_solution(data, memory, solution)
        if solution.solved:
            return 0
        # SOLVED asks each contact for its own load; a run goes on with what is right as a whole, as its kernels do
        whole = guarded_residual(*measured(data, memory, solution.z)[0])
        if not whole <= self._tolerance:
            self._note(solution)
            return int(solution.status)
        memory.residual = whole
        return 0


class Rescue:
    """The rest of the chain of Auto, for problems on which its compiled part failed. The step is then repeated.

    Where that fails as well, the best answer will do if it is right by its terms: see :mod:`lcpflex.steppers.wedged`.
    """

    def __init__(self, solver: LcpSolver, tolerance: float) -> None:
        self._solver, self._tolerance = as_solver(solver, tolerance), tolerance
        self._at = -1.0  # [s] time of the last problem
        self._times: Counter[int] = Counter()  # how often one of each island came then
        self._wedged = Wedged()
        self._failed: Solution | None = None

    @property
    def solver(self) -> LcpSolver:
        """The solver of the run; one of the user's as an UserSolver with the tolerance of the run."""
        solver: LcpSolver = self._solver
        return solver

    def note(self, solution: Solution) -> None:
        """Keep an answer of a solver in Python that solved nothing, for the words on it."""
        self._failed = solution

    def unsolved(self, work: Workspace, status: int, tolerance: float) -> str:
        """Why the contact problem in ``work`` does not count as solved, with what a solver of the user's says of it.

        Raises SolverError from what that solver raised.
        """
        words = _unsolved(work.impulses.solver, status, tolerance, self._failed)
        own = own_part(self._solver)
        if own is None or own.last is None or not own.last.error:
            return words
        words = f"{words}; {own.name} {own.last.error}"
        if own.last.cause is not None:
            raise SolverError(words) from own.last.cause
        return words

    def __call__(self, work: Workspace, at: float) -> bool:
        """Whether the problem posed in ``work`` at time ``at`` [s] was solved; the solution waits there."""
        if type(self._solver) not in METHODS:
            return False
        if at != self._at:
            self._at = at
            self._times.clear()
        island = int(work.posed.islands.next)
        times = self._times[island]
        self._times[island] += 1
        data, memory = work.posed.problem, work.impulses.solver
        enough = lagging(memory)  # what was found will do where nothing is better
        if times > MOST_RESCUES and not enough:
            return False
        points = [tried_point(memory)]
        if type(self._solver) is Auto and times <= MOST_RESCUES:
            solution = self._attempt(posed_problem(data, memory))
            if solution is not None:
                # what fractions know to be solved, floats may refuse: once they have, it is not told to them again
                whole = guarded_residual(*measured(data, memory, solution.z)[0]) <= self._tolerance
                if whole or (times == 0 and solution.residual <= self._tolerance):
                    if enough and not solution.solved:
                        self._wedged.note_light(data, memory, at)
                    put_solution(data, memory, solution)
                    return True
                points.append(solution.z)
        if enough:
            self._wedged.note_light(data, memory, at)
            put_tried(memory)
            return True
        best = self._wedged.best(data, memory, points, self._tolerance)
        if best is None:
            return False
        self._wedged.note(data, at)
        put_wedged(memory, best)
        return True

    def _attempt(self, problem: Any) -> Solution | None:
        """What the rest of Auto makes of a problem; None where it does not take it."""
        if has_cones(problem):
            return None if self._solver.refuses(problem) else self._solver.solve(problem)
        return self._solver.attempt(problem, None, TRIALS)

    def remarks(self, name: Callable[[int], str]) -> list[str]:
        """The warning of problems that rounding did not let be solved any better; name: of a declared contact."""
        return self._wedged.remarks(name)


def _unsolved(memory: SolverMemory, status: int, tolerance: float, failed: Solution | None) -> str:
    """Why the contact problem does not count as solved; failed: the answer, if a solver in Python gave it."""
    found = Status(status) if status else Status.INACCURATE
    why = found.words
    if failed is not None and failed.status is found and failed.ended is not None:
        why += f" (ended by {failed.ended.words})"
    return (
        f"the contact problem of size {memory.size} was not solved: {why}, "
        f"natural-map residual {memory.residual:.3g} (tolerance {tolerance:g})"
    )
