"""What comes down between the nodes of a face is told, and what they feel is not."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import lcpflex as lf


@cache
def block() -> lf.SpatialBody:
    steel = {"density": 7800.0, "youngs_modulus": 2.1e9, "poissons_ratio": 0.3}
    return lf.Solid.box((0.1, 0.1, 0.05), elements=(4, 4, 2), **steel).reduce(modes=2, contact="top", rows="normal")


def fallen(other: str, points: str) -> Any:
    """Something that falls on the top of a block that is held."""
    scene = lf.SpatialScene()
    body = scene.add(block())
    scene.join(lf.Weld(body.at(0.0, 0.0, 0.0), scene.ground.at(0.0, 0.0, 0.0)))
    made = {
        "small ball": (lf.Sphere(0.004, density=7800.0), 0.004, Rotation.identity(), (0.0125, 0.0125)),
        "large ball": (lf.Sphere(0.5, density=100.0), 0.5, Rotation.identity(), (0.0, 0.0)),
        "corner": (
            lf.Cuboid(0.02, 0.02, 0.02, density=7800.0),
            0.01 * np.sqrt(3.0),
            Rotation.align_vectors([(0.0, 0.0, -1.0)], [(1.0, 1.0, 1.0)])[0],
            (0.0125, 0.0125),
        ),
        "box": (lf.Cuboid(0.06, 0.06, 0.02, density=7800.0), 0.01, Rotation.identity(), (0.0, 0.0)),
    }
    shape, height, turn, (x, y) = made[other]
    ball = scene.add(shape, position=(x, y, 0.0251 + height), orientation=turn, velocity=(0.0, 0.0, -0.5))
    scene.contact(body.face("top"), ball.surface(), points=points)
    return lf.simulate(scene, 6e-3, lf.MoreauJean(step=1e-5))


@pytest.mark.filterwarnings("ignore::lcpflex.ModelWarning")
@pytest.mark.parametrize("points", ["areas", "nodes"])
@pytest.mark.parametrize(
    ("other", "told"), [("small ball", True), ("corner", True), ("large ball", False), ("box", False)]
)
def test_what_no_node_feels_is_told(other: str, told: bool, points: str) -> None:
    found = [warning for warning in fallen(other, points).warnings if "below the face" in warning]
    assert bool(found) == told, found
