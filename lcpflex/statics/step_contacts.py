"""The contact problems of a path, one after the other: many contacts begin with the forces of the step before.

Heaps press on each other in more ways than bodies can move, and their problems are hard from no forces at all. From
those of the step before, which is nearly the same, Newton's method on Alart and Curnier's function comes to rounding in
some ten factors.
"""

from __future__ import annotations

import numpy as np

from lcpflex.jit.kernel import FloatArray
from lcpflex.solvers.auto import Auto
from lcpflex.solvers.contact.problem import ContactProblem
from lcpflex.solvers.contact.spatial import SpatialContactProblem
from lcpflex.solvers.contact.starts import forces_at
from lcpflex.solvers.contact.strategy import ALART_CURNIER, NEWTON, Attempt
from lcpflex.solvers.contact.system import ContactSystem
from lcpflex.solvers.contact.user_search import UserSearch, user_attempts
from lcpflex.solvers.problem import Solution, Status
from lcpflex.solvers.user_table import PIVOTED
from lcpflex.statics.balance import Configuration

__all__ = ["StepContacts", "is_many"]

SOLVING = 60.0  # [s] that a contact problem may take
TOLERANCE = 1e-10  # residual of a solution
# The same of few contacts of space: relative to how far bodies would move without them, which little damping makes
# a thousand of their sizes. What slides at its limit, off by 1e-10 of that, bears 1e-6 less than the limit.
FINE = 1e-13
ENOUGH = 1e-6  # residual that a contact problem of space may have: forces are found anew where the path ends
FACTORS = 300  # of Newton's methods that may begin from the step before
FROM_NEAR = (
    Attempt(ALART_CURNIER, 25),
    Attempt(NEWTON, 100, eps=0.1, exact=True),
    Attempt(ALART_CURNIER, 25),
    Attempt(NEWTON, 200, eps=1.0, exact=True),
    Attempt(ALART_CURNIER, 25),
)
"""Attempts of :mod:`lcpflex.solvers.contact.strategy`: nine in ten problems of a heap are solved by the first."""

Keys = list[tuple[int, int]]


def is_many(at: Configuration) -> bool:
    """Whether contacts have more unknowns than pivoting is fast for: their problems are then what a step costs."""
    return at.n_contacts + 2 * (len(at.tangent) // at.d) > PIVOTED


class StepContacts:
    """Solves them. ``known``: multipliers by keys that outlive a step."""

    def __init__(self, known: dict[tuple[int, int], float]) -> None:
        self._before = known
        self._solver = Auto(tolerance=TOLERANCE, budget=SOLVING)
        self._fine_solver = Auto(tolerance=FINE, budget=SOLVING)

    def forces(
        self, at: Configuration, keys: Keys, factor: FloatArray, free: FloatArray, thorough: bool
    ) -> FloatArray | None:
        """(n + m,) of contacts and tangents, named ``keys``, whose operator is factor factor^T.

        None where they are not found; of many contacts in the plane, unless ``thorough``, not near those before.
        """
        before = np.array([self._before.get(key, 0.0) for key in keys])
        if at.d == 1 or not len(at.tangent):
            found = self._in_plane(ContactProblem(factor @ factor.T, free, at.friction), before, thorough)
        else:
            found = self._in_space(at, factor, free, before)
        if found is not None:
            self._before = dict(zip(keys, found.tolist(), strict=True))
        return found

    def _in_plane(self, problem: ContactProblem, before: FloatArray, thorough: bool) -> FloatArray | None:
        if problem.size > PIVOTED:
            near = _from_near(problem, before)
            if near is not None or not thorough:
                return near
        found = self._solver.solve(problem)
        return np.concatenate(problem.forces(found.z)) if found.solved else None

    def _in_space(
        self, at: Configuration, factor: FloatArray, free: FloatArray, before: FloatArray
    ) -> FloatArray | None:
        rows = np.full((at.n_contacts, 3), -1)  # of each contact n, t1 and t2, the latter where it has friction
        rows[:, 0] = np.arange(at.n_contacts)
        rows[at.tangent[::2], 1:] = at.n_contacts + np.arange(len(at.tangent)).reshape(-1, 2)
        order, known = rows.ravel(), rows.ravel() >= 0
        factor, free = np.where(known[:, None], factor[order], 0.0), np.where(known, free[order], 0.0)
        cones = SpatialContactProblem(factor @ factor.T, free, at.friction)
        if cones.size > PIVOTED:
            z = np.where(known, before[order], 0.0)
            guess = Solution(z, np.zeros(len(z)), Status.ITERATION_LIMIT, np.inf, 0, "the step before")
            found = self._solver.solve(cones, guess)
        else:
            found = self._fine_solver.solve(cones)
        if not (found.solved or found.residual <= ENOUGH):
            return None
        forces = np.zeros(at.n_contacts + len(at.tangent))
        forces[order[known]] = cones.forces(found.z).ravel()[known]
        return forces


def _from_near(problem: ContactProblem, forces: FloatArray) -> FloatArray | None:
    """The forces (m,) of a problem by Newton's method from some near to them; None where it does not get there."""
    alike, units, n = problem.balanced(), problem.unknown_units, len(problem.friction)
    start = forces_at(alike, units.inward(problem.unknowns(*np.split(forces, [n]))))
    search = UserSearch(ContactSystem(alike, problem.coupling), TOLERANCE, user_attempts(2, FROM_NEAR))
    reached: list[FloatArray] = []

    def is_good(point: FloatArray) -> bool:
        z = units.outward(alike.unknowns(*np.split(point, [n])))
        if problem.residual(z) <= TOLERANCE:
            reached.append(np.concatenate(problem.forces(z)))
        return True  # neither better ones nor others are looked for

    with np.errstate(all="ignore"):  # what overflows is not finite, and is not taken
        search.run(start, FACTORS, 0, is_good)
    return reached[0] if reached else None
