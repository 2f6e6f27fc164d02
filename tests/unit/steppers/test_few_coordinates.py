"""User-defined systems of one and two coordinates against closed forms, with contact, friction and joints."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.special import ellipk

import lcpflex as lf

STEPPERS = [
    pytest.param(lf.MoreauJean(step=1e-4), 2e-3, id="moreau-jean"),
    pytest.param(lf.EventDriven(), 1e-6, id="event-driven"),
]
Stepper = lf.MoreauJean | lf.EventDriven


@pytest.mark.parametrize(("stepper", "tolerance"), STEPPERS)
def test_one_coordinate_bounces(stepper: Stepper, tolerance: float) -> None:
    """A mass dropped from 1 m with e = 1/2: after one impact its speed is e sqrt(2 g h) - g (t - t1)."""
    weight = 2.0 * 9.81
    system = lf.UserSystem(
        q=[1.0], u=[0.0], mass=[[2.0]], force=lambda t, q, u: [-weight], gaps=lambda q: q, normals=[[1.0]],
        restitution=0.5, potential=lambda q: weight * q[0],
    )  # fmt: skip
    result = lf.simulate(system, 0.6, stepper)
    landing = math.sqrt(2.0 / 9.81)
    assert result.u[-1, 0] == pytest.approx(0.5 * math.sqrt(2.0 * 9.81) - 9.81 * (0.6 - landing), abs=tolerance)
    assert result.impulse[-1, 0, 0] == pytest.approx(2.0 * 1.5 * math.sqrt(2.0 * 9.81), rel=tolerance)
    assert result.penetration.max() < 1e-3


@pytest.mark.parametrize(("stepper", "tolerance"), STEPPERS)
def test_two_coordinates_slide_to_rest(stepper: Stepper, tolerance: float) -> None:
    """A particle that slides on a line with mu = 0.3 stops after v^2 / (2 mu g)."""
    system = lf.UserSystem(
        q=[0.0, 0.0], u=[1.0, 0.0], mass=np.eye(2), force=lambda t, q, u: [0.0, -9.81], gaps=lambda q: [q[1]],
        normals=[[0.0], [1.0]], tangents=[[1.0], [0.0]], friction=0.3,
    )  # fmt: skip
    result = lf.simulate(system, 0.5, stepper)
    assert result.q[-1, 0] == pytest.approx(1.0 / (2.0 * 0.3 * 9.81), abs=tolerance)
    np.testing.assert_allclose(result.u[-1], 0.0, atol=1e-9)


@pytest.mark.parametrize(("stepper", "tolerance"), STEPPERS)
def test_two_coordinates_swing_on_a_joint(stepper: Stepper, tolerance: float) -> None:
    """A particle on a rod of 1 m, released horizontally, hangs straight down after K(1/2) sqrt(l/g)."""
    system = lf.UserSystem(
        q=[1.0, 0.0], u=[0.0, 0.0], mass=np.eye(2), force=lambda t, q, u: [0.0, -9.81],
        potential=lambda q: 9.81 * q[1], constraints=lambda t, q: [0.5 * (q @ q - 1.0)], jacobian=lambda t, q: [q],
    )  # fmt: skip
    result = lf.simulate(system, float(ellipk(0.5)) / math.sqrt(9.81), stepper)
    np.testing.assert_allclose(result.q[-1], [0.0, -1.0], atol=tolerance)
    assert result.energies.largest_remainder < tolerance
