"""Functions of time that numba has compiled: called by address, the loop stays compiled."""

from __future__ import annotations

import math
import re
import time
from typing import Any

import numba
import numpy as np
import pytest

import lcpflex as lf

STEPPER = lf.MoreauJean(step=1e-3)


@numba.njit
def rising(t):
    return 3.0 * t


@numba.njit
def pair(t):
    return 2.0 * t, -1


@numba.njit
def array(t):
    return np.array([2.0 * t, -1.0])


@numba.njit
def cubed(t):
    return t**3


@numba.njit
def cubed_with_rates(t):
    return t**3, 3.0 * t**2, 6.0 * t


@numba.cfunc("float64(float64)")
def callback(t):
    return 3.0 * t


def pushed(value: Any, torque: Any = 0.0) -> lf.Scene:
    scene = lf.Scene(gravity=(0.0, 0.0))
    disc = scene.add(lf.Disc(0.1, mass=2.0), name="disc")
    scene.load(lf.Force(disc.point("center"), value))
    scene.load(lf.Torque(disc.point("center"), torque))
    return scene


def turned(motion: Any) -> lf.Scene:
    scene = lf.Scene(gravity=(0.0, 0.0))
    disc = scene.add(lf.Disc(0.1, mass=2.0), name="disc")
    scene.join(lf.DrivenAngle(disc.point("center"), scene.ground.at(0.0, 0.0), motion, name="drive"))
    return scene


@pytest.mark.parametrize(
    ("value", "speed"),
    [
        ((rising, callback), (0.75, 0.75)),
        ((lf.Function(rising, breaks=[0.3]), 0.0), (0.75, 0.0)),
        (pair, (0.5, -0.5)),
        (array, (0.5, -0.5)),
    ],
    ids=["components", "told", "tuple", "array"],
)
def test_forces(value: Any, speed: tuple[float, float]) -> None:
    scene = pushed(value, torque=rising)
    assert not scene.compiled().callbacks
    assert not scene.compiled().system().hooks
    result = lf.simulate(scene, 1.0, STEPPER)
    np.testing.assert_allclose(result.u[-1, :2], speed, rtol=1e-12)
    assert result.u[-1, 2] == pytest.approx(1.5 / 0.01, rel=1e-12)
    assert result.python_calls == 0
    assert not result.warnings


@pytest.mark.parametrize("motion", [cubed, cubed_with_rates, lf.Function(cubed)], ids=["value", "rates", "told"])
def test_motions_and_what_they_say_of_themselves(motion: Any) -> None:
    result = lf.simulate(turned(motion), 1.0, STEPPER)
    np.testing.assert_allclose(result.q[:, 2], result.times**3, atol=1e-9)
    assert result.u[-1, 2] == pytest.approx(3.0, rel=1e-5)
    python = lf.simulate(turned(lambda t: motion(t)), 1.0, STEPPER)
    np.testing.assert_allclose(result.q, python.q, atol=1e-12)
    assert python.python_calls > 1000
    assert result.python_calls == 0


@numba.njit
def raises(t):
    if t > 0.3:
        raise ValueError("so far and no farther")
    return 1.0


@numba.njit
def vanishes(t):
    return 1.0 if t < 0.3 else math.nan


@pytest.mark.parametrize(
    ("function", "words"),
    [(raises, "the function raised ValueError at t = 0.3005 s"), (vanishes, "the function returned nan at t = 0.3")],
)
def test_what_goes_wrong_ends_the_run_in_words(function: Any, words: str) -> None:
    with pytest.raises(lf.StepError, match=re.escape(words)) as caught:
        lf.simulate(pushed((function, 0.0)), 1.0, STEPPER)
    assert "force at disc.center, x" in str(caught.value)
    assert caught.value.result.times[-1] == pytest.approx(0.3, abs=2e-3)


def test_what_returns_something_else_is_refused_before_time_is_spent() -> None:
    with pytest.raises(lf.ModelError, match="expected 2 finite numbers"):
        pushed(rising).compiled()
    with pytest.raises(lf.ModelError, match="expected a finite number or three"):
        turned(pair).compiled()


