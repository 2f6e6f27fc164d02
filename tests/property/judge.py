"""Whether a run of a random scene is right, loud, or silent: wrong without a word.

A scene has a truth up to the time at which two runs of other methods, ten and twenty times finer, differ by more than
``AGREED`` of its size. Silent is a result that says "can be trusted", has no warning, and has passed through something,
or is off by more than ``OFF`` of the size (or of the largest speed) and by more than ``TIMES`` times the error of its
steps that it states. Velocities jump: they are compared within the time by which an impact may be displaced, and a
difference must last longer than that.
"""

from __future__ import annotations

import time
import warnings
from collections.abc import Iterator
from dataclasses import asdict, dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt

import lcpflex as lf
from lcpflex.results.summary import doubts
from tests.property.overlap import Outline, deepest, outlines, speeds, tracks
from tests.property.random_scenes import Drawn, box_corners, build, references, stepper_of

Array = npt.NDArray[np.float64]

__all__ = ["AGREED", "LEAST", "OFF", "TIMES", "Verdict", "judge", "judge_result", "smaller"]

AGREED = 1e-3  # of the size: references that differ by more tell no truth any longer
OFF = 0.02  # of the size or the largest speed: wrong
TIMES = 3.0  # the stated error of the steps: more is wrong by more than its own claims
LEAST = 0.2  # [s] of truth that a scene must have to be judged
INSTANTS = 4000  # stored of a reference: between them it is taken as linear
SHIFTS = 41  # of a reference within the time by which an impact may be displaced
LONGEST = 0.02  # [s] by which an impact may be displaced
GRID = 400  # instants at which references are compared


@dataclass(frozen=True)
class Verdict:
    """What became of one run."""

    seed: int
    outcome: str  # no truth, refused, stopped, silent, loud, quiet, warned (the last two: right)
    stepper: str
    truth: float = 0.0  # [s]
    off: float = 0.0  # largest error of a place, over the size
    off_speed: float = 0.0  # of a velocity, over the largest
    stated: float = 0.0  # the result's own, over the size
    stated_speed: float = 0.0  # over the largest speed
    depth: float = 0.0  # beyond that of the reference, over the size
    said: str = ""
    seconds: float = 0.0

    def line(self) -> dict[str, Any]:
        """For a log."""
        return {key: round(value, 6) if isinstance(value, float) else value for key, value in asdict(self).items()}


def _interpolated(times: Array, values: Array, at: Array) -> Array:
    """Linear between stored instants; of two at the same time the later one."""
    k = np.clip(np.searchsorted(times, at, side="right") - 1, 0, len(times) - 2)
    step = times[k + 1] - times[k]
    share = np.where(step > 0.0, (at - times[k]) / np.where(step > 0.0, step, 1.0), 0.0)
    share = np.clip(share, 0.0, 1.0)[:, None]
    return np.asarray((1.0 - share) * values[k] + share * values[k + 1])


def _places(shapes: list[Outline], q: Array) -> Array:
    """All places of all bodies (m, p, 2)."""
    return np.concatenate([tracks(shape, q) for shape in shapes], axis=1)


def _rates(shapes: list[Outline], q: Array, u: Array) -> Array:
    return np.concatenate([speeds(shape, q, u) for shape in shapes], axis=1)


def _distance(a: Array, b: Array) -> Array:
    """Largest distance of places at each instant (m,)."""
    gap = a - b
    return np.asarray(np.hypot(gap[..., 0], gap[..., 1]).max(-1))


def _extent(places: Array) -> float:
    return float(np.ptp(places, axis=0).max())


@dataclass(frozen=True)
class Truth:
    """A reference with the time up to which another one agrees with it."""

    result: lf.Result
    other: lf.Result
    until: float
    size: float  # [m] extent of the largest body, or the largest travel of a place
    speed: float  # [m/s] the largest of a place


