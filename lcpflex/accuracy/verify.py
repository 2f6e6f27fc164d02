"""The error of a run, measured: E(t) is some times the largest difference to its reruns, at equal times.

With fixed steps of length h, E = 2 max(|x_h - x_h/4|, |x_h - x_other|). Of 168 runs in space and 95 in the plane E was
below the truth in 4 and 2 %; with h/2 in place of another method in 10 and 4 %, as nested steps take an impact at the
same late instant.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from lcpflex.accuracy.comparison import bodies_of, differences, sizes_of, window_of
from lcpflex.accuracy.modes import ModeError, mode_error
from lcpflex.accuracy.reruns import Finished, checking_runs, stored_interval, unsensed
from lcpflex.accuracy.sameness import origin_of, refuse_others
from lcpflex.basics.arguments import flag, optional_flag
from lcpflex.basics.progress import Progress
from lcpflex.errors import ModelError
from lcpflex.results.measured_error import PARTED, MeasuredError

if TYPE_CHECKING:
    from lcpflex.jit.kernel import FloatArray
    from lcpflex.results.result import Result

__all__ = ["is_cheap", "measured", "verify"]

CHEAP = 1e6  # steps x velocities x contacts, up to which "auto" verifies: some seconds with all reruns
FEW = 100  # instants, fewer of which may miss by how much runs are apart in between
LISTED = 8  # contacts whose touches are counted


def is_cheap(result: Result) -> bool:
    """Whether a run is so small that its reruns are, too, by counted work: the same on every machine."""
    contacts = max(1, int(result.size.max(initial=0)))
    return bool(float(result.steps) * max(1, result.u.shape[1]) * contacts <= CHEAP)


def verify(
    result: Result, scene: Any = None, stepper: Any = None, progress: bool | None = None, other: bool = True
) -> MeasuredError:
    """See :meth:`lcpflex.Result.verify`."""
    if len(result.times) < 2 or not (np.isfinite(result.q).all() and np.isfinite(result.u).all()):
        raise ModelError("verify: the result holds no motion of finite numbers; expected one that began, and went well")
    other, progress = flag("other", other), optional_flag("progress", progress)
    origin = origin_of(result, scene, stepper)
    with Progress(progress, lambda: "running it again, finer and by another method", what="verify", bar=False):
        refuse_others(result, origin)
        found = list(checking_runs(unsensed(origin), float(result.times[-1]), result.steps, other))
        modes = mode_error(result, origin, float(result.times[-1]), stored_interval(origin))
    reruns = [one for one in found if isinstance(one, Finished)]
    if not reruns:
        raise ModelError(f"verify: no rerun came to anything: {'; '.join(map(str, found))[:400]}")
    error = _with_modes(measured(result, reruns, tuple(one for one in found if isinstance(one, str))), modes)
    object.__setattr__(result, "error", error)  # the one field that comes later: a result is a value else
    return error


def _with_modes(error: MeasuredError, found: ModeError | None) -> MeasuredError:
    """The error, with what twice as many modes change."""
    if found is None:
        return error
    runs = error.reruns if found.rerun is None else (*error.reruns, found.rerun)
    until = np.inf
    if found.times is not None and found.curve is not None:
        horizon, whole = _horizon(found.times, found.curve[:, None], error.extent, float(found.times[-1]))
        until = np.inf if whole else horizon
    return replace(error, modes=found.off, modes_horizon=until, modes_note=found.note, reruns=runs)


def measured(result: Result, reruns: Sequence[Finished], notes: tuple[str, ...] = ()) -> MeasuredError:
    """The error of a result by these reruns."""
    bodies = bodies_of(result)
    window = window_of(result, [one.result for one in reruns])
    apart = [differences(result, one.result, bodies, window) for one in reruns]
    factors = [one.told.factor for one in reruns]
    extent, fastest = sizes_of(result, bodies)
    first = min(apart, key=lambda one: len(one.times))
    rows = len(first.times)
    times = first.times
    place = _largest([one.place[:rows] for one in apart], factors)
    turn = _largest([one.turn[:rows] for one in apart], factors)
    speed = _largest([one.speed[:rows] for one in apart], factors)
    horizon, whole = _horizon(times, place + turn, extent, float(result.times[-1]))
    rms = _largest([one.rms for one in apart], factors)
    none = np.zeros(rows)
    return MeasuredError(
        times=times,
        place_curve=np.maximum.accumulate(place, axis=0),
        turn_curve=np.maximum.accumulate(turn, axis=0),
        speed_curve=np.maximum.accumulate(speed, axis=0),
        speed_rms=float(rms.max(initial=0.0)),
        extent=extent,
        fastest=fastest,
        horizon=horizon,
        whole=whole,
        parted="" if whole else _parting(result, horizon),
        bodies=bodies.names,
        gap_curve={
            name: np.maximum.accumulate(_largest([one.gap.get(name, none)[:rows] for one in apart], factors))
            for name in result.contact_names
        },
        force=_by_contact([one.force for one in apart], factors),
        impulse=_by_contact([one.impulse for one in apart], factors),
        touches=_touches(result, [result, *(one.result for one in reruns)]),
        reruns=tuple(one.told for one in reruns),
        notes=(*notes, *_few(times)),
    )


def _few(times: FloatArray) -> tuple[str, ...]:
    """That the runs were compared at few instants, and what is between is not known."""
    if len(times) >= FEW:
        return ()
    return (f"the runs were compared at the {len(times)} instants that are stored: a smaller record shows more",)


def _by_contact(apart: Sequence[dict[str, float]], factors: Sequence[float]) -> dict[str, float]:
    """The largest of the differences of each contact, each times its factor."""
    names = dict.fromkeys(name for one in apart for name in one)
    return {name: max(f * one.get(name, 0.0) for f, one in zip(factors, apart, strict=True)) for name in names}


def _largest(curves: Sequence[FloatArray], factors: Sequence[float]) -> FloatArray:
    """The largest of the differences, each times its factor; where none is known, 0."""
    found = np.zeros_like(curves[0])
    for curve, factor in zip(curves, factors, strict=True):
        found = np.fmax(found, factor * curve)
    return found


def _horizon(times: FloatArray, off: FloatArray, extent: float, end: float) -> tuple[float, bool]:
    """Time up to which no body is off by ``PARTED`` of the extent, and whether that is the end."""
    passed = np.flatnonzero(off.max(axis=1, initial=0.0) > PARTED * extent)
    if len(passed):
        return float(times[max(int(passed[0]) - 1, 0)]), False
    return float(times[-1]), bool(times[-1] >= end * (1.0 - 1e-9))


def _busiest(result: Result) -> list[str]:
    """Names of the contacts with most impulse that touched."""
    taken = result.impulse[-1, :, 0]
    order = np.argsort(-taken, kind="stable")[:LISTED]
    return [result.contact_names[k] for k in order if taken[k] > 0.0]


def _touches(result: Result, runs: Sequence[Result]) -> tuple[tuple[str, tuple[int, ...]], ...]:
    """How often the busiest contacts touched in each run."""
    return tuple(
        (name, tuple(len(run.contact(name).windows()) if name in run.contact_names else 0 for run in runs))
        for name in _busiest(result)
    )


def _parting(result: Result, horizon: float) -> str:
    """From which touch on the runs part, in words."""
    began = [
        (window.begin, number, name)
        for name in _busiest(result)
        for number, window in enumerate(result.contact(name).windows(), 1)
        if window.begin <= horizon and not window.from_start
    ]
    if not began:
        return "the runs part"
    _, number, name = max(began)
    return f"from touch {number} of {name!r} on the runs part"
