"""Means of forces over a step: steps of fixed length take the impulse of a load that bends or swings within them.

A value in the middle of the step would miss a pulse beside it, and would make a constant force of an oscillation.
"""

from __future__ import annotations

import math

from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.kinematics.signal_values import signal_value
from lcpflex.model.arrays import Signals

__all__ = ["force_value"]

PIECES, HARMONIC = 0, 1  # kinds of functions
SLOW = 0.15  # half of omega h, up to which the value in the middle is the mean to (omega h / 2)^2 / 6


@kernel
def integral(signals: Signals, index: int, begin: float, end: float) -> float:
    """Integral of a table of straight lines; NaN where it has no break between ``begin`` and ``end``."""
    first = signals.first[index]
    last = signals.last[index] - 1
    if end <= signals.breaks[first] or begin >= signals.breaks[last]:
        return math.nan
    low = first
    high = last
    while high - low > 1:
        middle = (low + high) // 2
        if signals.breaks[middle] <= begin:
            low = middle
        else:
            high = middle
    total = 0.0
    at = begin
    if at < signals.breaks[first]:
        total = signals.coefficients[first, 3] * (signals.breaks[first] - at)
        at = signals.breaks[first]
    elif end <= signals.breaks[low + 1]:
        return math.nan
    while at < end and low < last:
        until = min(end, signals.breaks[low + 1])
        place = 0.5 * (at + until) - signals.breaks[low]
        total += (signals.coefficients[low, 2] * place + signals.coefficients[low, 3]) * (until - at)
        at = until
        low += 1
    return total + signals.coefficients[last, 3] * (end - at)


@kernel
def force_value(signals: Signals, index: int, t: float, span: FloatArray, external: FloatArray) -> float:
    """Function ``index`` at time t; its mean from t - span[0] to t + span[1] where it bends or swings there."""
    length = span[0] + span[1]
    if length > 0.0 and signals.kind[index] == PIECES:
        whole = integral(signals, index, t - span[0], t + span[1])
        if not math.isnan(whole):
            return whole / length
    value, rate, _ = signal_value(signals, index, t, external)
    if length > 0.0 and signals.kind[index] == HARMONIC:
        half = 0.5 * length * signals.coefficients[signals.first[index], 2]
        if abs(half) > SLOW:
            mean = signals.coefficients[signals.first[index], 0]
            off = 0.5 * (span[1] - span[0]) * signals.coefficients[signals.first[index], 2]
            omega = signals.coefficients[signals.first[index], 2]
            swing = (value - mean) * math.cos(off) + rate / omega * math.sin(off)
            return mean + swing * math.sin(half) / half
    return value
