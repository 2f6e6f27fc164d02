"""Elastic part of contact laws: force, stiffness and stored energy of an indentation, and their inverses.

``kinds`` and ``p`` are the row of a law, see :mod:`lcpflex.force_laws.layout`. Beyond ``p[END]`` a law goes on along
its tangent there: trial states of a step may lie beyond, accepted ones not.
"""

from __future__ import annotations

import math

import numpy as np

from lcpflex.force_laws.layout import ADDRESS, ELASTIC, ELASTIC_KIND, END
from lcpflex.force_laws.user_call import own_force
from lcpflex.jit.kernel import FloatArray, IntArray, kernel

__all__ = [
    "ENERGY",
    "FORCE",
    "INDENTATION",
    "KINDS",
    "STIFFNESS",
    "evaluate",
    "LAST_LOGARITHM",
    "elastic_force",
    "elastic_stiffness",
    "indentation_at",
    "indentation_of",
    "persson_load",
    "stored_energy",
]

KINDS = ("power", "logarithmic", "liu", "persson", "own")
POWER, LOGARITHMIC, LIU, PERSSON, OWN = range(len(KINDS))
FORCE, STIFFNESS, ENERGY, INDENTATION = range(4)  # what arrays are asked for
MOST_ITERATIONS = 40
ROUGH = 1e-2  # relative, of an indentation that only bounds a step
FINE = 4e-16  # relative
LAST_LOGARITHM = 1.01  # u at the end of a logarithmic law: at u = 1, 5e-5 of the indentation on, it has no slope
FROM_SERIES = 0.25  # of the clearance, below which the closed form of the energy of Liu's law would cancel
PERSSON_POLE = 0.8346152454776573  # tan^2(eps/2) at which the load of Persson's solution is infinite
OWN_SPEED = 1.0  # impact speed at which the elastic part of a user's law is taken [m/s]
OWN_LEAST = 1e-12  # indentation whose slope is that at the touch [m]
OWN_DIFFERENCE = 1e-4  # relative, of the indentations between which its slope is taken
# not more than 1e-13 off up to the end of Persson's law, with the pole moved to infinity
NODES, WEIGHTS = np.polynomial.legendre.leggauss(20)


@kernel
def logarithm(p: FloatArray, depth: float) -> float:
    """u = ln(C/F) of a logarithmic law, the root > 1 of u - ln u = Lam = ln(C / (a depth)).

    From a point within 16 % of the root, for any number that a depth can be: a step of fourth order (Fritsch, Shafer &
    Crowley 1973) brings it to 5e-8, one of Newton's in a form that does not cancel to rounding. The time goes into the
    logarithms, so into few and large steps, and not into asking whether to end.
    """
    beyond = p[ELASTIC + 2] - math.log(depth) - 1.0
    u = 1.0 + math.sqrt(2.0 * beyond) + 0.8 * beyond  # between the known bounds, with 2/3 and 1 in place of 0.8
    residual = u - math.log(u) - 1.0 - beyond
    above = 1.0 - u
    q = 2.0 * above * (above + 2.0 / 3.0 * residual)
    u += u * residual * (q - residual) / (above * (q - 2.0 * residual))
    return u * (math.log(u) + beyond) / (u - 1.0)


@kernel
def persson_load(b: float) -> tuple[float, float]:
    """F / (2 pi E* L DeltaR) of Persson's solution and its derivative, at b = tan^2(eps/2) below the pole."""
    above = (b + 1.0) * b
    below = 2.0 - math.log1p(b) - 2.0 * b * b
    slope = ((2.0 * b + 1.0) * below + above * (1.0 / (1.0 + b) + 4.0 * b)) / (below * below)
    return above / below, slope


@kernel
def persson_energy(x: float) -> float:
    """Integral of ``persson_load`` over the indentation in clearances, from 0 to x."""
    top = -math.log1p(-x / (2.0 + x) / PERSSON_POLE)
    total = 0.0
    for i in range(len(NODES)):
        s = 0.5 * top * (1.0 + NODES[i])
        b = -PERSSON_POLE * math.expm1(-s)
        total += WEIGHTS[i] * persson_load(b)[0] * 2.0 / (1.0 - b) ** 2 * (PERSSON_POLE - b)
    return 0.5 * top * total


