"""What errors are measured against, and how wrong that may be itself."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np

from lcpflex.accuracy.outputs import Measured, Output, Part, as_curves, error_between, has_scale, resolution
from lcpflex.accuracy.refinement import brief, refined
from lcpflex.errors import ModelError, shown
from lcpflex.studies.chart_style import family_of
from lcpflex.studies.convergence.confirmation import Confirmation, confirmed, settled_apart
from lcpflex.studies.convergence.equal_times import UNKNOWN, EqualTimes, apart_at_equal_times, blur_at_equal_times
from lcpflex.studies.trial import Conditions, Trial, trial

__all__ = ["Reference", "analytic_reference", "converged_reference", "series_reference"]

INSTANTS = 20001  # at which an analytic function of time is sampled
FINER = 4.0  # how much finer than the finest run the reference is
PATIENT = 20.0  # limit of the runs of a reference, in multiples of that of all others
ROUNDING = 1e-12  # no reference is more exact than this


@dataclass(frozen=True, slots=True, eq=False)
class Reference:
    """The values that errors are measured against.

    Attributes
    ----------
    source
        Where they come from, in words.
    measured
        Value by output.
    error
        Own error by output, relative to the same scale as all others; NaN where nothing is known about it.
    notes
        What a reader must know.
    at_equal_times
        Own error by output at equal times: its mean over time and the largest; NaN for numbers.
    recorded
        How much of ``error`` lies between the stored instants.
    confirmation
        How far methods of other families agree with it; None for exact values, which need no witness.
    stepper, label
        What it was run by, and the method that this is one of, if it is.
    """

    source: str
    measured: Mapping[str, Measured]
    error: Mapping[str, float]
    notes: tuple[str, ...] = field(default=())
    at_equal_times: Mapping[str, EqualTimes] = field(default_factory=dict)
    recorded: Mapping[str, float] = field(default_factory=dict)
    confirmation: Confirmation | None = None
    stepper: Any = None
    label: str | None = None

    def reach(self, output: str) -> float:
        """What the reference may be wrong by: its own error, or the distance to the methods that confirm it."""
        witnesses = 0.0 if self.confirmation is None else self.confirmation.shape.get(output, math.inf)
        return _larger(self.error[output], witnesses)

    def reach_at_equal_times(self, output: str) -> float:
        """The same at equal times, on average over time."""
        own = self.at_equal_times.get(output, EqualTimes(math.inf, math.inf)).mean
        witnesses = 0.0 if self.confirmation is None else self.confirmation.mean.get(output, math.inf)
        return _larger(own, witnesses)


def _larger(own: float, other: float) -> float:
    """The larger one, NaN if what is known of itself is."""
    return own if math.isnan(own) else max(own, other)


class OwnErrors(NamedTuple):
    """By output what the last refinement of a method changed, at equal times too, and what its record blurs."""

    shape: dict[str, float]
    at_equal_times: dict[str, EqualTimes]
    recorded: dict[str, float]


def analytic_reference(values: Mapping[str, Any], outputs: Sequence[Output], duration: float) -> Reference:
    """Exact values: numbers, or functions of the times (m,) that return one row for each."""
    times = np.linspace(0.0, duration, INSTANTS)
    known = {output.name: output for output in outputs}
    measured, errors, timing, recorded = {}, {}, {}, {}
    for name, value in values.items():
        if name not in known:
            raise ModelError(f"reference: nothing measures {shown(name)}; expected one of {', '.join(known)}")
        if callable(value):
            curve = np.asarray(value(times), dtype=float)
            if curve.ndim not in (1, 2, 3) or len(curve) != len(times):
                raise ModelError(f"reference[{name!r}]: returned shape {curve.shape}; expected a row for each time")
            measured[name] = Measured(times, (Part(name, as_curves(curve)),), None)
        elif isinstance(value, (int, float)):
            measured[name] = Measured(times, (), float(value))
        else:
            raise ModelError(f"reference[{name!r}]: {shown(value)} was given, expected a number or a function of times")
        if not measured[name].finite:
            raise ModelError(f"reference[{name!r}]: values that are not finite; expected finite numbers")
        recorded[name] = (
            resolution(known[name], measured[name], duration) if has_scale(known[name], measured[name]) else 0.0
        )
        errors[name] = ROUNDING + recorded[name]
        blur = blur_at_equal_times(known[name], measured[name])
        timing[name] = EqualTimes(ROUNDING + blur, blur) if measured[name].parts else UNKNOWN
    return Reference("exact values", measured, errors, (), timing, recorded)


def converged_reference(conditions: Conditions, stepper: Any) -> Reference:
    """A run by ``stepper``; its error is the difference to a run with twice the step, or ten times the tolerance."""
    patient = _patient(conditions)
    best = trial(patient, stepper, repeats=0)
    if best.measured is None or best.failure:
        raise ModelError(
            f"reference: {brief(stepper)} fails on this scene ({best.failure}); expected one that does not"
        )
    coarser = _coarser(stepper)
    other = trial(patient, coarser, repeats=0) if coarser is not None else None
    if other is None or other.measured is None:
        errors = dict.fromkeys(best.measured, math.nan)
        told = ("the error of the reference itself is not known",)
        return Reference(brief(stepper), best.measured, errors, told, stepper=stepper)
    own = own_errors(conditions, best, other)
    return Reference(brief(stepper), best.measured, own.shape, (), own.at_equal_times, own.recorded, stepper=stepper)


def _coarser(stepper: Any) -> Any:
    tolerances = hasattr(stepper, "rtol") or getattr(stepper, "adaptive", None) is not None
    return refined(stepper, 0.1 if tolerances else 0.5)


def _patient(conditions: Conditions) -> Conditions:
    return replace(conditions, limit=PATIENT * conditions.limit)


def own_errors(conditions: Conditions, best: Trial, other: Trial) -> OwnErrors:
    """Difference of two runs of one method, what lies between the stored instants, and rounding."""
    assert best.measured is not None
    assert other.measured is not None
    own = OwnErrors({}, {}, {})
    for output in conditions.outputs:
        fine, coarse = best.measured[output.name], other.measured[output.name]
        own.shape[output.name], own.recorded[output.name] = math.nan, 0.0
        own.at_equal_times[output.name] = UNKNOWN
        if fine.undefined or coarse.undefined or not has_scale(output, fine):  # the caller drops the output
            continue
        own.recorded[output.name] = resolution(output, fine, conditions.duration)
        difference = error_between(output, coarse, fine, conditions.duration)
        own.shape[output.name] = ROUNDING + difference + own.recorded[output.name]
        apart = apart_at_equal_times(output, coarse, fine)
        blur = ROUNDING + blur_at_equal_times(output, fine)
        own.at_equal_times[output.name] = EqualTimes(apart.mean + blur, apart.largest + blur)
    return own


def with_witnesses(reference: Reference, conditions: Conditions, series: Mapping[str, Sequence[Trial]]) -> Reference:
    """The reference with what methods of other families say to it, and notes on those that converge elsewhere."""
    if reference.stepper is None:
        return reference
    found, notes = confirmed(conditions, reference, series)
    return replace(reference, confirmation=found, notes=(*reference.notes, *notes))


def series_reference(conditions: Conditions, series: Mapping[str, Sequence[Trial]], refine: bool = True) -> Reference:
    """The method that most others confirm, and of these the one that has converged best, run once more, finer than all.

    Of each method the two finest sound runs are compared in the first output: what the last refinement changed. Methods
    of other families confirm it where they are no farther from it than both of these changes. The method so chosen is
    refined once more, or without ``refine`` taken as it is; what that changes is the error of the reference.
    """
    settled = {label: pair for label, trials in series.items() if (pair := _two_finest(trials))}
    lawful = {label: pair for label, pair in settled.items() if not hasattr(pair[1].stepper, "law")}
    candidates = lawful or settled  # a contact force law of its own converges to another answer
    if not candidates:
        reasons = {label: next((t.failure for t in trials if t.failure), "") for label, trials in series.items()}
        told = "; ".join(f"{label}: {reason[:80]}" for label, reason in reasons.items() if reason)
        raise ModelError(
            "reference: not given, and no method has two sound runs to compare; expected a reference, or a longer limit"
            + (f" ({told[:300]})" if told else "")
        )
    first = conditions.outputs[0]
    alone = replace(conditions, outputs=(first,))
    changes = {label: own_errors(alone, fine, coarse).shape[first.name] for label, (coarse, fine) in settled.items()}

    def witnesses(label: str) -> int:
        """Families that agree with a method."""
        mine = settled[label][1]
        return len(
            {
                family_of(other.stepper)
                for them, (_, other) in settled.items()
                if not settled_apart(conditions, first, mine, other, changes[label] + changes[them])
            }
            - {family_of(mine.stepper)}
        )

    chosen = min(candidates, key=lambda label: (-witnesses(label), math.isnan(changes[label]), changes[label]))
    coarse, fine = candidates[chosen]
    if refine:
        fine, coarse = _finest(conditions, fine, coarse)
    assert fine.measured is not None
    best = own_errors(conditions, fine, coarse)
    source = f"{chosen}, {brief(fine.stepper)}"
    return Reference(
        source, fine.measured, best.shape, (), best.at_equal_times, best.recorded, stepper=fine.stepper, label=chosen
    )


def _two_finest(trials: Sequence[Trial]) -> tuple[Trial, Trial] | None:
    """The last but one and the last sound run of a series."""
    sound = [one for one in trials if one.measured is not None and not one.failure]
    return (sound[-2], sound[-1]) if len(sound) > 1 else None


def _finest(conditions: Conditions, fine: Trial, coarse: Trial) -> tuple[Trial, Trial]:
    """A run still finer than ``fine``, with ``fine``; or these two where that cannot be."""
    finer = refined(fine.stepper, FINER)
    if finer is not None:
        run = trial(_patient(conditions), finer, repeats=0)
        if run.measured is not None and not run.failure:
            return run, fine
    return fine, coarse
