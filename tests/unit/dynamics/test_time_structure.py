"""Instants at which functions of time bend, and means of loads over steps."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.dynamics.instants import at_stop, time_left
from lcpflex.dynamics.load_means import force_value
from lcpflex.dynamics.time_functions import SignalTable, State
from lcpflex.dynamics.time_structure import bends, probed, with_instants
from lcpflex.model.arrays import Signals

NOTHING = np.zeros((0, 3))


def signals_of(*functions: Any) -> Signals:
    table = SignalTable()
    for function in functions:
        table.force("f", function)
    return table.compile()[0]


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e9])
@pytest.mark.parametrize("unit", [1e-3, 1.0])
def test_bends_are_the_knots_that_a_straight_line_would_miss(scale: float, unit: float) -> None:
    times = unit * np.array([0.0, 0.1, 0.2, 0.5, 0.6, 0.7, 0.71, 0.72, 3.0])
    values = scale * np.array([1.0, 1.0, 1.0, 1.0, 2.0, 3.0, 1.0, 1.0, 1.0])
    np.testing.assert_allclose(bends(times, values) / unit, [0.0, 0.5, 0.7, 0.71, 3.0])
    assert bends(times, np.full(9, scale)).size == 0


def test_a_small_pulse_on_a_large_constant_is_a_bend() -> None:
    times = np.arange(101.0)
    values = np.full(101, 9810.0)
    values[40] += 0.1
    np.testing.assert_array_equal(bends(times, values), [0.0, 39.0, 40.0, 41.0, 100.0])


def test_a_dense_smooth_table_has_far_fewer_bends_than_knots() -> None:
    times = np.linspace(0.0, 1.0, 20_001)
    values = np.sin(2.0 * math.pi * times)
    knots = bends(times, values)
    assert 30 < len(knots) < 400
    middle = np.interp(times, knots, np.interp(knots, times, values))
    assert np.abs(middle - values).max() < 2e-3


@pytest.mark.parametrize("duration", [1e-3, 1.5, 1e4])
@pytest.mark.parametrize("share", [0.0031, 0.02, 0.3])
def test_a_probe_finds_jumps_to_a_millionth(duration: float, share: float) -> None:
    begin, end = 0.37 * duration, (0.37 + share) * duration

    def function(t: float) -> float:
        return 5.0 if begin <= t < end else -1.0

    times, values = probed(function, duration)
    knots = bends(times, values[:, 0])
    for edge in (begin, end):
        assert np.abs(knots - edge).min() < 2e-6 * duration
    assert len(times) < 2_000


def test_a_probe_leaves_what_is_no_number_to_the_run() -> None:
    def function(t: float) -> float:
        if t > 0.5:
            raise ValueError("not known there")
        return math.nan if t > 0.4 else t

    times, values = probed(function, 1.0)
    assert times.max() <= 0.4
    assert values.shape == (len(times), 1)
    assert probed(lambda t: "x", 1.0)[0].size == 0


def scene_with(load: Any, duration: float = 2.0) -> Signals:
    scene = lf.Scene()
    disc = scene.add(lf.Disc(0.1, mass=1.0))
    scene.load(lf.Force(disc.point("center"), (load, 0.0)))
    compiled = scene.compiled()
    start = State(0.0, compiled.q, compiled.u, compiled.model.bodies.dof)
    return with_instants(compiled.model, (*compiled.callbacks, *compiled.functions), start, duration).signals


def test_stops_and_longest_steps() -> None:
    assert scene_with(3.0).stops.size == 0
    assert scene_with(3.0).longest.size == 0
    assert scene_with(lf.Harmonic(0.0, 1e3, mean=2.0)).longest.size == 0
    np.testing.assert_allclose(scene_with(lf.Harmonic(1.0, -40.0)).longest, [2.0 * math.pi / 160.0])
    np.testing.assert_array_equal(scene_with(lf.Table([0, 0.5, 0.7, 9.0], [0, 0, 1, 1])).stops, [0.5, 0.7])
    told = scene_with(lf.Function(lambda t: 1.0, breaks=[1.5, 0.5], shortest=0.02))
    np.testing.assert_allclose(told.stops, [0.5, 0.5, 1.5, 1.5], atol=1e-9)
    np.testing.assert_allclose(told.longest, [0.01])
    np.testing.assert_allclose(scene_with(lambda t, state: state.q[0]).longest, [0.02])
    assert scene_with(lambda t: 3.0).longest.size == 0


@pytest.mark.parametrize("lost", ["function", "breaks", "shortest"])
def test_functions_refuse_what_cannot_be(lost: str) -> None:
    wrong = {"function": 3.0, "breaks": [math.nan], "shortest": 0.0}
    with pytest.raises(lf.ModelError, match=f"Function: {lost}"):
        lf.Function(**({"function": math.sin} | {lost: wrong[lost]}))


@pytest.mark.parametrize("plain", [True, False])
def test_the_time_to_the_next_stop(plain: bool) -> None:
    left, there = (time_left.py_func, at_stop.py_func) if plain else (time_left, at_stop)  # type: ignore[attr-defined]
    signals = signals_of(1.0)._replace(stops=np.array([0.25, 0.5, 0.75]))
    assert left(signals, 0.0, 1.0) == 0.25
    assert left(signals, 0.25, 1.0) == 0.25
    assert left(signals, 0.25 - 1e-16, 1.0) == pytest.approx(0.25)  # rounding: it has been there
    assert left(signals, 0.6, 0.7) == pytest.approx(0.1)
    assert left(signals, 0.75, 1.0) == 0.25
    assert left(signals_of(1.0), 0.3, 1.0) == 0.7
    assert there(signals, 0.5 + 1e-16, 1.0)
    assert not there(signals, 0.4, 1.0)
    assert not there(signals_of(1.0), 0.5, 1.0)


@pytest.mark.parametrize("plain", [True, False])
@pytest.mark.parametrize("theta", [0.5, 0.8, 1.0])
def test_means_are_integrals(plain: bool, theta: float) -> None:
    """Of tables and harmonics over steps that hold none, one or many of their bends or periods."""
    mean = force_value.py_func if plain else force_value  # type: ignore[attr-defined]
    knots, values = np.array([0.1, 0.2, 0.25, 0.6, 0.61, 0.9]), np.array([2.0, -1.0, 4.0, 4.0, 0.0, 3.0])
    table, harmonic = lf.Table(knots, values), lf.Harmonic(3.0, 47.0, 0.3, mean=-1.0)
    signals = signals_of(table, harmonic)
    for begin, step in ((-0.5, 0.2), (0.0, 0.15), (0.05, 1.5), (0.12, 0.01), (0.19, 0.5), (0.3, 0.05), (0.95, 0.3)):
        t = np.linspace(begin, begin + step, 400_001)
        span = np.array([theta * step, (1.0 - theta) * step])
        at = begin + theta * step
        fine = np.trapezoid(np.interp(t, knots, values), t) / step
        bent = ((knots > begin) & (knots < begin + step)).any()
        expected = fine if bent else np.interp(at, knots, values)
        assert mean(signals, 0, at, span, NOTHING) == pytest.approx(expected, abs=2e-5)
        swing = np.trapezoid(3.0 * np.sin(47.0 * t + 0.3) - 1.0, t) / step
        expected = swing if 47.0 * step > 0.3 else 3.0 * math.sin(47.0 * at + 0.3) - 1.0
        assert mean(signals, 1, at, span, NOTHING) == pytest.approx(expected, abs=1e-7)
        still = mean(signals, 1, at, np.zeros(2), NOTHING)
        assert still == pytest.approx(3.0 * math.sin(47.0 * at + 0.3) - 1.0, rel=1e-12)
