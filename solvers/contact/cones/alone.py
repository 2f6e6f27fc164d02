"""Contacts in space that nothing else acts on: with friction each may have several solutions, which are told."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from lcpflex.jit.kernel import FloatArray
from lcpflex.solvers.acceptance import accept
from lcpflex.solvers.contact.cones.several import contact_solutions
from lcpflex.solvers.contact.matrices import as_dense
from lcpflex.solvers.contact.parts import part_of
from lcpflex.solvers.contact.spatial import SpatialContactProblem
from lcpflex.solvers.problem import Solution, Status

__all__ = ["is_unique", "told_apart"]

DEFINITE = 1e-10  # of the largest: a block with less in some direction is not taken for definite
LOOKED = 20  # contacts up to which those that nothing else acts on are asked for several solutions


def told_apart(problem: SpatialContactProblem, found: Solution, tolerance: float) -> Solution:
    """The same, and the other solutions, where a contact that nothing else acts on has several."""
    n = len(problem.friction)
    if not found.solved or not 0 < n <= LOOKED or found.status is Status.NOT_UNIQUE:
        return found
    several: list[FloatArray] = []
    for k in _alone(problem):
        own = part_of(problem, np.array([k]))
        if is_unique(own):
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


def is_unique(problem: SpatialContactProblem) -> bool:
    """Whether a single contact is known to have no second solution.

    r -> u + mu |u_T| n is strictly monotone where mu^2 max eig(W_TT) (W^-1)_NN < 1, since mu |W_T d| |d_N| < d.W d for
    all d then; and r.q >= 0 for all r in the cone leaves r = 0 alone where W is definite.
    """
    alike = problem.balanced()  # products of three entries neither overflow nor vanish
    W, q, mu = alike.dense(), alike.free, float(problem.friction[0])
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
