"""Many bodies in contact: heaps, walls, piles of strips, chains, hoppers and silos, with sums that are known exactly.

Single forces of a pile are seldom unique; the weight on its supports and the momentum that they take are.
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial

import numpy as np

from lcpflex.bodies.rigid import Box, Disc
from lcpflex.errors import in_range
from lcpflex.gallery.mechanisms.arguments import checked
from lcpflex.gallery.mechanisms.flexible import aluminium_strip
from lcpflex.runs.case import Case
from lcpflex.scene.functions_of_time import Table
from lcpflex.scene.joints.driven_displacement import DrivenDisplacement
from lcpflex.scene.joints.prismatic import Prismatic
from lcpflex.scene.joints.revolute import Revolute
from lcpflex.scene.scene import Scene
from lcpflex.steppers.moreau_jean.stepper import MoreauJean

__all__ = ["brick_wall", "heap", "hopper", "link_chain", "silo", "strip_pile"]

GRAVITY = 9.81
WEIGHT = (0.0, -GRAVITY)
RADIUS = 0.1  # of discs [m]
BRICK = (0.2, 0.1)  # width and height [m]; 1 kg
STEP = MoreauJean(step=1e-3)
SETTLED, RAMP, SINKING = 1.5, 0.2, 0.05  # of silos: when the bottom begins to give way, for how long it gets faster [s]
LONGEST = 1e4  # [s] that the bottom of a silo may sink


@checked
def heap(discs: int = 30, friction: float = 0.5, scatter: float = 0.02, seed: int = 1) -> Scene:
    """Discs of 1 kg, radii from 0.1 m down by at most ``scatter``, fall into a box and come to rest."""
    columns = max(2, round(math.sqrt(0.6 * discs)))
    scene = _bin(2.4 * RADIUS * columns)
    _pour(scene, discs, columns, scatter, seed)
    scene.contact_all(friction=friction)
    return scene


@checked
def brick_wall(
    courses: int = 6, bricks: int = 4, speed: float = 0.0, ball: float = 5.0, friction: float = 0.5, joint: float = 1e-3
) -> Scene:
    """A wall in running bond, half bricks at the ends of every second course, without mortar; a ball may hit it.

    A brick has 1 kg, two of a course are ``joint`` [m] apart. With ``speed`` [m/s] a disc of ``ball`` [kg] flies
    against half its height from the left.
    """
    width, height = BRICK
    scene = Scene(gravity=WEIGHT)
    scene.ground.half_plane((0.0, 0.0), (0.0, 1.0))
    whole, half = Box(width - joint, height, mass=1.0), Box(0.5 * width - joint, height, mass=0.5)
    for course in range(courses):
        y = (course + 0.5) * height
        places = [(whole, width * (k + 0.5)) for k in range(bricks)]
        if course % 2:
            ends = [(half, 0.25 * width), (half, width * (bricks - 0.25))]
            places = [ends[0], *((whole, width * (k + 1.0)) for k in range(bricks - 1)), ends[1]]
        for k, (brick, x) in enumerate(places):
            scene.add(brick, name=f"brick {course + 1}.{k + 1}", position=(x, y))
    if speed:
        radius = 1.2 * height
        middle = 0.5 * height * (2 * (courses // 2) + 1)
        place = (-radius - 1.5 * joint, max(middle, 1.1 * radius))
        scene.add(Disc(radius, mass=ball), name="ball", position=place, velocity=(speed, 0.0))
    scene.contact_all(friction=friction)
    return scene


@checked
def strip_pile(strips: int = 8, modes: int = 4, friction: float = 0.5, shift: float = 0.1) -> Scene:
    """Aluminium strips of 0.5 m fall flat onto each other, the next one to the right and left in turn by ``shift`` [m].

    The lowest one falls onto two round supports, so that it bends under those above it.
    """
    material = aluminium_strip(length=0.5, width=0.05, thickness=0.005, elements=10)
    scene = Scene(gravity=WEIGHT)
    for x in (0.1, 0.4):
        scene.ground.circle(center=(x, -0.01), radius=0.01)
    body = replace(material.reduce(modes=modes, damping=0.05), statics=None)  # the modes are the model
    for k in range(strips):
        x = 0.5 * shift * (-1.0) ** k if k else 0.0
        scene.add(body, name=f"strip {k + 1}", position=(x, 0.0026 + 0.0051 * k))
    scene.contact_all(friction=friction)
    return scene


@checked
def link_chain(
    links: int = 30, height: float = 0.2, degrees: float = 5.0, hung: bool = False, friction: float = 0.5
) -> Scene:
    """A straight chain of hinged links, 0.1 m long, of 0.1 kg, falls onto a floor, its left end from ``height`` [m].

    It rises by ``degrees`` from the left end to the right. ``hung``: its right end is hinged to the ground.
    """
    length, thickness = 0.1, 0.02
    angle = math.radians(degrees)
    along = (math.cos(angle), math.sin(angle))
    scene = Scene(gravity=WEIGHT)
    scene.ground.half_plane((0.0, 0.0), (0.0, 1.0))
    link = Box(length, thickness, mass=0.1)
    start = height + 0.5 * thickness
    placed = [
        scene.add(
            link,
            name=f"link {k + 1}",
            position=((k + 0.5) * length * along[0], start + (k + 0.5) * length * along[1]),
            angle=angle,
        )
        for k in range(links)
    ]
    for k in range(links - 1):
        joint = Revolute(placed[k].point("right"), placed[k + 1].point("left"), name=f"joint {k + 1}")
        scene.join(joint)
    if hung:
        end = (links * length * along[0], start + links * length * along[1])
        scene.join(Revolute(placed[-1].point("right"), scene.ground.at(*end), name="hook"))
    scene.contact_all(friction=friction)
    return scene


@checked
def hopper(
    discs: int = 40,
    friction: float = 0.8,
    opening: float = 2.6,
    degrees: float = 30.0,
    scatter: float = 0.05,
    seed: int = 2,
) -> Scene:
    """Discs fall into a hopper with sides that rise by ``degrees`` from its mouth, ``opening`` diameters wide.

    What has left it (y < 0) lies in a bin below. On sides as flat as these, rough discs form an arch when a few have
    left. Steep sides let them pass for as long as chance will have it.
    """
    columns = 7
    half, mouth = 1.2 * RADIUS * columns, opening * RADIUS
    rise = (half - mouth) * math.tan(math.radians(degrees))
    scene = _bin(2.0 * half, bottom=-math.ceil(discs / columns + 1) * 2.4 * RADIUS)
    for side in (-1.0, 1.0):
        mid = half + side * half
        corners = [(half + side * mouth, 0.0), (mid, 0.0), (mid, rise)]
        scene.ground.chain(corners[:: int(side)], closed=True)
    _pour(scene, discs, columns, scatter, seed, bottom=rise)
    scene.contact_all(friction=friction)
    return scene


@checked
def silo(
    discs: int = 60, friction: float = 0.5, columns: int = 4, scatter: float = 0.2, seed: int = 1, duration: float = 2.0
) -> Scene:
    """Discs settle between two rough walls; from 1.5 s on their bottom gives way by 5 cm/s, and the walls carry.

    The joint "drive" holds the bottom, a box of 1 kg. The walls are ``columns`` diameters apart.
    """
    duration = in_range("duration", duration, 0.0, LONGEST)
    width = 2.0 * RADIUS * columns + 0.5 * RADIUS
    scene = Scene(gravity=WEIGHT)
    left = scene.ground.half_plane((0.0, 0.0), (1.0, 0.0))
    right = scene.ground.half_plane((width, 0.0), (-1.0, 0.0))
    bottom = scene.add(Box(width - 0.02 * RADIUS, 0.1, mass=1.0), name="bottom", position=(0.5 * width, -0.05))
    place = scene.ground.at(0.5 * width, -0.05)
    scene.join(Prismatic(bottom.point("center"), place, axis=(0.0, 1.0), name="guide"))
    times = np.linspace(0.0, SETTLED + duration, 20 * math.ceil(SETTLED + duration) + 1)
    since = np.maximum(times - SETTLED, 0.0)
    path = np.where(since < RAMP, 0.5 * since**2 / RAMP, since - 0.5 * RAMP)
    drive = Table(times, -SINKING * path)
    scene.join(DrivenDisplacement(bottom.point("center"), place, drive, (0.0, 1.0), name="drive"))
    _pour(scene, discs, columns - 1, scatter, seed, width=width)
    scene.contact_all(friction=friction, exclude=[(bottom, left), (bottom, right)])
    return scene


def _bin(width: float, bottom: float = 0.0) -> Scene:
    """A scene with a floor and two walls, at x = 0 and x = ``width``."""
    scene = Scene(gravity=WEIGHT)
    scene.ground.half_plane((0.0, bottom), (0.0, 1.0))
    scene.ground.half_plane((0.0, 0.0), (1.0, 0.0))
    scene.ground.half_plane((width, 0.0), (-1.0, 0.0))
    return scene


def _pour(
    scene: Scene, discs: int, columns: int, scatter: float, seed: int, bottom: float = 0.0, width: float | None = None
) -> None:
    """Discs in rows of so many, each at random in a cell of its own, over ``bottom`` and from x = 0 to ``width``."""
    rng = np.random.default_rng(seed)
    cell = 2.4 * RADIUS if width is None else width / columns
    for k in range(discs):
        radius = RADIUS * (1.0 - scatter * rng.uniform())
        free = 0.45 * cell - radius  # up to a tenth of the cell from the next one
        x = cell * (k % columns + 0.5) + max(free, 0.0) * rng.uniform(-1.0, 1.0)
        y = bottom + 2.2 * RADIUS * (k // columns + 0.5) + 0.05 * RADIUS * rng.uniform(-1.0, 1.0)
        scene.add(Disc(radius, mass=1.0), name=f"disc {k + 1}", position=(x, y))


def cases() -> tuple[Case, ...]:
    """The cases of this module; forces and impulses are those of the ground on all bodies together."""
    sums = "closed form: Newton's second law for all bodies together"
    return (
        Case(
            "heap",
            "discs fall into a box: they come to rest on it with their weight",
            heap,
            1.5,
            STEP,
            {"weight": 30.0 * GRAVITY},
            sums,
        ),
        Case(
            "brick_wall",
            "brick wall in running bond at rest: each course carries what is above it",
            brick_wall,
            0.1,
            STEP,
            {"weight": 24.0 * GRAVITY},
            sums,
        ),
        Case(
            "struck_wall",
            "a ball hits a brick wall: its momentum goes into friction on the ground",
            partial(brick_wall, speed=3.0),
            0.3,
            STEP,
            {"momentum": 15.0},
            sums,
        ),
        Case(
            "strip_pile",
            "flexible strips fall flat onto each other and two supports",
            strip_pile,
            0.3,
            MoreauJean(step=1e-4),
            {"weight": 8.0 * 2700.0 * 0.5 * 0.05 * 0.005 * GRAVITY},
            sums,
        ),
        Case(
            "link_chain",
            "a long chain of hinged links falls onto a floor",
            link_chain,
            0.6,
            STEP,
            {"weight": 3.0 * GRAVITY, "reaction": 0.0},
            sums,
        ),
        Case("hopper", "discs leave a hopper until an arch over its mouth stops them", hopper, 2.5, STEP),
        Case(
            "smooth_hopper",
            "the same hopper and discs without friction: it runs empty",
            partial(hopper, friction=0.0),
            2.5,
            STEP,
        ),
        Case(
            "silo",
            "rough walls carry a part of what is in a silo once its bottom gives way",
            silo,
            2.5,
            STEP,
            {"weight": 60.0 * GRAVITY},
            "Janssen 1895: saturation with the height",
        ),
    )
