"""Scenes whose mechanics at a state are known."""

from __future__ import annotations

import lcpflex as lf
from tests.scenes import floor_of

LENGTH, MASS = 1.0, 2.0  # of the pendulum


def sliding_block(speed: float = 1.0, friction: float = 0.3) -> lf.Scene:
    """0.2 m wide and 0.1 m high, 2 kg."""
    scene = lf.Scene(gravity=(0.0, -10.0))
    block = scene.add(lf.Box(0.2, 0.1, mass=2.0), "block", position=(0.0, 0.05), velocity=(speed, 0.0))
    scene.contact(block.surface(), floor_of(scene), name="floor", friction=friction, restitution=0.2)
    return scene


def rod_on_two_supports(slip: float = 0.0) -> lf.Scene:
    """A uniform rod on a rough support at -0.5 m and a smooth one at 0.25 m from its middle."""
    scene = lf.Scene(gravity=(0.0, -10.0))
    rod = scene.add(lf.Box(2.0, 0.02, mass=3.0), "rod", position=(0.0, 0.01), velocity=(slip, 0.0))
    for x, mu in ((-0.5, 0.4), (0.25, 0.0)):
        support = scene.ground.circle((x, -0.1), 0.1)
        scene.contact(rod.surface(), support, name=f"support at {x}", friction=mu)
    return scene


def pendulum_at_stop(speed: float = 0.0, restitution: float = 0.5) -> lf.Scene:
    """A disc on a massless rod, level to the right of its hinge, upon a stop; it approaches at ``speed``."""
    scene = lf.Scene(gravity=(0.0, -10.0))
    disc = lf.RigidBody(mass=MASS, inertia=0.1, points={"hinge": (-LENGTH, 0.0)})
    bob = scene.add(disc, "bob", position=(LENGTH, 0.0), velocity=(0.0, -speed), angular_velocity=-speed / LENGTH)
    scene.join(lf.Revolute(bob.point("hinge"), scene.ground.at(0.0, 0.0), name="hinge"))
    stop = scene.ground.half_plane((0.0, -0.1), (0.0, 1.0))
    scene.contact(bob.circle((0.0, 0.0), 0.1), stop, name="stop", restitution=restitution)
    return scene


def flexible_beam(speed: float = 0.5, fall: float = 0.0) -> lf.Scene:
    """A beam with a weight that swings from its end by a hinge, on two rough supports that it strikes at ``fall``."""
    scene = lf.Scene(gravity=(0.0, -9.81))
    strip = lf.Beam(length=1.0, width=0.03, thickness=0.006, density=7800.0, youngs_modulus=2.1e11)
    beam = scene.add(strip, name="strip", modes=9, damping=0.01, velocity=(speed, -fall))
    swing = {"velocity": (speed + 0.2, -fall), "angular_velocity": 2.0}
    weight = scene.add(lf.Box(0.04, 0.2, mass=0.3), "weight", position=(1.0, -0.1), **swing)
    scene.join(lf.Revolute(weight.at(0.0, 0.1), beam.point("right"), name="hinge"))
    for x in (0.2, 0.7):
        support = scene.ground.circle((x, -0.023), 0.02)
        scene.contact(beam.surface(), support, name=f"support at {x}", friction=0.3, restitution=0.4)
    return scene


SCENES = {
    "block": sliding_block,
    "rod": rod_on_two_supports,
    "pendulum": pendulum_at_stop,
    "beam": flexible_beam,
}
