"""Heavy top, spherical pendulum and spatial slider-crank, event-driven and under the integrators of Smooth."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from tests.rates import assert_rate
from tests.spatial_flight import lengths
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

# with the relative error that each must keep
STEPPERS = [
    pytest.param(lf.EventDriven(rtol=1e-8), 2e-8, id="events"),
    pytest.param(lf.EventDriven(rtol=1e-10), 2e-9, id="events, 1e-10"),
    pytest.param(lf.Smooth(integrator=lf.ExplicitRungeKutta(rtol=1e-9)), 5e-9, id="explicit"),
    pytest.param(lf.Smooth(integrator=lf.Stiff(rtol=1e-8)), 1e-8, id="stiff"),
    pytest.param(lf.Smooth(integrator=lf.Verlet(2e-4)), 1e-5, id="Verlet"),
]
FREE = 1e9  # a tolerance that leaves steps alone


@pytest.mark.parametrize("precession", PRECESSION)
@pytest.mark.parametrize(("stepper", "error"), STEPPERS)
def test_a_top_precesses_steadily(stepper: Any, error: float, precession: float) -> None:
    result = lf.simulate(heavy_top(precession), 0.2, stepper, record=0.01)
    theta, phi = axis_of(result)
    np.testing.assert_allclose(theta, LEAN, atol=error)
    np.testing.assert_allclose((phi[-1] - phi[0]) / 0.2, precession, atol=4.0 * error)
    assert np.abs(lengths(result) - 1.0).max() < 1e-14
    assert result.joint_drift.max() < error


@pytest.mark.parametrize(("stepper", "error"), STEPPERS)
def test_a_released_top_nods(stepper: Any, error: float) -> None:
    result = lf.simulate(heavy_top(0.0), RELEASED["period"], stepper, record=0.5 * RELEASED["period"])
    theta, phi = axis_of(result)
    assert len(theta) % 2 == 1
    np.testing.assert_allclose(theta[len(theta) // 2], RELEASED["lowest"], atol=error)
    np.testing.assert_allclose(theta[-1], LEAN, atol=error)
    np.testing.assert_allclose(phi[-1] - phi[0], RELEASED["turn"], atol=error)


@pytest.mark.parametrize(("stepper", "error"), STEPPERS)
def test_a_pendulum_goes_round(stepper: Any, error: float) -> None:
    result = lf.simulate(spherical_pendulum(), 2.0, stepper, record=0.1)
    theta, phi = polar(result)
    np.testing.assert_allclose(theta[-1], PENDULUM["theta"], atol=error)
    np.testing.assert_allclose(phi[-1], PENDULUM["phi"], atol=error)
    assert result.joint_drift.max() < error


@pytest.mark.parametrize("stepper", [lf.EventDriven(rtol=1e-8), lf.Smooth(integrator=lf.ExplicitRungeKutta(rtol=1e-8))])
def test_a_spatial_slider_crank_speeds_up_and_slows_down(stepper: Any) -> None:
    result = lf.simulate(slider_crank(), 2.0, stepper, record=0.05)
    at = np.searchsorted(result.times, [1.0 - 1e-9, 2.0 - 1e-9])
    np.testing.assert_allclose(crank_angle(result)[at], CRANK["angle"], atol=1e-6)
    np.testing.assert_allclose(result.u[at, 3], CRANK["rate"], atol=1e-6)
    np.testing.assert_allclose(result.q[at, 7], CRANK["slider"], atol=1e-6)


@pytest.mark.parametrize(
    "stepper",
    [
        lambda h: lf.EventDriven(rtol=FREE, atol=FREE, max_step=h, first_step=h),
        lambda h: lf.Smooth(integrator=lf.ExplicitRungeKutta(rtol=FREE, atol=FREE, max_step=h, first_step=h)),
    ],
    ids=["events", "explicit"],
)
def test_order_with_joints(stepper: Any) -> None:
    def end(scene: lf.SpatialScene, duration: float, h: float) -> np.ndarray:
        result = lf.simulate(scene, duration, stepper(h))
        assert result.steps == round(duration / h)
        return np.concatenate([result.q[-1], result.u[-1]])

    for scene, duration, steps in (
        (heavy_top(0.0), 0.064, np.array([2e-3, 1e-3, 5e-4])),
        (spherical_pendulum(), 0.8, np.array([0.04, 0.02, 0.01])),
    ):
        exact = end(scene, duration, 0.25 * steps[-1])
        errors = [np.abs(end(scene, duration, h) - exact).max() for h in steps]
        assert_rate(steps, errors, 5.0, 0.5)
