"""Newton's method for friction in space, begun by sweeps and rescued by proximal points.

Sources: Alart & Curnier 1991; Bonnefon & Daviet 2011; Rockafellar 1976; Acary, Bremond & Huber 2018.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar

from lcpflex.errors import ModelError
from lcpflex.jit.kernel import FloatArray
from lcpflex.solvers.arguments import check_guess
from lcpflex.solvers.clock import grown, out_of_time
from lcpflex.solvers.contact.looks import SWEPT
from lcpflex.solvers.contact.spatial import SpatialContactProblem
from lcpflex.solvers.contact.starts import own_units, start_of
from lcpflex.solvers.contact.system import MOST_DENSE, ContactSystem, storage_of
from lcpflex.solvers.contact.user_search import UserSearch
from lcpflex.solvers.guard import guarded
from lcpflex.solvers.limits import keep_settings
from lcpflex.solvers.problem import Solution, Status, accept
from lcpflex.solvers.refusals import only_cones

__all__ = ["AlartCurnier"]

NEWTON = "Alart-Curnier Newton"
RESCUED = "proximal points"
STAGES = ((30, 20), (200, 40), (1000, 60))  # sweeps, and how many Newton steps are tried then
CLOSE = 1e-2  # change of a sweep relative to the tolerance at which sweeps end
SWEEPS = 5000  # between runs of the proximal Newton method, at most


@dataclass(frozen=True, slots=True)
class AlartCurnier:
    """Newton's method on Alart and Curnier's function, for contacts with friction in space.

    Begins with some sweeps of block Gauss-Seidel; more of them, and then proximal points, follow where Newton's method
    stalls, as it does where bodies rest on many contacts. Dense operators of up to 64 contacts are solved in compiled
    code, others by sparse factors.

    Attributes
    ----------
    tolerance
        Largest accepted residual [-].
    step_limit
        Largest number of linear systems solved, proximal points included.

    Raises
    ------
    ModelError
        For numbers out of their range and, in :meth:`solve`, for anything but a :class:`SpatialContactProblem`.
    """

    tolerance: float = 1e-10
    step_limit: int = 5000
    only_cones: ClassVar[bool] = True

    def __post_init__(self) -> None:
        keep_settings(self, "step_limit", needed=True)

    def refuses(self, problem: Any) -> str:
        """Why the solver cannot take the problem; empty if it can."""
        if reason := only_cones(self, problem):
            return reason
        if problem.matrix() is None:
            return (
                "AlartCurnier needs the Delassus operator, which is too large here to be multiplied out of its factor: "
                "expected fewer contacts a body, or BlockGaussSeidel() as the solver"
            )
        return ""

    def solve(self, problem: SpatialContactProblem, guess: Solution | None = None) -> Solution:
        """The certified solution, or the best point found with its status.

        problem: contacts in space. guess: the solution of a similar problem to start from, matched by contact, or None.
        """
        check_guess(guess)
        if reason := self.refuses(problem):
            raise ModelError(reason)
        alike = problem.balanced()
        start = problem.unknown_units.inward(start_of(problem, guess, problem.residual))
        found = guarded(NEWTON, alike, self.tolerance, lambda: self._solved(alike, start))
        return own_units(problem, found, self.tolerance)

    def _solved(self, problem: SpatialContactProblem, start: FloatArray) -> Solution:
        def attempt(limit: int) -> _Attempt:
            one = _Attempt(problem, start, self.tolerance, limit)
            one.go()
            one.release()
            return one

        if len(problem.friction) <= MOST_DENSE[3]:  # kernels cannot look at a clock
            cost = int(problem.size**1.5)  # a step is that of a dense factor
            one, cut = grown(attempt, self.step_limit, cost, lambda one: one.residual > self.tolerance)
        else:
            one, cut = attempt(self.step_limit), out_of_time()
        status = Status.TIME_LIMIT if cut else Status.ITERATION_LIMIT if one.limited else Status.NUMERICAL_FAILURE
        return accept(
            problem, one.best, tolerance=self.tolerance, status=status, iterations=one.sweeps + one.steps,
            route=one.route,
        )  # fmt: skip


class _Attempt:
    """Sweeps and Newton's method by turns, then proximal points; ``best`` is the best point so far."""

    def __init__(self, problem: SpatialContactProblem, start: FloatArray, tolerance: float, limit: int) -> None:
        self.problem, self.tolerance, self.limit = problem, tolerance, limit
        self.best, self.residual, self.start = start.copy(), problem.residual(start), start
        self.sweeps = self.steps = 0
        self.route = "guess" if start.any() else "no forces"

    @property
    def limited(self) -> bool:
        """Whether the limit of linear systems was reached."""
        return self.steps >= self.limit

    def go(self) -> None:
        """Until the residual is within the tolerance, the limit is reached, or nothing helps."""
        for sweeps, steps in STAGES:
            if self._done():
                return
            self._sweep(sweeps)
            if self._done():
                return
            swept = self.system.forces
            forces = self.search.alart_curnier(swept, min(steps, self.limit - self.steps))
            self.steps = self.search.factors
            self._look(forces, f"{SWEPT}, {NEWTON}")
            self.system.take(swept)
        if not self._done():
            self.search.run(self.best, self.limit - self.steps, SWEEPS, self._is_good)
            self.steps = self.search.factors
            self.sweeps += self.search.sweeps

    @cached_property
    def system(self) -> ContactSystem:
        """The contacts, and the forces that sweeps have come to."""
        system = ContactSystem(self.problem, storage_of(self.problem))
        system.take(self.start)
        return system

    @cached_property
    def search(self) -> UserSearch:
        """Newton's methods on the contacts."""
        return UserSearch(self.system, self.tolerance)

    def release(self) -> None:
        """Leave its memory to the next problem."""
        for kept in ("system", "search"):
            if kept in vars(self):
                getattr(self, kept).release()

    def _is_good(self, forces: FloatArray) -> bool:
        self._look(forces, f"{SWEPT}, {NEWTON}, {RESCUED}")
        return self.residual <= self.tolerance

    def _done(self) -> bool:
        return self.residual <= self.tolerance or self.limited or out_of_time()

    def _sweep(self, sweeps: int) -> None:
        made, _ = self.system.sweep(sweeps, CLOSE * self.tolerance)
        self.sweeps += made
        self._look(self.system.forces, SWEPT)

    def _look(self, forces: FloatArray, route: str) -> None:
        """Keep the forces if they are better than all before; the route is told as far as it went."""
        residual = self.problem.residual(forces)
        self.route = route
        if residual < self.residual:
            self.best, self.residual = forces.copy(), residual
