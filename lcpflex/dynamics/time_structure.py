"""What is known of the functions of time of a scene before it runs: where they bend, and how fast they go.

A piecewise linear force and a spline's piecewise linear acceleration are described by those of their knots that a
straight line would miss; a Python function by what :mod:`lcpflex.dynamics.time_probe` finds.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, cast

import numpy as np

from lcpflex.dynamics.compiled_function import CompiledFunction
from lcpflex.dynamics.time_functions import HARMONIC, PIECES, Callback, ForceCallback, MotionCallback, State
from lcpflex.dynamics.time_probe import INTERVALS, probed
from lcpflex.jit.kernel import FloatArray
from lcpflex.model.arrays import Model, Signals, frozen
from lcpflex.model.layout import is_spatial
from lcpflex.model.spatial import SpatialModel
from lcpflex.scene.functions_of_time import Function

__all__ = ["LEAST_LOOKS", "bends", "for_system", "probe_of", "probed", "with_instants", "with_signals"]

BENT = 1e-3  # of the distance from the median: a straight line may be off by this before it counts as bent
NO_BEND = 1e-9  # and of the whole range
BENT_PROBED, NO_BEND_PROBED = 0.05, 2e-3  # the same for a Python function
BENT_MOTION = 0.01  # and for a motion, of which accelerations matter
PER_PERIOD = 4.0  # steps that a harmonic takes at least
PER_SHORTEST = 2.0  # steps in the shortest thing that a function does
LEAST_LOOKS = 100  # steps over the duration where a function depends on more than the time
BESIDE = 1e-10  # of the duration: a step ends as much before a break as the next but one begins behind it
NEAR_BENDS = (
    2.0 / INTERVALS
)  # of the duration: a step ends at bends so near to each other, and never passes over others


def bends(times: FloatArray, values: FloatArray, bent: float = BENT, floor: float = NO_BEND) -> FloatArray:
    """The instants between which straight lines come near to all values, ends included; none for a constant.

    Near: within ``bent`` of a value's distance from the median, so that what oscillates about a large mean is seen, and
    within ``floor`` of the whole range.
    """
    span = float(np.ptp(values))
    if span == 0.0 or len(times) < 2:
        return np.zeros(0)
    allowed = np.maximum(bent * np.abs(values - np.median(values)), floor * span)
    t, f, e = times.tolist(), values.tolist(), allowed.tolist()
    kept, low, high, anchor = [0], -math.inf, math.inf, 0
    for k in range(1, len(t)):
        length = t[k] - t[anchor]
        slope = (f[k] - f[anchor]) / length
        if not low <= slope <= high:
            anchor = k - 1
            kept.append(anchor)
            low, high = -math.inf, math.inf
            length = t[k] - t[anchor]
            slope = (f[k] - f[anchor]) / length
        low, high = max(low, slope - e[k] / length), min(high, slope + e[k] / length)
    kept.append(len(t) - 1)
    return times[kept]


def with_signals(model: Model, **changes: Any) -> Model:
    """``model``, packed or not, with other arrays among its functions of time."""
    signals = Signals(*(changes.get(name, getattr(model.signals, name)) for name in Signals._fields))
    parts = {name: getattr(model, name) for name in Model._fields}
    kind: Any = SpatialModel if is_spatial(model) else Model
    return cast(Model, kind(**(parts | {"signals": signals})))


def with_instants(
    model: Model, callbacks: Sequence[Callback | CompiledFunction], start: State, duration: float
) -> Model:
    """``model`` with the instants at which steps with error control end, and with their greatest length."""
    stops, longest = _built_in(model)
    for callback in callbacks:
        more, length = _of_function(callback, start, duration)
        stops.append(more)
        longest = min(longest, length)
    instants = np.unique(np.concatenate([np.zeros(0), *stops]))
    instants = instants[(instants > 0.0) & (instants < duration)]
    limit = frozen([longest] if longest < math.inf else [])
    return with_signals(model, stops=frozen(instants), longest=limit)


def _built_in(model: Model) -> tuple[list[FloatArray], float]:
    """Knots of tables, and the longest step for harmonics."""
    signals = model.signals
    drives = set(model.joints.signal.tolist())
    stops, longest = [], math.inf
    for k, kind in enumerate(signals.kind.tolist()):
        first, last = int(signals.first[k]), int(signals.last[k])
        if kind == PIECES:
            knots, pieces = signals.breaks[first:last], signals.coefficients[first:last]
            stops.append(bends(knots, pieces[:, 3]) if k not in drives else _bends_of_motion(knots, pieces))
        elif kind == HARMONIC:
            _, amplitude, omega, _ = signals.coefficients[first]
            if amplitude != 0.0 and omega != 0.0:
                longest = min(longest, 2.0 * math.pi / (PER_PERIOD * abs(float(omega))))
    return stops, longest


def _bends_of_motion(knots: FloatArray, pieces: FloatArray) -> FloatArray:
    """Where the acceleration of a spline bends, and where it begins and ends to move."""
    if not pieces[:-1, :3].any():
        return np.zeros(0)
    accelerations = 2.0 * pieces[:, 1]
    accelerations[-1] = 6.0 * pieces[-2, 0] * (knots[-1] - knots[-2]) + 2.0 * pieces[-2, 1]
    return np.unique([knots[0], knots[-1], *bends(knots, accelerations)])


def _of_function(callback: Callback | CompiledFunction, start: State, duration: float) -> tuple[FloatArray, float]:
    """Stops of a Python function, and the longest step."""
    function = callback.function
    told = function if isinstance(function, Function) else None
    breaks = np.asarray(told.breaks) if told else np.zeros(0)
    stops = [breaks - BESIDE * duration, breaks + BESIDE * duration]
    longest = math.inf
    by_state = isinstance(callback, ForceCallback) and callback.with_state
    if by_state:
        longest = duration / LEAST_LOOKS
    if told and told.shortest is not None:
        return np.concatenate(stops), told.shortest / PER_SHORTEST

    times, values = probe_of(callback, start, duration)
    more, slowest = _steps_for(times, values, BENT_MOTION if _is_motion(callback) else BENT_PROBED, duration)
    return np.concatenate([*stops, more]), min(longest, slowest)


def for_system(model: Model, function: Callable[[float], Any], duration: float) -> Model:
    """``model`` of a user's own system, whose forces at the start are ``function``, with stops and greatest step."""
    times, values = probed(function, duration, closely=False)
    if not len(times) or not np.ptp(values, axis=0).any():
        return model  # the time does not matter
    stops, longest = _steps_for(times, values, BENT_PROBED, duration)
    stops = stops[(stops > 0.0) & (stops < duration)]
    return with_signals(model, stops=frozen(stops), longest=frozen([min(longest, duration / LEAST_LOOKS)]))


