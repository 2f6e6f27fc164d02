"""Scenes that need rigid bodies, few modes, modes of one body only, many modes, and modes of a mesh."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

import lcpflex as lf
from lcpflex import gallery
from lcpflex.bodies.continuum import Continuum
from lcpflex.bodies.fem import meshes
from lcpflex.scene.scene import Scene
from tests.scenes import floor_of

STEEL = {"density": 7800.0, "youngs_modulus": 2.1e11}


@dataclass(frozen=True)
class Question:
    """A scene, how it is run, what is asked, and what must be the answer of every body that may be rigid."""

    build: Callable[[], Scene]
    duration: float
    stepper: Any
    tolerance: float
    rigid: tuple[str, ...] = ()
    outputs: Any = None


def sled() -> Scene:
    """A stout beam slides to rest on two feet."""
    scene = Scene()
    beam = lf.Beam(length=0.3, width=0.02, thickness=0.02, elements=30, **STEEL).reduce(2, damping=0.02)
    body = scene.add(beam, "sled", (0.0, 0.01), velocity=(0.5, 0.0))
    floor = floor_of(scene)
    for x in (0.05, 0.25):
        scene.contact(body.node(x, -0.01), floor, friction=0.3)
    return scene


def strip(elements: int = 40) -> Scene:
    """A pendulum meets a round stop."""
    scene = Scene()
    beam = lf.Beam(length=0.7, width=0.028, thickness=0.01, density=2700.0, youngs_modulus=6.9e10, elements=elements)
    body = scene.add(beam.reduce(2, damping=0.02), "pendulum", angular_velocity=-1.0)
    scene.join(lf.Revolute(body.point("left"), scene.ground.at(0.0, 0.0)))
    scene.contact(body.node(0.5, -0.005), scene.ground.circle((0.5, -0.0151), 0.01))
    return scene


def hung() -> Scene:
    """A slender beam with a stout load at its tip falls onto a stop in its middle."""
    scene = Scene()
    slender = lf.Beam(length=0.8, width=0.03, thickness=0.008, elements=30, **STEEL).reduce(2, damping=0.02)
    stout = lf.Beam(length=0.1, width=0.03, thickness=0.03, elements=10, **STEEL).reduce(2, damping=0.02)
    arm, load = scene.add(slender, "slender"), scene.add(stout, "stout", (0.75, 0.0))
    scene.join(lf.Revolute(arm.point("left"), scene.ground.at(0.0, 0.0)))
    scene.join(lf.Revolute(load.point("center"), arm.point("right")))
    scene.contact(arm.node(0.4, -0.004), scene.ground.circle((0.4, -0.0141), 0.01))
    return scene


def striker() -> Scene:
    """A stout body falls onto a slender beam between two supports."""
    scene = Scene()
    slender = lf.Beam(length=0.8, width=0.03, thickness=0.008, elements=30, **STEEL).reduce(2, damping=0.02)
    stout = lf.Beam(length=0.08, width=0.03, thickness=0.03, elements=6, **STEEL).reduce(2, damping=0.02)
    beam, hammer = scene.add(slender, "slender"), scene.add(stout, "stout", (0.26, 0.0191), velocity=(0.0, -1.0))
    scene.join(lf.Revolute(beam.point("left"), scene.ground.at(0.0, 0.0)))
    scene.join(lf.PointOnLine(beam.point("right"), scene.ground.at(0.8, 0.0), (1.0, 0.0)))
    scene.contact(hammer.node(0.04, -0.015), beam.surface("top"))
    return scene


def chain() -> Scene:
    """Two slender beams and a stout one, hinged to each other and to a wall; the first falls onto a stop."""
    scene = Scene()
    where, placed = 0.0, []
    for name, length, thickness in (("first", 0.5, 0.008), ("second", 0.4, 0.006), ("third", 0.1, 0.03)):
        beam = lf.Beam(length=length, width=0.03, thickness=thickness, elements=int(30 * length), **STEEL)
        placed.append(scene.add(beam.reduce(2, damping=0.02), name, (where, 0.0)))
        where += length
    for before, after in pairwise([None, *placed]):
        hinge = scene.ground.at(0.0, 0.0) if before is None else before.point("right")
        scene.join(lf.Revolute(after.point("left"), hinge))
    scene.contact(placed[0].node(0.25, -0.004), scene.ground.circle((0.25, -0.0141), 0.01))
    return scene


def block() -> Scene:
    """A block, meshed, flies end on against a wall: of its lowest modes, which bend it, the wall excites none."""
    scene = Scene(gravity=(0.0, 0.0))
    mesh = Continuum(meshes.rectangle(0.2, 0.02, 24, 2), poissons_ratio=0.3, thickness=0.02, **STEEL)
    body = scene.add(mesh.reduce(2, damping=0.02), "block", (1e-4, 0.0), velocity=(-1.0, 0.0))
    scene.contact(body.surface("left"), scene.ground.half_plane((0.0, 0.0), (1.0, 0.0)))
    return scene


def bar() -> Scene:
    """A bar strikes a wall: the energy that N modes lose falls as 1/N."""
    return gallery.elastic_bar(elements=200)


QUESTIONS = {
    "sled": Question(sled, 0.15, lf.GeneralizedAlpha(step=1e-4), 0.01, rigid=("sled",)),
    "strip": Question(strip, 0.03, lf.GeneralizedAlpha(step=5e-6), 0.03, outputs=("motion",)),
    "hung": Question(hung, 0.1, lf.GeneralizedAlpha(step=2e-5), 0.03, rigid=("stout",)),
    "striker": Question(striker, 0.02, lf.GeneralizedAlpha(step=4e-6), 0.07, rigid=("stout",)),
    "chain": Question(chain, 0.05, lf.GeneralizedAlpha(step=2e-5), 0.01, rigid=("third",)),
    "block": Question(block, 3e-4, lf.GeneralizedAlpha(step=1e-7), 0.03),
    "bar": Question(bar, 1.5, lf.MoreauJean(step=5e-4), 0.01),
}


def random_question(rng: np.random.Generator) -> Question:
    """A beam of random length, thickness and speed falls onto a round stop, or swings against it, anywhere."""
    length, speed, place = rng.uniform(0.3, 1.2), rng.uniform(0.2, 3.0), rng.uniform(0.05, 0.95)
    thickness, hinged = rng.uniform(0.004, 0.02), rng.random() < 0.5
    beam = lf.Beam(length=length, width=0.03, thickness=thickness, elements=30, **STEEL)
    period = 2.0 * np.pi / float(beam.reduce(1).frequencies()[0])

    def build() -> Scene:
        scene = Scene()
        body = beam.reduce(2, damping=0.01)
        if hinged:
            placed = scene.add(body, "beam", angular_velocity=-speed / length)
            scene.join(lf.Revolute(placed.point("left"), scene.ground.at(0.0, 0.0)))
        else:
            placed = scene.add(body, "beam", velocity=(0.0, -speed))
        at = (0.3 + 0.7 * place if hinged else place) * length
        stop = scene.ground.circle((at, -0.5 * thickness - 0.01 - 1e-4), 0.01)
        scene.contact(placed.surface("bottom"), stop)
        return scene

    return Question(build, 3.0 * period, lf.GeneralizedAlpha(step=period / 2000.0), 0.03)
