"""Rigid bodies in frictional contact, most with a closed solution."""

from __future__ import annotations

import math
from functools import partial

from lcpflex.bodies.rigid import Box, Disc, RigidBody
from lcpflex.gallery.mechanisms.arguments import checked
from lcpflex.runs.case import Case
from lcpflex.scene.functions_of_time import Harmonic
from lcpflex.scene.joints.revolute import Revolute
from lcpflex.scene.loads.force import Force
from lcpflex.scene.loads.spring import Spring
from lcpflex.scene.scene import Scene
from lcpflex.steppers.event_driven.stepper import EventDriven
from lcpflex.steppers.moreau_jean.stepper import MoreauJean

__all__ = [
    "block_on_incline",
    "bouncing_ball",
    "double_pendulum",
    "oblique_bounce",
    "painleve_friction",
    "painleve_rod",
    "rocking_block",
    "spring_block",
    "stack",
    "stick_slip_block",
    "three_balls",
]

WEIGHT = (0.0, -9.81)


@checked
def block_on_incline(friction: float = 0.4, speed: float = 2.0, degrees: float = 30.0) -> Scene:
    """A block pushed up a slope at ``speed`` [m/s]."""
    slope = math.radians(degrees)
    normal = (-math.sin(slope), math.cos(slope))
    scene = Scene(gravity=WEIGHT)
    block = scene.add(
        Box(width=0.4, height=0.2, mass=1.0),
        name="block",
        position=(0.1 * normal[0], 0.1 * normal[1]),
        angle=slope,
        velocity=(speed * math.cos(slope), speed * math.sin(slope)),
    )
    plane = scene.ground.half_plane((0.0, 0.0), normal)
    scene.contact(block.surface(), plane, friction=friction, name="slope")
    return scene


@checked
def stick_slip_block(friction: float = 0.3, force: float = 4.0, omega: float = 2.0) -> Scene:
    """A block of 1 kg on the floor, pulled by the horizontal force F sin(omega t)."""
    scene = Scene(gravity=WEIGHT)
    block = scene.add(Box(width=0.4, height=0.2, mass=1.0), name="block", position=(0.0, 0.1))
    scene.load(Force(block.point("center"), (Harmonic(force, omega), 0.0)))
    floor = scene.ground.half_plane((0.0, 0.0), (0.0, 1.0))
    scene.contact(block.surface(), floor, friction=friction, name="floor")
    return scene


@checked
def spring_block(friction: float = 0.1, start: float = 0.85e-3) -> Scene:
    """A block of 1 kg on a spring of 1e4 N/m, let go at ``start`` [m] on a rough floor; g = 10 (code_aster SDND100)."""
    scene = Scene(gravity=(0.0, -10.0))
    block = scene.add(Box(width=0.4, height=0.2, mass=1.0), name="block", position=(start, 0.1))
    scene.load(Spring(block.point("center"), scene.ground.at(-1.0, 0.1), stiffness=1e4, length=1.0))
    floor = scene.ground.half_plane((0.0, 0.0), (0.0, 1.0))
    scene.contact(block.surface(), floor, friction=friction, name="floor")
    return scene


@checked
def bouncing_ball(height: float = 1.0, restitution: float = 0.5) -> Scene:
    """A ball dropped from ``height`` [m] above the floor: infinitely many bounces in a finite time."""
    scene = Scene(gravity=WEIGHT)
    ball = scene.add(Disc(radius=0.1, mass=1.0), name="ball", position=(0.0, 0.1 + height))
    floor = scene.ground.half_plane((0.0, 0.0), (0.0, 1.0))
    scene.contact(ball.surface(), floor, restitution=restitution, name="floor")
    return scene


@checked
def oblique_bounce(friction: float = 0.2, restitution: float = 0.7) -> Scene:
    """A disc of 1 kg and 1 m radius, radius of gyration squared 0.4 m^2, meets the floor at (3, -2) m/s; no gravity."""
    scene = Scene(gravity=(0.0, 0.0))
    disc = scene.add(RigidBody(mass=1.0, inertia=0.4), name="disc", position=(0.0, 1.0), velocity=(3.0, -2.0))
    floor = scene.ground.half_plane((0.0, 0.0), (0.0, 1.0))
    rim = disc.circle(center=(0.0, 0.0), radius=1.0)
    scene.contact(rim, floor, friction=friction, restitution=restitution, name="floor")
    return scene


