"""Work against precision: what an accuracy costs by each method, on a scene of your own.

import lcpflex as lf
from lcpflex import gallery
from lcpflex.studies import work_precision

chart = work_precision(
    gallery.scenes()["stick_slip"],
    {
        "Moreau-Jean": [lf.MoreauJean(step=h) for h in (1e-2, 1e-3, 1e-4)],
        "event-driven": [lf.EventDriven(rtol=r, atol=1e-2 * r) for r in (1e-4, 1e-6, 1e-8)],
    },
)
print(chart)
chart.plot().savefig("work-precision.png")
"""

from __future__ import annotations

import inspect
import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from lcpflex.accuracy.outputs import (
    Output,
    chosen_outputs,
    error_between,
    has_scale,
    resolution,
    standard_outputs,
    unscaled,
)
from lcpflex.basics.arguments import flag, optional_flag, positive, raised
from lcpflex.basics.progress import Progress
from lcpflex.bodies.body import whole_number
from lcpflex.errors import LcpflexError, ModelError, in_range, shown
from lcpflex.results.energy_balance import EnergyGrowth
from lcpflex.studies.claims import claim
from lcpflex.studies.convergence.equal_times import apart_at_equal_times, blur_at_equal_times
from lcpflex.studies.convergence.methods import standard_methods
from lcpflex.studies.convergence.points import SceneStudy, WorkPoint, WorkPrecision
from lcpflex.studies.convergence.reference import (
    Reference,
    analytic_reference,
    converged_reference,
    series_reference,
    with_witnesses,
)
from lcpflex.studies.given_functions import is_stepper, series_of
from lcpflex.studies.trial import Conditions, Trial, run_series

if TYPE_CHECKING:
    from lcpflex.runs.simulate import Stepper

__all__ = ["work_precision"]

MOST_REPEATS = 10_000

ENTRIES = 4_000_000  # coordinates and velocities over all instants that are stored by default
FEWEST, MOST = 1000, 20_000


