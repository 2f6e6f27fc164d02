"""Whether methods that share no equations agree: a method that agrees with itself alone may have missed something.

A run by tighter tolerances of a method that steps over a contact agrees with the one before to the last digit. So a
reference counts as confirmed only as far as a method of another family of steppers is from it, and where any method has
converged elsewhere, not farther than to that distance.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import TYPE_CHECKING, Any

from lcpflex.accuracy.outputs import Output, error_between, has_scale, resolution
from lcpflex.steppers.massless_boundary.stepper import MasslessBoundary
from lcpflex.studies.chart_style import family_of
from lcpflex.studies.convergence.equal_times import UNKNOWN, apart_at_equal_times, blur_at_equal_times

if TYPE_CHECKING:
    from lcpflex.studies.convergence.reference import Reference
    from lcpflex.studies.trial import Conditions, Trial

__all__ = ["Confirmation", "confirmed", "settled_apart"]

LOOK = 3  # finest runs of a method whose changes tell how far it has converged: one alone may change little by chance
LEFT = 1.2  # disagreement that is not worth telling, in multiples of what both own up to


@dataclass(frozen=True, slots=True)
class Confirmation:
    """By output how far a reference is confirmed; infinite where no method of another family has a sound run.

    Attributes
    ----------
    shape
        Distance of graphs to the nearest independent method, or to the farthest that has converged elsewhere.
    mean
        The same for the difference at equal times, on average over time; NaN for numbers.
    words
        Who agrees, or who does not.
    """

    shape: dict[str, float] = field(default_factory=dict)
    mean: dict[str, float] = field(default_factory=dict)
    words: dict[str, str] = field(default_factory=dict)


def settled_apart(conditions: Conditions, output: Output, one: Trial, other: Trial, explained: float) -> bool:
    """Whether two runs differ by more than the last refinements of their methods explain."""
    assert one.measured is not None
    assert other.measured is not None
    mine, theirs = one.measured[output.name], other.measured[output.name]
    if mine.undefined or theirs.undefined:
        return False
    scale = mine if has_scale(output, mine) else theirs
    if not has_scale(output, scale):  # both are 0
        return False
    return not error_between(output, mine, theirs, conditions.duration, scale) <= LEFT * explained


def confirmed(
    conditions: Conditions, reference: Reference, series: Mapping[str, Sequence[Trial]]
) -> tuple[Confirmation, tuple[str, ...]]:
    """What the methods say to the reference, and a note on each that has converged elsewhere."""
    found = Confirmation()
    notes: dict[str, str] = {}
    runs = {label: [t for t in trials if t.measured and not t.failure] for label, trials in series.items()}
    for output in conditions.outputs:
        if reference.measured.get(output.name) is None or not _comparable(output, reference):
            continue
        said = [
            _witness(conditions, output, reference, label, trials[-LOOK:])
            for label, trials in runs.items()
            if trials and label != reference.label
        ]
        heard = [one for one in said if one is not None]
        for one in heard:
            if one.elsewhere and one.label not in notes:
                notes[one.label] = one.note(output.name)
        _judge(found, output.name, reference, heard)
    return found, tuple(notes.values())


@dataclass(frozen=True, slots=True)
class _Witness:
    """One method: where it stands, how much of that is explained, and whether that counts."""

    label: str
    stepper: Any
    apart: float
    mean: float
    explained: float
    elsewhere: bool
    late: bool  # elsewhere at equal times
    other_model: bool

    def note(self, output: str) -> str:
        why = ", for it solves another model" if self.other_model else ""
        return (
            f"{self.label} converges elsewhere{why}: {output} {self.apart:.2g} from the reference, of which the last "
            f"refinements of both explain {self.explained:.2g}"
        )


def _comparable(output: Output, reference: Reference) -> bool:
    measured = reference.measured[output.name]
    return not measured.undefined and has_scale(output, measured)


def _witness(
    conditions: Conditions, output: Output, reference: Reference, label: str, runs: Sequence[Trial]
) -> _Witness | None:
    """What the finest run of a method, and the one before, say; None if nothing."""
    measured = [run.measured[output.name] for run in runs if run.measured is not None]
    target = reference.measured[output.name]
    if any(one.undefined for one in measured):
        return None
    fine, duration = measured[-1], conditions.duration
    apart = error_between(output, fine, target, duration)
    mean = apart_at_equal_times(output, fine, target).mean
    explained, shift = math.inf, math.inf  # a single run is not known to have converged
    if len(measured) > 1:
        pairs = list(pairwise(measured))
        change = max(error_between(output, one, other, duration, target) for one, other in pairs)
        change += resolution(output, fine, duration, target) + _known(reference.error.get(output.name, 0.0))
        moved = max(_known(apart_at_equal_times(output, one, other).mean) for one, other in pairs)
        own = reference.at_equal_times.get(output.name, UNKNOWN)
        explained = LEFT * change
        shift = LEFT * (moved + blur_at_equal_times(output, fine) + _known(own.mean))
    stepper = runs[-1].stepper
    return _Witness(
        label, stepper, apart, mean, explained, apart > explained, mean > shift,
        _own_model(stepper) and not _own_model(reference.stepper),
    )  # fmt: skip


def _known(value: float) -> float:
    return 0.0 if math.isnan(value) else value


def _own_model(stepper: Any) -> bool:
    """Whether a scheme solves other equations than the scene states: a force law of its own, modes without mass."""
    return hasattr(stepper, "law") or isinstance(stepper, MasslessBoundary)


def _judge(found: Confirmation, output: str, reference: Reference, heard: Sequence[_Witness]) -> None:
    mine = family_of(reference.stepper)
    others = [one for one in heard if family_of(one.stepper) != mine]
    against = [one for one in heard if one.elsewhere and not one.other_model]
    nearest = min(others, key=lambda one: one.apart, default=None)
    farthest = max(against, key=lambda one: one.apart, default=None)
    shape = nearest.apart if nearest is not None else math.inf
    words = f"{nearest.label} agrees to {shape:.2g}" if nearest is not None else f"no family but {mine} has a sound run"
    if nearest is not None and farthest is not None:
        shape = max(shape, farthest.apart)
        words = f"{farthest.label} converges elsewhere, {farthest.apart:.2g} from it"
    late = [one.mean for one in heard if one.late and not one.other_model]
    found.shape[output], found.words[output] = shape, words
    found.mean[output] = max(min((one.mean for one in others), default=math.inf), *late, 0.0)
