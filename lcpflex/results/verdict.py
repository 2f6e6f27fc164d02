"""How far to trust a result: the verdict of its checks, and of reruns where there are any.

Checks are in every run: contact problems solved, gaps and joints kept, energy balanced. They say nothing of how
accurate the steps are: that is measured by reruns (``result.error``), or nothing is said of it. The first word decides.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from textwrap import shorten
from typing import TYPE_CHECKING

from lcpflex.basics.alarm import FINER, Alarm
from lcpflex.results.doubts import doubts, largest, loosest
from lcpflex.results.measured_error import PARTED
from lcpflex.results.words import with_unit

if TYPE_CHECKING:
    from lcpflex.results.measured_error import MeasuredError
    from lcpflex.results.result import Result

__all__ = ["NOT_TRUSTED", "TRUSTED", "UNVERIFIED", "Verdict", "verdict_of"]

TRUSTED, UNVERIFIED, NOT_TRUSTED = "Trusted", "Unverified", "NOT to be trusted"
LEVELS = {TRUSTED: 2, UNVERIFIED: 1, NOT_TRUSTED: 0}
PASSED = "its checks pass (energy balanced, contact problems solved, gaps and joints kept)"
LARGE = PARTED  # of the largest speed: an error of that size is none to be trusted within
BEGUN = 0.1  # of the duration: what parts before holds nowhere
LEAST = 1e-6  # a smaller share is told as less than that
LONGEST = 160  # characters of a note on reruns that a sentence has
LISTED = 4  # contacts whose touches are told


@dataclass(frozen=True)
class Verdict:
    """How far to trust a result, for programs; ``str()`` has it as a sentence.

    Attributes
    ----------
    word
        "Trusted", "Unverified" or "NOT to be trusted".
    level
        2, 1 or 0.
    reasons
        The alarms of a result that is not to be trusted (:class:`Alarm`: a text with what, where, when, amount and
        advice), else its warnings, and notes on reruns.
    numbers
        By name: "unexplained" energy over the largest stored, "residual" and "strict" of contact problems (relative),
        "penetration" and "drift" [m], and where reruns have measured the error, "place", "turn", "speed", "speed_rms"
        (shares of the largest extent or travel, or of the largest speed), "modes" (share) and "horizon" [s].
    sentence
        All of it in words.
    """

    word: str
    reasons: tuple[str, ...] = ()
    numbers: Mapping[str, float] = field(default_factory=dict)
    sentence: str = ""

    @property
    def level(self) -> int:
        """The higher, the more is known: 2 trusted, 1 unverified, 0 not to be trusted."""
        return LEVELS[self.word]

    def __str__(self) -> str:
        return self.sentence


def verdict_of(result: Result) -> Verdict:
    """The verdict on a result as it is, without any further run."""
    numbers = dict(_numbers(result))
    alarms = doubts(result)
    if not alarms and result.error is not None:
        alarms = _parted(result, result.error)
    if alarms:
        return Verdict(NOT_TRUSTED, alarms, numbers, _alarmed(alarms))
    warned = "; read its warnings" if result.warnings else ""
    if result.error is None:
        sentence = (
            f"{UNVERIFIED}: {PASSED}{warned}; how accurate the steps are is not known, result.verify() measures it "
            f"({_work(result)} the work of this run)."
        )
        return Verdict(UNVERIFIED, result.warnings, numbers, sentence)
    error = result.error
    notes = "".join(f"; {shorten(note, LONGEST, placeholder=' ...')}" for note in error.notes)
    sentence = f"{TRUSTED}{_as_modelled(error)} {_within(result, error)}{notes}{warned}."
    return Verdict(TRUSTED, (*result.warnings, *error.notes), numbers, sentence)


def _numbers(result: Result) -> Iterator[tuple[str, float]]:
    """What checks and reruns have measured, by name."""
    yield "unexplained", result.energies.relative_remainder
    yield "residual", largest(result.residual)
    yield "strict", loosest(result)
    yield "penetration", 0.0 if result.all_compliant else largest(result.penetration)
    yield "drift", largest(result.joint_drift)
    error = result.error
    if error is not None:
        for name in ("place", "turn", "speed", "speed_rms"):
            yield name, float(getattr(error, f"{name}_share"))
        if error.modes is not None:
            yield "modes", error.modes / error.extent
        yield "horizon", float(error.horizon)


def _alarmed(alarms: tuple[Alarm, ...]) -> str:
    """One alarm as a sentence, several one a line."""
    if len(alarms) == 1:
        return f"{NOT_TRUSTED}: {alarms[0]}."
    return "\n  ".join((f"{NOT_TRUSTED}, for {len(alarms)} reasons:", *(f"{alarm}." for alarm in alarms)))


def _work(result: Result) -> str:
    """How much a verification costs, in words: see :meth:`lcpflex.Result.verify`."""
    return "about twice" if result.stepper.startswith("EventDriven(") else "about six times"


def _parted(result: Result, error: MeasuredError) -> tuple[Alarm, ...]:
    """That reruns have nothing in common with a result, from the beginning or nearly so."""
    share = max(error.place_share, error.turn_share)
    if math.isfinite(share) and (error.whole or error.horizon >= BEGUN * float(result.times[-1])):
        return ()
    off = max(error.place, error.turn)
    clause = (
        f"reruns are off by up to {_share(share)} of the largest extent or travel{_metres(result, off)}, and known to "
        f"be near it up to t = {error.horizon:.6g} s alone{f' ({error.parted})' if error.parted else ''}"
    )
    return (Alarm(clause, "accuracy", "", error.horizon, off, FINER),)


def _share(value: float) -> str:
    """A share with the two digits that an estimate has, down to what matters to nobody."""
    return f"{_rough(100.0 * value):g} %" if not value < LEAST else f"less than {100.0 * LEAST:g} %"


def _metres(result: Result, value: float) -> str:
    """A length in brackets; of a user's own system it has no unit that is known."""
    return f" ({with_unit(_rough(value), 'm')})" if result.compiled is not None else ""