def test_python_functions_are_counted_and_told_of() -> None:
    slow = lf.simulate(pushed((lambda t: 3.0 * t, 0.0)), 0.1, STEPPER)
    said = slow.summary()
    assert f"Python functions of time: {slow.python_calls:,} calls took" in said
    assert "numba.njit" in said
    assert 100 <= slow.python_calls <= 300
    assert 0.0 < slow.python_time < slow.wall_time + slow.compile_time
    assert "Python functions" not in lf.simulate(pushed((rising, 0.0)), 0.1, STEPPER).summary()


def test_compiling_in_the_midst_of_a_run_is_no_computing() -> None:
    """Twenty steps, and a function that is compiled halfway: that takes far longer than they do."""

    @numba.njit
    def late(t):
        total = np.zeros(3)
        for k in range(7):
            total += np.sort(np.array([math.sin(k * t), math.exp(-t), t / (1.0 + k)]))
        return total.sum()

    def function(t: float) -> float:
        return late(t) if t > 0.01 else 0.0

    told = lf.Function(function, shortest=0.01)  # is not probed, which would compile it before
    began = time.perf_counter()
    result = lf.simulate(pushed((told, 0.0)), 0.02, STEPPER)
    (compiled,) = late.overloads.values()
    took = compiled.metadata["timers"]["compiler_lock"]
    assert result.compile_time > 0.99 * took
    assert result.wall_time < time.perf_counter() - began - 0.99 * took  # however long the machine is at other things


def smooth_rise(knots: int, span: float) -> lf.Table:
    times = np.linspace(0.0, span, knots)
    return lf.Table(times, 1.0 - np.cos(math.pi * times / span))


@pytest.mark.parametrize("knots", [12, 50, 400])
@pytest.mark.parametrize("span", [0.01, 1.0, 100.0])
def test_a_tabulated_drive_may_start_at_rest(knots: int, span: float) -> None:
    """The spline of its values starts with some 1e-8 ... 1e-3 of its speed; the scene says that it starts at rest."""
    table = smooth_rise(knots, span)
    compiled = turned(table).compiled()
    assert compiled.u[2] == 0.0
    pieces = compiled.model.signals.coefficients
    assert pieces[0, 2] == pytest.approx(0.0, abs=1e-12 / span)
    place = np.polyval(pieces[-2], np.diff(table.times)[-1])  # type: ignore[arg-type]
    assert place == pytest.approx(2.0, rel=1e-12)


def test_a_tabulated_drive_at_another_speed_is_refused() -> None:
    times = np.linspace(0.0, 1.0, 40)
    with pytest.raises(lf.ModelError, match=r"initial velocity violates it by 0\.3"):
        turned(lf.Table(times, 0.3 * times + times**3)).compiled()
    scene = lf.Scene(gravity=(0.0, 0.0))
    disc = scene.add(lf.Disc(0.1, mass=2.0), angular_velocity=0.3005)
    scene.join(lf.DrivenAngle(disc.point("center"), scene.ground.at(0.0, 0.0), lf.Table(times, 0.3 * times + times**3)))
    assert scene.compiled().model.signals.coefficients[0, 2] == pytest.approx(0.3005, rel=1e-12)


@pytest.mark.parametrize("kind", ["displacement", "distance"])
def test_other_tabulated_drives_take_the_velocity_of_the_start(kind: str) -> None:
    """Along an axis that turns, and between two points."""
    times = np.linspace(0.0, 1.0, 30)
    scene = lf.Scene(gravity=(0.0, 0.0))
    turning = scene.add(lf.Disc(0.1, mass=1.0), angular_velocity=2.0)
    slider = scene.add(lf.Disc(0.1, mass=1.0), position=(1.0, 0.5), velocity=(0.7, 2.0))
    if kind == "displacement":
        rate = 0.7 + 2.0 * 0.5  # e.v and edot.r, e fixed in the turning disc
        motion = lf.Table(times, 1.0 + rate * times + 0.5 * np.sin(3.0 * times) ** 2)
        scene.join(lf.DrivenDisplacement(slider.point("center"), turning.point("center"), motion, (1.0, 0.0)))
    else:
        length = math.hypot(1.0, 0.5)
        rate = (0.7 + 0.5 * 2.0) / length
        motion = lf.Table(times, length + rate * times + 0.5 * np.sin(3.0 * times) ** 2)
        scene.join(lf.Distance(slider.point("center"), turning.point("center"), length=motion))
    assert scene.compiled().model.signals.coefficients[0, 2] == pytest.approx(rate, rel=1e-12)
