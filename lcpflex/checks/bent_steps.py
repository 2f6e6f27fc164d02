"""Steps within which a function of time bends, and what such a step does not see of it."""

from __future__ import annotations

import numpy as np

from lcpflex.dynamics.time_structure import bends
from lcpflex.jit.kernel import FloatArray

__all__ = ["BentSteps"]

PEAKED = 0.5  # of what a pulse is above both ends of its step: so high it is as long as it lasts


class BentSteps:
    """The k steps within which a polygon bends, and the polygon with their ends among its corners."""

    def __init__(self, times: FloatArray, values: FloatArray, step: float, duration: float) -> None:
        knots = bends(times, values)
        knots = knots[(knots > 0.0) & (knots < duration)]
        number = np.unique(np.floor(knots / step))
        self.begin, self.end = number * step, (number + 1.0) * step
        # (k,) of two rules for the integral over a step: by its middle, and by its ends
        self.middle = step * np.interp(self.begin + 0.5 * step, times, values)
        self.ends = 0.5 * step * (np.interp(self.begin, times, values) + np.interp(self.end, times, values))
        inner = times[(times > 0.0) & (times < duration)]
        self.at = np.unique(np.concatenate([inner, self.begin, self.end]))
        self.value = np.interp(self.at, times, values)
        self.first, self.last = np.searchsorted(self.at, self.begin), np.searchsorted(self.at, self.end)

    def over(self, corners: FloatArray) -> FloatArray:
        """Integral over each step of what has the values ``corners`` at those of the polygon (k,)."""
        pieces = 0.5 * (corners[1:] + corners[:-1]) * np.diff(self.at)
        total = np.concatenate([[0.0], np.cumsum(pieces)])
        return np.asarray(total[self.last] - total[self.first])

    def _off(self) -> tuple[FloatArray, FloatArray]:
        """What the middle rule leaves out of each step, and the larger of that and what the rule of both ends does."""
        whole = self.over(self.value)
        middle = self.middle - whole
        return middle, np.maximum(np.abs(middle), np.abs(self.ends - whole))

    def missed(self) -> tuple[float, float]:
        """What the middle rule leaves out of all steps together, and what one of both rules does of one step."""
        middle, off = self._off()
        return float(np.abs(np.cumsum(middle)).max()), float(off.max())

    def pulse(self) -> tuple[float, float]:
        """When what steps miss most of begins, and for how long it lasts [s]; 0 where it goes on for steps."""
        k = int(self._off()[1].argmax())
        step = self.end[k] - self.begin[k]
        first, last = np.searchsorted(self.at, [self.begin[k] - step, self.end[k] + step])  # it may be at an end
        inside = slice(max(int(first) - 1, 0), int(last) + 1)
        at, value = self.at[inside], self.value[inside]
        beside = np.abs(value - np.interp(at, at[[0, -1]], value[[0, -1]]))
        high = np.flatnonzero(beside > PEAKED * beside.max())
        if not len(high) or abs(value[-1] - value[0]) > PEAKED * beside.max():
            return float(self.begin[k]), 0.0
        first, last = max(int(high[0]) - 1, 0), min(int(high[-1]) + 1, len(at) - 1)
        return float(at[high[0]]), float(0.5 * (at[last] - at[first] + at[high[-1]] - at[high[0]]))

    def beside_chords(self) -> float:
        """Area between the polygon and the chords of the steps, of all together."""
        ends = np.concatenate([self.first, self.last])
        ends = ends[np.argsort(self.at[ends], kind="stable")]
        chord = np.interp(self.at, self.at[ends], self.value[ends])
        return float(self.over(np.abs(self.value - chord)).sum())

    def lost_path(self) -> float:
        """What the polygon goes to and fro within steps, of all together."""
        gone = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(self.value)))])
        straight = np.abs(self.value[self.last] - self.value[self.first])
        return float((gone[self.last] - gone[self.first] - straight).sum())
