"""Contact with Coulomb friction: the data that such a problem is made of, its LCP forms and its residual.

Contact velocities (or accelerations) are v = G lambda + free, rows ordered [normals; tangents of frictional contacts].
The forms are those of :mod:`lcpflex.solvers.contact.lcp_forms`.
"""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from lcpflex.basics import libs
from lcpflex.basics.arguments import flag, point_of
from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.solvers.acceptance import accept, confirmed
from lcpflex.solvers.arguments import check_guess, check_solver
from lcpflex.solvers.balance import Units, unknown_units
from lcpflex.solvers.certificate import largest_measures
from lcpflex.solvers.contact.coupling import MOST_BLOCKS, Coupling, coupling_of
from lcpflex.solvers.contact.lcp_forms import assemble_copositive_lcp, assemble_friction_lcp, split_friction_solution
from lcpflex.solvers.contact.matrices import PosedContacts, as_dense, check_dense
from lcpflex.solvers.lcp.exact_residual import largest_of_each
from lcpflex.solvers.lcp.exact_systems import ExactSystem, contact_rows
from lcpflex.solvers.problem import Lcp, LcpSolver, Solution, Status

__all__ = ["ContactProblem", "aligned"]

APART = 1e-6  # relative distance of two solutions
KEPT = 300  # unknowns up to which the LCP is made only once, 1.5 MB


