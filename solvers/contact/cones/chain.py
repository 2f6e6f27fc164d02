"""Contact in space by all that is known for it, one after the other: what :class:`lcpflex.solvers.Auto` does with it.

Sweeps contact by contact, from the forces of the last problem; where a few of them do not do, the independent parts one
by one, each by the attempts of :class:`AlartCurnier`. Each answer is judged; the best point is kept, and the route
tells who gave it and who failed before. Convex programs and faceted cones are rivals for
:func:`lcpflex.solvers.cross_check` alone: no problem is known that needs them.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np

from lcpflex.jit.kernel import FloatArray
from lcpflex.solvers.clock import expired, out_of_time
from lcpflex.solvers.contact.block_gauss_seidel import BlockGaussSeidel
from lcpflex.solvers.contact.cones.parts import part_of, solved_by_parts
from lcpflex.solvers.contact.cones.several import contact_solutions
from lcpflex.solvers.contact.cones.solver import AlartCurnier
from lcpflex.solvers.contact.matrices import as_dense
from lcpflex.solvers.contact.spatial import SpatialContactProblem
from lcpflex.solvers.contact.starts import started
from lcpflex.solvers.guard import ENDED, guarded, joined
from lcpflex.solvers.problem import Solution, Status, accept

__all__ = ["solved_in_cones"]

FEW = 100  # sweeps over the whole, and over each part
NEWTON, TRIALS = "Alart-Curnier Newton", 2
DEFINITE = 1e-10  # of the largest: a block with less in some direction is not taken for definite
LOOKED = 20  # contacts up to which those that nothing else acts on are asked for several solutions


def solved_in_cones(problem: SpatialContactProblem, guess: Solution | None, tolerance: float) -> Solution:
    """The certified solution, or the best point of the whole chain with the reason why it is none.

    guess: the solution of a similar problem, matched by contact, or None. tolerance: largest accepted residual.
    """
    with np.errstate(all="ignore"):  # what overflows is not finite, and is not called solved
        found = _start(problem, guess, tolerance)
        if not found.solved:
            found = _swept(problem, found, tolerance)
        if not found.solved and not out_of_time():
            found = _further(problem, found, tolerance)
        return replace(_told_apart(problem, found, tolerance), keys=problem.unknown_keys)


def _start(problem: SpatialContactProblem, guess: Solution | None, tolerance: float) -> Solution:
    """The forces of the guess where they are better than none, judged."""
    point = started(guess, problem.unknown_keys)
    none = accept(problem, np.zeros(problem.size), tolerance=tolerance, route="no forces")
    if point is None:
        return none
    known = accept(problem, point, tolerance=tolerance, route="forces of the guess")
    return known if known.residual < none.residual else none


def _swept(problem: SpatialContactProblem, start: Solution, tolerance: float) -> Solution:
    return BlockGaussSeidel(tolerance, FEW).solve(problem, replace(start, keys=problem.unknown_keys))


def _further(problem: SpatialContactProblem, first: Solution, tolerance: float) -> Solution:
    """After a few sweeps over the whole, each of its parts by itself."""
    apart = solved_by_parts(problem, first.z, tolerance, lambda part, z: _part(part, z, tolerance))
    if apart is None:
        return _descended(problem, first, tolerance)
    route, iterations = f"{joined(first)} > {apart.route}", first.iterations + apart.iterations
    if not apart.solved and first.residual < apart.residual:
        return replace(apart, z=first.z, w=first.w, residual=first.residual, strict=first.strict, route=route)
    return replace(apart, route=route, iterations=iterations)


def _part(part: SpatialContactProblem, start: FloatArray, tolerance: float) -> Solution:
    """Contacts that do not fall into parts."""
    first = accept(part, start, tolerance=tolerance, route="sweeps over the whole")
    if not first.solved:
        first = _swept(part, first, tolerance)
    return first if first.solved else _descended(part, first, tolerance)


def _descended(problem: SpatialContactProblem, first: Solution, tolerance: float) -> Solution:
    """Newton's method from the best point so far, until that solves the problem; else the best point, and why.

    A second time, too: it begins from another point then.
    """
    newton, best, tried = AlartCurnier(tolerance), first, [first]
    while len(tried) <= TRIALS and not best.solved and not out_of_time():
        start = replace(best, keys=problem.unknown_keys)
        found = guarded(NEWTON, problem, tolerance, partial(newton.solve, problem, start))
        tried.append(found)
        if found.residual < best.residual or found.solved:
            best = found
    route, iterations = joined(*tried), sum(found.iterations for found in tried)
    told = replace(best, route=route, iterations=iterations)
    if best.solved:
        return told
    if out_of_time():
        return expired(told)
    reasons = [f"{best.message or best.status.name.lower()}; nothing of {len(tried)} methods found a solution"]
    reasons += [found.message for found in tried if ENDED in found.message]
    return replace(told, message="; ".join(dict.fromkeys(reasons)))


def _told_apart(problem: SpatialContactProblem, found: Solution, tolerance: float) -> Solution:
    """The same, and the other solutions, where a contact that nothing else acts on has several."""
    n = len(problem.friction)
    if not found.solved or not 0 < n <= LOOKED or found.status is Status.NOT_UNIQUE:
        return found
    several: list[FloatArray] = []
    for k in _alone(problem):
        own = part_of(problem, np.array([k]))
        if _is_unique(own):
            continue
        others = _of_one(own, tolerance)
        for forces in others if len(others) > 1 else ():
            several.append(found.z.copy())
            several[-1][3 * k : 3 * k + 3] = forces
    if not several:
        return found
    told = accept(problem, found.z, tolerance=tolerance, route=found.route, solutions=tuple(several))
    message = f"{len(several)} solutions are known: contacts that act on none have several" if told.solved else ""
    return replace(told, iterations=found.iterations, message=message)


def _alone(problem: SpatialContactProblem) -> list[int]:
    """The contacts that nothing else acts on."""
    matrix, n = problem.matrix(), len(problem.friction)
    if matrix is None:
        return []
    acts = np.abs(as_dense(matrix)).reshape(n, 3, n, 3).max(axis=(1, 3)) > 0.0
    acts |= acts.T
    np.fill_diagonal(acts, val=False)
    return [int(k) for k in np.flatnonzero(~acts.any(axis=1))]


def _is_unique(problem: SpatialContactProblem) -> bool:
    """Whether a single contact is known to have no second solution.

    r -> u + mu |u_T| n is strictly monotone where mu^2 max eig(W_TT) (W^-1)_NN < 1, since mu |W_T d| |d_N| < d.W d for
    all d then; and r.q >= 0 for all r in the cone leaves r = 0 alone where W is definite.
    """
    W, q, mu = problem.dense(), problem.free, float(problem.friction[0])
    if mu == 0.0:
        return True
    if not problem.symmetric:
        return False
    spread = np.hypot(0.5 * (W[1, 1] - W[2, 2]), W[1, 2])
    stiffest, softest = 0.5 * (W[1, 1] + W[2, 2]) + spread, 0.5 * (W[1, 1] + W[2, 2]) - spread
    if not softest > DEFINITE * stiffest:
        return False
    determinant = W[1, 1] * W[2, 2] - W[1, 2] ** 2
    taken = W[0, 1] ** 2 * W[2, 2] - 2.0 * W[0, 1] * W[0, 2] * W[1, 2] + W[0, 2] ** 2 * W[1, 1]
    pivot = W[0, 0] - taken / determinant  # 1 / (W^-1)_NN
    return bool(pivot > DEFINITE * W[0, 0] and (mu * mu * stiffest < pivot or q[0] >= mu * np.hypot(q[1], q[2])))


def _of_one(problem: SpatialContactProblem, tolerance: float) -> list[FloatArray]:
    """All solutions of a single contact that are within the tolerance."""
    alike, units = problem.balanced(), problem.unknown_units
    try:
        points = contact_solutions(alike.dense(), alike.free, float(alike.friction[0]))
    except np.linalg.LinAlgError:  # numbers that overflow in the quartic
        return []
    return [z for z in (units.outward(point) for point in points) if problem.residual(z) <= tolerance]
