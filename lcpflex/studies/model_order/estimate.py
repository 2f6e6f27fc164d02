"""How far a reduced scene is from its full mesh, judged by runs that are all reduced.

The outputs x of a scene are compared with those of a much richer reference V of the same scene, d = |x - x_V|. Both
differ from the full mesh F; what the reference lacks itself is extrapolated. With the number of modes N, z = N + 1/2,

    |x_N - x_F| ~ C (z_N^-p - z_F^-p)   so that   d_N ~ C (z_N^-p - z_V^-p),   e_V = C (z_V^-p - z_F^-p)

p is the slope that fits the levels below V best, within bounds: an impact without restitution loses 1/(2 N + 1) of the
energy of a free bar (p = 1). That holds where the differences fall regularly. Where they do not, contacts that come and
go make every level a little different from the next, and so V from F: then e_V is as large as the differences of the
two richest levels below V, their geometric mean, and does not fall. The estimate of a scene is d + e_V: a difference to
one far richer scene, not to the next level, so that a symmetric mode which changes nothing proves nothing.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from lcpflex.basics import libs

__all__ = ["Sample", "Trend", "cost_of", "lacking", "left_at", "trend_of"]

SLOWEST, FASTEST, USUAL = 0.5, 3.0, 1.0  # rates p that are believed, and that of an impact
SLOPES = np.linspace(SLOWEST, FASTEST, 26)
NOTHING = 1e-13  # differences below this are rounding
REGULAR = 0.55  # largest ratio of the differences of levels in succession that still is convergence: p = 1/2 has 0.41
DOUBT = 0.5  # part of the last difference that e_V is never below, where it is
LATEST = 3  # levels that tell how large the error still is: the first ones are not on the way yet


class Sample(NamedTuple):
    """A level below the reference: its number of modes and its difference to it."""

    modes: float
    difference: float


class Trend(NamedTuple):
    """Error ~ factor z^-rate."""

    rate: float
    factor: float
    samples: int  # levels that it comes from


def trend_of(samples: Sequence[Sample], reference: float) -> Trend:
    """The law of the differences to a reference with so many modes; the usual rate where they do not tell one."""
    used = sorted(
        {one.modes: one for one in samples if 0 <= one.modes < reference and one.difference > NOTHING}.values()
    )
    if not used:
        return Trend(USUAL, 0.0, 0)
    if len(used) > 2 and used[0].modes == 0:
        used = used[1:]  # rigid is no member of the family
    used = used[-LATEST:]
    z = np.array([one.modes + 0.5 for one in used])
    log_d = np.log([one.difference for one in used])
    end = reference + 0.5
    rate = USUAL
    if len(used) > 1:
        misfit = [float(np.var(log_d - np.log(z**-p - end**-p))) for p in SLOPES]
        rate = float(SLOPES[int(np.argmin(misfit))])
    factor = math.exp(float(np.mean(log_d - np.log(z**-rate - end**-rate))))
    return Trend(rate, factor, len(used))


def left_at(trend: Trend, modes: float, full: float) -> float:
    """Error that the trend leaves with so many modes, relative to the full mesh."""
    if modes >= full:
        return 0.0
    left: float = (modes + 0.5) ** -trend.rate - (full + 0.5) ** -trend.rate
    return trend.factor * left


def lacking(samples: Sequence[Sample], reference: float, full: float) -> float:
    """e_V: error of the reference itself, with so many modes, relative to the full mesh."""
    if reference >= full:
        return 0.0
    below = sorted(one for one in samples if 0 <= one.modes < reference)
    if not below:
        return math.inf
    near = [one.difference for one in below[-LATEST:]]
    ratios = [richer / poorer if poorer > NOTHING else 0.0 for poorer, richer in pairwise(near)]
    if max(ratios, default=0.0) <= REGULAR:
        return max(left_at(trend_of(samples, reference), reference, full), DOUBT * near[-1])
    return math.sqrt(near[-2] * near[-1])


def cost_of(known: Sequence[tuple[int, float]], coordinates: int) -> float:
    """Wall time [s] of a run with so many coordinates n: a + b n + c n^2, a, b, c >= 0, fitted to measured (n, time).

    The square, of explicit steps that fall with the highest mode, only where more than two sizes tell. Weighted towards
    the larger ones; beyond all that were measured, never below the largest of them. NaN where nothing was measured.
    """
    if not known:
        return math.nan
    n = np.array([one[0] for one in known], dtype=float)
    t = np.array([one[1] for one in known])
    sizes = len(set(n.tolist()))
    if sizes == 1:
        return float(np.median(t)) * max(1.0, coordinates / float(n[0]))
    powers = np.arange(3 if sizes > 2 else 2)
    weight = np.sqrt(n)
    found, _ = libs.nnls(weight[:, None] * (n[:, None] / n.max()) ** powers, weight * t)
    fitted = float(found @ (coordinates / n.max()) ** powers)
    return max(fitted, float(np.median(t[n == n.max()]))) if coordinates > n.max() else fitted
