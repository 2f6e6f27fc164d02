"""Functions of time: pieces, harmonics, and Python functions with or without their derivatives."""

import math

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.dynamics.time_functions import MotionCallback, SignalTable
from lcpflex.kinematics.signal_values import signal_value

NOTHING = np.zeros((0, 3))


def value_of(function, t, motion=True):
    table = SignalTable()
    index = table.motion("m", function) if motion else table.force("f", function)
    signals, callbacks = table.compile()
    external = np.zeros((table.n_external, 3))
    for callback in callbacks:
        callback.fill(t, None, external)
    return signal_value(signals, index, t, external)


def test_constant_and_harmonic():
    assert value_of(2.5, 7.0) == (2.5, 0.0, 0.0)
    expected = (0.5 + 2 * math.sin(3.4), 6 * math.cos(3.4), -18 * math.sin(3.4))
    assert value_of(lf.Harmonic(2.0, 3.0, phase=0.4, mean=0.5), 1.0) == pytest.approx(expected, rel=1e-14)


@pytest.mark.parametrize("t", np.linspace(0.05, 1.95, 9))
def test_a_cubic_is_its_own_spline_and_a_force_is_piecewise_linear(t):
    times = np.array([0.0, 0.3, 0.9, 1.4, 2.0])
    table = lf.Table(times, times**3 - times)
    assert value_of(table, t) == pytest.approx((t**3 - t, 3 * t**2 - 1, 6 * t), abs=1e-12)
    assert value_of(table, t, motion=False)[0] == pytest.approx(np.interp(t, times, times**3 - times), abs=1e-14)


@pytest.mark.parametrize("motion", [False, True])
def test_tables_are_constant_outside(motion):
    table = lf.Table([1.0, 2.0, 3.0], [4.0, 5.0, 7.0])
    assert value_of(table, 0.0, motion) == (4.0, 0.0, 0.0)
    assert value_of(table, 3.5, motion) == (7.0, 0.0, 0.0)
    assert value_of(table, 3.0, motion)[0] == pytest.approx(7.0, rel=1e-15)


def test_a_tabulated_motion_is_twice_continuously_differentiable():
    table = lf.Table(np.linspace(0, 1, 9), np.sin(7 * np.linspace(0, 1, 9)))
    for t in np.linspace(0, 1, 9)[1:-1]:
        before, after = value_of(table, t - 1e-9), value_of(table, t + 1e-9)
        np.testing.assert_allclose(before, after, atol=1e-5)


@pytest.mark.parametrize("omega", [1.0, 10.0, 100.0, 1000.0])
def test_differences_of_a_python_motion(omega):
    t = 0.37
    f, rate, acceleration = value_of(lambda t: math.sin(omega * t), t)
    assert f == math.sin(omega * t)
    assert rate == pytest.approx(omega * math.cos(omega * t), abs=1e-4 * omega)
    assert acceleration == pytest.approx(-(omega**2) * math.sin(omega * t), abs=max(1e-6, 1e-4 * omega**2))


def test_a_python_motion_with_its_derivatives_is_called_once():
    calls = []

    def motion(t):
        calls.append(t)
        return t**2, 2 * t, 2.0

    assert value_of(motion, 3.0) == (9.0, 6.0, 2.0)
    assert calls == [3.0]


@pytest.mark.parametrize("returned", [math.nan, None, (1.0, 2.0), "x"])
def test_a_bad_motion_names_itself(returned):
    with pytest.raises(lf.ModelError, match=r"drive: .*at t = 2 s, expected a finite number or three"):
        MotionCallback("drive", lambda t: returned, 0).fill(2.0, None, np.zeros((1, 3)))


def test_functions_with_an_optional_second_argument_are_called_with_the_time_only():
    assert value_of(lambda t, k=3.0: k * t, 2.0, motion=False)[0] == 6.0
    assert value_of(np.sin, 0.5, motion=False)[0] == math.sin(0.5)
