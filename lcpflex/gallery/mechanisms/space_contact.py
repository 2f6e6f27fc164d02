"""Bodies that slide, roll and spin on planes in space, each with a reference of its own."""

from __future__ import annotations

import math

import numpy as np

from lcpflex.bodies.spatial.body import SpatialBody, rigid_point
from lcpflex.bodies.spatial.rigid import Sphere
from lcpflex.errors import in_range
from lcpflex.gallery.mechanisms.arguments import checked
from lcpflex.runs.case import Case
from lcpflex.scene.spatial.scene import SpatialScene
from lcpflex.steppers.event_driven.stepper import EventDriven

__all__ = ["billiard_ball", "euler_disc", "puck", "rolling_disc", "sliding_puck", "tippe_top"]

UP = (0.0, 0.0, 1.0)
FLOOR = (0.0, 0.0, 0.0)
BALL = 0.028575  # radius of a billiard ball [m]
DISC = 0.1  # radius of discs and pucks [m]
GRAVITY = 9.81
LARGE, SMALL, LARGE_AT, SMALL_AT = 0.015, 0.005, 0.003, 0.016  # spheres of the tippe top and their places [m]


@checked
def billiard_ball(friction: float = 0.2, forward: float = 2.0, spin: float = 7.0) -> SpatialScene:
    """A billiard ball that is struck: it slides on a curve until it rolls; its spin about the normal stays.

    forward: speed at the start [m/s]. spin: about the normal [rad/s]; about the other two axes it is 15 and -30 rad/s.
    """
    scene = SpatialScene()
    ball = scene.add(
        Sphere(radius=BALL, mass=0.17),
        name="ball",
        position=(0.0, 0.0, BALL),
        velocity=(forward, 0.0, 0.0),
        angular_velocity=(15.0, -30.0, spin),
    )
    scene.contact(ball.surface(), scene.ground.plane(FLOOR, UP), friction=friction, name="cloth")
    return scene


def _puck(scene: SpatialScene, friction: float, velocity: tuple[float, float, float], spin: float) -> None:
    """A puck on three feet at its rim, in the plane of its mass centre: friction tips it not."""
    angles = 2.0 * math.pi * np.arange(3) / 3.0
    feet = {f"foot{k}": rigid_point(DISC * math.cos(a), DISC * math.sin(a), 0.0) for k, a in enumerate(angles)}
    inertia = 0.25 * DISC**2 * np.diag([1.0, 1.0, 2.0])
    body = SpatialBody(mass=1.0, inertia=inertia, points=feet)
    puck = scene.add(body, name="puck", velocity=velocity, angular_velocity=(0.0, 0.0, spin))
    floor = scene.ground.plane(FLOOR, UP)
    for name in feet:
        scene.contact(puck.node(name), floor, friction=friction, name=name)


@checked
def sliding_puck(degrees: float = 25.0, friction: float = math.tan(math.radians(25.0))) -> SpatialScene:
    """A puck that starts across a slope at 1 m/s: friction turns it downhill. x is across, -y down the slope.

    degrees: slope, by which gravity leans and not the plane. friction: tan(slope) by default, so that the speed and the
    part of it down the slope have a constant sum.
    """
    slope = math.radians(degrees)
    scene = SpatialScene(gravity=(0.0, -GRAVITY * math.sin(slope), -GRAVITY * math.cos(slope)))
    _puck(scene, friction, (1.0, 0.0, 0.0), 0.0)
    return scene


@checked
def puck(friction: float = 0.2, speed: float = 1.0, spin: float = 10.0) -> SpatialScene:
    """A puck on three feet that slides and spins on a level floor until it stops.

    speed: along x, where the first foot points [m/s]. spin: [rad/s].
    """
    scene = SpatialScene()
    _puck(scene, friction, (speed, 0.0, 0.0), spin)
    return scene


def _disc(
    scene: SpatialScene, friction: float, tilt: float, velocity: tuple[float, float, float], omega: object
) -> None:
    """A thin disc of 1 kg on its rim, its axis leaning by ``tilt`` [rad] from the vertical towards y."""
    cos, sin = math.cos(tilt), math.sin(tilt)
    inertia = 0.25 * DISC**2 * np.diag([1.0, 1.0, 2.0])
    body = SpatialBody(mass=1.0, inertia=inertia)
    disc = scene.add(
        body,
        name="disc",
        position=(0.0, 0.0, DISC * sin),
        orientation=np.array([[1.0, 0.0, 0.0], [0.0, cos, -sin], [0.0, sin, cos]]),
        velocity=velocity,
        angular_velocity=np.asarray(omega, dtype=float),
    )
    rim = disc.rim((0.0, 0.0, 0.0), (0.0, 0.0, 1.0), DISC)
    scene.contact(rim, scene.ground.plane(FLOOR, UP), friction=friction, name="rim")


