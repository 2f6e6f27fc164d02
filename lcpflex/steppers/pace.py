"""How a run with step control fares: what there is to say of its steps while it runs."""

from __future__ import annotations

import logging

from lcpflex.basics.progress import tell
from lcpflex.steppers.adaptive import Limits
from lcpflex.steppers.clock import StepClock

__all__ = ["Pace", "stopped_note"]

MOSTLY = 0.5  # part of the steps at the shortest length from which the result warns
NOTICED = 1e-3  # of the velocity threshold: slower ones are drift
WINDOW = 500  # steps of which that is asked at a time, or one more


class Pace:
    """Whether a run has come down to its shortest steps: by the last few hundred steps, however many went before."""

    def __init__(self, shortest: float) -> None:
        self._shortest = shortest
        self._seen = (0.0, 0.0, 0.0)  # time, steps, and those of them at the shortest length
        self._stuck: float | None = None  # since when [s]

    @property
    def due(self) -> int:
        """Steps after which a few hundred are judged: always the same ones, however many are made at a time."""
        return int(self._seen[1]) + WINDOW

    def update(self, clock: StepClock) -> None:
        """Take the clock of a run into account."""
        now = (clock.time, clock.steps, clock.n_shortest)
        made = now[1] - self._seen[1]
        if made < WINDOW:
            return
        if now[2] - self._seen[2] > MOSTLY * made and self._stuck is None:
            self._stuck = self._seen[0]
            tell(self._clause(self._stuck), logging.WARNING)
        self._seen = now

    def _clause(self, since: float) -> str:
        return (
            f"from t = {since:.6g} s on, most steps were as short as allowed, {self._shortest:g} s, and are "
            "not error-controlled: a larger tolerance, a shorter `shortest`, a higher `velocity_threshold`, or a "
            "fixed step suits this scene better"
        )

    def warnings(self, clock: StepClock) -> list[str]:
        """A warning where most steps, of all or of a few hundred in a row, were taken without error control."""
        if clock.n_shortest > MOSTLY * clock.steps:
            return [
                f"{clock.n_shortest} of {clock.steps} steps were as short as allowed, {self._shortest:g} s, "
                "and are not error-controlled: a larger tolerance, a shorter `shortest`, a higher "
                "`velocity_threshold`, or a fixed step suits this scene better"
            ]
        return [] if self._stuck is None else [self._clause(self._stuck)]


def stopped_note(limits: Limits, clock: StepClock) -> list[str]:
    """That approaches were stopped instead of reflected, where that was so."""
    given = limits.velocity_threshold
    threshold = given if given >= 0.0 else limits.slow + limits.rtol * clock.fastest
    if not clock.stopped > NOTICED * threshold:
        return []
    how = f"{given:g} m/s" if given >= 0.0 else "that follows from the tolerances"
    return [
        f"approaches of up to {clock.stopped:.3g} m/s were stopped, not reflected, below a velocity threshold {how}"
    ]
