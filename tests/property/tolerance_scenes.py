"""Scenes for runs to a tolerance: traps, in which a wrong choice is tempting, bodies with modes, and drawn ones."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import lcpflex as lf
from lcpflex.gallery.collection import scenes as gallery
from tests.property.built_scenes import build
from tests.property.random_scenes import draw

__all__ = ["SCENES", "Asked", "by_name"]

STEEL = {"density": 7800.0, "youngs_modulus": 2.1e11}
UP, FLOOR = (0.0, 1.0), (0.0, 0.0)
DOWN = (0.0, -9.81)
PLANE_SEEDS = (41000, 41002, 41003, 41004, 41005, 41010, 41012, 41017)
SPACE_SEEDS = (41000, 41002, 41003, 41004, 41010)


@dataclass(frozen=True)
class Asked:
    """A scene, for how long, and what it is."""

    name: str
    build: Callable[[], Any]
    duration: float
    kind: str  # "trap", "modes", "drawn", "usual"


def graze() -> Any:
    """A disc passes a fixed one, 2 um too near: fixed steps fly by."""
    scene = lf.Scene(gravity=(0.0, 0.0))
    disc = scene.add(lf.Disc(radius=0.1, mass=1.0), "disc", (-0.5, 0.2 - 2e-6), velocity=(1.0, 0.0))
    scene.contact(disc.surface(), scene.ground.circle((0.0, 0.0), 0.1), restitution=1.0)
    return scene


def pulsed(force: Any) -> Any:
    """A disc that rests on a floor with friction is pushed for 30 us of a second."""
    scene = lf.Scene(gravity=DOWN)
    disc = scene.add(lf.Box(0.1, 0.1, mass=1.0), "box", (0.0, 0.05))
    scene.contact(disc.surface(), scene.ground.half_plane(FLOOR, UP), friction=0.3)
    scene.load(lf.Force(disc.at(0.0, 0.0), (force, 0.0)))
    return scene


def pulse() -> Any:
    """The push as a Python function."""
    return pulsed(lambda t: 3e4 if 0.3333 < t < 0.33333 else 0.0)


def pulse_table() -> Any:
    """The push as a table."""
    return pulsed(lf.Table([0.0, 0.3333, 0.33331, 0.33332, 0.33333, 1.0], [0.0, 0.0, 4.5e4, 4.5e4, 0.0, 0.0]))


def pulse_of_state() -> Any:
    """The push as a function of time and state."""
    return pulsed(lambda t, state: 3e4 if 0.3333 < t < 0.33333 else 0.0)


def shaken_beam(modes: int, omega: float = 400.0, force: float = 5.0) -> Any:
    """A thin beam on a hinge, shaken at its end, near its third mode by default."""
    scene = lf.Scene(gravity=(0.0, 0.0))
    beam = lf.Beam(length=0.5, width=0.02, thickness=0.001, elements=12, **STEEL)
    arm = scene.add(beam, "arm", (0.0, 0.3), modes=modes)
    scene.join(lf.Revolute(arm.point("left"), scene.ground.at(0.0, 0.3), name="hinge"))
    scene.load(lf.Force(arm.point("right"), (0.0, lf.Harmonic(force, omega))))
    return scene


def locking_mesh() -> Any:
    """A cantilever of triangles of first order, which lock in bending, loaded at its end."""
    scene = lf.Scene(gravity=(0.0, 0.0))
    mesh = lf.meshes.rectangle(0.4, 0.02, 16, 1, triangles=True, order=1)
    body = lf.Continuum(mesh, thickness=0.01, poissons_ratio=0.3, **STEEL)
    arm = scene.add(body, "arm", modes=4)
    for k, y in enumerate((0.0, 0.02)):
        scene.join(lf.Revolute(arm.at(0.0, y), scene.ground.at(0.0, y), name=f"wall {k}"))
    scene.load(lf.Force(arm.at(0.4, 0.02), (0.0, lf.Harmonic(100.0, 60.0))))
    return scene


def shaken_plate() -> Any:
    """A block on a plate that is driven to and fro sticks and slips."""
    scene = lf.Scene(gravity=DOWN)
    plate = scene.add(lf.Box(0.6, 0.05, mass=5.0), "plate", (0.0, 0.0), velocity=(0.4, 0.0))
    scene.join(lf.Prismatic(plate.at(0.0, 0.0), scene.ground.at(0.0, 0.0), (1.0, 0.0), name="guide"))
    motion = lf.Harmonic(0.02, 20.0)
    scene.join(lf.DrivenDisplacement(plate.at(0.0, 0.0), scene.ground.at(0.0, 0.0), motion, (1.0, 0.0), name="drive"))
    block = scene.add(lf.Box(0.1, 0.05, mass=1.0), "block", (0.0, 0.05), velocity=(0.4, 0.0))
    scene.contact(block.surface(), plate.surface(), friction=0.4)
    return scene


def touch_of_law() -> Any:
    """A ball meets a stiff law for 50 us, after some flight."""
    scene = lf.Scene(gravity=DOWN)
    disc = scene.add(lf.Disc(radius=0.01, mass=0.1), "ball", (0.0, 0.06), velocity=(0.2, 0.0))
    law = lf.ContactLaw(lf.laws.PowerLaw(4e8, 1.0))
    scene.contact(disc.surface(), scene.ground.half_plane(FLOOR, UP), law=law)
    return scene


def skimmed_law() -> Any:
    """A ball skims a round stop by law: .3 um deep."""
    scene = lf.Scene(gravity=(0.0, 0.0))
    disc = scene.add(lf.Disc(radius=0.1, mass=0.1), "ball", (-0.5, 0.2 - 3e-7), velocity=(1.0, 0.0))
    law = lf.ContactLaw(lf.laws.PowerLaw(1e7, 1.0))
    scene.contact(disc.surface(), scene.ground.circle((0.0, 0.0), 0.1), law=law)
    return scene


def spinning_box() -> Any:
    """A box spins and slides on its four corners: how they share its weight is a choice."""
    scene = lf.SpatialScene(gravity=(0.0, 0.0, -9.81))
    box = scene.add(
        lf.Cuboid(0.2, 0.1, 0.06, mass=1.0), "box", (0.0, 0.0, 0.03), velocity=(0.5, 0.0, 0.0),
        angular_velocity=(0.0, 0.0, 6.0),
    )  # fmt: skip
    scene.contact(box.surface(), scene.ground.plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0)), friction=0.3)
    return scene


def ratchet() -> Any:
    """A pawl on a spring slides over a row of teeth that lean."""
    scene = lf.Scene(gravity=DOWN)
    pawl = scene.add(lf.Disc(radius=0.01, mass=0.2), "pawl", (-0.03, 0.0145), velocity=(1.0, 0.0))
    arm = scene.add(lf.Box(0.05, 0.02, mass=0.2), "arm", (-0.03, 0.0645), velocity=(1.0, 0.0))
    scene.join(lf.Revolute(pawl.at(0.0, 0.0), arm.at(0.0, -0.05), name="pin"))
    teeth = [(-0.05 + 0.04 * (k // 2) + (0.039 if k % 2 else 0.0), 0.0 if k % 2 == 0 else 0.004) for k in range(30)]
    scene.contact(pawl.surface(), scene.ground.chain(teeth[::-1]), friction=0.2)
    return scene


def break_of_discs() -> Any:
    """A cue disc breaks nine others between four walls: chaos."""
    scene = lf.Scene(gravity=(0.0, 0.0))
    discs = [scene.add(lf.Disc(radius=0.1, mass=1.0), f"d{k}", (0.25 * (k // 3), 0.25 * (k % 3))) for k in range(9)]
    discs.append(scene.add(lf.Disc(radius=0.1, mass=1.0), "cue", (-1.0, 0.33), velocity=(3.0, 0.0)))
    walls = (((-1.5, 0.0), (1.0, 0.0)), ((1.0, 0.0), (-1.0, 0.0)), ((0.0, -0.6), (0.0, 1.0)), ((0.0, 1.2), (0.0, -1.0)))
    for k, one in enumerate(discs):
        for wall, normal in walls:
            scene.contact(one.surface(), scene.ground.half_plane(wall, normal), restitution=1.0)
        for other in discs[:k]:
            scene.contact(one.surface(), other.surface(), restitution=1.0)
    return scene


def hung(modes: int, thickness: float, gap: float, elements: int = 12) -> Any:
    """A beam on a hinge falls on a ball."""
    scene = lf.Scene(gravity=DOWN)
    beam = lf.Beam(length=0.5, width=0.02, thickness=thickness, elements=elements, **STEEL)
    arm = scene.add(beam, "arm", (0.0, 0.3), modes=modes)
    scene.join(lf.Revolute(arm.point("left"), scene.ground.at(0.0, 0.3), name="hinge"))
    top = 0.3 - 0.5 * thickness - gap
    scene.contact(arm.surface("bottom"), scene.ground.circle((0.4, top - 0.02), 0.02), friction=0.2, name="stop")
    return scene


def struck_cantilever(modes: int) -> Any:
    """A ball falls on the end of a cantilever."""
    scene = lf.Scene(gravity=DOWN)
    beam = lf.Beam(length=0.5, width=0.02, thickness=0.005, elements=16, **STEEL)
    arm = scene.add(beam, "arm", (0.0, 0.0), modes=modes)
    scene.join(lf.Weld(arm.point("left"), scene.ground.at(0.0, 0.0), name="wall"))
    ball = scene.add(lf.Disc(radius=0.02, mass=0.2), "ball", (0.45, 0.05))
    scene.contact(ball.surface(), arm.surface("top"), name="touch")
    return scene


def swung_rod(modes: int) -> Any:
    """A rod of space on a ball joint is swung at its end."""
    scene = lf.SpatialScene(gravity=(0.0, 0.0, -9.81))
    rod = lf.SpatialBeam(
        0.5, 2e-4, (1.7e-9, 6.7e-9), 4.6e-9, density=7800.0, youngs_modulus=2.1e11, poissons_ratio=0.3, elements=8
    )
    body = scene.add(rod.reduce(modes, interfaces=["left", "right"]), "rod", (0.25, 0.0, 0.0))
    scene.join(lf.Ball(body.point("left"), scene.ground.at(0.0, 0.0, 0.0), name="joint"))
    scene.load(lf.Force(body.point("right"), (0.0, lf.Harmonic(300.0, 200.0), 0.0)))
    return scene


def crank(modes: int) -> Any:
    """A slider-crank with a flexible rod whose slider has a stop."""
    scene = lf.Scene(gravity=(0.0, 0.0))
    wheel = scene.add(lf.Box(0.1, 0.01, mass=0.5), "crank", (0.05, 0.0), angular_velocity=30.0, velocity=(0.0, 1.5))
    rod = lf.Beam(length=0.3, width=0.01, thickness=0.004, elements=10, **STEEL)
    arm = scene.add(rod, "rod", (0.1, 0.0), velocity=(0.0, 3.0), angular_velocity=-10.0, modes=modes)
    slider = scene.add(lf.Box(0.03, 0.03, mass=0.3), "slider", (0.4, 0.0))
    scene.join(lf.Revolute(wheel.at(-0.05, 0.0), scene.ground.at(0.0, 0.0), name="axle"))
    scene.join(lf.Revolute(wheel.at(0.05, 0.0), arm.point("left"), name="pin"))
    scene.join(lf.Revolute(arm.point("right"), slider.at(0.0, 0.0), name="wrist"))
    scene.join(lf.Prismatic(slider.at(0.0, 0.0), scene.ground.at(0.4, 0.0), (1.0, 0.0), name="guide"))
    return scene


def _drawn(dimension: int, seed: int) -> Asked:
    drawn = draw(dimension, seed)
    return Asked(f"drawn {dimension} {seed}", lambda: build(drawn), drawn.duration, "drawn")


def _usual(name: str, duration: float | None = None) -> Asked:
    case = gallery()[name]
    return Asked(name, case.build, duration or case.duration, "usual")


SCENES: tuple[Asked, ...] = (
    Asked("graze", graze, 1.0, "trap"),
    Asked("pulse", pulse, 1.0, "trap"),
    Asked("pulse table", pulse_table, 1.0, "trap"),
    Asked("pulse of state", pulse_of_state, 1.0, "trap"),
    Asked("locking mesh", locking_mesh, 0.2, "trap"),
    Asked("shaken plate", shaken_plate, 2.0, "trap"),
    Asked("touch of a law", touch_of_law, 0.3, "trap"),
    Asked("skimmed law", skimmed_law, 1.0, "trap"),
    Asked("spinning box", spinning_box, 0.3, "trap"),
    Asked("ratchet", ratchet, 0.25, "trap"),
    Asked("break", break_of_discs, 3.0, "trap"),
    Asked("too few modes", lambda: shaken_beam(1), 0.2, "modes"),
    Asked("enough modes", lambda: shaken_beam(8), 0.2, "modes"),
    Asked("slowly shaken", lambda: shaken_beam(6, 90.0, 0.3), 0.3, "modes"),
    Asked("hung", lambda: hung(4, 0.01, 0.02), 0.1, "modes"),
    Asked("hung thin", lambda: hung(8, 0.003, 0.01), 0.08, "modes"),
    Asked("cantilever", lambda: struck_cantilever(6), 0.12, "modes"),
    Asked("rod of space", lambda: swung_rod(4), 0.1, "modes"),
    Asked("crank", lambda: crank(4), 0.2, "modes"),
    _usual("painleve_rod"),
    _usual("stack"),
    _usual("rocking_block", 2.0),
    _usual("double_pendulum"),
    _usual("bouncing_ball"),
    _usual("puck"),
    _usual("three_balls"),
    _usual("spherical_pendulum"),
    *(_drawn(2, seed) for seed in PLANE_SEEDS),
    *(_drawn(3, seed) for seed in SPACE_SEEDS),
)


def by_name(name: str) -> Asked:
    """One of them."""
    return next(one for one in SCENES if one.name == name)
