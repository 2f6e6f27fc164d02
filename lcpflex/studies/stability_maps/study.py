"""Stability maps: where in a plane of two parameters does a method work, and how does it fail elsewhere?

    from lcpflex import MoreauJean, gallery
    from lcpflex.studies import stability

    chart = stability(
        gallery.block_on_incline,
        {"Moreau-Jean": lambda step: MoreauJean(step)},
        {"step": [1e-4, 1e-3, 1e-2], "friction": [0.2, 0.4, 0.8]},
        duration=0.5,
    )
    print(chart)
    chart.plot().savefig("map.png")

What a run says of itself is at best "no sign of trouble". With ``truth=True`` every run is compared with a fine one of
the same scene that two independent methods agree on, and "sound" is what is within ``criteria.error`` of it.

Any parameter of the function that builds the scene and of those that make the steppers can be an axis: step, contact
stiffness, number of modes, friction, angle, mass ratio, iterations, restitution, number of contacts.
"""

from __future__ import annotations

import inspect
import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from lcpflex.accuracy.outputs import Output
from lcpflex.basics.arguments import WrongFunction, called, mapping_of, optional_flag, raised
from lcpflex.basics.names import meant
from lcpflex.basics.progress import Progress
from lcpflex.errors import LcpflexError, ModelError, as_number, in_range, shown
from lcpflex.results.result import Result
from lcpflex.runs.simulate import given_up_after
from lcpflex.studies.criteria import Criteria
from lcpflex.studies.given_functions import check_call, checked_axes, instance_of, is_stepper
from lcpflex.studies.outcome import Outcome, Verdict, judge_error, judge_result
from lcpflex.studies.stability_maps.stability_map import StabilityMap
from lcpflex.studies.stability_maps.truth import LIMIT, Truth, find_truth, truth_outputs
from lcpflex.studies.trial import scene_warnings

if TYPE_CHECKING:
    from lcpflex.runs.case import Case

    Judge = Callable[[Result], Outcome | None]
    Check = Callable[[Result], float]

__all__ = ["stability"]

MOST = 100_000  # cells of a map
BUILT = "scene"  # parameter by which a method asks for the built scene


