"""Python functions that act for a moment only: steps go there, or the run says that it missed them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numba
import numpy as np
import pytest

import lcpflex as lf
from lcpflex.dynamics.time_probe import probed
from lcpflex.results.doubts import doubts

CONTROL = lf.AdaptiveStep(rtol=1e-4, atol=1e-6)
ADAPTIVE = (
    lf.EventDriven(),
    lf.MoreauJean(step=1e-3, adaptive=CONTROL),
    lf.GeneralizedAlpha(step=1e-3, adaptive=CONTROL),
    lf.Smooth(),
    lf.Smooth(integrator=lf.Stiff()),
)
FIXED = (
    lf.MoreauJean(step=1e-3),
    lf.MoreauJean(step=1e-3, theta=0.8),
    lf.GeneralizedAlpha(step=1e-3),
    lf.Smooth(integrator=lf.Verlet(1e-3)),
)


def jump(at: float, width: float, force: float, beside: float = 0.0) -> Callable[[float], float]:
    return lambda t: force if at <= t < at + width else beside


def both(at: float, width: float, force: float) -> Callable[[float], tuple[float, float]]:
    return lambda t: (force if at <= t < at + width else 0.0, -1.0)


def compiled(at: float, width: float, force: float) -> Any:
    return numba.njit(lambda t: force if at <= t < at + width else 0.0)


def plane(load: Any, mass: float = 1.0, size: float = 0.1) -> lf.Scene:
    scene = lf.Scene(gravity=(0.0, 0.0))
    disc = scene.add(lf.Disc(size, mass=mass), name="disc")
    scene.load(lf.Force(disc.point("center"), load))
    return scene


def space(load: Any) -> lf.SpatialScene:
    scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
    box = scene.add(lf.Cuboid(0.1, 0.1, 0.1, mass=1.0), "disc")
    scene.load(lf.Force(box.at(0.0, 0.0, 0.0), (load, 0.0, 0.0)))
    return scene


def own(load: Any) -> lf.UserSystem:
    return lf.UserSystem([0.0], [0.0], [[1.0]], lambda t, q, u: np.array([load(t)]))


@pytest.mark.parametrize("stepper", ADAPTIVE, ids=repr)
def test_error_control_goes_to_a_pulse_of_thirty_microseconds(stepper: Any) -> None:
    result = lf.simulate(plane((jump(0.4103, 3e-5, 1e5), 0.0)), 1.0, stepper, progress=False)
    assert result.u[-1, 0] == pytest.approx(3.0, rel=1e-2)
    assert not doubts(result)


@pytest.mark.parametrize(
    "scene",
    [
        lambda: plane(both(0.77, 3e-5, 1e5)),
        lambda: plane((compiled(0.2, 3e-5, 1e5), 0.0)),
        lambda: plane((jump(0.4103, 3e-5, 1e5, beside=2.0), 0.0)),
        lambda: space(jump(0.6, 3e-5, 1e5)),
    ],
    ids=["both components", "numba", "beside a force", "space"],
)
def test_whatever_the_function_is_given_for(scene: Any) -> None:
    expected = lf.simulate(scene(), 1.0, lf.EventDriven(), progress=False).u[-1, 0]
    assert 2.9 < expected < 5.1
    said = doubts(lf.simulate(scene(), 1.0, FIXED[0], progress=False))
    assert said
    assert "which do not follow it" in said[0]


def test_a_system_of_the_users_own_tells_what_its_steps_missed() -> None:
    """Its forces cost a state to be asked: a thousand looks, which see 4 ms."""
    scene = own(jump(0.901, 4e-3, 750.0))
    assert lf.simulate(scene, 1.0, lf.EventDriven(), progress=False).u[-1, 0] == pytest.approx(3.0, rel=1e-2)
    (said,) = doubts(lf.simulate(scene, 1.0, lf.MoreauJean(step=1e-2), progress=False))
    assert said.startswith("the force on coordinate 0 bends and jumps within steps of 0.01 s")
    assert not doubts(lf.simulate(scene, 1.0, lf.MoreauJean(step=1e-4), progress=False))


@pytest.mark.parametrize(
    "stepper",
    [
        pytest.param(FIXED[0], id="moreau"),
        pytest.param(FIXED[1], id="theta", marks=pytest.mark.slow),
        pytest.param(FIXED[2], id="alpha"),
        pytest.param(FIXED[3], id="verlet", marks=pytest.mark.slow),
    ],
)
@pytest.mark.parametrize(
    ("at", "width"),
    [(0.4103, 3e-5), *(pytest.param(*one, marks=pytest.mark.slow) for one in ((0.5, 2e-4), (0.90008, 1.5e-5)))],
)
def test_fixed_steps_that_miss_it_are_not_to_be_trusted(stepper: Any, at: float, width: float) -> None:
    result = lf.simulate(plane((jump(at, width, 3.0 / width), 0.0)), 1.0, stepper, progress=False)
    assert abs(result.u[-1, 0] - 3.0) > 0.3
    (said,) = (text for text in doubts(result) if "disc.center" in text)
    assert f"at t = {at:g}" in said.replace(f"{at + 1e-6:.6g}", f"{at:g}")
    assert "it acts for" in said


@pytest.mark.parametrize("duration", [1e-3, 1.0, 3600.0])
def test_pulses_longer_than_two_cells_are_always_found(duration: float) -> None:
    for share in np.random.default_rng(5).uniform(0.0, 0.99, 20):
        times, values = probed(jump(share * duration, 2e-5 * duration, 7.0), duration)
        seen = times[values[:, 0] > 0.0]
        assert len(seen)
        assert np.ptp(seen) == pytest.approx(2e-5 * duration, abs=2.1e-6 * duration)


def test_functions_that_cost_much_are_looked_at_less_often() -> None:
    """Counted in calls, so that it is the same on any machine."""
    looks = []

    def costly(t: float) -> float:
        looks.append(t)
        return float(sum(abs(k) for k in range(1000)))

    probed(costly, 1.0)
    few = len(looks)
    assert few < 4000
    looks.clear()
    probed(costly, 1.0)
    assert len(looks) == few


def test_smooth_functions_are_described_by_no_more_than_before() -> None:
    for function in (lambda t: 3.0 * t, lambda t: np.sin(31.0 * t), lambda t: 10.0, jump(0.3, 0.4, 2.0)):
        assert len(probed(function, 1.0)[0]) < 1100


def resting(load: Any, flat: bool = True) -> Any:
    """A box that sticks to the floor, pressed without gravity."""
    if flat:
        scene: Any = lf.Scene(gravity=(0.0, 0.0))
        box = scene.add(lf.Box(0.2, 0.1, mass=1.0), position=(0.0, 0.05))
        scene.contact(box.surface(), scene.ground.half_plane((0, 0), (0, 1)), friction=0.5)
        scene.load(lf.Force(box.at(0.0, -0.05), (load, -10.0)))
        return scene
    scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
    box = scene.add(lf.Cuboid(0.2, 0.1, 0.1, mass=1.0), position=(0.0, 0.0, 0.05))
    scene.contact(box.surface(), scene.ground.plane((0, 0, 0), (0, 0, 1)), friction=0.5)
    scene.load(lf.Force(box.at(0.0, 0.0, -0.05), (load, 0.0, -10.0)))
    return scene


NOISE = np.random.default_rng(1).normal(0.0, 0.5, 5001)


@pytest.mark.parametrize("flat", [True, False], ids=["plane", "space"])
@pytest.mark.parametrize("stepper", [FIXED[0], FIXED[2]], ids=["moreau", "alpha"])
@pytest.mark.parametrize(
    "load",
    [
        lambda t: 3.0 * np.sin(31.4 * t),
        lambda t: 3.0 * np.sin(314.0 * t),
        lf.Harmonic(3.0, 31.4),
        lf.Table(np.linspace(0.0, 1.0, 5001), NOISE),
        lambda t: 3.0 if 0.1 <= t < 0.2 else 0.0,
    ],
    ids=["sine", "faster", "harmonic", "noise", "jump"],
)
def test_what_sticks_needs_no_shorter_step(load: Any, stepper: Any, flat: bool) -> None:
    result = lf.simulate(resting(load, flat), 0.3, stepper, progress=False)
    assert np.abs(result.u).max() < 1e-12
    assert not result.warnings
    assert not doubts(result)


@pytest.mark.parametrize("stepper", [FIXED[0], FIXED[2]], ids=["moreau", "alpha"])
def test_a_pulse_that_would_break_it_loose_is_told(stepper: Any) -> None:
    """600 N for 0.3 ms, between the middles and ends of steps, on a box that sticks with 5 N."""
    result = lf.simulate(resting(jump(0.1001, 3e-4, 600.0)), 0.3, stepper, progress=False)
    assert np.abs(result.u).max() < 1e-12
    assert "at t = 0.1001 s it acts for 0.0003 s" in "; ".join(doubts(result))