def work_precision(
    scenes: Any,
    methods: Mapping[str, Sequence[Stepper] | Stepper] | None = None,
    reference: Mapping[str, Any] | Stepper | None = None,
    *,
    outputs: Any = None,
    duration: float | None = None,
    repeats: int = 3,
    limit: float = 10.0,
    instants: int | None = None,
    energy_growth: EnergyGrowth = EnergyGrowth.WARN,
    claims: bool = False,
    progress: bool | None = None,
    **varied: Sequence[Any],
) -> WorkPrecision:
    """Run scenes by several methods, each with a series of numbers; measure errors and wall times.

    Each run is made once with many stored instants, from which the errors are taken and which warms up; then
    ``repeats`` times as :func:`simulate` does by default, for the median and spread of its wall time.

    Parameters
    ----------
    scenes
        A :class:`Case`, a function that builds a scene, a :class:`Scene` or :class:`UserSystem`; or several of them,
        as a sequence or by label.
    methods
        By label the steppers of a series, which are run from coarse to fine: largest step or tolerance first. By
        default those of :func:`standard_methods`.
    reference
        Exact values by output: a number, or a function of times (m,) that returns a row for each. Or a stepper, which
        is run, and run once more with twice the step or ten times the tolerances: the difference is the error of the
        reference. Or None: of the methods that most others confirm, the one that has converged best is refined once
        more. Advice goes only as far as a method of another family of steppers agrees with a reference that was run.
    outputs
        By name functions of a :class:`Result` that return a number or an array with a row for each stored instant, or
        :class:`Output`; or names of standard ones. By default trajectory, impulses, peak force (without impacts only),
        peak impulse and energy; ``"motion"`` is the trajectory without velocities.
    duration
        Time to simulate [s]; that of the case by default.
    repeats
        Timed runs, fewer where they take longer than ``limit`` together; 0 takes the time of the first one.
    limit
        Wall time [s] of a run. Where the next one of a series is predicted to take longer, the series ends.
    instants
        Stored where errors are measured. By default up to 20 000, fewer with many coordinates.
    energy_growth
        As in :func:`simulate`. A result that warns counts as failed.
    claims
        Whether to check each sound run by reruns, as :meth:`Result.verify` does: table, file and chart then hold the
        error that it would claim beside its true one. Takes some eight times as long.
    progress
        Show a progress bar; by default on a terminal, after two seconds, and elsewhere a line a minute: see
        :func:`simulate`.
    varied
        Values for parameters of the functions that build the scenes, such as ``modes=[2, 4, 8]``. Each combination
        makes lines of its own; all are compared with the reference of the last combination.

    Returns
    -------
    WorkPrecision
        After Ctrl-C with what was measured before, marked incomplete.

    Raises
    ------
    KeyboardInterrupt
        After Ctrl-C before there was anything to compare.
    ModelError
        For arguments out of range; where no reference can be found; for outputs that cannot be compared.
    """
    named = _named_scenes(scenes)
    growth = energy_growth if isinstance(energy_growth, EnergyGrowth) else None
    if growth is None:
        raise ModelError(f"energy_growth: {shown(energy_growth)} was given, expected one of EnergyGrowth")
    request = _Request(
        None if methods is None else _checked_methods(methods),
        reference,
        standard_outputs() if outputs is None else chosen_outputs(outputs),
        None if duration is None else positive("duration", duration),
        whole_number("repeats", repeats, 0, MOST_REPEATS),
        in_range("limit", limit, 0.0, math.inf, open_ends=True),
        None if instants is None else whole_number("instants", instants, 2),
        growth,
        flag("claims", claims),
        optional_flag("progress", progress),
    )
    variants = _variants(varied)
    studies: list[SceneStudy] = []
    with Progress(request.progress, what="work_precision", total=len(named), unit="scene", bar=False) as whole:
        for label, scene in named.items():
            whole.at(label)
            try:
                studies.append(_study(request, label, scene, variants))
            except KeyboardInterrupt:
                if not studies:
                    raise
                return WorkPrecision(tuple(studies), complete=False)
            if not studies[-1].complete:
                return WorkPrecision(tuple(studies), complete=False)
            whole.update()
    return WorkPrecision(tuple(studies))


@dataclass(frozen=True, slots=True)
class _Request:
    """The arguments, checked."""

    methods: Mapping[str, tuple[Any, ...]] | None
    reference: Any
    outputs: tuple[Output, ...]
    duration: float | None
    repeats: int
    limit: float
    instants: int | None
    energy_growth: EnergyGrowth
    claims: bool
    progress: bool | None


def _named_scenes(scenes: Any) -> dict[str, Any]:
    if isinstance(scenes, Mapping):
        named = {str(label): scene for label, scene in scenes.items()}
    elif isinstance(scenes, (list, tuple)):
        named = {}
        for scene in scenes:
            label, count = _label(scene), 2
            while label in named:
                label, count = f"{_label(scene)} ({count})", count + 1
            named[label] = scene
    else:
        named = {_label(scenes): scenes}
    if not named:
        raise ModelError("scenes: none was given, expected at least one")
    return named


def _label(scene: Any) -> str:
    return str(getattr(scene, "name", None) or getattr(scene, "__name__", "scene"))


def _checked_methods(methods: Any) -> dict[str, tuple[Any, ...]]:
    if not isinstance(methods, Mapping) or not methods:
        raise ModelError(f"methods: {shown(methods)} was given, expected series of steppers by label")
    checked = {}
    for label, series in methods.items():
        checked[str(label)] = series_of(f"methods[{shown(label)}]", series)
    return checked


def _variants(varied: Mapping[str, Sequence[Any]]) -> list[dict[str, Any]]:
    for name, values in varied.items():
        if isinstance(values, str) or not isinstance(values, Sequence) or not values:
            raise ModelError(
                f"{name}: {shown(values)} was given, expected a sequence of values for the builder of the scene"
            )
    return [dict(zip(varied, values, strict=True)) for values in itertools.product(*varied.values())]


