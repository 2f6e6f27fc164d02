"""Touches of compliant contacts that take too few steps of one length for their force law to act, in words."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from lcpflex.basics.alarm import Alarm
from lcpflex.force_laws.history import ENOUGH, FEWEST, OF_ALL, OF_COARSE, TIMES_STEPS
from lcpflex.jit.kernel import FloatArray

__all__ = ["NO_TOUCHES", "Touches", "rounded_down"]

COARSE = 0.05  # of the impulse of a contact: touches of too few steps that have more matter
FEW, SHARE = 5, 0.2  # steps of touches on the mean: fewer, with such a share of the impulse, are off by more than 5 %
SHORTER = 0.95  # of the step that makes ENOUGH of what was counted, whose ends fall anywhere within steps


class Touches(NamedTuple):
    """Those of a run. ``counted``: of :class:`lcpflex.force_laws.history.ContactMemory`; ``step`` [s]."""

    counted: FloatArray
    step: float

    def enough(self) -> dict[int, float]:
        """By law, the step [s] that would do, where a share of its impulse was given in too few steps."""
        return {
            law: SHORTER * self.step * float(row[FEWEST]) / ENOUGH
            for law, row in enumerate(self.counted[:-1])
            if row[OF_COARSE] > COARSE * row[OF_ALL]
        }

    def warnings(self, names: Sequence[str]) -> list[str]:
        """One for each such contact."""
        return [
            f"the touches of contact {names[law]!r} take as few as {self._steps(law)}, and a force law needs at least "
            f"{ENOUGH}: the rebound is off; take steps of at most {rounded_down(enough):.2g} s, or error control"
            for law, enough in self.enough().items()
        ]

    def alarms(self, names: Sequence[str]) -> list[Alarm]:
        """Of those that take so few that little is left of the law."""
        return [
            Alarm(
                f"the touches of contact {names[law]!r} take as few as {self._steps(law)}, in which a force law cannot "
                "act",
                "steps in a touch",
                f"contact {names[law]!r}",
                None,
                float(self.counted[law, FEWEST]),
                f"take steps of at most {rounded_down(enough):.2g} s",
            )
            for law, enough in self.enough().items()
            if self.counted[law, TIMES_STEPS] < FEW * self.counted[law, OF_COARSE]
            and self.counted[law, OF_COARSE] > SHARE * self.counted[law, OF_ALL]
        ]

    def _steps(self, law: int) -> str:
        steps = int(self.counted[law, FEWEST])
        return "1 step" if steps == 1 else f"{steps} steps"


NO_TOUCHES = Touches(np.zeros((0, 0)), 0.0)


def rounded_down(value: float) -> float:
    """To two digits, so that what is shown is no more than it."""
    unit = 10.0 ** (math.floor(math.log10(value)) - 1)
    return math.floor(value / unit * (1.0 + 1e-12)) * unit
