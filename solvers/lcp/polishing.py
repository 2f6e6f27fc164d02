"""From a near-solution of a convex quadratic program with bounds to its exact one, by its active set.

min 1/2 z.M z + q.z, lower <= z <= upper: backends stop near 1e-8, but which unknowns lie between their bounds is known
by then. On these w = M z + q = 0 is solved, the others are put on their bounds, and where that shows the set to be
wrong it is corrected: the primal-dual active set method (Hintermueller, Ito & Kunisch 2003).
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from lcpflex.jit.kernel import FloatArray, IntArray

__all__ = ["equilibrium", "polish", "shortest"]

POLISHING = 10  # corrections on the active set: one to three suffice when the backend came near
EXACT = 1e-14  # w on the active set that is rounding, relative to the terms it is made of
RANK = 1e-12  # eigenvalue of M_AA, relative to the largest, below which contacts are redundant


def polish(
    M: FloatArray,
    q: FloatArray,
    z: FloatArray,
    w: FloatArray | None = None,
    lower: npt.ArrayLike = 0.0,
    upper: npt.ArrayLike = np.inf,
) -> FloatArray:
    """Solve on the set lower < z - w < upper of a near-solution, for a few corrections of that set.

    M (n, n), q (n,): symmetric positive semidefinite, with a diagonal near 1; lower, upper (n,) or numbers: the bounds,
    those of an LCP if left out; z (n,) within them; w (n,): M z + q if left out. Redundant contacts share their load as
    z does: the equations are solved with the least change of z.
    """
    low, high = np.broadcast_to(lower, z.shape), np.broadcast_to(upper, z.shape)
    best, least, solved = z, _violation(M, q, z, low, high), None
    for _ in range(POLISHING):
        target = z - (M @ z + q if w is None else w)
        place = (target > low).astype(np.int64) + (target >= high)
        if solved is not None and np.array_equal(place, solved):
            break
        active = np.flatnonzero(place == 1)
        trial = equilibrium(M, q, z, active, np.where(place == 0, low, high))
        z, w, solved = _yielding(M, q, trial, active, low, high), None, place
        point = np.minimum(np.maximum(z, low), high)
        violation = _violation(M, q, point, low, high)
        if violation < least:
            best, least = point, violation
    return best


def equilibrium(
    M: FloatArray, q: FloatArray, z: FloatArray, active: IntArray, elsewhere: FloatArray | None = None
) -> FloatArray:
    """w = 0 on the active set and z = ``elsewhere`` (n,), or 0, off it, by the least change of z (n,)."""
    trial = np.zeros_like(z) if elsewhere is None else elsewhere.copy()
    trial[active] = z[active]
    block = M[np.ix_(active, active)]
    if not active.size or not np.isfinite(block).all():
        return trial
    values, vectors = np.linalg.eigh(block)
    kept = values > RANK * values[-1]
    inverse = vectors[:, kept] / values[kept]
    for _ in range(2):  # the second pass takes out the rounding of the first
        trial[active] -= inverse @ (vectors[:, kept].T @ (M @ trial + q)[active])
    return trial


def shortest(M: FloatArray, z: FloatArray, free: npt.NDArray[np.bool_]) -> FloatArray:
    """The same w = M z + q with the shortest z (n,) on the ``free`` unknowns: M (n, n) positive semidefinite.

    A z_F with M_FF z_F = 0 moves no w at all, M being semidefinite.
    """
    if not free.any():
        return z
    values, vectors = np.linalg.eigh(M[np.ix_(free, free)])
    idle = vectors[:, values <= RANK * values[-1]]
    short = z.copy()
    short[free] -= idle @ (idle.T @ z[free])
    return short


def _yielding(
    M: FloatArray, q: FloatArray, z: FloatArray, active: IntArray, lower: FloatArray, upper: FloatArray
) -> FloatArray:
    """z, unless w = 0 contradicts itself on the active set: then further, until one unknown of it is on its bound.

    What is left of w on A after least squares is a direction in which M_AA z stays and the objective falls.
    """
    rest = np.zeros_like(z)
    rest[active] = (M @ z + q)[active]
    if not np.abs(rest).max(initial=0.0) > EXACT * (1.0 + np.abs(z).sum()):
        return z
    room = np.where(rest > 0.0, z - lower, upper - z)
    falling = np.flatnonzero((rest != 0.0) & (room > 0.0) & np.isfinite(room))
    if not falling.size:
        return z
    steps = room[falling] / np.abs(rest[falling])
    first = falling[int(np.argmin(steps))]
    bound = lower[first] if rest[first] > 0.0 else upper[first]
    z = z - steps.min() * rest
    z[first] = bound
    return z


def _violation(M: FloatArray, q: FloatArray, z: FloatArray, lower: FloatArray, upper: FloatArray) -> float:
    """Largest entry of |z - mid(lower, z - w, upper)|, |min(z, w)| for an LCP; inf if it is not a number."""
    off = np.maximum(np.minimum(z - lower, M @ z + q), z - upper)
    violation = float(np.abs(off).max())
    return violation if math.isfinite(violation) else math.inf