def stability(
    scene: Case | Callable[..., Any],
    methods: Mapping[str, Any],
    axes: Mapping[str, Sequence[Any]],
    duration: float | None = None,
    *,
    criteria: Criteria | None = None,
    judge: Judge | None = None,
    check: Check | None = None,
    truth: Any = None,
    outputs: Any = None,
    truth_limit: float = LIMIT,
    time_limit: float | None = None,
    record: float | None = None,
    progress: bool | None = None,
) -> StabilityMap:
    """Run ``scene`` by every method at every point of a plane, and say what became of each run.

    Parameters
    ----------
    scene
        A case of the gallery, or a function with keyword parameters that builds a scene.
    methods
        By label: a stepper, or a function of keyword parameters. What the function returns decides: a stepper is run;
        an :class:`Outcome` or :class:`Verdict` is the answer, as of a method that needs no time stepping such as
        :func:`acceleration_level`; a :class:`Result` is judged.
        A parameter called ``scene`` receives the scene as built for that cell.
    axes
        One or two names, each with its values. A name is that of a parameter of the scene, of the methods, or of both.
    duration
        Time to simulate [s]; that of the case by default.
    criteria
        Where a result ceases to be sound.
    judge
        Called first with each result: the outcome, or None to leave it to the criteria.
    check
        Error of a result without trouble, compared with ``criteria.error``: above it the answer is silently wrong.
    truth
        What results are compared with. None: nothing, and no result is called sound but by ``check``. True: for every
        scene of the plane a run of this library that another method confirms to a quarter of ``criteria.error``: an
        event-driven one and a time-stepping one, or two time-stepping schemes with different steps where events do not
        work. A stepper, or a function of parameters as in ``methods``: a run by it, which one with half the step or
        half the tolerances has to confirm as well. Where nothing confirms it, the map says that there is no truth. It
        has Newton's law of impact, and the contact laws of the scene: a method with others is right in other terms.
    outputs
        What is compared, as in :func:`work_precision`. By default positions at equal times, the largest difference
        relative to the largest range; of other curves the mean difference over time.
    truth_limit
        Computing time [s] of each run of the truth.
    time_limit
        Computing time of a cell [s] after which it is too slow, compilation not counted.
    record
        Time between stored instants [s], as in :func:`simulate`.
    progress
        Show a progress bar; by default on a terminal, after two seconds, and elsewhere a line a minute: see
        :func:`simulate`.

    Returns
    -------
    StabilityMap
        After Ctrl-C with the cells that were left as ``Outcome.NOT_RUN``.

    Raises
    ------
    ModelError
        For axes that nothing takes, parameters that nothing gives, and arguments out of range, before time is spent.
        One that a cell raises is the outcome of that cell: refused.
    """
    table = checked_axes(axes, MOST)
    progress = optional_flag("progress", progress)
    build = getattr(scene, "build", scene)
    compared = truth_outputs(outputs)
    truth_limit = in_range("truth_limit", truth_limit, 0.0, math.inf, open_ends=True)
    if duration is None:
        duration = getattr(scene, "duration", None)
    if duration is not None:
        duration = in_range("duration", duration, 0.0, math.inf, open_ends=True)
    if time_limit is not None:
        time_limit = in_range("time_limit", time_limit, 0.0, math.inf, open_ends=True)
    if record is not None:
        record = in_range("record", record, 0.0, math.inf)
    check_call("judge", judge, "a function of a Result that returns an Outcome or None")
    check_call("check", check, "a function of a Result that returns its error")
    methods = mapping_of("methods", methods)
    if not methods:
        raise ModelError("methods: none was given; expected steppers, or functions that make them, by label")
    builder = _Maker.of("scene", build, table)
    makers = {label: _Maker.of(f"methods[{label!r}]", method, table) for label, method in methods.items()}
    _check_names(table, builder, makers)
    cells = len(makers) * math.prod(map(len, table.values()))
    if cells > MOST:
        raise ModelError(f"axes: {cells} cells with {len(makers)} methods; expected at most {MOST}")
    own = truth is None or isinstance(truth, (bool, np.bool_))
    truth_maker = None if own else _Maker.of("truth", truth, table)
    if duration is None and (truth or any(maker.fixed is not None for maker in makers.values())):
        raise ModelError("duration: not given, and the scene does not say; expected a number of seconds > 0")
    criteria = instance_of("criteria", criteria, Criteria) or Criteria()
    truths = None
    if duration is not None and truth is not None and truth is not False:
        truths = _Truths(builder, truth_maker, duration, compared, criteria.error, truth_limit)
    trial = _Trial(builder, duration, criteria, judge, check, time_limit, record, truths, [], {})
    return _fill(trial, makers, table, progress)


@dataclass(frozen=True, slots=True)
class _Maker:
    """A function and those of the axes that it takes; or a stepper, which takes none."""

    label: str
    function: Callable[..., Any] | None
    fixed: Any
    takes: tuple[str, ...]
    known: tuple[str, ...]
    wants_scene: bool

    @classmethod
    def of(cls, label: str, thing: Any, axes: Mapping[str, Any]) -> _Maker:
        if is_stepper(thing) and label != "scene":
            return cls(label, None, thing, (), (), False)
        if not callable(thing):
            expected = "a Case or a function that builds a scene" if label == "scene" else "a stepper or a function"
            raise ModelError(f"{label}: {shown(thing)} was given, expected {expected}")
        parameters = inspect.signature(thing).parameters.values()
        named = {p.name: p for p in parameters if p.kind in (p.POSITIONAL_OR_KEYWORD, p.KEYWORD_ONLY)}
        anything = any(p.kind is p.VAR_KEYWORD for p in parameters)
        wants_scene = label != "scene" and BUILT in named
        missing = [
            name
            for name, p in named.items()
            if p.default is p.empty and name not in axes and not (wants_scene and name == BUILT)
        ]
        if missing:
            raise ModelError(
                f"axes: {label} needs {shown(missing[0])}, which no axis gives; expected it there or a default"
            )
        takes = tuple(name for name in axes if name in named or anything)
        return cls(label, thing, None, takes, tuple(name for name in named if name != BUILT), wants_scene)

    def __call__(self, values: Mapping[str, Any], **more: Any) -> Any:
        if self.function is None:
            return self.fixed
        return self.function(**more, **{name: values[name] for name in self.takes})


