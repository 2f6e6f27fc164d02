"""Spheres on cylinders in space against closed forms (g = 9.81 m/s^2)."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp
from scipy.spatial.transform import Rotation

import lcpflex as lf

G = 9.81
RADIUS, BALL = 1.0, 0.1
RING, HEIGHT, MARBLE = 0.3, 0.4, 0.05  # of a column that stands on its end, and of what rolls on it
START = 0.1


def hill(mu: float = 0.0, carried: bool = False, along: float = 0.0) -> lf.SpatialScene:
    """A ball on a lying cylinder, ``START`` off its highest line; that is a body that is welded where it is carried."""
    scene, path = lf.SpatialScene(gravity=(0.0, 0.0, -G)), RADIUS + BALL
    if carried:
        turn = Rotation.from_euler("x", 90.0, degrees=True)
        log = scene.add(lf.Cylinder(RADIUS, 4.0, mass=5.0), "log", orientation=turn)
        scene.join(lf.Weld(log.at(0.0, 0.0, 0.0), scene.ground.at(0.0, 0.0, 0.0)))
        surface = log.surface()
    else:
        surface = scene.ground.cylinder((0.0, 0.0, 0.0), (0.0, -2.0, 0.0), RADIUS, 4.0)
    place = (path * math.sin(START), 0.0, path * math.cos(START))
    ball = scene.add(lf.Sphere(BALL, mass=1.0), "ball", position=place, velocity=(0.0, along, 0.0))
    scene.contact(ball.surface(), surface, friction=mu, name="contact")
    return scene


def time_to(angle: float, share: float = 1.0) -> float:
    """When it is there, with omega^2 = share 2 g (cos START - cos angle) / path; slow at first: angle = START + s^2."""

    def slowness(s: float) -> float:
        fall = 2.0 * math.sin(START + 0.5 * s * s) * math.sin(0.5 * s * s)
        return 2.0 * s / math.sqrt(share * 2.0 * G / (RADIUS + BALL) * fall)

    return float(quad(slowness, 0.0, math.sqrt(angle - START), epsabs=1e-14)[0])


def angle_of(q: Any) -> float:
    return math.atan2(q[-7], q[-5])


def times(result: lf.Result, kind: str) -> list[float]:
    return [event.time for event in result.events if event.kind == kind]


@pytest.mark.parametrize(("carried", "along"), [(False, 0.0), (False, 0.7), (True, 0.0)])
def test_a_ball_leaves_a_smooth_lying_cylinder_where_two_thirds_of_its_height_are_left(
    carried: bool, along: float
) -> None:
    result = lf.simulate(hill(0.0, carried, along), 1.3, lf.EventDriven(), record=0.01)
    expected = time_to(math.acos(2.0 / 3.0 * math.cos(START)))
    assert times(result, "lift-off") == pytest.approx([expected], abs=1e-8)
    assert result.energies.relative_remainder < 5e-9


def test_a_ball_rolls_down_a_cylinder_with_five_sevenths_of_the_pull() -> None:
    result = lf.simulate(hill(1.0), 0.8, lf.EventDriven(), record=0.1)
    for k in range(1, 9):
        assert time_to(angle_of(result.q[k]), 5.0 / 7.0) == pytest.approx(result.times[k], abs=1e-8)
    assert abs(result.energies.friction[-1]) < 1e-10


@pytest.mark.parametrize("scheme", [lf.MoreauJean, lf.GeneralizedAlpha])
def test_fixed_steps_slide_down_a_cylinder_with_order_two(scheme: Any) -> None:
    errors = []
    for step in (2e-3, 1e-3, 5e-4):
        result = lf.simulate(hill(), 0.9, scheme(step))
        errors.append(abs(time_to(angle_of(result.q[-1])) - 0.9))
    assert errors[-1] < 2e-6
    assert np.log2(np.array(errors[:-1]) / errors[1:]) == pytest.approx([2.0, 2.0], abs=0.1)


def column(speed: float, friction: float, spin: float) -> lf.SpatialScene:
    """A marble on the end of a standing cylinder, on its way to the rim."""
    scene = lf.SpatialScene(gravity=(0.0, 0.0, -G))
    solid = scene.ground.cylinder((0.0, 0.0, -0.5 * HEIGHT), (0.0, 0.0, 1.0), RING, HEIGHT)
    marble = scene.add(
        lf.Sphere(MARBLE, mass=1.0),
        position=(0.1, 0.0, MARBLE),
        velocity=(speed, 0.0, 0.0),
        angular_velocity=(0.0, spin, 0.0),
    )
    scene.contact(marble.surface(), solid, friction=friction, name="contact")
    return scene


def over_the_rim(speed: float, share: float = 1.0) -> Any:
    """Angle and its rate as a function of the time from the rim: theta'' = share g sin theta / MARBLE."""
    rate = share * G / MARBLE
    return solve_ivp(
        lambda t, y: [y[1], rate * math.sin(y[0])],
        (0.0, 1.0),
        [0.0, speed / MARBLE],
        rtol=1e-12,
        atol=1e-13,
        dense_output=True,
        events=lambda t, y: math.cos(y[0]) - 2.0 / 3.0 - speed**2 / (3.0 * G * MARBLE),
    )


@pytest.mark.parametrize("speed", [0.3, 0.5])
def test_a_marble_slides_over_the_rim_and_leaves_it_without_losing_energy(speed: float) -> None:
    result = lf.simulate(column(speed, 0.0, 0.0), 1.0, lf.EventDriven(), record=0.01)
    expected = (RING - 0.1) / speed + over_the_rim(speed).t_events[0][0]
    assert times(result, "lift-off") == pytest.approx([expected], abs=2e-9)
    assert result.energies.relative_remainder < 1e-9
    assert result.energies.impact[-1] == 0.0


def test_a_marble_rolls_over_the_rim_as_about_an_edge() -> None:
    speed = 0.3
    result = lf.simulate(column(speed, 2.0, speed / MARBLE), 0.75, lf.EventDriven(), record=0.01)
    path = over_the_rim(speed, 5.0 / 7.0).sol
    reached = (RING - 0.1) / speed
    behind = np.flatnonzero(result.times > reached)
    assert len(behind) > 5
    for k in behind:
        angle = path(result.times[k] - reached)[0]
        expected = [RING + MARBLE * math.sin(angle), 0.0, MARBLE * math.cos(angle)]
        np.testing.assert_allclose(result.q[k, :3], expected, atol=1e-9)
    assert result.energies.impact[-1] == 0.0
    assert abs(result.energies.friction[-1]) < 1e-10
    assert result.energies.relative_remainder < 5e-9


@pytest.mark.parametrize(("scheme", "order"), [(lf.MoreauJean, 1.0), (lf.GeneralizedAlpha, 1.0)])
def test_fixed_steps_roll_over_the_rim_and_lose_less_with_shorter_steps(scheme: Any, order: float) -> None:
    speed, duration = 0.3, 0.75
    angle = over_the_rim(speed, 5.0 / 7.0).sol(duration - (RING - 0.1) / speed)[0]
    expected = np.array([RING + MARBLE * math.sin(angle), 0.0, MARBLE * math.cos(angle)])
    errors, losses = [], []
    for step in (1e-3, 2.5e-4):
        result = lf.simulate(column(speed, 2.0, speed / MARBLE), duration, scheme(step))
        kinetic, potential = result.energies.kinetic, result.energies.potential
        errors.append(float(np.abs(result.q[-1, :3] - expected).max()))
        losses.append(abs(float((kinetic + potential)[-1] - (kinetic + potential)[0])))
    assert errors[1] < 4.0**-order * errors[0]
    assert losses[1] < 4.0**-order * losses[0]
    assert losses[0] < 1e-4


@pytest.mark.parametrize("stepper", [lf.EventDriven(), lf.MoreauJean(1e-3), lf.GeneralizedAlpha(1e-3)])
@pytest.mark.parametrize("place", [0.0, 0.2, RING])
def test_a_ball_stays_balanced_on_the_end_of_a_column_and_carries_its_weight(stepper: Any, place: float) -> None:
    """In the middle, where no direction leads away from the axis, and on the border of the rim as well."""
    scene = lf.SpatialScene(gravity=(0.0, 0.0, -G))
    solid = scene.add(lf.Cylinder(RING, HEIGHT, mass=1.0), "column", position=(0.0, 0.0, -0.5 * HEIGHT))
    scene.join(lf.Weld(solid.at(0.0, 0.0, 0.0), scene.ground.at(0.0, 0.0, -0.5 * HEIGHT)))
    ball = scene.add(lf.Sphere(0.1, mass=2.0), position=(place, 0.0, 0.1))
    scene.contact(solid.surface(), ball.surface(), friction=0.5, name="contact")
    result = lf.simulate(scene, 0.3, stepper)
    np.testing.assert_allclose(result.q[:, -7:-4], np.tile([place, 0.0, 0.1], (len(result.times), 1)), atol=1e-12)
    assert result.contact("contact").normal_force[-1] == pytest.approx(2.0 * G, abs=1e-8)


ROD, HALF = 0.05, 0.4  # radius of a capsule and half of the length between its ends
LYING, UPRIGHT = (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)


def rod_on(axis: tuple[float, float, float], start: Any = (0.0, 0.0), velocity: Any = (0.0, 0.0, 0.0), mu: float = 0.4):
    """A capsule along x that lies on a cylinder, whose highest place is at z = 0."""
    scene = lf.SpatialScene(gravity=(0.0, 0.0, -G))
    height = 0.5 * HEIGHT if axis == UPRIGHT else RING
    solid = scene.ground.cylinder((0.0, 0.0, -height), axis, RING, HEIGHT)
    rod = scene.add(
        lf.Capsule(ROD, 2.0 * HALF, mass=2.0),
        position=(*start, ROD),
        orientation=Rotation.from_euler("y", 90.0, degrees=True),
        velocity=velocity,
    )
    scene.contact(rod.surface(), solid, friction=mu, name="contact")
    return scene


@pytest.mark.parametrize("stepper", [lf.EventDriven(), lf.MoreauJean(1e-3), lf.GeneralizedAlpha(1e-3)])
@pytest.mark.parametrize(
    ("axis", "start"),
    [(UPRIGHT, (0.0, 0.0)), (UPRIGHT, (0.05, 0.1)), (LYING, (0.0, 0.0)), ((1.0, 0.0, 0.0), (0.05, 0.0))],
)
def test_a_capsule_rests_on_an_end_across_and_along_a_cylinder(stepper: Any, axis: Any, start: Any) -> None:
    result = lf.simulate(rod_on(axis, start), 0.3, stepper)
    np.testing.assert_allclose(result.q, np.tile(result.q[0], (len(result.times), 1)), atol=1e-14)
    assert result.contact("contact").normal_force[-1] == pytest.approx(2.0 * G, abs=1e-8)


@pytest.mark.parametrize(
    ("axis", "start", "velocity", "way"),
    [
        (UPRIGHT, (0.0, 0.07), (0.8, 0.0, 0.0), math.sqrt(RING**2 - 0.07**2)),  # over an end, to the rim
        (LYING, (0.0, 0.0), (0.0, 0.3, 0.0), 0.5 * HEIGHT),  # across the side, over the rim
        ((1.0, 0.0, 0.0), (0.0, 0.0), (0.8, 0.0, 0.0), 0.5 * HEIGHT),  # along the side, until that ends
    ],
)
def test_a_capsule_slides_off_a_smooth_cylinder_with_all_of_its_energy(
    axis: Any, start: Any, velocity: Any, way: float
) -> None:
    """Its mass centre goes straight on as long as there is something below it; then all steppers agree."""
    exact = lf.simulate(rod_on(axis, start, velocity, 0.0), 1.0, lf.EventDriven(), record=0.01)
    straight = exact.times < 0.99 * way / max(velocity)
    gone = np.outer(exact.times[straight], velocity)
    np.testing.assert_allclose(exact.q[straight, :3] - exact.q[0, :3], gone, atol=1e-9)
    assert exact.energies.relative_remainder < 5e-9
    assert abs(exact.energies.impact[-1]) < 1e-9
    assert times(exact, "lift-off")
    for scheme in (lf.MoreauJean, lf.GeneralizedAlpha):
        errors = []
        for step in (1e-3, 2.5e-4):
            result = lf.simulate(rod_on(axis, start, velocity, 0.0), 1.0, scheme(step))
            errors.append(float(np.abs(result.q[-1, :3] - exact.q[-1, :3]).max()))
        assert errors[0] < 5e-5
        assert errors[1] < 2e-5


@pytest.mark.parametrize("friction", [0.0, 0.5])
@pytest.mark.parametrize("body", [lf.Sphere(0.1, mass=1.0), lf.Capsule(0.1, 0.6, mass=1.0)])
@pytest.mark.parametrize("aim", [(0.1, 0.05, 0.1), (0.0, 0.25, 0.5), (0.1, 0.1, -0.6), (0.05, -0.2, 0.3)])
def test_what_strikes_a_free_cylinder_keeps_all_momenta(aim: Any, body: lf.SpatialBody, friction: float) -> None:
    """From several sides, on a cylinder that spins; with the energy where there is no friction."""
    scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
    log = scene.add(lf.Cylinder(0.3, 1.0, mass=2.0), "log", angular_velocity=(0.4, -0.3, 0.5))
    way = np.array([1.5, 0.7, -0.4])
    rod = scene.add(
        body,
        "rod",
        position=np.array(aim) - way,
        orientation=Rotation.from_rotvec([0.3, 0.9, 0.2]),
        velocity=2.0 * way,
        angular_velocity=(0.5, -1.0, 2.0),
    )
    scene.contact(log.surface(), rod.surface(), friction=friction, restitution=1.0)
    result = lf.simulate(scene, 1.0, lf.EventDriven(), record=0.01)
    assert "impact" in {event.kind for event in result.events}
    momentum = result.momentum()
    for values in (momentum.linear, momentum.angular):
        np.testing.assert_allclose(values, np.tile(values[0], (len(values), 1)), atol=1e-8)
    if friction == 0.0:
        np.testing.assert_allclose(result.energies.kinetic, result.energies.kinetic[0], rtol=1e-8)


def test_a_capsule_rocks_on_a_lying_cylinder() -> None:
    """It rolls: (J + m (rho^2 + R^2 a^2)) a'' + m R^2 a a'^2 + m g (R a cos a - rho sin a) = 0 of its slope a."""
    scene, rate = lf.SpatialScene(gravity=(0.0, 0.0, -G)), 2.0
    solid = scene.ground.cylinder((0.0, 0.0, -RING), LYING, RING, HEIGHT)
    body = lf.Capsule(ROD, 2.0 * HALF, mass=2.0)
    turn = Rotation.from_euler("y", 90.0, degrees=True)
    place = (0.0, 0.1, ROD)
    rod = scene.add(body, "rod", place, turn, velocity=(ROD * rate, 0.0, 0.0), angular_velocity=(0.0, rate, 0.0))
    scene.contact(solid, rod.surface(), friction=1.0, name="contact")
    J, m = float(body.inertia[0, 0]), 2.0

    def slope(t: float, y: Any) -> list[float]:
        a, b = y
        pull = m * RING**2 * a * b * b + m * G * (RING * a * math.cos(a) - ROD * math.sin(a))
        return [b, -pull / (J + m * (ROD**2 + RING**2 * a * a))]

    exact = solve_ivp(slope, (0.0, 2.0), [0.0, rate], rtol=1e-12, atol=1e-12, dense_output=True).sol
    result = lf.simulate(scene, 2.0, lf.EventDriven(), record=0.1)
    for t, q in zip(result.times, result.q, strict=True):
        a = exact(t)[0]
        n, along = np.array([math.sin(a), 0.0, math.cos(a)]), np.array([math.cos(a), 0.0, -math.sin(a)])
        expected = (RING + ROD) * n - RING * a * along + [0.0, 0.1, -RING]
        np.testing.assert_allclose(q[:3], expected, atol=2e-8)
    assert np.abs(exact(result.times)[0]).max() > 0.3
    assert abs(result.energies.friction[-1]) < 1e-9
