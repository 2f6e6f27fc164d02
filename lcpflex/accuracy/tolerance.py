"""A run to a tolerance: fidelity, method and step are chosen by short runs, and another method bears the run out.

All is counted in steps and events, nothing by the clock: the same script chooses the same on every machine.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from lcpflex.accuracy.fidelity import Modes, chosen_modes, with_enough_modes
from lcpflex.accuracy.hidden_loads import looked_at
from lcpflex.accuracy.outputs import chosen_outputs
from lcpflex.accuracy.refinement import brief
from lcpflex.accuracy.reruns import Finished
from lcpflex.accuracy.settling import Refused, Settled, settled
from lcpflex.accuracy.trials import Level, Made, Trials
from lcpflex.accuracy.verify import measured
from lcpflex.basics.progress import Progress
from lcpflex.errors import ModelError, ToleranceError, in_range, shown
from lcpflex.jit.background import expecting
from lcpflex.results.measured_error import Rerun
from lcpflex.results.run_choice import RunChoice
from lcpflex.runs.initial_state import began_wrong, started_from
from lcpflex.runs.named_steppers import kind_named
from lcpflex.runs.origin import Origin
from lcpflex.runs.request import checked_request, stored_interval
from lcpflex.runs.setup import Options, compiled_for, set_up
from lcpflex.runs.simulate import carry_out, kind_of_run
from lcpflex.scene.user_system import UserSystem
from lcpflex.statics.rest import Rest

if TYPE_CHECKING:
    from lcpflex.results.energy_balance import EnergyGrowth
    from lcpflex.results.result import Result

__all__ = ["run_to_tolerance"]

TIGHTEST, LOOSEST = 1e-6, 0.5
COARSEST = 200  # stored instants in the duration, by which runs are compared; coarser records are made at the end
TRIED = ("EventDriven", "GeneralizedAlpha", "MoreauJean")


def run_to_tolerance(
    scene: Any,
    duration: float,
    tolerance: float,
    outputs: Any,
    stepper: Any,
    record: Any,
    progress: Any,
    project: Any,
    energy_growth: EnergyGrowth,
    initial: Result | Rest | None,
    left: dict[str, Any],
) -> Result:
    """See ``tolerance`` of :func:`lcpflex.simulate`. ``left``: arguments that must not be given with it.

    Raises
    ------
    ModelError
        For arguments out of their range.
    ToleranceError
        Where the tolerance cannot be had; with the best run made.
    """
    tolerance = in_range("tolerance", tolerance, TIGHTEST, LOOSEST)
    _refuse(left)
    pinned = _pinned(stepper)
    usual = kind_named("event-driven")() if pinned is None else pinned
    duration, _, progress, project = checked_request(duration, usual, record, progress, project, energy_growth, None)
    chosen = () if outputs is None else chosen_outputs(outputs)
    with expecting(kind_of_run(scene, usual)), Progress(progress, lambda: "choosing", what="simulate", bar=False):
        request = _Request(scene, duration, tolerance, usual, project, initial)
        options = Options(
            duration, _interval(record, duration), project, energy_growth, (), began_wrong(initial), 0.0, False, None
        )
        trials = Trials(options, chosen)
        level = request.level(scene)
        trials.options = replace(options, notes=request.notes)
        looked = ""
        kept = Modes(None, 0.0, "", "modes are those of the state that it began from") if initial is not None else None
        try:
            looked = looked_at(level.source, duration)
            modes = kept or with_enough_modes(trials, scene, level, request.level, tolerance, pinned)
            level = modes.level or level
            answer = settled(trials, level, tolerance - modes.error, modes.made, pinned)
        except Refused as refusal:
            raise _error(trials, refusal, tolerance, looked, scene) from None
        if chosen and not trials.told:
            names = ", ".join(repr(output.name) for output in chosen)
            raise ModelError(f"outputs: {names} are 0 throughout, and no error is relative to that; expected others")
        return _answer(trials, answer, modes, tolerance, looked, record, scene)


def _refuse(left: dict[str, Any]) -> None:
    """Raise ModelError for what a run to a tolerance does not take."""
    reasons = {
        "checkpoint": "it makes several runs, of which a file could hold one: run with result.choice's stepper instead",
        "budget": "what is chosen must not hang on the clock: its work is counted",
        "record_problems": "it makes several runs: record those of one with result.choice's stepper",
    }
    for name, value in left.items():
        if value is not None:
            raise ModelError(f"{name}: {shown(value)} was given with a tolerance, expected None: {reasons[name]}")


def _pinned(stepper: Any) -> Any:
    """The method that was given, of which only the step or the tolerance is chosen; None: any."""
    if stepper is None:
        return None
    if isinstance(stepper, str):
        kind = kind_named(stepper)
        stepper = kind() if kind.__name__ == "EventDriven" else kind(step=1e-3) if kind.__name__ in TRIED else kind
    name = type(stepper).__name__
    plain = name in TRIED and getattr(stepper, "adaptive", None) is None
    newton = type(getattr(stepper, "impact", None)).__name__ in ("Newton", "NoneType")
    if plain and newton:
        return stepper
    why = (
        "other impact laws have no second method to bear them out"
        if plain
        else "other methods have no second one for the same equations, or choose their steps themselves"
    )
    raise ModelError(
        f"stepper: {shown(stepper)} was given with a tolerance, expected None, or EventDriven, GeneralizedAlpha or "
        f"MoreauJean with fixed steps and Newton's impact law: {why}"
    )


def _interval(record: Any, duration: float) -> float:
    """Time between stored instants of the trials [s]: that asked for, where runs can be compared by it."""
    asked = stored_interval(record, duration, None)
    return asked if 0.0 < asked <= duration / COARSEST else stored_interval(None, duration, None)


class _Request:
    """What is compiled anew for each number of modes."""

    def __init__(self, scene: Any, duration: float, tolerance: float, stepper: Any, project: bool, initial: Any):
        self._stepper, self._project, self._initial = stepper, project, initial
        self.notes: tuple[str, ...] = ()

    def level(self, scene: Any) -> Level:
        """The scene, compiled."""
        resting = isinstance(self._initial, Rest)
        push = None if resting else self._project and self._initial is None
        source = compiled_for(scene, self._stepper, self._project or resting, push)
        if self._initial is not None:
            source, self.notes = started_from(source, self._initial, self._stepper)
        count = len(np.asarray(source.u))
        modes = 0 if isinstance(source, UserSystem) else chosen_modes(scene)
        return Level(scene, source, modes, count)


def _answer(
    trials: Trials, answer: Settled, modes: Modes, tolerance: float, looked: str, record: Any, scene: Any
) -> Result:
    """The run, with its choice and its error."""
    made = answer.made
    claimed = answer.claim + modes.error
    choice = RunChoice(
        tolerance=tolerance,
        measure=_measure(trials, made),
        claimed=claimed,
        modes=modes.error if modes.level is not None else None,
        trials=tuple(trials.rows),
        chosen=made.number,
        why="; ".join(text for text in (modes.why, answer.why) if text),
        confirmed=answer.confirmed,
        outputs=_by_output(trials, answer),
        notes=tuple(text for text in (modes.note, looked) if text),
    )
    result = _as_recorded(trials, made, record)
    return _with_choice(trials, result, choice, made, answer.against, modes, scene)


def _by_output(trials: Trials, answer: Settled) -> dict[str, float]:
    """The largest difference of each output, in the times that it counts."""
    found: dict[str, float] = {}
    for other, factor in answer.against:
        for name, value in trials.apart_by_output(answer.made, other).items():
            found[name] = max(found.get(name, 0.0), factor * value)
    return found


def _measure(trials: Trials, made: Made | None) -> str:
    if trials.outputs:
        names = ", ".join(one.name for one in trials.outputs)
        return f"the range of {names}"
    if made is None:
        return "the largest extent or travel"
    if made.result.compiled is None:
        return "the range of each coordinate"
    return f"the largest extent or travel ({trials.extent(made):.3g} m), at the point of a body that is worst off"


def _as_recorded(trials: Trials, made: Made, record: Any) -> Result:
    """The run with the instants that were asked for: made once more where others were compared."""
    asked = stored_interval(record, trials.duration, made.stepper)
    if record is None or asked == trials.options.interval:
        return made.result
    options = replace(trials.options, interval=asked)
    return carry_out(set_up(made.level.source, made.stepper, options, None), False)


def _with_choice(
    trials: Trials,
    result: Result,
    choice: RunChoice,
    made: Made,
    against: Sequence[tuple[Made, float]],
    modes: Modes,
    scene: Any,
) -> Result:
    reruns = [Finished(_told(other, factor, made), other.result) for other, factor in against]
    error = measured(result, reruns) if reruns else None
    if error is not None and modes.level is not None:
        error = replace(error, modes=modes.error * error.extent, modes_note=modes.why)
    origin = Origin(made.level.source, made.stepper, trials.options, made.level.scene)
    note = f"{brief(made.stepper)} was chosen for a tolerance of {choice.tolerance:.3g}; result.choice says why"
    return replace(result, error=error, choice=choice, origin=origin, notes=(note, *result.notes))


def _told(other: Made, factor: float, made: Made) -> Rerun:
    run = other.result
    same = type(other.stepper) is type(made.stepper)
    what = "another method" if not same else "a looser tolerance" if hasattr(other.stepper, "rtol") else "a longer step"
    return Rerun(what, run.stepper, run.steps, run.wall_time, float(run.times[-1]), factor)


def _error(trials: Trials, refusal: Refused, tolerance: float, looked: str, scene: Any) -> ToleranceError:
    """The refusal, with the best run made."""
    best = refusal.best
    choice = RunChoice(
        tolerance=tolerance,
        measure=_measure(trials, best),
        claimed=math.inf,
        modes=None,
        trials=tuple(trials.rows),
        chosen=0 if best is None else best.number,
        why=refusal.reason,
        confirmed="",
        notes=tuple(text for text in (looked,) if text),
    )
    message = f"tolerance: {tolerance:.3g} cannot be had: {refusal.reason}"
    if best is None:
        partial = trials.partial
        return ToleranceError(message, None if partial is None else replace(partial, choice=choice))
    near = [(one, 2.0) for one in refusal.others if one.level is best.level]
    result = _with_choice(trials, best.result, choice, best, near, Modes(None, 0.0, ""), scene)
    return ToleranceError(message, result)
