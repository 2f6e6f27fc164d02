"""What errors are measured against, and how wrong that may be itself."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from lcpflex.errors import ModelError
from lcpflex.studies.outputs import Measured, Output, Part, as_curves, error_between, resolution
from lcpflex.studies.trial import Conditions, Trial, brief, refined, trial

__all__ = ["Reference", "analytic_reference", "converged_reference", "series_reference"]

INSTANTS = 20001  # at which an analytic function of time is sampled
FINER = 4.0  # how much finer than the finest run the reference is
PATIENT = 20.0  # limit of the runs of a reference, in multiples of that of all others
ROUNDING = 1e-12  # no reference is more exact than this
LEFT = 1.2  # disagreement that is not worth telling, in multiples of what both own up to


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
    """

    source: str
    measured: Mapping[str, Measured]
    error: Mapping[str, float]
    notes: tuple[str, ...] = field(default=())


def analytic_reference(values: Mapping[str, Any], outputs: Sequence[Output], duration: float) -> Reference:
    """Exact values: numbers, or functions of the times (m,) that return one row for each."""
    times = np.linspace(0.0, duration, INSTANTS)
    known = {output.name: output for output in outputs}
    measured, errors = {}, {}
    for name, value in values.items():
        if name not in known:
            raise ModelError(f"reference: nothing measures {name!r}; expected one of {', '.join(known)}")
        if callable(value):
            curve = np.asarray(value(times), dtype=float)
            if curve.ndim not in (1, 2, 3) or len(curve) != len(times):
                raise ModelError(f"reference[{name!r}]: returned shape {curve.shape}; expected a row for each time")
            measured[name] = Measured(times, (Part(name, as_curves(curve)),), None)
        elif isinstance(value, (int, float)):
            measured[name] = Measured(times, (), float(value))
        else:
            raise ModelError(f"reference[{name!r}]: {value!r} was given, expected a number or a function of times")
        if not measured[name].finite:
            raise ModelError(f"reference[{name!r}]: values that are not finite; expected finite numbers")
        errors[name] = ROUNDING + resolution(known[name], measured[name], duration)
    return Reference("exact values", measured, errors)


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
        errors = dict.fromkeys(best.measured, float("nan"))
        return Reference(brief(stepper), best.measured, errors, ("the error of the reference itself is not known",))
    return Reference(brief(stepper), best.measured, own_errors(conditions, best, other))


def _coarser(stepper: Any) -> Any:
    tolerances = hasattr(stepper, "rtol") or getattr(stepper, "adaptive", None) is not None
    return refined(stepper, 0.1 if tolerances else 0.5)


def _patient(conditions: Conditions) -> Conditions:
    from dataclasses import replace

    return replace(conditions, limit=PATIENT * conditions.limit)


def own_errors(conditions: Conditions, best: Trial, other: Trial) -> dict[str, float]:
    """Difference of two runs of one method, what lies between the stored instants, and rounding."""
    assert best.measured is not None
    assert other.measured is not None
    errors = {}
    for output in conditions.outputs:
        reference = best.measured[output.name]
        try:
            difference = error_between(output, other.measured[output.name], reference, conditions.duration)
        except ModelError:  # relative to nothing: an output without a scale, which the caller drops
            difference = float("nan")
        errors[output.name] = ROUNDING + difference + resolution(output, reference, conditions.duration)
    return errors


def series_reference(conditions: Conditions, series: Mapping[str, Sequence[Trial]], refine: bool = True) -> Reference:
    """The method that has converged best, run once more, finer than all.

    Of each method the two finest sound runs are compared in the first output; the method with the smallest difference
    is refined once more, or without ``refine`` taken as it is. The error of the reference is what the last refinement
    changes. A method that has converged, too, but elsewhere, is named.
    """
    settled = {label: pair for label, trials in series.items() if (pair := _two_finest(trials))}
    lawful = {label: pair for label, pair in settled.items() if not hasattr(pair[1].stepper, "law")}
    candidates = lawful or settled  # a contact force law of its own converges to another answer
    if not candidates:
        reasons = {label: next((t.failure for t in trials if t.failure), "") for label, trials in series.items()}
        told = "; ".join(f"{label}: {reason}" for label, reason in reasons.items() if reason)
        raise ModelError(
            "reference: not given, and no method has two sound runs to compare; expected a reference"
            + (f" ({told})" if told else "")
        )
    first = conditions.outputs[0].name
    changes = {label: own_errors(conditions, fine, coarse)[first] for label, (coarse, fine) in settled.items()}
    chosen = min(candidates, key=lambda label: (math.isnan(changes[label]), changes[label]))
    fine = candidates[chosen][1]
    best, other = _finest(conditions, fine, candidates[chosen][0]) if refine else (fine, candidates[chosen][0])
    assert best.measured is not None
    errors = own_errors(conditions, best, other)
    notes = tuple(
        note
        for label, (_, run) in settled.items()
        if label != chosen and (note := _disagreement(conditions, label, run, best, changes[label] + errors[first]))
    )
    return Reference(f"{chosen}, {brief(best.stepper)}", best.measured, errors, notes)


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


def _disagreement(conditions: Conditions, label: str, run: Trial, best: Trial, explained: float) -> str:
    output = conditions.outputs[0]
    assert run.measured is not None
    assert best.measured is not None
    apart = error_between(output, run.measured[output.name], best.measured[output.name], conditions.duration)
    if apart <= LEFT * explained:
        return ""
    return (
        f"{label} converges elsewhere: {output.name} {apart:.2g} from the reference, of which the last refinements of "
        f"both explain {explained:.2g}"
    )