@checked
def three_balls(restitution: float = 1.0) -> Scene:
    """Three equal balls in a row, in contact; the first arrives at 1 m/s. No gravity."""
    scene = Scene(gravity=(0.0, 0.0))
    balls = [
        scene.add(Disc(radius=0.1, mass=1.0), name=f"ball {k + 1}", position=(0.2 * k, 0.0), velocity=(speed, 0.0))
        for k, speed in enumerate((1.0, 0.0, 0.0))
    ]
    scene.contact(balls[0].surface(), balls[1].surface(), restitution=restitution, name="first")
    scene.contact(balls[1].surface(), balls[2].surface(), restitution=restitution, name="second")
    return scene


@checked
def rocking_block(width: float = 0.2, height: float = 1.0, tilt: float = 0.5, friction: float = 0.8) -> Scene:
    """A block stands on one lower corner, tilted by ``tilt`` times its angle of toppling, and is let go."""
    angle = tilt * math.atan2(width, height)
    cos, sin = math.cos(angle), math.sin(angle)
    center = (0.5 * (width * cos - height * sin), 0.5 * (width * sin + height * cos))  # seen from the standing corner
    scene = Scene(gravity=WEIGHT)
    block = scene.add(Box(width=width, height=height, mass=1.0), name="block", position=center, angle=angle)
    floor = scene.ground.half_plane((0.0, 0.0), (0.0, 1.0))
    scene.contact(block.surface(), floor, friction=friction, name="floor")
    return scene


@checked
def double_pendulum(friction: float = 0.5, restitution: float = 0.5) -> Scene:
    """Kane's double pendulum: two hinged rods (1 kg, 1 m), its tip strikes a rough floor.

    Newton's law of impact with friction creates energy here.
    """
    rod = RigidBody(mass=1.0, inertia=1.0 / 12.0, center=(0.5, 0.0), points={"top": (0.0, 0.0), "bottom": (1.0, 0.0)})
    upper, lower = math.radians(20.0), math.radians(30.0)  # from the downward vertical
    elbow = (math.sin(upper), -math.cos(upper))
    tip = (elbow[0] + math.sin(lower), elbow[1] - math.cos(lower))
    scene = Scene(gravity=WEIGHT)
    first = scene.add(rod, name="upper rod", angle=upper - 0.5 * math.pi, angular_velocity=-0.1)
    second = scene.add(
        rod,
        name="lower rod",
        position=elbow,
        angle=lower - 0.5 * math.pi,
        velocity=(0.1 * elbow[1], -0.1 * elbow[0]),
        angular_velocity=-0.2,
    )
    scene.join(Revolute(first.point("top"), scene.ground.at(0.0, 0.0), name="shoulder"))
    scene.join(Revolute(second.point("top"), first.point("bottom"), name="elbow"))
    floor = scene.ground.half_plane((0.0, tip[1]), (0.0, 1.0))
    scene.contact(second.node(1.0, 0.0), floor, friction=friction, restitution=restitution, name="floor")
    return scene


@checked
def painleve_rod(friction: float = 1.4, degrees: float = 60.0, spin: float = 0.0, slip: float = -1.0) -> Scene:
    """A uniform rod (1 kg, half length 1 m, g = 1 m/s^2) touches a rough floor with its lower end.

    It leans by ``degrees`` from the floor, that end slides at ``slip`` [m/s], and it turns at ``spin`` [rad/s]. With
    much friction (:func:`painleve_friction`) no force can keep it sliding, or two motions are possible.
    """
    angle = math.radians(degrees)
    scene = Scene(gravity=(0.0, -1.0))
    rod = scene.add(
        RigidBody(mass=1.0, inertia=1.0 / 3.0),
        name="rod",
        position=(math.cos(angle), math.sin(angle)),
        angle=angle,
        velocity=(slip - spin * math.sin(angle), spin * math.cos(angle)),
        angular_velocity=spin,
    )
    floor = scene.ground.half_plane((0.0, 0.0), (0.0, 1.0))
    scene.contact(rod.node(-1.0, 0.0), floor, friction=friction, name="floor")
    return scene


@checked
def painleve_friction(degrees: float) -> float:
    """Friction above which the rod of :func:`painleve_rod`, its end sliding to the left, meets Painleve's paradoxes.

    mu_P = (1 + 3 cos^2 phi) / (3 sin phi cos phi), where p = 1 + 3 cos phi (cos phi - mu sin phi) vanishes in
    gddot_N = p lambda_N + phidot^2 sin phi - 1. Its least value is 4/3, at tan phi = 2. Infinite from 90 degrees on.
    """
    phi = math.radians(degrees)
    product = 3.0 * math.sin(phi) * math.cos(phi)
    return (1.0 + 3.0 * math.cos(phi) ** 2) / product if product > 1e-15 else math.inf


