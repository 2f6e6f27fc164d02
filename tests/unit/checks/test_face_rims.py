"""A contact that reaches the rim of a face where the surface goes on is told; one that ends at an edge is not."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import lcpflex as lf

STEEL = {"density": 7800.0, "youngs_modulus": 2.1e9, "poissons_ratio": 0.3}


def inner(x: float, y: float, z: Any) -> Any:
    """The middle of the bottom."""
    return (np.abs(x) < 0.03) & (np.abs(y) < 0.03) & (z < -0.0249)


def dropped(face: str, points: str) -> Any:
    """A block that falls flat on a plane."""
    solid = lf.Solid.box((0.1, 0.1, 0.05), elements=(4, 4, 2), sets={"inner": inner}, **STEEL)
    body = solid.reduce(modes=2, contact=face, rows="normal")
    scene = lf.SpatialScene()
    block = scene.add(body, position=(0.0, 0.0, 0.0251), velocity=(0.0, 0.0, -0.1))
    scene.contact(block.face(face), scene.ground.plane((0, 0, 0), (0, 0, 1)), points=points)
    return lf.simulate(scene, 2e-3, lf.MoreauJean(step=1e-5))


@pytest.mark.filterwarnings("ignore::lcpflex.ModelWarning")
@pytest.mark.parametrize("points", ["areas", "nodes"])
@pytest.mark.parametrize(("face", "told"), [("inner", True), ("bottom", False)])
def test_a_rim_that_is_no_edge_is_told(face: str, told: bool, points: str) -> None:
    found = [warning for warning in dropped(face, points).warnings if "the rim of its face" in warning]
    assert bool(found) == told, found
