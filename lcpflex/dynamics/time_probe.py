"""Python functions of time, looked at before a run: where they bend, and what they do for a moment only.

A thousand instants come first, and more where straight lines between them miss the function. Then as many as a hundred
thousand, one at random in each of as many cells of equal length, with a fixed seed, so that no period hides from them:
a pulse that lasts longer than two cells is seen for sure, a shorter one mostly. Where they are off
these straight lines, the function is followed more closely, too. How many they are is decided by the number of calls
that one look at the function makes, and never by a clock: numbers of a run must not hang on the load of a machine.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from itertools import pairwise
from typing import Any

import numpy as np

from lcpflex.jit.kernel import FloatArray

__all__ = ["INTERVALS", "probed", "unseen"]

BENT = 0.05  # of the range: by how much a straight line may be off
UNEXPLAINED = 2.0 * BENT  # of the range: a value that straight lines have missed, of those that are good to BENT
INTERVALS = 512  # of the first probe, two calls each
MOST_CALLS = 20_000  # to follow what bends
FINEST = 1e-6  # of the duration, to which a jump is located
CELLS = 100_000  # looks at what costs no more than CHEAP calls
CHEAP = 16  # calls of Python or C functions in one look: .2 s for all of them, at ten million a second
MOST_FOLLOWED = 1000  # instants that are off, of which the function is followed
SEED = 20240229
GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)


def probed(function: Callable[[float], Any], duration: float, closely: bool = True) -> tuple[FloatArray, FloatArray]:
    """Instants (k,) and values (k, components) of a function of time, close to each other where it bends.

    ``closely``: with the hundred thousand looks, not of what costs a state or a system to be asked, too.
    What raises or returns no finite number is left out: if a run comes there, it says so itself.
    """
    probe = _Probe(function, duration)
    if not probe.begun:
        return np.zeros(0), np.zeros((0, 1))
    if probe.follow(list(pairwise(probe.edges)), MOST_CALLS) and closely:
        probe.follow(probe.off(), 2 * MOST_CALLS)
    return probe.found()


def unseen(function: Callable[[float], Any], duration: float) -> tuple[float | None, float]:
    """Where a function that was not probed closely does something for a moment [s], and the width looked for [s].

    None: nowhere. Twice a cell is the width that is seen for sure.
    """
    width = 2.0 * duration / _cells(function, duration)
    probe = _Probe(function, duration)
    if not probe.begun or not probe.follow(list(pairwise(probe.edges)), MOST_CALLS):
        return None, width
    off = probe.off()
    return (0.5 * sum(off[0]) if off else None), width


class _Probe:
    """What is known of a function over a duration [s]."""

    def __init__(self, function: Callable[[float], Any], duration: float) -> None:
        self._function, self._duration = function, duration
        self._called: dict[float, FloatArray | None] = {}
        # spread unevenly, so that no period hides between them
        spread = np.arange(1, INTERVALS) + 0.6 * ((np.arange(1, INTERVALS) * GOLDEN) % 1.0 - 0.5)
        self.edges = [0.0, *(spread * duration / INTERVALS).tolist(), duration]
        known = [value for t in self.edges if (value := self._at(t)) is not None]
        self.begun = len(known) > 1 and len({value.size for value in known}) == 1
        if self.begun:
            self._first, self._span = known[0], np.ptp(np.array(known), axis=0)

    def _at(self, t: float) -> FloatArray | None:
        if t not in self._called:
            self._called[t] = _value(self._function, t)
        return self._called[t]

    def follow(self, waiting: list[tuple[float, float]], calls: int) -> bool:
        """Halve intervals in which the function bends; whether so many calls in all were enough."""
        while waiting and len(self._called) < calls:
            finer: list[tuple[float, float]] = []
            for low, high in waiting:
                middle = 0.5 * (low + high)
                first, value, last = self._at(low), self._at(middle), self._at(high)
                if first is None or value is None or last is None or value.size != self._span.size:
                    continue
                self._span = np.maximum(self._span, np.abs(value - self._first))
                bent = np.abs(value - 0.5 * (first + last)) > BENT * self._span
                if bent.any() and high - low > FINEST * self._duration and len(self._called) < calls:
                    finer += [(low, middle), (middle, high)]
            waiting = finer
        return not waiting

    def off(self) -> list[tuple[float, float]]:
        """Intervals about instants at which the function is off the straight lines through what is known."""
        times, values = _looks(self._function, self._duration, self._span.size)
        if not len(times):
            return []
        known, lines = self.found()
        span = np.maximum(self._span, np.ptp(values, axis=0))
        drawn = np.stack([np.interp(times, known, line) for line in lines.T], axis=1)
        share = np.divide(np.abs(values - drawn), span, out=np.zeros_like(values), where=span > 0.0).max(axis=1)
        share[np.diff(known)[np.clip(np.searchsorted(known, times) - 1, 0, len(known) - 2)] <= self._located] = 0.0
        off = np.flatnonzero(share > UNEXPLAINED)
        off = np.sort(off[np.argsort(-share[off], kind="stable")[:MOST_FOLLOWED]])
        self._span = span
        corners = times[np.unique(np.clip(off[:, None] + np.arange(-1, 2), 0, len(times) - 1))]
        cell = 2.0 * self._duration / len(times)
        return [(low, high) for low, high in pairwise(corners.tolist()) if high - low <= cell]

    @property
    def _located(self) -> float:
        """Length of an interval that was not halved any more [s]: somewhere in it is a jump."""
        return FINEST * self._duration

    def found(self) -> tuple[FloatArray, FloatArray]:
        """All that is known: instants and values."""
        times = [t for t in sorted(self._called) if self._called[t] is not None]
        return np.array(times), np.array([self._called[t] for t in times])


def _value(function: Callable[[float], Any], t: float) -> FloatArray | None:
    """What the function returns, as an array; None where that is no finite number."""
    try:
        values = np.atleast_1d(np.asarray(function(t), dtype=float)).ravel()
    except Exception:  # left to the run, which tells where it was
        return None
    return values if np.isfinite(values).all() else None


def _looks(function: Callable[[float], Any], duration: float, components: int) -> tuple[FloatArray, FloatArray]:
    """Instants (k,), one in each cell, and values (k, components); none of a function that raises at one of them."""
    cells = _cells(function, duration)
    times = (np.arange(cells) + np.random.default_rng(SEED).random(cells)) * (duration / cells)
    try:
        values = np.array([function(t) for t in times.tolist()], dtype=float).reshape(cells, -1)
    except Exception:  # left to the run, which tells where it was
        return np.zeros(0), np.zeros((0, components))
    finite = np.isfinite(values).all(axis=1)
    if values.shape[1] != components or not finite.any():
        return np.zeros(0), np.zeros((0, components))
    return times[finite], values[finite]


def _cells(function: Callable[[float], Any], duration: float) -> int:
    """In how many cells of equal length a function is looked at: fewer, the more a look at it costs."""
    return max(CELLS // max(1, math.ceil(_calls_of(function, 0.5 * duration) / CHEAP)), 2 * INTERVALS)


def _calls_of(function: Callable[[float], Any], t: float) -> int:
    """How many functions of Python and of C are called in one look."""
    count, before = 0, sys.getprofile()

    def counted(frame: Any, event: str, what: Any) -> None:
        nonlocal count
        count += event in ("call", "c_call")

    sys.setprofile(counted)
    try:
        function(t)
    except Exception:  # left to the run, which tells where it was
        count += 0
    finally:
        sys.setprofile(before)
    return count
