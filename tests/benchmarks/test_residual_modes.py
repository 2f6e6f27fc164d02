"""A body with residual modes costs what its number of coordinates says: a step is that of as many free modes."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import pytest

import lcpflex as lf

BEAM = lf.Beam(0.7, 0.028, 0.005, density=2700.0, youngs_modulus=6.9e10)
FREE = 6  # and residual ones besides
STEPPERS = [
    pytest.param(lf.MoreauJean(step=1e-5), id="Moreau-Jean"),
    pytest.param(lf.GeneralizedAlpha(step=1e-5), id="generalised-alpha"),
]


def arm(residual: bool) -> lf.Scene:
    """A beam welded to a hub that swings, with residual modes at the weld, or with as many free modes more."""
    scene = lf.Scene()
    hub = scene.add(lf.Disc(radius=0.05, mass=1.0), "hub")
    beam = scene.add(BEAM, "arm", modes=FREE) if residual else scene.add(BEAM.reduce(FREE + 3), "arm")
    scene.join(lf.Revolute(hub.point("center"), scene.ground.at(0.0, 0.0)))
    scene.join(lf.Weld(beam.point("left"), hub.point("center")))
    return scene


def seconds_per_step(scene: lf.Scene, stepper: Any) -> float:
    result = lf.simulate(scene, 0.4, stepper, record=0.4, progress=False)
    assert result.modes_of("arm").columns.size == FREE + 3
    return result.wall_time / result.steps


@pytest.mark.parametrize("stepper", STEPPERS)
def test_a_step_costs_what_as_many_free_modes_cost(
    interleave: Callable[..., Mapping[str, float]], stepper: Any
) -> None:
    medians = interleave(
        {
            "6 free and 3 residual modes": partial(seconds_per_step, arm(residual=True), stepper),
            "9 free modes": partial(seconds_per_step, arm(residual=False), stepper),
        }
    )
    residual, free = medians.values()
    assert residual <= 1.05 * free
