"""Linear complementarity problems, and how wrong a point of one is.

0 <= z  _|_  w = M z + q >= 0                                                    (Cottle, Pang & Stone)
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from lcpflex.basics.arguments import FLOAT, flag, point_of
from lcpflex.errors import ModelError, shown
from lcpflex.jit.kernel import FloatArray
from lcpflex.solvers.acceptance import accept, restored
from lcpflex.solvers.arguments import check_guess, check_solver
from lcpflex.solvers.arrays import as_array, check_finite, finite_array, nothing
from lcpflex.solvers.balance import Units, in_units, lcp_units
from lcpflex.solvers.certificate import (
    GUARD,
    all_finite,
    is_symmetric,
    residual_parts,
    weigh,
    weigh_contacts_of,
    weigh_rows,
    worse,
)
from lcpflex.solvers.lcp.exact_residual import Contacts, own_parts, residual_in_fractions
from lcpflex.solvers.lcp.exact_signs import is_wide, off_in_fractions
from lcpflex.solvers.lcp.exact_systems import ExactSystem, exact_rows
from lcpflex.solvers.lcp.proofs import nearly_infeasible
from lcpflex.solvers.solution import PROVED, LcpSolver, PosedProblem, Problem, Solution
from lcpflex.solvers.status import Status

__all__ = [
    "PROVED",
    "Lcp",
    "LcpSolver",
    "PosedProblem",
    "Problem",
    "Solution",
    "Status",
    "accept",
]


@dataclass(frozen=True, slots=True, eq=False)
class Lcp:
    """The problem 0 <= z _|_ M z + q >= 0.

    M (n, n), q (n,): any consistent units; n = 0 is a valid problem, solved by the empty z.
    factor (n, k), optional: J with M = J J^T, which makes M positive semidefinite and gives quadratic programs their
    velocity form. All are copied and made read-only. Raises ModelError if M is not square, the sizes differ, a number
    is not finite or the factor is not one of M.
    """

    M: FloatArray
    q: FloatArray
    factor: FloatArray | None = None
    # What M and q show read-only: kernels would be compiled a second time for read-only arrays.
    _data: tuple[FloatArray, FloatArray] = field(init=False, repr=False, compare=False)
    _symmetric: list[bool] = field(default_factory=list, init=False, repr=False, compare=False)  # once it is known
    _units: list[Any] = field(default_factory=list, init=False, repr=False, compare=False)  # once they are known
    # Whether its entries are far apart, once that is known; and its contacts, if it is of some.
    _known: list[Any] = field(default_factory=list, init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        q = as_array("q", self.q, 1)
        M = as_array("M", self.M, 2) if len(q) else nothing("M", self.M)
        if M.shape != (len(q), len(q)):
            raise ModelError(f"M has shape {M.shape} and q shape {q.shape}: expected (n, n) and (n,)")
        if not all_finite(M, q):
            check_finite("q", q)
            check_finite("M", M)
        if self.factor is not None:
            object.__setattr__(self, "factor", _checked_factor(self.factor, M))
        M_view, q_view = M.view(), q.view()
        M_view.flags.writeable = False
        q_view.flags.writeable = False
        object.__setattr__(self, "M", M_view)
        object.__setattr__(self, "q", q_view)
        object.__setattr__(self, "_data", (M, q))

    @property
    def size(self) -> int:
        """Number of unknowns n."""
        return len(self.q)

    @property
    def symmetric(self) -> bool:
        """Whether M equals its transpose to rounding; looked at when first asked."""
        if not self._symmetric:
            self._symmetric.append(self.factor is not None or bool(is_symmetric(self._data[0], self.size)))
        return self._symmetric[0]

    @property
    def data(self) -> tuple[FloatArray, FloatArray]:
        """M and q, read-only."""
        return self.M, self.q

    def measured_in(self, units: npt.ArrayLike) -> Lcp:
        """The same problem, whose unknowns are to be measured in these units (n,): see :meth:`balanced`.

        This one stays as it is; they share their numbers. Raises ModelError for units that are not positive.
        """
        d = point_of("units", units, self.size)
        if not (d > 0.0).all() or np.isinf(d).any():
            raise ModelError(f"units is {shown(d)}: expected ({self.size},) positive numbers")
        return self._measured([np.array(d), "given"])

    @property
    def contacts(self) -> Contacts | None:
        """How many contacts it is of, and the contact of each tangential row; None if it is not of contacts."""
        return None if len(self._known) < 2 else (self._known[1], self._known[2])

    def measured_alike(self) -> Lcp:
        """The same problem, whose unknowns are known to be alike as they are; this one stays as it is."""
        return self._measured([None, None, False], self.contacts)

    def _measured(self, units: list[Any], contacts: Contacts | None = None) -> Lcp:
        """A problem of the same numbers with these ``_units``; they are not looked at.

        contacts: see :attr:`contacts`.
        """
        made = object.__new__(type(self))
        for name in ("M", "q", "factor", "_data", "_symmetric"):
            object.__setattr__(made, name, getattr(self, name))
        object.__setattr__(made, "_units", units)
        object.__setattr__(made, "_known", [False, *(contacts or ())] if contacts or units[0] is None else [])
        return made

    def balanced(self) -> tuple[Lcp, Units | None]:
        """The problem in units in which its unknowns are alike, and those: z / d, d M d, d q.

        Residuals are measured in it, and it is what algorithms solve: both are then the same in any units. The problem
        itself and None where one unit will do. See :mod:`lcpflex.solvers.balance`.
        """
        if not self._units:
            d = np.empty(self.size)
            self._units[:] = [d if lcp_units(self._data[0], self.size, d) else None, "guessed"]
        if isinstance(self._units[-1], str):
            self._units[:] = [*self._in_units(self._units[0]), self._units[1] == "guessed" and not self.symmetric]
        scaled, units, _ = self._units
        return (self, None) if scaled is None else (scaled, units)

    def residuals(self, z: FloatArray) -> tuple[float, float]:
        """The residual of z (n,) in two sizes: :attr:`Solution.residual` and :attr:`Solution.strict`."""
        return self.judged(z)[1:]

    def judged(self, z: FloatArray) -> tuple[FloatArray, float, float]:
        """w of z (n,), and its residual in the two sizes of a :class:`Solution`.

        Where units were guessed from the diagonal of an unsymmetric M, which tells little of its rows, the larger ones
        of :meth:`balanced` and of the problem as it is. Where floats lose w in its terms, in fractions.
        """
        if type(z) is not np.ndarray or z.dtype is not FLOAT or z.shape != (self.size,):
            z = point_of("z", z, self.size)
        w = np.empty(self.size)
        residual, strict, _ = self._sizes(z, w)
        if GUARD < residual < np.inf and (exact := residual_in_fractions(self, z)) is not None:
            return exact[0], exact[1], exact[1]
        if residual <= GUARD and self._wide() and (off := self._off(z, w)) > GUARD:
            return w, off, max(off, strict)
        return w, residual, strict

    def _wide(self) -> bool:
        """Whether its entries differ by so much that rows which are right to their last digit need not make a solution.

        Not asked of contacts, whose matrix is a product.
        """
        if not self._known:
            self._known.append(bool(is_wide(self.balanced()[0]._data[0], self.size)))
        return self._known[0]  # type: ignore[no-any-return]

    def _off(self, z: FloatArray, w: FloatArray) -> float:
        """How far z (n,) is from the exact solution on its active set: :func:`off_in_fractions`."""
        alike, units = self.balanced()
        rows = np.abs(alike.M).max(axis=1)
        inward, slack = (z, w) if units is None else (units.inward(z), units.slack_inward(w))
        return off_in_fractions(self, z, (z > 0.0) & (rows * inward > slack))

    def _sizes(self, z: FloatArray, w: FloatArray) -> tuple[float, float, float]:
        """The three sizes of :func:`lcpflex.solvers.certificate.measured` at z (n,); w is written."""
        alike, units = self.balanced()
        if units is None:
            return self._weighed(z, w)
        told = alike._weighed(units.inward(z), w)
        if self._units[2]:
            return worse(told, self._weighed(z, w))
        weigh(*self._data, z, self.size, w)
        return told

    def _weighed(self, z: FloatArray, w: FloatArray) -> tuple[float, float, float]:
        """The same in the units of this problem."""
        if len(self._known) > 1 and (contacts := self.contacts) is not None:
            told: tuple[float, float, float] = weigh_contacts_of(*self._data, z, self.size, w, *contacts)
            return told
        rows: tuple[float, float, float] = weigh_rows(*self._data, z, self.size, w)
        return rows

    def by_terms(self, z: FloatArray) -> tuple[float, str]:
        """The residual of z (n,) relative to the terms that cancel in each contact, or row, and which one is worst.

        The worst is the one that has most left of its own load; inf where a tenth of that may be left.
        """
        z, w = point_of("z", z, self.size), np.empty(self.size)
        terms = self._sizes(z, w)[2]
        if not terms < np.inf:
            return np.inf, ""
        M, q, units, contacts = self.measures()[0]
        inward = (z, w) if units is None else (units.inward(z), units.slack_inward(w))
        miss, _, own = own_parts((M, q), *inward, contacts)
        worst = int(np.argmax(np.where(miss > 0.0, miss / np.where(own > 0.0, own, 1.0), 0.0)))
        return terms, f"{'row' if contacts is None else 'contact'} {worst}"

    def measures(self) -> list[tuple[FloatArray, FloatArray, Units | None, Contacts | None]]:
        """M and q as residuals are taken in them, their units and contacts: once, or twice if units were guessed."""
        alike, units = self.balanced()
        own = [(*self._data, None, self.contacts)] if units is not None and self._units[2] else []
        return [(*alike._data, units, alike.contacts), *own]

    def _in_units(self, d: FloatArray | None) -> tuple[Lcp | None, Units | None]:
        """The problem in units d; None where those are one, or it overflows."""
        if d is None:
            return None, None
        units = Units.of(d, self._data[1])
        M, q = np.empty((self.size, self.size)), np.empty(self.size)
        in_units(*self._data, *units, self.size, M, q)
        if not all_finite(M, q):
            return None, None
        scaled = Lcp(M, q, None if self.factor is None else self.factor * d[:, None])
        scaled = scaled._measured([None, None, False], self.contacts)
        scaled._symmetric[:] = self._symmetric
        return scaled, units

    def lcp(self) -> Lcp:
        """The problem itself, as of those that are only posed as one."""
        return self

    def solve_by(self, solver: LcpSolver, guess: Solution | None = None) -> Solution:
        """What ``solver`` makes of :meth:`balanced`, as a certified solution of this problem.

        guess: the solution of a similar problem to start from, or None.
        """
        check_solver(solver)
        check_guess(guess)
        scaled, units = self.balanced()
        if units is None:
            return solver.solve(scaled, guess)
        if guess is not None and guess.z.shape == units.d.shape:
            guess = replace(guess, z=units.inward(guess.z))
        return restored(self, solver.solve(scaled, guess), units, getattr(solver, "tolerance", 1e-10))

    @property
    def matrix_class(self) -> str:
        """What is cheap to know of M: "positive semidefinite" (a factor is known), "symmetric" or "general"."""
        if self.factor is not None:
            return "positive semidefinite"
        return "symmetric" if self.symmetric else "general"

    def slack(self, z: npt.ArrayLike) -> FloatArray:
        """w = M z + q, shape (n,)."""
        return np.asarray(self.M @ point_of("z", z, self.size) + self.q)

    def _nearly_infeasible(self, u: FloatArray) -> bool:
        """Whether u (n,) is near to Farkas' vector: :func:`lcpflex.solvers.lcp.proofs.nearly_infeasible`."""
        return nearly_infeasible(*self._data, u)

    def exact_system(self) -> ExactSystem:
        """M and q in fractions."""
        return exact_rows(self.M, self.q)

    def residual(self, z: npt.ArrayLike, scaled: bool = True) -> float:
        """Natural-map residual of z (n,): dimensionless, or in the units of q if not scaled.

        See :func:`lcpflex.solvers.certificate.natural_residual`; scaled, it is that of :meth:`balanced`, the same in
        any units. inf for a z that holds NaN or inf. Raises ModelError if z has another shape.
        """
        point = point_of("z", z, self.size)
        if not flag("scaled", scaled):
            return float(residual_parts(*self._data, point, self.size)[0])
        return self.residuals(point)[0]


def _checked_factor(value: Any, M: FloatArray) -> FloatArray:
    """A read-only copy of J, if J J^T = M."""
    J = finite_array("factor", value, 2)
    if J.shape[0] != len(M):
        raise ModelError(f"factor has shape {J.shape}: expected ({len(M)}, k), one row for each row of M")
    with np.errstate(all="ignore"):
        difference = float(np.abs(J @ J.T - M).max(initial=0.0))
    if not difference <= 1e-8 * float(np.abs(M).max(initial=0.0)):
        raise ModelError(f"factor: factor @ factor.T differs from M by up to {difference:.3g}; expected M itself")
    J.flags.writeable = False
    return J
