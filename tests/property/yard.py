"""What random scenes are drawn from: bodies, walls and loads of either dimension, in plain numbers."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.spatial.transform import Rotation

__all__ = ["GRAVITY", "STEEL", "Push", "Shape", "Vector", "Wall", "Yard", "core", "crossed", "turned"]

Array = npt.NDArray[np.float64]
Vector = tuple[float, ...]

GRAVITY = 9.81  # [m/s^2]
STEEL = 7800.0  # [kg/m^3]
SIDES = 24  # of the prism that stands for a drum where places and depths are measured


@dataclass(frozen=True)
class Shape:
    """A body and how it starts."""

    kind: str  # ball, box, hull, drum, capsule, beam
    numbers: Vector  # radius; edges; corners; radius, length; the same; length, thickness, Young's modulus
    mass: float
    place: Vector  # of its middle
    turn: Vector  # angle; in space the rotation vector
    speed: Vector
    spin: Vector  # world axes
    hold: str = "free"  # weld, pin, rod, spring, drive, guide, hinge to the body before it
    at: Vector = ()  # where it is held, body frame [m]
    hold_numbers: Vector = ()


@dataclass(frozen=True)
class Push:
    """A load in time."""

    body: int
    way: int  # component of a force
    kind: str  # constant, ramp, harmonic, pulse, steps, function
    size: float  # [N] or [N m]
    period: float  # [s] of a harmonic, width of a pulse, of a step or of a ramp
    start: float  # [s]
    turns: bool = False  # a torque, in space about the axis ``way``
    at: Vector = ()  # where a force acts, body frame; () for the middle


class Wall(NamedTuple):
    """What stands still."""

    kind: str  # plane, post, slab
    place: Vector  # a point of it; its middle; its lowest corner
    numbers: Vector  # normal; radius; edges


def turned(turn: Vector, points: npt.ArrayLike) -> Array:
    """Points (..., d) in world axes."""
    points = np.asarray(points, dtype=float)
    if len(turn) == 3:
        return np.asarray(Rotation.from_rotvec(turn).apply(points))
    c, s = math.cos(turn[0]), math.sin(turn[0])
    return np.asarray(points @ np.array([[c, s], [-s, c]]))


def crossed(spin: Vector, arm: Array) -> Array:
    """The velocity spin x arm."""
    if len(spin) == 3:
        return np.asarray(np.cross(spin, arm))
    return spin[0] * np.array([-arm[1], arm[0]])


def core(shape: Shape, dimension: int) -> tuple[Array, float]:
    """Corners (k, d) of a rigid body in its frame, and what is added all around them [m]."""
    numbers = shape.numbers
    if shape.kind == "ball":
        return np.zeros((1, dimension)), numbers[0]
    if shape.kind == "box":
        signs = np.array(np.meshgrid(*[(-0.5, 0.5)] * dimension, indexing="ij")).reshape(dimension, -1).T
        if dimension == 2:
            signs = signs[[0, 2, 3, 1]]  # as a ring
        return signs * np.array(numbers), 0.0
    if shape.kind == "hull":
        return np.reshape(numbers, (-1, dimension)), 0.0
    if shape.kind == "capsule":
        return np.array([(0.0, 0.0, -0.5 * numbers[1]), (0.0, 0.0, 0.5 * numbers[1])]), numbers[0]
    if shape.kind == "drum":
        ring = np.exp(2j * math.pi * np.arange(SIDES) / SIDES) * numbers[0]
        return np.array([(p.real, p.imag, z) for z in (-0.5 * numbers[1], 0.5 * numbers[1]) for p in ring]), 0.0
    half = 0.5 * numbers[0] * np.eye(dimension)[0]
    return np.array([-half, half]), 0.5 * numbers[1]


@dataclass
class Yard:
    """Draws parts of a scene of one dimension, size and system of units."""

    rng: np.random.Generator
    dimension: int
    metre: float = 1.0  # 1e3: in millimetres, tonnes and seconds
    length: float = field(init=False)

    def __post_init__(self) -> None:
        self.length = 10.0 ** self.rng.uniform(-1.7, 0.3) * self.metre

    @property
    def kilogram(self) -> float:
        """Forces are in newtons in either system of units."""
        return 1.0 / self.metre

    @property
    def g(self) -> float:
        """Gravity in its units."""
        return GRAVITY * self.metre

    @property
    def speed(self) -> float:
        """What gravity makes of the length."""
        return math.sqrt(self.g * self.length)

    def down(self, lean: float = 0.0) -> Vector:
        """Gravity, leaning by an angle [rad]."""
        return self.at(-self.g * math.sin(lean), -self.g * math.cos(lean))

    def at(self, along: float, up: float, aside: float = 0.0) -> Vector:
        """A vector; ``aside`` there is in space alone."""
        return (float(along), float(up)) if self.dimension == 2 else (float(along), float(aside), float(up))

    @property
    def still(self) -> tuple[Vector, Vector]:
        """No velocity and no spin."""
        return self.at(0.0, 0.0), (0.0,) * (1 if self.dimension == 2 else 3)

    def any_turn(self) -> Vector:
        """Any rotation."""
        if self.dimension == 2:
            return (float(self.rng.uniform(-math.pi, math.pi)),)
        return tuple(map(float, Rotation.random(rng=self.rng).as_rotvec()))

    def upright(self, yaw: float = 0.0) -> Vector:
        """Turned about the way up, which there is in space alone."""
        return (0.0,) if self.dimension == 2 else (0.0, 0.0, float(yaw))

    def leaning(self, lean: float, yaw: float = 0.0) -> Vector:
        """Turned about the level axis across x, counter-clockwise seen with x to the right, and then about up."""
        if self.dimension == 2:
            return (float(lean),)
        return tuple(map(float, Rotation.from_euler("yz", (-lean, yaw)).as_rotvec()))

    def any_spin(self) -> Vector:
        """Up to five radians in the time of a fall."""
        count = 1 if self.dimension == 2 else 3
        return tuple(map(float, self.rng.uniform(-1.0, 1.0, count) * self.speed / self.length * 5.0))

    def mass_of(self, volume: float) -> float:
        """Of a random density."""
        return float(volume * 10.0 ** self.rng.uniform(2.0, 3.9) * self.kilogram / self.metre**3)

    def edges(self, low: float, high: float) -> Vector:
        """Of a box, over the length."""
        return tuple(float(x) * self.length for x in self.rng.uniform(low, high, self.dimension))

    def figure(self, kind: str) -> tuple[str, Vector, float]:
        """A body no farther than 0.4 lengths from its middle: kind, numbers, mass."""
        rng, L, space = self.rng, self.length, self.dimension == 3
        if kind == "ball":
            numbers: Vector = (float(rng.uniform(0.1, 0.35)) * L,)
            volume = math.pi * numbers[0] ** 2 * (4.0 / 3.0 * numbers[0] if space else L)
        elif kind == "box":
            numbers = self.edges(0.1, 0.45)
            volume = float(np.prod(numbers)) * (1.0 if space else L)
        elif kind == "hull":
            numbers = self.hull()
            volume = 0.05 * L**3
        elif kind == "beam":
            return self.beam(0.75, float(rng.uniform(0.01, 0.04)))
        else:
            numbers = (float(rng.uniform(0.08, 0.2)) * L, float(rng.uniform(0.1, 0.4)) * L)
            volume = math.pi * numbers[0] ** 2 * numbers[1]
        return kind, numbers, self.mass_of(volume)

    def beam(self, length: float, thickness: float) -> tuple[str, Vector, float]:
        """Its Euler load is ten to 500 times its weight; length and thickness over the length of the scene."""
        L = self.length
        length, thickness = length * L, thickness * L
        density = STEEL * self.kilogram / self.metre**3
        first = 10.0 ** self.rng.uniform(1.35, 2.2) * math.sqrt(self.g / length)  # of the free beam [rad/s]
        young = density * (first * length**2 / 22.37) ** 2 * 12.0 / thickness**2
        return "beam", (length, thickness, float(young)), float(density * length * thickness * 0.1 * L)

    def hull(self) -> Vector:
        """Corners of a convex body about its mass centre."""
        rng, L = self.rng, self.length
        if self.dimension == 2:
            corners = int(rng.integers(3, 7))
            angles = 2.0 * math.pi * (np.arange(corners) + rng.uniform(-0.25, 0.25, corners)) / corners
            ring = 0.3 * L * np.column_stack([np.cos(angles), np.sin(angles)])
            return tuple(map(float, (ring - _centre(ring)).ravel()))
        import lcpflex as lf

        points = rng.normal(size=(int(rng.integers(6, 14)), 3))
        points *= 0.3 * L / np.linalg.norm(points, axis=1)[:, None]
        body = lf.ConvexHull(points, mass=1.0)
        return tuple(map(float, np.array(body.shape.vertices).ravel()))  # type: ignore[union-attr]

    def choice(self, values: Any) -> float:
        """One of some numbers."""
        return float(self.rng.choice(values))


def _centre(ring: Array) -> Array:
    """Mass centre of a polygon, counter-clockwise."""
    after = np.roll(ring, -1, axis=0)
    area = ring[:, 0] * after[:, 1] - after[:, 0] * ring[:, 1]
    return np.asarray(((ring + after) * area[:, None]).sum(0) / (3.0 * area.sum()))