def _rough(value: float) -> float:
    return float(f"{value:.2g}")


def _as_modelled(error: MeasuredError) -> str:
    """That what follows says nothing of the modes left out, where these matter more."""
    return ", with the modes that it has," if error.modes is not None and error.modes > error.place else ""


def _within(result: Result, error: MeasuredError) -> str:
    """Up to when reruns bear a result out, and within what."""
    if error.whole:
        return f"{_accuracy(result, error)}{_modes(result, error)}{_touches(error)}"
    reach = error.up_to(error.horizon)
    share = max(reach.place_share, reach.turn_share)
    if error.place_share + error.turn_share <= PARTED:
        ends = "no rerun came farther"
    else:
        ends = f"{error.parted or 'the runs part'}: a shorter step, or tighter tolerances, may carry farther"
    return (
        f"up to {with_unit(error.horizon, 's')} within {_share(share)} in places"
        f"{_metres(result, share * error.extent)}; {ends}{_modes(result, error)}{_touches(error)}"
    )


def _accuracy(result: Result, error: MeasuredError) -> str:
    """Errors of places, and of rotations where they are larger, and of velocities."""
    turned = f", {_share(error.turn_share)} in rotations" if error.turn_share > error.place_share else ""
    places = f"within {_share(error.place_share)} in places{_metres(result, error.place)}{turned}"
    mean = f"{_share(error.speed_rms_share)} on the average with impacts"
    if error.speed_share <= LARGE:
        return f"{places}, {_share(error.speed_share)} in velocities off impacts, {mean}"
    if error.speed_rms_share <= LARGE:
        return f"{places}, and in velocities within {mean}, though off by {_share(error.speed_share)} at worst"
    return f"in places alone, {places}; velocities are off by {_share(error.speed_share)}, {mean}"


def _modes(result: Result, error: MeasuredError) -> str:
    """What is known of modes that a run does without."""
    if error.modes is None:
        return ""
    off = f"{_share(error.modes / error.extent)}{_metres(result, error.modes)}"
    late = f", by more than {_share(PARTED)} from t = {error.modes_horizon:.6g} s on"
    return f"; for want of more modes places may be off by {off}{late if math.isfinite(error.modes_horizon) else ''}"


def _touches(error: MeasuredError) -> str:
    """Of each contact how often it touched, in this run and in each rerun: those that touch differently first."""
    if not error.touches:
        return ""
    ordered = sorted(error.touches, key=lambda one: len(set(one[1])) == 1)[:LISTED]
    if len(error.touches) == 1:
        told = ", ".join(map(str, ordered[0][1]))
    else:
        told = "; ".join(f"of {name!r} {', '.join(map(str, counts))}" for name, counts in ordered)
    more = len(error.touches) - len(ordered)
    return f"; touches {told}" + (f"; and {more} more contacts" if more > 0 else "")
