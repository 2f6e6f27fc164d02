"""What a stability map compares its runs with: a fine run of the same scene, where two that are independent agree."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from lcpflex.accuracy.outputs import Measured, Output, chosen_outputs, error_between, is_nothing, scale_of_part
from lcpflex.accuracy.refinement import brief, refined
from lcpflex.errors import LcpflexError, ModelError, shown
from lcpflex.jit.kernel import FloatArray
from lcpflex.results.energy_balance import EnergyGrowth
from lcpflex.results.result import Result
from lcpflex.steppers.event_driven.stepper import EventDriven
from lcpflex.steppers.generalized_alpha.stepper import GeneralizedAlpha
from lcpflex.steppers.moreau_jean.stepper import MoreauJean
from lcpflex.studies.trial import Conditions, Trial, trial

__all__ = ["LIMIT", "Truth", "find_truth", "truth_outputs"]

INSTANTS = 4000  # at which the truth is stored
LIMIT = 10.0  # [s] of computing, of each of its runs
SHARE = 0.25  # of the tolerance: two runs that agree to less than this may serve as a truth
RTOL, ATOL = 1e-9, 1e-11  # of event-driven integration
COARSEST, FINER, LEVELS = 1e-3, 4.0, 6  # first step, as a share of the duration; then finer by factors
UNEVEN = 0.77  # ratio of the steps of two schemes that are to agree: what falls between the steps of one is met by both
MOTION = "motion"


@dataclass(frozen=True, slots=True, eq=False)
class Truth:
    """The outputs of a run that another, independent one has confirmed; or why there is none.

    Attributes
    ----------
    source
        Which run it is, and which other agrees with it how well; or why there is no truth.
    measured
        Value by output; empty where there is no truth.
    """

    source: str
    outputs: tuple[Output, ...] = ()
    measured: Mapping[str, Measured] = field(default_factory=dict)
    duration: float = math.nan

    @property
    def known(self) -> bool:
        """Whether there is one."""
        return bool(self.measured)

    def error_of(self, result: Result) -> float:
        """The largest error of the outputs of a result; NaN without a truth. Raises ModelError for another scene's."""
        if not self.known:
            return math.nan
        try:
            measured = {one.name: one.of(result) for one in self.outputs}
            return apart(self.outputs, measured, self.measured, self.duration)
        except LcpflexError:
            raise
        except Exception as error:  # whatever a function of the user's own may raise
            names = ", ".join(one.name for one in self.outputs)
            raise ModelError(
                f"outputs: {names} of a result cannot be compared with the truth: {type(error).__name__}: {error}"
            ) from error


def truth_outputs(outputs: Any) -> tuple[Output, ...]:
    """The outputs asked for; by default positions at equal times. Raises ModelError."""
    return chosen_outputs(MOTION if outputs is None else outputs)


def apart(
    outputs: tuple[Output, ...], one: Mapping[str, Measured], truth: Mapping[str, Measured], duration: float
) -> float:
    """Largest difference of two runs over the outputs, relative to the scale of the second."""
    return max(_difference(output, one[output.name], truth[output.name], duration) for output in outputs)


def _difference(output: Output, one: Measured, truth: Measured, duration: float) -> float:
    """Of numbers; of positions the largest at equal times; of other curves, which may jump, the mean over time."""
    if one.number is not None or truth.number is not None:
        return error_between(output, one, truth, duration)
    worst = 0.0
    for mine, other in zip(one.parts, truth.parts, strict=True):
        if not np.isfinite(mine.curves).all():
            return math.inf
        distance = np.linalg.norm(mine.curves - _at(one.times, truth.times, other.curves), axis=-1)
        if output.name != MOTION and len(one.times) > 1:
            widths = np.gradient(one.times) if len(one.times) > 2 else np.ones(2)
            distance = (widths[:, None] * distance).sum(axis=0, keepdims=True) / max(widths.sum(), 1e-300)
        worst = max(worst, float(distance.max(initial=0.0)) / (scale_of_part(output, other) or 1.0))
    return worst


def _at(times: FloatArray, known: FloatArray, curves: FloatArray) -> FloatArray:
    """Curves (m, c, d), given at ``known``, at other times."""
    flat = curves.reshape(len(known), -1)
    found = np.stack([np.interp(times, known, column) for column in flat.T], axis=1)
    return np.asarray(found.reshape(len(times), *curves.shape[1:]))