@dataclass(slots=True)
class _Truths:
    """The truth of every scene of a plane, each looked for when it is first needed."""

    build: _Maker
    stepper: _Maker | None
    duration: float
    outputs: tuple[Output, ...]
    tolerance: float
    limit: float
    found: dict[tuple[Any, ...], Truth] = field(default_factory=dict)

    def __call__(self, values: Mapping[str, Any]) -> Truth:
        """The truth of the scene with these values. KeyboardInterrupt where the user pressed Ctrl-C."""
        taken = {*self.build.takes, *(self.stepper.takes if self.stepper is not None else ())}
        key = tuple(repr(values[name]) for name in values if name in taken)
        if key not in self.found:
            self.found[key] = self._look(values)
        return self.found[key]

    def _look(self, values: Mapping[str, Any]) -> Truth:
        def scene() -> Any:
            return _scene_of(self.build, values)

        try:
            given = None
            if self.stepper is not None:
                given = self.stepper(values, **({BUILT: scene()} if self.stepper.wants_scene else {}))
                if not is_stepper(given):
                    raise ModelError(f"truth: returned {shown(given)}; expected a stepper")
            return find_truth(scene, self.duration, self.outputs, self.tolerance, self.limit, given)
        except WrongFunction:
            raise
        except (LcpflexError, ArithmeticError, np.linalg.LinAlgError) as error:
            return Truth(f"there is no truth: {error}")


def _scene_of(build: _Maker, values: Mapping[str, Any]) -> Any:
    """The scene with these values; a function may return a case."""
    try:
        scene = build(values)
    except LcpflexError:
        raise
    except Exception as error:
        raise raised(build.label, error, "a scene") from error
    return scene.build() if hasattr(scene, "build") and hasattr(scene, "duration") else scene


@dataclass(frozen=True, slots=True)
class _Trial:
    """How one cell is tried."""

    build: _Maker
    duration: float | None
    criteria: Criteria
    judge: Judge | None
    check: Check | None
    time_limit: float | None
    record: float | None
    truths: _Truths | None
    touched: list[bool]  # of every result with contacts, whether any was touched
    said: dict[str, None]  # what results warn of their scenes

    def __call__(self, method: _Maker, values: Mapping[str, Any]) -> Verdict:
        """The verdict on one cell. KeyboardInterrupt where the user pressed Ctrl-C."""
        try:
            made = self._made(method, values)
            if isinstance(made, Result):
                return self._judged(made, None if self.truths is None else self.truths(values))
            return Verdict(made) if isinstance(made, Outcome) else made
        except WrongFunction:
            raise
        except (LcpflexError, ArithmeticError, np.linalg.LinAlgError) as error:
            return judge_error(error, self.criteria)

    def _made(self, method: _Maker, values: Mapping[str, Any]) -> Outcome | Verdict | Result:
        """What the method says, or the result of the stepper that it makes."""
        scene = _scene_of(self.build, values)
        made = method(values, **({BUILT: scene} if method.wants_scene else {}))
        if isinstance(made, (Outcome, Verdict, Result)):
            return made
        if not is_stepper(made):
            raise WrongFunction(
                f"{method.label}: the function returned {shown(made)}; expected a stepper, an Outcome or a Result"
            )
        if self.duration is None:
            raise WrongFunction(
                f"duration: not given, but {method.label} returned a stepper; expected a number > 0 [s]"
            )
        return given_up_after(self.time_limit, scene, self.duration, made, self.record)

    def _judged(self, result: Result, truth: Truth | None) -> Verdict:
        if not result.complete and result.message.startswith("interrupted"):
            raise KeyboardInterrupt
        if result.contact_names:
            self.touched.append(bool(np.any(result.impulse)))
        self.said.update(dict.fromkeys(scene_warnings(result)))
        said = called("judge", self.judge, "an Outcome or None", result) if self.judge is not None else None
        if not (said is None or isinstance(said, Outcome)):
            raise WrongFunction(f"judge: the function returned {shown(said)}, expected an Outcome or None")
        check = None if self.check is None else self._error
        return Verdict(said) if said is not None else judge_result(result, self.criteria, check, truth)

    def _error(self, result: Result) -> float:
        """What the check says of a result."""
        assert self.check is not None
        error = called("check", self.check, "the error of the result", result)
        undefined = isinstance(error, float | np.floating) and math.isnan(error)  # which counts as wrong
        if not (undefined or as_number(error) >= 0.0):
            raise WrongFunction(f"check: the function returned {shown(error)}, expected an error, a number >= 0")
        return as_number(error)


