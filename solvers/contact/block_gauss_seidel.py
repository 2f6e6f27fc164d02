"""Nonsmooth Gauss-Seidel iteration for Coulomb friction, contact by contact, in the plane and in space.

The law of one contact, with the forces of all others held, is solved exactly (:mod:`lcpflex.solvers.contact.laws`):
:func:`lcpflex.solvers.contact.sweeping.sweep`. It needs the Delassus matrix G, or its factor J alone: then
u = J^T lambda is kept up to date, a contact costs as much as its bodies have coordinates, and memory is linear in the
contacts. Since the last digits come slowly, in the plane the states found are taken as the active set of the whole
problem from time to time, which ends the iteration as soon as they are right.
Sources: Jean 1999 (nonsmooth contact dynamics); Jourdan, Alart & Jean 1998; Bonnefon & Daviet 2011 (the exact solution
of one contact in space).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from lcpflex.errors import ModelError
from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.solvers.acceptance import accept
from lcpflex.solvers.arguments import check_guess, posed
from lcpflex.solvers.attention import Ear, listening
from lcpflex.solvers.contact.active_set import free_forces, in_cones, on_active_set
from lcpflex.solvers.contact.looks import SWEPT, Finish, by_looks
from lcpflex.solvers.contact.problem import ContactProblem
from lcpflex.solvers.contact.starts import forces_at, start_of
from lcpflex.solvers.contact.system import ContactSystem, storage_of
from lcpflex.solvers.guard import guarded
from lcpflex.solvers.lcp.lemke import lemke_workspace
from lcpflex.solvers.lcp.pivoting import block_pivots
from lcpflex.solvers.limits import keep_settings
from lcpflex.solvers.problem import Lcp, PosedProblem, Solution
from lcpflex.solvers.refusals import has_cones

__all__ = ["SWEPT", "BlockGaussSeidel", "ByPivots"]

EXCHANGES = 5  # of the active set in one attempt to finish
FINISHED = ", finished on its active set"


class ByPivots:
    """Finishes planar contacts on their active set, a few wrong signs exchanged: by elimination of the dense LCP."""

    def __init__(self, problem: ContactProblem, lcp: Lcp | None) -> None:
        self.problem, self.lcp = problem, lcp
        self.table, self.basis = np.empty((0, 0)), np.empty(0, dtype=np.int64)
        self.ear: Ear | None = None

    def __call__(self, z: FloatArray, active: IntArray | None) -> tuple[FloatArray, IntArray | None]:
        n = len(z)
        if self.lcp is None:
            self.lcp = self.problem.lcp()
        if not len(self.table):
            self.table, basis = lemke_workspace(n)
            self.basis, self.ear = listening(basis, n)
        lcp, point = self.lcp, np.empty(n)

        def exchange() -> int:
            point[:], self.basis[:n] = z, 0 if active is None else active
            return block_pivots(*lcp._data, n, point, self.table, self.basis, EXCHANGES)[0]

        solves = exchange() if self.ear is None else self.ear(exchange)
        return (point, self.basis[:n].copy()) if solves > 0 else (z, active)


class _Corrected:
    """Finishes planar contacts by the equations of their states, v_N = 0 where pressed and v_T = 0 where sticking.

    The shortest change of the forces.
    """

    def __init__(self, system: ContactSystem, dense: FloatArray | None) -> None:
        self.system, self.dense = system, dense

    def __call__(self, z: FloatArray, active: IntArray | None) -> tuple[FloatArray, IntArray | None]:
        problem, forces, states = self.system.problem, self.system.forces, self.system.group.state
        with np.errstate(all="ignore"):  # sweeps that ran away overflow: not finite, hence not solved
            if self.dense is None:
                forces = on_active_set(problem, states, forces)
            else:
                unknown, spread = free_forces(problem, states)
                x = forces[unknown]
                matrix, free = self.dense[unknown] @ spread, problem.free[unknown]
                for _ in range(2 if len(unknown) else 0):  # the second takes out the rounding of the first
                    x = x - np.linalg.lstsq(matrix, matrix @ x + free, rcond=1e-12)[0]
                forces = in_cones(problem, np.asarray(spread @ x))
            return problem.unknowns(*np.split(forces, [len(problem.friction)])), None


@dataclass(frozen=True, slots=True)
class BlockGaussSeidel:
    """Gauss-Seidel iteration contact by contact, for many contacts with friction.

    tolerance: largest accepted residual [-]; sweep_limit: largest number of sweeps. Takes a :class:`ContactProblem` or
    :class:`SpatialContactProblem`, with the Delassus matrix or only its factor, and an :class:`Lcp` that is symmetric,
    as contact without friction.
    Raises ModelError for numbers out of their range and for other problems. Converges in practice, without a guarantee.
    """

    tolerance: float = 1e-10
    sweep_limit: int = 20_000

    def __post_init__(self) -> None:
        keep_settings(self, "sweep_limit", needed=True)

    def refuses(self, problem: Lcp | PosedProblem) -> str:
        """Why the solver cannot take the problem; empty if it can."""
        if (
            isinstance(problem, ContactProblem)
            or has_cones(problem)
            or (problem if isinstance(problem, Lcp) else posed(problem).lcp()).symmetric
        ):
            return ""
        return (
            "an unsymmetric matrix does not tell which unknowns are one contact: expected a ContactProblem, or Lemke() "
            "or Auto() as the solver"
        )

    def solve(self, problem: Lcp | PosedProblem, guess: Solution | None = None) -> Solution:
        """Iterate, from the forces of the guess if there is one (matched by contact).

        problem: a :class:`ContactProblem`, in space a :class:`SpatialContactProblem`. guess: the solution of a similar
        problem to start from, or None.
        """
        check_guess(guess)
        if isinstance(problem, Lcp):
            if reason := self.refuses(problem):
                raise ModelError(reason)
            if problem.balanced()[1] is not None:
                return problem.solve_by(self, guess)
            smooth = ContactProblem(problem.M, problem.q, np.zeros(problem.size))
            start = start_of(smooth, guess, problem.residual)
            return guarded(SWEPT, problem, self.tolerance, lambda: self._swept(smooth, start, problem))
        if not isinstance(problem, ContactProblem) and not has_cones(problem):
            return posed(problem).solve_by(self, guess)
        contacts: Any = problem
        found = guarded(SWEPT, contacts, self.tolerance, lambda: self._in_units(contacts, guess))
        return replace(found, keys=contacts.unknown_keys)

    def _in_units(self, problem: Any, guess: Solution | None) -> Solution:
        """Sweeps on contacts in the plane or in space, each measured by its own diagonal."""
        if not has_cones(problem) and problem.delassus is not None:
            _ = problem.coupling  # by which it is judged, as it is and in units: made once
        units = problem.unknown_units
        start = units.inward(start_of(problem, guess, problem.residual))
        return self._swept(problem.balanced(), start, problem, units.outward)

    def _swept(
        self, contacts: Any, start: FloatArray, judged: Any, outward: Callable[[FloatArray], FloatArray] = np.asarray
    ) -> Solution:
        """Sweeps and looks from the point ``start`` on; outward: a point of the contacts as one of the problem judged.

        In the plane looks are finished on the active set, where that tells more than sweeps to come.
        """
        lcp = judged if isinstance(judged, Lcp) else None
        storage = storage_of(contacts) if lcp is None else lcp._data[0]
        system = ContactSystem(contacts, storage)
        system.take(forces_at(contacts, start))
        dense = storage if isinstance(storage, np.ndarray) else None
        finish: Finish | None = None if has_cones(contacts) else _Corrected(system, dense)
        if dense is not None and finish is not None:
            finish = ByPivots(contacts, lcp)
        residual = contacts.residual if lcp is None else lcp.residual
        found = by_looks(system, residual, self.tolerance, self.sweep_limit, finish=finish)
        if isinstance(finish, ByPivots) and found.residual > self.tolerance:
            corrected, _ = _Corrected(system, dense)(found.z, None)
            if residual(corrected) < found.residual:
                found.z, found.active = corrected, None
        system.release()
        solved = found.residual <= self.tolerance
        return accept(
            judged, outward(found.z), tolerance=self.tolerance, status=found.status, iterations=found.sweeps,
            route=SWEPT + FINISHED * (solved and found.finished), active=found.active if solved else None,
        )  # fmt: skip