def find_truth(
    build: Callable[[], Any],
    duration: float,
    outputs: tuple[Output, ...],
    tolerance: float,
    limit: float = LIMIT,
    given: Any = None,
) -> Truth:
    """A truth for a scene: two sound runs that differ by less than a quarter of the tolerance.

    By default of two methods: event-driven and time stepping; where one of them cannot run the scene, two time-stepping
    schemes of different steps. Of a ``given`` stepper: the run, and one with half the step or half the tolerances.
    Refinements of one method alone would be blind to what that method misses at any step.
    """
    conditions = Conditions(build, duration, outputs, INSTANTS, 0, limit, EnergyGrowth.WARN)
    search = _Search(conditions, outputs, SHARE * tolerance)
    try:
        truth = search.of(given) if given is not None else search.own()
    except ModelError as error:
        return Truth(f"there is no truth: {error}")
    return truth


@dataclass(slots=True)
class _Search:
    """Runs that are compared until two agree."""

    conditions: Conditions
    outputs: tuple[Output, ...]
    enough: float
    reasons: list[str] = field(default_factory=list)
    nearest: tuple[float, str] = (math.inf, "")
    spent: float = 0.0  # [s] in the runs with the present step

    def of(self, stepper: Any) -> Truth:
        """The truth that a stepper of the user's own makes."""
        finer = refined(stepper, 2.0)
        one = self._run(stepper)
        if one is None:
            return self._none()
        if finer is None:
            return Truth(f"there is no truth: {brief(stepper)} has no step and no tolerance that could be halved")
        other = self._run(finer)
        return self._agreed(other, one) or self._none() if other is not None else self._none()

    def own(self) -> Truth:
        """The truth that the methods of the library agree on."""
        event = self._run(EventDriven(rtol=RTOL, atol=ATOL))
        before: Trial | None = None
        stepping = False
        for step in self._steps():
            run = self._run(MoreauJean(step=step))
            if run is None:
                before = None
                continue
            stepping = True
            if event is not None and (found := self._agreed(event, run)):
                return found
            if event is None and before is not None and self._differ(run, before) <= self.enough:
                other = self._run(GeneralizedAlpha(step=UNEVEN * step))
                if other is not None and (found := self._agreed(run, other)):
                    return found
            before = run
        if event is not None and not stepping:
            for step in self._steps():
                other = self._run(GeneralizedAlpha(step=step))
                if other is not None and (found := self._agreed(event, other)):
                    return found
        return self._none()

    def _steps(self) -> Iterator[float]:
        """From coarse to fine, while a run is expected to keep the limit."""
        for level in range(LEVELS):
            self.spent = 0.0
            yield COARSEST * self.conditions.duration / FINER**level
            if FINER * self.spent > self.conditions.limit:
                return

    def _run(self, stepper: Any) -> Trial | None:
        """A run, or None for one that failed or warns, whose reason is kept."""
        found = trial(self.conditions, stepper, repeats=0)
        self.spent += sum(found.times)
        if found.measured is not None and not found.failure:
            self._refuse_nothing(found.measured)
            return found
        self.reasons.append(f"{brief(stepper)}: {found.failure}")
        return None

    def _refuse_nothing(self, measured: Mapping[str, Measured]) -> None:
        """Raise ModelError for a number that is zero, unless its scale is given."""
        for one in self.outputs:
            number = measured[one.name].number is not None
            if number and one.scale is None and is_nothing(measured[one.name]):
                raise ModelError(f"{shown(one.name)} is zero, and no error can be relative to that; expected a scale")

    def _differ(self, one: Trial, other: Trial) -> float:
        assert one.measured is not None
        assert other.measured is not None
        found = apart(self.outputs, other.measured, one.measured, self.conditions.duration)
        if found <= self.nearest[0]:
            self.nearest = (found, f"{brief(one.stepper)} and {brief(other.stepper)}")
        return found

    def _agreed(self, best: Trial, other: Trial) -> Truth | None:
        """The first as the truth, if the second is close to it."""
        difference = self._differ(best, other)
        if difference > self.enough or best.measured is None:
            return None
        source = f"{brief(best.stepper)}, which {brief(other.stepper)} confirms to {100.0 * difference:.2g} %"
        return Truth(source, self.outputs, best.measured, self.conditions.duration)

    def _none(self) -> Truth:
        if self.nearest[1]:
            told = f"{self.nearest[1]}, the nearest two, differ by {100.0 * self.nearest[0]:.3g} %"
        else:
            told = "; ".join(dict.fromkeys(reason[:200] for reason in self.reasons[:2])) or "no two runs"
        return Truth(f"there is no truth: {told}")
