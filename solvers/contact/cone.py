"""The convex relaxation of Coulomb friction, by Clarabel's second-order cones. It is another model.

With v = G lambda + free and the cones K: |lambda_T| <= mu lambda_N and K*: v_N >= mu |v_T| of each contact,

    min 1/2 lambda.G lambda + free.lambda  subject to lambda in K    <=>    K ∋ lambda  _|_  v ∈ K*

(an associated law, of maximal dissipation in the normal direction too: Anitescu 2006). It is convex, and so solved in
polynomial time, but a contact that slides is lifted: v_N = mu |v_T|, where Coulomb's law has v_N = 0. Contacts that
stick, and those without friction, obey Coulomb's law. What is found here must not be taken for a solution of
:meth:`ContactProblem.lcp`; how far it is from one, :meth:`ConvexContactProblem.lift` says.

Where only a factor J of G = J J^T is known, the dual program min 1/2 |y|^2 with J y + free in K* is solved, which never
forms G; lambda is its multiplier.
"""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from lcpflex.basics import libs
from lcpflex.errors import ModelError
from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.solvers.acceptance import accept
from lcpflex.solvers.arguments import check_guess
from lcpflex.solvers.clock import out_of_time
from lcpflex.solvers.contact.cones.conic import (
    SHORT_STEP,
    STEP,
    SUCCESS,
    RelaxedSpatialProblem,
    conic_program,
    relaxed_solution,
)
from lcpflex.solvers.contact.matrices import as_dense, is_sparse
from lcpflex.solvers.contact.problem import ContactProblem
from lcpflex.solvers.contact.relaxation import ConvexContactProblem
from lcpflex.solvers.contact.spatial import SpatialContactProblem
from lcpflex.solvers.guard import guarded
from lcpflex.solvers.lcp.polishing import equilibrium, polish
from lcpflex.solvers.lcp.proofs import infeasibility
from lcpflex.solvers.limits import keep_settings
from lcpflex.solvers.problem import Lcp, PosedProblem, Solution, Status

__all__ = ["ConvexFriction", "relaxed_forces"]

LARGEST = 2000  # force components beyond which the dense matrix that polishing needs is not formed
UNSYMMETRIC = "delassus is unsymmetric, and no convex program has its solutions; expected a symmetric one"
UNBOUNDED = "the relaxation has no solution: forces in the cones press contacts together without bound"
POLISHING = 5  # corrections of which edges carry force


