"""Nonsmooth Gauss-Seidel iteration for Coulomb friction, contact by contact: planar here, in space in :mod:`.cones`.

The law of one contact, with the forces of all others held, is a problem in two unknowns,

    0 <= v_N = a p + b t + r_N  _|_  p >= 0,    v_T = c p + d t + r_T,    t in -mu p Sign(v_T),

solved exactly: open, sticking, or sliding one way or the other. It needs the Delassus matrix G, or its factor J alone:
then u = J^T lambda is kept up to date, a contact costs as much as its bodies have coordinates, and memory is linear in
the contacts. Since the last digits come slowly, the states found are taken as the active set of the whole problem from
time to time, which ends the iteration as soon as they are right.
Sources: Jean 1999 (nonsmooth contact dynamics); Jourdan, Alart & Jean 1998.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from lcpflex.basics import libs
from lcpflex.errors import ModelError
from lcpflex.jit.kernel import FloatArray
from lcpflex.solvers.arguments import check_guess, posed
from lcpflex.solvers.attention import listening
from lcpflex.solvers.clock import grown
from lcpflex.solvers.contact.active_set import free_forces, in_cones, on_active_set, own_blocks
from lcpflex.solvers.contact.looks import SWEPT, by_looks
from lcpflex.solvers.contact.problem import ContactProblem, aligned
from lcpflex.solvers.contact.sweeps import block_gauss_seidel, sweep_blocks, sweep_delassus, sweep_factor
from lcpflex.solvers.guard import guarded
from lcpflex.solvers.lcp.lemke import lemke_workspace
from lcpflex.solvers.limits import keep_settings
from lcpflex.solvers.problem import Lcp, PosedProblem, Solution, accept, restored
from lcpflex.solvers.refusals import has_cones
from lcpflex.solvers.status import ITERATION_LIMIT, Status

__all__ = ["SWEPT", "BlockGaussSeidel"]

PIVOTING = 900  # unknowns up to which the attempt is made with dense matrices
FINISHED = ", finished on its active set"
FAR = 1e3  # residual of a guess from which to start would only be to carry its rounding along


class _Iteration:
    """One run of the iteration: its forces and states, the two ways to sweep and the two ways to finish."""

    def __init__(self, problem: ContactProblem, guess: Solution | None, lcp: Lcp | None) -> None:
        self.problem = problem
        n = len(problem.friction)
        self.tangent_of = np.full(n, -1, dtype=np.int64)
        self.tangent_of[problem.tangent] = n + np.arange(len(problem.tangent))
        self.states = np.zeros(n, dtype=np.int64)
        self.forces = np.zeros(len(problem.free))
        dense = isinstance(problem.delassus, np.ndarray)
        self.lcp = problem.lcp() if lcp is None and dense and problem.size <= PIVOTING else lcp
        self.blocks = problem.coupling if problem.delassus is not None and self.lcp is None else None
        self.dense: Any = problem._data[0] if problem.delassus is not None and self.blocks is None else None
        if lcp is not None:  # without friction: its matrix is the operator, and dense whatever its size
            self.dense = lcp._data[0]
        self.judge: Lcp | ContactProblem = problem if self.lcp is None else self.lcp
        start = None if guess is None else aligned(guess, problem.unknown_keys)
        if start is not None and start.z.shape == (problem.size,):
            z = np.maximum(start.z, 0.0)
            if self.judge.residual(z) <= FAR:
                self.forces = np.concatenate(problem.forces(z))
        if problem.delassus is None:
            J = libs.sparse.csr_array(problem.factor)
            self.J: Any = J
            self.rows = (J.indptr.astype(np.int64), J.indices.astype(np.int64), np.ascontiguousarray(J.data))
            self.block = own_blocks(J, self.tangent_of)
            self.u = np.asarray(J.T @ self.forces)

    def sweep(self, sweeps: int, target: float) -> tuple[int, float]:
        """Up to so many sweeps; how many were made, and the largest change of a velocity in the last one."""
        problem = self.problem
        common = (*problem._data[1:3], self.tangent_of)
        if self.dense is not None:
            return sweep_delassus(self.dense, *common, self.forces, self.states, sweeps, target)
        if self.blocks is not None:
            rows = (self.blocks.first, self.blocks.other, self.blocks.block, self.blocks.own)
            return sweep_blocks(*rows, *common, self.forces, self.states, sweeps, target)
        return sweep_factor(*self.rows, self.block, *common, self.u, self.forces, self.states, sweeps, target)

    @property
    def start(self) -> FloatArray:
        """What is kept if no other point is better."""
        return np.zeros(self.problem.size)

    def points(self) -> Iterator[tuple[FloatArray, str]]:
        """z of the three-unknown form, and the same from the active set, each with what the route says of it."""
        yield self.problem.unknowns(*np.split(self.forces, [len(self.problem.friction)])), ""
        yield self.corrected(), FINISHED

    def corrected(self) -> FloatArray:
        """z from the equations of the states, v_N = 0 where pressed and v_T = 0 where sticking; the shortest change."""
        problem, n = self.problem, len(self.problem.friction)
        if self.dense is None:
            forces = on_active_set(problem, self.states, self.forces)
        else:
            unknown, spread = free_forces(problem, self.states)
            x = self.forces[unknown]
            matrix, free = self.dense[unknown] @ spread, problem.free[unknown]
            for _ in range(2 if len(unknown) else 0):  # the second takes out the rounding of the first
                x = x - np.linalg.lstsq(matrix, matrix @ x + free, rcond=1e-12)[0]
            forces = in_cones(problem, np.asarray(spread @ x))
        return problem.unknowns(*np.split(forces, [n]))


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
        if has_cones(problem):
            from lcpflex.solvers.contact.cones.gauss_seidel import sweep_to_solution

            return sweep_to_solution(problem, guess, self.tolerance, self.sweep_limit)  # type: ignore[arg-type]
        if isinstance(problem, Lcp):
            if reason := self.refuses(problem):
                raise ModelError(reason)
            if problem.balanced()[1] is not None:
                return problem.solve_by(self, guess)
            contacts = ContactProblem(problem.M, problem.q, np.zeros(problem.size))
            return self._iterate(_Iteration(contacts, guess, problem))
        if not isinstance(problem, ContactProblem):
            return posed(problem).solve_by(self, guess)
        keys, units = problem.unknown_keys, problem.unknown_units
        guess = aligned(guess, keys)
        if guess is not None and guess.z.shape == units.d.shape:
            guess = replace(guess, z=units.inward(guess.z))
        found = self._iterate(_Iteration(problem.balanced(), guess, None))
        return replace(restored(problem, found, units, self.tolerance), keys=keys)

    def _iterate(self, run: _Iteration) -> Solution:
        """Compiled where the whole problem is known as an LCP of moderate size, else look by look."""
        if run.lcp is None:
            return guarded(SWEPT, run.problem, self.tolerance, lambda: by_looks(run, self.tolerance, self.sweep_limit))
        lcp = run.lcp
        return guarded(SWEPT, lcp, self.tolerance, lambda: self._compiled(run, lcp))

    def _compiled(self, run: _Iteration, lcp: Lcp) -> Solution:
        problem, n = run.problem, lcp.size
        z, (table, basis) = np.empty(n), lemke_workspace(n)
        basis, ear = listening(basis, n)
        free, friction = problem._data[1:3]
        work, start = np.empty(n), (run.forces.copy(), run.states.copy())

        def swept(most: int) -> tuple[int, int, int]:
            run.forces[:], run.states[:] = start
            return block_gauss_seidel(
                run.dense, free, friction, run.tangent_of, *lcp._data, run.forces, run.states,
                z, work, table, basis, self.tolerance, most,
            )  # fmt: skip

        (code, sweeps, finished), cut = grown(
            swept, self.sweep_limit, n, lambda found: found[0] == ITERATION_LIMIT, ear
        )
        status, active = Status.TIME_LIMIT if cut else Status(code), None
        route = SWEPT + FINISHED * finished
        if status is Status.SOLVED:
            active = basis[:n].copy()
        else:
            with np.errstate(all="ignore"):  # sweeps that ran away overflow: not finite, hence not solved
                corrected = run.corrected()
            if lcp.residual(corrected) < lcp.residual(z):
                z, route = corrected, SWEPT + FINISHED
        return accept(
            lcp, z, tolerance=self.tolerance, status=status, iterations=sweeps, route=route, active=active
        )  # fmt: skip
