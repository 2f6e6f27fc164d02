"""Time stepping of bodies on joints in space: order 2, and motions known of a top, a pendulum, a slider-crank."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.bodies.spatial.body import SpatialPoint
from tests.rates import assert_rate
from tests.spatial_bodies import random_body
from tests.spatial_flight import flexible_body, lengths
from tests.spatial_tops import (
    CRANK,
    LEAN,
    PENDULUM,
    PRECESSION,
    RELEASED,
    axis_of,
    crank_angle,
    heavy_top,
    polar,
    slider_crank,
    spherical_pendulum,
)

STEPPERS: dict[str, Callable[[float], Any]] = {
    "alpha": lambda h: lf.GeneralizedAlpha(h),
    "corrected": lambda h: lf.MoreauJean(h),
    "solved": lambda h: lf.MoreauJean(h, gyroscopic="solved"),
}


def simulated(scene: lf.SpatialScene, duration: float, stepper: Any, record: float | None = None) -> lf.Result:
    """A result whose joints hold and whose quaternions have length 1."""
    growth = lf.EnergyGrowth.ACCEPT
    result = lf.simulate(scene, duration, stepper, record=record or duration, energy_growth=growth)
    assert result.joint_drift.max() < 1e-11
    assert np.abs(lengths(result) - 1.0).max() < 1e-14
    return result


@pytest.mark.parametrize("name", STEPPERS)
@pytest.mark.parametrize(("precession", "duration"), [(PRECESSION[0], 0.25), (PRECESSION[1], 0.1)])
def test_a_top_precesses_steadily_with_order_two(name: str, precession: float, duration: float) -> None:
    """R2, both precessions at which 30 degrees are kept. Of order 1 if joints have no part in the gyroscopic torque."""
    steps = 250 * 2 ** np.arange(3)
    errors = []
    for n in steps:
        angle, azimuth = axis_of(simulated(heavy_top(precession), duration, STEPPERS[name](duration / n)))
        ahead = math.remainder(azimuth[-1] - azimuth[0] - precession * duration, 2.0 * math.pi)
        errors.append(math.hypot(angle[-1] - LEAN, ahead))
    assert_rate(1.0 / steps, errors, 2.0, within=0.1)
    assert errors[-1] < 2e-4


@pytest.mark.parametrize("name", STEPPERS)
def test_a_top_that_is_let_go_nutates(name: str) -> None:
    """R2: its lowest place and one period."""
    period, errors = RELEASED["period"], []
    for n in (500, 1000, 2000):
        angle, azimuth = axis_of(simulated(heavy_top(0.0), period, STEPPERS[name](period / n), period / 2))
        errors.append(max(abs(angle[1] - RELEASED["lowest"]), abs(azimuth[2] - azimuth[0] - RELEASED["turn"])))
    assert_rate([4.0, 2.0, 1.0], errors, 2.0, within=0.2)
    assert errors[-1] < 2e-4


@pytest.mark.parametrize("name", ["alpha", "corrected"])
def test_a_spherical_pendulum_with_order_two(name: str) -> None:
    """R7 at t = 2."""
    steps = 250 * 2 ** np.arange(3)
    errors = []
    for n in steps:
        theta, phi = polar(simulated(spherical_pendulum(), 2.0, STEPPERS[name](2.0 / n), 0.2))
        errors.append(max(abs(theta[-1] - PENDULUM["theta"]), abs(phi[-1] - PENDULUM["phi"])))
    assert_rate(1.0 / steps, errors, 2.0, within=0.1)
    assert errors[-1] < 3e-5


@pytest.mark.parametrize("name", ["alpha", "corrected"])
def test_a_spatial_slider_crank_runs_free_with_order_two(name: str) -> None:
    """R6' at t = 2; the six digits printed end at 1e-6."""
    steps = 250 * 2 ** np.arange(3)
    errors = []
    for n in steps:
        result = simulated(slider_crank(), 2.0, STEPPERS[name](2.0 / n), 0.04)
        off = np.array([crank_angle(result)[-1], result.u[-1, 3], result.q[-1, 7]])
        errors.append(np.abs(off / [CRANK["angle"][1], CRANK["rate"][1], CRANK["slider"][1]] - 1.0).max())
    # errors of opposite signs make it fall faster at first under Moreau-Jean
    assert_rate(1.0 / steps, errors, 2.0, within=(0.1, 0.2 if name == "alpha" else 0.8))
    assert errors[-1] < 1e-4


