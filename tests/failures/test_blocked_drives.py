"""A drive that pushes bodies where they cannot go is named; warnings about joints are in the result."""

from __future__ import annotations

import math
from typing import Any

import pytest

import lcpflex as lf

STEPPERS = [
    pytest.param(lf.MoreauJean(step=1e-3), id="moreau"),
    pytest.param(lf.GeneralizedAlpha(step=1e-3), id="alpha", marks=pytest.mark.slow),
    pytest.param(lf.EventDriven(), id="events", marks=pytest.mark.slow),
]


def ramp(t: float) -> tuple[float, float, float]:
    """A motion from rest with .1 m/s^2."""
    return 0.05 * t * t, 0.1 * t, 0.1


def back(t: float) -> tuple[float, float, float]:
    return -0.05 * t * t, -0.1 * t, -0.1


def against_a_wall(motion: Any, friction: float = 0.3, scale: float = 1.0) -> lf.Scene:
    """A box 10 mm from a wall, on a floor, lengths times ``scale``."""
    scene = lf.Scene(gravity=(0.0, -9.81 * scale))
    box = scene.add(lf.Box(0.1 * scale, 0.1 * scale, mass=1.0), "box", position=(0.0, 0.05 * scale))
    wall = scene.ground.half_plane((0.06 * scale, 0.0), (-1.0, 0.0))
    scene.contact(box.surface(), wall, friction=friction, name="wall")
    scene.contact(box.surface(), scene.ground.half_plane((0, 0), (0, 1)), friction=friction, name="floor")
    scene.join(lf.DrivenDisplacement(box.at(0, 0), scene.ground.at(0, 0.05 * scale), motion, (1.0, 0.0), name="ram"))
    return scene


def in_space(motion: Any) -> lf.SpatialScene:
    scene = lf.SpatialScene(gravity=(0.0, 0.0, -9.81))
    box = scene.add(lf.Cuboid(0.1, 0.1, 0.1, mass=1.0), "box", position=(0.0, 0.0, 0.05))
    scene.contact(box.surface(), scene.ground.plane((0.06, 0.0, 0.0), (-1.0, 0.0, 0.0)), friction=0.3, name="wall")
    scene.join(lf.DrivenDisplacement(box.at(0, 0, 0), scene.ground.at(0, 0, 0.05), motion, (1, 0, 0), name="ram"))
    return scene


def squeezed() -> lf.Scene:
    """A disc between two driven jaws, of which only one moves, and a third drive that is free to."""
    scene = lf.Scene(gravity=(0.0, 0.0))
    disc = scene.add(lf.Disc(0.05, mass=1.0), "disc")
    for name, x, motion in (("left", -0.11, ramp), ("right", 0.11, 0.0)):
        jaw = scene.add(lf.Box(0.1, 0.1, mass=1.0), name, position=(x, 0.0))
        scene.join(lf.Prismatic(jaw.at(0, 0), scene.ground.at(x, 0.0)))
        scene.join(lf.DrivenDisplacement(jaw.at(0, 0), scene.ground.at(x, 0.0), motion, (1.0, 0.0), name=f"{name} jaw"))
        scene.contact(disc.surface(), jaw.surface(), friction=0.3, name=f"{name} pad")
    other = scene.add(lf.Disc(0.05, mass=1.0), "other", position=(0.0, 1.0))
    scene.join(lf.DrivenAngle(other.at(0, 0), scene.ground.at(0, 1.0), ramp, name="spindle"))
    return scene


def crank() -> lf.Scene:
    """An arm that is turned against the floor."""
    scene = lf.Scene(gravity=(0.0, 0.0))
    arm = scene.add(lf.Box(0.4, 0.02, mass=1.0), "arm", position=(0.2, 0.1))
    scene.join(lf.Revolute(arm.at(-0.2, 0.0), scene.ground.at(0.0, 0.1)))
    scene.join(
        lf.DrivenAngle(
            arm.at(-0.2, 0.0), scene.ground.at(0.0, 0.1), lambda t: tuple(8 * x for x in back(t)), name="motor"
        )
    )
    scene.contact(arm.surface(), scene.ground.half_plane((0, 0), (0, 1)), friction=0.2, name="floor")
    return scene


BLOCKED = {
    "wall": (lambda: against_a_wall(ramp), "joint 'ram'"),
    "without friction": (lambda: against_a_wall(ramp, 0.0), "joint 'ram'"),
    "millimetres": (lambda: against_a_wall(lambda t: tuple(1e3 * x for x in ramp(t)), scale=1e3), "joint 'ram'"),
    "harmonic": (lambda: against_a_wall(lf.Harmonic(0.02, 2.0, -0.5 * math.pi, 0.02)), "joint 'ram'"),
    "space": (lambda: in_space(ramp), "joint 'ram'"),
    "jaws": (squeezed, "joint 'left jaw'"),
    "crank": (crank, "joint 'motor'"),
}


@pytest.mark.parametrize("stepper", STEPPERS)
@pytest.mark.parametrize("name", BLOCKED)
def test_the_drive_is_named(name: str, stepper: Any) -> None:
    build, named = BLOCKED[name]
    with pytest.raises(lf.StepError, match=r"cannot be fulfilled") as told:
        lf.simulate(build(), 1.5, stepper, progress=False)
    assert f"The motion of {named} cannot be fulfilled" in str(told.value)
    assert "spindle" not in str(told.value)
    assert told.value.contacts


def test_drives_that_are_not_in_the_way_are_not_blamed() -> None:
    """Away from the wall all is well; and a run that ends for another reason does not name the drive."""
    away = lf.simulate(against_a_wall(back), 0.6, lf.MoreauJean(step=1e-3), progress=False)
    assert away.complete
    scene = against_a_wall(back)
    scene.load(lf.Force(scene.body("box").at(0.0, 0.0), (lambda t: 1.0 if t < 0.3 else math.nan, 0.0)))
    with pytest.raises(lf.StepError) as told:
        lf.simulate(scene, 0.6, lf.MoreauJean(step=1e-3), progress=False)
    assert "cannot be fulfilled" not in str(told.value)
