"""Steps of free spatial bodies against those of a free planar one: 0.88 us rigid, 1.6 us with 8 modes, 0.74 us."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

import lcpflex as lf
from tests.spatial_bodies import as_body, random_body

STEP = 1e-3


def seconds_per_step(scene: lf.Scene | lf.SpatialScene) -> float:
    duration = 50000 * STEP
    result = lf.simulate(scene, duration, lf.MoreauJean(step=STEP), record=duration, progress=False)
    return float(result.wall_time / result.steps)


def in_space(body: lf.SpatialBody) -> lf.SpatialScene:
    scene = lf.SpatialScene()
    scene.add(body, angular_velocity=(0.3, 1.0, 0.2))
    return scene


def test_space_costs_little_more_than_the_plane(interleave: Callable[..., Mapping[str, float]]) -> None:
    plane = lf.Scene()
    plane.add(lf.Disc(radius=0.1, mass=1.0), angular_velocity=3.0)
    rigid = in_space(lf.SpatialBody(mass=1.0, inertia=np.diag([1.0, 2.0, 2.5])))
    flexible = in_space(as_body(random_body(np.random.default_rng(0), 8, centred=True)))
    medians = interleave(
        {
            "plane": lambda: seconds_per_step(plane),
            "rigid": lambda: seconds_per_step(rigid),
            "8 modes": lambda: seconds_per_step(flexible),
        }
    )
    assert medians["rigid"] <= 1.6 * medians["plane"]
    assert medians["8 modes"] <= 3.2 * medians["plane"]
