"""Coulomb friction in space as a sequence of convex programs: the fixed point of Acary and Cadoux.

Given slips s_k, the forces of min 1/2 r.G r + (free + mu s n).r over the cones obey K ∋ r _|_ u + mu s n ∈ K*; where
they give s_k = |u_Tk|, this is Coulomb's law. So s <- |u_T|, from s = 0: mostly a contraction, without a guarantee.
Source: Acary, Cadoux, Lemarechal & Malick 2011 (a formulation of the linear discrete Coulomb friction problem via
convex optimization).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from lcpflex.errors import ModelError
from lcpflex.jit.kernel import FloatArray
from lcpflex.solvers.arguments import check_guess
from lcpflex.solvers.clock import out_of_time
from lcpflex.solvers.contact.clarabel import SUCCESS
from lcpflex.solvers.contact.cones.conic import ConicProgram
from lcpflex.solvers.contact.spatial import SpatialContactProblem
from lcpflex.solvers.contact.starts import started
from lcpflex.solvers.guard import guarded
from lcpflex.solvers.limits import keep_settings
from lcpflex.solvers.problem import Lcp, PosedProblem, Solution, Status, accept, restored
from lcpflex.solvers.refusals import only_cones

__all__ = ["ConicFixedPoint"]

ROUTE = "conic fixed point"
NEAR = 1e-2  # residual from which a program is near enough to the last one for Newton steps alone
ROUNDED = 1e-13  # what they may leave of the natural map, relative to the load
STALLED = 10  # passes without a better point that end the iteration
BETTER = 0.9  # of the least residual


@dataclass(frozen=True, slots=True)
class ConicFixedPoint:
    """Contact in space by a sequence of convex programs (Clarabel): slow, and independent of all other solvers.

    tolerance: largest accepted residual [-]; pass_limit: largest number of programs. Takes a
    :class:`SpatialContactProblem`, with the Delassus matrix or only its factor. Converges in practice, without a
    guarantee; where the slip of many contacts depends on that of others, or friction is large, it may not. Beyond 400
    contacts the last digits of its programs are Clarabel's, and it ends at 1e-8 to 1e-9. Raises ModelError for numbers
    out of their range and for other problems.
    """

    tolerance: float = 1e-10
    pass_limit: int = 300
    only_cones: ClassVar[bool] = True

    def __post_init__(self) -> None:
        keep_settings(self, "pass_limit", needed=True)

    def refuses(self, problem: Lcp | PosedProblem) -> str:
        """Why the solver cannot take the problem; empty if it can."""
        return only_cones(self, problem)

    def solve(self, problem: Lcp | PosedProblem, guess: Solution | None = None) -> Solution:
        """Iterate, from the slips of the guess if there is one (matched by contact).

        problem: a :class:`SpatialContactProblem`. guess: the solution of a similar problem to start from, or None.
        """
        check_guess(guess)
        if not isinstance(problem, SpatialContactProblem):
            raise ModelError(self.refuses(problem))
        units, alike = problem.unknown_units, problem.balanced()
        start = started(guess, problem.unknown_keys)
        start = None if start is None else units.inward(start)
        with np.errstate(all="ignore"):  # what overflows is not finite, and is not called solved
            found = guarded(ROUTE, alike, self.tolerance, lambda: self._iterate(alike, start))
        return replace(restored(problem, found, units, self.tolerance), keys=problem.unknown_keys)

    def _iterate(self, problem: SpatialContactProblem, start: FloatArray | None) -> Solution:
        """Programs, each with the slips of the last one. problem: balanced; start (3 k,): forces, or None."""
        best = np.zeros(problem.size)
        least = problem.residual(best)
        if least <= self.tolerance:
            return accept(problem, best, tolerance=self.tolerance, route="free velocities")
        program = ConicProgram.of(problem)
        forces = best if start is None else start
        slip = np.zeros(len(problem.friction)) if start is None else _slip(problem, start)
        said, status, done, stalled = "", Status.ITERATION_LIMIT, 0, 0
        while done < self.pass_limit and least > self.tolerance:
            forces, said = _pass(program, program.load(slip, forces), forces, warm=least < NEAR)
            done += 1
            if not np.isfinite(forces).all():
                status = Status.NUMERICAL_FAILURE
                break
            residual = problem.residual(forces)
            stalled = 0 if residual < BETTER * least else stalled + 1
            if residual < least:
                best, least = forces, residual
            if stalled > STALLED or out_of_time():
                status = Status.TIME_LIMIT if out_of_time() else Status.NUMERICAL_FAILURE
                break
            slip = _slip(problem, forces)
        message = "" if least <= self.tolerance or said in SUCCESS else f"numerical failure: Clarabel: {said}"
        return accept(
            problem,
            best,
            tolerance=self.tolerance,
            status=status,
            iterations=done,
            route=ROUTE,
            message=message,
        )


def _pass(program: ConicProgram, load: FloatArray, forces: FloatArray, warm: bool) -> tuple[FloatArray, str]:
    """The solution of one program, and what Clarabel says.

    warm: whether forces are near enough for Newton steps alone to find it.
    """
    if warm:
        near, left = program.polished(load, forces)
        if left <= ROUNDED * float(np.abs(load).max(initial=0.0)):
            return near, SUCCESS[0]
    forces, _, said = program.solve(load)
    return program.polished(load, forces)[0], said


def _slip(problem: SpatialContactProblem, forces: FloatArray) -> FloatArray:
    """|u_T| (k,) of each contact."""
    u = problem.velocity(forces)
    return np.hypot(u[1::3], u[2::3])
