"""Linear complementarity problems, what a solution of one is, and the only door through which a solver may claim one.

0 <= z  _|_  w = M z + q >= 0                                                    (Cottle, Pang & Stone)
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from lcpflex.basics.arguments import FLOAT, flag, point_of
from lcpflex.errors import ModelError, shown
from lcpflex.jit.kernel import FloatArray, IntArray
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
from lcpflex.solvers.claims import check_claim, check_vectors
from lcpflex.solvers.lcp.exact_residual import Contacts, own_parts, residual_in_fractions
from lcpflex.solvers.lcp.exact_signs import is_wide, off_in_fractions
from lcpflex.solvers.lcp.exact_systems import ExactSystem, exact_rows
from lcpflex.solvers.lcp.proofs import Proof, exact_solution, infeasibility, nearly_infeasible
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
    "brought_back",
    "confirmed",
    "restored",
    "retold",
]

NEARLY = (
    "nearly infeasible: a vector u fulfils M^T u <= 0 and q.u < 0 to rounding, but none is known that does so exactly"
)

NEAR = (Status.INACCURATE, Status.RIGHT_TO_TERMS)  # what a point is, whatever ended the algorithm
FAILURES = (Status.RAY, Status.ITERATION_LIMIT, Status.NUMERICAL_FAILURE, Status.TIME_LIMIT)  # what ends one
ROUNDED = "numerical failure: {} has no solution, but its rounding may be the reason"


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


def accept(
    problem: Problem,
    z: npt.ArrayLike,
    *,
    tolerance: float,
    status: Status = Status.SOLVED,
    iterations: int = 0,
    route: str = "",
    message: str = "",
    active: IntArray | None = None,
    certificate: FloatArray | None = None,
    solutions: tuple[FloatArray, ...] = (),
    proof: Proof | None = None,
) -> Solution:
    """Judge a point on the original data: the one exit of every solver.

    z (n,): the point; status: what the algorithm believes; its word counts only for *why* it failed. SOLVED is granted
    if and only if the residual is within the tolerance; NOT_UNIQUE only if that holds for at least two ``solutions``
    that differ; INFEASIBLE and NO_SOLUTION only with a ``proof`` about this problem, the former also where the
    ``certificate`` u (n,) of an :class:`Lcp` is, or leads to, one that holds in exact arithmetic. Raises ModelError for
    arguments of other kinds.

    iterations, route, message, active: as the :class:`Solution` keeps them, which also keeps the status as ``ended``.
    """
    check_claim(problem, tolerance, iterations, status, route, message, proof)
    point = as_array("z", z, 1)
    if type(solutions) is not tuple or solutions or active is not None or certificate is not None:
        check_vectors(len(point), solutions, active=active, certificate=certificate)
    w, residual, strict = _judged(problem, point)
    if residual <= tolerance:
        judged, proof = Status.SOLVED, None
        if solutions and _differ(problem, solutions, tolerance):
            judged = Status.NOT_UNIQUE
    else:
        near = certificate is not None and type(problem) is Lcp and nearly_infeasible(*problem._data, certificate)
        if proof is None and near:
            proof = infeasibility(problem, certificate)
        judged = _why_not(problem, residual, tolerance, status, proof)
        where = "" if judged in PROVED else _right_to_terms(problem, point, residual, tolerance)
        if where:
            judged, message = Status.RIGHT_TO_TERMS, where
        if not message or judged in PROVED:
            grounds = _grounds(judged, residual, tolerance) + (f"; {NEARLY}" if near and judged not in PROVED else "")
            message = f"{judged.words}: {grounds}"
    u, vector = (None, ()) if proof is None or judged not in PROVED else (proof.certificate, proof.vector)
    ended = status if judged in NEAR and status in FAILURES else None
    return Solution(
        point, w, judged, residual, iterations, route, message, active, u, None, solutions, vector, strict, ended
    )


def _right_to_terms(problem: Problem, point: FloatArray, residual: float, tolerance: float) -> str:
    """Which contact is right to its terms only, and how much of its own load that leaves; empty if that is not so."""
    if not (residual < np.inf and hasattr(problem, "by_terms")):
        return ""
    terms, worst = problem.by_terms(point)
    if not terms <= tolerance:
        return ""
    return (
        f"right to its terms only: {worst} has up to {residual:.1e} of its own load left, {terms:.1e} of the terms "
        "that cancel in it; its numbers are too far apart for more"
    )


def retold(problem: Problem, z: FloatArray, found: Solution, tolerance: float, **changed: Any) -> Solution:
    """The point z judged on ``problem``, with what ``found`` tells of how it was found.

    changed: arguments of :func:`accept` that are not those of ``found``.
    """
    kept = {name: getattr(found, name) for name in ("iterations", "route", "message", "active", "solutions")}
    kept["status"] = found.status if found.ended is None else found.ended
    return accept(problem, z, tolerance=tolerance, **(kept | changed))


def brought_back(
    problem: Problem, found: Solution, outward: Callable[[FloatArray], FloatArray], tolerance: float, **changed: Any
) -> Solution:
    """A solution of a problem made of ``problem``, its points brought back by ``outward`` and judged on ``problem``.

    changed: arguments of :func:`accept` that are not those of ``found``.
    """
    points = tuple([outward(one) for one in found.solutions])
    return retold(problem, outward(found.z), found, tolerance, **({"solutions": points} | changed))


def restored(problem: Problem, found: Solution, units: Units, tolerance: float) -> Solution:
    """A solution of the same problem in other units, brought to those of ``problem`` and judged there.

    Other units round the numbers: that there is no solution must be proved once more, by the numbers of ``problem``.
    """
    unproved = ROUNDED.format("the problem in units in which its unknowns are alike")
    told = brought_back(
        problem,
        found,
        units.outward,
        tolerance,
        message="" if found.solved else unproved if found.status in PROVED else found.message,
        certificate=None if found.certificate is None else found.certificate * units.d,
        proof=exact_solution(problem)[0] if found.status is Status.NO_SOLUTION else None,
    )
    return told if found.keys is None else replace(told, keys=found.keys)


def _judged(problem: Problem, point: FloatArray) -> tuple[FloatArray, float, float]:
    """w, and the residual in its two sizes; NaN for the second where a problem does not tell it."""
    if hasattr(problem, "judged"):
        told: tuple[FloatArray, float, float] = problem.judged(point)
        return told
    with np.errstate(all="ignore"):
        if hasattr(problem, "residuals"):
            residual, strict = problem.residuals(point)
        else:
            residual, strict = problem.residual(point), math.nan
        return problem.slack(point), residual, strict


def _grounds(status: Status, residual: float, tolerance: float) -> str:
    """What the verdict rests on."""
    if status is Status.INFEASIBLE:
        return "no z >= 0 has M z + q >= 0, as the certificate u proves: u >= 0, M^T u <= 0, q.u < 0"
    if status is Status.NO_SOLUTION:
        return "each of all active sets was refuted in exact arithmetic"
    return f"residual {residual:.1e}, tolerance {tolerance:.1e}"


def _why_not(problem: Problem, residual: float, tolerance: float, status: Status, proof: Proof | None) -> Status:
    """The status of a point that does not solve the problem."""
    if proof is not None and proof.problem is problem:
        return Status.INFEASIBLE if proof.vector else Status.NO_SOLUTION
    if status is Status.TIME_LIMIT:
        return status
    if residual <= 1e3 * tolerance:
        return Status.INACCURATE
    if status in (Status.RAY, Status.ITERATION_LIMIT, Status.WRONG):
        return status
    return Status.NUMERICAL_FAILURE


def confirmed(problem: Problem, found: Solution) -> Solution:
    """A proof about the LCP of ``problem`` as one about the problem, from whose numbers rounding has made the LCP.

    Where it does not hold for the problem too, the status is NUMERICAL_FAILURE.
    """
    if found.status not in PROVED:
        return found
    if found.status is Status.INFEASIBLE:
        proof = infeasibility(problem, found.certificate)
    else:
        proof = exact_solution(problem)[0]
    if proof is not None and bool(proof.vector) == (found.status is Status.INFEASIBLE):
        return replace(found, proof=proof.vector)
    message = ROUNDED.format("the LCP made of the problem")
    return replace(found, status=Status.NUMERICAL_FAILURE, message=message, certificate=None, proof=())


def _differ(problem: Problem, solutions: tuple[FloatArray, ...], tolerance: float) -> bool:
    """Whether at least two of the points are solutions, and not the same one."""
    good = [z for z in solutions if problem.residual(z) <= tolerance]
    return any(np.abs(z - good[0]).max() > 1e-6 * max(np.abs(z).max(), np.abs(good[0]).max()) for z in good[1:])


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