@checked
def stack(boxes: int = 10, top_mass: float = 1.0, friction: float = 0.5) -> Scene:
    """Equal boxes of 1 kg stand on each other; the one on top may be heavier."""
    scene = Scene(gravity=WEIGHT)
    for k in range(boxes):
        mass = top_mass if k == boxes - 1 else 1.0
        scene.add(Box(width=0.2, height=0.1, mass=mass), name=f"box {k + 1}", position=(0.0, 0.05 + 0.1 * k))
    scene.ground.half_plane((0.0, 0.0), (0.0, 1.0))
    scene.contact_all(friction=friction)
    return scene


def cases() -> tuple[Case, ...]:
    """The cases of this module."""
    closed = "closed form"
    return (
        Case(
            "incline",
            "block pushed up a slope of 30 degrees, mu = 0.4: it stops and slides back",
            block_on_incline,
            0.5,
            MoreauJean(step=1e-5),
            {"stop_time": 0.240869, "stop_distance": 0.240869, "slide_back": 1.506716},
            closed,
        ),
        Case(
            "incline_sticks",
            "block pushed up a slope of 30 degrees, mu = 0.7: it stops and stays",
            partial(block_on_incline, friction=0.7),
            10.0,
            MoreauJean(step=1e-4),
            {"drift": 0.0},
            closed,
        ),
        Case(
            "stick_slip",
            "block on a rough floor under the force 4 sin 2t: sticks, slips, sticks",
            stick_slip_block,
            1.9,
            MoreauJean(step=1e-5),
            {"slip_time": 0.413386715, "stick_time": 1.552770643, "displacement": 0.332714308},
            closed,
        ),
        Case(
            "spring_block",
            "block on a spring and a rough floor: five turning points, then rest",
            spring_block,
            0.15,
            MoreauJean(step=1e-6),
            {
                "turn_1": -0.65e-3,
                "turn_2": 0.45e-3,
                "turn_3": -0.25e-3,
                "rest": 0.05e-3,
                "rest_time": 0.125663706,
            },
            "closed form; code_aster SDND100",
        ),
        Case(
            "bouncing_ball",
            "ball that comes to rest after infinitely many bounces",
            bouncing_ball,
            1.6,
            MoreauJean(step=1e-5),
            {"first_impact": 0.4515236, "rest_time": 1.354570923},
            closed,
        ),
        Case(
            "oblique_bounce",
            "disc that bounces off a rough floor and starts to spin",
            oblique_bounce,
            1.0,
            MoreauJean(step=1e-3),
            {"normal_impulse": 3.4, "tangential_impulse": -0.68, "v_x": 2.32, "v_y": 1.4, "omega": -1.7},
            closed,
        ),
        Case(
            "three_balls",
            "three balls in a row, struck at one end: all impacts at once",
            three_balls,
            0.5,
            MoreauJean(step=1e-3),
            {"v_1": -1.0 / 3.0, "v_2": 2.0 / 3.0, "v_3": 2.0 / 3.0},
            closed,
        ),
        Case(
            "rocking_block",
            "slender block rocks from corner to corner",
            rocking_block,
            4.0,
            EventDriven(),
            {"rate_ratio": 0.942308, "first_impact": 1.388374 / 4.0},
            closed,
        ),
        Case(
            "double_pendulum",
            "Kane's double pendulum strikes a rough floor: Newton's law of impact creates energy",
            double_pendulum,
            0.3,
            EventDriven(),
            {
                "energy_before": 0.02318141,
                "upper_rate": -0.334649,
                "lower_rate": 0.363115,
                "normal_impulse": 0.567980,
                "tangential_impulse": -0.244597,
                "energy_gain": 0.5875,
            },
            closed,
        ),
        Case(
            "painleve_rod",
            "rod that cannot go on sliding on a very rough floor: an impact without collision",
            painleve_rod,
            0.05,
            EventDriven(),
            {"least_friction": 4.0 / 3.0},
            closed,
        ),
        Case("stack", "ten boxes on each other at rest", stack, 1.0, MoreauJean(step=1e-3), {"drift": 0.0}, closed),
        Case(
            "heavy_stack",
            "ten boxes at rest, the top one a hundred times heavier",
            partial(stack, top_mass=100.0),
            1.0,
            MoreauJean(step=1e-3),
            {"drift": 0.0},
            closed,
        ),
    )
