"""Contact in space under generalised-alpha: errors against closed forms and references, and their order in the step."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import lcpflex as lf
from lcpflex.bodies.spatial.body import SpatialPoint
from lcpflex.bodies.spatial.shapes import SurfaceShape
from tests.spatial_bodies import random_body
from tests.spatial_flight import flexible_body

G = 9.81
UP, FLOOR = (0.0, 0.0, 1.0), (0.0, 0.0, 0.0)
RADIUS = 0.028575  # of a billiard ball [m]


def puck(slope: float, mu: float, spin: float = 0.0) -> lf.SpatialScene:
    """Three feet in the plane of the mass centre, at 1 m/s across a slope; -y is downhill."""
    scene = lf.SpatialScene(gravity=(0.0, -G * math.sin(slope), -G * math.cos(slope)))
    body = lf.SpatialBody(mass=1.0, inertia=np.diag([2.5e-3, 2.5e-3, 5e-3]))
    placed = scene.add(body, velocity=(1.0, 0.0, 0.0), angular_velocity=(0.0, 0.0, spin))
    floor = scene.ground.plane(FLOOR, UP)
    for k in range(3):
        angle = 2.0 * math.pi * k / 3.0
        scene.contact(placed.node((0.1 * math.cos(angle), 0.1 * math.sin(angle), 0.0)), floor, friction=mu)
    return scene


def box(slope: float, mu: float) -> lf.SpatialScene:
    """On its four corners."""
    scene = lf.SpatialScene(gravity=(0.0, -G * math.sin(slope), -G * math.cos(slope)))
    placed = scene.add(lf.Cuboid(0.2, 0.3, 0.4, mass=2.0), position=(0.0, 0.0, 0.2))
    scene.contact(placed.surface(), scene.ground.plane(FLOOR, UP), friction=mu)
    return scene


def run(scene: lf.SpatialScene, duration: float, step: float) -> lf.Result:
    return lf.simulate(scene, duration, lf.GeneralizedAlpha(step=step), progress=False)


def fitted(steps: list[float], errors: list[float]) -> float:
    return float(np.polyfit(np.log(steps), np.log(errors), 1)[0])


def test_a_puck_across_a_slope_has_order_two() -> None:
    """S1: v = (.13577602, .49078244) m/s across and down at .3 s; the direction of friction turns."""
    slope, steps, errors = math.radians(25.0), [4e-3, 2e-3, 1e-3], []
    for step in steps:
        u = run(puck(slope, math.tan(slope)), 0.3, step).u[-1]
        errors.append(math.hypot(u[0] - 0.13577602, -u[1] - 0.49078244))
    assert 1.9 < fitted(steps, errors) < 2.1
    assert errors[-1] < 2e-6


def test_a_billiard_ball_begins_to_roll() -> None:
    """S2: rolls with v = (1.18364286, -.12246429) m/s; the spin about the normal stays 7 rad/s to h^2."""
    steps, errors = [2e-3, 1e-3, 5e-4], []
    for step in steps:
        scene = lf.SpatialScene()
        ball = scene.add(
            lf.Sphere(RADIUS, mass=0.17),
            name="ball",
            position=(0.0, 0.0, RADIUS),
            velocity=(2.0, 0.0, 0.0),
            angular_velocity=(15.0, -30.0, 7.0),
        )
        scene.contact(ball.surface(), scene.ground.plane(FLOOR, UP), friction=0.2)
        result = run(scene, 0.6, step)
        errors.append(math.hypot(result.u[-1, 0] - 1.18364286, result.u[-1, 1] + 0.12246429))
        assert abs(float(result.angular_velocity("ball")[-1, 2]) - 7.0) < 2.5e3 * step**2
        change = 0.17 * (result.u[-1, :3] - result.u[0, :3])
        assert np.allclose(result.impulse[-1, 0, 1:], change, rtol=0.0, atol=1e-13)
    assert 1.8 < fitted(steps, errors) < 2.2
    assert errors[1] < 3e-5


def test_a_three_legged_puck_slides_and_spins_to_rest() -> None:
    """R4: slip of all three feet ends at one time, in as many directions."""
    result = run(puck(0.0, 0.2, 10.0), 0.7, 1e-3)
    angle = Rotation.from_quat(result.q[-1, [4, 5, 6, 3]]).as_rotvec()[2]
    assert np.allclose(result.q[-1, :2], (0.3221555, 0.0040920), rtol=0.0, atol=2e-7)
    assert abs(angle - 2.6321765) < 1e-5
    assert np.abs(result.u[-1]).max() < 1e-13
    assert not result.warnings
    assert result.energies.relative_remainder < 1e-5


def test_a_box_below_the_angle_of_friction_does_not_drift() -> None:
    """Over 10 s; four corners share the load in many ways."""
    result = run(box(math.radians(20.0), 0.5), 10.0, 5e-3)
    assert np.abs(result.q[-1, :3] - (0.0, 0.0, 0.2)).max() < 1e-14
    assert np.abs(result.q[-1, 4:7]).max() < 1e-14


def test_a_box_above_the_angle_of_friction_slides_exactly() -> None:
    slope, mu = math.radians(35.0), 0.5
    result = run(box(slope, mu), 1.0, 1e-3)
    down = 0.5 * G * (math.sin(slope) - mu * math.cos(slope))
    assert abs(result.q[-1, 1] + down) < 1e-12
    assert np.abs(result.q[-1, 4:7]).max() < 1e-13


def test_a_bouncing_ball_comes_to_rest_where_newtons_law_has_it() -> None:
    """e = .5: the height of the second flight is e^2 times the first, to the order of the step; then it rests."""
    scene, steps, errors = lf.SpatialScene(), [2e-3, 1e-3, 5e-4], []
    ball = scene.add(lf.Sphere(0.1, mass=1.0), position=(0.0, 0.0, 1.1), velocity=(0.3, 0.2, 0.0))
    scene.contact(ball.surface(), scene.ground.plane(FLOOR, UP), restitution=0.5)
    fall = math.sqrt(2.0 / G)
    for step in steps:
        result = run(scene, 2.0, step)
        second = (result.times > fall) & (result.times < 2.0 * fall)
        errors.append(abs(float(result.q[second, 2].max()) - 0.1 - 0.25))
        assert np.allclose(result.q[-1, :3], (0.6, 0.4, 0.1), rtol=0.0, atol=1e-12)
        assert abs(result.impulse[-1, 0, 0] - 2.0 * G) < 1e-11
    assert max(error / step for error, step in zip(errors, steps, strict=True)) < 3.0


def test_a_tumbling_box_comes_to_rest_with_its_energy_and_momentum_accounted_for() -> None:
    scene = lf.SpatialScene()
    placed = scene.add(
        lf.Cuboid(0.2, 0.3, 0.4, mass=2.0),
        position=(0.0, 0.0, 0.5),
        velocity=(0.5, 0.2, 0.0),
        angular_velocity=(3.0, 1.0, 2.0),
    )
    scene.contact(scene.ground.plane(FLOOR, UP), placed.surface(), friction=0.3, restitution=0.4)
    result = run(scene, 2.0, 1e-3)
    assert np.abs(result.u[-1]).max() < 1e-12
    assert np.allclose(result.impulse[-1, 0], (4.0 * G, 1.0, 0.4, 0.0), rtol=0.0, atol=1e-10)  # on the ground
    assert result.energies.relative_remainder < 1e-3


def test_friction_is_the_same_in_all_directions() -> None:
    found = []
    for angle in np.linspace(0.0, 2.0 * math.pi, 7):
        velocity = (math.cos(angle), math.sin(angle), 0.0)
        scene = lf.SpatialScene()
        ball = scene.add(lf.Sphere(radius=0.1, mass=1.0), position=(0.0, 0.0, 0.1), velocity=velocity)
        scene.contact(ball.surface(), scene.ground.plane(FLOOR, UP), friction=0.3)
        force = run(scene, 0.05, 1e-3).force[-1, 0, 1:]
        found.append((-force @ np.array(velocity), float(np.linalg.norm(force))))
    along, size = np.array(found).T
    assert np.ptp(size) < 1e-8 * size.mean()
    assert np.abs(along / size - 1.0).max() < 1e-8
    assert abs(size.mean() / (0.3 * G) - 1.0) < 1e-8


def test_jointed_balls_that_slide_have_order_two() -> None:
    """Two balls on a ball joint with different friction, against event-driven steps."""

    def scene() -> lf.SpatialScene:
        scene = lf.SpatialScene()
        floor = scene.ground.plane(FLOOR, UP)
        balls = []
        for x, mu in ((0.0, 0.2), (0.3, 0.4)):
            ball = scene.add(lf.Sphere(0.1, mass=1.0), position=(x, 0.0, 0.1), velocity=(2.0, 1.0, 0.0))
            scene.contact(ball.surface(), floor, friction=mu)
            balls.append(ball)
        scene.join(lf.Ball(balls[0].at(0.15, 0.0, 0.0), balls[1].at(-0.15, 0.0, 0.0)))
        return scene

    exact = lf.simulate(scene(), 0.1, lf.EventDriven(rtol=1e-11, atol=1e-12), progress=False).u[-1]
    steps, errors = [4e-3, 2e-3, 1e-3], []
    for step in steps:
        errors.append(float(np.abs(run(scene(), 0.1, step).u[-1] - exact).max()))
    assert 1.8 < fitted(steps, errors) < 2.2
    assert errors[-1] < 1e-4


def test_a_flexible_body_that_slides_has_order_two() -> None:
    """On one of its points, which shakes, against event-driven steps."""
    given = random_body(np.random.default_rng(7), 3, centred=True)
    turns = 0.3 * np.random.default_rng(1).normal(size=(3, 3))
    points = {"foot": SpatialPoint(given.places[0], given.shapes[:, 0], turns)}
    body = flexible_body(given, stiffness=400.0 * (1.0 + np.arange(3)), damping=np.ones(3), points=points)
    scene = lf.SpatialScene()
    placed = scene.add(body, position=-given.places[0], velocity=(1.0, 0.5, 0.0))
    scene.contact(placed.node("foot"), scene.ground.plane(FLOOR, UP), friction=0.1)
    exact = lf.simulate(scene, 0.1, lf.EventDriven(rtol=1e-10, atol=1e-11), progress=False).u[-1]
    steps, errors = [2e-3, 1e-3, 5e-4], []
    for step in steps:
        result = run(scene, 0.1, step)
        errors.append(float(np.abs(result.u[-1] - exact).max()))
        assert result.energies.relative_remainder < 0.1 * step**2
    assert 1.9 < fitted(steps, errors) < 2.1
    assert errors[-1] < 3e-6


def overhanging(beyond: float) -> lf.SpatialScene:
    """A box on the edge of a block that is held, its mass centre ``beyond`` the edge [m], turned by .3 rad about z."""
    scene = lf.SpatialScene()
    block = scene.add(lf.Cuboid(1.0, 1.0, 1.0, mass=1e3), position=(-0.5, 0.0, -0.5))
    scene.join(lf.Weld(block.at(0.0, 0.0, 0.0), scene.ground.at(-0.5, 0.0, -0.5)))
    turn = Rotation.from_rotvec([0.0, 0.0, 0.3])
    box = scene.add(lf.Cuboid(0.4, 0.2, 0.1, mass=1.0), "box", position=(beyond, 0.0, 0.05), orientation=turn)
    scene.contact(box.surface(), block.surface(), friction=0.6, name="edge")
    return scene


@pytest.mark.parametrize("step", [1e-3, 2.5e-4])
@pytest.mark.parametrize("beyond", [1e-5, 3e-4])
def test_a_box_tips_over_an_edge_as_soon_as_its_mass_centre_is_beyond(beyond: float, step: float) -> None:
    """Crossings of edges that begin in one corner are contacts of their own, with loads of their own."""
    truth = lf.simulate(overhanging(beyond), 0.5, lf.EventDriven(), progress=False)
    result = run(overhanging(beyond), 0.5, step)
    tilt = result.orientation("box")[-1].as_matrix()[:, 2]
    expected = truth.orientation("box")[-1].as_matrix()[:, 2]
    assert np.linalg.norm(expected[:2]) > 100.0 * beyond
    np.testing.assert_allclose(tilt, expected, atol=1e-3 * float(np.linalg.norm(expected[:2])))


def test_a_box_at_rest_over_an_edge_is_carried_by_its_weight() -> None:
    result = run(overhanging(-1e-3), 0.05, 1e-3)
    np.testing.assert_allclose(result.contact("edge").normal_force[5:], G, rtol=1e-9)


def corner() -> SurfaceShape:
    """A floor and a wall of one piece, that meet in the line x = z = 0."""
    outline = np.array([(0.0, 0.0), (1.0, 0.0), (1.0, -0.2), (-0.2, -0.2), (-0.2, 1.0), (0.0, 1.0)])
    vertices = np.array([(x, y, z) for y in (-0.5, 0.5) for x, z in outline])
    ends = [(0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 5)]
    sides = [t for a in range(6) for b in ((a + 1) % 6,) for t in ((a, a + 6, b + 6), (a, b + 6, b))]
    triangles = np.array([*ends, *((c + 6, b + 6, a + 6) for a, b, c in ends), *sides])
    return SurfaceShape(vertices, triangles[:, ::-1], np.zeros((12, 0, 3)))


@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_a_ball_in_a_corner_is_free_to_leave_the_wall(friction: float) -> None:
    """Pulled off by F: x = F t^2 / 2 m, and of one that rolls 5/7 of that. The floor's load is none of the wall."""
    pull = 0.01
    scene = lf.SpatialScene(gravity=(0.0, 0.0, -G))
    body = scene.add(lf.SpatialBody(mass=100.0, inertia=10.0 * np.eye(3), shape=corner()))
    scene.join(lf.Weld(body.at(0.0, 0.0, 0.0), scene.ground.at(0.0, 0.0, 0.0)))
    ball = scene.add(lf.Sphere(0.05, mass=1.0), "ball", position=(0.05, 0.013, 0.05))
    scene.contact(ball.surface(), body.surface(), friction=friction, name="corner")
    scene.load(lf.Force(ball.at(0.0, 0.0, 0.0), (pull, 0.0, 0.0)))
    result = run(scene, 0.1, 2e-4)
    moved = result.point("ball", (0.0, 0.0, 0.0))[-1, 0] - 0.05
    assert abs(moved - 0.5 * pull * 0.1**2 * (5.0 / 7.0 if friction else 1.0)) < 1e-12
    np.testing.assert_allclose(result.contact("corner").normal_force[5:], G, rtol=1e-9)