@kernel
def liu_energy(x: float) -> float:
    """Integral of x^1.5 / sqrt(1 + x) from 0 to x."""
    if x < FROM_SERIES:
        power = x * x * math.sqrt(x)
        total = power / 2.5
        for k in range(1, MOST_ITERATIONS):
            power *= -x * (k - 0.5) / k
            total += power / (k + 2.5)
            if abs(power) < FINE * total:
                break
        return total
    root = math.sqrt(x * (1.0 + x))
    return 0.5 * root * (x - 1.5) + 0.75 * math.asinh(math.sqrt(x))


@kernel
def own_energy(address: int, depth: float) -> float:
    """Integral of the elastic part of a user's law, over x with depth x^2: smooth for powers of indentation."""
    total = 0.0
    for i in range(len(NODES)):
        x = 0.5 * (1.0 + NODES[i])
        total += WEIGHTS[i] * x * own_force(address, depth * x * x, 0.0, OWN_SPEED)
    return depth * total


@kernel
def own_stiffness(address: int, depth: float) -> float:
    """Slope of the elastic part of a user's law, by a central difference."""
    more = own_force(address, depth * (1.0 + OWN_DIFFERENCE), 0.0, OWN_SPEED)
    less = own_force(address, depth * (1.0 - OWN_DIFFERENCE), 0.0, OWN_SPEED)
    return (more - less) / (2.0 * OWN_DIFFERENCE * depth)


@kernel
def force_inside(kinds: IntArray, p: FloatArray, depth: float) -> float:
    """``elastic_force`` up to the end of the law."""
    kind = kinds[ELASTIC_KIND]
    if kind == POWER:
        return p[ELASTIC] * depth ** p[ELASTIC + 1]
    if kind == LOGARITHMIC:
        return p[ELASTIC] * depth / logarithm(p, depth)
    if kind == LIU:
        return p[ELASTIC] * depth * math.sqrt(depth / (2.0 * (p[ELASTIC + 1] + depth)))
    if kind == PERSSON:
        return p[ELASTIC] * persson_load(depth / (2.0 * p[ELASTIC + 1] + depth))[0]
    if kind == OWN:
        return own_force(kinds[ADDRESS], depth, 0.0, OWN_SPEED)
    return math.nan


@kernel
def stiffness_inside(kinds: IntArray, p: FloatArray, depth: float) -> float:
    """``elastic_stiffness`` up to the end of the law."""
    kind = kinds[ELASTIC_KIND]
    if kind == POWER:
        return p[ELASTIC] * p[ELASTIC + 1] * depth ** (p[ELASTIC + 1] - 1.0)
    if kind == LOGARITHMIC:
        return p[ELASTIC] / (logarithm(p, depth) - 1.0)
    if kind == LIU:
        x = depth / (p[ELASTIC + 1] + depth)
        return p[ELASTIC] * math.sqrt(0.5 * x) * (1.5 - 0.5 * x)
    if kind == PERSSON:
        wide = 2.0 * p[ELASTIC + 1] + depth
        return p[ELASTIC] * persson_load(depth / wide)[1] * 2.0 * p[ELASTIC + 1] / (wide * wide)
    if kind == OWN:
        return own_stiffness(kinds[ADDRESS], max(depth, OWN_LEAST))
    return math.nan


@kernel
def energy_inside(kinds: IntArray, p: FloatArray, depth: float) -> float:
    """``stored_energy`` up to the end of the law."""
    kind = kinds[ELASTIC_KIND]
    if kind == POWER:
        return p[ELASTIC] * depth ** (p[ELASTIC + 1] + 1.0) / (p[ELASTIC + 1] + 1.0)
    if kind == LOGARITHMIC:
        u = logarithm(p, depth)
        return p[ELASTIC] * (depth / u) ** 2 * (0.5 * u - 0.25)
    if kind == LIU:
        return p[ELASTIC] * math.sqrt(0.5) * p[ELASTIC + 1] ** 2 * liu_energy(depth / p[ELASTIC + 1])
    if kind == PERSSON:
        return p[ELASTIC] * p[ELASTIC + 1] * persson_energy(depth / p[ELASTIC + 1])
    if kind == OWN:
        return own_energy(kinds[ADDRESS], depth)
    return math.nan


@kernel
def elastic_force(kinds: IntArray, p: FloatArray, depth: float) -> float:
    """Force F [N] at an indentation [m]: the derivative of ``stored_energy``; 0 at and before the touch."""
    if depth <= 0.0:
        return 0.0
    force = force_inside(kinds, p, min(depth, p[END]))
    if depth > p[END]:
        force += stiffness_inside(kinds, p, p[END]) * (depth - p[END])
    return force


