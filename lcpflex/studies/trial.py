"""One scheme with its numbers on one scene: what it cost, what came out, or why it failed."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from lcpflex.accuracy.outputs import Measured, Output
from lcpflex.accuracy.refinement import brief, fineness
from lcpflex.checks.resolution import unresolved
from lcpflex.errors import LcpflexError, ModelError, StepError
from lcpflex.results.energy_balance import EnergyGrowth
from lcpflex.results.result import Result
from lcpflex.runs.simulate import given_up_after

if TYPE_CHECKING:
    from lcpflex.runs.origin import Origin
    from lcpflex.runs.simulate import Stepper

__all__ = [
    "NONE",
    "SEVERAL",
    "Conditions",
    "Series",
    "Trial",
    "assessed",
    "in_order",
    "is_paradox",
    "patience",
    "predicted",
    "run_series",
    "scene_warnings",
    "trial",
]

NONE, SEVERAL = "no acceleration was admissible", "several motions were admissible"  # the words that report paradoxes

PATIENCE = 3.0  # a run is ended after this many times the limit that it was predicted to keep
GUESS = 3.0  # how much longer the next run takes where nothing tells


@dataclass(frozen=True, slots=True)
class Conditions:
    """How every run of a scene is made."""

    build: Callable[[], Any]
    duration: float
    outputs: tuple[Output, ...]
    instants: int  # stored where the accuracy is measured
    repeats: int
    limit: float  # [s] of computing
    energy_growth: EnergyGrowth


@dataclass(frozen=True, slots=True, eq=False)
class Trial:
    """What came of one stepper: times of the repeated runs [s], outputs, and why it counts as failed, if so."""

    stepper: Any
    steps: int = 0
    times: tuple[float, ...] = ()
    measured: Mapping[str, Measured] | None = None
    failure: str = ""
    refused: bool = False  # before time was spent: it does not apply
    duration: float = math.nan  # [s]
    thinned: bool = False  # instants were stored by the clock, not one for each step
    origin: Origin | None = None  # by which it can be run again

    @property
    def complete(self) -> bool:
        """Whether it ran to its end, trusted or not: its time is that of a run."""
        return bool(self.times) and self.measured is not None

    @property
    def wall_time(self) -> float:
        """Median [s]."""
        return float(np.median(self.times)) if self.times else float("nan")


def trial(conditions: Conditions, stepper: Stepper, repeats: int | None = None) -> Trial:
    """Run once with many stored instants, which warms up and is measured, then again for the time."""
    repeats = conditions.repeats if repeats is None else repeats
    try:
        first = _run(conditions, stepper, conditions.duration / conditions.instants)
    except StepError as error:
        return _failed(stepper, error)
    except ModelError as error:
        return Trial(stepper, failure=str(error), refused=True)
    except (LcpflexError, ArithmeticError, np.linalg.LinAlgError) as error:
        return Trial(stepper, failure=f"{type(error).__name__}: {error}")
    measured, failure = _measured(conditions, first)
    origin = first.origin
    thinned = _thinned(first, conditions.duration / conditions.instants)
    if failure:
        once = (first.wall_time,)
        return Trial(stepper, first.steps, once, measured, failure, False, conditions.duration, thinned, origin)
    times = [first.wall_time]
    if repeats and first.wall_time <= conditions.limit:
        times = [_run(conditions, stepper, None).wall_time]
        while len(times) < repeats and sum(times) < conditions.limit:  # long runs need no median of many
            times.append(_run(conditions, stepper, None).wall_time)
    told = "; ".join(_distrust(first))
    return Trial(stepper, first.steps, tuple(times), measured, told, False, conditions.duration, thinned, origin)


def assessed(conditions: Conditions, result: Result) -> tuple[dict[str, Measured] | None, str]:
    """The outputs of a result, and why they cannot be trusted."""
    measured, failure = _measured(conditions, result)
    return measured, failure or "; ".join(_distrust(result))


def patience(conditions: Conditions) -> float:
    """Seconds of computing after which a run is ended, whatever was predicted."""
    return PATIENCE * conditions.limit


def _thinned(result: Result, interval: float) -> bool:
    """Whether instants lie where the clock asked for them, about every ``interval`` [s], and not at every step."""
    spans = np.diff(result.times)
    spans = spans[spans > 0.0]
    return bool(len(spans) and len(spans) != result.steps and np.median(spans) < 1.5 * interval)


def _distrust(result: Result) -> list[str]:
    """What the result warns of, but for the scene itself, and for a paradox that was named and resolved."""
    of_scene = scene_warnings(result)
    return [warning for warning in result.warnings if warning not in of_scene and not is_paradox(warning)]


def is_paradox(warning: str) -> bool:
    """Whether a run reports by it that it met, and got past, one of Painleve's paradoxes."""
    return NONE in warning or SEVERAL in warning


