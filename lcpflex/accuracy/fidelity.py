"""How many modes a scene needs for a tolerance: from few on, until twice as many change less than they may."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from lcpflex.accuracy.richer import richer
from lcpflex.accuracy.settling import Refused, first_look
from lcpflex.accuracy.trials import Level, Made, Trials
from lcpflex.scene.user_system import UserSystem

__all__ = ["Modes", "chosen_modes", "with_enough_modes"]

SHARE = 0.5  # of the tolerance, that modes may take
FEWEST = 2  # modes of the richest body from which on numbers are doubled
POORER = 2  # halvings of the modes that were given, to begin with
MOST_DOUBLINGS = 20  # no mesh that can be run has a million times as many
MOST_COORDINATES = 400  # of a scene: with more, runs take minutes
PATIENT, STUCK = 2, 0.5  # doublings in which what modes change has to fall by so much
TWICE = 2.0  # what twice as many modes change counts so many times: 1.6 to 2.2 times the true error, tried on 60 scenes


@dataclass(frozen=True, slots=True, eq=False)
class Modes:
    """What is known of the modes of a scene.

    Attributes
    ----------
    level
        The scene with enough of them; None where there are none to vary.
    error
        What they err, in the measure of the trials.
    why
        In words, how they were chosen.
    note
        What stayed as it was.
    made
        Runs of that level.
    """

    level: Level | None
    error: float
    why: str
    note: str = ""
    made: tuple[Made, ...] = ()


def with_enough_modes(
    trials: Trials, scene: Any, level: Level, level_of: Callable[[Any], Level], tolerance: float, pinned: Any
) -> Modes:
    """The scene with as many modes as the tolerance needs, of its reduced bodies.

    Raises Refused where the runs that tell cannot be made, or more modes than are run would be needed.
    """
    if isinstance(level.source, UserSystem) or not len(level.source.model.bodies.stiffness):
        return Modes(None, 0.0, "")
    note = _unknown(richer(scene)[1])
    ladder = _ladder(scene, level, level_of)
    at = next(ladder)
    run: Made | None = None
    errors: list[float] = []
    for finer in ladder:
        run = run or first_look(trials, at, tolerance, pinned)
        if finer.coordinates > MOST_COORDINATES:
            raise Refused(
                f"{_told(at, errors)}, and more make {finer.coordinates} coordinates, of at most {MOST_COORDINATES} "
                "that are tried",
                run,
            )
        try:
            other = first_look(trials, finer, tolerance, pinned)
        except Refused as refusal:
            raise Refused(f"{_told(at, errors)}, and of more {refusal.reason}", run) from None
        errors.append(TWICE * trials.apart(run, other))
        if errors[-1] <= SHARE * tolerance:
            why = f"{at.modes} modes are off by {errors[-1]:.2g} at most, and the {finer.modes} that tell it are taken"
            return Modes(finer, errors[-1], why, note, (other,))
        if len(errors) > PATIENT and min(errors[-2:]) > STUCK * errors[-1 - PATIENT]:
            whole = level_of(richer(scene, 2.0**MOST_DOUBLINGS, FEWEST)[0])
            if whole.coordinates <= MOST_COORDINATES:
                why = f"doubling modes moves much ({errors[-1]:.2g} by {finer.modes}): all {whole.modes} are taken"
                return Modes(whole, 0.0, why, note)
            until = trials.agree_until(run, other, SHARE * tolerance / TWICE)
            raise Refused(
                f"more modes do not bring runs together: {_told(finer, errors)}; they agree up to t = {until:.3g} s",
                other,
            )
        at, run = finer, other
    if run is None:
        return Modes(None, 0.0, "", note)
    return Modes(at, 0.0, f"all modes of the meshes ({at.modes}) are taken", note, (run,))


def _told(level: Level, errors: Sequence[float]) -> str:
    moved = f" move it by {errors[-1]:.2g} still" if errors else " are not known to do"
    return f"{level.modes} modes{moved}"


def _ladder(scene: Any, level: Level, level_of: Callable[[Any], Level]) -> Iterator[Level]:
    """The scene with a quarter of its modes, half, as it is, with twice as many, and on to all of its meshes.

    Of each number once. All come from the scene as it is: damping ratios of many modes are not known from few.
    """
    before: tuple[int, ...] = ()
    for power in range(-POORER, MOST_DOUBLINGS):
        made = scene if power == 0 else richer(scene, 2.0**power, FEWEST)[0]
        chosen = tuple(map(_chosen, made.parts().placed))
        if chosen == before:
            if power > 0:
                return
            continue
        before = chosen
        yield level if made is scene else level_of(made)


def chosen_modes(scene: Any) -> int:
    """Modes that were chosen of all bodies: without residual ones, of which fewer may do with more of these."""
    return sum(map(_chosen, scene.parts().placed))


def _chosen(placed: Any) -> int:
    if placed.order is not None:
        return int(placed.order.modes)
    reduction = getattr(placed.source, "reduction", None)
    return int(placed.source.modes if reduction is None else reduction.modes)


def _unknown(names: Sequence[str]) -> str:
    if not names:
        return ""
    listed = ", ".join(map(repr, names[:3]))
    return f"the modes of {listed} are as they were given: how many it has beside them is not known"
