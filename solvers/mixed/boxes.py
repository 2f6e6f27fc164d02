"""Compiled ways between a boxed problem and its LCP, and its residual: see :mod:`lcpflex.solvers.mixed.problems`."""

from __future__ import annotations

import numpy as np

from lcpflex.jit.kernel import FloatArray, IntArray, kernel
from lcpflex.solvers.balance import EVEN
from lcpflex.solvers.certificate import ROUNDING, guarded_residual, measured, strict_residual, worse

__all__ = [
    "CANCELLED",
    "DOUBLE",
    "FREE",
    "SINGLE",
    "box_parts",
    "box_sizes",
    "on_bounds",
    "recover_box",
    "reduce_box",
    "sound_box",
]

FREE, SINGLE, DOUBLE = 0, 1, 2  # bounds of an unknown
CANCELLED = 1e-13  # part of its terms below which a sum is rounding
REGULAR = 1e-6  # pivot of the scaled bilateral rows below which their rank is looked at more closely
LARGE = 60  # bilateral rows beyond which they are left to the libraries of numpy
NEAR = 16.0  # ratio to 1 up to which diagonal entries are near it
TINY, HUGE = 1e-200, 1e200  # diagonal entries that units are never made of
CLEAR = 1e-6  # part of its terms above which the sign of w is beyond doubt
CLOSE = 1e-9  # part of the load beyond which large terms are no excuse for a residual
BESIDE = 1e-12  # part of the width of a box by which an unknown is not on its bound
SYMMETRIC = 1e-12  # |M_ij - M_ji| relative to M_ij, of a matrix that stays symmetric


@kernel
def sound_box(M: FloatArray, q: FloatArray, lower: FloatArray, upper: FloatArray) -> tuple[int, int, int]:
    """How many unknowns have a bound, and two, and whether all are alike (1) by the diagonal of M; -1 where M (n, n) or
    q (n,) is not finite, or bounds (n,) are none.
    """
    total, bounded, double, low, high = 0.0, 0, 0, np.inf, 0.0
    for i in range(len(q)):
        for j in range(len(q)):
            total += 0.0 * M[i, j]
        total += 0.0 * q[i]
        if not (lower[i] <= upper[i] and lower[i] < np.inf and upper[i] > -np.inf):
            return -1, -1, -1
        below, above = lower[i] > -np.inf, upper[i] < np.inf
        bounded += 1 if below or above else 0
        double += 1 if below and above else 0
        low, high = min(low, abs(M[i, i])), max(high, abs(M[i, i]))
    if total != 0.0:
        return -1, -1, -1
    return bounded, double, 1 if high <= EVEN * low and low > TINY and high < HUGE else 0


@kernel
def _invert(block: FloatArray, inverse: FloatArray, n: int) -> bool:
    """The inverse of the leading block by elimination with row pivots; False where a pivot is below REGULAR."""
    for i in range(n):
        for j in range(n):
            inverse[i, j] = 1.0 if i == j else 0.0
    for k in range(n):
        r = k
        for i in range(k + 1, n):
            if abs(block[i, k]) > abs(block[r, k]):
                r = i
        if not abs(block[r, k]) > REGULAR:
            return False
        if r != k:
            for j in range(n):
                block[k, j], block[r, j] = block[r, j], block[k, j]
                inverse[k, j], inverse[r, j] = inverse[r, j], inverse[k, j]
        lift = 1.0 / block[k, k]
        for j in range(n):
            block[k, j] *= lift
            inverse[k, j] *= lift
        for i in range(n):
            factor = block[i, k]
            if i != k and factor != 0.0:
                for j in range(n):
                    block[i, j] -= factor * block[k, j]
                    inverse[i, j] -= factor * inverse[k, j]
    return True


@kernel
def _cleared(total: float, terms: float) -> float:
    """The sum, 0 where nothing but the rounding of its terms is left."""
    return total if abs(total) > CANCELLED * terms else 0.0


