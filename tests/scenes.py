"""Scenes that tests share: floors, and what several of them drop, throw, hinge or press upon one.

Lengths in m, masses in kg, gravity downwards; a further keyword of a contact goes to ``Scene.contact``.
"""

from __future__ import annotations

import math
from typing import Any

import lcpflex as lf
from lcpflex.bodies.surface import Surface

Pair = tuple[float, float]


def floor_of(scene: lf.Scene) -> Surface:
    """The ground below y = 0."""
    return scene.ground.half_plane((0.0, 0.0), (0.0, 1.0))


def disc_on_floor(
    height: float = 0.1,
    velocity: Pair = (0.0, 0.0),
    *,
    radius: float = 0.1,
    mass: float = 1.0,
    gravity: float = 9.81,
    spin: float = 0.0,
    **contact: Any,
) -> lf.Scene:
    """A disc ("disc") with its centre at ``height`` over the floor, with which it is in contact ("floor")."""
    scene = lf.Scene(gravity=(0.0, -gravity))
    disc = scene.add(
        lf.Disc(radius, mass=mass), "disc", position=(0.0, height), velocity=velocity, angular_velocity=spin
    )
    scene.contact(disc.surface(), floor_of(scene), **{"name": "floor", **contact})
    return scene


def box_on_floor(
    velocity: Pair = (0.0, 0.0), *, size: float = 1.0, mass: float = 1.0, gravity: float = 9.81, **contact: Any
) -> lf.Scene:
    """A box ("box"), 0.4 ``size`` wide and half as high, stands on the floor ("floor")."""
    scene = lf.Scene(gravity=(0.0, -gravity))
    body = lf.Box(0.4 * size, 0.2 * size, mass=mass)
    box = scene.add(body, "box", position=(0.0, 0.1 * size), velocity=velocity)
    scene.contact(box.surface(), floor_of(scene), **{"name": "floor", **contact})
    return scene


# Ball of 0.1 m, dropped by 1 m on a floor with e = 0.8 under 10 m/s^2: no step ends at one of its three impacts.
THREE_BOUNCES = 1.5


def three_bounces() -> lf.Scene:
    """See above."""
    return disc_on_floor(1.1, gravity=10.0, restitution=0.8)


def after_three_bounces() -> Pair:
    """Height of its lowest point and speed at the end of ``THREE_BOUNCES`` seconds, exactly."""
    time, speed = math.sqrt(2.0 / 10.0), 0.8 * math.sqrt(20.0)
    while time + 2.0 * speed / 10.0 < THREE_BOUNCES:
        time, speed = time + 2.0 * speed / 10.0, 0.8 * speed
    rest = THREE_BOUNCES - time
    return speed * rest - 5.0 * rest**2, speed - 10.0 * rest


def disc_on_spring(stiffness: float) -> lf.Scene:
    """A disc of 1 kg on a spring to the origin, drawn out by 0.1 m of its 1 m, without gravity."""
    scene = lf.Scene(gravity=(0.0, 0.0))
    disc = scene.add(lf.Disc(0.1, mass=1.0), "disc", position=(1.1, 0.0))
    scene.load(lf.Spring(disc.point("center"), scene.ground.at(0.0, 0.0), stiffness=stiffness, length=1.0))
    return scene


def soft_beam(damping: float = 0.0) -> Any:
    """1 m of a soft beam with two modes."""
    return lf.Beam(1.0, 0.05, 0.01, 1000.0, 2e8, axial=False).reduce(modes=2, damping=damping)


def swinging_beam(damping: float = 0.0) -> lf.Scene:
    """A soft beam, hinged at one end, swings: joint rows and large rotation."""
    scene = lf.Scene(gravity=(0.0, -9.81))
    beam = scene.add(soft_beam(damping), "beam", angular_velocity=3.0)
    scene.join(lf.Revolute(beam.point("left"), scene.ground.at(0.0, 0.0)))
    return scene


def sliding_beam() -> lf.Scene:
    """The end of a swinging beam slides along a wall with friction: joints, closed contact and sliding column."""
    scene = lf.Scene(gravity=(0.0, -9.81))
    beam = scene.add(soft_beam(), "beam", angle=0.5, position=(0.0, 0.0))
    foot = (math.cos(0.5), math.sin(0.5))
    scene.join(lf.PointOnLine(beam.point("left"), scene.ground.at(0.0, 0.0), axis=(1.0, 0.0)))
    wall = scene.ground.half_plane((0.0, foot[1] - 0.02), (0.0, 1.0))
    disc = scene.add(lf.Disc(radius=0.02, mass=0.1), "disc", position=foot)
    scene.join(lf.Weld(disc.point("center"), beam.point("right")))
    scene.contact(disc.surface(), wall, friction=0.2)
    return scene


