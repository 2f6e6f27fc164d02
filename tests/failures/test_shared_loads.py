"""Contacts of the plane that share a load in more ways than one: each stepper says that another motion may come out."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import pytest

import lcpflex as lf
from lcpflex import gallery

STEPPERS: dict[str, Callable[[], Any]] = {
    "EventDriven": lf.EventDriven,
    "MoreauJean": lambda: lf.MoreauJean(step=1e-3),
    "GeneralizedAlpha": lambda: lf.GeneralizedAlpha(step=1e-3),
}


def said(result: lf.Result) -> bool:
    return any("another method may come to another motion" in note for note in result.notes)


@pytest.mark.parametrize("stepper", STEPPERS)
@pytest.mark.parametrize("seed", [2, 3])
def test_a_heap_between_walls(stepper: str, seed: int) -> None:
    """Of seed 3 event-driven runs come to rest elsewhere than time stepping, at every step and tolerance."""
    result = lf.simulate(gallery.heap(discs=9, seed=seed), 0.6, STEPPERS[stepper]())
    assert said(result)
    (note,) = (note for note in result.notes if "another motion" in note)
    assert "'disc" in note
    assert "at t = " in note


def groove(degrees: float, friction: float, turned: float, m: float) -> lf.Scene:
    """A disc in a groove of two inclined planes, all turned."""
    scene = lf.Scene(gravity=(-9.81 * m * math.sin(turned), -9.81 * m * math.cos(turned)))
    slope = math.radians(degrees)
    disc = scene.add(lf.Disc(0.1 * m, mass=1.0), position=(0.0, 0.1 * m / math.cos(slope)))
    for name, x in (("left", math.sin(slope)), ("right", -math.sin(slope))):
        scene.contact(
            disc.surface(), scene.ground.half_plane((0, 0), (x, math.cos(slope))), friction=friction, name=name
        )
    return scene


@pytest.mark.parametrize("stepper", STEPPERS)
@pytest.mark.parametrize(
    ("degrees", "friction", "m", "shared"), [(30.0, 0.4, 1.0, True), (50.0, 0.9, 1e3, True), (30.0, 0.0, 1.0, False)]
)
def test_a_disc_in_a_groove(stepper: str, degrees: float, friction: float, m: float, shared: bool) -> None:
    """Two contacts that stick have four forces for three equations; without friction there are two, and unique."""
    assert said(lf.simulate(groove(degrees, friction, 0.0, m), 0.02, STEPPERS[stepper]())) == shared


def box(speed: float, feet: tuple[tuple[float, float], ...], angle: float, m: float) -> lf.Scene:
    """A box on a plane, or on feet at x with a friction each; gravity straight onto the plane."""
    normal = (-math.sin(angle), math.cos(angle))
    scene = lf.Scene(gravity=(-9.81 * m * normal[0], -9.81 * m * normal[1]))
    plane = scene.ground.half_plane((0.0, 0.0), normal)
    high = 0.05 * m if not feet else 0.08 * m
    along = (math.cos(angle), math.sin(angle))
    shape = lf.Box(0.4 * m, 0.1 * m, mass=1.0)
    body = scene.add(
        shape,
        position=(high * normal[0], high * normal[1]),
        angle=angle,
        velocity=(speed * m * along[0], speed * m * along[1]),
    )
    if not feet:
        scene.contact(body.surface(), plane, friction=0.3)
    for x, mu in feet:
        scene.contact(body.circle((x * m, -0.06 * m), 0.02 * m), plane, friction=mu)
    return scene


@pytest.mark.parametrize("stepper", STEPPERS)
@pytest.mark.parametrize("speed", [0.0, 1.0])
@pytest.mark.parametrize(("angle", "m"), [(0.0, 1.0), (0.4, 1e3)])
def test_a_box_on_two_corners(stepper: str, speed: float, angle: float, m: float) -> None:
    """Its friction is mu m g, however the corners share it."""
    assert not said(lf.simulate(box(speed, (), angle, m), 0.05, STEPPERS[stepper]()))


@pytest.mark.parametrize("stepper", STEPPERS)
@pytest.mark.parametrize(
    ("frictions", "shared"),
    [((0.3, 0.3, 0.3), False), ((0.3, 0.1, 0.3), True), ((0.3, 0.0), False), ((0.2, 0.4), False)],
)
def test_feet_that_slide(stepper: str, frictions: tuple[float, ...], shared: bool) -> None:
    """Three feet of one friction slide under mu m g; of two frictions, shares decide; two feet have none to choose."""
    xs = (-0.15, 0.02, 0.15) if len(frictions) == 3 else (-0.15, 0.15)
    scene = box(1.0, tuple(zip(xs, frictions, strict=True)), 0.0, 1.0)
    assert said(lf.simulate(scene, 0.05, STEPPERS[stepper]())) == shared


@pytest.mark.parametrize("stepper", ["MoreauJean", "GeneralizedAlpha"])
def test_boxes_on_boxes(stepper: str) -> None:
    """Corners on a face and corners of the other in it: four points on a line, and the load of two."""
    assert not said(lf.simulate(gallery.stack(5), 0.05, STEPPERS[stepper]()))


def test_a_note_is_no_doubt() -> None:
    result = lf.simulate(groove(30.0, 0.4, 0.0, 1.0), 0.02, lf.MoreauJean(step=1e-3))
    assert said(result)
    assert not result.warnings
    assert "NOT" not in result.summary()
