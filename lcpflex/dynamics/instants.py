"""Instants at which functions of time bend or jump: steps with error control end there, and look often enough between.

Error control sees a load at a few instants of a step: a pulse between two of them would not exist for it.
The instants are found by :mod:`lcpflex.dynamics.time_structure` before a run.
"""

from __future__ import annotations

import math

from lcpflex.jit.kernel import kernel
from lcpflex.model.arrays import Signals

__all__ = ["at_stop", "longest_look", "time_left"]

NEAR = 1e-12  # of the end: an instant so near has been reached


@kernel
def stops_until(signals: Signals, t: float) -> int:
    """How many stops there are up to t."""
    low = 0
    high = len(signals.stops)
    while low < high:
        middle = (low + high) // 2
        if signals.stops[middle] <= t:
            low = middle + 1
        else:
            high = middle
    return low


@kernel
def time_left(signals: Signals, t: float, end: float) -> float:
    """Time from t to the next stop, or to ``end`` if that is earlier [s]."""
    if len(signals.stops) == 0:
        return end - t
    following = stops_until(signals, t + NEAR * end)
    if following == len(signals.stops):
        return end - t
    return min(signals.stops[following], end) - t


@kernel
def longest_look(signals: Signals) -> float:
    """Longest step [s] that looks at all functions of time often enough."""
    return signals.longest[0] if len(signals.longest) > 0 else math.inf


@kernel
def at_stop(signals: Signals, t: float, end: float) -> bool:
    """Whether t is a stop."""
    if len(signals.stops) == 0:
        return False
    return stops_until(signals, t + NEAR * end) > stops_until(signals, t - NEAR * end)
