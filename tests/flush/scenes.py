"""Scenes of bodies that are flush, equal and aligned but for a place (:class:`tests.flush.places.Place`).

Contacts are named by their bodies, the first one first: "up/low", "low/ground".
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

from scipy.spatial.transform import Rotation

import lcpflex as lf
from tests.flush.pairs import BRICK, KINDS, ROUND, Kind, Shape, above, box, drum
from tests.flush.places import Place

__all__ = ["GRAVITY", "MOTIONS", "RESTS", "STEP", "STEPPERS", "Motion", "level", "on_floor"]

GRAVITY = 9.81
STEP = 1e-3  # [s]
STEPPERS = {
    "EventDriven": lf.EventDriven(),
    "MoreauJean": lf.MoreauJean(step=STEP),
    "GeneralizedAlpha": lf.GeneralizedAlpha(step=STEP),
}
Build = Callable[[Place], lf.SpatialScene]


def level(gravity: float = GRAVITY) -> lf.SpatialScene:
    """An empty scene."""
    return lf.SpatialScene(gravity=(0.0, 0.0, -gravity))


def on_floor(scene: lf.SpatialScene, friction: float, *names: str) -> None:
    """Contacts of bodies with a floor at z = 0."""
    floor = scene.ground.plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    for name in names:
        scene.contact(scene.body(name).surface(), floor, friction=friction, name=f"{name}/ground")


def fixed(scene: lf.SpatialScene, shape: Shape, position: Any, turn: Rotation) -> Any:
    """A body welded to the ground."""
    body = scene.add(shape.body, "low", position=position, orientation=turn)
    scene.join(lf.Weld(body.at(0.0, 0.0, 0.0), scene.ground.at(*position), orientation=turn))
    return body


def standing(kind: Kind, place: Place) -> lf.SpatialScene:
    """ "up" on "low" on a floor."""
    scene, turn = level(), place.turn()
    low = scene.add(kind.low.body, "low", position=(0.0, 0.0, kind.low.height))
    at = place.at(kind.width, kind.start, 2.0 * kind.low.height + above(kind.up, turn))
    up = scene.add(kind.up.body, "up", at, turn)
    on_floor(scene, 0.4, "low")
    scene.contact(up.surface(), low.surface(), friction=0.4, name="up/low")
    return scene


def on_two(place: Place) -> lf.SpatialScene:
    """A brick on two that lie end to end."""
    scene, brick = level(), box(*BRICK)
    low = [scene.add(brick.body, name, position=(x, 0.0, 0.03)) for name, x in (("left", -0.1), ("right", 0.1))]
    up = scene.add(brick.body, "up", place.at(0.1, 0.0, 0.09), place.turn())
    on_floor(scene, 0.4, "left", "right")
    scene.contact(low[0].surface(), low[1].surface(), friction=0.4, name="left/right")
    for name, body in zip(("left", "right"), low, strict=True):
        scene.contact(up.surface(), body.surface(), friction=0.4, name=f"up/{name}")
    return scene


def sliding(place: Place) -> lf.SpatialScene:
    """A brick slides along a longer one of its own width."""
    scene, brick = level(), box(*BRICK)
    low = fixed(scene, box(0.8, 0.1, 0.06), (0.0, 0.0, 0.03), Rotation.identity())
    turn = place.turn()
    up = scene.add(brick.body, "up", place.at(0.1, 0.0, 0.06 + above(brick, turn)), turn, velocity=(0.8, 0.0, 0.0))
    scene.contact(up.surface(), low.surface(), friction=0.3, name="up/low")
    return scene


def off_a_ramp(place: Place) -> lf.SpatialScene:
    """A box slides down a ramp of its own width, over its end, and tips."""
    scene, moved = level(), box(0.1, 0.1, 0.06)
    incline = Rotation.from_euler("y", math.radians(30.0))
    low = fixed(scene, box(0.4, 0.1, 0.06), (0.0, 0.0, 0.3), incline)
    turn = place.turn()
    at = incline.apply(place.at(0.1, 0.11, 0.03 + above(moved, turn)))
    at[2] += 0.3
    speed = incline.apply([0.5, 0.0, 0.0])
    up = scene.add(moved.body, "up", at, incline * turn, velocity=speed)
    scene.contact(up.surface(), low.surface(), friction=0.2, name="up/low")
    return scene


def over_an_end(place: Place) -> lf.SpatialScene:
    """A brick tips over the end of one of its own width, 10 mm beyond balance."""
    scene, brick = level(), box(*BRICK)
    low = fixed(scene, brick, (0.0, 0.0, 0.03), Rotation.identity())
    turn = place.turn()
    up = scene.add(brick.body, "up", place.at(0.1, 0.11, 0.06 + above(brick, turn)), turn)
    scene.contact(up.surface(), low.surface(), friction=0.6, name="up/low")
    return scene


def end_to_end(place: Place) -> lf.SpatialScene:
    """A bar meets an equal one at rest, end to end and without gravity; no speed is lost."""
    scene, bar = level(0.0), box(0.02, 0.02, 0.2)
    low = scene.add(bar.body, "low", position=(0.0, 0.0, 0.1))
    turn = place.turn()
    up = scene.add(bar.body, "up", place.at(0.02, 0.0, 0.205 + above(bar, turn)), turn, velocity=(0.0, 0.0, -1.0))
    scene.contact(up.surface(), low.surface(), restitution=1.0, name="up/low")
    return scene


def rolling(place: Place) -> lf.SpatialScene:
    """A drum rolls along a box that is as wide as the drum is long, at 1 m/s."""
    scene, moved = level(), drum(0.05, 0.1)
    low = fixed(scene, box(0.8, 0.1, 0.06), (0.0, 0.0, 0.03), Rotation.identity())
    turn = place.turn() * Rotation.from_euler("x", math.pi / 2.0)
    ahead = Rotation.from_euler("z", math.remainder(place.yaw, math.pi))  # whichever end of its axis is left
    velocity, spin = ahead.apply([[1.0, 0.0, 0.0], [0.0, 20.0, 0.0]])
    at = place.at(0.1, -0.15, 0.11)
    up = scene.add(moved.body, "up", at, turn, velocity=velocity, angular_velocity=spin)
    scene.contact(up.surface(), low.surface(), friction=0.5, name="up/low")
    return scene


RESTS: dict[str, Build] = {
    **{
        name: lambda place, kind=(KINDS | ROUND)[name]: standing(kind, place)  # type: ignore[misc]
        for name in ("box on box", "box on a wider box", "prism on box", "gem on box", "drum on box")
    },
    "brick on two": on_two,
}


class Motion(NamedTuple):
    """One of the scenes, in which "up" is the body that moves, the last one."""

    build: Build
    moved: Shape
    duration: float  # [s]
    speed: float = 0.0  # of an impact during it [m/s]
    tilts: bool = True  # whether its motion goes with the tilt: not of an impact, which then is of one corner first
    leaves: bool = False  # whether corners leave what carries them, and it tips from then on


MOTIONS = {
    "slides": Motion(sliding, box(*BRICK), 0.1),
    "off a ramp": Motion(off_a_ramp, box(0.1, 0.1, 0.06), 0.25, leaves=True),
    "over an end": Motion(over_an_end, box(*BRICK), 0.15),
    "rolls": Motion(rolling, drum(0.05, 0.1), 0.25, tilts=False, leaves=True),
    "end to end": Motion(end_to_end, box(0.02, 0.02, 0.2), 0.02, speed=1.0, tilts=False),
}