def truth_of(first: lf.Result, second: lf.Result, duration: float) -> Truth:
    """The first of two references, and how long it holds."""
    shapes = outlines(first)
    grid = np.linspace(0.0, duration, GRID + 1)
    q, p = (_interpolated(r.times, r.q, grid) for r in (first, second))
    places = _places(shapes, q)
    extent = max(max(_extent(tracks(s, q[:1])[0]), 2.0 * s.radius) for s in shapes)
    far = np.hypot(*np.moveaxis(places - places[0], -1, 0)).max(-1)
    apart = _distance(places, _places(shapes, p))
    known = apart <= AGREED * np.maximum(extent, np.maximum.accumulate(far))
    known &= grid <= min(first.times[-1], second.times[-1])
    last = len(grid) - 1 if known.all() else int(np.argmin(known)) - 1
    until = float(grid[max(last, 0)])
    held = grid <= until
    u = _interpolated(first.times, first.u, grid[held])
    rates = _rates(shapes, q[held], u)
    fastest = float(np.hypot(rates[..., 0], rates[..., 1]).max())
    return Truth(first, second, until, max(extent, float(far[held].max())), fastest)


def _nearest(mine: Array, theirs: list[Array]) -> Array:
    """Least distance (m,) of velocities (m, p, 2) from the way through others, straight from one to the next."""
    least = np.full(len(mine), np.inf)
    for first, second in pairwise(theirs):
        way = second - first
        length = np.sum(way * way, axis=(1, 2))
        share = np.sum((mine - first) * way, axis=(1, 2)) / np.where(length > 0.0, length, 1.0)
        least = np.minimum(least, _distance(mine, first + np.clip(share, 0.0, 1.0)[:, None, None] * way))
    return least


def _lasting(times: Array, errors: Array, window: Array) -> Array:
    """The least error within ``window`` after each instant: what passes sooner is an impact at another time."""
    last = np.searchsorted(times, times + window, side="right")
    return np.array([errors[k:end].min() for k, end in enumerate(last)])


def _speed_errors(truth: Truth, result: lf.Result, shapes: list[Outline], rows: Any, least: float) -> Array:
    """Differences of velocities (m,) from the nearer reference, 0 where these differ: both hold.

    An impact may be displaced by ``least`` [s], or by the time in which a place moves by ``OFF`` of the size.
    """
    t, q, u = result.times[rows], result.q[rows], result.u[rows]
    now = _rates(shapes, q, _interpolated(truth.result.times, truth.result.u, t))
    fast = np.hypot(now[..., 0], now[..., 1]).max(-1)
    window = np.clip(OFF * truth.size / np.maximum(fast, 1e-300), least, max(least, LONGEST))
    shifts = np.clip(t + window * np.linspace(-1.0, 1.0, SHIFTS)[:, None], 0.0, truth.until)
    one, other = (
        [_rates(shapes, q, _interpolated(r.times, r.u, at)) for at in shifts] for r in (truth.result, truth.other)
    )
    mine = _rates(shapes, q, u)
    sure = _nearest(now, other) <= 0.25 * OFF * truth.speed
    error = np.minimum(_nearest(mine, one), _nearest(mine, other))
    return _lasting(t, np.where(sure, error, 0.0), window)


def walls_of(drawn: Drawn) -> list[tuple[Any, ...]]:
    """The walls of a random scene as :func:`overlap.deepest` takes them."""
    found: list[tuple[Any, ...]] = []
    for wall in drawn.walls:
        if len(wall) == 1:
            found.append(("plane", (0.0, wall[0]), (0.0, 1.0)))
        elif len(wall) == 3:
            found.append(("disc", wall[:2], wall[2]))
        else:
            found.append(("ring", box_corners(wall)))
    return found


def pairs_of(drawn: Drawn) -> list[tuple[int, int]]:
    """Pairs of bodies that may touch."""
    count = len(drawn.shapes)
    hinged = [(k, k - 1) for k in range(count) if drawn.shapes[k].hold == "hinge"]
    return [(k, j) for k in range(count) for j in range(k) if (k, j) not in hinged]


def _said(result: lf.Result) -> str:
    return "; ".join((*(f"doubt: {text}" for text in doubts(result)), *result.warnings))


