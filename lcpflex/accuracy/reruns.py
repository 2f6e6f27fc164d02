"""The runs by which a run is checked: the same method made finer, and another method."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from lcpflex.accuracy.refinement import brief, fineness, refined, settled
from lcpflex.basics.progress import look
from lcpflex.errors import LcpflexError, ModelError, StepError
from lcpflex.results.measured_error import Rerun
from lcpflex.runs.default_stepper import Wish
from lcpflex.runs.named_steppers import kind_named
from lcpflex.runs.setup import set_up
from lcpflex.runs.simulate import carry_out

if TYPE_CHECKING:
    from collections.abc import Iterator

    from lcpflex.results.result import Result
    from lcpflex.runs.origin import Origin

__all__ = ["Finished", "checking_runs", "rerun", "stored_interval"]

QUARTER, HUNDREDTH = 4.0, 100.0
FINEST = 1e-11  # rtol of these, below which one of a looser tolerance checks it: rounding is as large
ENOUGH = 4000  # steps that an event-driven run may take in any case: less than what loading its kernels takes
HIGH_ORDER = ("EventDriven", "Smooth")  # a tolerance a hundred times tighter costs them two runs
BETWEEN = 4.0  # stored instants of a rerun between those of the run, where the two have not the same: near impacts
CALLS = 8.0  # evaluations of a step of order 5 with an event now and then, over those of a time step


@dataclass(frozen=True, slots=True, eq=False)
class Finished:
    """A rerun with its result."""

    told: Rerun
    result: Result


def rerun(
    origin: Origin, stepper: Any, what: str, factor: float, until: float, interval: float, most: float = math.inf
) -> Finished | str:
    """The scene of a run with another stepper, as far as it comes in the ``most`` steps; why it came to nothing.

    Raises KeyboardInterrupt where it was interrupted.
    """
    look()
    options = replace(
        origin.options, duration=until, interval=interval, notes=(), began_wrong=(), records_problems=False, choice=None
    )
    ended = ""
    try:
        found = carry_out(set_up(replace(origin.source, sensors=()), stepper, options, None), False, most=most)
        if not found.complete:
            if found.message.startswith("interrupted"):
                raise KeyboardInterrupt
            ended = found.message
    except StepError as error:
        if error.result is None:
            return f"{brief(stepper)}: {error}"
        found, ended = error.result, str(error)
    except LcpflexError as error:
        return f"{brief(stepper)}: {error}"
    if len(found.times) < 2:
        return f"{brief(stepper)}: {ended}"
    told = Rerun(what, found.stepper, found.steps, found.wall_time, float(found.times[-1]), factor, ended)
    return Finished(told, found)


def checking_runs(result: Result, origin: Origin, other: bool = True) -> Iterator[Finished | str]:
    """The reruns that check a run: two with steps, or tolerances, and one of an event-driven run.

    other: whether another method may be one of them.
    """
    until = float(result.times[-1])
    stepper = settled(origin.stepper, until / max(1, result.steps))
    origin, kind = replace(origin, stepper=stepper), fineness(stepper)
    if kind is None:
        raise ModelError(f"verify: {brief(stepper)} has neither a step nor a tolerance to be made finer by")
    interval = stored_interval(origin)
    if kind[0] == "rtol":
        yield from _of_tolerance(result, origin, until, interval, other)
        return
    yield rerun(origin, refined(stepper, QUARTER), "a quarter of the step", 2.0, until, interval)
    yield _second_opinion(result, origin, until, interval, other)


def stored_interval(origin: Origin) -> float:
    """Time between the instants that a run has stored, which its reruns store, too [s]."""
    kind, asked = fineness(origin.stepper), origin.options.interval
    if kind is None or kind[0] == "rtol":
        return asked
    return max(1, round(asked / kind[1])) * kind[1] if asked > 0.0 else kind[1]


def _of_tolerance(
    result: Result, origin: Origin, until: float, interval: float, other: bool
) -> Iterator[Finished | str]:
    stepper = origin.stepper
    if type(stepper).__name__ in HIGH_ORDER:
        if (kind := fineness(stepper)) is not None and kind[1] < FINEST:
            yield rerun(
                origin, refined(stepper, 1.0 / HUNDREDTH), "a hundred times the tolerance", 1.0, until, interval
            )
        else:
            yield rerun(origin, refined(stepper, HUNDREDTH), "a hundredth of the tolerance", 1.25, until, interval)
        return
    sixteenth = refined(stepper, QUARTER * QUARTER)
    yield rerun(origin, sixteenth, "a sixteenth of the tolerance", 2.0, until, interval / BETWEEN)
    yield _second_opinion(result, origin, until, interval / BETWEEN, other)


def _second_opinion(result: Result, origin: Origin, until: float, interval: float, asked: bool) -> Finished | str:
    """Another method where there is one for the scene and it comes to the end, else the same, a little finer."""
    most = max(ENOUGH, QUARTER * result.steps / CALLS)
    for other in _others(origin, until) if asked else ():
        limit = most if type(other).__name__ == "EventDriven" else math.inf
        found = rerun(origin, other, "another method", 2.0, until, interval, limit)
        if isinstance(found, Finished) and not found.told.ended:
            return found
    if _controlled(origin.stepper):
        return rerun(origin, refined(origin.stepper, QUARTER), "a quarter of the tolerance", 2.0, until, interval)
    return rerun(origin, refined(origin.stepper, 2.0), "half the step", 2.0, until, interval)


def _controlled(stepper: Any) -> bool:
    found = fineness(stepper)
    return found is not None and found[0] == "rtol"


def _others(origin: Origin, until: float) -> list[Any]:
    """Methods of another kind for the same equations, the cheapest first.

    None for a force law or a boundary without mass of the stepper's own, nor for a rigid pile: there event-driven
    stepping stops, generalised-alpha takes many times as long, and motions part soon whatever the method.
    """
    stepper: Any = origin.stepper
    name, impact = type(stepper).__name__, getattr(stepper, "impact", None)
    if name not in ("MoreauJean", "GeneralizedAlpha"):
        return []
    usual = Wish(None, until).choice(origin.source).stepper
    kind = type(usual).__name__
    others: list[Any] = []
    if kind == "EventDriven":
        others = [kind_named("event-driven")(**({} if impact is None else {"impact": impact}))]
    finer = refined(stepper, QUARTER)
    same = {"step": finer.step, "adaptive": finer.adaptive}
    if name == "GeneralizedAlpha":
        return [*others, kind_named("moreau-jean")(**same)]
    newton = impact is None or type(impact).__name__ == "Newton"
    if newton and kind != "MoreauJean":
        others.append(kind_named("generalized-alpha")(**same))
    return others