def _steps_for(times: FloatArray, values: FloatArray, bent: float, duration: float) -> tuple[FloatArray, float]:
    """Of the bends of a probe: those to stop at, near to each other, and the longest step over the others."""
    stops, longest = [np.zeros(0)], math.inf
    for column in values.T:
        knots = bends(times, column, bent, NO_BEND_PROBED)
        apart = np.diff(knots)
        near = apart < NEAR_BENDS * duration
        beside = np.concatenate([near, [False]]) | np.concatenate([[False], near])
        stops.append(knots[beside[: len(knots)]])
        # the last piece ends with the duration, not where it bends
        longest = min(longest, float(apart[:-1][~near[:-1]].min(initial=math.inf)))
    return np.unique(np.concatenate(stops)), longest


def probe_of(callback: Callback | CompiledFunction, start: State, duration: float) -> tuple[FloatArray, FloatArray]:
    """Instants (k,) and values (k, components) of a Python function, by :func:`probed`; at ``start`` if by state."""
    function = callback.function
    by_state = isinstance(callback, ForceCallback) and callback.with_state

    def asked(t: float) -> Any:
        return function(t, replace(start, time=t)) if by_state else function(t)

    times, values = probed(asked, duration, closely=not by_state)
    return times, values[:, :1] if _is_motion(callback) else values


def _is_motion(callback: Callback | CompiledFunction) -> bool:
    return callback.motion if isinstance(callback, CompiledFunction) else isinstance(callback, MotionCallback)