def _study(request: _Request, label: str, scene: Any, variants: Sequence[Mapping[str, Any]]) -> SceneStudy:
    """All methods on all variants of one scene, and their errors; up to an interruption by Ctrl-C."""
    duration = request.duration or getattr(scene, "duration", None)
    if duration is None:
        raise ModelError(f"duration: not given, and {shown(label)} does not say; expected a number of seconds > 0")
    series: dict[str, list[Trial]] = {}
    made: list[tuple[Conditions, Trial]] = []
    notes: list[str] = []
    conditions = [_conditions(request, _builder(label, scene, variant), duration) for variant in variants]
    reference = _given_reference(request, label, conditions[-1])  # first: it may be impossible
    interrupted = False
    for variant, one in zip(variants, conditions, strict=True):
        last, more, interrupted = _all_methods(request, one, "".join(f", {k}={v}" for k, v in variant.items()))
        notes += more
        series |= last
        made += [(one, run) for trials in last.values() for run in trials]
        if interrupted:
            break
    if reference is None:
        reference, interrupted = _found_reference(one, last, interrupted)
    reference = with_witnesses(reference, one, last)
    used, why = _used_outputs(request.outputs, reference, [t for trials in series.values() for t in trials])
    points = tuple(_point(label, method, one, used, reference) for method, trials in series.items() for one in trials)
    if request.claims and not interrupted:
        points, interrupted = _claimed(points, made, used, request.progress)
    return SceneStudy(label, duration, used, reference, points, (*notes, *why), complete=not interrupted)


def _used_outputs(
    outputs: Sequence[Output], reference: Reference, trials: Sequence[Trial]
) -> tuple[tuple[Output, ...], list[str]]:
    """Those that have values in all runs and a scale that errors can be relative to; why the others are left out."""
    used, notes = [], []
    standard = {output.name for output in standard_outputs()}
    for output in outputs:
        target = reference.measured.get(output.name)
        if target is None:
            continue
        measured = [target, *(one.measured[output.name] for one in trials if one.measured is not None)]
        reason = next((one.undefined for one in measured if one.undefined), "")
        if not reason and not has_scale(output, target):
            if output.name in standard:  # such as impulses without contacts: nobody asked for them
                continue
            reason = f"{output.name}: 0 throughout, no error is relative to that; expected Output(..., scale=...)"
        if reason:
            notes.append(reason)
            continue
        used.append(output)
        still = unscaled(output, target)
        if still:
            notes.append(f"{output.name}: {', '.join(still)[:200]} not compared, 0 throughout")
    if not used:
        why = "; ".join(notes)[:300]
        raise ModelError(f"outputs: none can be compared, expected one with values and a scale; {why}")
    return tuple(used), notes


def _builder(label: str, scene: Any, variant: Mapping[str, Any]) -> Callable[[], Any]:
    """What makes the scene anew; a function may return a case."""
    build = getattr(scene, "build", scene)
    if not callable(build):
        if variant:
            words = f"{shown(label)} is no function whose parameters could be varied, expected one"
            raise ModelError(f"{next(iter(variant))}: {words}")
        return lambda: scene
    try:
        inspect.signature(build).bind(**variant)
    except TypeError as error:
        words = f"cannot be called with {shown(dict(variant))}: {error}, expected a function that can, or a scene"
        raise ModelError(f"scenes[{shown(label)}]: the function {words}") from error

    def made() -> Any:
        try:
            result = build(**variant)
        except LcpflexError:
            raise
        except Exception as error:
            raise raised(f"scenes[{shown(label)}]", error, "a scene") from error
        return result.build() if hasattr(result, "build") and hasattr(result, "duration") else result

    return made


def _conditions(request: _Request, build: Callable[[], Any], duration: float) -> Conditions:
    instants = request.instants
    if instants is None:
        instants = int(min(max(ENTRIES / (2 * _coordinates(build())), FEWEST), MOST))
    return Conditions(build, duration, request.outputs, instants, request.repeats, request.limit, request.energy_growth)


