"""Contact problems of many contacts, by their sparse matrices: who is tried when, within a budget of factors.

Sweeps that look at what they reach; the equations of the states they end in; the convex relaxation, which is right
where nothing slides, as a point to begin from; more sweeps; the proximal Newton method, with sweeps in between. Each
finds active sets that the others do not. The best point of all is kept and judged, whatever it is.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from lcpflex.basics import libs
from lcpflex.errors import LcpflexError
from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.solvers.clock import out_of_time
from lcpflex.solvers.contact.active_set import REGULAR, TINY, on_active_set, own_blocks, states_of
from lcpflex.solvers.contact.coupling import tangents
from lcpflex.solvers.contact.problem import ContactProblem
from lcpflex.solvers.contact.proximal import Proximal
from lcpflex.solvers.contact.settling import point_of_forces, settle
from lcpflex.solvers.contact.sweeps import sweep_factor, take_basis
from lcpflex.solvers.guard import ENDED, FAILED, words_of
from lcpflex.solvers.problem import Solution, Status, accept

__all__ = ["FACTORS", "Search"]

FACTORS = 600  # sparse factors that one problem may take, unless the user says otherwise
SWEPT, FINISHED, CONVEX, NEWTON = "block Gauss-Seidel", "finished on its active set", "convex start", "proximal Newton"
STEPS = {"swept": SWEPT, "swept_on": SWEPT, "finished": FINISHED, "relaxed": CONVEX, "newton": NEWTON}
BETWEEN, LOOK = 20, 16  # sweeps between two runs of Newton's method, and at a time
# Sweeps at most; and so many of them that leave more of the residual than that fraction are the last.
FEW, MORE, MANY = (200, 24, 0.4), (500, 128, 0.8), (2000, 128, 0.8)
ROUNDS = ((0.1, 150), (0.01, 60), (1e-3, 150), (0.1, 240))  # eps to begin with, and factors, of each run
CONVEX_FACTORS = 25  # what the relaxation counts for
FAR = 1e3  # residual of a guess from which to start would only be to carry its rounding along
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
        if guess is not None and guess.z.shape == (problem.size,):
            z = np.maximum(guess.z, 0.0)
            if problem.residuals(z)[0] <= FAR:
                self.forces = np.concatenate(problem.forces(z)) / problem.unknown_units.load / problem.row_units

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

    def _basis(self) -> IntArray | None:
        """Which unknowns the states leave free to be positive, where the best point solves the problem."""
        c = self.problem.coupling
        if not self.done or c is None:
            return None
        z, basis = np.empty(self.problem.size), np.empty(self.problem.size, dtype=np.int64)
        point_of_forces(c.first, c.other, c.block, c.free, c.friction, c.tangent_of, self.best, z)
        take_basis(self.states, c.tangent_of, len(c.free), z, basis)
        return basis

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
            self._sweep(BETWEEN)
        return CONVEX

    def newton(self) -> str:
        """Runs of the proximal Newton method from the best point, sweeps in between."""
        method = Proximal(self.problem.balanced(), self._keep)
        for eps, factors in ROUNDS:
            if self.spent:
                break
            self.factors += method.run(self.best, eps, min(factors, self.budget - self.factors), self.tolerance)
            if self.done:
                self.states = self._states()
            if self.done or self.finished():
                break
            self.forces = self.best.copy()
            self._sweep(BETWEEN)
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
        problem, c = self.problem, self.problem.coupling
        if c is not None:
            z = np.empty(problem.size)
            point_of_forces(c.first, c.other, c.block, c.free, c.friction, c.tangent_of, forces, z)
            z = problem.unknown_units.outward(z)
        else:
            own = forces * problem.row_units * problem.unknown_units.load
            z = problem.unknowns(*np.split(own, [len(problem.friction)]))
        return z if np.isfinite(z).all() else np.zeros(len(z))  # beyond what floats hold in the units of the user

    def _keep(self, forces: FloatArray) -> float:
        """Judge forces, and keep them if they are the best ones so far; their residual."""
        residual = self.problem.residuals(self._unknowns(forces))[0]
        if residual < self.least:
            self.best, self.least = forces.copy(), residual
        return residual

    def _sweep(self, sweeps: int, patience: int = 2**40, crawling: float = 1.0) -> None:
        """Sweep from ``forces`` on, and keep the best point."""
        c = self.problem.coupling
        if c is None:
            self._sweep_bodies(sweeps)
            return
        rows = (c.first, c.other, c.block, c.own, c.free, c.friction, c.tangent_of)
        z, best = np.empty(self.problem.size), np.empty(len(c.free))
        made, least = settle(*rows, self.forces, self.states, z, best, self.tolerance, sweeps, patience, crawling)
        self.sweeps += made
        if least < self.least:
            self.best, self.least = best, least
            if not made:  # no sweep has told the states of the forces that it began from
                self.states = self._states()

    def _sweep_bodies(self, sweeps: int) -> None:
        """The same through the factor, where nearly all contacts touch one body."""
        alike = self.problem.balanced()
        J = libs.sparse.csr_array(alike._data[3])
        tangent_of = tangents(alike.friction)
        rows = (J.indptr.astype(np.int64), J.indices.astype(np.int64), J.data, own_blocks(J, tangent_of))
        u, made = np.asarray(J.T @ self.forces), 0
        self._keep(self.forces)
        while made < sweeps and not self.done and not out_of_time():
            _, free, friction, _ = alike._data
            count, change = sweep_factor(*rows, free, friction, tangent_of, u, self.forces, self.states, LOOK, 0.0)
            made += count
            self.sweeps += count
            if not change < np.inf:
                break
            self._keep(self.forces)
