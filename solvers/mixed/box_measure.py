"""How a boxed problem is measured, whatever its units and however far its bounds; and its answers on an active set.

Only the point of a box that is nearest to zero is load: a bound that no unknown reaches changes no answer, and must not
change what counts as an error either. Brought to an LCP, the problem is shifted by its bounds, and far ones round q
away; on the set of unknowns between their bounds, z is found without that shift.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from lcpflex.jit.kernel import FloatArray
from lcpflex.solvers.balance import Units, in_units, lcp_units
from lcpflex.solvers.certificate import all_finite, is_symmetric
from lcpflex.solvers.mixed.boxes import box_parts, box_sizes

__all__ = ["BoxMeasure"]

POLISHING = 12  # corrections of the active set
RANK = 1e-12  # singular value of the equations of the active set, relative, below which unknowns share their load
FAR = 1e6  # bound, relative to the load, that hardly any solution reaches
BELOW, WITHIN, ABOVE = 0, 1, 2

Box = tuple[FloatArray, FloatArray, FloatArray, FloatArray]


class BoxMeasure(NamedTuple):
    """A box in units in which its unknowns are alike.

    data: M, q, lower, upper in these units; unit (n,): z = unit z'; both: whether the problem is measured as it is,
    too, as an Lcp whose M is not symmetric.
    """

    given: Box
    data: Box
    unit: FloatArray
    both: bool

    @classmethod
    def of(cls, given: Box, alike: bool) -> BoxMeasure:
        """The units of the diagonal as for an LCP; ``alike``: it is known that one unit will do."""
        M, q, lower, upper = given
        n = len(q)
        d, one = np.empty(n), np.ones(n)
        if alike or not lcp_units(M, n, d):
            return cls(given, given, one, False)
        units = Units.of(d, q)
        scaled, right = np.empty((n, n)), np.empty(n)
        in_units(M, q, *units, n, scaled, right)
        unit = units.outward(one)
        if not (all_finite(scaled, right) and np.isfinite(unit).all() and (unit > 0.0).all()):
            return cls(given, given, one, False)
        with np.errstate(all="ignore"):  # a bound beyond all numbers is none
            data = scaled, right, lower / unit, upper / unit
        return cls(given, data, unit, not is_symmetric(M, n))

    def residuals(self, z: FloatArray) -> tuple[float, float]:
        """The residual of z (n,) in the two sizes of a Solution."""
        with np.errstate(all="ignore"):
            residual, strict = box_sizes(*self.data, z / self.unit, np.empty(len(z)))
        if self.both:
            raw = box_sizes(*self.given, z, np.empty(len(z)))
            return max(residual, raw[0]), max(strict, raw[1])
        return residual, strict

    @property
    def rest(self) -> FloatArray:
        """The point (n,) of the box that is nearest to zero."""
        return np.clip(np.zeros(len(self.unit)), self.given[2], self.given[3])

    def within_near_bounds(self) -> tuple[FloatArray, FloatArray]:
        """The bounds (n,) of the problem, infinite where they are far beyond q and the bounds that keep z from 0."""
        M, q, lower, upper = self.data
        d = _rows(M)
        load = max(float(np.abs(q).max(initial=0.0)), float((d * np.abs(self.rest / self.unit)).max(initial=0.0)))
        low = np.where(d * np.abs(lower) > FAR * load, -np.inf, self.given[2])
        return low, np.where(d * np.abs(upper) > FAR * load, np.inf, self.given[3])

    def polished(self, z: FloatArray) -> FloatArray:
        """Solve w = 0 on the set lower < z - w / d < upper of a near-solution, the others on their bounds.

        z (n,). A few corrections of that set, the best point of all; z itself if none is better. Any M: the primal-dual
        active set method where M is monotone (Hintermueller, Ito & Kunisch 2003), a semismooth Newton method elsewhere.
        """
        M, q, lower, upper = self.data
        best, w, d = z, np.empty(len(z)), _rows(M)
        with np.errstate(all="ignore"):
            point, before = z / self.unit, None
            least = box_parts(*self.data, point, w)[0]
            for _ in range(POLISHING):
                target = point - (M @ point + q) / d
                place = np.where(target <= lower, BELOW, np.where(target >= upper, ABOVE, WITHIN))
                if not np.isfinite(target).all() or (before is not None and np.array_equal(place, before)):
                    break
                before, ends = place, np.where(place == BELOW, lower, upper)
                point = _equilibrium(M, q, np.where(place == WITHIN, point, ends), place == WITHIN)
                worst = box_parts(*self.data, np.clip(point, lower, upper), w)[0]
                if worst < least:
                    best, least = self._outward(point, place), worst
        return best

    def _outward(self, point: FloatArray, place: npt.NDArray[np.int64]) -> FloatArray:
        """The point in the units of the problem, on its bounds exactly where it is on them here."""
        lower, upper = self.given[2], self.given[3]
        z = np.where(place == BELOW, lower, np.where(place == ABOVE, upper, self.unit * point))
        return np.asarray(np.clip(z, lower, upper))


def _rows(M: FloatArray) -> FloatArray:
    """The largest |M_ij| of each row, 1 for a zero row."""
    largest = np.abs(M).max(axis=1, initial=0.0)
    return np.where(largest > 0.0, largest, 1.0)


def _equilibrium(M: FloatArray, q: FloatArray, z: FloatArray, active: npt.NDArray[np.bool_]) -> FloatArray:
    """w = 0 on the active set by the least change of z (n,) there."""
    block = M[np.ix_(active, active)]
    if active.any() and np.isfinite(block).all():
        for _ in range(3):  # the second and third pass take out the rounding of the first
            left = (M @ z + q)[active]
            if not np.isfinite(left).all():
                break
            try:
                z[active] -= np.linalg.lstsq(block, left, rcond=RANK)[0]
            except np.linalg.LinAlgError:
                break
    return z
