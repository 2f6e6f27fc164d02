"""Distance of two motions that forgives a jump its time: that of their completed graphs.

Two velocities that jump at t and at t + dt differ by the whole jump in between, however small dt is: errors taken at
equal times do not converge across impacts. The completed graph of y is the curve (t, y(t)) with the jumps filled in by
vertical segments; seen as sets, the two graphs are dt apart. With both axes made dimensionless,

    P = { (t/T, y/Y) },   d(A, B) = max( max_{a in A} min_{b in B} |a - b|,  max_{b in B} min_{a in A} |a - b| )

is the Hausdorff distance, a metric; its one-sided parts are not. For motions without jumps it is at most, and with
slopes of order Y/T about, the largest error at equal times. Source of the convergence of time stepping in this
distance: Moreau 1978, "Approximation en graphe d'une évolution discontinue".
"""

from __future__ import annotations

import math

import numpy as np

from lcpflex.compiled import FloatArray, kernel
from lcpflex.errors import ModelError, in_range

__all__ = ["graph_distance"]

SHARE = 0.02  # of the distance: to this a segment's largest distance is searched
GRAIN = 1e-5  # least spacing of the points tried on a segment: finely sampled graphs need none
FINEST = 1000  # most points tried on a segment


def graph_distance(
    times: FloatArray,
    values: FloatArray,
    other_times: FloatArray,
    other_values: FloatArray,
    time_scale: float = 1.0,
    value_scale: float = 1.0,
    *,
    two_sided: bool = True,
) -> float:
    """Hausdorff distance of two polylines (t/time_scale, y/value_scale), accurate to 2 % or 5e-6.

    Parameters
    ----------
    times, other_times
        (m,), (k,), none decreasing [s]. Two equal times in succession are a jump.
    values, other_values
        (m,) or (m, d), (k,) or (k, d).
    time_scale, value_scale
        What times and values are divided by.
    two_sided
        Take the larger of the distances of each graph to the other; else only that of the first to the other.

    Returns
    -------
    float
        Dimensionless; 0 to rounding for equal graphs.

    Raises
    ------
    ModelError
        For arrays of other shapes, entries that are not finite, times that decrease and scales that are not > 0.
    """
    time_scale = in_range("time_scale", time_scale, 0.0, math.inf, open_ends=True)
    value_scale = in_range("value_scale", value_scale, 0.0, math.inf, open_ends=True)
    one = _polyline("values", times, values, time_scale, value_scale)
    other = _polyline("other_values", other_times, other_values, time_scale, value_scale)
    if one.shape[1] != other.shape[1]:
        raise ModelError(f"other_values: {other.shape[1] - 1} columns; expected {one.shape[1] - 1}, as in values")
    far = _farthest(one, other, 0.0)
    return float(_farthest(other, one, far)) if two_sided else float(far)


def _polyline(name: str, times: FloatArray, values: FloatArray, time_scale: float, value_scale: float) -> FloatArray:
    """Corners (m, 1 + d), dimensionless."""
    t, y = np.asarray(times, dtype=float), np.asarray(values, dtype=float)
    if t.ndim != 1 or not t.size or y.ndim not in (1, 2) or len(y) != len(t):
        raise ModelError(f"{name}: shape {y.shape} at times of shape {t.shape}; expected (m,) or (m, d) at (m,), m > 0")
    if not (np.isfinite(t).all() and np.isfinite(y).all()):
        raise ModelError(f"{name}: times or values that are not finite; expected finite numbers")
    if np.any(np.diff(t) < 0.0):
        raise ModelError(f"{name}: times that decrease; expected times in order")
    return np.ascontiguousarray(np.column_stack([t / time_scale, y / value_scale]))


@kernel
def _farthest(a: FloatArray, b: FloatArray, known: float) -> float:
    """Largest distance of a point of polyline a from polyline b, or ``known`` if that is larger.

    A point between two corners of a is at most (d1 + d2 + length)/2 from b: few segments need points between.
    """
    near = 0
    here = _nearest(a, 0, 0.0, b, near, known)
    best = max(known, here)
    for i in range(len(a) - 1):
        while near < len(b) - 1 and b[near + 1, 0] <= a[i + 1, 0]:
            near += 1
        there = _nearest(a, i, 1.0, b, near, best)
        best = max(best, there)
        length = 0.0
        for c in range(a.shape[1]):
            length += (a[i + 1, c] - a[i, c]) ** 2
        length = math.sqrt(length)
        excess = 0.5 * (here + there + length) - best
        if excess > SHARE * best + 0.5 * GRAIN:
            n = int(min(FINEST, 1.0 + 0.5 * length / (SHARE * best + 0.5 * GRAIN)))
            for k in range(1, n):
                best = max(best, _nearest(a, i, k / n, b, near, best))
        here = there
    return best


@kernel
def _nearest(a: FloatArray, i: int, s: float, b: FloatArray, near: int, enough: float) -> float:
    """Distance of the point a_i + s (a_{i+1} - a_i) from polyline b, or that of a segment nearer than ``enough``.

    The search goes both ways from corner ``near`` of b: with time among the coordinates it may end where the times
    alone are farther apart than the nearest point found.
    """
    after = min(i + 1, len(a) - 1)
    t = a[i, 0] + s * (a[after, 0] - a[i, 0])
    best = _to_segment(a, i, after, s, b, near, near)
    right, left = near, near
    while best > enough * enough:
        more = False
        if right < len(b) - 1 and (b[right, 0] - t <= 0.0 or (b[right, 0] - t) ** 2 < best):
            best = min(best, _to_segment(a, i, after, s, b, right, right + 1))
            right += 1
            more = True
        if left > 0 and (t - b[left, 0] <= 0.0 or (t - b[left, 0]) ** 2 < best):
            best = min(best, _to_segment(a, i, after, s, b, left - 1, left))
            left -= 1
            more = True
        if not more:
            break
    return math.sqrt(best)


@kernel
def _to_segment(a: FloatArray, i: int, after: int, s: float, b: FloatArray, j: int, k: int) -> float:
    """Squared distance of the point a_i + s (a_after - a_i) from the segment b_j b_k."""
    along, length = 0.0, 0.0
    for c in range(a.shape[1]):
        edge = b[k, c] - b[j, c]
        along += (a[i, c] + s * (a[after, c] - a[i, c]) - b[j, c]) * edge
        length += edge * edge
    share = 0.0
    if length > 0.0:
        share = min(max(along / length, 0.0), 1.0)
    square = 0.0
    for c in range(a.shape[1]):
        square += (a[i, c] + s * (a[after, c] - a[i, c]) - b[j, c] - share * (b[k, c] - b[j, c])) ** 2
    return square