@kernel
def _eliminate(A: FloatArray, n: int, b: int, order: IntArray, gain: FloatArray, work: FloatArray) -> bool:
    """gain (f, b + 1), z_F = gain [x_B; 1] from A_FF z_F + A_FB x_B + A_Fn = 0; False unless A_FF is regular.

    A (n, n + 1): signs and bases applied already, the vector in its last column; order (n,): numbers of the b bounded
    unknowns, then of the f free ones. work (2 f + 2, n + 1).
    """
    f, free = n - b, order[b:]
    block, inverse, scale, left = work[:f], work[f : 2 * f], work[2 * f], work[2 * f + 1]
    for i in range(f):
        largest = 0.0
        for j in range(f):
            largest = max(largest, abs(A[free[i], free[j]]))
        if largest == 0.0:
            return False
        scale[i] = np.sqrt(largest)
    for i in range(f):
        for j in range(f):
            block[i, j] = A[free[i], free[j]] / (scale[i] * scale[j])
    if not _invert(block, inverse, f):
        return False
    for i in range(f):
        for j in range(f):
            inverse[i, j] /= scale[i] * scale[j]
    for c in range(b + 1):
        column = order[c] if c < b else n
        for i in range(f):
            gain[i, c] = 0.0
        for _ in range(3):  # the second and third take out the rounding of the inverse
            for i in range(f):
                left[i] = A[free[i], column]
                for j in range(f):
                    left[i] += A[free[i], free[j]] * gain[j, c]
            for i in range(f):
                for j in range(f):
                    gain[i, c] -= inverse[i, j] * left[j]
        for i in range(f):
            terms = 0.0
            for j in range(f):
                terms += abs(inverse[i, j]) * abs(A[free[j], column])
            gain[i, c] = _cleared(gain[i, c], terms)
            if not abs(gain[i, c]) < np.inf:
                return False
    return True


@kernel
def _normal_form(
    M: FloatArray, q: FloatArray, lower: FloatArray, upper: FloatArray, frame: FloatArray, kind: IntArray, A: FloatArray
) -> bool:
    """The problem in x with z = base + sign x, A (n, n + 1) with the vector last; whether M is symmetric."""
    base, sign, n, symmetric = frame[0], frame[1], len(q), True
    for i in range(n):
        below, above = lower[i] > -np.inf, upper[i] < np.inf
        base[i] = lower[i] if below else upper[i] if above else 0.0
        sign[i] = -1.0 if above and not below else 1.0
        kind[i] = FREE
        if below or above:
            kind[i] = DOUBLE if below and above else SINGLE
    for i in range(n):
        total = 0.0
        for j in range(n):
            total += M[i, j] * base[j]
            A[i, j] = sign[i] * M[i, j] * sign[j]
            symmetric = symmetric and abs(M[i, j] - M[j, i]) <= SYMMETRIC * abs(M[j, i])
        A[i, n] = sign[i] * (total + q[i])
    return symmetric


@kernel
def reduce_box(
    M: FloatArray,
    q: FloatArray,
    lower: FloatArray,
    upper: FloatArray,
    frame: FloatArray,
    kind: IntArray,
    order: IntArray,
    gain: FloatArray,
    full: FloatArray,
    load: FloatArray,
    work: FloatArray,
) -> int:
    """The LCP of a box. 0 where it was not made, for bilateral rows that are many or not clearly regular; else 1, and 2
    if its unknowns are alike though the multipliers have no diagonal: those of the others are near 1.

    M (n, n), q, lower, upper (n,), with b unknowns bounded, e of them twice, and f free. Out: full (b + e, b + e) and
    load (b + e,), matrix and vector in the unknowns [x of bounded z, multipliers of second bounds]; frame (2, n), base
    and sign in z = base + sign x; kind (n,); gain (f, b + 1) in z_F = gain [x; 1]. order (n,), work
    (n + 2 f + 2, n + 1): work.
    """
    n, b = len(q), gain.shape[1] - 1
    A, f = work[:n], n - b
    symmetric = _normal_form(M, q, lower, upper, frame, kind, A)
    p, last = 0, b
    for i in range(n):
        if kind[i] == FREE:
            order[last] = i
            last += 1
        else:
            order[p] = i
            p += 1
    if f > LARGE or (f > 0 and not _eliminate(A, n, b, order, gain, work[n:])):
        return 0
    for k in range(len(load)):
        for c in range(len(load)):
            full[k, c] = 0.0
    for k in range(b):
        i = order[k]
        for c in range(b + 1):
            column = order[c] if c < b else n
            total, terms = A[i, column], abs(A[i, column])
            for j in range(f):
                total += A[i, order[b + j]] * gain[j, c]
                terms += abs(A[i, order[b + j]]) * abs(gain[j, c])
            value = _cleared(total, terms)
            if c < b:
                full[k, c] = value
            else:
                load[k] = value
    if symmetric and f > 0:
        for k in range(b):
            for c in range(k):
                full[k, c] = 0.5 * (full[k, c] + full[c, k])
                full[c, k] = full[k, c]
    p = b
    for k in range(b):
        i = order[k]
        if kind[i] == DOUBLE:
            full[k, p], full[p, k], load[p] = 1.0, -1.0, upper[i] - lower[i]
            p += 1
    for k in range(b):
        if not 1.0 <= NEAR * abs(full[k, k]) <= NEAR * NEAR:
            return 1
    return 2 if p > b else 1


