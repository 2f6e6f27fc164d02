"""Free flight in space under steppers that take configurations as numbers: orders, tolerances, what is conserved."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import BDF, Radau

import lcpflex as lf
from lcpflex.jit.kernel import FloatArray
from tests.rates import assert_rate
from tests.spatial_flight import (
    OMEGA,
    OMEGA_8,
    P_8,
    PERIOD,
    angular_momenta,
    apart,
    dzhanibekov,
    exact_flight,
    flexible_flight,
    lengths,
)

FREE = 1e9  # a tolerance that leaves steps alone


def event_driven(h: float) -> lf.EventDriven:
    """Steps of one length."""
    return lf.EventDriven(rtol=FREE, atol=FREE, max_step=h, first_step=h)


def smooth(h: float) -> lf.Smooth:
    """The same between contacts with force laws."""
    return lf.Smooth(integrator=lf.ExplicitRungeKutta(rtol=FREE, atol=FREE, max_step=h, first_step=h))


@pytest.mark.parametrize("stepper", [event_driven, smooth])
def test_runge_kutta_is_of_order_5_in_free_rotation(stepper: object) -> None:
    p, omega = np.split(exact_flight(4.0)(4.0), [4])
    steps = np.array([0.04, 0.02, 0.01, 0.005]) * 0.8
    errors = []
    for h in steps:
        result = lf.simulate(dzhanibekov(), 4.0, stepper(h))  # type: ignore[operator]
        assert result.steps == round(4.0 / h)
        errors.append([apart(result.q[-1, 3:], p), np.abs(result.u[-1, 3:] - omega).max()])
    assert_rate(steps, errors, 5.0, 0.5)


@pytest.mark.parametrize("stepper", [event_driven, smooth])
def test_runge_kutta_is_of_order_5_for_a_flexible_body(stepper: object) -> None:
    def end(h: float) -> tuple[FloatArray, float]:
        result = lf.simulate(flexible_flight(), 0.8, stepper(h))  # type: ignore[operator]
        energy = result.energies.kinetic + result.energies.elastic
        return np.concatenate([result.q[-1], result.u[-1]]), float(np.ptp(energy) / energy[0])

    exact, _ = end(0.0025)
    steps = np.array([0.04, 0.02, 0.01])
    ends = [end(h) for h in steps]
    assert_rate(steps, [np.abs(state - exact).max() for state, _ in ends], 5.0, 0.5)
    assert_rate(steps, [energy for _, energy in ends], 5.5, 1.0)


@pytest.mark.parametrize("rtol", [1e-6, 1e-8, 1e-10])
def test_errors_of_dzhanibekov_follow_the_tolerance(rtol: float) -> None:
    exact = exact_flight(8.0)(8.0)
    np.testing.assert_allclose(exact[4:], OMEGA_8, atol=6e-9)
    assert apart(exact[:4], P_8) < 6e-9
    for stepper in (lf.EventDriven(rtol=rtol), lf.Smooth(integrator=lf.ExplicitRungeKutta(rtol=rtol))):
        result = lf.simulate(dzhanibekov(), 8.0, stepper)
        assert np.abs(result.u[-1, 3:] - exact[4:]).max() < 50.0 * rtol
        assert apart(result.q[-1, 3:], exact[:4]) < 10.0 * rtol
        np.testing.assert_allclose(result.q[-1, :3], 8.0 * np.array([1.0, 2.0, 3.0]), rtol=1e-13)


@pytest.mark.parametrize(("method", "rtol", "most"), [(Radau, 1e-6, 1e-5), (Radau, 1e-8, 1e-7), (BDF, 1e-8, 1e-4)])
def test_stiff_methods_keep_to_their_tolerance(method: type, rtol: float, most: float) -> None:
    exact = exact_flight(4.0)(4.0)
    result = lf.simulate(dzhanibekov(), 4.0, lf.Smooth(integrator=lf.Stiff(rtol=rtol, method=method)), record=0.1)
    assert apart(result.q[-1, 3:], exact[:4]) < most
    assert np.abs(lengths(result) - 1.0).max() < 1e-14


def test_after_a_period_the_angular_velocity_is_what_it_was() -> None:
    result = lf.simulate(dzhanibekov(), PERIOD, lf.EventDriven(rtol=1e-11))
    np.testing.assert_allclose(result.u[-1, 3:], OMEGA, atol=2e-9)
    half = lf.simulate(dzhanibekov(), 0.5 * PERIOD, lf.EventDriven(rtol=1e-11))
    np.testing.assert_allclose(half.u[-1, 3:], np.array([-1.0, -1.0, 1.0]) * OMEGA, atol=2e-9)


def test_1e5_steps_keep_energy_both_momenta_and_the_length_of_quaternions() -> None:
    result = lf.simulate(dzhanibekov(), 50.0, event_driven(5e-4), record=0.5)
    assert result.steps >= 100_000
    np.testing.assert_allclose(result.energies.kinetic, result.energies.kinetic[0], rtol=1e-12)
    momenta = angular_momenta(result)
    np.testing.assert_allclose(momenta, np.tile(momenta[0], (len(momenta), 1)), atol=1e-11 * np.linalg.norm(momenta[0]))
    np.testing.assert_array_equal(result.u[:, :3], np.tile([1.0, 2.0, 3.0], (len(momenta), 1)))
    assert np.abs(lengths(result) - 1.0).max() < 1e-14


def test_verlet_is_of_order_2_as_its_kick_is_made_with_the_mean_velocity() -> None:
    p, omega = np.split(exact_flight(4.0)(4.0), [4])
    steps = np.array([0.01, 0.005, 0.0025])
    errors = []
    for h in steps:
        result = lf.simulate(dzhanibekov(), 4.0, lf.Smooth(integrator=lf.Verlet(h)))
        errors.append([apart(result.q[-1, 3:], p), np.abs(result.u[-1, 3:] - omega).max()])
        assert np.abs(lengths(result) - 1.0).max() < 1e-14
    assert_rate(steps, errors, 2.0, 0.3)


def test_states_between_dense_instants_are_as_good_as_those_at_them() -> None:
    exact = exact_flight(4.0)
    result = lf.simulate(dzhanibekov(), 4.0, lf.EventDriven(rtol=1e-8), record="dense")
    assert np.abs(lengths(result) - 1.0).max() < 1e-14
    for t in np.random.default_rng(3).uniform(0.0, 4.0, 40).tolist():
        state = result.at(t)
        assert abs(math.sqrt(float(state.q[3:] @ state.q[3:])) - 1.0) < 1e-14
        assert apart(state.q[3:], exact(t)[:4]) < 1e-7
        assert np.abs(state.u[3:] - exact(t)[4:]).max() < 2e-6
