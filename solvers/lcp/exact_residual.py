"""The residual of a point whose terms are so large that floats lose w in their sum: in fractions, where w is not lost.

A nearly singular matrix has solutions 1e10 times its load. A residual in floats tells nothing of them, and is refused
(:func:`lcpflex.solvers.certificate.guarded_residual`); but some, as all in whole numbers, are floats that solve the
problem exactly.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.solvers.certificate import GUARD, ROUNDING, own_load
from lcpflex.solvers.lcp.exact_systems import fractions

if TYPE_CHECKING:
    from lcpflex.solvers.problem import Lcp

__all__ = ["Contacts", "OwnParts", "largest_of_each", "own_parts", "residual_in_fractions"]

LARGEST = 48  # unknowns
LEFT = 8.0  # roundings of each term by which floats may be off from a solution


Contacts = tuple[int, IntArray]  # their number, and the contact of each tangential row


class OwnParts(NamedTuple):
    """Of each contact, or of each row (n_units,): what it misses, the size of its terms, and what it is measured by."""

    miss: FloatArray
    terms: FloatArray
    own: FloatArray


def own_parts(data: tuple[FloatArray, FloatArray], z: FloatArray, w: FloatArray, contacts: Contacts | None) -> OwnParts:
    """What :func:`lcpflex.solvers.certificate.measured` is told of a point z (n,) whose w (n,) is known.

    data: M and q in the units in which this counts; contacts: ``Lcp.contacts``, None where each row stands for itself.
    """
    M, q = data
    sizes = np.abs(M)
    rows, load = sizes.max(axis=1, initial=0.0), np.abs(q)
    terms = sizes @ np.abs(z) + load
    miss = np.abs(np.minimum(np.where(rows > 0.0, rows, 1.0) * z, w))
    if contacts is not None:
        miss, terms, load = (largest_of_each(values, *contacts) for values in (miss, terms, load))
    largest = float(load.max(initial=0.0))
    own = [own_load(*each, largest) for each in zip(terms.tolist(), load.tolist(), strict=True)]
    return OwnParts(miss, terms, np.array(own))


def largest_of_each(values: FloatArray, count: int, tangent: IntArray) -> FloatArray:
    """The largest of the rows of each of ``count`` contacts: its normal and, block by block, those of its tangent."""
    largest = values[:count].copy()
    for first in range(count, len(values), max(len(tangent), 1)):
        largest[tangent] = np.maximum(largest[tangent], values[first : first + len(tangent)])
    return largest


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
    worst = 0.0
    for M, right, units, contacts in problem.measures():
        inward = (z, w) if units is None else (units.inward(z), units.slack_inward(w))
        miss, _, own = own_parts((M, right), *inward, contacts)
        with np.errstate(all="ignore"):
            worst = max(worst, float(np.where(miss > 0.0, miss / own, 0.0).max(initial=0.0)))
    return w, worst


def _lost(problem: Lcp, z: FloatArray) -> bool:
    """Whether z may be a solution as far as floats can tell, which is not far enough."""
    lost = False
    with np.errstate(all="ignore"):
        for M, q, units, contacts in problem.measures():
            point = z if units is None else units.inward(z)
            miss, terms, own = own_parts((M, q), point, M @ point + q, contacts)
            if not (miss <= LEFT * len(z) * ROUNDING * terms).all() or not (terms < np.inf).all():
                return False
            lost = lost or bool((ROUNDING * terms > GUARD * own).any())
    return lost
