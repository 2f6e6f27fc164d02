"""How much damping the steps of a path take: alpha from step to step, and after steps that were refused.

The contact problems of a few contacts take no time, and alpha goes up and down by fixed factors. Those of many contacts
are what a path costs, and each step that is refused is one for nothing. Where damping is what holds, a step is as long
as alpha is small: the next one is given that with which it will be as long as the last ones could be.
"""

from __future__ import annotations

import math

__all__ = ["Damping"]

MORE, LESS = 4.0, 0.2  # alpha after a step that was refused, and after one that was made
BEYOND = 1.2  # times what makes a step that was too long as long as it may be
PATIENCE = 2  # problems of many contacts that are left because they are hard, before one is solved whatever it takes
TWICE = 2.0  # alpha of many contacts, after a step that was refused though it was short enough
MOST, LEAST = 0.85, 0.1  # of the longest step: what many contacts aim at
FARTHER, NEARER = 1.5, 0.5  # that aim after a step that was made at once, of the length of one that was refused


class Damping:
    """alpha of the steps of one path, which may be ``longest`` [m]."""

    def __init__(self, longest: float) -> None:
        self._longest, self._aim, self._refused = longest, MOST, False
        self._kept, self._hard, self._patience = 0.0, 0.0, 0

    @property
    def is_patient(self) -> bool:
        """Whether a contact problem that is hard is left for one with more damping."""
        return self._patience > 0

    def begin(self, first: float, least: float, patient: bool) -> float:
        """alpha with which a step is tried at first: ``first`` if none was made, else no less than ``least``."""
        self._refused, self._patience = False, PATIENCE if patient else 0
        return max(self._kept, least) if self._kept > 0.0 else first

    def refuse(self, alpha: float, length: float, many: bool) -> float:
        """alpha after a step of this length [m] was refused; inf where it was not found."""
        self._refused = True
        if self.is_patient and length == math.inf:
            self._hard = alpha if self._patience == PATIENCE else self._hard
            self._patience -= 1
            return MORE * alpha if self.is_patient else self._hard  # more made it no easier
        if many and length <= self._longest:
            self._aim = max(LEAST, NEARER * length / self._longest)
            return TWICE * alpha
        return alpha * min(MORE, max(BEYOND * length / self._longest, MORE if length <= self._longest else 1.0))

    def make(self, alpha: float, length: float, least: float, many: bool) -> None:
        """A step of this length [m] was made: the next one begins with ``least`` at least."""
        if not many:
            less = LESS if length <= 0.5 * self._longest else 1.0
        else:
            if not self._refused:
                self._aim = min(MOST, FARTHER * self._aim)
            less = min(1.0, max(LESS, length / (self._aim * self._longest)))
        self._kept = max(less * alpha, least)
