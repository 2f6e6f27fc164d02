"""Where mechanics leaves a choice, or events are too many to follow: the run says what it took, or did not follow."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from lcpflex import gallery
from tests.scenes import floor_of

STEPPERS = [
    pytest.param(lf.EventDriven(), id="event-driven"),
    pytest.param(lf.MoreauJean(step=1e-6), id="moreau-jean"),
    pytest.param(lf.GeneralizedAlpha(step=1e-6), id="generalized-alpha"),
    pytest.param(lf.MoreauJean(step=1e-6, adaptive=lf.AdaptiveStep()), id="adaptive moreau-jean"),
    pytest.param(lf.GeneralizedAlpha(step=1e-6, adaptive=lf.AdaptiveStep()), id="adaptive generalized-alpha"),
]


def leaning_rods(
    friction: float, spin: float, size: float = 1.0, mass: float = 1.0, mirrored: bool = False
) -> lf.Scene:
    """Painleve's rod (:func:`lcpflex.gallery.painleve_rod`) in other units, or turned to the other side."""
    side = -1.0 if mirrored else 1.0
    angle = math.radians(120.0 if mirrored else 60.0)
    scene = lf.Scene(gravity=(0.0, -size))
    rod = scene.add(
        lf.RigidBody(mass=mass, inertia=mass * size**2 / 3.0),
        name="rod",
        position=(size * math.cos(angle), size * math.sin(angle)),
        angle=angle,
        velocity=(size * (-side - side * spin * math.sin(angle)), size * side * spin * math.cos(angle)),
        angular_velocity=side * spin,
    )
    floor = floor_of(scene)
    scene.contact(rod.node(-size, 0.0), floor, friction=friction, name="tip")
    return scene


@pytest.mark.parametrize("stepper", STEPPERS)
@pytest.mark.parametrize(
    ("size", "mass", "mirrored"),
    [(1.0, 1.0, False), (1e3, 1e-3, False), (1.0, 50.0, True)],
    ids=["m", "mm, t", "mirrored"],
)
def test_several_motions_are_said_by_all(stepper: Any, size: float, mass: float, mirrored: bool, loud: Any) -> None:
    """The end of the rod may slide on, or leave the floor: time stepping took one of the two without a word."""
    said = loud(leaning_rods(1.4, 1.2, size, mass, mirrored), 2e-5, stepper)
    assert "several motions were admissible" in said
    assert "contact 'tip'" in said
    for friction, spin in ((0.5, 0.0), (0.5, 1.2), (1.2, 1.2)):  # below mu_P = 1.347, one motion
        assert not lf.simulate(leaning_rods(friction, spin, size, mass, mirrored), 2e-5, stepper).warnings


@pytest.mark.parametrize("stepper", STEPPERS[1:3])
def test_several_motions_among_other_contacts(stepper: Any, loud: Any) -> None:
    """Beside a block at rest on the same floor, and declared before or after it."""
    for block_first in (True, False):
        scene = leaning_rods(1.4, 1.2)

        def block(scene: lf.Scene) -> None:
            box = scene.add(lf.Box(0.4, 0.2, mass=1.0), name="box", position=(9.0, 0.1))
            scene.contact(box.surface(), floor_of(scene), friction=0.5, name="under box")

        if block_first:
            scene = lf.Scene(gravity=(0.0, -1.0))
            block(scene)
            rod = scene.add(
                lf.RigidBody(mass=1.0, inertia=1.0 / 3.0),
                position=(0.5, math.sin(math.radians(60.0))),
                angle=math.radians(60.0),
                velocity=(-1.0 - 1.2 * math.sin(math.radians(60.0)), 0.6),
                angular_velocity=1.2,
            )
            scene.contact(rod.node(-1.0, 0.0), floor_of(scene), friction=1.4, name="tip")
        else:
            block(scene)
        said = loud(scene, 2e-5, stepper)
        assert "several motions were admissible" in said
        assert "taken was the one in which contact 'tip' slides" in said
        assert "under box" not in said  # the block is another island, whose motion is no question


def test_forces_that_are_not_unique_are_no_several_motions() -> None:
    """A wedged disc and a box with much friction: many forces, one motion, no warning."""
    scene = lf.Scene()
    disc = scene.add(lf.Disc(0.1, mass=1.0), position=(0.0, 0.2))
    for side in (1.0, -1.0):
        wall = scene.ground.half_plane((0, 0), (side * math.sqrt(0.75), 0.5))
        scene.contact(disc.surface(), wall, friction=1.5)
    box = scene.add(lf.Box(0.1, 0.4, mass=1.0), position=(3.0, 0.2))
    scene.contact(box.surface(), floor_of(scene), friction=1.5)
    for stepper in (lf.MoreauJean(step=1e-4), lf.GeneralizedAlpha(step=1e-4)):
        result = lf.simulate(scene, 0.02, stepper)
        assert np.abs(result.u).max() < 1e-9
        assert not result.warnings


def test_events_that_accumulate_too_fast(loud: Any) -> None:
    """Bounces of e = 0.99 that are too many for the rate allowed are ended a little early."""
    said = loud(gallery.bouncing_ball(height=2e-4, restitution=0.99), 2.0, lf.EventDriven(most_events=500.0))
    assert "events accumulated faster than 500 a second (most_events)" in said
    assert "m/s was stopped, not reflected" in said
    followed = lf.simulate(gallery.bouncing_ball(height=2e-4, restitution=0.99), 2.0, lf.EventDriven())
    assert not followed.warnings
