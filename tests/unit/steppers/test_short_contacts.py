"""Contacts that last less than a step: adaptive schemes find them, as event-driven runs do."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from tests.scenes import grazing_disc

FINE = lf.AdaptiveStep(rtol=1e-10, atol=1e-11)
SCHEMES = [lf.MoreauJean, lf.GeneralizedAlpha]


def deflected(overlap: float) -> tuple[float, float]:
    """Velocity of the disc after the graze without friction, in metres: only that along the normal is reflected."""
    cos = (0.2 - overlap) / 0.2
    sin = math.sqrt(1.0 - cos * cos)
    return 1.0 - 1.5 * sin * sin, 1.5 * sin * cos


@pytest.mark.parametrize("overlap", [1e-4, 1e-6, 1e-8])
@pytest.mark.parametrize("scheme", SCHEMES)
def test_a_graze_is_found(scheme: Any, overlap: float) -> None:
    result = lf.simulate(grazing_disc(overlap), 1.0, scheme(step=1e-3, adaptive=FINE))
    assert result.u[-1, :2] == pytest.approx(deflected(overlap), abs=3e-7)
    assert result.u[-1, 1] == pytest.approx(deflected(overlap)[1], rel=1e-4)
    assert result.steps < 1000


@pytest.mark.parametrize("size", [1e3, 1e-3])
@pytest.mark.parametrize("scheme", SCHEMES)
def test_a_graze_is_found_in_other_units(scheme: Any, size: float) -> None:
    control = lf.AdaptiveStep(rtol=1e-10, atol=1e-11 * size)
    result = lf.simulate(
        grazing_disc(1e-5, size=size), 1.0, scheme(step=1e-3, adaptive=control, gap_tolerance=1e-9 * size)
    )
    assert result.u[-1, :2] / size == pytest.approx(deflected(1e-5), rel=1e-4)


@pytest.mark.parametrize("scheme", SCHEMES)
def test_a_graze_with_friction_is_that_of_an_event_driven_run(scheme: Any) -> None:
    exact = lf.simulate(grazing_disc(1e-6, friction=0.3), 1.0, lf.EventDriven())
    result = lf.simulate(grazing_disc(1e-6, friction=0.3), 1.0, scheme(step=1e-3, adaptive=FINE))
    np.testing.assert_allclose(result.u[-1], exact.u[-1], rtol=0.0, atol=3e-7)


@pytest.mark.parametrize("scheme", SCHEMES)
def test_a_near_miss_is_none(scheme: Any) -> None:
    result = lf.simulate(grazing_disc(-1e-6), 1.0, scheme(step=1e-3, adaptive=FINE))
    assert result.u[-1] == pytest.approx((1.0, 0.0, 0.0), abs=1e-12)


def tip(overlap: float, spin: float) -> lf.Scene:
    """A rod of 1 m turns about its end; its tip, a point, overlaps a free disc by ``overlap`` [m] at the first turn."""
    scene = lf.Scene(gravity=(0.0, 0.0))
    rod = scene.add(lf.RigidBody(mass=1.0, inertia=1.0 / 3.0), angular_velocity=spin)
    scene.join(lf.Revolute(rod.at(0, 0), scene.ground.at(0, 0)))
    disc = scene.add(lf.Disc(0.05, mass=1.0), position=(0.0, 1.05 - overlap))
    scene.contact(rod.node(1.0, 0.0), disc.surface(), restitution=0.5)
    return scene


def struck(overlap: float, spin: float) -> tuple[float, float]:
    """Rate of the rod and speed of the disc after the first impact."""
    distance = 1.05 - overlap
    angle = math.asin((1.0 + distance**2 - 0.05**2) / (2.0 * distance))  # of the rod, where tip and edge meet
    place = np.array([math.cos(angle), math.sin(angle)])
    normal = (np.array([0.0, distance]) - place) / 0.05
    arm = float(place[0] * normal[1] - place[1] * normal[0])
    impulse = 1.5 * spin * arm / (1.0 + 3.0 * arm * arm)
    return spin - 3.0 * arm * impulse, abs(impulse)


STEPPERS = [*(scheme(step=1e-3, adaptive=FINE) for scheme in SCHEMES), lf.EventDriven()]


@pytest.mark.parametrize("spin", [5.0, 40.0])
@pytest.mark.parametrize("overlap", [1e-4, 1e-6])
@pytest.mark.parametrize("stepper", STEPPERS, ids=["moreau", "alpha", "event-driven"])
def test_the_tip_of_a_rod_strikes_at_its_first_turn(stepper: Any, overlap: float, spin: float) -> None:
    result = lf.simulate(tip(overlap, spin), 2.0 / spin, stepper)
    rate, speed = struck(overlap, spin)
    assert result.u[-1, 2] == pytest.approx(rate, abs=1e-6 * spin)
    assert np.hypot(*result.u[-1, 3:5]) == pytest.approx(speed, rel=3e-4)


@pytest.mark.parametrize("scheme", SCHEMES)
def test_a_thin_wall_is_not_passed_by_long_steps(scheme: Any) -> None:
    scene = lf.Scene(gravity=(0.0, 0.0))
    disc = scene.add(lf.Disc(0.005, mass=0.01), position=(-0.5, 0.0), velocity=(100.0, 0.0))
    wall = scene.ground.chain([(0, -0.1), (0.002, -0.1), (0.002, 0.1), (0, 0.1)], closed=True)
    scene.contact(disc.surface(), wall, restitution=1.0)
    control = lf.AdaptiveStep(rtol=1e-6, atol=1e-8, longest=2e-3)
    result = lf.simulate(scene, 0.01, scheme(step=1e-3, adaptive=control))
    assert result.u[-1, 0] == pytest.approx(-100.0, rel=1e-9)
    assert result.q[-1, 0] == pytest.approx(-0.51, abs=1e-5)