def _coordinates(scene: Any) -> int:
    if hasattr(scene, "compile"):
        return max(1, int(scene.compiled().q.size))
    return max(1, len(getattr(scene, "q", ())))


def _all_methods(
    request: _Request, conditions: Conditions, suffix: str
) -> tuple[dict[str, list[Trial]], list[str], bool]:
    """Runs by label, notes on what was left out, and whether Ctrl-C ended them."""
    methods = request.methods or standard_methods(conditions.duration)
    series: dict[str, list[Trial]] = {}
    notes: list[str] = []
    total = sum(map(len, methods.values()))
    with Progress(request.progress, what="work_precision", total=total, unit="run", leave=False) as bar:
        for method, steppers in methods.items():
            bar.at(method + suffix)
            found = run_series(conditions, steppers, bar.update)
            series[method + suffix] = found.trials
            if found.left_out:
                notes.append(f"{method}{suffix}: {found.left_out}")
            if found.interrupted:
                notes += [f"{label}{suffix}: not run, interrupted" for label in list(methods)[len(series) :]]
                return series, notes, True
    return series, notes, False


def _given_reference(request: _Request, label: str, conditions: Conditions) -> Reference | None:
    given = request.reference
    if isinstance(given, Mapping) and label in given:  # one for each scene
        given = given[label]
    if given is None:
        return None
    if isinstance(given, Mapping):
        return analytic_reference(given, conditions.outputs, conditions.duration)
    if not is_stepper(given):
        raise ModelError(f"reference: {shown(given)} was given, expected exact values by output, a stepper or None")
    return converged_reference(conditions, given)


def _found_reference(
    conditions: Conditions, series: Mapping[str, Sequence[Trial]], interrupted: bool
) -> tuple[Reference, bool]:
    """The reference that the runs themselves give, and whether Ctrl-C ended them or its refinement."""
    if not interrupted:
        try:
            return series_reference(conditions, series), False
        except KeyboardInterrupt:
            pass
    try:
        return series_reference(conditions, series, refine=False), True
    except ModelError as error:  # there is nothing yet to compare
        raise KeyboardInterrupt from error


def _claimed(
    points: Sequence[WorkPoint], made: Sequence[tuple[Conditions, Trial]], outputs: Any, progress: bool | None
) -> tuple[tuple[WorkPoint, ...], bool]:
    """The points with what each sound run says of its own error, and whether Ctrl-C ended that."""
    found = list(points)
    with Progress(progress, what="claimed errors", total=len(points), unit="run", leave=False) as bar:
        for k, (point, (conditions, run)) in enumerate(zip(points, made, strict=True)):
            bar.at(point.told)
            try:
                if not point.failure:
                    found[k] = replace(point, claims=claim(conditions, run, outputs).errors)
            except KeyboardInterrupt:
                return tuple(found), True
            bar.update()
    return tuple(found), False


def _point(scene: str, method: str, one: Trial, outputs: Sequence[Output], reference: Reference) -> WorkPoint:
    errors, timing, unseen, late = {}, {}, {}, {}
    runs = one.measured or {}
    for output in outputs if runs else ():
        name, measured, target = output.name, runs[output.name], reference.measured[output.name]
        errors[name] = error_between(output, measured, target, one.duration)
        timing[name] = apart_at_equal_times(output, measured, target)
        thinned = measured.finite and one.thinned
        unseen[name] = resolution(output, measured, one.duration, target) if thinned else 0.0
        late[name] = blur_at_equal_times(output, measured) if thinned else 0.0
    return WorkPoint(
        scene, method, one.stepper, one.steps, one.wall_time,
        min(one.times, default=math.nan), max(one.times, default=math.nan), len(one.times),
        errors, one.failure, one.refused, unseen, timing, late,
    )  # fmt: skip