@dataclass(frozen=True, slots=True)
class ConvexFriction:
    """The convex relaxation of Coulomb friction: another model, which lifts contacts that slide.

    Solves :class:`ConvexContactProblem`; the z of its solutions holds the forces [lambda_N (n_N), lambda_T (n_H)] and w
    the velocities, not the unknowns of :meth:`ContactProblem.lcp`; in space the forces as they are of a
    :class:`SpatialContactProblem`. SOLVED means solved in that model; route and message say so. tolerance: largest
    accepted residual of that model [-]. Raises ModelError, in :meth:`solve`, for anything that is no contact problem.
    """

    tolerance: float = 1e-10
    model: ClassVar[str] = "convex relaxation"

    def __post_init__(self) -> None:
        keep_settings(self)

    def refuses(self, problem: Lcp | PosedProblem) -> str:
        """Why the solver cannot take the problem; empty if it can."""
        if isinstance(problem, SpatialContactProblem):
            return "" if problem.symmetric else f"{UNSYMMETRIC}: Auto() takes it"
        if isinstance(problem, ContactProblem):
            return ""
        return (
            f"problem: {type(problem).__name__} does not tell which unknowns are the normal and tangential forces of "
            "contacts, as is expected: pose a ContactProblem, whose friction this solver relaxes, or use Lemke()"
        )

    def solve(self, problem: Lcp | PosedProblem, guess: Solution | None = None) -> Solution:
        """The forces of the relaxed model. A guess is ignored: interior points cannot start from one.

        problem: a :class:`ContactProblem` or a :class:`SpatialContactProblem`. guess: the solution of a similar problem
        to start from, or None.
        """
        check_guess(guess)
        if reason := self.refuses(problem):
            raise ModelError(reason)
        if isinstance(problem, SpatialContactProblem):
            space = RelaxedSpatialProblem(problem)
            with np.errstate(all="ignore"):
                return guarded("Clarabel", space, self.tolerance, lambda: self._in_space(space))
        assert isinstance(problem, ContactProblem)
        relaxed = ConvexContactProblem(problem)
        if not problem.free.any():
            return self._judged(relaxed, np.zeros(relaxed.size), "free = 0", 0, "Solved")
        with np.errstate(all="ignore"):  # what overflows is not finite, and is not called solved
            return guarded("Clarabel", relaxed, self.tolerance, lambda: self._solve(relaxed))

    def _in_space(self, relaxed: RelaxedSpatialProblem) -> Solution:
        """Clarabel's forces in the cones of space, their last digits by Newton steps."""
        forces, iterations, said = relaxed_solution(relaxed.contact)
        if not np.isfinite(forces).all():
            forces = np.zeros(relaxed.size)
        return self._judged(relaxed, forces, "Clarabel", iterations, said)

    def _solve(self, relaxed: ConvexContactProblem) -> Solution:
        """Clarabel's point, polished and judged; a second one where rounding stops it short, as in a squeeze."""
        program = _Program.of(relaxed.contact)
        if not program.finite:
            words = "the numbers of the problem overflow when they are scaled"
            return self._judged(relaxed, np.zeros(relaxed.size), "", 0, words)
        found = self._stepping(relaxed, program, STEP)
        if found.settled or relaxed.size > LARGEST or out_of_time():
            return found
        again = self._stepping(relaxed, program, SHORT_STEP)
        return again if again.settled or again.residual < found.residual else found

    def _stepping(self, relaxed: ConvexContactProblem, program: _Program, step: float) -> Solution:
        """What Clarabel finds with steps of so much of the way to the edge of a cone, polished and judged."""
        nowhere = np.zeros(relaxed.size)
        x, iterations, said = program.clarabel(step)
        if not np.isfinite(x).all():
            return self._judged(relaxed, nowhere, "Clarabel", iterations, said)
        if relaxed.size > LARGEST:
            return self._judged(relaxed, program.forces(x), "Clarabel", iterations, said)
        M = program.matrix()
        if said == "DualInfeasible" and infeasibility(relaxed, relaxed.on_edges(program.forces(x))) is not None:
            return self._judged(relaxed, nowhere, "Clarabel", iterations, UNBOUNDED)
        x, polished = self._polished(relaxed, program, M, x)
        route = "Clarabel, active set" if polished else "Clarabel"
        return self._judged(relaxed, program.forces(x), route, iterations, said)

    def _polished(
        self, relaxed: ConvexContactProblem, program: _Program, M: FloatArray, x: FloatArray
    ) -> tuple[FloatArray, bool]:
        """The best point seen while the edges that carry force are corrected, and whether it is another one than x."""
        best, least = x, relaxed.residual(program.forces(x))
        polished = False
        for count in range(POLISHING + 1):
            x = program.on_active_edges(M, x) if count < POLISHING else program.on_each_edge(M, best)
            residual = relaxed.residual(program.forces(x))
            settled = residual > 0.1 * least or out_of_time()
            if residual < least:
                best, least, polished = x, residual, True
            if settled and (least <= self.tolerance or out_of_time()):
                break
        return best, polished

    def _judged(
        self,
        relaxed: ConvexContactProblem | RelaxedSpatialProblem,
        z: FloatArray,
        route: str,
        iterations: int,
        said: str,
    ) -> Solution:
        """The point, judged by the relaxed law and labelled as a solution of no other."""
        solution = accept(
            relaxed,
            z,
            tolerance=self.tolerance,
            status=Status.NUMERICAL_FAILURE if said not in SUCCESS else Status.SOLVED,
            iterations=iterations,
            route="convex relaxation of friction (not Coulomb's law)" + (f": {route}" if route else ""),
            message="" if said in SUCCESS else said,
        )
        message = solution.message
        if solution.solved:
            lift = relaxed.lift(z)
            message = f"solves the convex relaxation of friction, which lifts sliding contacts by up to {lift:.3g}"
        return replace(solution, message=message, keys=_force_keys(relaxed))