def flexible_pendulum(modes: int = 3) -> lf.SpatialScene:
    """A damped flexible body of point masses that hangs on a ball joint at one of them, and spins."""
    given = random_body(np.random.default_rng(7), modes, centred=True)
    turns = 0.3 * np.random.default_rng(1).normal(size=(modes, 3))
    points = {"hung": SpatialPoint(given.places[0], given.shapes[:, 0], turns)}
    body = flexible_body(given, stiffness=400.0 * (1.0 + np.arange(modes)), damping=np.ones(modes), points=points)
    omega, place = np.array([1.0, 2.0, -1.5]), given.places[0]
    scene = lf.SpatialScene()
    placed = scene.add(body, position=-place, angular_velocity=omega, velocity=-np.cross(omega, place))
    scene.join(lf.Ball(placed.point("hung"), scene.ground.at(0.0, 0.0, 0.0)))
    return scene


@pytest.mark.parametrize("name", STEPPERS)
def test_a_flexible_pendulum_with_order_two(name: str) -> None:
    """Against Runge-Kutta steps to 1e-12: a ball joint at a material point that moves and turns with the modes."""
    exact = lf.simulate(flexible_pendulum(), 0.5, lf.EventDriven(rtol=1e-12, atol=1e-13), record=0.5)
    steps = 200 * 2 ** np.arange(3)
    errors, unexplained = [], []
    for n in steps:
        result = simulated(flexible_pendulum(), 0.5, STEPPERS[name](0.5 / n))
        errors.append([np.abs(result.q[-1] - exact.q[-1]).max(), np.abs(result.u[-1] - exact.u[-1]).max()])
        unexplained.append(result.energies.largest_remainder)
    assert_rate(1.0 / steps, errors, 2.0, within=0.1)
    assert np.max(errors[-1]) < 4e-5
    assert unexplained[-1] < 5e-5  # of 22 J


@pytest.mark.parametrize(
    ("make", "power"), [pytest.param(lf.GeneralizedAlpha, 2 / 3, marks=pytest.mark.slow), (lf.MoreauJean, 1.0)]
)
def test_error_control_with_joints(make: Callable[..., Any], power: float) -> None:
    """R7: errors fall with the tolerance, as its power 2/3 at order 2.

    Faster under Moreau-Jean: its velocities meet a joint in the middle of a step, and what those of steps and of half
    steps differ by for that is of order h^2 but no error of theirs.
    """
    tolerances = 10.0 ** -np.arange(4.0, 7.0)
    errors = []
    for rtol in tolerances:
        control = lf.AdaptiveStep(rtol=float(rtol))
        theta, phi = polar(simulated(spherical_pendulum(), 2.0, make(1e-3, adaptive=control), 0.2))
        errors.append(max(abs(theta[-1] - PENDULUM["theta"]), abs(phi[-1] - PENDULUM["phi"])))
    assert_rate(tolerances, errors, power, within=0.2)
    assert errors[-1] < 3e-5


def test_stiff_dampers_in_space_converge() -> None:
    """A block on a spring with a damper of c r^2 h / J = 20, against Runge-Kutta steps."""
    scene = lf.SpatialScene()
    block = scene.add(lf.Cuboid(0.2, 0.1, 0.05, mass=1.0), angular_velocity=(1.0, 2.0, 3.0))
    foot = scene.ground.at(0.1, 0.05, 0.5)
    scene.load(lf.Spring(block.at(0.1, 0.05, 0.02), foot, stiffness=2000.0, damping=150.0))
    exact = lf.simulate(scene, 0.5, lf.EventDriven(rtol=1e-9, atol=1e-11), record=0.5)
    result = lf.simulate(scene, 0.5, lf.GeneralizedAlpha(5e-3), record=0.5)
    assert not any("did not converge" in warning for warning in result.warnings)
    assert np.abs(result.q[-1] - exact.q[-1]).max() < 2e-2
