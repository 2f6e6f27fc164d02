"""Newton's method for friction in space, begun by sweeps and rescued by proximal points.

Sources: Alart & Curnier 1991; Bonnefon & Daviet 2011; Rockafellar 1976; Acary, Bremond & Huber 2018.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, ClassVar

from lcpflex.errors import ModelError
from lcpflex.jit.kernel import FloatArray
from lcpflex.solvers.acceptance import accept
from lcpflex.solvers.arguments import check_guess
from lcpflex.solvers.clock import expired, grown, out_of_time
from lcpflex.solvers.contact.spatial import SpatialContactProblem
from lcpflex.solvers.contact.starts import own_units, start_of
from lcpflex.solvers.contact.strategy import FEW_FACTORS, SPATIAL_CONTACTS
from lcpflex.solvers.contact.system import MOST_DENSE, ContactSystem, storage_of
from lcpflex.solvers.contact.user_search import UserSearch, user_attempts
from lcpflex.solvers.guard import guarded
from lcpflex.solvers.limits import keep_settings
from lcpflex.solvers.problem import Solution, Status
from lcpflex.solvers.refusals import only_cones

__all__ = ["AlartCurnier"]

NEWTON = "Alart-Curnier"
SWEEPS = 5000  # at most, in all


@dataclass(frozen=True, slots=True)
class AlartCurnier:
    """Newton's method on Alart and Curnier's function, for contacts with friction in space.

    Rows of one table of attempts: some sweeps come first; more of them, and then proximal points, follow where the
    method stalls, as it does where bodies rest on many contacts. Dense operators of up to 64 contacts are solved in
    compiled code, others by sparse factors.

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
        def attempt(limit: int) -> tuple[Solution, bool]:
            system = ContactSystem(problem, storage_of(problem))
            search, found = UserSearch(system, self.tolerance, user_attempts(3, SPATIAL_CONTACTS)), []

            def is_limited() -> bool:
                return limit - search.factors < FEW_FACTORS  # rows begin with no fewer

            def is_good(forces: FloatArray) -> bool:
                status = Status.ITERATION_LIMIT if is_limited() else Status.NUMERICAL_FAILURE
                count = search.factors + search.sweeps
                found.append(accept(problem, forces, tolerance=self.tolerance, status=status, iterations=count))
                return found[-1].solved

            search.run(start, limit, SWEEPS, is_good)
            system.release()
            search.release()
            best = min(found, key=lambda one: one.residual)
            return replace(best, iterations=found[-1].iterations, route=search.route), is_limited()

        if out_of_time():
            return accept(problem, start, tolerance=self.tolerance, status=Status.TIME_LIMIT, route="not begun")
        if len(problem.friction) > MOST_DENSE[3]:
            one = attempt(self.step_limit)[0]
            return expired(one) if out_of_time() else one
        cost = int(problem.size**1.5)  # a step is that of a dense factor; kernels cannot look at a clock
        (one, _), cut = grown(attempt, self.step_limit, cost, lambda found: found[1] and not found[0].solved)
        return expired(one) if cut else one
