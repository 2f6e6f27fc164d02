"""Seams of flush bodies: what slides over one, or along both bodies, is not caught by the sides that meet at it.

Where a body is in the plane of those sides, and in that of the faces, which of both it touches is rounding. Starts and
steps are such that it is there at the end of a step.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import lcpflex as lf

ANGLES = 2.0 * math.pi * np.arange(40) / 40
BODIES: dict[str, Any] = {
    "box": lf.Cuboid(0.1, 0.1, 0.1, mass=1.0),
    "prism": lf.ConvexHull(
        [(0.05 * math.cos(a), 0.05 * math.sin(a), z) for a in ANGLES for z in (-0.05, 0.05)], mass=1.0
    ),
    "can": lf.Cylinder(0.05, 0.1, mass=1.0),
}


@pytest.mark.parametrize("name", BODIES)
@pytest.mark.parametrize("start", [-0.15, -0.15 - 1e-15, -0.1])
@pytest.mark.parametrize("step", [1e-3, 2e-4])
def test_what_slides_over_a_seam_of_two_boxes_goes_straight_on(name: str, start: float, step: float) -> None:
    scene = lf.SpatialScene(gravity=(0.0, 0.0, -9.81))
    grounds = [scene.ground.box((x, 0.0, -0.1), (0.5, 1.0, 0.2)) for x in (-0.25, 0.25)]
    moved = scene.add(BODIES[name], position=(start, 0.0, 0.05), velocity=(1.0, 0.0, 0.0))
    for ground in grounds:
        scene.contact(moved.surface(), ground)
    result = lf.simulate(scene, 0.25, lf.GeneralizedAlpha(step=step), progress=False)
    assert result.u[-1] == pytest.approx([1.0, 0.0, 0.0, 0.0, 0.0, 0.0], abs=1e-12)


@pytest.mark.parametrize("name", BODIES)
@pytest.mark.parametrize("above", [0.1, 0.1 + 1e-13, 0.1 - 1e-13])
def test_what_goes_down_a_chute_of_its_own_width_is_not_caught(name: str, above: float) -> None:
    scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
    walls = [scene.ground.box((x, 0.0, z), (1.0, 1.0, 1.0)) for x in (-0.55, 0.55) for z in (-0.5, 0.5)]
    moved = scene.add(BODIES[name], position=(0.0, 0.0, above + 0.05), velocity=(0.0, 0.0, -1.0))
    for wall in walls:
        scene.contact(moved.surface(), wall)
    result = lf.simulate(scene, 0.2, lf.GeneralizedAlpha(step=1e-3), progress=False)
    assert result.u[-1] == pytest.approx([0.0, 0.0, -1.0, 0.0, 0.0, 0.0], abs=1e-12)
