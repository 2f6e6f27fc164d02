"""Walls, piles and stacks of equal bricks and cubes."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

import lcpflex as lf
from tests.flush.pairs import BRICK, box
from tests.flush.scenes import GRAVITY, level

__all__ = ["LAST", "PLAY", "heap", "half_bond", "ninety_degrees", "stack_of_cubes", "tipping", "wall"]

LENGTH, WIDTH, HEIGHT = BRICK
PLAY = 4e-3  # [m] between bricks of the half bond
LAST = "brick 3 2"  # its upper end brick, which nothing holds down


def wall(noise: float = 0.0, pitch: float = LENGTH, aside: float = 0.05, courses: int = 4) -> lf.SpatialScene:
    """Courses of three, each by ``aside`` beside the one below, to and fro; places up to ``noise`` off but in height.

    Bricks of a course are by twice the noise farther apart than their pitch, so that none begins in the other.
    """
    scene, rng = level(), np.random.default_rng(5)
    scene.ground.plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    for course in range(courses):
        for k in range(3):
            x, y = rng.uniform(-noise, noise, 2)
            place = ((pitch + 2.0 * noise) * k + aside * (course % 2) + x, y, (course + 0.5) * HEIGHT)
            scene.add(box(*BRICK).body, f"brick {course} {k}", position=place)
    scene.contact_all(friction=0.5)
    return scene


def half_bond(noise: float = 0.0) -> lf.SpatialScene:
    """Bricks with play, each course by half a pitch beside the one below.

    The end of a course overhangs by half the play beyond balance; all but that of the uppermost course are held down.
    """
    pitch = LENGTH + PLAY
    return wall(noise, pitch, 0.5 * pitch)


def tipping(duration: float) -> tuple[float, float]:
    """How far a brick on an edge half the play beside its centre has turned [rad] and sunk [m], from rest.

    k^2 theta'' = g (d cos theta + b sin theta), d beside and b above the edge, k the radius of inertia about it.
    """
    d, b = 0.5 * PLAY, 0.5 * HEIGHT
    k2 = (LENGTH**2 + HEIGHT**2) / 12.0 + d**2 + b**2

    def slope(_: float, y: np.ndarray) -> tuple[float, float]:
        return y[1], GRAVITY * (d * math.cos(y[0]) + b * math.sin(y[0])) / k2

    theta = float(solve_ivp(slope, (0.0, duration), (0.0, 0.0), rtol=1e-10, atol=1e-12).y[0, -1])
    return theta, d * math.sin(theta) + b * (1.0 - math.cos(theta))


def heap(count: int = 50) -> lf.SpatialScene:
    """Tilted boxes that fall between four walls, layer by layer of nine."""
    scene, rng = level(), np.random.default_rng(11)
    scene.ground.plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    for way in ((1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)):
        scene.ground.plane((-0.3 * way[0], -0.3 * way[1], 0.0), (*way, 0.0))
    for k in range(count):
        layer, place = divmod(k, 9)
        x, y = 0.19 * (place % 3 - 1), 0.19 * (place // 3 - 1)
        turn = Rotation.from_rotvec(0.3 * rng.normal(size=3))
        scene.add(lf.Cuboid(0.14, 0.1, 0.06, mass=1.0), f"box {k}", (x, y, 0.12 + 0.18 * layer), turn)
    scene.contact_all(friction=0.4)
    return scene


def ninety_degrees() -> Iterator[tuple[str, Rotation]]:
    """Turns of a cube onto itself as they are written."""
    half = math.sqrt(0.5)
    for axis in "xyz":
        yield (
            f"exact, {axis}",
            Rotation.from_matrix(np.round(Rotation.from_euler(axis, 90.0, degrees=True).as_matrix())),
        )
        yield f"degrees, {axis}", Rotation.from_euler(axis, 90.0, degrees=True)
        yield f"float32, {axis}", Rotation.from_euler(axis, float(np.float32(math.pi / 2.0)))
        for digits in (7, 8, 9):
            vector = round(half, digits) * np.eye(3)["xyz".index(axis)]
            yield f"quaternion of {digits}, {axis}", Rotation.from_quat([*vector, round(half, digits)])
    for axes in ("xyz", "zyx", "xzx", "yxz"):
        yield f"chain {axes}", Rotation.from_euler(axes, [90.0, 90.0, -90.0], degrees=True)
        yield f"float32 chain {axes}", Rotation.from_euler(axes, np.float32([math.pi / 2.0, -math.pi / 2.0, math.pi]))


def stack_of_cubes(turns: tuple[Rotation, Rotation, Rotation], side: float = 0.1) -> lf.SpatialScene:
    """Three on each other, each turned in its own way."""
    scene = level()
    scene.ground.plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    for k, turn in enumerate(turns):
        place = (0.0, 0.0, (k + 0.5) * side)
        scene.add(box(side, side, side).body, f"cube {k}", place, turn)
    scene.contact_all(friction=0.3)
    return scene
