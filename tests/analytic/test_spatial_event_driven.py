"""Event-driven contact in space against closed forms and converged references (g = 9.81 m/s^2)."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import lcpflex as lf

G = 9.81
ALPHA = math.radians(25.0)


def puck(
    slope: float,
    mu: float,
    velocity: tuple[float, float, float],
    spin: float = 0.0,
) -> lf.SpatialScene:
    """A puck on three feet in the plane of its mass centre; -y points down the slope."""
    scene = lf.SpatialScene(gravity=(0.0, -G * math.sin(slope), -G * math.cos(slope)))
    radius = 0.1
    body = scene.add(
        lf.SpatialBody(mass=1.0, inertia=np.diag([0.25, 0.25, 0.5]) * radius**2),
        velocity=velocity,
        angular_velocity=(0.0, 0.0, spin),
    )
    floor = scene.ground.plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    for k in range(3):
        angle = 2.0 * math.pi * k / 3.0
        foot = body.node((radius * math.cos(angle), radius * math.sin(angle), 0.0))
        scene.contact(foot, floor, friction=mu)
    return scene


def on_incline(t: float) -> tuple[float, float]:
    """Velocity across and down of a puck with v0 = 1 across, mu = tan(slope): |v| + v_down = 1 throughout."""
    low, high = 0.0, 0.5
    for _ in range(200):
        down = 0.5 * (low + high)
        passed = (0.5 * down - 0.25 * math.log1p(-2.0 * down)) / (G * math.sin(ALPHA))
        low, high = (down, high) if passed < t else (low, down)
    return math.sqrt((1.0 - down) ** 2 - down**2), down


def test_a_puck_that_slides_across_an_incline() -> None:
    """S1: the direction of slip turns; the closed form gives the tabulated (.13577602, .49078244) at .3 s."""
    exact = on_incline(0.3)
    assert np.allclose(exact, (0.13577602, 0.49078244), rtol=0.0, atol=6e-9)
    result = lf.simulate(puck(ALPHA, math.tan(ALPHA), (1.0, 0.0, 0.0)), 0.3, lf.EventDriven(), record=0.3)
    assert result.u[-1, 0] == pytest.approx(exact[0], abs=1e-8)
    assert -result.u[-1, 1] == pytest.approx(exact[1], abs=1e-8)


def test_the_order_of_sliding_is_that_of_the_integrator() -> None:
    """Errors over fixed steps fall with order 5; no step is bounded by the slip yet."""
    exact = on_incline(0.1)
    steps, errors = [0.01, 0.005, 0.0025], []
    for step in steps:
        stepper = lf.EventDriven(rtol=1.0, atol=1.0, max_step=step, first_step=step)
        result = lf.simulate(puck(ALPHA, math.tan(ALPHA), (1.0, 0.0, 0.0)), 0.1, stepper, record=0.1)
        errors.append(abs(result.u[-1, 0] - exact[0]) + abs(-result.u[-1, 1] - exact[1]))
    order = np.polyfit(np.log(steps), np.log(errors), 1)[0]
    assert 4.3 < order < 6.5


@pytest.mark.parametrize("threshold", [1e-3, 1e-4, 1e-5])
def test_slip_ends_early_by_the_threshold_over_its_rate(threshold: float) -> None:
    """A puck on the level stops at v0 / (mu g), seen early by v_s / (mu g); v_s is a hundredth of what is given."""
    stepper = lf.EventDriven(velocity_threshold=threshold)
    result = lf.simulate(puck(0.0, 0.2, (0.6, 0.8, 0.0)), 0.6, stepper, record=0.6)
    stuck = [event.time for event in result.events if event.kind == "stick"]
    rate = 0.2 * G
    assert len(stuck) == 3
    assert 1.0 / rate - max(stuck) == pytest.approx(1e-2 * threshold / rate, rel=2e-3)
    assert np.abs(result.u[-1]).max() < 1e-13


def test_a_ball_that_slides_and_spins_begins_to_roll() -> None:
    """S2: rolls from .420739889 s, straight on from there; spin about the normal stays."""
    scene, radius = lf.SpatialScene(), 0.028575
    ball = scene.add(
        lf.Sphere(radius, mass=0.17),
        position=(0.0, 0.0, radius),
        velocity=(2.0, 0.0, 0.0),
        angular_velocity=(15.0, -30.0, 7.0),
    )
    scene.contact(ball.surface(), scene.ground.plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0)), friction=0.2)
    result = lf.simulate(scene, 0.6, lf.EventDriven(), record=0.6)
    (event,) = result.events
    assert event.kind == "stick"
    assert event.time == pytest.approx(0.420739889, abs=2e-8)
    assert np.allclose(result.u[-1, :3], (1.18364286, -0.12246429, 0.0), rtol=0.0, atol=2e-8)
    turned = Rotation.from_quat(result.q[-1, [4, 5, 6, 3]])
    assert turned.apply(result.u[-1, 3:])[2] == pytest.approx(7.0, abs=1e-6)
    change = 0.17 * (result.u[-1, :3] - result.u[0, :3])
    assert np.allclose(np.asarray(result.impulse)[-1, 0, 1:], change, rtol=0.0, atol=1e-8)


def test_a_three_legged_puck_slides_and_spins_to_rest() -> None:
    """R4: slip of all three feet ends at one time, in as many directions."""
    result = lf.simulate(puck(0.0, 0.2, (1.0, 0.0, 0.0), 10.0), 0.7, lf.EventDriven(), record=0.7)
    angle = Rotation.from_quat(result.q[-1, [4, 5, 6, 3]]).as_rotvec()[2]
    assert max(event.time for event in result.events) == pytest.approx(0.6129201, abs=1e-7)
    assert np.allclose(result.q[-1, :2], (0.3221555, 0.0040920), rtol=0.0, atol=1e-7)
    assert angle == pytest.approx(2.6321765, abs=1e-7)


def test_slip_that_turns_back_neither_sticks_nor_chatters() -> None:
    """Up an incline steeper than the friction angle and down again: slip goes through zero."""
    slope, mu = math.radians(30.0), 0.2
    result = lf.simulate(puck(slope, mu, (0.0, 1.0, 0.0)), 1.0, lf.EventDriven(), record=0.5)
    up, down = G * (math.sin(slope) + mu * math.cos(slope)), G * (math.sin(slope) - mu * math.cos(slope))
    late = 1.0 - 1.0 / up
    assert result.u[-1, 1] == pytest.approx(-down * late, abs=2e-8)
    assert result.q[-1, 1] == pytest.approx(0.5 / up - 0.5 * down * late**2, abs=2e-8)
    assert not any(event.kind == "stick" for event in result.events)


def test_a_ball_bounces_at_the_times_of_newtons_law() -> None:
    """Bounces of e = .5 follow each other as t0 (1 + 2 (e + e^2 + ...)), and end."""
    scene, radius, e = lf.SpatialScene(), 0.1, 0.5
    ball = scene.add(lf.Sphere(radius, mass=1.0), position=(0.0, 0.0, radius + 1.0), velocity=(0.3, 0.2, 0.0))
    scene.contact(ball.surface(), scene.ground.plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0)), restitution=e)
    result = lf.simulate(scene, 2.0, lf.EventDriven(), record=2.0)
    first = math.sqrt(2.0 / G)
    times = [event.time for event in result.events if event.kind == "impact"]
    for n in range(10):
        assert times[n] == pytest.approx(first * (1.0 + 2.0 * sum(e**k for k in range(1, n + 1))), abs=1e-12)
    assert np.allclose(result.q[-1, :3], (0.6, 0.4, radius), rtol=0.0, atol=1e-9)


@pytest.mark.parametrize("degrees", [20.0, 25.0, 35.0])
def test_a_box_on_an_incline_sticks_or_slides(degrees: float) -> None:
    """Four corners share the load in many ways; below the friction angle the box does not move but by rounding."""
    slope, mu = math.radians(degrees), 0.5
    scene = lf.SpatialScene(gravity=(0.0, -G * math.sin(slope), -G * math.cos(slope)))
    box = scene.add(lf.Cuboid(0.2, 0.3, 0.4, mass=2.0), position=(0.0, 0.0, 0.2))
    scene.contact(box.surface(), scene.ground.plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0)), friction=mu)
    result = lf.simulate(scene, 1.0, lf.EventDriven(), record=1.0)
    down = 0.5 * G * max(0.0, math.sin(slope) - mu * math.cos(slope))
    assert result.q[-1, 1] == pytest.approx(-down, abs=1e-12)
    assert np.abs(result.q[-1, 4:7]).max() < 1e-13


@pytest.mark.parametrize("impact", [lf.Newton(), lf.Poisson()])
def test_a_tumbling_box_comes_to_rest_with_its_energy_accounted_for(impact: lf.Newton | lf.Poisson) -> None:
    """Impacts of one corner after the other, with friction: momentum is that of the impulses, energy does not grow."""
    scene = lf.SpatialScene()
    box = scene.add(
        lf.Cuboid(0.2, 0.3, 0.4, mass=2.0),
        position=(0.0, 0.0, 0.5),
        velocity=(0.5, 0.2, 0.0),
        angular_velocity=(3.0, 1.0, 2.0),
    )
    floor = scene.ground.plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    scene.contact(floor, box.surface(), friction=0.3, restitution=0.4)
    result = lf.simulate(scene, 2.0, lf.EventDriven(impact=impact), record=2.0)
    assert np.abs(result.u[-1]).max() < 1e-12
    sums = np.asarray(result.impulse)[-1, 0]  # on the ground, which was declared first
    assert sums[0] == pytest.approx(2.0 * G * 2.0, rel=1e-8)
    assert np.allclose(sums[1:], (1.0, 0.4, 0.0), rtol=0.0, atol=1e-8)


def test_stronges_law_is_refused() -> None:
    """With two tangents it is not integrated."""
    with pytest.raises(lf.ModelError, match=r"impact: Stronge.*spatial scene, expected Newton\(\) or Poisson\(\)"):
        lf.simulate(puck(0.0, 0.2, (1.0, 0.0, 0.0)), 0.1, lf.EventDriven(impact=lf.Stronge()))
