"""A step of reduced solids that many nodes carry costs what these are, not what their meshes or samples are."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import pytest

import lcpflex as lf

STEEL: dict[str, Any] = {"density": 7800.0, "youngs_modulus": 2.1e11, "poissons_ratio": 0.3}
STEP = 4e-7
CHEAPER = 3.0  # than the unreduced mesh, at least
DEARER = 1.5  # by areas than by nodes, at most; with all of their samples in each step: 2.5
pytestmark = pytest.mark.filterwarnings("ignore::lcpflex.ModelWarning")


def pressed(reduced: bool) -> lf.SpatialScene:
    """A block pressed on a plane with its 36 nodes below: 20 modes and what these nodes need, or the whole mesh."""
    solid = lf.Solid.box((0.02, 0.02, 0.01), elements=(5, 5, 6), **STEEL)
    made = solid.reduce(20, 0.3, contact="bottom", rows="normal") if reduced else solid.reduce(None, 0.3)
    scene = lf.SpatialScene(gravity=(0.0, 0.0, -1e5))
    block = scene.add(made, "block", position=(0.0, 0.0, 0.005))
    scene.contact(block.surface(), scene.ground.plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0)), name="below")
    return scene


def seconds_per_step(scene: lf.SpatialScene) -> float:
    result = lf.simulate(scene, 250 * STEP, lf.MoreauJean(step=STEP), record=250 * STEP, progress=False)
    assert result.contact("below").normal_force[-1] > 0.0
    return result.wall_time / result.steps


def test_a_step_costs_a_part_of_that_of_the_mesh(interleave: Callable[..., Mapping[str, float]]) -> None:
    medians = interleave(
        {
            "20 modes and 36 nodes": partial(seconds_per_step, pressed(reduced=True)),
            "the unreduced mesh": partial(seconds_per_step, pressed(reduced=False)),
        },
        rounds=5,
    )
    reduced, whole = medians.values()
    assert CHEAPER * reduced <= whole


def flush(points: str) -> lf.SpatialScene:
    """A block pressed on an equal one, which lies on a plane: 144 nodes and 20 modes each."""
    solid = lf.Solid.box((0.022, 0.022, 0.01), elements=(11, 11, 4), **STEEL)
    made = solid.reduce(20, 0.3)
    scene = lf.SpatialScene(gravity=(0.0, 0.0, -1e5))
    lower = scene.add(made, "lower", position=(0.0, 0.0, 0.005))
    upper = scene.add(made, "upper", position=(0.0, 0.0, 0.015))
    scene.contact(lower.face("bottom"), scene.ground.plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0)), points="nodes")
    scene.contact(upper.face("bottom"), lower.face("top"), points=points, friction=0.3, name="below")
    return scene


def test_areas_cost_little_more_than_nodes(interleave: Callable[..., Mapping[str, float]]) -> None:
    medians = interleave({points: partial(seconds_per_step, flush(points)) for points in ("areas", "nodes")}, rounds=5)
    assert medians["areas"] <= DEARER * medians["nodes"]
