"""Gaps that jump: by more than the bodies could move. No step is short enough for them, and no verdict sees them.

An outline whose parts disagree where they meet, a feature that stands in for another one far away, a user's function
with a step: the distance of two bodies is then no continuous function of their configuration. Looked at are the last
instants of a run that failed and the way that its last velocity leads, and stored instants between which bodies have
sunk into each other farther than they moved. What is found is followed by bisection: of a continuous gap, however
bent, nothing is left.
"""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple, Protocol

import numpy as np

from lcpflex.basics.alarm import Alarm
from lcpflex.checks.grown import BOUND, gone_too_far, largest_gap
from lcpflex.checks.measured_gaps import GapsOfFunctions, GapsOfScene
from lcpflex.errors import LcpflexError

if TYPE_CHECKING:
    from collections.abc import Hashable

    from lcpflex.checks.measured_gaps import MeasuredGaps
    from lcpflex.compile.compiled_scene import CompiledScene
    from lcpflex.jit.kernel import FloatArray
    from lcpflex.results.result import Result
    from lcpflex.scene.user_system import UserSystem
    from lcpflex.steppers.system import System

__all__ = ["jumped_gap", "sunk_by_jumps"]

HALVINGS = 30  # of the way on which a gap changed by too much
DEEP = 0.01  # of the size of the scene: bodies so deep in each other have gone wrong before
OFF = 1.01  # times the way of the bodies: more is a jump
MOST = 3  # contacts that are followed
SHORTER = 4.0  # from one look ahead to the next, under error control
LOOKS = 10
UNKNOWN = 1e-3  # of the duration, where nothing tells how long steps were


class Advanced(Protocol):
    """A run that has come to where it cannot go on."""

    @property
    def time(self) -> float: ...
    @property
    def motion(self) -> tuple[FloatArray, FloatArray]: ...


class Ahead(NamedTuple):
    """Where a run stands, and how far its next step may lead."""

    time: float  # [s]
    q: FloatArray
    u: FloatArray
    step: float  # [s]
    fixed: bool  # else it may be any part of that

    def times(self) -> list[float]:
        """After which to look [s]: positions are also predicted half a step ahead."""
        if self.fixed:
            return [0.5 * self.step, self.step]
        return [self.step / SHORTER**k for k in range(LOOKS, -1, -1)]


class Jump(NamedTuple):
    """A gap that jumps."""

    name: str
    time: float  # [s]
    before: float  # [m]
    after: float
    moved: float  # by the bodies, at most
    span: float  # in so much time [s]

    def words(self, beyond: float) -> str:
        """In a clause."""
        before, after = (f"more than {gap:.3g} m" if gap >= beyond else f"{gap:.3g} m" for gap in self[2:4])
        return (
            f"the gap of {self.name} jumps from {before} to {after} at t = {self.time:.6g} s, where {self.span:.2g} s "
            f"of motion change it by {self.moved:.2g} m at most: an outline, or the function of a gap, that is not "
            "continuous"
        )

    def alarm(self, beyond: float) -> Alarm:
        """Of a run that has passed it."""
        advice = "close the outline, or make the function continuous"
        return Alarm(self.words(beyond), "gap", self.name, self.time, self.after - self.before, advice)


Way = list[tuple[float, "FloatArray"]]  # times and configurations


def jumped_gap(result: Result, run: Advanced, system: System, source: CompiledScene | UserSystem) -> str:
    """Words on the gap that jumped where a run of ``system`` could not go on; empty where none did.

    source: what the system is made of.
    """
    ahead, measured = _ahead(result, run), _measured(result, system, source)
    if measured is None:
        return ""
    stored = zip(result.times[-3:].tolist(), result.q[-3:].copy(), strict=True)
    way = [*((t, q) for t, q in stored if t < ahead.time), (ahead.time, ahead.q)]
    try:
        way += [(ahead.time + h, measured.moved(ahead.q, ahead.u, h)) for h in ahead.times()]
        jump = _on(way, measured) or next(iter(_between(result, gone_too_far(result, system.model), measured)), None)
    except (LcpflexError, ArithmeticError):  # what functions of the user make of such places is told by the run
        return ""
    return f". T{jump.words(measured.beyond())[1:]}" if jump else ""


