"""Heaps of balls that fall into a box and roll on each other: islands of many contacts, with joints and without."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import lcpflex as lf
from tests.benchmarks.sphere_chart import loose, of_lcpflex

STEP = 1e-3
RADIUS = 0.1


def places(layers: int) -> np.ndarray:
    """(9 layers, 3) balls in layers of nine, a little out of line, that nearly touch."""
    rng = np.random.default_rng(2)
    k = np.arange(9 * layers)
    layer, rest = np.divmod(k, 9)
    row, column = np.divmod(rest, 3)
    grid = np.column_stack([column, row, layer]) * 0.202 + 0.101
    grid[:, 2] *= 0.995
    return grid + 0.0009 * rng.uniform(-1.0, 1.0, grid.shape) * [1.0, 1.0, 0.0]


def heap(layers: int, joints: int = 0) -> lf.SpatialScene:
    """The first ``2 joints`` balls of the lowest layers in pairs on ball joints, four walls and a floor."""
    scene = lf.SpatialScene()
    wall = 0.606
    for point, normal in (
        ((0, 0, 0), (0, 0, 1)), ((0, 0, 0), (1, 0, 0)), ((wall, 0, 0), (-1, 0, 0)), ((0, 0, 0), (0, 1, 0)),
        ((0, wall, 0), (0, -1, 0)),
    ):  # fmt: skip
        scene.ground.plane(point, normal)
    at = places(layers)
    balls = [scene.add(lf.Sphere(radius=RADIUS, mass=1.0), position=place) for place in at]
    for j in range(joints):
        one, two = balls[2 * j], balls[2 * j + 1]
        half = 0.5 * (at[2 * j + 1] - at[2 * j])
        scene.join(lf.Ball(one.at(*half), two.at(*-half)))
    scene.contact_all(friction=0.5)
    return scene


@pytest.mark.parametrize("joints", [0, 4])
def test_every_step_of_a_collapsing_heap_is_solved(joints: int) -> None:
    """To the tolerance of a run, in natural-map form; bodies on joints stay together."""
    result = lf.simulate(heap(4, joints), 0.2, lf.MoreauJean(step=STEP), record=0.05, progress=False)
    assert not [warning for warning in result.warnings if "not solved" in warning]
    assert result.residual.max() <= 1e-9
    at = result.q[-1].reshape(36, 7)
    for j in range(joints):
        turned = Rotation.from_quat(at[2 * j : 2 * j + 2, 3:], scalar_first=True)
        half = 0.5 * (places(4)[2 * j + 1] - places(4)[2 * j])
        ends = at[2 * j : 2 * j + 2, :3] + turned.apply([half, -half])
        assert np.abs(ends[1] - ends[0]).max() < 1e-11
    speed = result.u[-1].reshape(36, 6)[:, :3]
    assert 1e-3 < np.abs(speed).max() < 5.0


@pytest.mark.slow
def test_spheres_that_pile_up_are_solved_well_within_a_small_budget() -> None:
    """128 of them, 20 factors a step: typically 1e-4 of the free velocity, and overlaps by one step of falling."""
    point = of_lcpflex(*loose(128), steps=500, budget=20)
    assert point.residual <= 5e-4
    assert point.overlap <= 2.5e-3
