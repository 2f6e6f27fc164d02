"""The residual of a point whose terms are so large that floats lose w in their sum: in fractions, where w is not lost.

A nearly singular matrix has solutions 1e10 times its load. A residual in floats tells nothing of them, and is refused
(:func:`lcpflex.solvers.certificate.guarded_residual`); but some, as all in whole numbers, are floats that solve the
problem exactly.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from lcpflex.jit.kernel import FloatArray
from lcpflex.solvers.certificate import GUARD, ROUNDING, residual_parts, strict_residual
from lcpflex.solvers.lcp.exact_systems import fractions

if TYPE_CHECKING:
    from lcpflex.solvers.balance import Units
    from lcpflex.solvers.problem import Lcp

__all__ = ["residual_in_fractions"]

LARGEST = 48  # unknowns
LEFT = 8.0  # roundings of each term by which floats may be off from a solution


def residual_in_fractions(problem: Lcp, z: FloatArray) -> tuple[FloatArray, float] | None:
    """w (n,) of z (n,), rounded once, and its residual relative to q alone: nothing is left of rounding to forgive.

    In the units of the problem, the larger one where it counts in two. None where floats tell enough, be it that z is
    no solution, and where there are more than 48 unknowns.
    """
    if problem.size > LARGEST or not _lost(problem, z):
        return None
    point = fractions(z.tolist())
    w = np.empty(problem.size)
    try:
        for i, (*row, q) in enumerate(problem.exact_system().rows(range(problem.size))):
            w[i] = float(sum((a * x for a, x in zip(row, point, strict=True) if a and x), q))
    except OverflowError:
        return None
    return w, max(_against_load(*measured, z, w) for measured in problem.measures())


def _lost(problem: Lcp, z: FloatArray) -> bool:
    """Whether z may be a solution as far as floats can tell, which is not far enough."""
    for M, q, units in problem.measures():
        worst, size, load = residual_parts(M, q, z if units is None else units.inward(z), len(z))
        if not worst <= LEFT * len(z) * ROUNDING * size < np.inf:
            return False
        if ROUNDING * size > GUARD * load > 0.0:
            return True
    return False


def _against_load(M: FloatArray, q: FloatArray, units: Units | None, z: FloatArray, w: FloatArray) -> float:
    """max_i |min(d_i z_i, w_i)| / max_i |q_i| in these units, d_i the largest |M_ij|, 1 in a row of zeros."""
    if units is not None:
        z, w = units.inward(z), w * (units.d / units.load)
    rows = np.abs(M).max(axis=1)
    worst = np.abs(np.minimum(np.where(rows > 0.0, rows, 1.0) * z, w)).max()
    return float(strict_residual(worst, np.abs(q).max()))
