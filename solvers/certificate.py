"""What proves an answer: the natural-map residual of a point.

Every solver's claim is checked here on the original data, in plain sums that owe nothing to its algorithm. Proofs that
there is no solution are those of :mod:`lcpflex.solvers.lcp.proofs`.
"""

from __future__ import annotations

import numpy as np

from lcpflex.jit.kernel import FloatArray, IntArray, kernel

__all__ = [
    "all_finite",
    "guarded_residual",
    "is_symmetric",
    "judge",
    "largest_measures",
    "measured",
    "natural_residual",
    "own_load",
    "own_share",
    "residual_parts",
    "row_parts",
    "strict_residual",
    "terms_residual",
    "weigh",
    "weigh_contacts_of",
    "weigh_rows",
    "worse",
]

GUARD = 1e-6  # a residual above this fraction of |q| is judged against |q| itself: see guarded_residual
WEDGED = 0.1  # a residual, or rounding, above this fraction of |q| leaves nothing of an answer: see terms_residual
ROUNDING = 2.2e-16  # of one operation, relative
OWN = 1e3  # tolerances: what steppers may leave of the own load of a contact
ROUNDED = 4.0  # roundings of the terms of a contact: what is left below that is 0
SYMMETRY = 1e-10  # largest |M - M^T| of a symmetric matrix, relative to max|M|


@kernel
def row_parts(row: FloatArray, z: FloatArray, n: int) -> tuple[float, float, float]:
    """row . z, sum |row_j z_j| and max |row_j|; four of each side by side, or one would wait for its last addition."""
    w0, w1, w2, w3 = 0.0, 0.0, 0.0, 0.0
    t0, t1, t2, t3 = 0.0, 0.0, 0.0, 0.0
    d0, d1, d2, d3 = 0.0, 0.0, 0.0, 0.0
    whole = n - n % 4
    for j in range(0, whole, 4):
        e0, e1, e2, e3 = row[j], row[j + 1], row[j + 2], row[j + 3]
        a0, a1, a2, a3 = e0 * z[j], e1 * z[j + 1], e2 * z[j + 2], e3 * z[j + 3]
        w0 += a0
        w1 += a1
        w2 += a2
        w3 += a3
        t0 += abs(a0)
        t1 += abs(a1)
        t2 += abs(a2)
        t3 += abs(a3)
        d0 = max(d0, abs(e0))
        d1 = max(d1, abs(e1))
        d2 = max(d2, abs(e2))
        d3 = max(d3, abs(e3))
    for j in range(whole, n):
        a0 = row[j] * z[j]
        w0 += a0
        t0 += abs(a0)
        d0 = max(d0, abs(row[j]))
    return (w0 + w1) + (w2 + w3), (t0 + t1) + (t2 + t3), max(max(d0, d1), max(d2, d3))


@kernel
def residual_parts(M: FloatArray, q: FloatArray, z: FloatArray, n: int) -> tuple[float, float, float]:
    """The absolute natural-map residual, the size of the terms of w, and |q|; all inf if anything is not finite.

    M (cap, cap), q (cap,), z (cap,): the leading n x n block and the first n entries count. Returns
    ``max_i |min(d_i z_i, w_i)|`` with d_i the largest |M_ij| of the row (1 for a zero row),
    ``max_i (|q_i| + sum_j |M_ij z_j|)`` and ``max_i |q_i|``, all in the units of q.
    """
    return _parts(M, q, z, n, False, z)


@kernel
def _parts(
    M: FloatArray, q: FloatArray, z: FloatArray, n: int, kept: bool, w: FloatArray
) -> tuple[float, float, float]:
    """As :func:`residual_parts`; where it is ``kept``, w = M z + q (cap,) is written."""
    worst, size, load = 0.0, 0.0, 0.0
    finite = True
    for i in range(n):
        product, terms, row = row_parts(M[i], z, n)
        slack = product + q[i]
        if kept:
            w[i] = slack
        load = max(load, abs(q[i]))
        terms += abs(q[i])
        lifted = row * z[i] if row > 0.0 else z[i]
        # NaN fails every comparison, and min() may drop it: each number is asked for by itself.
        if not (terms < np.inf and abs(lifted) < np.inf and abs(slack) < np.inf):
            finite = False
        worst = max(worst, abs(min(lifted, slack)))
        size = max(size, terms)
    if not finite:
        return np.inf, np.inf, np.inf
    return worst, size, load


