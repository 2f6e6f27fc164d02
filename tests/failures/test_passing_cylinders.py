"""Balls that go through cylinders of space between two looks: said; those that fly past: not."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from scipy.spatial.transform import Rotation

import lcpflex as lf
from lcpflex.results.doubts import doubts

Loud = Callable[..., str]
DOWN, ACROSS = (0.0, 0.0, -100.0), (-100.0, 0.0, 0.0)


def shot(place: tuple[float, float, float], velocity: tuple[float, float, float], radius: float, length: float) -> Any:
    """A ball of 10 mm radius at 100 m/s, and a cylinder about z at rest."""
    scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
    solid = scene.ground.cylinder((0.0, 0.0, 0.0), (0.0, 0.0, 1.0), radius, length)
    ball = scene.add(lf.Sphere(0.01, mass=0.5), "ball", position=place, velocity=velocity)
    scene.contact(ball.surface(), solid, name="contact")
    return scene


@pytest.mark.parametrize(
    ("place", "velocity", "radius", "length"),
    [
        ((0.1, 0.0, 1.0), DOWN, 0.5, 0.02),  # through both ends of a thin disc
        ((1.0, 0.0, 0.3), ACROSS, 0.02, 2.0),  # through the side of a thin rod
        ((0.026, 0.0, 0.3), DOWN, 0.02, 0.02),  # by the rim
    ],
)
@pytest.mark.parametrize("step", [7e-4, 1.3e-3])
def test_a_ball_does_not_fly_through_a_cylinder_unseen(
    loud: Loud, place: Any, velocity: Any, radius: float, length: float, step: float
) -> None:
    said = loud(shot(place, velocity, radius, length), 0.03, lf.MoreauJean(step))
    assert "'contact' passed through each other" in said or "penetrates by" in said


@pytest.mark.parametrize(
    ("place", "velocity", "radius", "length"),
    [
        ((0.035, 0.0, 0.3), DOWN, 0.02, 0.02),
        ((0.3, 0.0, 1.02), ACROSS, 0.02, 2.0),  # over the end
        ((0.3, 0.035, 0.0), ACROSS, 0.02, 2.0),  # beside the side
    ],
)
@pytest.mark.parametrize("step", [7e-4, 1.3e-3])
def test_a_ball_that_flies_past_is_no_matter(
    place: Any, velocity: Any, radius: float, length: float, step: float
) -> None:
    result = lf.simulate(shot(place, velocity, radius, length), 0.03, lf.MoreauJean(step))
    assert doubts(result) == result.warnings == ()


def test_events_are_not_missed() -> None:
    for place, velocity, radius, length in (((0.1, 0.0, 1.0), DOWN, 0.5, 0.02), ((1.0, 0.0, 0.3), ACROSS, 0.02, 2.0)):
        result = lf.simulate(shot(place, velocity, radius, length), 0.03, lf.EventDriven())
        assert [event.kind for event in result.events] == ["impact"]


def rod(
    place: tuple[float, float, float], velocity: tuple[float, float, float], axis: tuple[float, float, float], size: Any
) -> Any:
    """A capsule along x, 0.4 m between its ends, of 10 mm radius, at 100 m/s, and a cylinder at rest."""
    scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
    solid = scene.ground.cylinder((0.0, 0.0, 0.0), axis, *size)
    turn = Rotation.from_euler("y", 90.0, degrees=True)
    body = scene.add(lf.Capsule(0.01, 0.4, mass=0.5), "rod", position=place, orientation=turn, velocity=velocity)
    scene.contact(body.surface(), solid, name="contact")
    return scene


@pytest.mark.parametrize(
    ("axis", "size"),
    [
        ((0.0, 1.0, 0.0), (0.02, 2.0)),  # its side through the side of a thin rod
        ((0.0, 0.0, 1.0), (0.1, 0.02)),  # its side through a disc
        ((1.0, 0.0, 0.0), (0.02, 0.2)),  # through a shorter one along it
    ],
)
@pytest.mark.parametrize("step", [7e-4, 1.3e-3])
def test_a_capsule_does_not_fly_through_a_cylinder_unseen(loud: Loud, axis: Any, size: Any, step: float) -> None:
    said = loud(rod((0.05, 0.0, 1.0), DOWN, axis, size), 0.03, lf.MoreauJean(step))
    assert "'contact' passed through each other" in said or "penetrates by" in said


@pytest.mark.parametrize("step", [7e-4, 1.3e-3])
@pytest.mark.parametrize(
    ("place", "axis", "size"),
    [
        ((0.25, 0.0, 1.0), (0.0, 1.0, 0.0), (0.02, 2.0)),  # beyond its own end
        ((0.0, 1.05, 1.0), (0.0, 1.0, 0.0), (0.02, 2.0)),  # beyond the end of the cylinder
        ((0.0, 0.15, 1.0), (0.0, 0.0, 1.0), (0.1, 0.02)),  # beside a disc
    ],
)
def test_a_capsule_that_flies_past_is_no_matter(place: Any, axis: Any, size: Any, step: float) -> None:
    result = lf.simulate(rod(place, DOWN, axis, size), 0.03, lf.MoreauJean(step))
    assert doubts(result) == result.warnings == ()
