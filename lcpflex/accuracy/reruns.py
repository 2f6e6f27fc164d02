"""The runs by which a run is checked: the same method made finer, and another method."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import partial
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
    from collections.abc import Callable, Iterator, Sequence

    from lcpflex.results.result import Result
    from lcpflex.runs.origin import Origin
    from lcpflex.runs.setup import Options

__all__ = ["QUARTER", "Finished", "attempted", "checking_runs", "rerun", "stored_interval", "unsensed"]

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


def attempted(
    source: Any, stepper: Any, options: Options, most: float = math.inf, seconds: float | None = None
) -> tuple[Result | None, str]:
    """A run as far as it comes in ``most`` steps and events and so many seconds of computing, and why it stopped.

    Empty where it came to its end; no result where it did not begin. Raises KeyboardInterrupt where it was interrupted.
    """
    look()
    try:
        found = carry_out(set_up(source, stepper, options, None), False, budget=seconds, most=most)
    except StepError as error:
        return error.result, str(error)
    except LcpflexError as error:  # also of a method that does not take this scene
        return None, str(error)
    if found.complete:
        return found, ""
    if found.message.startswith("interrupted"):
        raise KeyboardInterrupt
    return found, found.message


def rerun(
    origin: Origin,
    stepper: Any,
    what: str,
    factor: float,
    until: float,
    interval: float,
    most: float = math.inf,
    seconds: float | None = None,
) -> Finished | str:
    """The scene of a run with another stepper, as far as it comes in the ``most`` steps; why it came to nothing.

    seconds: of computing, after which it ends where it is. Raises KeyboardInterrupt where it was interrupted.
    """
    options = replace(
        origin.options, duration=until, interval=interval, notes=(), began_wrong=(), records_problems=False, choice=None
    )
    found, ended = attempted(origin.source, stepper, options, most, seconds)
    if found is None or len(found.times) < 2:
        return f"{brief(stepper)}: {ended}"
    told = Rerun(what, found.stepper, found.steps, found.wall_time, float(found.times[-1]), factor, ended)
    return Finished(told, found)


def unsensed(origin: Origin) -> Origin:
    """The same without its sensors, which a comparison of motions does not read."""
    return replace(origin, source=replace(origin.source, sensors=()))


def checking_runs(
    origin: Origin,
    until: float,
    steps: int,
    other: bool = True,
    seconds: float | None = None,
    enough: int = ENOUGH,
) -> Iterator[Finished | str]:
    """The reruns that check a run, the surest first: two with steps, or tolerances, and one of an event-driven run.

    Each is made when it is asked for.

    Parameters
    ----------
    origin
        What the run came from.
    until, steps
        How far it came [s], and in how many steps.
    other
        Whether another method may be one of them.
    seconds
        Of computing, after which each of them ends where it is; any by default.
    enough
        Steps that an event-driven run may take in any case; else as many as cost less than a quarter of the step.
    """
    stepper = settled(origin.stepper, until / max(1, steps))
    origin, number = replace(origin, stepper=stepper), fineness(stepper)
    if number is None:
        raise ModelError(f"verify: {brief(stepper)} has neither a step nor a tolerance to be made finer by")
    controlled, interval = number[0] == "rtol", stored_interval(origin)
    high = controlled and type(stepper).__name__ in HIGH_ORDER
    if controlled and not high:
        interval /= BETWEEN
    again = partial(rerun, origin, until=until, interval=interval, seconds=seconds)
    if high and number[1] < FINEST:
        yield again(refined(stepper, 1.0 / HUNDREDTH), "a hundred times the tolerance", 1.0)
        return
    if high:
        yield again(refined(stepper, HUNDREDTH), "a hundredth of the tolerance", 1.25)
        return
    finest, last = (
        ("a sixteenth of the tolerance", "a quarter of the tolerance")
        if controlled
        else ("a quarter of the step", "half the step")
    )
    yield again(refined(stepper, QUARTER**2 if controlled else QUARTER), finest, 2.0)
    most = max(enough, QUARTER * steps / CALLS)
    found = _another_method(again, _others(origin, until), most) if other else None
    yield found or again(refined(stepper, QUARTER if controlled else 2.0), last, 2.0)


def stored_interval(origin: Origin) -> float:
    """Time between the instants that a run has stored, which its reruns store, too [s]."""
    number, asked = fineness(origin.stepper), origin.options.interval
    if number is None or number[0] == "rtol":
        return asked
    step = number[1]
    return max(1, round(asked / step)) * step if asked > 0.0 else step


def _another_method(again: Callable[..., Finished | str], others: Sequence[Any], most: float) -> Finished | None:
    """The first of other methods that comes to the end, event-driven in ``most`` steps; None where none does."""
    for other in others:
        limit = most if type(other).__name__ == "EventDriven" else math.inf
        found = again(other, "another method", 2.0, most=limit)
        if isinstance(found, Finished) and not found.told.ended:
            return found
    return None


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