@kernel
def guarded_residual(worst: float, size: float, load: float) -> float:
    """The dimensionless residual from its parts: ``worst / size``, unless z has run away.

    A z that runs away along a ray makes the denominator, and not the numerator, large; so a residual above
    1e-6 |q| is taken relative to |q| instead, and so is the rounding of w itself when it comes to more than that (w
    would be 0 if z is so large that q is lost in the sum).
    """
    if size < np.inf and ROUNDING * size > GUARD * load > 0.0:
        return max(worst, ROUNDING * size) / load
    if worst == 0.0:
        return 0.0
    if worst == np.inf:
        return np.inf
    if worst > GUARD * load:
        return worst / load if load > 0.0 else np.inf
    return worst / size


@kernel
def weigh(M: FloatArray, q: FloatArray, z: FloatArray, n: int, w: FloatArray) -> tuple[float, float]:
    """w = M z + q, and its two sizes: the residual of :func:`natural_residual`, and the same relative to |q| alone.

    M (cap, cap), q, z and w (cap,): the leading n x n block and the first n entries count. Out: w.
    """
    worst, size, load = _parts(M, q, z, n, True, w)
    if worst == np.inf:
        return np.inf, np.inf
    return guarded_residual(worst, size, load), strict_residual(worst, load)


@kernel
def strict_residual(worst: float, load: float) -> float:
    """The natural-map residual ``worst`` relative to the load |q|, whatever terms cancel: 0 for a solution."""
    if worst == 0.0:
        return 0.0
    return worst / load if load > 0.0 else np.inf


@kernel
def terms_residual(worst: float, size: float, load: float) -> float:
    """The residual relative to the terms alone, ``worst / size``: what rounding allows where bodies are wedged.

    Large forces then cancel in small velocities, and :func:`guarded_residual` asks for more digits than there are. inf
    where more than a tenth of the load is left, or lost in rounding: that is how a z that runs away looks.
    """
    if not (size < np.inf and max(worst, ROUNDING * size) <= WEDGED * load):
        return np.inf
    return worst / size if size > 0.0 else 0.0


@kernel
def own_load(terms: float, load: float, all_else: float) -> float:
    """What a contact is measured by: its load, and what its neighbours do to it; see :func:`measured`."""
    return max(load, min(terms, all_else))


@kernel
def measured(miss: float, terms: float, load: float, all_else: float) -> tuple[float, float, float]:
    """The one measure of a contact, or of a row: what it misses against its own terms and load, in three sizes.

    miss: what is left of its law; terms: the largest sum of terms that cancel in its rows; load: its own free velocity,
    the largest |q| of its rows; all_else: the largest load of all.
    Returns the guarded residual (:func:`guarded_residual`: SOLVED means that it is within the tolerance), the same
    relative to the load alone, and relative to the terms alone (:func:`terms_residual`). A contact that is hardly
    loaded itself, as one between two bodies that fall alike, is measured by what its neighbours do to it: its load
    counts as no less than its terms, as far as these are not larger than all else.
    """
    own = own_load(terms, load, all_else)
    size = max(terms, own)
    known = max(miss, ROUNDING * terms)  # w is not known any better
    return guarded_residual(miss, size, own), strict_residual(miss, own), terms_residual(known, size, own)


@kernel
def own_share(miss: float, terms: float, load: float, all_else: float) -> float:
    """What is left of the own load of a contact beyond rounding; all as in :func:`measured`."""
    if miss <= ROUNDED * ROUNDING * terms:
        return 0.0
    return measured(miss, terms, load, all_else)[1]


@kernel
def worse(a: tuple[float, float, float], b: tuple[float, float, float]) -> tuple[float, float, float]:
    """The larger one of each of three numbers; what is not finite stays so."""
    return max(a[0], b[0]), max(a[1], b[1]), max(a[2], b[2])


@kernel
def largest_measures(miss: FloatArray, terms: FloatArray, load: FloatArray) -> tuple[float, float, float]:
    """The largest of each size of :func:`measured` over contacts, of which all three (contacts,) are known."""
    told, all_else = (0.0, 0.0, 0.0), 0.0
    for k in range(len(load)):
        all_else = max(all_else, load[k])
    for k in range(len(miss)):
        if not (miss[k] < np.inf and terms[k] < np.inf):
            return np.inf, np.inf, np.inf
        told = worse(told, measured(miss[k], terms[k], load[k], all_else))
    return told


