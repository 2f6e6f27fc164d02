"""Whether a run of a random scene is right, loud, or silent: wrong without a word.

A scene has a truth up to the time at which event-driven stepping at a tolerance of 1e-12 and another method, fine
enough, differ by more than ``AGREED`` of its size. A run is wrong where places, or velocities off impacts, are off by
more than ``OFF`` of the size (or of the largest speed) and by more than the run itself says, or where bodies are in
each other. Wrong is loud with a doubt, hinted with warnings alone, understated where the run says that it is off by
more than ``OFF``, but of another measure or by less, and else silent; a run that is right and has a doubt is a false
alarm. Velocities jump: they are compared within the time by which an impact may be displaced, two steps or what a
place needs for ``OFF`` of the size, and a difference must last longer than that.
"""

from __future__ import annotations

import time
import warnings
from collections import Counter
from collections.abc import Iterable
from dataclasses import asdict, dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt

import lcpflex as lf
from lcpflex.results.doubts import doubts
from lcpflex.runs.limits import TOO_LATE
from tests.property.built_scenes import stepper_of
from tests.property.random_scenes import Drawn
from tests.property.seen import Seen
from tests.property.truths import LEAST, PATIENCE, Truth, carried, largest, reference_runs, truth_of

__all__ = [
    "JUDGED",
    "OFF",
    "RIGHT",
    "WRONG",
    "Errors",
    "Verdict",
    "alarms",
    "judge",
    "judge_result",
    "outcome_of",
    "quiet",
    "stops",
]

Array = npt.NDArray[np.float64]

OFF = 0.02  # of the size or the largest speed: wrong
MOSTLY = 0.5  # of the instants velocities must have a truth for a doubt to be false
MOST = 400  # instants at which velocities are compared
SHIFTS = 41  # of a reference within the time by which an impact may be displaced
LONGEST = 0.02  # [s] by which an impact may be displaced
RIGHT = ("quiet", "warned", "alarm")
WRONG = ("silent", "understated", "hinted", "loud")
JUDGED = (*RIGHT, "stated", "stopped", *WRONG)


@dataclass(frozen=True)
class Errors:
    """Of a result, over the size or the largest speed."""

    off: float = 0.0  # the largest of a place
    off_speed: float = 0.0  # of a velocity
    stated: float = 0.0  # the result's own, where reruns have measured it
    stated_speed: float = 0.0
    depth: float = 0.0  # of bodies in each other or in walls, beyond that of the reference
    known: float = 1.0  # share of the instants at which velocities have a truth

    @property
    def right(self) -> bool:
        """Not of a NaN."""
        return self.off <= OFF and self.off_speed <= OFF and self.depth <= OFF

    @property
    def wrong(self) -> bool:
        """By more than the run says."""
        place = max(self.off, self.depth) <= max(OFF, self.stated)
        return not (place and self.off_speed <= max(OFF, self.stated_speed))


@dataclass(frozen=True)
class Verdict:
    """What became of one run."""

    dimension: int
    seed: int
    kind: str
    outcome: str  # one of JUDGED, or: no truth, refused, slow
    stepper: str
    truth: float = 0.0  # [s]
    errors: Errors = Errors()
    said: str = ""
    seconds: float = 0.0

    def line(self) -> dict[str, Any]:
        """For a log."""
        line = asdict(self)
        line |= line.pop("errors")
        return {key: round(value, 6) if isinstance(value, float) else value for key, value in line.items()}


def quiet(counts: Counter[str]) -> float:
    """Of the runs that are right, the share of those without a word."""
    right = sum(counts[name] for name in RIGHT)
    return counts["quiet"] / right if right else 1.0


def alarms(counts: Counter[str]) -> float:
    """Of the runs that are right, the share of those that are called not to be trusted."""
    return counts["alarm"] / max(1, sum(counts[name] for name in RIGHT))


def stops(counts: Counter[str]) -> float:
    """Of the runs that have a truth, the share of those that end with an error."""
    return counts["stopped"] / max(1, sum(counts[name] for name in JUDGED))


def _nearest(mine: Array, theirs: list[Array]) -> Array:
    """Least distance (m,) of velocities (m, p, d) from the way through others, straight from one to the next."""
    least = np.full(len(mine), np.inf)
    for first, second in pairwise(theirs):
        way = second - first
        length = np.sum(way * way, axis=(1, 2))
        share = np.sum((mine - first) * way, axis=(1, 2)) / np.where(length > 0.0, length, 1.0)
        least = np.minimum(least, largest(mine - first - np.clip(share, 0.0, 1.0)[:, None, None] * way))
    return least


def _lasting(times: Array, errors: Array, window: Array) -> Array:
    """The least error within ``window`` after each instant: what passes sooner is an impact at another time."""
    last = np.searchsorted(times, times + window, side="right")
    return np.array([errors[k:end].min() for k, end in enumerate(last)])