def sunk_by_jumps(
    result: Result, rows: list[tuple[int, bool]], system: System, source: CompiledScene | UserSystem
) -> tuple[Alarm, ...]:
    """An alarm for each contact whose bodies have sunk into each other by more than they moved, or were put apart.

    rows: where, as :func:`lcpflex.checks.grown.gone_too_far` tells.
    """
    measured = _measured(result, system, source)
    if measured is None:
        return ()
    try:
        return tuple(jump.alarm(measured.beyond()) for jump in _between(result, rows, measured))
    except (LcpflexError, ArithmeticError):
        return ()


def _ahead(result: Result, run: Advanced) -> Ahead:
    """Under error control the next step may be as long as the last ones between stored instants."""
    q, u = run.motion
    span = float(np.diff(result.times[-2:]).sum()) or UNKNOWN * result.duration
    fixed = float(getattr(run, "fixed_step", 0.0))
    return Ahead(run.time, q, u, fixed or span, fixed > 0.0)


def _measured(result: Result, system: System, source: CompiledScene | UserSystem) -> MeasuredGaps | None:
    """The gaps of a run; None where it has none, or ended too far off for any to be measured."""
    if not system.n_laws:
        return None
    if not len(result.times) or not np.abs(result.q[-1]).max(initial=0.0) < BOUND:
        return None
    if result.compiled is not None:
        return GapsOfScene(result.compiled)
    functions = source._functions  # type: ignore[union-attr]
    place = float(np.abs(result.q[np.isfinite(result.q)]).max(initial=0.0))
    return GapsOfFunctions(functions, largest_gap(result), place, system.contact_name)


def _between(result: Result, rows: list[tuple[int, bool]], measured: MeasuredGaps) -> list[Jump]:
    """Jumps between stored instants and those before them, each contact once."""
    found: dict[str, Jump] = {}
    for k, kept in rows:
        before, after = result.q[k - 1].copy(), result.q[k].copy()
        t, h = float(result.times[k - 1]), float(result.times[k] - result.times[k - 1])
        ahead = Ahead(t, before, result.u[k - 1], h, True)
        free = [(t + part, measured.moved(before, ahead.u, part)) for part in ahead.times()]
        for way in ([(t, before), (t + h, after)], [(t, before), *free]):
            jump = _on(way, measured)
            if jump and (kept or jump.after < 0.0):
                found.setdefault(jump.name, jump)
    return list(found.values())


def _on(way: Way, measured: MeasuredGaps) -> Jump | None:
    """The first jump on a way through configurations."""
    for (ta, a), (tb, b) in pairwise(way):
        if not (np.abs(b).max(initial=0.0) < BOUND):
            break
        before, after = measured.at(a), measured.at(b)
        far = measured.beyond()
        off = {
            key: _excess(measured, key, before.get(key, far), after.get(key, far), a, b) for key in {**before, **after}
        }
        for key in sorted((key for key in off if off[key] > 0.0), key=lambda key: -off[key])[:MOST]:
            jump = _followed(measured, key, (ta, a), (tb, b))
            if jump:
                return jump
    return None


def _excess(measured: MeasuredGaps, key: Hashable, before: float, after: float, a: FloatArray, b: FloatArray) -> float:
    """By how much more a gap has changed than it may have; of bodies that come out of deep inside each other, nothing.

    They have been wrong before: what is the nearest way out then changes with the feature that tells it.
    """
    if before < min(after, -DEEP * measured.size):
        return 0.0
    return abs(after - before) - OFF * measured.bound(key, a, b) - measured.noise


def _followed(
    measured: MeasuredGaps, key: Hashable, start: tuple[float, FloatArray], end: tuple[float, FloatArray]
) -> Jump | None:
    """The jump of one gap between two configurations; None where it fades on the way between them."""
    (ta, a), (tb, b) = start, end
    velocity = measured.change(a, b)

    def gap(share: float) -> float:
        return measured.at(measured.moved(a, velocity, share)).get(key, measured.beyond())

    low, high = 0.0, 1.0
    before, after = gap(low), gap(high)
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        between = gap(middle)
        if abs(between - before) > abs(after - between):
            high, after = middle, between
        else:
            low, before = middle, between
    ends = measured.moved(a, velocity, low), measured.moved(a, velocity, high)
    if not _excess(measured, key, before, after, *ends) > 0.0:
        return None
    return Jump(measured.name(key), ta + high * (tb - ta), before, after, measured.bound(key, a, b), tb - ta)