@kernel
def weigh_rows(M: FloatArray, q: FloatArray, z: FloatArray, n: int, w: FloatArray) -> tuple[float, float, float]:
    """w = M z + q, and the largest of the three sizes of :func:`measured` over all rows, each by itself.

    Arrays as in :func:`weigh`.
    """
    load = 0.0
    for i in range(n):
        load = max(load, abs(q[i]))
    told = (0.0, 0.0, 0.0)
    finite = True
    for i in range(n):
        miss, terms = _row(M, q, z, n, i, w)
        finite = finite and miss < np.inf
        told = worse(told, measured(miss, terms, abs(q[i]), load))
    if not finite:
        return np.inf, np.inf, np.inf
    return told


@kernel
def weigh_contacts_of(
    M: FloatArray,
    q: FloatArray,
    z: FloatArray,
    n: int,
    w: FloatArray,
    contacts: int,
    tangent: IntArray,
) -> tuple[float, float, float]:
    """The same over contacts: the rows of each share their terms and their load.

    tangent (tangents,): the contact that each tangential row belongs to, ascending. Rows [normals; tangents; ...], as
    many blocks of tangents as there are (:mod:`lcpflex.solvers.contact.lcp_forms`).
    """
    tangents, largest = len(tangent), 0.0
    for i in range(contacts + tangents):
        largest = max(largest, abs(q[i]))
    told = (0.0, 0.0, 0.0)
    finite, j = True, 0
    for k in range(contacts):
        miss, terms = _row(M, q, z, n, k, w)
        load = abs(q[k])
        if j < tangents and tangent[j] == k:
            for i in range(contacts + j, n, tangents):
                other, size = _row(M, q, z, n, i, w)
                miss, terms, load = max(miss, other), max(terms, size), max(load, abs(q[i]))
            j += 1
        finite = finite and miss < np.inf
        told = worse(told, measured(miss, terms, load, largest))
    if not finite:
        return np.inf, np.inf, np.inf
    return told


@kernel
def _row(M: FloatArray, q: FloatArray, z: FloatArray, n: int, i: int, w: FloatArray) -> tuple[float, float]:
    """What row i misses, inf if anything is not finite, and the size of its terms; w_i is written."""
    product, terms, row = row_parts(M[i], z, n)
    slack = product + q[i]
    w[i] = slack
    terms += abs(q[i])
    lifted = row * z[i] if row > 0.0 else z[i]
    if not (terms < np.inf and abs(lifted) < np.inf and abs(slack) < np.inf):
        return np.inf, np.inf
    return abs(min(lifted, slack)), terms


@kernel
def judge(M: FloatArray, q: FloatArray, z: FloatArray, n: int, w: FloatArray) -> float:
    """w = M z + q, and the residual as :func:`natural_residual` gives it. Arrays as in :func:`weigh`."""
    residual, _ = weigh(M, q, z, n, w)
    return residual


@kernel
def natural_residual(M: FloatArray, q: FloatArray, z: FloatArray, n: int) -> float:
    """How far z is from solving the problem: dimensionless, 0 for a solution, inf for a z that is not finite.

    ``max_i |min(d_i z_i, w_i)| / max_i (|q_i| + sum_j |M_ij z_j|)`` with d_i the largest |M_ij| of row i, guarded
    against large z (:func:`guarded_residual`). Arrays as in :func:`residual_parts`.
    """
    worst, size, load = residual_parts(M, q, z, n)
    return guarded_residual(worst, size, load)


@kernel
def all_finite(M: FloatArray, q: FloatArray) -> bool:
    """Whether M (n, m) and q (k,) hold neither NaN nor infinity."""
    for i in range(M.shape[0]):
        total = 0.0
        for j in range(M.shape[1]):
            total += 0.0 * M[i, j]
        if total != 0.0:  # 0 times inf is NaN, and NaN differs from everything
            return False
    total = 0.0
    for i in range(len(q)):
        total += 0.0 * q[i]
    return total == 0.0


@kernel
def is_symmetric(M: FloatArray, n: int) -> bool:
    """Whether the leading block of M equals its transpose to 1e-10 of its largest entry."""
    largest, difference = 0.0, 0.0
    for i in range(n):
        for j in range(i + 1):
            largest = max(largest, abs(M[i, j]))
            difference = max(difference, abs(M[i, j] - M[j, i]))
    return difference <= SYMMETRY * largest
