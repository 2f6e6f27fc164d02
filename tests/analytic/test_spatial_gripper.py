"""A box between two fingers that rise: what the ground and the fingers hold together cannot all be held any more.

At rest the ground and the fingers share the weight in many ways. From the first instant at which the hand gets faster
the ground can no longer be touched without slip at the fingers, and the box leaves it.
"""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest

import lcpflex as lf

MASS, FRICTION, GRAVITY = 0.5, 0.4, 9.81
START, TIME, SPEED = 0.05, 0.2, 0.1  # of the lift: begins [s], takes [s], mean speed [m/s]
NEEDED = MASS * GRAVITY / (2.0 * FRICTION)  # to hold the box at rest [N]


def height(t: float) -> float:
    """Of the hand, which begins and ends to rise without a jump of its acceleration [m]."""
    s = min(max(t - START, 0.0), TIME)
    rate = 2.0 * math.pi / TIME
    return SPEED * (s - math.sin(rate * s) / rate)


def gripped(force: float) -> lf.SpatialScene:
    """A box on the ground, and round fingers in a hand, each pressed to it with ``force`` [N]."""
    scene, up = lf.SpatialScene(gravity=(0.0, 0.0, -GRAVITY)), (0.0, 0.0, 1.0)
    box = scene.add(lf.Cuboid(0.06, 0.06, 0.06, mass=MASS), name="box", position=(0.0, 0.0, 0.03))
    hand = scene.add(lf.Cuboid(0.2, 0.05, 0.03, mass=1.0), name="hand", position=(0.0, 0.0, 0.1))
    rail = scene.ground.at(0.0, 0.0, 0.1)
    scene.join(lf.Prismatic(hand.point("center"), rail, axis=up))
    scene.join(lf.DrivenDisplacement(hand.point("center"), rail, height, up))
    scene.contact(box.surface(), scene.ground.plane((0.0, 0.0, 0.0), up), friction=0.3, name="floor")
    for name, sign in (("left", -1.0), ("right", 1.0)):
        x = sign * 0.04
        finger = scene.add(lf.Sphere(0.01, mass=0.1), name=name, position=(x, 0.0, 0.03))
        scene.join(lf.Prismatic(finger.point("center"), hand.at(x, 0.0, -0.07), axis=(1.0, 0.0, 0.0)))
        scene.load(lf.Force(finger.point("center"), (-sign * force, 0.0, 0.0)))
        scene.contact(finger.surface(), box.surface(), friction=FRICTION, name=name)
    return scene


def slip_of(force: float) -> float:
    """How far the hand gets ahead: vdot = g + a - 2 mu N / m while v > 0 or that is positive, v before the box [m]."""
    times = np.linspace(0.0, TIME, 200_001)
    rate = 2.0 * math.pi / TIME
    excess = SPEED * rate * np.sin(rate * times) + GRAVITY - 2.0 * FRICTION * force / MASS
    step, v, slip = times[1], 0.0, 0.0
    for first, last in pairwise(excess):
        new = max(v + 0.5 * step * (first + last), 0.0)
        slip += 0.5 * step * (v + new)
        v = new
    rest = 2.0 * FRICTION * force / MASS - GRAVITY
    return slip + 0.5 * v * v / rest


@pytest.mark.parametrize("share", [1.15, 1.25, 1.4])
def test_a_box_leaves_the_ground_with_the_hand_that_holds_it(share: float) -> None:
    result = lf.simulate(gripped(share * NEEDED), 0.4, lf.EventDriven())
    left = next(event.time for event in result.events if event.kind == "lift-off" and event.contact == "floor")
    assert START - 1e-6 <= left < START + 1e-3
    ahead = height(0.4) - (result.point("box", "center")[-1, 2] - 0.03)
    assert ahead == pytest.approx(slip_of(share * NEEDED), abs=2e-6)
    assert result.penetration.max() < 1e-6
    assert not result.found_wrong


def test_a_hand_that_moves_aside_drags_the_box_over_the_ground() -> None:
    """The box sticks to fingers and ground; the fingers are held, and friction of the ground is mu m g from then on."""
    scene = lf.SpatialScene(gravity=(0.0, 0.0, -GRAVITY))
    box = scene.add(lf.Cuboid(0.06, 0.06, 0.06, mass=MASS), name="box", position=(0.0, 0.0, 0.03))
    scene.contact(box.surface(), scene.ground.plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0)), friction=0.3, name="floor")
    for name, sign in (("left", -1.0), ("right", 1.0)):
        place = (sign * 0.04, 0.0, 0.03)
        finger = scene.add(lf.Sphere(0.01, mass=0.1), name=name, position=place)
        tied = scene.ground.at(*place)
        carriage = scene.add(lf.Sphere(0.005, mass=0.1), name=f"{name} carriage", position=place)
        scene.join(lf.Prismatic(carriage.point("center"), tied, axis=(0.0, 1.0, 0.0)))
        scene.join(lf.DrivenDisplacement(carriage.point("center"), tied, height, (0.0, 1.0, 0.0)))
        scene.join(lf.Prismatic(finger.point("center"), carriage.point("center"), axis=(1.0, 0.0, 0.0)))
        scene.load(lf.Force(finger.point("center"), (-sign * 20.0, 0.0, 0.0)))
        scene.contact(finger.surface(), box.surface(), friction=FRICTION, name=name)
    result = lf.simulate(scene, 0.2, lf.EventDriven())
    assert result.point("box", "center")[-1, 1] == pytest.approx(height(0.2), abs=2e-6)
    dragged = (result.times > START + 0.02) & (result.times < 0.19)
    friction = np.linalg.norm(result.contact("floor").friction_force[dragged], axis=1)
    pressed = result.contact("floor").normal_force[dragged]
    np.testing.assert_allclose(friction, 0.3 * pressed, rtol=1e-6)
    assert not result.found_wrong


@pytest.mark.filterwarnings("ignore:mesh. its stiffness:lcpflex.ModelWarning")  # coarse: rest is exact on any mesh
def test_a_soft_finger_on_a_wall_comes_to_rest() -> None:
    """What swings dies out, and then nothing moves: no step is larger than those before it."""
    rubber = {"density": 1100.0, "youngs_modulus": 2e6, "poissons_ratio": 0.45}
    solid = lf.Solid.box((0.03, 0.024, 0.024), elements=(3, 2, 2), **rubber)
    body = solid.reduce(modes=4, interfaces=["left"], contact="right", damping=lf.Rayleigh(0.0, 2e-3))
    scene = lf.SpatialScene(gravity=(0.0, 0.0, -GRAVITY))
    finger = scene.add(body, name="finger")
    root = finger.point("left")
    scene.join(lf.Prismatic(root, scene.ground.at(-0.015, 0.0, 0.0), axis=(1.0, 0.0, 0.0)))
    scene.load(lf.Force(root, (lf.Table([0.0, 0.1], [0.0, 6.0]), 0.0, 0.0)))
    wall = scene.ground.plane((0.015, 0.0, 0.0), (-1.0, 0.0, 0.0))
    scene.contact(finger.face("right"), wall, friction=0.5, points="nodes")
    result = lf.simulate(scene, 1.5, lf.MoreauJean(step=2e-3, solver_tolerance=1e-12), progress=False)
    ways = np.abs(np.diff(result.q, axis=0)).max(axis=1)
    parts = [ways[(result.times[1:] > t) & (result.times[1:] <= t + 0.1)].max() for t in np.arange(0.2, 1.2, 0.1)]
    assert all(later < before for before, later in pairwise(parts))
    assert ways[-1] < 1e-15