class ContactProblem(PosedContacts):
    """Planar Coulomb contact: contact velocities (or accelerations) are ``G @ forces + free``.

    Attributes
    ----------
    delassus
        G (m, m) [1/kg], dense or scipy sparse, or None where only its factor is known. Kept as a CSR array where it is
        sparse, and where it has more than 4000 rows (``matrices.DENSE_LARGEST``): beyond that size no dense matrix is
        made of a contact problem, and :meth:`dense`, :meth:`lcp`, :meth:`copositive_lcp` and the methods that need them
        raise ModelError.
    free
        (m,) velocity [m/s] or acceleration [m/s^2] without contact forces. Rows are ordered [normals of all contacts;
        tangents of the frictional ones], m = n_N + n_H.
    friction
        (n_N,) coefficients [-]: a contact has a tangent row if and only if its coefficient is positive.
    keys
        (n_N,) names of the contacts, for messages and for warm starts from problems with other contacts; their numbers
        if left out.
    factor
        J (m, k) with G = J J^T, dense or scipy sparse: W^T L^-T for the mass matrix M = L L^T. Memory then stays linear
        in the contacts where each of them touches few bodies.

    Raises
    ------
    ModelError
        For sizes that do not fit, a number that is not finite, a negative coefficient, keys that repeat.
    """

    __slots__ = ()

    @staticmethod
    def _rows(friction: FloatArray) -> tuple[int, str]:
        n, rubbing = len(friction), int(np.count_nonzero(friction))
        return n + rubbing, f" for {n} contacts, {rubbing} of them with friction"

    @property
    def tangent(self) -> IntArray:
        """(n_H,) the contact to which each tangential row belongs."""
        if "tangent" not in self._kept:
            self._kept["tangent"] = np.flatnonzero(self.friction)
        return self._kept["tangent"]  # type: ignore[no-any-return]

    @property
    def row_contacts(self) -> IntArray:
        """(m,) the contact of each row."""
        return np.concatenate([np.arange(len(self.friction)), self.tangent])

    def _rows_of(self, contacts: IntArray) -> IntArray:
        """The rows of contacts (k,), whose numbers rise."""
        rubbing = contacts[self.friction[contacts] > 0.0]
        return np.concatenate([contacts, len(self.friction) + np.searchsorted(self.tangent, rubbing)])

    @property
    def unknown_units(self) -> Units:
        """The units of the unknowns of :meth:`lcp`, those of force for a force, their inverse for a slip."""
        if "unknown units" not in self._kept:
            d, tangent = np.empty(self.size), self.tangent
            unknown_units(self.units, tangent, len(self.friction), len(tangent), d)
            self._kept["unknown units"] = Units.of(d, self.free)
        return self._kept["unknown units"]  # type: ignore[no-any-return]

    def balanced(self) -> ContactProblem:
        """See :meth:`.PosedContacts.balanced`."""
        known = None if "balanced" in self._kept else self._kept.get("coupling")
        alike = super().balanced()
        if known is not None:
            alike._kept["coupling"] = replace(known, free=known.free / alike.unknown_units.load)
        return alike

    @property
    def coupling(self) -> Coupling | None:
        """The operator of :meth:`balanced` in blocks of two contacts; None where a factor couples thousands."""
        if "coupling" not in self._kept:
            matrix, units = self.sparse_delassus(), self.units
            free = self.free / self.unknown_units.load * self.row_units
            self._kept["coupling"] = None if matrix is None else coupling_of(matrix, free, self._data[2], units)
        return self._kept["coupling"]  # type: ignore[no-any-return]

    def sparse_delassus(self) -> Any:
        """The Delassus operator, multiplied out sparsely if only its factor is known; None if that has many entries."""
        if self.delassus is not None:
            return self._data[0]
        factor = libs.sparse.csr_array(self.factor)
        touched = np.bincount(factor.indices, minlength=factor.shape[1]).astype(float)
        return factor @ factor.T if (touched**2).sum() <= 4 * MOST_BLOCKS else None

    @property
    def size(self) -> int:
        """Number n_N + 2 n_H of unknowns of :meth:`lcp`."""
        return 2 * len(self.free) - len(self.friction)

    @property
    def unknown_keys(self) -> tuple[Hashable, ...]:
        """Name of each unknown of :meth:`lcp`: the contact's key with "N", "R" or "L"."""
        if "keys" not in self._kept:
            rubbing = [self.keys[i] for i in self.tangent]
            sides = (("N", self.keys), ("R", rubbing), ("L", rubbing))
            self._kept["keys"] = tuple([(key, side) for side, keys in sides for key in keys])
        return self._kept["keys"]  # type: ignore[no-any-return]

    def lcp(self) -> Lcp:
        """Unknowns [lambda_N (n_N), lambda_R (n_H), xi_L (n_H)]: see :func:`assemble_friction_lcp`.

        Raises ModelError beyond 4000 unknowns.
        """
        if "lcp" in self._kept:
            return self._kept["lcp"]  # type: ignore[no-any-return]
        tangent, normals, n = self.tangent, len(self.friction), self.size
        check_dense("the LCP of the contacts", n)
        M, q = np.zeros((n, n)), np.zeros(n)
        delassus = self._data[0] if isinstance(self.delassus, np.ndarray) else self.dense()
        assemble_friction_lcp(delassus, *self._data[1:3], tangent, normals, len(tangent), M, q)
        factor = None if len(tangent) or self.factor is None else as_dense(self.factor)
        lcp = Lcp(M, q, factor)._measured([self.unknown_units.d, "given"], (normals, tangent))
        if n <= KEPT:
            self._kept["lcp"] = lcp
        return lcp

    def solve_by(self, solver: LcpSolver, guess: Solution | None = None) -> Solution:
        """The solution of :meth:`lcp` by ``solver``; a guess may be of a problem with other contacts."""
        check_solver(solver)
        check_guess(guess)
        keys, lcp = self.unknown_keys, self.lcp()
        found = solver.solve(lcp, aligned(guess, keys))
        if found.status is Status.NOT_UNIQUE:
            found = self.told_apart(lcp, found, getattr(solver, "tolerance", 1e-10))
        return replace(confirmed(self, found), keys=keys)

    def exact_system(self) -> ExactSystem:
        """:meth:`lcp` without the rounding of G_T mu, and of J J^T where only the factor is known."""
        return contact_rows(self.delassus, self.factor, self.free, self.friction)

    def told_apart(self, lcp: Lcp, found: Solution, tolerance: float) -> Solution:
        """Of several solutions those of different forces: xi_L of an open contact is any speed with xi_R >= 0.

        lcp: this problem as an LCP. found: its solutions. tolerance: largest residual of a solution.
        """
        points: list[FloatArray] = []
        for z in (self.unknowns(*self.forces(z)) for z in found.solutions):
            if all(np.abs(z - p).max() > APART * max(np.abs(z).max(), np.abs(p).max()) for p in points):
                points.append(z)
        several = tuple(points) if len(points) > 1 else ()
        told = accept(lcp, points[0], tolerance=tolerance, route=found.route, solutions=several)
        return replace(told, active=found.active, iterations=found.iterations) if told.solved else found

    def copositive_lcp(self) -> Lcp:
        """Unknowns [lambda_N (n_N), beta_+, beta_-, sigma (n_H each)]: see :func:`assemble_copositive_lcp`.

        Raises ModelError beyond 4000 unknowns.
        """
        tangent, normals = self.tangent, len(self.friction)
        n = normals + 3 * len(tangent)
        check_dense("the copositive LCP of the contacts", n)
        M, q = self.lcp()._data
        M4, q4 = np.zeros((n, n)), np.zeros(n)
        assemble_copositive_lcp(M, q, self._data[2], tangent, normals, len(tangent), M4, q4)
        forces, slip = np.split(self.unknown_units.d, [len(self.free)])
        return Lcp(M4, q4)._measured([np.concatenate([forces, forces[normals:], slip]), "given"], (normals, tangent))

    def forces(self, z: npt.ArrayLike) -> tuple[FloatArray, FloatArray]:
        """(lambda_N (n_N,), lambda_T (n_H,)) of a solution z (n,) of :meth:`lcp`."""
        tangent, normals = self.tangent, len(self.friction)
        point = self._point(z)
        out = np.zeros(normals), np.zeros(len(tangent))
        split_friction_solution(point, self._data[2], tangent, normals, len(tangent), *out)
        return out

    def unknowns(self, lambda_normal: npt.ArrayLike, lambda_tangent: npt.ArrayLike) -> FloatArray:
        """z (n,) of :meth:`lcp` for forces lambda_N (n_N,), lambda_T (n_H,); xi_L from the velocity they cause.

        lambda_normal, lambda_tangent: in the order of the contacts and of those with friction [N] or [N s].
        """
        tangent, normals = self.tangent, len(self.friction)
        pressed = point_of("lambda_normal", lambda_normal, normals)
        rubbed = point_of("lambda_tangent", lambda_tangent, len(tangent))
        slip = self.velocity(np.concatenate([pressed, rubbed]))[normals:]
        edge = (self.friction * pressed)[tangent]
        return np.concatenate([pressed, rubbed + edge, np.maximum(-slip, 0.0)])

    def slack(self, z: npt.ArrayLike) -> FloatArray:
        """w of :meth:`lcp` without forming it: [v_N, xi_R = v_T + xi_L, lambda_L = 2 mu lambda_N - lambda_R].

        z (n,): the unknowns of :meth:`lcp`.
        """
        tangent, normals = self.tangent, len(self.friction)
        point = self._point(z)
        pressed, right, left = np.split(point, [normals, normals + len(tangent)])
        edge = (self.friction * pressed)[tangent]
        velocity = self.velocity(np.concatenate([pressed, right - edge]))
        return np.concatenate([velocity[:normals], velocity[normals:] + left, 2.0 * edge - right])

    def residual(self, z: npt.ArrayLike, scaled: bool = True) -> float:
        """Natural-map residual of z (n,), that of :meth:`lcp`: dimensionless and the same in any units if scaled.

        Else in the units of ``free``. inf for a z that holds NaN or inf. Raises ModelError if z has another shape.
        """
        if flag("scaled", scaled):
            return self.residuals(z)[0]
        return float(self._parts(self._point(z))[0].max(initial=0.0))

    def residuals(self, z: npt.ArrayLike) -> tuple[float, float]:
        """The residual of z (n,) in two sizes: :attr:`Solution.residual` and :attr:`Solution.strict`.

        Of each contact by itself, in its unit: relative to the terms that cancel in its velocities, and to its own free
        velocity (:func:`lcpflex.solvers.certificate.measured`); the largest ones.
        """
        residual, strict, _ = self._sizes(self._point(z), np.empty(0))
        return float(residual), float(strict)

    def judged(self, z: FloatArray) -> tuple[FloatArray, float, float]:
        """w of z (n,), and its residual in the two sizes of a :class:`Solution`."""
        units = self.unknown_units
        if self.coupling is None:
            return self.slack(z), *self.residuals(z)
        w = np.empty(self.size)
        residual, strict, _ = self._sizes(self._point(z), w)
        return units.slack_outward(w), float(residual), float(strict)

    def by_terms(self, z: FloatArray) -> tuple[float, str]:
        """The residual of z (n,) relative to the terms that cancel in each contact, and which contact is worst.

        The worst is the one that has most left of its own load; inf where a tenth of that may be left.
        """
        point, coupling = self._point(z), self.coupling
        terms = self._sizes(point, np.empty(0))[2]
        if not terms < np.inf:
            return np.inf, ""
        if coupling is None:
            miss, size, load = self.balanced()._parts(self.unknown_units.inward(point))
            missed = miss / np.maximum(np.maximum(load, size), 1e-300)
        else:
            missed = coupling.missed(self.unknown_units.inward(point))
        return float(terms), f"contact {self.keys[int(np.argmax(missed))]}"

    def _sizes(self, point: FloatArray, w: FloatArray) -> tuple[float, float, float]:
        """The three sizes of :func:`lcpflex.solvers.certificate.measured`; w in units, unless it is empty."""
        inward, coupling = self.unknown_units.inward(point), self.coupling
        if coupling is not None:
            return coupling.weighed(inward, w)
        told: tuple[float, float, float] = largest_measures(*self.balanced()._parts(inward))
        return told

    def _parts(self, point: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """What each contact misses, the size of its terms, its load (n_N,): in the units of ``free``.

        point (n,): unknowns of :meth:`lcp`. No more than BLOCK rows of the matrix exist at a time.
        """
        with np.errstate(all="ignore"):
            w = self.slack(point)
            largest, terms = row_sizes(self, point)
            miss = np.abs(np.minimum(largest * point, w))
        miss[~np.isfinite(miss + terms)] = np.inf
        load = np.concatenate([np.abs(self.free), np.zeros(len(self.tangent))])
        miss, terms, load = (
            largest_of_each(values, len(self.friction), self.tangent) for values in (miss, terms, load)
        )
        return miss, terms, load

    def _point(self, z: npt.ArrayLike) -> FloatArray:
        return point_of("z", z, self.size)


def aligned(guess: Solution | None, keys: tuple[Hashable, ...]) -> Solution | None:
    """The guess with z and basis brought to the unknowns ``keys`` by name; unknowns that are new start nonbasic."""
    if guess is None or guess.keys is None or guess.keys == keys:
        return guess
    place = {key: i for i, key in enumerate(guess.keys)}
    found = np.array([place.get(key, -1) for key in keys], dtype=np.int64)
    known = found >= 0
    z = np.where(known, guess.z[found], 0.0) if len(guess.z) else np.zeros(len(keys))
    active = None
    if guess.active is not None:
        active = np.where(known, guess.active[found], 0) if len(guess.z) else np.zeros(len(keys), dtype=np.int64)
    return replace(guess, z=z, w=np.zeros(len(keys)), active=active, keys=keys)


def row_sizes(problem: ContactProblem, z: FloatArray) -> tuple[FloatArray, FloatArray]:
    """max_j |M_ij| and |q_i| + sum_j |M_ij z_j| of every row of :meth:`ContactProblem.lcp`."""
    tangent, normals, m = problem.tangent, len(problem.friction), len(problem.free)
    count = len(tangent)
    edge = libs.sparse.csr_array((problem.friction[tangent], (np.arange(count), tangent)), shape=(count, normals))
    columns = libs.sparse.block_array(
        [[libs.sparse.eye_array(normals), None], [-edge, libs.sparse.eye_array(count)]], format="csr"
    )
    largest, terms = np.zeros(problem.size), np.zeros(problem.size)
    size = np.abs(z)
    for rows, block in problem.row_blocks():
        block = abs(block @ columns)
        largest[rows] = as_dense(block.max(axis=1)).ravel()
        terms[rows] = block @ size[:m]
    terms[:m] += np.abs(problem.free)
    largest[normals:m] = np.maximum(largest[normals:m], 1.0)
    terms[normals:m] += size[m:]
    mu = problem.friction[tangent]
    largest[m:] = np.maximum(2.0 * mu, 1.0)
    terms[m:] = 2.0 * mu * size[tangent] + size[normals:m]
    largest[largest == 0.0] = 1.0
    return largest, terms
