"""The convex relaxation of planar Coulomb friction as a problem: K ∋ lambda _|_ G lambda + free ∈ K*.

In forces along the edges of its plane cones it is an LCP, symmetric and semidefinite. See
:mod:`lcpflex.solvers.contact.cone`.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from lcpflex.basics import libs
from lcpflex.basics.arguments import flag, point_of
from lcpflex.errors import ModelError
from lcpflex.jit.kernel import FloatArray
from lcpflex.solvers.acceptance import brought_back, confirmed
from lcpflex.solvers.arguments import check_guess, check_solver
from lcpflex.solvers.certificate import guarded_residual
from lcpflex.solvers.contact.matrices import as_dense, check_dense
from lcpflex.solvers.contact.problem import ContactProblem
from lcpflex.solvers.lcp.exact_systems import ExactSystem, relaxed_rows
from lcpflex.solvers.problem import PROVED, Lcp, LcpSolver, Solution

__all__ = ["ConvexContactProblem"]

PRESSED = 1e-8  # lambda_N, relative to the largest, beyond which a contact counts as pressed


@dataclass(frozen=True, slots=True, eq=False)
class ConvexContactProblem:
    """The relaxed law K ∋ lambda _|_ G lambda + free ∈ K* for the contacts of a :class:`ContactProblem`.

    Unknowns are the forces (or impulses) themselves, lambda (m,), rows ordered as in ``contact``: [lambda_N (n_N),
    lambda_T (n_H)]. Raises ModelError if ``contact`` is something else.
    """

    contact: ContactProblem

    def __post_init__(self) -> None:
        if not isinstance(self.contact, ContactProblem):
            raise ModelError(f"contact is a {type(self.contact).__name__}: expected a ContactProblem")

    @property
    def size(self) -> int:
        """Number m = n_N + n_H of force components."""
        return len(self.contact.free)

    def slack(self, z: npt.ArrayLike) -> FloatArray:
        """The velocities [v_N, v_T] (m,) under the forces z (m,)."""
        return self.contact.velocity(self._point(z))

    def residual(self, z: npt.ArrayLike, scaled: bool = True) -> float:
        """max_k d_k |lambda_k - P_K(lambda_k - v_k / d_k)|, d_k the largest |G_ij| in the rows of contact k.

        P_K projects on the cone of the contact. Made dimensionless like that of an :class:`Lcp` unless ``scaled`` is
        False: then in the units of ``free``. inf for a z (m,) that holds NaN or inf. Raises ModelError if z has
        another shape.
        """
        point, contact = self._point(z), self.contact
        with np.errstate(all="ignore"):
            largest, terms = self._row_sizes(point)
            velocity = contact.velocity(point)
            size = float(terms.max(initial=0.0))
            inner = self._projected(point - velocity / largest)
            worst = float(np.abs(largest * (point - inner)).max(initial=0.0))
        if not (np.isfinite(point).all() and np.isfinite(velocity).all() and np.isfinite(size) and np.isfinite(worst)):
            return float("inf")
        load = np.abs(contact.free).max(initial=0.0)
        return float(guarded_residual(worst, size, load)) if flag("scaled", scaled) else worst

    def lift(self, z: npt.ArrayLike) -> float:
        """Largest v_N of the contacts that forces z (m,) press: 0 if Coulomb's law holds too; in the units of free."""
        point = self._point(z)
        normals = len(self.contact.friction)
        pressed = point[:normals] > PRESSED * np.abs(point).max(initial=0.0)
        return float(self.slack(point)[:normals][pressed].max(initial=0.0))

    def lcp(self) -> Lcp:
        """The law in the unknowns of :meth:`on_edges`: symmetric and semidefinite, as G is.

        Raises ModelError beyond 4000 unknowns.
        """
        edges, contact = self._edges(), self.contact
        check_dense("the LCP of the relaxed contacts", edges.shape[1])
        if contact.delassus is None:
            factor = np.ascontiguousarray(as_dense(edges.T @ contact.factor))
            return Lcp(factor @ factor.T, edges.T @ contact.free, factor)
        return Lcp(as_dense(edges.T @ (edges.T @ contact.delassus.T).T), edges.T @ contact.free)

    def solve_by(self, solver: LcpSolver, guess: Solution | None = None) -> Solution:
        """The forces by way of :meth:`lcp`; ``active`` and ``certificate`` then are those of the LCP."""
        check_solver(solver)
        check_guess(guess)
        edges = self._edges()
        if guess is not None and guess.z.shape == (self.size,):
            guess = replace(guess, z=np.maximum(self.on_edges(guess.z), 0.0))
        found = solver.solve(self.lcp(), guess)
        judged = brought_back(
            self,
            found,
            lambda z: np.asarray(edges @ z),
            getattr(solver, "tolerance", 1e-10),
            message="" if found.solved else found.message,
        )
        if not judged.solved and found.status in PROVED:
            return confirmed(self, replace(judged, status=found.status, certificate=found.certificate))
        return judged

    def _edges(self) -> Any:
        """Forces (m,) of one unit along each edge, as columns of a sparse matrix."""
        normals, tangent = len(self.contact.friction), self.contact.tangent
        smooth, mu = np.flatnonzero(self.contact.friction == 0.0), self.contact.friction[tangent]
        count, pairs = len(smooth), np.arange(len(tangent))
        columns = [np.arange(count), *(count + k * len(tangent) + pairs for k in (0, 1, 0, 1))]
        rows = [smooth, tangent, tangent, normals + pairs, normals + pairs]
        values = [np.ones(count + 2 * len(tangent)), mu, -mu]
        places = (np.concatenate(rows), np.concatenate(columns))
        shape = (self.size, count + 2 * len(tangent))
        return libs.sparse.csr_array((np.concatenate(values), places), shape=shape)

    def on_edges(self, z: FloatArray) -> FloatArray:
        """Forces z (m,) along the edges of the cones: lambda_N of contacts without friction, then both of each other.

        lambda_N is the sum of both, lambda_T mu times their difference.
        """
        normals, tangent = len(self.contact.friction), self.contact.tangent
        part = z[normals:] / self.contact.friction[tangent]
        pressed = z[:normals][tangent]
        smooth = z[:normals][self.contact.friction == 0.0]
        return np.concatenate([smooth, 0.5 * (pressed + part), 0.5 * (pressed - part)])

    def exact_system(self) -> ExactSystem:
        """The law as an LCP in the unknowns of :meth:`on_edges`, without rounding."""
        contact = self.contact
        return relaxed_rows(contact.delassus, contact.factor, contact.free, contact.friction)

    def _projected(self, point: FloatArray) -> FloatArray:
        """The nearest point of the cones."""
        normals, tangent = len(self.contact.friction), self.contact.tangent
        mu = self.contact.friction[tangent]
        pressed, rubbed = point[:normals].copy(), point[normals:]
        edge = np.maximum((pressed[tangent] + mu * np.abs(rubbed)) / (1.0 + mu * mu), 0.0)
        inside = np.abs(rubbed) <= mu * pressed[tangent]
        rubbed = np.where(inside, rubbed, mu * edge * np.sign(rubbed))
        pressed[tangent] = np.where(inside, pressed[tangent], edge)
        return np.concatenate([np.maximum(pressed, 0.0), rubbed])

    def _row_sizes(self, z: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Of every row: max |G_ij| over both rows of its contact (1 if zero), and |free_i| + sum_j |G_ij z_j|."""
        contact, m = self.contact, self.size
        largest, terms = np.zeros(m), np.abs(contact.free)
        for rows, block in contact.row_blocks():
            block = abs(block)
            largest[rows] = as_dense(block.max(axis=1)).ravel()
            terms[rows] += block @ np.abs(z)
        normals, tangent = len(contact.friction), contact.tangent
        largest[tangent] = largest[normals:] = np.maximum(largest[tangent], largest[normals:])
        largest[largest == 0.0] = 1.0
        return largest, terms

    def _point(self, z: npt.ArrayLike) -> FloatArray:
        return point_of("z", z, self.size)