@dataclass(frozen=True, slots=True, eq=False)
class _Program:
    """The relaxed law in scaled unknowns x, lambda = load unit x, in which every cone is |x_T| <= x_N.

    Rows of x: contacts without friction, then (x_N, x_T) of each other one. order (m,): the rows of the contact problem
    in that order. P (m, m) or B (m, k) with P = B B^T, c (m,): scaled G or factor, and free.
    """

    order: IntArray
    unit: FloatArray
    load: float
    smooth: int
    P: Any
    B: Any
    c: FloatArray

    @classmethod
    def of(cls, contact: ContactProblem) -> _Program:
        """Units in which the larger diagonal entry of each contact is 1, and the largest of c."""
        normals, tangent = len(contact.friction), contact.tangent
        smooth = np.flatnonzero(contact.friction == 0.0)
        pairs = np.column_stack([tangent, normals + np.arange(len(tangent))])
        order = np.concatenate([smooth, pairs.ravel()]).astype(np.int64)
        aspect = np.ones(len(contact.free))
        aspect[normals:] = contact.friction[tangent]
        size = aspect * np.sqrt(np.abs(contact.diagonal))
        size[tangent] = size[normals:] = np.maximum(size[tangent], size[normals:])
        unit = (aspect / np.where(size > 0.0, size, 1.0))[order]
        c = unit * contact.free[order]
        load = float(np.abs(c).max())
        P = B = None
        if contact.factor is None and contact.delassus is not None:
            P = _in_order(contact.delassus, order, unit)
        else:
            B = libs.sparse.diags_array(unit) @ libs.sparse.csr_array(contact.factor)[order]
        return cls(order, unit, load, len(smooth), P, B, c / load)

    @property
    def finite(self) -> bool:
        """Whether no number overflowed."""
        matrix = self.B if self.P is None else self.P
        matrix = matrix.data if is_sparse(matrix) else matrix
        return bool(np.isfinite(matrix).all() and np.isfinite(self.c).all() and self.load > 0.0)

    def clarabel(self, step: float = STEP) -> tuple[FloatArray, int, str]:
        """x (m,), the iterations and what Clarabel says of it."""
        return conic_program(self.P, self.B, self.c, self.smooth, 2, step)

    def turned(self, x: FloatArray) -> FloatArray:
        """Components along the two edges of each plane cone; turned twice is x itself."""
        y = x.copy()
        first, second = x[self.smooth :: 2], x[self.smooth + 1 :: 2]
        y[self.smooth :: 2] = (first + second) * np.sqrt(0.5)
        y[self.smooth + 1 :: 2] = (first - second) * np.sqrt(0.5)
        return y

    def matrix(self) -> FloatArray:
        """P (m, m), multiplied out if only its factor is known."""
        return as_dense(self.P if self.B is None else self.B @ self.B.T)

    def on_edges(self, M: FloatArray) -> tuple[FloatArray, FloatArray]:
        """The relaxed law as an LCP: its unknowns are the forces along the edges, which are all >= 0."""
        return np.ascontiguousarray(self.turned(self.turned(M).T)), self.turned(self.c)

    def on_active_edges(self, M: FloatArray, x: FloatArray) -> FloatArray:
        """v = 0 along the edges that carry force, no force along the others, by the least change of x (m,).

        A contact that carries force along both edges sticks: its unknowns are then x_N and x_T, as the edges are nearly
        parallel where mu is small.
        """
        active = self.turned(x) > self.turned(M @ x + self.c)
        columns = self.turned(np.eye(len(x)))
        pairs = active[self.smooth :].reshape(-1, 2).all(axis=1)
        sticking = self.smooth + np.flatnonzero(np.repeat(pairs, 2))
        columns[:, sticking] = np.eye(len(x))[:, sticking]
        columns = columns[:, active]
        size = np.sqrt(np.abs(np.einsum("ij,ij->j", columns, M @ columns)))
        columns /= np.where(size > 0.0, size, 1.0)
        start = columns.T @ x / np.einsum("ij,ij->j", columns, columns)
        block, load = columns.T @ M @ columns, columns.T @ self.c
        return columns @ equilibrium(block, load, start, np.arange(len(start)))

    def on_each_edge(self, M: FloatArray, x: FloatArray) -> FloatArray:
        """The same with the edges as unknowns, of which a contact may lose one at a time: for a set that is far off."""
        return self.turned(polish(*self.on_edges(M), np.maximum(self.turned(x), 0.0)))

    def forces(self, x: FloatArray) -> FloatArray:
        """lambda (m,) of the nearest x in the cones, in the order of the contact problem."""
        z = np.zeros(len(x))
        z[self.order] = self.load * (self.unit * self.turned(np.maximum(self.turned(x), 0.0)))
        return z


def relaxed_forces(contact: ContactProblem) -> FloatArray | None:
    """Forces (m,) of the relaxed law as Clarabel finds them, not judged, for others to begin from; None if it fails.

    contact: with a symmetric Delassus operator and free velocities that are not all zero.
    """
    with np.errstate(all="ignore"):
        program = _Program.of(contact)
        if not program.finite:
            return None
        forces = program.forces(program.clarabel()[0])
    return forces if np.isfinite(forces).all() else None


def _in_order(matrix: Any, order: IntArray, unit: FloatArray) -> Any:
    """Rows and columns in this order, times their units; dense or sparse as it was."""
    if is_sparse(matrix):
        scale = libs.sparse.diags_array(unit)
        return scale @ matrix[order][:, order] @ scale
    return (matrix[np.ix_(order, order)] * unit[:, None]) * unit


def _force_keys(relaxed: ConvexContactProblem | RelaxedSpatialProblem) -> tuple[Hashable, ...]:
    """Names of lambda_N and lambda_T: no guess of Coulomb's unknowns must mistake the latter for lambda_R."""
    if isinstance(relaxed, RelaxedSpatialProblem):
        return relaxed.unknown_keys
    contact = relaxed.contact
    frictional = [contact.keys[i] for i in contact.tangent]
    return (*((key, "N") for key in contact.keys), *((key, "T") for key in frictional))
