"""Coulomb contact in space: the data of such a problem, and what a solution of it is.

With u = G r + free, contact k is solved when K_mu ∋ r_k  _|_  u_k + mu_k |u_Tk| n ∈ K_mu* (de Saxce & Feng 1998),
K_mu the cone |r_T| <= mu r_N and K_mu* its dual. No linear complementarity problem says the same: solvers of those
refuse it, and those that know cones take it as it is.
"""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt

from lcpflex.basics import libs
from lcpflex.basics.arguments import flag, point_of
from lcpflex.errors import ModelError
from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.solvers.arguments import check_guess, check_solver
from lcpflex.solvers.balance import Units
from lcpflex.solvers.certificate import guarded_residual, strict_residual
from lcpflex.solvers.contact.cones.certificate import cone_parts, cone_sizes, weigh_cones
from lcpflex.solvers.contact.matrices import PosedContacts, is_sparse
from lcpflex.solvers.problem import Lcp, LcpSolver, Solution
from lcpflex.solvers.refusals import NO_LCP, check_answer

__all__ = ["OtherLaw", "SpatialContactProblem"]

MOST_ENTRIES = 20_000_000  # of the product of a factor, up to which it is multiplied out
SIDES = ("N", "1", "2")


class SpatialContactProblem(PosedContacts):
    """Coulomb contact in space: contact velocities (or accelerations) are ``G @ forces + free``.

    The unknowns z of its solutions are the forces (3 k,) themselves, [N s] or [N], and w the velocities.

    Attributes
    ----------
    delassus
        G (3 k, 3 k) [1/kg], dense or scipy sparse, or None where only its factor is known; rows (n, t1, t2) of each
        contact in turn. It may be unsymmetric. Kept as a CSR array where it is sparse, and beyond 4000 rows.
    free
        (3 k,) velocity [m/s] or acceleration [m/s^2] without contact forces.
    friction
        (k,) coefficients [-], 0 for a contact without friction: its tangents have rows too.
    keys
        (k,) names of the contacts, for messages and for warm starts from problems with other contacts; their numbers
        if left out.
    factor
        J (3 k, m) with G = J J^T, dense or scipy sparse: W^T L^-T for the mass matrix M = L L^T.

    Raises
    ------
    ModelError
        For sizes that do not fit, a number that is not finite, a negative coefficient, keys that repeat.
    """

    __slots__ = ()
    cones: ClassVar[bool] = True  # no LCP

    @staticmethod
    def _rows(friction: FloatArray) -> tuple[int, str]:
        return 3 * len(friction), f", three for each of {len(friction)} contacts"

    @property
    def size(self) -> int:
        """Number 3 k of force components."""
        return len(self.free)

    @property
    def unknown_keys(self) -> tuple[Hashable, ...]:
        """Name of each unknown: the contact's key with "N", "1" or "2"."""
        if "keys" not in self._kept:
            self._kept["keys"] = tuple([(key, side) for key in self.keys for side in SIDES])
        return self._kept["keys"]  # type: ignore[no-any-return]

    @property
    def row_contacts(self) -> IntArray:
        """(3 k,) the contact of each row."""
        return np.repeat(np.arange(len(self.friction)), 3)

    def _rows_of(self, contacts: IntArray) -> IntArray:
        """The rows of contacts (k,), whose numbers rise."""
        return np.asarray((3 * contacts[:, None] + np.arange(3)).ravel())

    @property
    def unknown_units(self) -> Units:
        """The units of the forces, three for each contact; the load is that of the free velocities in them."""
        if "unknown units" not in self._kept:
            d = self.row_units
            with np.errstate(all="ignore"):
                self._kept["unknown units"] = Units.of(d, self.free * d)
        return self._kept["unknown units"]  # type: ignore[no-any-return]

    def matrix(self) -> Any:
        """The Delassus operator, multiplied out if only its factor is known; None if that has too many entries."""
        if self.delassus is not None:
            return self._data[0]
        if "matrix" not in self._kept:
            self._kept["matrix"] = _product(self._data[3])
        return self._kept["matrix"]

    def _formed(self) -> Any:
        return self.matrix()

    def forces(self, z: npt.ArrayLike) -> FloatArray:
        """(k, 3) force of each contact, normal and two tangents, of a solution z (3 k,)."""
        return self._point("z", z).reshape(-1, 3)

    def slack(self, z: npt.ArrayLike) -> FloatArray:
        """w of a point z (3 k,): the velocities of the contacts."""
        return self.velocity(self._point("z", z))

    def residual(self, z: npt.ArrayLike, scaled: bool = True) -> float:
        """How far forces z (3 k,) are from solving the problem: dimensionless and the same in any units if scaled.

        The largest component of r' - P_K(r' - (u' + mu |u'_T| n)), r' and u' in units of each contact (see
        :mod:`lcpflex.solvers.contact.cones.certificate`), relative to the terms that cancel in the velocities; not
        scaled: itself. inf for a z that holds NaN or inf. Raises ModelError if z has another shape.
        """
        point = self._point("z", z)
        if flag("scaled", scaled):
            return self.residuals(point)[0]
        return self.residual_parts(point)[0]

    def residuals(self, z: npt.ArrayLike) -> tuple[float, float]:
        """The residual of z (3 k,) in two sizes: :attr:`Solution.residual` and :attr:`Solution.strict`."""
        return self.judged(self._point("z", z))[1:]

    def judged(self, z: FloatArray) -> tuple[FloatArray, float, float]:
        """The velocities under the forces z (3 k,), and their residual in the two sizes of a :class:`Solution`."""
        point, units = self._point("z", z), self.units
        delassus, free, friction, _ = self._data
        if isinstance(delassus, np.ndarray):
            w, terms = np.empty(self.size), np.empty(self.size)
            residual, strict, _ = weigh_cones(delassus, free, friction, units, point, len(friction), w, terms)
            return w, float(residual), float(strict)
        with np.errstate(all="ignore"):  # what is not finite is judged so
            w = self.velocity(point)
        residual, strict, _ = self._sizes(point, w, np.empty(0))
        return w, residual, strict

    def by_terms(self, z: FloatArray) -> tuple[float, str]:
        """The residual of z (3 k,) relative to the terms that cancel in each contact, and which contact is worst.

        The worst is the one that has most left of its own load; inf where a tenth of that may be left.
        """
        point, missed = self._point("z", z), np.empty(len(self.friction))
        with np.errstate(all="ignore"):
            terms = self._sizes(point, self.velocity(point), missed)[2]
        return (terms, f"contact {self.keys[int(np.argmax(missed))]}") if terms < np.inf else (np.inf, "")

    def _sizes(self, z: FloatArray, w: FloatArray, missed: FloatArray) -> tuple[float, float, float]:
        """What :func:`cone_sizes` tells of forces z (3 k,) with velocities w."""
        told = cone_sizes(z, w, self._terms(z), *self._data[1:3], self.units, len(self.friction), missed)
        return float(told[0]), float(told[1]), float(told[2])

    def _terms(self, z: FloatArray) -> FloatArray:
        """(3 k,) sum |G_ij z_j| + |free_i|."""
        with np.errstate(all="ignore"):
            size, terms = np.abs(z), np.abs(self.free)
            for rows, block in self.row_blocks():
                terms[rows] += abs(block) @ size
        return terms

    def residual_parts(self, z: FloatArray) -> tuple[float, float, float]:
        """What is left of the natural map, size of its terms, max |free|: each in the units of the contacts.

        z (3 k,): forces.
        """
        with np.errstate(all="ignore"):
            parts = cone_parts(z, self.velocity(z), self._terms(z), *self._data[1:3], self.units, len(self.friction))
        return float(parts[0]), float(parts[1]), float(parts[2])

    def lcp(self) -> Lcp:
        """Raises ModelError: friction in space is a cone, and no LCP."""
        raise ModelError(f"problem: {NO_LCP}")

    def solve_by(self, solver: LcpSolver, guess: Solution | None = None) -> Solution:
        """What ``solver`` makes of this problem; raises ModelError, with its reason, if it does not take it.

        solver: one that knows cones, as Auto(). guess: the solution of a similar problem to start from, or None.
        """
        check_solver(solver)
        check_guess(guess)
        if reason := solver.refuses(self) if callable(getattr(solver, "refuses", None)) else "":
            raise ModelError(reason)
        return check_answer(solver.solve(self, guess))

    def _point(self, name: str, z: npt.ArrayLike) -> FloatArray:
        return point_of(name, z, self.size)


