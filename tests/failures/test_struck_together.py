"""Contacts that touch as one of them is struck: the impact law alone decides, and every stepper says so, once a run."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.dynamics.impact_laws import Poisson

STEPPERS: dict[str, Callable[[], Any]] = {
    "EventDriven": lf.EventDriven,
    "sequential": lambda: lf.EventDriven(impact=lf.Newton(sequential=True)),
    "Poisson": lambda: lf.EventDriven(impact=Poisson()),
    "MoreauJean": lambda: lf.MoreauJean(step=1e-3),
    "GeneralizedAlpha": lambda: lf.GeneralizedAlpha(step=1e-3),
}


def notes(result: lf.Result) -> list[str]:
    return [note for note in result.notes if "both touched as one was struck" in note]


def cradle(gap: float, e: float, space: bool, m: float = 1.0) -> Any:
    """Three balls, the first of which comes from a quarter of its radius."""
    scene: Any = lf.SpatialScene(gravity=(0.0, 0.0, 0.0)) if space else lf.Scene(gravity=(0.0, 0.0))
    zeros = (0.0,) * (2 if space else 1)
    ball: Any = lf.Sphere if space else lf.Disc
    balls = [
        scene.add(ball(0.05 * m, mass=1.0), name=name, position=(x * m, *zeros), velocity=(v * m, *zeros))
        for name, x, v in (("a", -0.0125, 1.0), ("b", 0.1, 0.0), ("c", 0.2 + gap, 0.0))
    ]
    for i in range(2):
        scene.contact(balls[i].surface(), balls[i + 1].surface(), restitution=e, name=f"pair {i + 1}")
    return scene


@pytest.mark.parametrize("stepper", STEPPERS)
@pytest.mark.parametrize(("space", "m"), [(False, 1.0), (True, 1.0), (False, 1e3)])
def test_balls_that_touch(stepper: str, space: bool, m: float) -> None:
    (note,) = notes(lf.simulate(cradle(0.0, 0.9, space, m), 0.05, STEPPERS[stepper]()))
    assert "'pair 1' and 'pair 2'" in note
    assert ("one after another, the fastest first (" in note) == (stepper == "sequential")


@pytest.mark.parametrize("stepper", STEPPERS)
@pytest.mark.parametrize(("gap", "e"), [(1e-4, 0.9), (0.02, 1.0), (0.0, 0.0)])
def test_balls_with_a_gap_or_without_restitution(stepper: str, gap: float, e: float) -> None:
    """The gap decides the order; without restitution nothing rebounds."""
    assert not notes(lf.simulate(cradle(gap, e, False), 0.05, STEPPERS[stepper]()))


@pytest.mark.parametrize("stepper", STEPPERS)
@pytest.mark.parametrize("under", [0.0, 0.5])
def test_a_ball_on_a_box_that_stands(stepper: str, under: float) -> None:
    """With the floor at once, or the box first: a ball bounces as on a wall, or as on a free box."""
    scene = lf.Scene()
    box = scene.add(lf.Box(0.4, 0.2, mass=1.0), position=(0.0, 0.1))
    ball = scene.add(lf.Disc(0.05, mass=0.5), position=(0.0, 0.3))
    scene.contact(box.surface(), scene.ground.half_plane((0, 0), (0, 1)), friction=0.3, restitution=under, name="floor")
    scene.contact(ball.surface(), box.surface(), restitution=0.5, name="strike")
    (note,) = notes(lf.simulate(scene, 0.15, STEPPERS[stepper]()))
    assert "'strike' and 'floor'" in note


@pytest.mark.parametrize("stepper", STEPPERS)
def test_what_is_struck_alone(stepper: str) -> None:
    """Two balls that bounce on one floor share no body that moves."""
    scene = lf.Scene()
    floor = scene.ground.half_plane((0, 0), (0, 1))
    for x in (-0.5, 0.5):
        ball = scene.add(lf.Disc(0.1, mass=1.0), position=(x, 0.2))
        scene.contact(ball.surface(), floor, restitution=0.8, friction=0.2)
    result = lf.simulate(scene, 0.5, STEPPERS[stepper]())
    assert not notes(result)


def test_a_note_is_no_warning() -> None:
    result = lf.simulate(cradle(0.0, 1.0, False), 0.05, lf.GeneralizedAlpha(step=1e-3))
    assert notes(result)
    assert not result.warnings
    assert "NOT" not in result.summary()


def test_bodies_that_are_too_far_off_to_be_measured_are_no_case() -> None:
    """Two instants alone are stored, and from the first on both boxes are out of reach: no gap is told of them."""
    scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
    ball = scene.add(lf.Sphere(0.05, mass=1.0), velocity=(5.0, 0.0, 0.0))
    for x in (2.0, 4.0):
        box = scene.add(lf.Cuboid(0.1, 0.1, 0.1, mass=1.0), position=(x, 0.0, 0.0))
        scene.contact(ball.surface(), box.surface(), restitution=0.5)
    result = lf.simulate(scene, 0.6, lf.MoreauJean(step=1e-3), record=0.6, progress=False)
    assert result.impulse[-1, 0, 0] > 0.0
    assert np.isnan(result.gap).all()
    assert not notes(result)
