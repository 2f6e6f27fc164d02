"""Time stepping of rigid bodies on joints in space: order 2, and motions known of a top, a pendulum, a slider-crank."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.jit.kernel import FloatArray
from tests.rates import assert_rate
from tests.spatial_mechanisms import (
    FAST,
    STEADY,
    angles_of_pendulum,
    axis_in_precession,
    axis_of_top,
    flexible_pendulum,
    pendulum,
    simulated,
    slider_crank,
    top,
)

STEPPERS: dict[str, Callable[[float], Any]] = {
    "alpha": lambda h: lf.GeneralizedAlpha(h),
    "corrected": lambda h: lf.MoreauJean(h),
    "solved": lambda h: lf.MoreauJean(h, gyroscopic="solved"),
}


def off_precession(precession: float, duration: float, stepper: Any) -> float:
    """Error of the axis of a top that precesses steadily."""
    found = simulated(top(precession), duration, stepper)
    assert found["joint_drift"].max() < 1e-11
    assert abs(np.linalg.norm(found["q"][-1, 3:7]) - 1.0) < 1e-14
    return float(np.abs(axis_of_top(found["q"][-1]) - axis_in_precession(precession, duration)).max())


@pytest.mark.parametrize("name", STEPPERS)
@pytest.mark.parametrize(("precession", "duration", "coarsest"), [(STEADY, 0.25, 250), (FAST, 0.1, 250)])
def test_a_top_precesses_steadily_with_order_two(name: str, precession: float, duration: float, coarsest: int) -> None:
    """R2, both precessions at which 30 degrees are kept. Of order 1 if joints have no part in the gyroscopic torque."""
    steps = coarsest * 2 ** np.arange(3)
    errors = [off_precession(precession, duration, STEPPERS[name](duration / n)) for n in steps]
    assert_rate(1.0 / steps, errors, 2.0, within=0.1)
    assert errors[-1] < 1e-4


@pytest.mark.parametrize("name", STEPPERS)
def test_a_top_that_is_let_go_nutates(name: str) -> None:
    """R2: theta from 30 degrees to .623871299 and back in .237882413 s, by .627062592 rad about the vertical."""
    period, highest, advance = 0.237882413, 0.623871299, 0.627062592
    errors = []
    for n in (500, 1000, 2000):
        run = STEPPERS[name](period / n).start(top(0.0), period, period / 2)
        assert not run.advance(10**9)
        half, end = (axis_of_top(q) for q in run.records.collected()["q"][1:])
        errors.append(max(abs(np.arccos(half[2]) - highest), np.abs(end - axis_in_precession(advance, 1.0)).max()))
    assert_rate([4.0, 2.0, 1.0], errors, 2.0, within=0.2)
    assert errors[-1] < 2e-4


@pytest.mark.parametrize("name", ["alpha", "corrected"])
def test_a_spherical_pendulum_with_order_two(name: str) -> None:
    """R7 at t = 2: theta = .930829520, phi = 7.259031152 rad."""
    exact = np.array([0.930829520, 7.259031152 - 2.0 * np.pi])
    steps = 250 * 2 ** np.arange(3)
    errors = []
    for n in steps:
        found = simulated(pendulum(), 2.0, STEPPERS[name](2.0 / n))
        assert found["joint_drift"].max() < 1e-11
        errors.append(np.abs(angles_of_pendulum(found["q"][-1]) - exact).max())
    assert_rate(1.0 / steps, errors, 2.0, within=0.1)
    assert errors[-1] < 3e-5


def off_crank(found: dict[str, FloatArray]) -> float:
    """Error at t = 2 of R6', of the slider [m] and of the crank's rate over its size."""
    return float(max(abs(found["q"][-1, 7] - 0.224092), abs(found["u"][-1, 3] / 8.978506 - 1.0)))


@pytest.mark.parametrize("name", ["alpha", "corrected"])
def test_a_spatial_slider_crank_runs_free_with_order_two(name: str) -> None:
    """R6': theta, theta' and x of an equation of one freedom. The six digits printed end at 1e-6."""
    steps = 250 * 2 ** np.arange(3)
    errors = []
    for n in steps:
        found = simulated(slider_crank(), 2.0, STEPPERS[name](2.0 / n))
        assert found["joint_drift"].max() < 1e-11
        errors.append(off_crank(found))
    # errors of opposite signs make it fall faster at first under Moreau-Jean
    assert_rate(1.0 / steps, errors, 2.0, within=(0.1, 0.2 if name == "alpha" else 0.8))
    assert errors[-1] < 1e-4


@pytest.mark.parametrize("name", STEPPERS)
def test_a_flexible_pendulum_with_order_two(name: str) -> None:
    """Against Runge-Kutta steps to 1e-12: a ball joint at a material point that moves and turns with the modes."""
    exact = simulated(flexible_pendulum(), 0.5, lf.EventDriven(rtol=1e-12, atol=1e-13))
    steps = 200 * 2 ** np.arange(3)
    errors, unexplained = [], []
    for n in steps:
        found = simulated(flexible_pendulum(), 0.5, STEPPERS[name](0.5 / n))
        assert found["joint_drift"].max() < 1e-11
        errors.append([np.abs(found[part][-1] - exact[part][-1]).max() for part in ("q", "u")])
        audit = found["energies"][:, :6].sum(axis=1) - found["energies"][:, 6]
        unexplained.append(abs(audit[1] - audit[0]))
    assert_rate(1.0 / steps, errors, 2.0, within=0.1)
    assert np.max(errors[-1]) < 4e-5
    assert unexplained[-1] < 5e-5  # of 22 J


@pytest.mark.parametrize(("make", "power"), [(lf.GeneralizedAlpha, 2 / 3), (lf.MoreauJean, 1.0)])
def test_error_control_with_joints(make: Callable[..., Any], power: float) -> None:
    """R7: errors fall with the tolerance, as its power 2/3 at order 2.

    Faster under Moreau-Jean: its velocities meet a joint in the middle of a step, and what those of steps and of half
    steps differ by for that is of order h^2 but no error of theirs.
    """
    tolerances = 10.0 ** -np.arange(4.0, 7.0)
    errors = []
    for rtol in tolerances:
        found = simulated(pendulum(), 2.0, make(1e-3, adaptive=lf.AdaptiveStep(rtol=float(rtol))))
        off = angles_of_pendulum(found["q"][-1]) - [0.930829520, 7.259031152 - 2.0 * np.pi]
        errors.append(np.abs(off).max())
    assert_rate(tolerances, errors, power, within=0.1)
    assert errors[-1] < 3e-5
