"""The motion of spatial bodies between stored instants: of the order of the polynomials, and rotations all the way."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from lcpflex.results.polynomials import hermite
from lcpflex.results.spatial.chart import SpatialChart, square_roots_of_masses

J = np.array([1.0, 2.0, 3.0])
BODIES: Any = SimpleNamespace(
    place=np.array([0, 8]), dof=np.array([0, 7]), mass=np.array([4.0]), second=np.diag([2.0, 1.0, 0.0])[None]
)


def rate(t: float, y: np.ndarray) -> np.ndarray:
    """A thrown body with principal moments J that tumbles, and a mode that vibrates by itself."""
    q, u = y[:8], y[8:]
    p, omega = q[3:7], u[3:6]
    turn = 0.5 * np.array([-p[1:] @ omega, *(p[0] * omega + np.cross(p[1:], omega))])
    return np.array([*u[:3], *turn, u[6], 0.0, 0.0, -9.81, *(-np.cross(omega, J * omega) / J), -9.0 * q[7]])


@pytest.fixture(scope="module")
def motion() -> Any:
    """Its states over time."""
    start = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.1, 1.0, 2.0, 3.0, 0.5, 3.0, 0.4, 0.2]
    return solve_ivp(rate, (0.0, 0.5), start, rtol=1e-12, atol=1e-13, dense_output=True, method="DOP853").sol


@pytest.mark.parametrize(("instants", "order"), [(2, 4), (3, 6)])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_interpolation_is_of_the_order_of_its_polynomial_for_either_sign_of_quaternions(
    motion: Any, instants: int, order: int, sign: float
) -> None:
    errors = []
    for h in (0.1, 0.05):
        times = np.linspace(0.2, 0.2 + h, instants)
        states = motion(times).T
        states[-1, 3:7] *= sign
        chart = SpatialChart(BODIES, states[0, :8])
        x, rates = chart.coordinates(states[:, :8], states[:, 8:])
        worst = 0.0
        for t in np.linspace(0.2, 0.2 + h, 9):
            q, u = chart.state(*hermite(times, x, rates, t))
            assert abs(np.linalg.norm(q[3:7]) - 1.0) < 1e-15
            worst = max(worst, np.abs(q - motion(t)[:8]).max(), 0.1 * h * np.abs(u - motion(t)[8:]).max())
        errors.append(worst)
    assert order - 0.3 < np.log2(errors[0] / errors[1]) < order + 0.3


def test_a_rotation_about_a_fixed_axis_is_found_exactly() -> None:
    omega = np.array([0.3, -1.0, 0.8])
    u = np.array([0.0, 0.0, 0.0, *omega, 0.0])
    times = np.array([0.0, 1.0])
    half = 0.5 * np.linalg.norm(omega) * times
    axis = omega / np.linalg.norm(omega)
    q = np.zeros((2, 8))
    q[:, 3], q[:, 4:7] = np.cos(half), np.sin(half)[:, None] * axis
    chart = SpatialChart(BODIES, q[0])
    found, velocity = chart.state(*hermite(times, *chart.coordinates(q, np.array([u, u])), 0.4))
    half = 0.2 * np.linalg.norm(omega)
    np.testing.assert_allclose(found[3:7], [np.cos(half), *np.sin(half) * axis], atol=1e-15)
    np.testing.assert_allclose(velocity, u, atol=1e-15)


def test_numbers_of_coordinates_and_masses() -> None:
    chart = SpatialChart(BODIES, np.array([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0]))
    assert [chart.number(i) for i in range(7)] == [0, 1, 2, 4, 5, 6, 7]
    weight, owner = square_roots_of_masses(BODIES)
    np.testing.assert_allclose(weight**2, [4.0, 4.0, 4.0, 1.0, 2.0, 3.0, 1.0])
    assert owner.tolist() == [0] * 7
