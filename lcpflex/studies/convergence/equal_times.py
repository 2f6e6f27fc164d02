"""How far two motions are apart at equal times: what the distance of their graphs forgives, a drift of phase above all.

Both are taken as polylines y(t), z(t), and their difference on the union of their instants, where it is linear. At a
jump of either one both sides count, so that a jump that comes too early costs all of its height in ``largest``, however
early, but only height times delay in ``mean``.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from lcpflex.accuracy.outputs import Measured, Output, coarsened, scale_of_part
from lcpflex.errors import ModelError, shown
from lcpflex.jit.kernel import FloatArray, kernel

__all__ = ["UNKNOWN", "EqualTimes", "apart_at_equal_times", "blur_at_equal_times", "difference_at_equal_times"]


class EqualTimes(NamedTuple):
    """|y(t) - z(t)| relative to a scale, over the times that both have: its mean over time and its largest value."""

    mean: float
    largest: float


UNKNOWN = EqualTimes(math.nan, math.nan)  # of numbers, which have no time


def apart_at_equal_times(output: Output, measured: Measured, reference: Measured) -> EqualTimes:
    """Of the curves of an output the worst, relative to the scale of the reference.

    Infinite for what is not finite, and where there are no common times. Raises ModelError for curves of different
    shapes.
    """
    if not reference.parts or not measured.parts:
        return UNKNOWN
    if not measured.finite:
        return EqualTimes(math.inf, math.inf)
    mean, largest = 0.0, 0.0
    for part, other in zip(measured.parts, reference.parts, strict=True):
        if part.curves.shape[1:] != other.curves.shape[1:]:
            raise ModelError(
                f"outputs: {shown(output.name)} has curves of shape {part.curves.shape[1:]}, its reference "
                f"{other.curves.shape[1:]}; expected the same"
            )
        scale = scale_of_part(output, other)
        if scale == 0.0:
            continue
        for k in range(part.curves.shape[1]):
            found = difference_at_equal_times(
                measured.times, part.curves[:, k].copy(), reference.times, other.curves[:, k].copy()
            )
            if math.isnan(found[0]):
                return EqualTimes(math.inf, math.inf)
            mean, largest = max(mean, found[0] / scale), max(largest, found[1] / scale)
    return EqualTimes(mean, largest)


def blur_at_equal_times(output: Output, measured: Measured) -> float:
    """How well the stored instants describe the curves, on average over time: every second of them against all."""
    if not measured.parts or len(measured.times) < 3:
        return 0.0
    return apart_at_equal_times(output, coarsened(measured), measured).mean


@kernel
def difference_at_equal_times(
    times: FloatArray, values: FloatArray, other_times: FloatArray, other_values: FloatArray
) -> tuple[float, float]:
    """Mean over time, within 25 % above the true one, and largest value of the distance of two polylines in R^d.

    ``times`` (m,) and ``other_times`` (k,) never decrease, ``values`` are (m, d) and (k, d). NaN without common times.
    """
    i, j = 0, 0
    total, span, largest = 0.0, 0.0, math.nan
    while i < len(times) - 1 and j < len(other_times) - 1:
        begin = max(times[i], other_times[j])
        end = min(times[i + 1], other_times[j + 1])
        if end > begin:
            first = _apart(times, values, i, other_times, other_values, j, begin)
            middle = _apart(times, values, i, other_times, other_values, j, 0.5 * (begin + end))
            last = _apart(times, values, i, other_times, other_values, j, end)
            total += 0.25 * (end - begin) * (first + 2.0 * middle + last)  # never too small: the distance is convex
            span += end - begin
            if not largest >= max(first, last):
                largest = max(first, last)
        if times[i + 1] <= other_times[j + 1]:
            i += 1
        else:
            j += 1
    return (total / span if span > 0.0 else math.nan), largest


@kernel
def _apart(
    times: FloatArray, values: FloatArray, i: int, other_times: FloatArray, other_values: FloatArray, j: int, t: float
) -> float:
    """Distance at time t of segment i of one polyline and segment j of the other."""
    s = (t - times[i]) / (times[i + 1] - times[i])
    r = (t - other_times[j]) / (other_times[j + 1] - other_times[j])
    square = 0.0
    for c in range(values.shape[1]):
        one = values[i, c] + s * (values[i + 1, c] - values[i, c])
        other = other_values[j, c] + r * (other_values[j + 1, c] - other_values[j, c])
        square += (one - other) ** 2
    return math.sqrt(square)