def _speed_errors(truth: Truth, result: lf.Result, seen: Seen, rows: Any, least: float) -> tuple[Array, float]:
    """Differences of velocities (m,) from the nearer reference, 0 where these differ, and how often they do not.

    An impact may be displaced by ``least`` [s], or by the time in which a place moves by ``OFF`` of the size.
    """
    rows = rows[:: -(-len(rows) // MOST)]
    t = result.times[rows]
    mine, now = seen.rates(result.q[rows], result.u[rows]), truth.first.rates(t)
    window = np.clip(OFF * truth.size / np.maximum(largest(now), 1e-300), least, max(least, LONGEST))
    shifts = np.clip(t + window * np.linspace(-1.0, 1.0, SHIFTS)[:, None], 0.0, truth.until)
    one, other = ([run.rates(at) for at in shifts] for run in (truth.first, truth.second))
    sure = _nearest(now, other) <= 0.25 * OFF * truth.speed
    error = np.minimum(_nearest(mine, one), _nearest(mine, other))
    return _lasting(t, np.where(sure, error, 0.0), window), float(sure.mean())


def judge_result(drawn: Drawn, result: lf.Result, truth: Truth) -> Errors:
    """How far it is off, by what it says and in truth."""
    seen = Seen(drawn, result)
    rows = np.flatnonzero(result.times <= truth.until)
    there = truth.first.places(result.times[rows])
    off = float(largest(seen.places(result.q[rows]) - there).max()) / truth.size
    window = 2.0 * drawn.fineness if drawn.fixed else 0.0
    speeds, known = _speed_errors(truth, result, seen, rows, window)
    right = truth.first.result
    held = np.flatnonzero(right.times <= truth.until)
    depth = seen.depth(result, rows) - max(0.0, truth.first.seen.depth(right, held))
    place, speed = _stated(result, truth.until)
    off_speed = float(speeds.max()) / truth.speed
    return Errors(off, off_speed, place, speed, max(0.0, depth) / truth.size, known)


def _stated(result: lf.Result, until: float) -> tuple[float, float]:
    """How far off a result says that its points and their velocities are, up to some time; 0 where it does not."""
    if result.error is None:
        return 0.0, 0.0
    reach = result.error.up_to(until)
    return reach.place_share + reach.turn_share, reach.speed_share


def judge(drawn: Drawn) -> Verdict:
    """Run the scene, and its references, and tell what the result is worth."""
    began = time.perf_counter()

    def verdict(outcome: str, said: str = "", until: float = 0.0, errors: Errors | None = None) -> Verdict:
        spent, stepper = time.perf_counter() - began, repr(stepper_of(drawn))
        errors = errors or Errors()
        return Verdict(drawn.dimension, drawn.seed, drawn.kind, outcome, stepper, until, errors, said[:600], spent)

    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        result, ended = carried(drawn, stepper_of(drawn), 3.0 * PATIENCE)
    if result is None or TOO_LATE in ended:
        return verdict("slow" if result else "refused", ended)
    found = reference_runs(drawn)
    if isinstance(found, str):
        return verdict("no truth", found)
    truth = truth_of(drawn, *found)
    if truth.until < LEAST:
        return verdict("no truth", ended, truth.until)
    if ended:
        return verdict("stopped", ended, truth.until)
    told = [f"{w.message}" for w in caught if issubclass(w.category, lf.ModelWarning)]
    errors = judge_result(drawn, result, truth)
    if errors.wrong and not doubts(result):  # it is "unverified": what counts is what reruns say
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            result.verify(progress=False)
        errors = judge_result(drawn, result, truth)
    outcome, said = outcome_of(errors, doubts(result), [*result.warnings, *told])
    if outcome == "alarm" and not _in_doubt(replace(drawn, duration=truth.until)):
        outcome = "no truth"  # of what the doubt is about, which comes later
    return verdict(outcome, said, truth.until, errors)


def _in_doubt(drawn: Drawn) -> bool:
    """Whether the scene's own run has doubts."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        result, ended = carried(drawn, stepper_of(drawn), 3.0 * PATIENCE)
    return result is None or bool(ended) or bool(doubts(result))


def outcome_of(errors: Errors, doubted: Iterable[str], warned: Iterable[str]) -> tuple[str, str]:
    """What a run is, and all that it says."""
    doubted = [f"doubt: {text}" for text in doubted]
    said = "; ".join([*doubted, *warned])
    if errors.right:
        if doubted and errors.known < MOSTLY:
            return "no truth", said  # a doubt of the energy is none of places
        return ("alarm" if doubted else "warned" if said else "quiet"), said
    if not errors.wrong and not doubted:
        return "stated", said
    coarse = max(errors.stated, errors.stated_speed) > OFF  # which its verdict tells, with what to do
    return ("loud" if doubted else "hinted" if said else "understated" if coarse else "silent"), said
