"""What proves an answer in space: the natural map of the friction cones, each contact in a unit of its own.

With r' = r / d and u' = d u, d = 1 / sqrt(max diag W_kk) of each contact, r solves contact k if and only if

    r' = P_K(r' - (u' + mu |u'_T| n))                                            (de Saxce & Feng 1998)

with P_K the projection on K: |r_T| <= mu r_N. Cones stay as they are in any unit, and what is left of the equation is
the same for kilograms and metres as for tonnes and millimetres.
"""

from __future__ import annotations

import math

import numpy as np

from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.solvers.certificate import measured, row_parts, worse

__all__ = ["cone_parts", "cone_sizes", "nearest_in_cone", "natural_miss", "weigh_cones"]

SMALLEST, LARGEST = 1e-280, 1e300  # squares between which a sum of two of them loses nothing


@kernel
def length_of(x: float, y: float) -> float:
    """sqrt(x^2 + y^2), whatever the size of x and y; a library's hypot takes three times as long."""
    square = x * x + y * y
    return math.sqrt(square) if SMALLEST < square < LARGEST else math.hypot(x, y)


@kernel
def nearest_in_cone(x_n: float, x_1: float, x_2: float, mu: float) -> tuple[float, float, float]:
    """The nearest point of the cone |x_T| <= mu x_N, 0 <= mu < inf."""
    slip = length_of(x_1, x_2)
    if slip <= mu * x_n and x_n >= 0.0:  # without friction 0 <= -0 holds for any
        return x_n, x_1, x_2
    length = length_of(1.0, mu)
    cosine, sine = 1.0 / length, mu / length
    along = cosine * x_n + sine * slip  # on the generator below or above the point
    if along <= 0.0:
        return 0.0, 0.0, 0.0
    if slip == 0.0:
        return cosine * along, 0.0, 0.0
    return cosine * along, sine * along * (x_1 / slip), sine * along * (x_2 / slip)


@kernel
def natural_miss(
    r_n: float, r_1: float, r_2: float, u_n: float, u_1: float, u_2: float, mu: float, unit: float
) -> float:
    """Largest component of r' - P_K(r' - (u' + mu |u'_T| n)) of one contact, r' = r / unit and u' = unit u.

    r: its force; u: its velocity. inf where anything is not finite.
    """
    a_n, a_1, a_2 = r_n / unit, r_1 / unit, r_2 / unit
    b_1, b_2 = unit * u_1, unit * u_2
    b_n = unit * u_n + mu * length_of(b_1, b_2)
    if not abs(a_n) + abs(a_1) + abs(a_2) + abs(b_n) + abs(b_1) + abs(b_2) < np.inf:
        return np.inf
    c_n, c_1, c_2 = nearest_in_cone(a_n - b_n, a_1 - b_1, a_2 - b_2, mu)
    # b itself where the point is inside: a - (a - b) would lose its digits
    if c_n == a_n - b_n and c_1 == a_1 - b_1 and c_2 == a_2 - b_2:
        return max(abs(b_n), max(abs(b_1), abs(b_2)))
    return max(abs(a_n - c_n), max(abs(a_1 - c_1), abs(a_2 - c_2)))


@kernel
def contact_parts(
    forces: FloatArray,
    velocity: FloatArray,
    terms: FloatArray,
    free: FloatArray,
    friction: FloatArray,
    units: FloatArray,
    k: int,
) -> tuple[float, float, float]:
    """What contact k leaves of the natural map, the size of the terms of its velocities, and that of the free ones.

    In its unit; all inf if anything is not finite. Arrays as in :func:`cone_parts`.
    """
    i, unit = 3 * k, units[k]
    miss = natural_miss(
        forces[i], forces[i + 1], forces[i + 2], velocity[i], velocity[i + 1], velocity[i + 2], friction[k], unit
    )
    size, load, finite = 0.0, 0.0, True
    for j in range(i, i + 3):
        load = max(load, unit * abs(free[j]))
        size = max(size, unit * terms[j])
        # NaN fails every comparison, and max() may drop it: each number is asked for by itself.
        if not (unit * terms[j] < np.inf and abs(velocity[j]) < np.inf and miss < np.inf):
            finite = False
    if not finite:
        return np.inf, np.inf, np.inf
    return miss, size, load


@kernel
def cone_parts(
    forces: FloatArray,
    velocity: FloatArray,
    terms: FloatArray,
    free: FloatArray,
    friction: FloatArray,
    units: FloatArray,
    n: int,
) -> tuple[float, float, float]:
    """The largest over n contacts of each of :func:`contact_parts`; all inf if anything is not finite.

    forces, velocity, terms, free (3 n,): rows (n, t1, t2) of each contact in turn, terms = sum |W_ij r_j| + |free_i|;
    friction, units (n,).
    """
    worst, size, load = 0.0, 0.0, 0.0
    for k in range(n):
        own = contact_parts(forces, velocity, terms, free, friction, units, k)
        worst, size, load = max(worst, own[0]), max(size, own[1]), max(load, own[2])
    return worst, size, load


@kernel
def cone_sizes(
    forces: FloatArray,
    velocity: FloatArray,
    terms: FloatArray,
    free: FloatArray,
    friction: FloatArray,
    units: FloatArray,
    n: int,
    missed: FloatArray,
) -> tuple[float, float, float]:
    """The largest over n contacts of the three sizes of :func:`lcpflex.solvers.certificate.measured`.

    Arrays as in :func:`cone_parts`. Out, unless it is empty: what is left of the own load of each contact, missed (n,).
    """
    largest = 0.0
    for i in range(3 * n):
        largest = max(largest, units[i // 3] * abs(free[i]))
    told, finite = (0.0, 0.0, 0.0), True
    for k in range(n):
        miss, size, load = contact_parts(forces, velocity, terms, free, friction, units, k)
        if not miss < np.inf:
            finite = False
        own = measured(miss, size, load, largest)
        if len(missed) > 0:
            missed[k] = own[1]
        told = worse(told, own)
    if not finite:
        return np.inf, np.inf, np.inf
    return told


@kernel
def weigh_cones(
    W: FloatArray,
    free: FloatArray,
    friction: FloatArray,
    units: FloatArray,
    forces: FloatArray,
    n: int,
    velocity: FloatArray,
    terms: FloatArray,
) -> tuple[float, float, float]:
    """Velocities W forces + free, and the sizes of :func:`cone_sizes` of n contacts.

    W (cap, cap) dense; the others as in :func:`cone_parts`. Out: velocity and terms (3 n,).
    """
    m = 3 * n
    for i in range(m):
        caused, size, _ = row_parts(W[i], forces, m)
        velocity[i] = caused + free[i]
        terms[i] = size + abs(free[i])
    return cone_sizes(forces, velocity, terms, free, friction, units, n, units[:0])