def _fill(
    trial: _Trial, makers: Mapping[str, _Maker], axes: Mapping[str, tuple[Any, ...]], progress: bool | None
) -> StabilityMap:
    """Try every cell; cells that differ in nothing their method and scene take are tried once."""
    shape = (len(makers), *(len(values) for values in axes.values()))
    outcomes = np.full(shape, Outcome.NOT_RUN, dtype=object)
    messages = np.full(shape, "", dtype=object)
    errors, seconds = np.full(shape, np.nan), np.zeros(shape)
    known: dict[tuple[int, ...], Verdict] = {}
    labels = list(makers)
    with Progress(progress, what="stability", total=outcomes.size, unit="cell", leave=False) as bar:
        for place in np.ndindex(shape):
            method = makers[labels[place[0]]]
            values = {name: axes[name][i] for name, i in zip(axes, place[1:], strict=True)}
            taken = {*method.takes, *trial.build.takes}
            same = (place[0], *(i if name in taken else -1 for name, i in zip(axes, place[1:], strict=True)))
            began = time.perf_counter()
            if same not in known:
                try:
                    known[same] = trial(method, values)
                except KeyboardInterrupt:
                    break
                seconds[place] = time.perf_counter() - began
            one = known[same]
            outcomes[place], messages[place], errors[place] = one.outcome, one.message, one.error
            bar.update()
    notes = _notes(trial, outcomes)
    return StabilityMap(tuple(makers), axes, outcomes, messages, seconds, errors, notes)


def _notes(trial: _Trial, outcomes: Any) -> tuple[str, ...]:
    """What a reader of the map must know: what it was compared with, and whether anything touched."""
    notes = []
    found = list(trial.truths.found.values()) if trial.truths is not None else []
    limit = f"sound is an error below {100.0 * trial.criteria.error:g} %"
    if known := [one.source for one in found if one.known]:
        more = f", and {len(known) - 1} more" if len(known) > 1 else ""
        notes.append(f"{limit}, relative to {known[0]}{more}")
    if lost := [one.source for one in found if not one.known]:
        scenes = f" for {len(lost)} of {len(found)} scenes" if len(found) > 1 else ""
        notes.append(f"nothing is called sound{scenes}: {lost[0]}")
    if trial.truths is None and np.any(outcomes == Outcome.NO_TROUBLE):
        notes.append(
            "no truth was taken: a run without a sign of trouble may still be wrong; truth=True compares each with one"
        )
    if trial.touched and not any(trial.touched):
        notes.append("nothing touched in any run: this says nothing about contact")
    if trial.said:
        more = f" (and {len(trial.said) - 1} more)" if len(trial.said) > 1 else ""
        notes.append(f"whatever the method, the scene itself is doubtful: {next(iter(trial.said))}{more}")
    return tuple(notes)


def _check_names(axes: Mapping[str, Any], builder: _Maker, makers: Mapping[str, _Maker]) -> None:
    for name in axes:
        if not any(name in maker.takes for maker in (builder, *makers.values())):
            owners = "; ".join(
                f"{maker.label}: {', '.join(maker.known) or 'none'}" for maker in (builder, *makers.values())
            )
            near = meant(name, {known for maker in (builder, *makers.values()) for known in maker.known})
            raise ModelError(
                f"axes: nothing takes {shown(name)}{near}; expected a parameter of one of these ({owners})"
            )
