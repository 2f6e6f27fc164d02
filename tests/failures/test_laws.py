"""Contacts by a force law where a method gets them wrong: it says which, and a neighbouring scene is left alone."""

from __future__ import annotations

from typing import Any

import pytest

import lcpflex as lf
from tests.scenes import floor_of

WEIGHT = 9.81


def against_a_wall(push: float = 50.0, prop: bool = True, length: float = 1.0, mass: float = 1.0) -> lf.Scene:
    """A disc of 1 kg lies on a smooth floor, by complementarity, and is pushed against a rubber wall, by a law."""
    law = lf.ContactLaw(lf.laws.PowerLaw(1e6 * mass, exponent=1.0), friction=lf.laws.SmoothedCoulomb(1e-3 * length))
    scene = lf.Scene(gravity=(0.0, -WEIGHT * length if prop else 0.0))
    disc = scene.add(lf.Disc(0.1 * length, mass=mass), "disc", position=(0.0, 0.1 * length))
    scene.join(lf.DrivenAngle(disc.point("center"), scene.ground.at(0.0, 0.1 * length), 0.0))
    depth = push / 1e6 * length
    wall = scene.ground.half_plane((0.1 * length - depth, 0.0), (-1.0, 0.0))
    if prop:
        scene.contact(disc.surface(), floor_of(scene), name="floor")
    scene.contact(disc.surface(), wall, friction=0.3, law=law, name="wall")
    scene.load(lf.Force(disc.point("center"), (push * mass * length, 0.0)))
    return scene


@pytest.mark.parametrize(("length", "mass"), [(1.0, 1.0), (1e3, 1e-3)], ids=["metres", "millimetres"])
@pytest.mark.parametrize("step", [1e-3, 1e-4])
def test_a_wall_that_seems_to_carry_what_lies_on_the_floor(loud: Any, step: float, length: float, mass: float) -> None:
    """Friction by the law takes the weight off the floor; event-driven runs share it out rightly."""
    scene = against_a_wall(length=length, mass=mass)
    said = loud(scene, 0.05, lf.MoreauJean(step))
    assert "friction of contact 'wall' is off by" in said
    assert "EventDriven" in said
    result = lf.simulate(scene, 0.05, lf.EventDriven())
    assert not result.warnings
    assert result.contact("floor").force[-1, 0] == pytest.approx(WEIGHT * mass * length, rel=1e-6)
    assert abs(result.contact("wall").force[-1, 1]) < 1e-6 * WEIGHT * mass * length


def test_friction_by_a_law_alone_is_balanced_and_says_nothing() -> None:
    scene = against_a_wall(prop=False)
    result = lf.simulate(scene, 0.05, lf.MoreauJean(1e-3))
    assert not result.warnings
    assert result.contact("wall").force[-1, 0] == pytest.approx(50.0, rel=1e-6)


def pressed_by_a_spring(length: float = 1.0, mass: float = 1.0, weight: bool = False) -> lf.Scene:
    """A spring, 20 mm longer than there is room, throws a disc on the floor and keeps it there; or its weight does."""
    scene = lf.Scene(gravity=(0.0, -20.0 * length if weight else 0.0))
    disc = scene.add(
        lf.Disc(0.1 * length, mass=mass), "disc", position=(0.0, 0.15 * length), velocity=(0.0, -0.26 * length)
    )
    scene.contact(disc.surface(), floor_of(scene), name="floor")
    scene.join(lf.PointOnLine(disc.point("center"), scene.ground.at(0.0, 0.0), (0.0, 1.0)))
    if not weight:
        top = scene.ground.at(0.0, length)
        scene.load(lf.Spring(disc.point("center"), top, 1e3 * mass, damping=5.0 * mass, length=0.92 * length))
    return scene


@pytest.mark.parametrize(("length", "mass"), [(1.0, 1.0), (1e3, 1e-3)], ids=["metres", "millimetres"])
def test_a_depth_that_a_spring_feels(loud: Any, length: float, mass: float) -> None:
    """0.15 mm are little for a disc of 0.2 m, and 0.75 % of the spring's 20 mm: the contact force is off by that."""
    scene = pressed_by_a_spring(length, mass)
    said = loud(scene, 0.4, lf.MoreauJean(1e-3))
    result = lf.simulate(scene, 0.4, lf.MoreauJean(1e-3))
    off = 1.0 - result.contact("floor").force[-1, 0] / (20.0 * mass * length)
    assert 0.005 < off < 0.01
    assert f"is off by about {100.0 * off / (1.0 - off):.2g} %" in said
    assert "times shorter" in said
    for stepper in (lf.MoreauJean(1e-5), lf.EventDriven()):
        result = lf.simulate(scene, 0.4, stepper)
        assert not result.warnings
        assert result.contact("floor").force[-1, 0] == pytest.approx(20.0 * mass * length, rel=2e-3)


def test_the_same_depth_under_a_weight_is_left_alone() -> None:
    result = lf.simulate(pressed_by_a_spring(weight=True), 0.4, lf.MoreauJean(1e-4))
    assert result.gap[-1, 0] < -1e-5
    assert result.contact("floor").force[-1, 0] == pytest.approx(20.0, rel=1e-9)
    assert not result.warnings
