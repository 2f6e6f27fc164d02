"""A billiard ball on a floor that gives way, under regularised friction: what it misses, by orders and constants.

The slip of the ball keeps its direction e. With the arm a = R - d/2 of friction (d = m g / K the indentation), and
k = 1 + m a^2 / J, the slip speed s obeys s' = -k mu g tanh(s / v_s), so that sinh(s / v_s) falls exponentially. Where
the ball of Coulomb begins to roll (s_0 - k mu g t = 0) it still slips at v_s arsinh(1/2), and from then on it is ahead
of that one by pi^2 v_s^2 / (12 k^2 mu g) along e. What it rolls with does not depend on the law of friction at all.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from tests.rates import assert_rate

laws = lf.laws
RADIUS, MASS, MU, G = 0.028575, 0.17, 0.2, 9.81
VELOCITY, SPIN = np.array([2.0, 0.0, 0.0]), np.array([15.0, -30.0, 7.0])
ROLLING, ROLLS_AT = (1.18364286, -0.12246429), 0.420739889  # on a floor that does not give way
SPEEDS = np.array([0.08, 0.04, 0.02, 0.01])  # v_s [m/s]


class Coulomb:
    """The motion under Coulomb's law with friction at the arm a."""

    def __init__(self, arm: float) -> None:
        slip = VELOCITY + np.cross(SPIN, [0.0, 0.0, -arm])
        self.speed = float(np.linalg.norm(slip))
        self.along = slip / self.speed
        self.k = 1.0 + arm**2 / (0.4 * RADIUS**2)
        self.rolls_at = self.speed / (self.k * MU * G)
        self.velocity = VELOCITY - self.speed / self.k * self.along

    def place(self, t: float) -> Any:
        """Behind the beginning of rolling."""
        early = self.rolls_at
        return VELOCITY * early - 0.5 * MU * G * early**2 * self.along + self.velocity * (t - early)


def ball(stiffness: float, friction: Any, duration: float, rtol: float = 1e-9) -> lf.Result:
    """Struck while it rests on a floor of that stiffness."""
    scene = lf.SpatialScene()
    one = scene.add(
        lf.Sphere(RADIUS, mass=MASS),
        name="ball",
        position=(0.0, 0.0, RADIUS - MASS * G / stiffness),
        velocity=VELOCITY,
        angular_velocity=SPIN,
    )
    floor = scene.ground.plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    law = lf.ContactLaw(laws.PowerLaw(stiffness, 1.0), None, friction)
    scene.contact(one.surface(), floor, friction=MU, law=law, name="cloth")
    return lf.simulate(scene, duration, lf.Smooth(integrator=lf.ExplicitRungeKutta(rtol=rtol)), record=duration)


def test_the_reference_is_that_of_a_rigid_floor() -> None:
    rigid = Coulomb(RADIUS)
    assert rigid.rolls_at == pytest.approx(ROLLS_AT, abs=1e-9)
    assert rigid.velocity[:2] == pytest.approx(ROLLING, abs=1e-8)


def test_what_regularised_friction_misses_has_its_order_and_its_constant() -> None:
    stiffness = 1e6
    exact = Coulomb(RADIUS - 0.5 * MASS * G / stiffness)
    slips, ahead = [], []
    for speed in SPEEDS:
        early = ball(stiffness, laws.SmoothedCoulomb(float(speed)), exact.rolls_at)
        late = ball(stiffness, laws.SmoothedCoulomb(float(speed)), 0.6)
        slips.append((early.u[-1, :3] - exact.velocity) @ exact.along)
        ahead.append((late.q[-1, :3] - exact.place(0.6)) @ exact.along)
        assert np.abs(late.u[-1, :2] - exact.velocity[:2]).max() < 5e-9
        assert late.angular_velocity("ball")[-1, 2] == pytest.approx(SPIN[2], abs=5e-9)
    assert_rate(SPEEDS, slips, 1.0, 1e-4)
    np.testing.assert_allclose(slips, SPEEDS * math.asinh(0.5) / exact.k, rtol=1e-5)
    assert_rate(SPEEDS, ahead, 2.0, 1e-4)
    np.testing.assert_allclose(ahead, (math.pi * SPEEDS) ** 2 / (12.0 * exact.k**2 * MU * G), rtol=1e-5)


@pytest.mark.parametrize(
    "friction",
    [laws.SmoothedCoulomb(0.01), laws.BrownMcPhee(0.01, static_friction=0.3), laws.LuGre(), laws.Bristle()],
    ids=lambda law: type(law).__name__,
)
def test_whatever_the_friction_it_rolls_alike(friction: Any) -> None:
    """Its moment of momentum about the place of friction is kept."""
    exact = Coulomb(RADIUS - 0.5 * MASS * G / 1e6)
    result = ball(1e6, friction, 0.6)
    assert np.abs(result.u[-1, :2] - exact.velocity[:2]).max() < 2e-8
    assert result.angular_velocity("ball")[-1, 2] == pytest.approx(SPIN[2], abs=2e-8)


def test_the_floor_comes_to_a_rigid_one_as_its_compliance() -> None:
    stiffnesses = np.array([1e5, 1e6, 1e7])
    missed = [ball(k, laws.SmoothedCoulomb(0.01), 0.6).u[-1, :2] - Coulomb(RADIUS).velocity[:2] for k in stiffnesses]
    assert_rate(stiffnesses, np.linalg.norm(missed, axis=1), -1.0, 1e-3)


def test_a_law_with_bristles_begins_with_a_shock_that_goes_with_its_damping() -> None:
    """From straight bristles at slip v the impulse is that of Coulomb and mu N (sigma_1 - mu / v) / sigma_0 more."""
    speed, until = 1.0, 0.03
    for stiffness, damping in ((1e5, 30.0), (1e5, 3.0), (1e4, 0.0)):
        scene = lf.SpatialScene()
        point = lf.SpatialPoint(np.array([0.0, 0.0, -0.5 * G / 1e5]), np.zeros((0, 3)), np.zeros((0, 3)))
        body = lf.SpatialBody(mass=1.0, inertia=1e3 * np.eye(3), points={"foot": point})
        block = scene.add(body, position=(0.0, 0.0, -0.5 * G / 1e5), velocity=(0.6 * speed, 0.8 * speed, 0.0))
        law = lf.ContactLaw(laws.PowerLaw(1e5, 1.0), None, laws.LuGre(stiffness=stiffness, damping=damping))
        floor = scene.ground.plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0))
        scene.contact(block.node("foot"), floor, friction=0.3, law=law)
        result = lf.simulate(scene, until, lf.Smooth(integrator=lf.ExplicitRungeKutta(rtol=1e-9)), record=until)
        lost = speed - result.u[-1, :2] @ [0.6, 0.8]
        shock = 0.3 * G * (damping - 0.3 / speed) / stiffness
        assert lost - 0.3 * G * until == pytest.approx(shock, rel=2e-2)
        assert result.u[-1, :2] @ [-0.8, 0.6] == pytest.approx(0.0, abs=1e-9)
