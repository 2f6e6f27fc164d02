"""What a run says of the error of its outputs: E, by the reruns that check any run, as ``Result.verify`` does."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from lcpflex.accuracy.outputs import error_between, has_scale
from lcpflex.accuracy.refinement import fineness, settled
from lcpflex.accuracy.reruns import Finished, checking_runs
from lcpflex.studies.trial import Conditions, Trial, assessed, patience

if TYPE_CHECKING:
    from lcpflex.accuracy.outputs import Output
    from lcpflex.results.measured_error import Rerun

__all__ = ["Claim", "claim"]

RERUNS = 2  # of a run with steps
FEW = 100  # steps that an event-driven rerun may take in any case: a study counts every run


@dataclass(frozen=True, slots=True)
class Claim:
    """By how much the outputs of a run may be off.

    Attributes
    ----------
    errors
        By output, E relative to the scale of the output; empty where nothing is known.
    reruns
        That it is by.
    missing
        Why other reruns say nothing.
    """

    errors: Mapping[str, float] = field(default_factory=dict)
    reruns: tuple[Rerun, ...] = ()
    missing: tuple[str, ...] = ()

    @property
    def largest(self) -> float:
        """Of the errors; NaN where nothing is known."""
        return max(self.errors.values(), default=math.nan if not self.reruns else 0.0)

    @property
    def seconds(self) -> float:
        """That the reruns took [s]."""
        return sum(one.seconds for one in self.reruns)


def claim(
    conditions: Conditions,
    run: Trial,
    outputs: Sequence[Output] | None = None,
    enough: float = math.inf,
    most: int = RERUNS,
) -> Claim:
    """The errors of the outputs of a run: some times the largest difference to the reruns that check it.

    A rerun that ends early or warns says nothing.

    Parameters
    ----------
    conditions
        Of the run, whose limit holds for each rerun.
    run
        That is checked.
    outputs
        Those of the conditions by default; what is zero throughout is left out.
    enough
        An error from which on no further rerun is made.
    most
        Reruns that are made, the surest first.
    """
    own = run.measured
    if run.origin is None or own is None:
        return Claim(missing=(run.failure,))
    if fineness(settled(run.stepper, 1.0)) is None:
        return Claim(missing=("the stepper has neither a step nor a tolerance",))
    found: dict[str, float] = {}
    reruns: list[Rerun] = []
    missing: list[str] = []
    checking = checking_runs(run.origin, conditions.duration, run.steps, seconds=patience(conditions), enough=FEW)
    for _, one in zip(range(most), checking, strict=False):
        if not isinstance(one, Finished):
            missing.append(one)
            continue
        measured, why = assessed(conditions, one.result)
        why = one.told.ended or why
        if why or measured is None:
            missing.append(f"{one.told.what}: {why}")
            continue
        reruns.append(one.told)
        for output in outputs or conditions.outputs:
            finer = measured[output.name]
            if not (finer.undefined or own[output.name].undefined) and has_scale(output, finer):
                off = one.told.factor * error_between(output, own[output.name], finer, conditions.duration)
                found[output.name] = max(found.get(output.name, 0.0), off)
        if max(found.values(), default=0.0) > enough:
            break
    return Claim(found, tuple(reruns), tuple(missing))