@dataclass(frozen=True, slots=True)
class OtherLaw:
    """Contacts of a :class:`SpatialContactProblem` under another law than Coulomb's; unknowns are the forces (3 k,).

    Raises ModelError if ``contact`` is something else.
    """

    contact: SpatialContactProblem

    def __post_init__(self) -> None:
        if not isinstance(self.contact, SpatialContactProblem):
            raise ModelError(f"contact is a {type(self.contact).__name__}: expected a SpatialContactProblem")

    @property
    def size(self) -> int:
        """Number 3 k of force components."""
        return self.contact.size

    @property
    def unknown_keys(self) -> tuple[Hashable, ...]:
        """Those of the contacts."""
        return self.contact.unknown_keys

    def slack(self, z: npt.ArrayLike) -> FloatArray:
        """The velocities (3 k,) under the forces z (3 k,)."""
        return self.contact.slack(z)

    def residual(self, z: npt.ArrayLike, scaled: bool = True) -> float:
        """What forces z (3 k,) leave of the law in units of each contact; relative to its terms if ``scaled``.

        inf where they hold NaN or inf. Raises ModelError if z has another shape.
        """
        return self.residuals(z)[0] if flag("scaled", scaled) else self._parts(z)[0]

    def residuals(self, z: npt.ArrayLike) -> tuple[float, float]:
        """The residual of z (3 k,) relative to the terms of the velocities, and to the free velocity alone."""
        worst, size, load = self._parts(z)
        return float(guarded_residual(worst, size, load)), float(strict_residual(worst, load))

    def _parts(self, z: npt.ArrayLike) -> tuple[float, float, float]:
        """What is left, the size of its terms, and that of the free velocities, in units of the contacts."""
        contact, point = self.contact, point_of("z", z, self.size)
        _, size, load = contact.residual_parts(point)
        d = contact.unknown_units.d
        with np.errstate(all="ignore"):
            r, u = point / d, contact.slack(point) * d
            if not (size < np.inf and np.isfinite(r).all() and np.isfinite(u).all()):
                return np.inf, np.inf, np.inf
            worst = self._miss(r, u)
        return (worst, size, load) if worst < np.inf else (np.inf, np.inf, np.inf)

    def _miss(self, r: FloatArray, u: FloatArray) -> float:
        """The largest component that forces r (3 k,) with velocities u leave of the law, both in units."""
        raise NotImplementedError


def _product(factor: Any) -> Any:
    """J J^T, or None where it has too many entries."""
    if not is_sparse(factor):
        return factor @ factor.T if len(factor) ** 2 <= MOST_ENTRIES else None
    touched = np.bincount(factor.indices, minlength=factor.shape[1]).astype(float)
    return libs.sparse.csr_array(factor @ factor.T) if (touched**2).sum() <= MOST_ENTRIES else None