@kernel
def elastic_stiffness(kinds: IntArray, p: FloatArray, depth: float) -> float:
    """dF/ddelta at an indentation [N/m]; at the touch the limit from above."""
    if depth <= 0.0:
        if kinds[ELASTIC_KIND] == LOGARITHMIC:
            return 0.0
        depth = 0.0
    return stiffness_inside(kinds, p, min(depth, p[END]))


@kernel
def stored_energy(kinds: IntArray, p: FloatArray, depth: float) -> float:
    """Energy stored at an indentation [J]; 0 at and before the touch."""
    if depth <= 0.0:
        return 0.0
    energy = energy_inside(kinds, p, min(depth, p[END]))
    if depth > p[END]:
        beyond = depth - p[END]
        slope = stiffness_inside(kinds, p, p[END])
        energy += beyond * (force_inside(kinds, p, p[END]) + 0.5 * slope * beyond)
    return energy


@kernel
def kept(low: float, high: float, depth: float, following: float) -> float:
    """The next iterate: ``following`` where it lies in the bracket, else halfway, in logarithms if it has ends."""
    if low <= following <= high:
        return following
    if low > 0.0 and high < math.inf:
        return math.sqrt(low * high)
    return 0.5 * min(high, 4.0 * depth)


@kernel
def indentation_of(kinds: IntArray, p: FloatArray, energy: float) -> float:
    """Indentation at which about ``energy`` is stored [m], to 1 %: Newton's method in logarithms, exact for powers.

    Beyond the end of a law, where the energy is a parabola, its root.
    """
    low = 0.0
    high = p[END]
    depth = min(1e-6, high)
    if high < math.inf:
        more = energy - energy_inside(kinds, p, high)
        if more >= 0.0:
            last = force_inside(kinds, p, high)
            return high + 2.0 * more / (last + math.sqrt(last * last + 2.0 * stiffness_inside(kinds, p, high) * more))
    for _ in range(4 * MOST_ITERATIONS):
        stored = stored_energy(kinds, p, depth)
        if abs(stored - energy) <= ROUGH * energy:
            break
        if stored < energy:
            low = depth
        else:
            high = depth
        following = depth * (energy / stored) ** (stored / (depth * elastic_force(kinds, p, depth)))
        depth = kept(low, high, depth, following)
    return depth


@kernel
def indentation_at(kinds: IntArray, p: FloatArray, force: float) -> float:
    """Indentation [m] at a force [N]: the inverse of ``elastic_force``; 0 for forces <= 0.

    Explicit for powers and logarithmic laws; for the others Newton's method in logarithms, kept in a bracket.
    """
    if force <= 0.0:
        return 0.0
    kind = kinds[ELASTIC_KIND]
    if kind == LOGARITHMIC:
        u = math.log(p[ELASTIC + 1]) - math.log(force)
        if u >= LAST_LOGARITHM:
            return force / p[ELASTIC] * u
    if p[END] < math.inf:
        last = force_inside(kinds, p, p[END])
        if force >= last:
            return p[END] + (force - last) / stiffness_inside(kinds, p, p[END])
    if kind == POWER:
        return (force / p[ELASTIC]) ** (1.0 / p[ELASTIC + 1])
    low = 0.0
    high = p[END]
    depth = min(1e-6, high)
    for _ in range(4 * MOST_ITERATIONS):
        found = elastic_force(kinds, p, depth)
        if found < force:
            low = depth
        else:
            high = depth
        slope = depth * elastic_stiffness(kinds, p, depth)
        following = kept(low, high, depth, depth * (force / found) ** (found / slope))
        if abs(following - depth) <= FINE * depth:
            break
        depth = following
    return depth


@kernel
def evaluate(kinds: IntArray, p: FloatArray, quantity: int, given: FloatArray, out: FloatArray) -> None:
    """A quantity of a law at each indentation (or for INDENTATION at each force) ``given`` (n,), to ``out`` (n,)."""
    for i in range(len(given)):
        if quantity == FORCE:
            out[i] = elastic_force(kinds, p, given[i])
        elif quantity == STIFFNESS:
            out[i] = elastic_stiffness(kinds, p, given[i])
        elif quantity == ENERGY:
            out[i] = stored_energy(kinds, p, given[i])
        else:
            out[i] = indentation_at(kinds, p, given[i])
