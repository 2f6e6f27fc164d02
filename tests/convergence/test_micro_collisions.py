"""Micro-collisions of a flexible pendulum: their number, impulse and peak as modes and contact nodes are added."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import lcpflex as lf
from lcpflex.gallery.acceptance.measures import separate_contacts
from lcpflex.gallery.mechanisms.strikers import pendulum_on_hemisphere, strip_with_patch
from tests.rates import assert_rate

PARTED = 1e-5  # [s]


def strike(modes: int, fine: float = 5e-4, duration: float = 2.5e-4, step: float = 2e-7) -> lf.Result:
    stepper = lf.MasslessBoundary(step=step, dynamic_modes=modes)
    result = lf.simulate(pendulum_on_hemisphere(strip_with_patch(fine), modes), duration, stepper, record=step)
    assert result.energies.relative_remainder < 2e-4
    return result


def peak(result: lf.Result) -> float:
    return result.contact("hemisphere").peak_force


def impulse(result: lf.Result) -> float:
    return float(result.impulse[-1, 0, 0])


def test_fall_is_that_of_a_rigid_bar_with_a_ripple() -> None:
    # Shi, Hong & Liu 2013: by the rigid estimate, the tip falls at 1.4618 m/s at 0.1 s
    strip = lf.Beam(0.7, 0.028, 0.005, density=2700.0, youngs_modulus=6.9e10).reduce(modes=6)
    scene = lf.Scene()
    bar = scene.add(strip, name="bar")
    scene.join(lf.Revolute(bar.point("left"), scene.ground.at(0.0, 0.0)))
    result = lf.simulate(scene, 0.1, lf.EventDriven(rtol=1e-7, atol=1e-9), record=1e-4)
    rigid = solve_ivp(
        lambda t, y: (y[1], -1.5 * 9.81 / 0.7 * math.cos(y[0])),
        (0.0, 0.1),
        (0.0, 0.0),
        rtol=1e-10,
        atol=1e-12,
        t_eval=np.minimum(result.times, 0.1),
    )
    estimate = 0.7 * rigid.y[1] * np.cos(rigid.y[0])
    assert estimate[-1] == pytest.approx(-1.4618, abs=1e-4)
    ripple = (result.velocity("bar", "right")[:, 1] - estimate) / 1.4618
    assert abs(ripple.mean()) < 0.01
    assert 0.01 < np.abs(ripple).max() < 0.1
    assert np.count_nonzero(np.diff(np.sign(ripple[1:]))) > 4


@pytest.mark.slow
def test_three_contacts_and_a_peak_of_the_order_of_500_newtons() -> None:
    result = strike(160, duration=1.5e-3)
    assert len(separate_contacts(result, PARTED)) == 3
    assert 350.0 < peak(result) < 750.0


@pytest.mark.slow
def test_number_impulse_and_peak_converge_as_modes_are_added() -> None:
    results = {modes: strike(modes) for modes in (10, 20, 40, 80, 160, 320)}
    number = {modes: len(separate_contacts(result, PARTED)) for modes, result in results.items()}
    rich = results.pop(320)
    off = {modes: abs(impulse(result) / impulse(rich) - 1.0) for modes, result in results.items()}
    high = {modes: abs(peak(result) / peak(rich) - 1.0) for modes, result in results.items()}
    assert (number[10], number[20]) == (1, 2)
    assert number[80] == number[160] == number[320] == 3
    assert min(high[10], high[20]) > 0.2
    assert high[160] < 0.1
    assert_rate(list(off), list(off.values()), -2.5, within=1.0)


@pytest.mark.slow
def test_number_impulse_and_peak_converge_as_contact_nodes_are_added() -> None:
    results = [strike(160, fine) for fine in (1e-3, 5e-4, 2.5e-4, 1.25e-4)]
    assert [len(separate_contacts(result, PARTED)) for result in results[1:]] == [3, 3, 3]
    assert impulse(results[-2]) == pytest.approx(impulse(results[-1]), rel=2e-3)
    assert peak(results[-2]) == pytest.approx(peak(results[-1]), rel=0.02)


@pytest.mark.slow
def test_contact_nodes_with_mass_make_the_same_collisions() -> None:
    massless = strike(160)
    scene = pendulum_on_hemisphere(strip_with_patch(), 160)
    heavy = lf.simulate(scene, 2.5e-4, lf.MoreauJean(step=2e-8), record=1e-7)
    assert len(separate_contacts(heavy, PARTED)) == 3
    assert impulse(heavy) == pytest.approx(impulse(massless), rel=5e-3)


@pytest.mark.slow
def test_the_step_changes_little() -> None:
    coarse, fine = strike(160), strike(160, step=1e-7)
    assert impulse(coarse) == pytest.approx(impulse(fine), rel=1e-3)
    assert peak(coarse) == pytest.approx(peak(fine), rel=5e-3)
