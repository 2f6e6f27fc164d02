"""Light bodies beside heavy ones: places of rest told by the forces that act on each body, not on the largest."""

from __future__ import annotations

import math

import numpy as np
import pytest

import lcpflex as lf
from tests.scenes import floor_of

G = 9.81


def beside_a_block() -> lf.Scene:
    """A block of 1 kg on the floor."""
    scene = lf.Scene(gravity=(0.0, -G))
    block = scene.add(lf.Box(1.0, 1.0, mass=1.0), "block", position=(0.0, 0.5))
    scene.contact(block.surface(), floor_of(scene), friction=0.3, name="block")
    return scene


@pytest.mark.parametrize("mass", [1e-8, 1e-12])
def test_a_feather_does_not_hang_in_the_air(mass: float) -> None:
    """It falls to the floor, which bears its weight and holds it."""
    scene = beside_a_block()
    feather = scene.add(lf.Disc(0.1, mass=mass), "feather", position=(2.0, 0.4))
    scene.contact(feather.surface(), floor_of(scene), friction=0.3, name="feather")
    rest = lf.equilibrium(scene)
    assert rest.q[4] == pytest.approx(0.1, abs=1e-9)
    contact = rest.contact("feather")
    assert contact.states == ("stick",)
    assert contact.on("feather") == pytest.approx([0.0, mass * G], rel=1e-8, abs=1e-6 * mass * G)
    assert rest.stable
    assert len(rest.neutral) == 1  # it may roll
    assert rest.neighbours == 2  # and each of both may be elsewhere


@pytest.mark.parametrize("up", [True, False])
def test_a_light_pendulum(up: bool) -> None:
    """On its head it is unstable, hanging it is stable; neither is neutral."""
    scene = beside_a_block()
    sign = 1.0 if up else -1.0
    bar = scene.add(lf.Box(1.0, 0.1, mass=1e-9), "bar", position=(2.0, 0.5 * sign), angle=0.5 * math.pi * sign)
    scene.join(lf.Revolute(bar.point("left"), scene.ground.at(2.0, 0.0), name="hinge"))
    rest = lf.equilibrium(scene)
    assert rest.stable != up
    assert len(rest.unstable) == int(up)
    assert not rest.neutral
    assert rest.joint("hinge").force == pytest.approx([0.0, 1e-9 * G], rel=1e-8, abs=1e-15)


@pytest.mark.parametrize("mass", [1e-3, 1e-6, 1e-9])
def test_a_light_box_on_a_heavy_one(mass: float) -> None:
    """Its corners bear half its weight each and could press sideways: they stick, and forces are not unique."""
    scene = beside_a_block()
    box = scene.add(lf.Box(0.4, 0.2, mass=mass), "box", position=(0.0, 1.1))
    scene.contact(box.surface(), scene.ground.half_plane((0.0, 1.0), (0.0, 1.0)), friction=0.4, name="box")
    contact = lf.equilibrium(scene).contact("box")
    assert contact.states == ("stick", "stick")
    assert contact.normal == pytest.approx([0.5 * mass * G] * 2, rel=1e-6)
    assert not contact.unique.any()


@pytest.mark.parametrize("pull", [-0.999999, 0.999999])
def test_both_corners_of_a_pulled_box_stick(pull: float) -> None:
    """What friction has left, 1e-6 of its limit, can be at either corner."""
    scene = lf.Scene(gravity=(0.0, -G))
    box = scene.add(lf.Box(0.4, 0.2, mass=1.0), "box", position=(0.0, 0.1))
    scene.contact(box.surface(), floor_of(scene), friction=0.3, name="box")
    scene.load(lf.Force(box.point("center"), (pull * 0.3 * G, 0.0)))
    rest = lf.equilibrium(scene)
    assert rest.contact("box").states == ("stick", "stick")
    assert rest.contact("box").on("box") == pytest.approx(np.array([-pull * 0.3 * G, G]), rel=1e-8)
