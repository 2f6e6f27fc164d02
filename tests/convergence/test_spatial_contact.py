"""Bodies that slide and roll in space under Moreau-Jean: errors against closed forms, and their order in the step."""

from __future__ import annotations

import math

import numpy as np

import lcpflex as lf

UP, FLOOR = (0.0, 0.0, 1.0), (0.0, 0.0, 0.0)
RADIUS = 0.028575  # of a billiard ball [m]


def billiard_ball() -> lf.SpatialScene:
    """A ball that slides on a curve and rolls from t = .420739889 s on."""
    scene = lf.SpatialScene()
    ball = scene.add(
        lf.Sphere(radius=RADIUS, mass=0.17),
        name="ball",
        position=(0.0, 0.0, RADIUS),
        velocity=(2.0, 0.0, 0.0),
        angular_velocity=(15.0, -30.0, 7.0),
    )
    scene.contact(ball.surface(), scene.ground.plane(FLOOR, UP), friction=0.2)
    return scene


def sliding_puck(degrees: float = 25.0) -> lf.SpatialScene:
    """Three feet in the plane of the mass centre, at 1 m/s across a slope with mu = tan(slope); -y is downhill."""
    slope = math.radians(degrees)
    scene = lf.SpatialScene(gravity=(0.0, -9.81 * math.sin(slope), -9.81 * math.cos(slope)))
    body = lf.SpatialBody(mass=1.0, inertia=np.diag([2.5e-3, 2.5e-3, 5e-3]))
    puck = scene.add(body, name="puck", velocity=(1.0, 0.0, 0.0))
    floor = scene.ground.plane(FLOOR, UP)
    for k in range(3):
        angle = 2.0 * math.pi * k / 3.0
        foot = puck.node((0.1 * math.cos(angle), 0.1 * math.sin(angle), 0.0))
        scene.contact(foot, floor, friction=math.tan(slope))
    return scene


def test_a_puck_across_a_slope_has_order_one() -> None:
    """S1: v = (.13577602, .49078244) m/s across and down at .3 s; the direction of friction turns."""
    steps, errors = (2e-3, 1e-3, 5e-4, 2.5e-4), []
    for step in steps:
        result = lf.simulate(sliding_puck(), 0.3, lf.MoreauJean(step=step), progress=False)
        errors.append(math.hypot(result.u[-1, 0] - 0.13577602, -result.u[-1, 1] - 0.49078244))
    order = float(np.polyfit(np.log(steps), np.log(errors), 1)[0])
    assert 0.95 < order < 1.05
    assert errors[1] < 1.3e-3


def test_a_billiard_ball_has_order_two_while_its_slip_keeps_its_direction() -> None:
    """S2: rolls with v = (1.18364286, -.12246429) m/s, and the spin about the normal stays 7 rad/s."""
    steps, errors, spins = (2e-3, 1e-3, 5e-4), [], []
    for step in steps:
        result = lf.simulate(billiard_ball(), 0.6, lf.MoreauJean(step=step), progress=False)
        errors.append(math.hypot(result.u[-1, 0] - 1.18364286, result.u[-1, 1] + 0.12246429))
        spins.append(abs(float(result.angular_velocity("ball")[-1, 2]) - 7.0))
    assert 1.8 < float(np.polyfit(np.log(steps), np.log(errors), 1)[0]) < 2.2
    assert 1.8 < float(np.polyfit(np.log(steps), np.log(spins), 1)[0]) < 2.2
    assert errors[1] < 1.5e-5
    assert spins[1] < 3e-4


def test_friction_is_the_same_in_all_directions() -> None:
    """A ball that is pushed into any direction over the floor is slowed down by the same force, against its slip."""
    found = []
    for angle in np.linspace(0.0, 2.0 * math.pi, 7):
        scene = lf.SpatialScene()
        velocity = (math.cos(angle), math.sin(angle), 0.0)
        ball = scene.add(lf.Sphere(radius=0.1, mass=1.0), position=(0.0, 0.0, 0.1), velocity=velocity)
        scene.contact(ball.surface(), scene.ground.plane(FLOOR, UP), friction=0.3)
        result = lf.simulate(scene, 0.05, lf.MoreauJean(step=1e-3), progress=False)
        force = result.force[-1, 0, 1:]
        found.append((-force @ np.array(velocity), float(np.linalg.norm(force))))
    along, size = np.array(found).T
    assert np.ptp(size) < 1e-8 * size.mean()
    assert np.abs(along / size - 1.0).max() < 1e-8
    assert abs(size.mean() / (0.3 * 9.81) - 1.0) < 1e-8
