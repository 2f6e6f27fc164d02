"""What the step does to a choice of bodies: runs with half of it, of the choice and of what it is compared with."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from lcpflex.accuracy.refinement import fineness
from lcpflex.results.words import with_unit
from lcpflex.studies.model_order.scenes import State, told
from lcpflex.studies.model_order.search import Search

if TYPE_CHECKING:
    from lcpflex.studies.model_order.scenes import Fidelities

__all__ = ["HalfSteps", "half_steps", "undersampled"]

BUDGET = 8.0  # runs of the full mesh that a study may take with those of half the step
A_PERIOD = 2.0  # steps, below which a vibration is not seen at all


@dataclass(frozen=True, slots=True)
class HalfSteps:
    """By how much half the step changes the outputs; NaN where that was not run.

    Attributes
    ----------
    own
        Of the choice.
    reference
        Of the bodies that all others are compared with.
    missing
        Which of them were not run, and why; empty where both were, or there is no step to be halved.
    """

    own: float = math.nan
    reference: float = math.nan
    missing: str = ""

    @property
    def largest(self) -> float:
        """The larger one; NaN where none is known."""
        return max((one for one in (self.own, self.reference) if math.isfinite(one)), default=math.nan)


def half_steps(search: Search, state: State) -> HalfSteps:
    """Run half the step with the choice, and with what it is compared with: a promise needs both."""
    assert search.reference is not None
    if fineness(search.stepper_of(search.fidelities.at(state))) is None:
        return HalfSteps(missing="half the step was not run: the stepper has neither a step nor a tolerance")
    own, reference = math.nan, math.nan
    missing = []
    if why := _dear(search, state):
        missing.append(f"with the choice ({why})")
    else:
        own = search.half_step(state, search.used())
    if search.reference == state:
        reference = own
    elif why := _dear(search, search.reference):
        missing.append(f"with {told(search.fidelities.labels(search.reference))} ({why})")
    else:
        reference = search.half_step(search.reference, search.used())
        if not math.isfinite(reference):
            missing.append(f"to its end with {told(search.fidelities.labels(search.reference))}")
    if not math.isfinite(own) and not missing:
        missing.append("to its end with the choice")
    return HalfSteps(own, reference, f"half the step was not run {' and '.join(missing)}" if missing else "")


def _dear(search: Search, state: State) -> str:
    """Why twice the steps are too many; empty where they are not."""
    cost = 2.0 * search.cost(state)
    if cost > search.limit:
        return f"about {cost:.2g} s, limit {search.limit:g} s"
    if search.exceeds(BUDGET, 2.0 * search.usual_cost(state)):
        return "it would have cost too much"
    return ""


def undersampled(fidelities: Fidelities, stepper_of: Callable[[Any], Any]) -> str:
    """Of bodies whose slowest vibration a fixed step cannot show, in words; empty where there is none.

    Half such a step shows no more of it: that two runs agree says nothing.
    """
    stepper = stepper_of(fidelities.scene)
    found = fineness(stepper)
    if found is None or found[0] != "step":
        return ""
    for name, levels in zip(fidelities.names, fidelities.levels, strict=True):
        period = 2.0 * math.pi / float(levels[1].make().frequencies().min())
        if period < A_PERIOD * found[1]:
            return (
                f"the slowest vibration of {name!r} has a period of {with_unit(period, 's')}, less than {A_PERIOD:g} "
                f"steps of {with_unit(found[1], 's')}: no run shows what it does"
            )
    return ""
