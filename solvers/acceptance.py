"""The only door through which a solver may claim a solution: points and proofs are judged on the original data."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.solvers.arrays import as_array
from lcpflex.solvers.balance import Units
from lcpflex.solvers.claims import check_claim, check_vectors
from lcpflex.solvers.lcp.proofs import NEARLY, Proof, exact_solution, infeasibility
from lcpflex.solvers.solution import PROVED, Problem, Solution
from lcpflex.solvers.status import Status

__all__ = ["accept", "brought_back", "confirmed", "restored", "retold"]

NEAR = (Status.INACCURATE, Status.RIGHT_TO_TERMS)  # what a point is, whatever ended the algorithm
FAILURES = (Status.RAY, Status.ITERATION_LIMIT, Status.NUMERICAL_FAILURE, Status.TIME_LIMIT)  # what ends one
ROUNDED = "numerical failure: {} has no solution, but its rounding may be the reason"


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
        near = certificate is not None and _nearly_infeasible(problem, certificate)
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


def _nearly_infeasible(problem: Problem, u: FloatArray) -> bool:
    """Whether u is worth a look in fractions: of an LCP alone."""
    return hasattr(problem, "_nearly_infeasible") and bool(problem._nearly_infeasible(u))


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