def scene_warnings(result: Result) -> tuple[str, ...]:
    """Warnings that are of the scene and not of the run: of bodies too stiff, or too coarse for their contacts."""
    return (*unresolved(result), *(result.compiled.warnings if result.compiled is not None else ()))


def _measured(conditions: Conditions, result: Result) -> tuple[dict[str, Measured] | None, str]:
    """The outputs, or why there are none: a function that cannot cope with one result leaves the others their say."""
    measured = {}
    for output in conditions.outputs:
        try:
            measured[output.name] = output.of(result)
        except ModelError:
            raise
        except Exception as error:  # whatever a function of the user's own may raise
            return None, f"outputs[{output.name!r}] raised {type(error).__name__}: {error}"
    wild = [name for name, one in measured.items() if not one.finite and not one.undefined]
    return measured, f"outputs[{wild[0]!r}] is not finite" if wild else ""


def _run(conditions: Conditions, stepper: Any, record: float | None) -> Result:
    seconds, growth = patience(conditions), conditions.energy_growth
    result = given_up_after(seconds, conditions.build(), conditions.duration, stepper, record, growth)
    if not result.complete and result.message.startswith("interrupted"):
        raise KeyboardInterrupt
    return result


def _failed(stepper: Any, error: StepError) -> Trial:
    result: Result | None = error.result
    if result is None:
        return Trial(stepper, failure=str(error))
    return Trial(stepper, result.steps, (result.wall_time,), failure=str(error))


class Series(NamedTuple):
    """The runs of one method, which were left out and why, and whether Ctrl-C ended them."""

    trials: list[Trial]
    left_out: str = ""
    interrupted: bool = False


def run_series(
    conditions: Conditions, steppers: Sequence[Stepper], done: Callable[[], object] = lambda: None
) -> Series:
    """Run the steppers of a series from coarse to fine, as long as they keep the limit."""
    trials: list[Trial] = []
    steppers = in_order(steppers)
    for k, stepper in enumerate(steppers):
        expected = predicted(trials, stepper)
        what = f"{brief(stepper)}{' and finer ones' if k + 1 < len(steppers) else ''} left out"
        if expected > conditions.limit:
            return Series(trials, f"{what}: about {expected:.2g} s a run, limit {conditions.limit:g} s")
        try:
            trials.append(trial(conditions, stepper))
        except KeyboardInterrupt:
            return Series(trials, f"{what}: interrupted", interrupted=True)
        done()
    return Series(trials)


def predicted(trials: Sequence[Trial], stepper: Any) -> float:
    """Wall time [s] of the next run: in proportion to the steps, or growing as it did before."""
    timed = [trial for trial in trials if trial.times]
    if not timed:
        return 0.0
    last = timed[-1]
    now, before = fineness(stepper), fineness(last.stepper)
    if now and before and now[0] == before[0] == "step":
        return last.wall_time * max(1.0, before[1] / now[1])
    if last.failure and len(timed) == 1:  # its time tells nothing: sound ones are often faster
        return 0.0
    growth = last.wall_time / timed[-2].wall_time if len(timed) > 1 else GUESS
    return last.wall_time * min(max(growth, 1.0), 10.0)


def in_order(steppers: Sequence[Stepper]) -> list[Stepper]:
    """From coarse to fine, where one kind of number tells; else as they were given."""
    known = [fineness(stepper) for stepper in steppers]
    if any(one is None for one in known) or len({one[0] for one in known if one}) != 1:
        return list(steppers)
    order = sorted(range(len(steppers)), key=lambda k: -(known[k] or ("", 0.0))[1])
    return [steppers[k] for k in order]
