"""Which instants a run stores: those of its record, and those that sensors ask for at rates of their own.

Each rate keeps its own account of what it has stored, as if it were the only one: so what comes of it does not depend
on the others. Rate 0 is that of the record.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from lcpflex.jit.kernel import FloatArray, IntArray, kernel
from lcpflex.jit.struct import allocate, array, struct

__all__ = [
    "Rates",
    "ask_all",
    "ask_at",
    "ask_step",
    "ask_time",
    "next_instant",
    "rates",
    "stored_at",
    "strides_of",
    "went_on",
]

SAME = 1e-12  # of the duration: instants nearer than that are one


@struct
class Rates:
    """Accounts of the rates; of ``interval``, ``stride``, ``count`` and ``due`` entry 0 is kept by the loop itself."""

    least: float  # under step doubling: time between stored instants, at least [s]
    now: IntArray = array("rates")  # 1: the rate asks for the instant about to be stored
    interval: FloatArray = array("rates")  # between instants [s]; 0: the end of each step
    stride: IntArray = array("rates")  # the same in steps of one length
    count: IntArray = array("rates")  # instants at multiples of the interval so far; -1: all are stored
    due: FloatArray = array("rates")  # of step doubling: time of the next instant [s]
    done: IntArray = array("rates")  # steps whose ends are stored, of rates that ask for each


def rates(intervals: Sequence[float]) -> Rates:
    """For the record and sensors with these intervals [s]."""
    number = 1 + len(intervals)
    made = allocate(Rates, {"rates": number}, stride=np.ones(number, dtype=np.int64))
    made.now[:] = 1
    made.interval[1:] = intervals
    return made


def strides_of(rates: Rates, step: float) -> None:
    """Intervals in steps of this length [s]."""
    for r, interval in enumerate(rates.interval[1:].tolist(), 1):
        rates.stride[r] = max(1, round(interval / step))


@kernel
def ask_all(rates: Rates) -> None:
    """All rates ask for the present instant: it is a side of an event."""
    for r in range(len(rates.now)):
        rates.now[r] = 1


@kernel
def ask_step(rates: Rates, stride: int, steps: int, last: int) -> bool:
    """Which rates ask for the state after ``steps`` steps of one length; ``stride``: steps between those of the record.

    All ask for that after the ``last`` one.
    """
    some = False
    for r in range(len(rates.now)):
        each = stride if r == 0 else rates.stride[r]
        asks = steps == last or steps % each == 0
        rates.now[r] = 1 if asks else 0
        some = some or asks
    return some


@kernel
def ask_time(rates: Rates, due: float, time: float, ended: bool) -> bool:
    """Which rates ask for the state at the end of a step of any length; ``due``: time of the next one of the record."""
    some = False
    for r in range(len(rates.now)):
        next_one = due if r == 0 else rates.due[r]
        asks = next_one <= time or (ended and next_one < math.inf)
        rates.now[r] = 1 if asks else 0
        some = some or asks
    return some


@kernel
def went_on(rates: Rates, time: float, ended: bool) -> None:
    """Behind an instant that :func:`ask_time` asked for: when the next one of each rate but the record's is due."""
    for r in range(1, len(rates.now)):
        if rates.now[r] == 1:
            rates.due[r] = math.inf if ended else time + max(rates.interval[r], rates.least)


@kernel
def next_instant(rates: Rates, r: int, interval: float, count: int, steps: int, end: float, duration: float) -> float:
    """Time of the next instant of rate r [s], in a step to ``end`` behind ``steps`` others; infinite if none is left.

    ``interval``, ``count``: those of the rate.
    """
    if count < 0:
        return math.inf
    if interval > 0.0:
        return min(count * interval, duration)
    return end if rates.done[r] <= steps else math.inf


@kernel
def ask_at(rates: Rates, own: float, steps: int, end: float, duration: float) -> float:
    """The first of the next instants of all rates [s], and which ask for it; ``own``: that of the record."""
    first = own
    for r in range(1, len(rates.now)):
        first = min(first, next_instant(rates, r, rates.interval[r], rates.count[r], steps, end, duration))
    rates.now[0] = 1 if own == first else 0
    for r in range(1, len(rates.now)):
        at = next_instant(rates, r, rates.interval[r], rates.count[r], steps, end, duration)
        rates.now[r] = 1 if at == first else 0
    return first


@kernel
def stored_at(rates: Rates, t: float, steps: int, duration: float) -> bool:
    """Behind an instant that was stored at t: go on to the next one of each rate; whether t is the end.

    The count of the record is the loop's.
    """
    last = t >= duration * (1.0 - SAME)
    for r in range(len(rates.now)):
        if rates.now[r] == 1:
            rates.done[r] = steps + 1
            if r > 0:
                rates.count[r] = -1 if last else rates.count[r] + 1
    return last
