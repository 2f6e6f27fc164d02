"""Thresholds that rise for a while where events come too fast to be located one by one, and the words for it.

Impacts and reversals of slip may accumulate so slowly that thousands of them are far below anything that matters: a
raised threshold ends them a little earlier. It stays small beside the velocities that contacts have had, and it
returns to what it was after a while.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from lcpflex.steppers.event_driven.memory import EVENT_KINDS, LIFT_OFF, REVERSES, SLIPS, STICKS, WINDOW, EventSettings
from lcpflex.steppers.event_driven.remarks import times
from lcpflex.steppers.named import listed

__all__ = ["SLIP_PART", "SPATIAL_SLIP_PART", "Thresholds"]

SLIP_PART = 1e-3  # of the velocity threshold: slower slip counts as none
SPATIAL_SLIP_PART = 1e-2  # the same in space, where slip that ends has no change of sign to be found by
RISE = 10.0  # of the velocity threshold at once
SLIP_RISE = 100.0  # of the slip threshold
WORTH = 1.5  # a smaller rise is none
LIMIT = 1e-2  # of the largest velocity of a contact: no threshold rises beyond
LASTS = 4.0  # times that WINDOW events may take at least: how long a rise lasts
OF_SLIP = {EVENT_KINDS[kind] for kind in (STICKS, SLIPS, REVERSES)}

Events = list[tuple[float, str, int, float]]


def of_slip(events: Events) -> bool:
    """Whether more of the events are of slip than of impacts."""
    slips = sum(kind in OF_SLIP for _, kind, _, _ in events)
    return slips > sum(kind not in OF_SLIP and kind != EVENT_KINDS[LIFT_OFF] for _, kind, _, _ in events)


class Thresholds:
    """The settings of a run with its thresholds as they are at present."""

    def __init__(self, settings: EventSettings) -> None:
        self.settings = settings
        self._base = settings
        self._times = 0
        self._first = math.nan
        self._contacts: set[int] = set()
        self._highest = self._highest_slip = 0.0

    def rise(self, events: Events, time: float, fastest: float, gentlest: float, slips: bool | None = None) -> bool:
        """Raise the threshold that ends most of the last ``events``; False where it must not rise further.

        fastest: largest velocity of a contact so far; gentlest: approach of the slowest impact lately [m/s]; slips:
        whether they are of slip, not of impacts, where they do not tell.
        """
        recent = events[-WINDOW:]
        now, limit = self.settings, LIMIT * fastest
        velocity = min(RISE * now.velocity_threshold, limit)
        slip = min(SLIP_RISE * now.slip_threshold, limit)
        if of_slip(recent) if slips is None else slips:
            if not slip > WORTH * now.slip_threshold:
                return False
            now = now._replace(slip_threshold=slip)
            self._highest_slip = max(self._highest_slip, slip)
        else:
            if gentlest > limit or not velocity > WORTH * now.velocity_threshold:
                return False
            now = now._replace(velocity_threshold=velocity)
            self._highest = max(self._highest, velocity)
        self.settings = now._replace(calm=time + LASTS * now.least_window)
        self._contacts |= {law for _, _, law, _ in recent}
        self._times += 1
        if self._times == 1:
            self._first = time
        return True

    def fall(self) -> None:
        """Return to the thresholds that were asked for."""
        self.settings = self._base

    def more_laws(self, components: int) -> None:
        """The state has so many components more, all of them impulses."""
        longer = np.pad(self._base.atol, (0, components), mode="edge")
        self.settings, self._base = self.settings._replace(atol=longer), self._base._replace(atol=longer)

    def remarks(self, name: Callable[[int], str]) -> list[str]:
        """That thresholds were raised, if they were; ``name``: what a contact is called."""
        if not self._times:
            return []
        raised = []
        if self._highest:
            raised.append(f"approach slower than {self._highest:.3g} m/s was stopped, not reflected")
        if self._highest_slip:
            raised.append(f"slip slower than {self._highest_slip:.3g} m/s counted as none")
        return [
            f"events accumulated faster than {self.most} "
            f"{times(self._times)}, first at t = {self._first:.9g} s, of {listed(sorted(self._contacts), name)}: for "
            f"{LASTS * self._base.least_window:.3g} s each time {' and '.join(raised)}; "
            "a larger most_events follows them for longer, MoreauJean(step=...) takes those of a step together"
        ]

    @property
    def most(self) -> str:
        """Events a second that are not followed further, with the name of the argument."""
        return f"{WINDOW / self._base.least_window:g} a second (most_events)"