@kernel
def recover_box(x: FloatArray, frame: FloatArray, kind: IntArray, gain: FloatArray, z: FloatArray) -> None:
    """z (n,) from the unknowns x of the LCP of :func:`reduce_box`."""
    k, f, b = 0, 0, gain.shape[1] - 1
    for i in range(len(z)):
        if kind[i] != FREE:
            z[i] = frame[0, i] + frame[1, i] * x[k]
            k += 1
        else:
            z[i] = gain[f, b]
            for c in range(b):
                z[i] += gain[f, c] * x[c]
            f += 1


@kernel
def box_parts(
    M: FloatArray, q: FloatArray, lower: FloatArray, upper: FloatArray, z: FloatArray, w: FloatArray
) -> tuple[float, float, float]:
    """The absolute residual of a box, the size of the terms of w and the load, as a Lcp's; all inf if not finite.

    Out: w = M z + q (n,). The load is the largest of |q_i| and d_i |mid(lower_i, 0, upper_i)|. Where it is 0, z = 0
    is a solution; another z is one if its w is rounding of its terms, which are the load then.
    Where a bound is neither 0 nor infinite, unknowns on their bounds may make the terms large: a residual above 1e-9 of
    the load is judged against the load.
    """
    worst, size, load, shifted = 0.0, 0.0, 0.0, False
    for i in range(len(q)):
        off, terms, own = box_row(M, q, lower, upper, z, w, i)
        shifted = shifted or 0.0 < abs(lower[i]) < np.inf or 0.0 < abs(upper[i]) < np.inf
        load = max(load, own)
        if not (terms < np.inf and off < np.inf and load < np.inf):
            return np.inf, np.inf, np.inf
        worst, size = max(worst, off), max(size, terms)
    if load == 0.0 and worst <= ROUNDING * len(q) * size:
        load = size
    if shifted and worst > CLOSE * load:
        size = load
    return worst, max(size, load), load


@kernel
def box_row(
    M: FloatArray, q: FloatArray, lower: FloatArray, upper: FloatArray, z: FloatArray, w: FloatArray, i: int
) -> tuple[float, float, float]:
    """What row i misses, the size of its terms, and its load, as :func:`box_parts` counts them; w_i is written."""
    row, terms, total = 0.0, 0.0, 0.0
    for j in range(len(q)):
        row = max(row, abs(M[i, j]))
        total += M[i, j] * z[j]
        terms += abs(M[i, j]) * abs(z[j])
    d = row if row > 0.0 else 1.0
    w[i] = total + q[i]
    off = d * (z[i] - min(max(z[i] - w[i] / d, lower[i]), upper[i]))
    terms += abs(q[i])
    if z[i] != 0.0 and off == 0.0 and abs(w[i]) > CLEAR * terms:  # on its bound, whatever w is rounded to
        terms = abs(q[i])
    return abs(off), terms, max(abs(q[i]), d * abs(min(max(0.0, lower[i]), upper[i])))


@kernel
def box_sizes(
    M: FloatArray, q: FloatArray, lower: FloatArray, upper: FloatArray, z: FloatArray, w: FloatArray
) -> tuple[float, float]:
    """The residual of a box in the two sizes of a Solution; w (n,) is written.

    Row by row (:func:`lcpflex.solvers.certificate.measured`) where bounds are 0 or infinite, as for an Lcp. Other
    bounds load the rows of others, too: the whole is then judged by the largest.
    """
    load, shifted = 0.0, False
    for i in range(len(q)):
        load = max(load, abs(q[i]))
        shifted = shifted or 0.0 < abs(lower[i]) < np.inf or 0.0 < abs(upper[i]) < np.inf
    if shifted or load == 0.0:
        worst, size, load = box_parts(M, q, lower, upper, z, w)
        return guarded_residual(worst, size, load), strict_residual(worst, load)
    told, finite = (0.0, 0.0, 0.0), True
    for i in range(len(q)):
        off, terms, own = box_row(M, q, lower, upper, z, w, i)
        finite = finite and off < np.inf and terms < np.inf
        told = worse(told, measured(off, terms, own, load))
    return (told[0], told[1]) if finite else (np.inf, np.inf)


@kernel
def on_bounds(q: FloatArray, lower: FloatArray, upper: FloatArray, z: FloatArray, w: FloatArray) -> bool:
    """Whether each z_i (n,) with two bounds is on the one that a w_i (n,), large enough beside q, pushes it to.

    A narrow box beside a large q: either end is as good to a residual that is relative to q.
    """
    load = 0.0
    for i in range(len(q)):
        load = max(load, abs(q[i]))
    for i in range(len(q)):
        width = upper[i] - lower[i]
        bound = lower[i] if w[i] > 0.0 else upper[i]
        if width < np.inf and abs(w[i]) > CLOSE * load and abs(z[i] - bound) > BESIDE * width:
            return False
    return True
