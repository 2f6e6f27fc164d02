"""Steps of a rigid box on four and eight frictional contacts beside free ones: 4 to 9 and 9 to 14 us, 0.9 us."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

import lcpflex as lf

STEP = 1e-3


def seconds_per_step(scene: lf.SpatialScene) -> float:
    duration = 5000 * STEP
    result = lf.simulate(scene, duration, lf.MoreauJean(step=STEP), record=duration, progress=False)
    return float(result.wall_time / result.steps)


def flying() -> lf.SpatialScene:
    scene = lf.SpatialScene()
    scene.add(lf.Cuboid(0.3, 0.2, 0.1, mass=2.0), angular_velocity=(0.3, 1.0, 0.2))
    return scene


def standing(contacts: int, friction: float, speed: float = 0.0) -> lf.SpatialScene:
    """A box on small spheres in a circle, which slides and spins at ``speed`` [m/s] and ten times as many rad/s."""
    scene = lf.SpatialScene()
    ground = scene.ground.plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    box = scene.add(
        lf.Cuboid(0.3, 0.2, 0.1, mass=2.0),
        "box",
        (0.0, 0.0, 0.05),
        velocity=(speed, 0.3 * speed, 0.0),
        angular_velocity=(0.0, 0.0, 10.0 * speed),
    )
    for k in range(contacts):
        angle = 2.0 * math.pi * (k + 0.5) / contacts
        foot = box.sphere((0.1 * math.cos(angle), 0.1 * math.sin(angle), -0.04), 0.01)
        scene.contact(foot, ground, friction=friction)
    return scene


def test_contacts_cost_a_few_free_steps(interleave: Callable[..., Mapping[str, float]]) -> None:
    scenes = {
        "free": flying(),
        "rest": standing(4, 0.5),
        "slide": standing(4, 0.02, 3.0),
        "eight at rest": standing(8, 0.5),
        "eight slide": standing(8, 0.02, 3.0),
    }
    medians = interleave({name: (lambda scene=scene: seconds_per_step(scene)) for name, scene in scenes.items()})
    assert medians["rest"] <= 6.0 * medians["free"]
    assert medians["slide"] <= 15.0 * medians["free"]
    assert medians["eight at rest"] <= 2.4 * medians["rest"]
    assert medians["eight slide"] <= 2.4 * medians["slide"]
