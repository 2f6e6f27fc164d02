"""Several places of rest in space."""

from __future__ import annotations

import math

import numpy as np
import pytest

import lcpflex as lf

G = 9.81


def test_a_switch_has_two_places() -> None:
    """A lever that a spring across its hinge pulls to one stop or to the other."""
    scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
    lever = scene.add(lf.Cuboid(0.2, 0.02, 0.02, mass=1.0), "lever", position=(0.1, 0.0, 0.01))
    scene.join(lf.Revolute(lever.at(-0.1, 0, 0), scene.ground.at(0.0, 0.0, 0.01), axis=(0.0, 1.0, 0.0), name="hinge"))
    scene.load(lf.Spring(lever.at(0.1, 0.0, 0.0), scene.ground.at(-0.1, 0.0, 0.0), stiffness=100.0, length=0.1))
    tip = lever.sphere((0.1, 0.0, 0.0), 0.01)
    scene.contact(tip, scene.ground.plane((0.0, 0.0, -0.1), (0.0, 0.0, 1.0)), name="down")
    scene.contact(tip, scene.ground.plane((0.0, 0.0, 0.1), (0.0, 0.0, -1.0)), name="up")
    places = lf.equilibria(scene)
    assert len(places) == 2
    closed = {contact.name: place for place in places for contact in place.contacts if contact.states}
    for name, height in (("down", -0.09), ("up", 0.09)):
        place = closed[name]
        assert place.point("lever", "center")[2] == pytest.approx(0.5 * (height + 0.01), abs=1e-10)
        # moments about the hinge, of the spring to (-0.1, 0, 0) and of the stop
        tip_at = np.array([math.sqrt(0.2**2 - (height - 0.01) ** 2), height])
        to_spring = np.array([-0.1, 0.0]) - tip_at
        tension = 100.0 * (np.hypot(*to_spring) - 0.1)
        arm = tip_at - [0.0, 0.01]
        moment = tension * (arm[0] * to_spring[1] - arm[1] * to_spring[0]) / np.hypot(*to_spring)
        assert place.contact(name).normal == pytest.approx([abs(moment) / arm[0]], rel=1e-8)
        assert place.stable
        assert not place.neutral


@pytest.mark.slow
def test_a_box_rests_on_each_of_its_faces() -> None:
    """Pushed over its edges on a rough floor, one after the other."""
    scene = lf.SpatialScene(gravity=(0.0, 0.0, -G))
    box = scene.add(lf.Cuboid(0.3, 0.2, 0.1, mass=1.0), "box", position=(0.0, 0.0, 0.06))
    floor = scene.ground.plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    scene.contact(box.surface(), floor, friction=0.3, name="floor")
    places = lf.equilibria(scene)
    assert sorted(place.q[2] for place in places) == pytest.approx([0.05, 0.05, 0.1, 0.1, 0.15, 0.15], abs=1e-9)
    for place in places:
        assert place.contact("floor").normal == pytest.approx(np.full(4, 0.25 * G), rel=1e-8)
        assert place.stable
    assert not any(place.warnings for place in places)


@pytest.mark.slow
def test_a_ball_on_a_tray_of_balls() -> None:
    """Nine balls in a square, touching: four hollows, in each the ball bears W sqrt(2) / 4 at each of four places."""
    scene = lf.SpatialScene(gravity=(0.0, 0.0, -G))
    ball = scene.add(lf.Sphere(0.05, mass=1.0), "ball", position=(0.04, 0.03, 0.2))
    for i in range(3):
        for j in range(3):
            center = (0.1 * (i - 1), 0.1 * (j - 1), 0.0)
            scene.contact(ball.surface(), scene.ground.sphere(center, 0.05), name=f"ball {i} {j}")
    for x, y in ((1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)):
        scene.contact(
            ball.surface(), scene.ground.plane((-0.15 * x, -0.15 * y, 0.0), (x, y, 0.0)), name=f"wall {x} {y}"
        )
    places = lf.equilibria(scene, reach=0.15)
    found = sorted(tuple(np.sign(place.q[:2])) for place in places)
    assert found == [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)]
    for place in places:
        assert np.abs(place.q[:3]) == pytest.approx([0.05, 0.05, 0.05 * math.sqrt(2.0)], abs=1e-10)
        forces = [contact.normal[0] for contact in place.contacts if contact.states]
        assert forces == pytest.approx([G * math.sqrt(2.0) / 4.0] * 4, rel=1e-8)
        assert len(place.neutral) == 3
