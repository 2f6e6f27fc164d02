"""Flexible beams in frictional contact."""

from __future__ import annotations

import math
from functools import partial

from lcpflex.bodies.beam import Beam
from lcpflex.gallery.mechanisms.arguments import checked
from lcpflex.runs.case import Case
from lcpflex.scene.joints.revolute import Revolute
from lcpflex.scene.scene import Scene
from lcpflex.steppers.moreau_jean.stepper import MoreauJean

__all__ = ["hemisphere_pendulum", "pendulum", "sliding_beam"]

WEIGHT = (0.0, -9.81)


def aluminium_strip(length: float, width: float, thickness: float, elements: int = 40) -> Beam:
    """A beam of aluminium that bends over its ``thickness``."""
    return Beam(length, width, thickness, density=2700.0, youngs_modulus=6.9e10, elements=elements)


@checked
def pendulum(modes: int = 8, friction: float = 0.3, elements: int = 40, restitution: float = 0.0) -> Scene:
    """An aluminium strip, hinged and let go horizontally, swings down against a round stop beside its tip.

    0.7 m long, bending over its 5 mm side. The stop has a radius of 10 mm and is met when the strip hangs, 10 mm above
    the tip.
    """
    strip = aluminium_strip(length=0.7, width=0.028, thickness=0.005, elements=elements)
    scene = Scene(gravity=WEIGHT)
    bar = scene.add(strip, name="pendulum", modes=modes)
    scene.join(Revolute(bar.point("left"), scene.ground.at(0.0, 0.0), name="hinge"))
    stop = scene.ground.circle(center=(-0.0125, -0.69), radius=0.01)
    scene.contact(bar.surface(), stop, friction=friction, restitution=restitution, name="stop")
    return scene


@checked
def hemisphere_pendulum(
    modes: int = 15, friction: float = 0.3, reach: float = 0.65, speed: float = 0.4, radius: float = 0.01
) -> Scene:
    """The strip of :func:`pendulum`, let go horizontally, meets a fixed hemisphere under it.

    Bar, release and ``speed`` [m/s] of the strip where it touches are those of Shi, Hong & Liu 2013; they do not print
    ``reach`` (distance of that place from the hinge) and ``radius`` [m]: the values here are chosen. Friction is added.
    """
    half = 0.0025
    drop = math.asin(0.7 * (speed / reach) ** 2 / (3.0 * 9.81))  # rigid: omega^2 = 3 g sin(drop) / L
    face = (reach * math.cos(drop) - half * math.sin(drop), -reach * math.sin(drop) - half * math.cos(drop))
    center = (face[0] - radius * math.sin(drop), face[1] - radius * math.cos(drop))
    strip = aluminium_strip(length=0.7, width=0.028, thickness=2.0 * half)
    scene = Scene(gravity=WEIGHT)
    bar = scene.add(strip, name="pendulum", modes=modes)
    scene.join(Revolute(bar.point("left"), scene.ground.at(0.0, 0.0), name="hinge"))
    bump = scene.ground.arc(center, radius, start=0.0, extent=math.pi)
    scene.contact(bar.surface("bottom"), bump, friction=friction, restitution=0.0, name="hemisphere")
    return scene


@checked
def sliding_beam(modes: int = 8, friction: float = 0.3, roughness: float = 0.004, damping: float = 0.01) -> Scene:
    """An aluminium strip falls, slanting and moving, onto wavy ground and slides over its crests."""
    strip = aluminium_strip(length=1.0, width=0.05, thickness=0.01)
    scene = Scene(gravity=WEIGHT)
    beam = scene.add(
        strip,
        name="beam",
        position=(0.0, 0.15),
        angle=math.radians(8.0),
        velocity=(2.0, 0.0),
        modes=modes,
        damping=damping,
    )
    stations = [4.0 - 0.025 * k for k in range(181)]  # from right to left: the solid is on the left of the chain
    ground = scene.ground.chain([(x, roughness * math.cos(2.0 * math.pi * x / 0.2)) for x in stations])
    scene.contact(beam.surface(), ground, friction=friction, restitution=0.0, name="ground")
    return scene


def cases() -> tuple[Case, ...]:
    """The cases of this module."""
    return (
        Case(
            "pendulum",
            "flexible aluminium pendulum falls against a round stop, with friction",
            pendulum,
            0.6,
            MoreauJean(step=2.5e-6),  # all 21 touches; with 1e-5 the errors of the steps sum up to 16 %
            {"first_touch": 0.4044},
            "fall of a rigid rod, by an elliptic integral; the flexible one is as fast within 1 %",
        ),
        Case(
            "smooth_pendulum",
            "the same pendulum without friction: impulse of the stop in the first 50 ms",
            partial(pendulum, friction=0.0),
            0.5,
            MoreauJean(step=1e-4),
            {"first_touch": 0.4044},
            "fall of a rigid rod, by an elliptic integral",
        ),
        Case(
            "hemisphere",
            "flexible pendulum meets a hemisphere at 0.4 m/s, with friction: several contacts within milliseconds",
            hemisphere_pendulum,
            0.06,
            MoreauJean(step=2e-6),
            {"first_touch": 0.0294},
            "Shi, Hong & Liu 2013 (bar, release and speed); first touch of a rigid bar",
        ),
        Case(
            "sliding_beam",
            "flexible beam falls and slides on wavy ground, several contacts at a time",
            sliding_beam,
            1.0,
            MoreauJean(step=2e-5),
        ),
    )
