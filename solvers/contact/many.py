"""Contact problems of many contacts, by their sparse matrices: who is tried when, within a budget of factors.

Sweeps that look at what they reach; the equations of the states they end in; the convex relaxation, which is right
where nothing slides, as a point to begin from; more sweeps; the proximal Newton method, with sweeps in between. Each
finds active sets that the others do not. The best point of all is kept and judged, whatever it is.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property

import numpy as np

from lcpflex.basics import libs
from lcpflex.errors import LcpflexError
from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.solvers.clock import out_of_time
from lcpflex.solvers.contact.active_set import REGULAR, TINY, on_active_set, states_of
from lcpflex.solvers.contact.looks import SWEPT, Pace, by_looks
from lcpflex.solvers.contact.problem import ContactProblem
from lcpflex.solvers.contact.starts import forces_at, start_of
from lcpflex.solvers.contact.system import ContactSystem
from lcpflex.solvers.contact.user_search import UserSearch
from lcpflex.solvers.guard import ENDED, FAILED, words_of
from lcpflex.solvers.problem import Solution, Status, accept

__all__ = ["Search"]

FINISHED, CONVEX, NEWTON = "finished on its active set", "convex start", "proximal Newton"
STEPS = {"swept": SWEPT, "swept_on": SWEPT, "finished": FINISHED, "relaxed": CONVEX, "newton": NEWTON}
BETWEEN = (20, Pace(2, 16))  # sweeps between two runs of Newton's method
# Sweeps at most; and so many of them that leave more of the residual than that fraction are the last.
FEW, MORE, MANY = (200, Pace(2, 16, 24, 0.4)), (500, Pace(2, 16, 128, 0.8)), (2000, Pace(2, 16, 128, 0.8))
SWEEPS = 2000  # between runs of Newton's method, at most
CONVEX_FACTORS = 25  # what the relaxation counts for
SYMMETRY = 1e-10  # relative to the largest entry


class Search:
    """One problem, its best forces so far (in units of the contacts), and what was tried.

    problem: the contacts. guess: the solution of a problem with the same unknowns, or None. tolerance: of the residual.
    factors: how many sparse factors may be made.
    """

    def __init__(self, problem: ContactProblem, guess: Solution | None, tolerance: float, factors: int) -> None:
        self.problem, self.tolerance, self.budget = problem, tolerance, factors
        self.factors, self.sweeps, self.route = 0, 0, ""
        self.errors: list[str] = []
        n, m = len(problem.friction), len(problem.free)
        self.forces, self.states = np.zeros(m), np.zeros(n, dtype=np.int64)
        self.best, self.least = np.zeros(m), np.inf
        if guess is not None:
            start = problem.unknown_units.inward(start_of(problem, guess, problem.residual))
            self.forces = forces_at(problem.balanced(), start)

    @property
    def done(self) -> bool:
        """Whether the best point is within the tolerance."""
        return self.least <= self.tolerance

    @property
    def spent(self) -> bool:
        """Whether no factor, or no time, is left."""
        return self.factors >= self.budget or out_of_time()

    def run(self, *steps: Callable[[], str]) -> bool:
        """One step after the other until the problem is solved or the time is up; whether it is solved."""
        for step in steps:
            if self.done or out_of_time():
                break
            before, name = self.route, self._guarded(step)
            if name:
                self.route = f"{before} > {name}".removeprefix(" > ") + ("" if self.done else FAILED)
        return self.done

    def _guarded(self, step: Callable[[], str]) -> str:
        """What the step is called; what it raises, of numpy, scipy or Clarabel, is kept for the message."""
        try:
            with np.errstate(all="ignore"):  # what runs away overflows: not finite, and hence not solved
                return step()
        except (LcpflexError, KeyboardInterrupt, SystemExit):
            raise
        except BaseException as error:  # a panic in Rust is no Exception
            name = STEPS[step.__name__]
            self.errors.append(f"{name} {ENDED} {words_of(error)}")
            return name

    def solution(self) -> Solution:
        """The best point, judged on the problem."""
        status = Status.TIME_LIMIT if out_of_time() else Status.ITERATION_LIMIT
        message = "" if self.done or not self.errors else f"numerical failure: {'; '.join(self.errors[:2])}"
        return accept(
            self.problem,
            self._unknowns(self.best),
            tolerance=self.tolerance,
            status=status,
            iterations=self.sweeps + self.factors,
            route=self.route,
            message=message,
            active=self._basis(),
        )

    @cached_property
    def system(self) -> ContactSystem:
        """The contacts by their blocks, or where nearly all of them touch one body, through the factor."""
        return ContactSystem(self.problem.balanced(), self.problem.coupling)

    def _basis(self) -> IntArray | None:
        """Which unknowns the states leave free to be positive, where the best point solves the problem."""
        if not self.done:
            return None
        self.system.take(self.best)
        self.system.group.state[:] = self.states
        return self.system.point()[1]

    def swept(self) -> str:
        """A few sweeps, as long as they pay."""
        self._sweep(*FEW)
        return SWEPT

    def swept_on(self) -> str:
        """Many sweeps from the best point; in between and at the end, the equations of the states that they came to."""
        for sweeps in (MORE, MANY):
            self.forces = self.best.copy()
            self._sweep(*sweeps)
            if not self.done and self.finished():
                return f"{SWEPT} > {FINISHED}"
            if self.done:
                break
        return SWEPT

    def finished(self) -> str:
        """The equations of the states of the best point, with little, then next to nothing, added to them."""
        alike, states = self.problem.balanced(), self._states()
        for least in (REGULAR, TINY):
            if self.spent or self.done:
                break
            self.factors += 1
            with np.errstate(all="ignore"):
                forces = on_active_set(alike, states, self.best, least)
            if np.isfinite(forces).all():
                self._keep(forces)
            if self.done:
                self.states = states
        return FINISHED if self.done else ""

    def relaxed(self) -> str:
        """Forces of the convex relaxation, and sweeps from there: right where contacts stick."""
        if self.spent or not self._symmetric():
            return ""
        self.factors += CONVEX_FACTORS
        from lcpflex.solvers.contact.cone import relaxed_forces  # which knows the conic programs

        forces = relaxed_forces(self.problem.balanced())
        if forces is not None:
            self.forces = forces
            self._sweep(*BETWEEN)
        return CONVEX

    def newton(self) -> str:
        """The attempts of the table, from the best point: runs of Newton's method, sweeps in between, and paths."""
        search = UserSearch(self.system, self.tolerance)
        try:
            search.run(self.best, self.budget - self.factors, SWEEPS, self._is_good)
        finally:
            self.factors += search.factors
            self.sweeps += search.sweeps
        if self.done:
            self.states = self._states()
        else:
            self.finished()
        return NEWTON

    def _states(self) -> IntArray:
        """In which states the best point puts the contacts."""
        alike = self.problem.balanced()
        return states_of(alike, self.best, alike.velocity(self.best))

    def _symmetric(self) -> bool:
        """Whether the operator is, as the relaxation needs it."""
        if self.problem.delassus is None:
            return True
        matrix = libs.sparse.csr_array(self.problem.balanced()._data[0])
        largest = abs(matrix).max() if matrix.nnz else 0.0
        return bool(abs(matrix - matrix.T).max() <= SYMMETRY * largest)

    def _unknowns(self, forces: FloatArray) -> FloatArray:
        """z of the problem for forces in units of the contacts."""
        alike = self.problem.balanced()
        z = self.problem.unknown_units.outward(alike.unknowns(*np.split(forces, [len(alike.friction)])))
        return z if np.isfinite(z).all() else np.zeros(len(z))  # beyond what floats hold in the units of the user

    def _keep(self, forces: FloatArray) -> float:
        """Judge forces, and keep them if they are the best ones so far; their residual."""
        residual = self.problem.residuals(self._unknowns(forces))[0]
        if residual < self.least:
            self.best, self.least = forces.copy(), residual
        return residual

    def _is_good(self, forces: FloatArray) -> bool:
        """Keep forces, and tell whether they solve the problem."""
        self._keep(forces)
        return self.done

    def _sweep(self, sweeps: int, pace: Pace) -> None:
        """Sweep from ``forces`` on, and keep the best point."""
        self.system.take(self.forces)
        found = by_looks(self.system, self.problem.balanced().residual, self.tolerance, sweeps, pace)
        self.sweeps += found.sweeps
        self.forces = self.system.forces
        if found.residual < self.least:
            self.best, self.least, self.states = found.forces, found.residual, found.states
