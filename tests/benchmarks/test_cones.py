"""A rigid box on four and eight frictional contacts: 2.2 and 3.9 us a step at rest, 6 and 15 sliding; free .63."""

from __future__ import annotations

import itertools
import math
import time
from collections.abc import Callable, Mapping
from typing import Any

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
    assert medians["rest"] <= 4.2 * medians["free"]
    assert medians["slide"] <= 15.0 * medians["free"]
    assert medians["eight at rest"] <= 2.4 * medians["rest"]
    assert medians["eight slide"] <= 2.4 * medians["slide"]


def packed(side: int, height: float) -> lf.SpatialScene:
    """side^3 spheres in a cubic packing that fills a box with five walls, ``height`` above its floor [m]."""
    scene, radius = lf.SpatialScene(), 0.1
    width = 2.0 * radius * side
    for point, normal in (
        ((0, 0, 0), (0, 0, 1)), ((0, 0, 0), (1, 0, 0)), ((width, 0, 0), (-1, 0, 0)), ((0, 0, 0), (0, 1, 0)),
        ((0, width, 0), (0, -1, 0)),
    ):  # fmt: skip
        scene.ground.plane(point, normal)
    spread = 1.0 if height == 0.0 else 0.95
    for x, y, z in itertools.product(range(side), repeat=3):
        place = [radius * (1 + 2 * k) for k in (x, y, z)]
        scene.add(lf.Sphere(radius=spread * radius, mass=1.0), position=(place[0], place[1], place[2] + height))
    scene.contact_all(friction=0.5)
    return scene


def test_spheres_at_rest_cost_a_few_falling_ones(interleave: Callable[..., Mapping[str, float]]) -> None:
    """1000 spheres with 3200 contacts in one island, warm: 5 ms, and certified; as many that fall freely 0.7 ms."""
    runs = {
        name: lf.MoreauJean(step=STEP, solver_tolerance=1e-6).start(packed(10, height).compiled().system(), 1e3, 1e3)
        for name, height in (("rest", 0.0), ("fall", 5.0))
    }

    def seconds(run: Any) -> float:
        begun = time.process_time()
        assert not run.advance(20)
        return (time.process_time() - begun) / 20

    for run in runs.values():
        assert not run.advance(10)
    medians = interleave({name: (lambda run=run: seconds(run)) for name, run in runs.items()})
    counts = runs["rest"].records.recorder.counts
    assert counts.unsolved == 0.0
    assert counts.worst_relative <= 1e-6
    assert medians["rest"] <= 20.0 * medians["fall"]
