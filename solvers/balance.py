"""Units in which the unknowns of a problem are alike: what a residual must be measured in to survive a change of units.

z -> d z, M -> d M d, q -> d q with d > 0 changes neither the sign of z or w nor what is complementary, and a change of
the units of mass, length or time is of this kind. So each contact is measured by its own diagonal,

    d_k = 1 / sqrt(D_k),  D_k = max(G_NN, G_TT)     (force and impulse; 1 / d_k for slip; cones as before)

and an LCP of which nothing else is known by the diagonal of M. The numbers that come out are the same for kilograms and
metres as for tonnes and millimetres, and so are the certificate, the path of an algorithm and the answer.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from lcpflex.jit.kernel import FloatArray, IntArray, kernel

__all__ = ["DEAD", "NOTHING", "Units", "contact_units", "in_units", "lcp_units", "unknown_units"]

DEAD = 1e-13  # of the largest diagonal: a contact with less joins two bodies that are held, what is left is rounding
NOTHING = 1e-31  # the same of a matrix that is given: its square root is the rounding of the rows that it is made of
SMALLEST, LARGEST = 1e-150, 1e150  # units: their products neither overflow nor vanish
EVEN = 16.0  # ratio of the diagonal entries of an LCP up to which all are in one unit
PEAK = 4.0  # entry, relative to those of the diagonal, from which the diagonal is no measure of its row
SWEEPS = 4  # that even out the largest entries where there is no diagonal, or it is small


class Units(NamedTuple):
    """z = d load z', w = w' load / d: how a problem in its own units is to be read in those of its user.

    By one after the other: their product, or their ratio, may vanish or be infinite where z or w is neither.
    """

    d: FloatArray  # (n,)
    load: float  # a power of two near the largest entry of q: the other one has that near 1, and never vanishes

    @classmethod
    def of(cls, d: FloatArray, q: FloatArray) -> Units:
        """The units d, and the load from the largest finite q."""
        largest = largest_entry(q)
        return cls(d, 2.0 ** (math.frexp(largest)[1] - 1) if 0.0 < largest < np.inf else 1.0)

    def inward(self, z: FloatArray) -> FloatArray:
        """z' of a point z."""
        with np.errstate(all="ignore"):  # what is not finite is judged so
            return np.asarray(z / self.load / self.d)

    def outward(self, z: FloatArray) -> FloatArray:
        """z of a point z'."""
        with np.errstate(all="ignore"):
            return np.asarray(z * self.d * self.load)

    def slack_inward(self, w: FloatArray) -> FloatArray:
        """w' of w = M z + q."""
        with np.errstate(all="ignore"):
            return np.asarray(w / self.load * self.d)

    def slack_outward(self, w: FloatArray) -> FloatArray:
        """w of w'."""
        with np.errstate(all="ignore"):
            return np.asarray(w / self.d * self.load)


@kernel
def largest_entry(q: FloatArray) -> float:
    """max |q_i|, NaN if one is no number."""
    largest = 0.0
    for i in range(len(q)):
        if not abs(q[i]) <= largest:
            largest = abs(q[i])
    return largest


@kernel
def contact_units(size: FloatArray, n: int, dead: float) -> None:
    """In place d_k = 1 / sqrt(D_k) from D_k = size[k] >= 0, k < n.

    A contact between two bodies that are held has D_k = 0 but for rounding, up to ``dead`` of the largest: it is
    measured in the unit of the contact that gives way most, which does not ask less of the others. Of a matrix that is
    given nobody knows what rounding made of it: a contact of a body 1e14 times heavier than another one is none.
    """
    largest = 0.0
    for k in range(n):
        if size[k] < np.inf:
            largest = max(largest, size[k])
    if largest == 0.0:
        largest = 1.0
    for k in range(n):
        own = size[k] if dead * largest < size[k] < np.inf else largest
        size[k] = min(max(1.0 / math.sqrt(own), SMALLEST), LARGEST)


@kernel
def unknown_units(units: FloatArray, tangent: IntArray, n_normal: int, n_tangent: int, d: FloatArray) -> None:
    """d (n_normal + 2 n_tangent,) of the three-unknown form from those of the contacts: forces, then slip."""
    for k in range(n_normal):
        d[k] = units[k]
    for j in range(n_tangent):
        d[n_normal + j] = units[tangent[j]]
        d[n_normal + n_tangent + j] = 1.0 / units[tangent[j]]


@kernel
def in_units(
    M: FloatArray, q: FloatArray, d: FloatArray, load: float, n: int, scaled: FloatArray, right: FloatArray
) -> None:
    """Out: scaled = d M d and right = d q / load, the leading n x n block and n entries; a symmetric M stays so."""
    for i in range(n):
        own, source, row = d[i], M[i], scaled[i]
        right[i] = own * (q[i] / load)
        for j in range(n):
            row[j] = source[j] * (own * d[j])


@kernel
def lcp_units(M: FloatArray, n: int, d: FloatArray) -> bool:
    """Out: d (n,) of an LCP of which nothing else is known. False where one unit will do, and d is not set.

    From the diagonal; an unknown without one takes the unit in which the largest entry that it shares with the others
    is 1. All steps but the clipping commute with a change of units.
    """
    low, high = np.inf, 0.0
    for i in range(n):
        low, high = min(low, abs(M[i, i])), max(high, abs(M[i, i]))
    if high <= EVEN * low and low > 1e-200 and high < 1e200:
        return False
    left = 0
    for i in range(n):
        d[i] = 0.0
        if M[i, i] != 0.0:
            d[i] = min(max(1.0 / math.sqrt(abs(M[i, i])), SMALLEST), LARGEST)
        else:
            left += 1
    while left > 0:  # layer by layer: the rows that share an entry with one whose unit is known
        found = 0
        for i in range(n):
            if d[i] == 0.0:
                shared = 0.0
                for j in range(n):
                    if d[j] > 0.0:
                        shared = max(shared, max(abs(M[i, j]), abs(M[j, i])) * d[j])
                if shared > 0.0:
                    d[i] = -min(max(1.0 / shared, SMALLEST), LARGEST)
                    found += 1
        for i in range(n):
            d[i] = abs(d[i])
        left -= found
        if found == 0:
            break
    if left > 0:
        _rest(n, d)
    for _ in range(SWEEPS):
        if not _even_out(M, n, d):
            break
    return True


@kernel
def _rest(n: int, d: FloatArray) -> None:
    """Rows that share nothing with a diagonal entry take the largest unit of the others, 1 if there is none."""
    largest = 0.0
    for i in range(n):
        largest = max(largest, d[i])
    for i in range(n):
        if d[i] == 0.0:
            d[i] = largest if largest > 0.0 else 1.0


@kernel
def _even_out(M: FloatArray, n: int, d: FloatArray) -> bool:
    """Divide d by the root of the largest entry of each row and column where that is far above 1; whether one was."""
    changed = False
    for i in range(n):
        peak = 0.0
        for j in range(n):
            peak = max(peak, max(abs(M[i, j]), abs(M[j, i])) * d[j])
        peak *= d[i]
        if PEAK < peak < np.inf:
            d[i] /= math.sqrt(peak)
            changed = True
    return changed
