"""Distance of two motions that forgives a jump its time: that of their completed graphs.

Two velocities that jump at t and at t + dt differ by the whole jump in between, however small dt is: errors taken at
equal times do not converge across impacts. The completed graph of y is the curve (t, y(t)) with the jumps filled in by
vertical segments; seen as sets, the two graphs are dt apart. With both axes made dimensionless,

    P = { (t/T, y/Y) },   d(A, B) = max( max_{a in A} min_{b in B} |a - b|,  max_{b in B} min_{a in A} |a - b| )

is the Hausdorff distance, a metric; its one-sided parts are not. For motions without jumps it is at most, and with
slopes of order Y/T about, the largest error at equal times. Source of the convergence of time stepping in this
distance: Moreau 1978, "Approximation en graphe d'une évolution discontinue".

The nearest point is sought in a tree of boxes, and only until it is no farther than the farthest one known: the time
grows little faster than the number of corners, however far apart the graphs are.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from lcpflex.basics.arguments import flag, numbers
from lcpflex.errors import ModelError, in_range, shown
from lcpflex.jit.kernel import FloatArray, IntArray, kernel

__all__ = ["graph_distance"]

SHARE = 0.02  # of the distance: to this a segment's largest distance is searched
GRAIN = 1e-5  # least spacing of the points tried on a segment: finely sampled graphs need none
HALVINGS = 10  # of a segment, at most
SMALLEST = 1.0 / 2**HALVINGS
RUN = 8  # segments in a box
WALK = 16  # segments tried about the time of a point before the boxes are
LARGEST = 1e100  # a coordinate: squares of such are numbers
SPARSE = 61  # the first look takes every so manieth segment


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
    two_sided = flag("two_sided", two_sided)
    far = _farthest(one, _tree(other), 0.0)
    return _farthest(other, _tree(one), far) if two_sided else far


def _polyline(name: str, times: FloatArray, values: FloatArray, time_scale: float, value_scale: float) -> FloatArray:
    """Corners (m, 1 + d), dimensionless."""
    clock = "times" if name == "values" else "other_times"
    t, y = numbers(times), numbers(values)
    if t is None or y is None:
        what, given = (clock, times) if t is None else (name, values)
        raise ModelError(f"{what}: {shown(given)} was given, expected an array of numbers")
    if t.ndim != 1 or not t.size or y.ndim not in (1, 2) or len(y) != len(t):
        raise ModelError(f"{name}: shape {y.shape} at times of shape {t.shape}; expected (m,) or (m, d) at (m,), m > 0")
    if not (np.isfinite(t).all() and np.isfinite(y).all()):
        raise ModelError(f"{name}: times or values that are not finite; expected finite numbers")
    if np.any(np.diff(t) < 0.0):
        raise ModelError(f"{name}: times that decrease; expected times in order")
    scales = ("time_scale", t, time_scale), ("value_scale", y, value_scale)
    for what, coordinates, scale in scales:
        most = float(np.abs(coordinates).max(initial=0.0))
        if not most <= LARGEST * scale:
            raise ModelError(
                f"{what}: {scale:g} was given, expected a scale nearer to the size of the graphs, {most:g}"
            )
    return np.ascontiguousarray(np.column_stack([t / time_scale, y / value_scale]))


class _Tree(NamedTuple):
    """Polyline (m, n) and the boxes about runs of its segments, as a binary heap: the children of k are 2k, 2k + 1."""

    line: FloatArray
    low: FloatArray  # (2 leaves, n)
    high: FloatArray


def _tree(line: FloatArray) -> _Tree:
    runs = max(1, -(-(len(line) - 1) // RUN))
    leaves = 1 << (runs - 1).bit_length()
    low = np.full((2 * leaves, line.shape[1]), math.inf)
    high = np.full((2 * leaves, line.shape[1]), -math.inf)
    starts = np.arange(runs) * RUN
    ends = np.minimum(starts + RUN, len(line) - 1)  # the last corner of a run is the first one of the next
    for ufunc, box in ((np.minimum, low), (np.maximum, high)):
        box[leaves : leaves + runs] = ufunc(ufunc.reduceat(line, starts, axis=0), line[ends])
        width = leaves
        while width > 1:
            level = box[width : 2 * width]
            box[width // 2 : width] = ufunc(level[0::2], level[1::2])
            width //= 2
    return _Tree(line, low, high)


def _farthest(a: FloatArray, b: _Tree, known: float) -> float:
    """Largest distance of a point of polyline a from polyline b, or ``known`` if that is larger."""
    point, stack = np.empty(a.shape[1]), np.empty(2 * b.low.shape[0].bit_length() + 2, dtype=np.int64)
    pieces = np.empty((HALVINGS + 2, 3))
    for stride in (SPARSE, 1):  # a distance that is large already makes all others cheap
        known = _largest(a, *b, known, stride, point, stack, pieces)
    return known


@kernel
def _largest(
    a: FloatArray, b: FloatArray, low: FloatArray, high: FloatArray, known: float, stride: int,
    point: FloatArray, stack: IntArray, pieces: FloatArray,
) -> float:  # fmt: skip
    """The distance of the farthest point of every ``stride``-th segment of a, or ``known`` if that is larger.

    A piece whose points may be farther than what is known is halved.
    """
    near, last = 0, 0
    best = known
    here, place, following = 0.0, 0, -1  # distance of the first corner of segment ``following``, and where from
    for i in range(0, max(len(a) - 1, 1), stride):
        while near < len(b) - 2 and b[near + 1, 0] <= a[i, 0]:
            near += 1
        if following != i:
            here, place = _nearest(a, i, 0.0, b, low, high, near, last, best, point, stack)
        there, last = _nearest(a, i, 1.0, b, low, high, near, place, max(best, here), point, stack)
        best = max(best, here, there)
        pieces[0, 0], pieces[0, 1], pieces[0, 2] = 0.0, here, place
        pieces[1, 0], pieces[1, 1], pieces[1, 2] = 1.0, there, last
        count = 1  # of pieces; row ``count`` is the end of the one looked at, the row below its beginning
        while count > 0:
            width = pieces[count, 0] - pieces[count - 1, 0]
            if width <= SMALLEST or _bound(a, i, b, pieces, count, point) <= (1.0 + SHARE) * best + 0.5 * GRAIN:
                count -= 1
                continue
            for c in range(3):
                pieces[count + 1, c] = pieces[count, c]
            s = pieces[count - 1, 0] + 0.5 * width
            middle, where = _nearest(a, i, s, b, low, high, near, last, best, point, stack)
            pieces[count, 0], pieces[count, 1], pieces[count, 2] = s, middle, where
            best = max(best, middle)
            count += 1
        here, place, following = there, last, i + 1
    return best


@kernel
def _bound(a: FloatArray, i: int, b: FloatArray, pieces: FloatArray, k: int, point: FloatArray) -> float:
    """Largest distance that a point of segment i of a, between the places of rows k - 1 and k, can have from b.

    By the triangle, (d1 + d2 + length)/2; and, for the distance from one segment is convex, the larger one of the two
    ends from the segment that is nearest to either.
    """
    length = 0.0
    for c in range(a.shape[1]):
        length += (a[min(i + 1, len(a) - 1), c] - a[i, c]) ** 2
    first, last = pieces[k - 1, 1], pieces[k, 1]
    least = 0.5 * (first + last + (pieces[k, 0] - pieces[k - 1, 0]) * math.sqrt(length))
    _point(a, i, pieces[k, 0], point)
    least = min(least, max(first, math.sqrt(_to_segment(point, b, int(pieces[k - 1, 2])))))
    _point(a, i, pieces[k - 1, 0], point)
    least = min(least, max(last, math.sqrt(_to_segment(point, b, int(pieces[k, 2])))))
    return float(least)


@kernel
def _point(a: FloatArray, i: int, s: float, point: FloatArray) -> None:
    """Write a_i + s (a_{i+1} - a_i) into ``point``."""
    after = min(i + 1, len(a) - 1)
    for c in range(a.shape[1]):
        point[c] = a[i, c] + s * (a[after, c] - a[i, c])


@kernel
def _nearest(
    a: FloatArray, i: int, s: float, b: FloatArray, low: FloatArray, high: FloatArray, near: int, last: int,
    enough: float, point: FloatArray, stack: IntArray,
) -> tuple[float, int]:  # fmt: skip
    """Distance of the point a_i + s (a_{i+1} - a_i) from polyline b, or one up to ``enough``; and a segment there.

    Segments ``near`` and ``last`` are tried first, then those about ``near``; then the boxes that come nearer than what
    is found.
    """
    _point(a, i, s, point)
    best, where = _to_segment(point, b, near), near
    square = _to_segment(point, b, last)
    if square < best:
        best, where = square, last
    left, right = near, near  # segments farther in time than what is found can be left out, as in most cases all are
    while right - left < WALK and best > enough * enough:
        ahead = right < len(b) - 2 and max(b[right + 1, 0] - point[0], 0.0) ** 2 < best
        behind = left > 0 and max(point[0] - b[left, 0], 0.0) ** 2 < best
        if not ahead and not behind:
            return math.sqrt(best), where
        if ahead:
            right += 1
            square = _to_segment(point, b, right)
            if square < best:
                best, where = square, right
        if behind:
            left -= 1
            square = _to_segment(point, b, left)
            if square < best:
                best, where = square, left
    leaves = low.shape[0] // 2
    stack[0] = 1
    count = 1
    while count > 0 and best > enough * enough:
        count -= 1
        node = stack[count]
        if _to_box(point, low, high, node) >= best:
            continue
        if node >= leaves:
            first = (node - leaves) * RUN
            for k in range(first, max(min(first + RUN, len(b) - 1), first + 1)):
                square = _to_segment(point, b, k)
                if square < best:
                    best, where = square, k
        else:
            first_half = _to_box(point, low, high, 2 * node)
            second_half = _to_box(point, low, high, 2 * node + 1)
            farther = 2 * node + (1 if first_half <= second_half else 0)
            if max(first_half, second_half) < best:
                stack[count] = farther
                count += 1
            if min(first_half, second_half) < best:
                stack[count] = 4 * node + 1 - farther  # the other one, looked at first
                count += 1
    return math.sqrt(best), where


@kernel
def _to_box(point: FloatArray, low: FloatArray, high: FloatArray, node: int) -> float:
    """Squared distance of a point from a box; infinite for an empty one."""
    square = 0.0
    for c in range(len(point)):
        gap = max(low[node, c] - point[c], point[c] - high[node, c], 0.0)
        square += gap * gap
    return square


@kernel
def _to_segment(point: FloatArray, b: FloatArray, j: int) -> float:
    """Squared distance of a point from the segment b_j b_{j+1}, from b_j alone where that is the last corner."""
    k = min(j + 1, len(b) - 1)
    along, length = 0.0, 0.0
    for c in range(len(point)):
        edge = b[k, c] - b[j, c]
        along += (point[c] - b[j, c]) * edge
        length += edge * edge
    share = 0.0
    if length > 0.0:
        share = min(max(along / length, 0.0), 1.0)
    square = 0.0
    for c in range(len(point)):
        square += (point[c] - b[j, c] - share * (b[k, c] - b[j, c])) ** 2
    return square