def euler_rate(degrees: float) -> float:
    """Rate W at which the point of contact of a thin disc, its centre at rest, goes around [rad/s]."""
    return math.sqrt(4.0 * GRAVITY / (DISC * math.sin(math.radians(degrees))))


@checked
def euler_disc(degrees: float = 60.0, friction: float = 1.0) -> SpatialScene:
    """A thin disc that rolls on its rim about its own centre, which stays at rest.

    The point of contact goes around at W = sqrt(4 g / (R sin a)), and the disc turns at W sin(a) about the diameter
    through it. degrees: inclination a of its plane, 0.1 to 90.
    """
    lean = math.radians(in_range("degrees", degrees, 0.1, 90.0))
    down = np.array([0.0, -math.cos(lean), -math.sin(lean)])  # from the centre to the lowest point of the rim
    scene = SpatialScene()
    _disc(scene, friction, lean, (0.0, 0.0, 0.0), -euler_rate(degrees) * math.sin(lean) * down)
    return scene


@checked
def rolling_disc(speed: float = 0.65, lean_rate: float = 1e-4, friction: float = 1.0) -> SpatialScene:
    """A thin disc that rolls upright along x; it is stable above sqrt(g R / 3) = .572 m/s.

    lean_rate: at which it leans at the start [rad/s].
    """
    scene = SpatialScene()
    velocity = (speed, -lean_rate * DISC, 0.0)
    _disc(scene, friction, 0.5 * math.pi, velocity, (lean_rate, speed / DISC, 0.0))
    return scene


def leaning_rate(speed: float) -> float:
    """Rate at which a thin disc that rolls upright sways [rad/s]: sqrt(12 v^2 / (5 R^2) - 4 g / (5 R))."""
    return math.sqrt(2.4 * (speed / DISC) ** 2 - 0.8 * GRAVITY / DISC)


@checked
def tippe_top(spin: float = 180.0, lean: float = 0.1, friction: float = 0.3) -> SpatialScene:
    """A top that turns over: two spheres on one axis, the mass centre below that of the large one.

    spin: about the vertical [rad/s]. lean: of the axis at the start [rad]. One that spins about its own axis instead
    begins to roll before it turns over.
    """
    sin, cos = math.sin(lean), math.cos(lean)
    scene = SpatialScene()
    top = scene.add(
        SpatialBody(mass=6e-3, inertia=np.diag([8e-7, 8e-7, 7e-7])),
        name="top",
        position=(0.0, 0.0, LARGE - LARGE_AT * cos),
        orientation=np.array([[1.0, 0.0, 0.0], [0.0, cos, -sin], [0.0, sin, cos]]),
        angular_velocity=(0.0, 0.0, spin),
    )
    floor = scene.ground.plane(FLOOR, UP)
    scene.contact(top.sphere((0.0, 0.0, LARGE_AT), LARGE), floor, friction=friction, name="large")
    scene.contact(top.sphere((0.0, 0.0, SMALL_AT), SMALL), floor, friction=friction, name="small")
    return scene


def cases() -> tuple[Case, ...]:
    """Those of this module."""
    rate = leaning_rate(0.65)
    largest = 1e-4 / rate
    return (
        Case(
            "billiard_ball",
            "billiard ball that slides on a curve and then rolls",
            billiard_ball,
            0.6,
            EventDriven(),
            {"rolls": 0.420739889, "v_x": 1.18364286, "v_y": -0.12246429, "spin": 7.0},
            "closed form",
        ),
        Case(
            "sliding_puck",
            "puck that slides across a slope and turns downhill",
            sliding_puck,
            0.3,
            EventDriven(),
            {"across": 0.13577602, "down": 0.49078244},
            "closed form",
        ),
        Case(
            "puck",
            "puck on three feet that slides and spins until it stops",
            puck,
            0.7,
            EventDriven(),
            {"stops": 0.6129201, "x": 0.3221555, "y": 0.0040920, "angle": 2.6321765},
            "equations of motion, to 1e-9",
        ),
        Case(
            "euler_disc",
            "thin disc that rolls on its rim about its centre",
            euler_disc,
            3.25 * 2.0 * math.pi / euler_rate(60.0),
            EventDriven(),
            {"inclination": math.radians(60.0), "rate": euler_rate(60.0), "moved": 0.0},
            "closed form",
        ),
        Case(
            "rolling_disc",
            "thin disc that rolls upright faster than it falls over",
            rolling_disc,
            1.5,
            EventDriven(),
            {"lean": largest * math.sin(1.5 * rate), "largest_lean": largest},
            "closed form of small leans: stable above sqrt(g R / 3)",
        ),
        Case(
            "tippe_top",
            "tippe top that turns over on a rough floor",
            tippe_top,
            3.0,
            EventDriven(),
            {"lean_at_1_s": 2.22535347352, "Jellett's_number": 1.0},
            "data of Leine & Glocker (2003); equations of motion of one sphere that slides, to 1e-11",
        ),
    )