def pendulum_into_stop() -> lf.Scene:
    """A flexible pendulum swings into a rough stop."""
    body = lf.Beam(0.7, 0.028, 0.005, density=2700.0, youngs_modulus=6.9e10, elements=10).reduce(modes=4)
    scene = lf.Scene()
    bar = scene.add(body, name="bar", angle=-1.45, angular_velocity=-2.0)
    scene.join(lf.Revolute(bar.point("left"), scene.ground.at(0.0, 0.0)))
    scene.contact(bar.surface(), scene.ground.circle((-0.0125, -0.69), 0.01), friction=0.3, name="stop")
    return scene


def bar_between_walls(
    elements: int, length: float, modulus: float, start: float, play: float, restitution: float = 0.0
) -> lf.Scene:
    """An elastic bar of 1 kg/m flies with 10 m/s to the left wall, ``start`` away, and to and fro over ``play``."""
    scene = lf.Scene(gravity=(0.0, 0.0))
    body = lf.Bar(length, area=1.0, density=1.0, youngs_modulus=modulus, elements=elements).reduce(modes=None)
    bar = scene.add(body, name="bar", position=(start, 0.0), velocity=(-10.0, 0.0))
    for name, end, x, sign in (("left", 0.0, 0.0, 1.0), ("right", length, length + play, -1.0)):
        wall = scene.ground.half_plane((x, 0.0), (sign, 0.0))
        scene.contact(bar.node(end, 0.0), wall, restitution=restitution, name=name)
    return scene


def beam_struck_by_disc(mass: float, x: float = 0.2, **contact: Any) -> lf.Scene:
    """A beam on two supports, 0.4 m apart, is struck by a disc with 1 m/s at ``x``."""
    body = lf.Beam(0.4, 0.02, 0.01, density=7800.0, youngs_modulus=2.1e11, elements=40).reduce(modes=20)
    scene = lf.Scene(gravity=(0.0, 0.0))
    beam = scene.add(body, name="beam")
    scene.join(lf.Revolute(beam.point("left"), scene.ground.at(0.0, 0.0)))
    scene.join(lf.PointOnLine(beam.point("right"), scene.ground.at(0.4, 0.0), axis=(1.0, 0.0)))
    disc = scene.add(lf.Disc(radius=0.01, mass=mass), "disc", position=(x, 0.0151), velocity=(0.0, -1.0))
    scene.contact(disc.surface(), beam.surface("top"), **contact)
    return scene


def grazing_disc(overlap: float, aside: float = 0.0, *, size: float = 1.0, **contact: Any) -> lf.Scene:
    """A disc flies past a round post of its own radius, 0.1 ``size``, and touches it by ``overlap`` in passing."""
    scene = lf.Scene(gravity=(0.0, 0.0))
    place = (-0.5 * size, (0.2 - overlap) * size)
    disc = scene.add(lf.Disc(0.1 * size, mass=1.0 / size), "disc", position=place, velocity=(size, 0.0))
    post = scene.ground.circle((0.0, -aside * size), 0.1 * size)
    scene.contact(disc.surface(), post, restitution=0.5, **contact)
    return scene


def shot_at_thin_wall(
    speed: float = 100.0, start: float = -0.05, height: float = 0.0, *, size: float = 1.0, **contact: Any
) -> lf.Scene:
    """A disc of 5 mm radius flies at a wall that is 2 mm thick and 200 mm high; ``size``: 1 m in units of length."""
    scene = lf.Scene(gravity=(0.0, 0.0))
    disc = scene.add(
        lf.Disc(0.005 * size, mass=0.01 / size),
        "disc",
        position=(start * size, height * size),
        velocity=(speed * size, 0.0),
    )
    corners = [(0.0, -0.1), (0.002, -0.1), (0.002, 0.1), (0.0, 0.1)]
    wall = scene.ground.chain([(x * size, y * size) for x, y in corners], closed=True)
    scene.contact(disc.surface(), wall, **{"name": "wall", **contact})
    return scene
