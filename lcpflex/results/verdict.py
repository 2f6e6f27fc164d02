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
from lcpflex.results.words import SHARED, with_unit

if TYPE_CHECKING:
    from lcpflex.results.measured_error import MeasuredError
    from lcpflex.results.result import Result

__all__ = ["NOT_TRUSTED", "TRUSTED", "UNVERIFIED", "Verdict", "verdict_of"]

TRUSTED, UNVERIFIED, NOT_TRUSTED = "Trusted", "Unverified", "NOT to be trusted"
LEVELS = {TRUSTED: 2, UNVERIFIED: 1, NOT_TRUSTED: 0}
PASSED = "Its checks pass (energy, contact problems, gaps, joints), which say nothing of that"
OF_EXTENT = "the largest extent or travel"
CHOSEN = "friction shares loads here in more ways than one: another method may come to another motion at any step"
LARGE = PARTED  # of the largest speed: an error of that size is none to be trusted within
BEGUN = 0.1  # of the duration: what parts before holds nowhere
LEAST = 1e-6  # a smaller share is told as less than that
LONGEST = 160  # characters of a note on reruns that a sentence has
LISTED = 3  # contacts whose touches are told


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
    warned = " Read its warnings." if result.warnings else ""
    if result.error is None:
        sentence = (
            f"{UNVERIFIED}: how accurate the steps are is not known; result.verify() measures it, for {_work(result)} "
            f"the work of this run. {PASSED}.{warned}"
        )
        return Verdict(UNVERIFIED, result.warnings, numbers, sentence)
    error = result.error
    remarks = (*error.notes, *([CHOSEN] if any(SHARED in note for note in result.notes) else []))
    told = "".join(f" {_sentence(shorten(note, LONGEST, placeholder=' ...'))}" for note in remarks)
    sentence = f"{TRUSTED} {_within(result, error)}{told}{warned}"
    return Verdict(TRUSTED, (*result.warnings, *remarks), numbers, sentence)


def _sentence(note: str) -> str:
    return f"{note[:1].upper()}{note[1:].rstrip('.')}."


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
        f"reruns are off by up to {_share(share)} in positions{_metres(result, share)}, and near it up to "
        f"t = {error.horizon:.6g} s alone{f' ({error.parted})' if error.parted else ''}"
    )
    return (Alarm(clause, "accuracy", "", error.horizon, off, FINER),)


def _share(value: float) -> str:
    """A share with the two digits that an estimate has, down to what matters to nobody."""
    return f"{_rough(100.0 * value):g} %" if not value < LEAST else f"less than {100.0 * LEAST:g} %"


def _rough(value: float) -> float:
    return float(f"{value:.2g}")


def _within(result: Result, error: MeasuredError) -> str:
    """Up to when reruns bear a result out, and within what: steps and modes together, the larger error first."""
    until = min(error.horizon, error.modes_horizon)
    whole = error.whole and math.isinf(error.modes_horizon)
    reach = error.up_to(until)
    steps = max(reach.place_share, reach.turn_share)
    modes = 0.0 if error.modes is None else error.modes / error.extent
    modes = modes if whole or math.isinf(error.modes_horizon) else PARTED
    head = "" if whole else f"up to {with_unit(until, 's')} "
    parts = f": steps {_share(steps)}, modes {_share(modes)}" if error.modes is not None else ""
    positions = f"{head}within {_share(steps + modes)} in positions{_metres(result, steps + modes, parts)}"
    speeds = f"{'but' if reach.speed_share > LARGE else 'and'} {_share(reach.speed_share)} of the largest speed"
    mean = f" ({_share(error.speed_rms_share)} on the average of all times)" if whole else ""
    after = "" if whole else f"; {_after(result, error)}"
    return f"{positions}, {speeds} in velocities between impacts{mean}{after}.{_touches(error)}"


def _metres(result: Result, share: float, parts: str = "") -> str:
    """A share as a length, of what, and what it is made of, in brackets; a user's own numbers have ranges."""
    if result.compiled is None or result.error is None:
        return f" (of their ranges{parts})"
    extent = f"{with_unit(_rough(result.error.extent), 'm')}, {OF_EXTENT}{parts}"
    if share < LEAST:  # rounding
        return f" (of {extent})"
    return f" ({with_unit(_rough(share * result.error.extent), 'm')} of {extent})"


def _after(result: Result, error: MeasuredError) -> str:
    """What becomes of it after the time up to which it holds, and what to do."""
    if error.modes_horizon < error.horizon:
        off = 0.0 if error.modes is None else error.modes / error.extent
        length = "" if result.compiled is None else f" ({with_unit(_rough(off * error.extent), 'm')})"
        alone = error.up_to(error.horizon)
        steps = max(alone.place_share, alone.turn_share)
        return (
            f"after that positions may be off by {_share(off)}{length}: give the bodies more modes (the steps alone "
            f"err by {_share(steps)} up to {with_unit(error.horizon, 's')})"
        )
    if error.place_share + error.turn_share <= PARTED:
        return "no rerun came farther"
    where = error.parted.removesuffix(" the runs part")
    since = f", {where}," if where and where != error.parted else ""
    return f"after that{since} the reruns part from the run: a shorter step or tighter tolerances may carry farther"


def _touches(error: MeasuredError) -> str:
    """Of each contact how often it touched, in this run and in each rerun: those that touch differently first."""
    if not error.touches:
        return ""
    ordered = sorted(error.touches, key=lambda one: len(set(one[1])) == 1)[:LISTED]
    told = "; ".join(f"{name!r} {', '.join(map(str, counts))}" for name, counts in ordered)
    more = len(error.touches) - len(ordered)
    rest = f"; and {more} more contacts" if more > 0 else ""
    return f" Touches in this run and its reruns: {told}{rest}."