def judge_result(
    drawn: Drawn, result: lf.Result, truth: Truth, window: float = 0.0
) -> tuple[float, float, float, float, float]:
    """Errors of places and velocities, those stated, and depth beyond the reference's, over size or speed."""
    shapes = outlines(result)
    rows = np.flatnonzero(result.times <= truth.until)
    q = _interpolated(truth.result.times, truth.result.q, result.times[rows])
    off = float(_distance(_places(shapes, result.q[rows]), _places(shapes, q)).max()) / truth.size
    speed = max(truth.speed, 1e-300)
    off_speed = float(_speed_errors(truth, result, shapes, rows, window).max()) / speed
    walls, pairs = walls_of(drawn), pairs_of(drawn)
    known = np.flatnonzero(truth.result.times <= truth.until)
    depth = deepest(result, walls, pairs, rows).max() - max(0.0, deepest(truth.result, walls, pairs, known).max())
    stated = (result.place_error or 0.0) / truth.size
    return off, off_speed, stated, (result.speed_error or 0.0) / speed, float(depth) / truth.size


def reference_runs(drawn: Drawn) -> tuple[lf.Result, lf.Result] | str:
    """Both references, as far as they come; or why there are none."""
    found = []
    for stepper in references(drawn):
        try:
            scene = build(drawn, exact=True)
            options = {"record": drawn.duration / INSTANTS, "project": True, "progress": False}
            result = lf.simulate(scene, drawn.duration, stepper, **options)  # type: ignore[arg-type]
        except lf.StepError as error:
            result = error.result
        except lf.LcpflexError as error:
            return f"{type(error).__name__}: {error}"
        if len(result.times) < 2 or not np.isfinite(result.q).all():
            return "a reference came to nothing"
        found.append(result)
    return found[0], found[1]


def judge(drawn: Drawn) -> Verdict:
    """Run the scene, and two references, and tell what the result is worth."""
    began = time.perf_counter()

    def verdict(outcome: str, *numbers: float, said: str = "") -> Verdict:
        spent = time.perf_counter() - began
        names = ("truth", "off", "off_speed", "stated", "stated_speed", "depth")
        return Verdict(
            drawn.seed, outcome, repr(stepper_of(drawn)), **dict(zip(names, numbers, strict=False)),
            said=said[:400], seconds=spent,
        )  # fmt: skip

    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            result = lf.simulate(build(drawn), drawn.duration, stepper_of(drawn), project=True, progress=False)
        except lf.StepError as error:
            return verdict("stopped", said=str(error))
        except lf.LcpflexError as error:
            return verdict("refused", said=str(error))
        runs = reference_runs(drawn)
    if isinstance(runs, str):
        return verdict("no truth", said=runs)
    truth = truth_of(*runs, drawn.duration)
    if truth.until < LEAST:
        return verdict("no truth", truth.until)
    window = 2.0 * drawn.fineness if drawn.fixed else 0.0
    off, off_speed, stated, stated_speed, depth = judge_result(drawn, result, truth, window)
    said = _said(result) + "".join(f"; {w.message}" for w in caught if issubclass(w.category, lf.ModelWarning))
    wrong = off > OFF and off > TIMES * stated
    wrong |= off_speed > OFF and off_speed > TIMES * stated_speed
    wrong |= depth > OFF
    right = off <= OFF and off_speed <= OFF and depth <= OFF
    if wrong and not said:
        outcome = "silent"
    elif right:
        outcome = "warned" if said else "quiet"
    else:
        outcome = "loud" if said else "stated"
    return verdict(outcome, truth.until, off, off_speed, stated, stated_speed, depth, said=said)


def smaller(drawn: Drawn) -> Iterator[Drawn]:
    """The scene with one part less: what a failure is shrunk by, by hand."""
    for k in range(len(drawn.pushes)):
        yield replace(drawn, pushes=drawn.pushes[:k] + drawn.pushes[k + 1 :])
    for k in range(len(drawn.walls)):
        yield replace(drawn, walls=drawn.walls[:k] + drawn.walls[k + 1 :])
    last = len(drawn.shapes) - 1
    if last > 0 and all(push.body < last for push in drawn.pushes):
        yield replace(drawn, shapes=drawn.shapes[:last])
    for k, shape in enumerate(drawn.shapes):
        if shape.hold != "free":
            yield replace(drawn, shapes=(*drawn.shapes[:k], replace(shape, hold="free"), *drawn.shapes[k + 1 :]))
