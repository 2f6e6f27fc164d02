"""A run in which nothing moves is to be trusted, wherever the zero of the potential energy is."""

from __future__ import annotations

from typing import Any

import pytest

import lcpflex as lf

STEPPERS: dict[str, Any] = {"Moreau-Jean": lf.MoreauJean(step=1e-3), "event-driven": lf.EventDriven()}


@pytest.mark.parametrize("height", [0.0, 3.0])
@pytest.mark.parametrize("stepper", STEPPERS)
def test_a_box_on_two_hinges_at_rest(stepper: str, height: float) -> None:
    scene = lf.Scene()
    box = scene.add(lf.Box(0.3, 0.1, mass=1.0), position=(0.15, height))
    for x in (0.0, 0.3):
        scene.join(lf.Revolute(box.at(x - 0.15, 0.0), scene.ground.at(x, height)))
    result = lf.simulate(scene, 0.2, STEPPERS[stepper])
    assert "Unverified: how accurate" in result.summary()
    assert not result.warnings
