"""What the steps do to a choice of bodies: its error by reruns, and that of what it is compared with."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from lcpflex.accuracy.refinement import fineness
from lcpflex.accuracy.reruns import QUARTER
from lcpflex.results.words import with_unit
from lcpflex.studies.claims import RERUNS, Claim
from lcpflex.studies.model_order.scenes import State, told
from lcpflex.studies.model_order.search import Search

if TYPE_CHECKING:
    from lcpflex.studies.model_order.scenes import Fidelities

__all__ = ["StepErrors", "step_errors", "undersampled"]

BUDGET = 12.0  # runs of the full mesh that a study may take with the reruns that a promise needs, each four of its own
THOROUGH = 10.0  # and with those by another method
A_PERIOD = 2.0  # steps, below which a vibration is not seen at all
UNKNOWN = Claim()


@dataclass(frozen=True, slots=True)
class StepErrors:
    """The errors that the steps leave in the outputs, by reruns.

    Attributes
    ----------
    own
        Of the choice.
    reference
        Of the bodies that all others are compared with.
    missing
        Of which of them it is not known, and why; empty where it is of both.
    """

    own: Claim = UNKNOWN
    reference: Claim = UNKNOWN
    missing: str = ""

    @property
    def largest(self) -> float:
        """The larger one; NaN where none is known."""
        return max((one for one in (self.own.largest, self.reference.largest) if math.isfinite(one)), default=math.nan)


def step_errors(search: Search, state: State) -> StepErrors:
    """Run the choice again, and what it is compared with: a promise needs both.

    Each with a quarter of the step, and by another method where counted work leaves enough for that.
    """
    assert search.reference is not None
    left = search.left_of(BUDGET)
    same = search.reference == state
    kept = 0.0 if same else QUARTER * search.usual_cost(search.reference)  # no promise without that
    own, missing = _claim(search, state, left - kept)
    if same:
        reference = own
    else:
        left -= QUARTER * search.usual_cost(state) * len(own.reruns)
        reference, more = _claim(search, search.reference, left)
        missing = " and ".join(one for one in (missing, more) if one)
    return StepErrors(own, reference, f"the error of the steps is not known with {missing}" if missing else "")


def _claim(search: Search, state: State, left: float) -> tuple[Claim, str]:
    """The error of a state, by as many reruns as are left; and where there is none, of which bodies, and why."""
    found, why = UNKNOWN, ""
    cost, usual = QUARTER * search.cost(state), QUARTER * search.usual_cost(state)
    if cost > search.limit:
        why = f"about {cost:.2g} s, limit {search.limit:g} s"
    elif left < usual:
        why = "it would have cost too much"
    else:
        spare = left - (BUDGET - THOROUGH) * search.usual_cost(search.fidelities.top)
        found = search.claim(state, search.used(), RERUNS if RERUNS * usual <= spare else 1)
        if not found.reruns:
            why = "; ".join(found.missing)[:200]
    return found, f"{told(search.fidelities.labels(state))} ({why})" if why else ""


def undersampled(fidelities: Fidelities, stepper_of: Callable[[Any], Any]) -> str:
    """Of bodies whose slowest vibration a fixed step cannot show, in words; empty where there is none.

    A quarter of such a step may show no more of it: that two runs agree says nothing.
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
