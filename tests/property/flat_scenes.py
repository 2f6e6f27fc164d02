"""Random scenes of flat bodies: flush faces, equal sizes and aligned edges are drawn on purpose.

In the plane bodies turn by what tilts them alone; in space about the way up, too.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from tests.property.layout import Layout
from tests.property.yard import Shape, Vector, Wall, Yard, core, turned

__all__ = ["flat"]

BRICK = (0.2, 0.1, 0.06)  # over the unit
YAWS = (0.0, 0.5 * math.pi, 1e-9, 1e-6, 1e-3)  # and any [rad]
LEANS = (0.0, 0.0, 0.0, 1e-9, 1e-6, 1e-3)  # [rad]
ASIDE = (0.0, 0.0, 1e-10, 1e-8, 1e-6, 1e-4, 0.02, 0.1)  # over the width
GAPS = (0.0, 0.0, 1e-4, 0.02)  # over five bricks' lengths


def flat(yard: Yard) -> Layout:
    """On each other, on two, beside each other, on an edge."""
    rng = yard.rng
    form = str(rng.choice(["stack", "bricks", "beside", "on an edge"], p=[0.4, 0.25, 0.2, 0.15]))
    shapes = {"stack": _stack, "bricks": _bricks, "beside": _beside, "on an edge": _on_an_edge}[form](yard)
    ground = Wall("plane", yard.at(0.0, 0.0), yard.at(0.0, 1.0))
    friction, restitution = float(rng.choice([0.0, 0.3, 0.6])), float(rng.choice([0.0, 0.0, 0.5]))
    return Layout(tuple(shapes), yard.down(), (ground,), friction=friction, restitution=restitution)


def _sizes(yard: Yard, edges: Vector) -> Vector:
    """Of a box: in the plane without its width."""
    scaled = tuple(edge * yard.length for edge in edges)
    return scaled if yard.dimension == 3 else (scaled[0], scaled[-1])


def _box(yard: Yard, edges: Vector) -> Shape:
    """At rest at the origin."""
    numbers = _sizes(yard, edges)
    mass = float(np.prod(numbers)) * (1.0 if yard.dimension == 3 else 0.1 * yard.length)
    still, no_spin = yard.still
    mass *= 833.0 * yard.kilogram / yard.metre**3
    return Shape("box", numbers, mass, still, yard.upright(), still, no_spin)


def _kind(yard: Yard) -> Shape:
    """A body that stands about as wide and high as a brick."""
    rng = yard.rng
    kind = str(rng.choice(["box", "prism", "gem", "drum"], p=[0.65, 0.15, 0.1, 0.1]))
    brick = _box(yard, BRICK if rng.random() < 0.8 else (0.1, 0.1, 0.1))
    if kind == "box":
        return brick
    if kind == "drum" and yard.dimension == 3:
        return replace(brick, kind="drum", numbers=(0.06 * yard.length, 0.06 * yard.length))
    corners = _gem(yard) if kind == "gem" and yard.dimension == 3 else _prism(yard)
    return replace(brick, kind="hull", numbers=tuple(map(float, corners.ravel())))


def _prism(yard: Yard) -> np.ndarray:
    """Upright, a flat side of it towards +x; in the plane its outline, a flat side of it down."""
    sides, radius, L = int(yard.rng.choice([4, 6, 8])), 0.08, yard.length
    angles = (np.arange(sides) + 0.5) * 2.0 * np.pi / sides + (0.0 if yard.dimension == 3 else 0.5 * math.pi)
    ring = radius * L * np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    if yard.dimension == 2:
        return ring
    return np.array([(*xy, z) for z in (-0.03 * L, 0.03 * L) for xy in ring])


def _gem(yard: Yard) -> np.ndarray:
    """A hull of points on a ball, twice each across its middle, cut flat below and above; it stands on many corners."""
    size = 0.1 * yard.length
    points = yard.rng.normal(size=(10, 3))
    points *= size / np.linalg.norm(points, axis=1)[:, None]
    points = np.concatenate([points, -points])
    points[:, 2] = np.clip(points[:, 2], -0.5 * size, 0.5 * size)
    rings = np.linspace(0.0, 2.0 * np.pi, 7)[:-1]  # both flat ends are wide, whatever was drawn
    wide = 0.7 * size * np.stack([np.cos(rings), np.sin(rings)], axis=-1)
    return np.concatenate([points, [(*xy, z) for xy in wide for z in (-0.5 * size, 0.5 * size)]])


def _turn(yard: Yard) -> Vector:
    """Nearly aligned, or anyhow about the way up; nearly upright."""
    rng = yard.rng
    yaw = rng.choice([*YAWS, rng.uniform(-math.pi, math.pi)])
    lean = rng.choice(LEANS) if yard.dimension == 2 or rng.random() < 0.2 else 0.0
    return yard.leaning(float(lean), float(yaw))


def _stand(yard: Yard, shape: Shape, along: float, aside: float, floor: float, turn: Vector) -> tuple[Shape, float]:
    """A body with its lowest corner at a height, and the height of its highest one."""
    corners, radius = core(shape, yard.dimension)
    heights = turned(turn, corners)[:, -1]
    up = floor - heights.min() + radius
    return replace(shape, place=yard.at(along, up, aside), turn=turn), float(up + heights.max() + radius)


def _moving(yard: Yard, shape: Shape) -> Shape:
    """It slides, and in space spins, two times in five."""
    rng = yard.rng
    if rng.random() >= 0.4:
        return shape
    unit = yard.speed
    speed = yard.at(rng.uniform(-0.3, 0.3) * unit, 0.0, rng.choice([0.0, rng.uniform(-0.15, 0.15)]) * unit)
    spin = rng.choice([0.0, rng.uniform(-0.3, 0.3)]) * unit / yard.length
    return replace(shape, speed=speed, spin=yard.upright(spin))


def _gap(yard: Yard) -> float:
    return yard.choice(GAPS) * yard.length


def _stack(yard: Yard) -> list[Shape]:
    """Two or three on each other, often equal."""
    rng, kind, top, found = yard.rng, _kind(yard), 0.0, []
    for k in range(int(rng.choice([2, 3], p=[0.75, 0.25]))):
        kind = kind if rng.random() < 0.6 else _kind(yard)
        x, y = 0.1 * yard.length * rng.choice(ASIDE, 2) * (k > 0)
        shape, top = _stand(yard, kind, x, y, top + (_gap(yard) if k else 0.0), _turn(yard))
        found.append(_moving(yard, shape) if k else shape)
    return found


def _bricks(yard: Yard) -> list[Shape]:
    """Two end to end, or in space side by side, and one on both."""
    rng, L = yard.rng, yard.length
    length, width, height = (edge * L for edge in BRICK)
    along = yard.dimension == 2 or rng.random() < 0.7
    aside = 0.1 * L * float(rng.choice(ASIDE[:-2]))
    step = np.array([length, aside] if along else [aside, width])
    step += float(rng.choice([0.0, 1e-9, 1e-4])) * L * np.array([along, not along])
    brick = _box(yard, BRICK)
    found = [_stand(yard, brick, *(k * step), 0.0, yard.upright())[0] for k in range(2)]
    x, y = 0.5 * step + 0.1 * L * rng.choice(ASIDE[:-1], 2)
    yaw = float(rng.choice(YAWS)) + (0.0 if along else 0.5 * math.pi)
    upper, _ = _stand(yard, brick, x, y, height + _gap(yard), yard.leaning(0.0, yaw))
    return [*found, _moving(yard, upper)]


def _beside(yard: Yard) -> list[Shape]:
    """One slides into a side of an equal one, or in space along it, in the plane over it."""
    rng, L = yard.rng, yard.length
    length, width, height = (edge * L for edge in BRICK)
    brick = _box(yard, BRICK)
    first, _ = _stand(yard, brick, 0.0, 0.0, 0.0, yard.upright())
    into = rng.random() < 0.5
    x = -length - float(rng.choice([1e-9, 0.02])) * L if into else -0.05 * L
    y = width * float(rng.choice(ASIDE)) if into else width + float(rng.choice([0.0, 1e-9, 1e-6])) * L
    floor = 0.0 if into or yard.dimension == 3 else height + float(rng.choice([0.0, 1e-9, 1e-6])) * L
    second, _ = _stand(yard, brick, x, y, floor, yard.upright())
    return [first, replace(second, speed=yard.at((0.3 if into else 0.2) * yard.speed, 0.0))]


def _on_an_edge(yard: Yard) -> list[Shape]:
    """A cube falls with an edge on a brick: on its face, along its end, or across that."""
    rng, L = yard.rng, yard.length
    low, top = _stand(yard, _box(yard, BRICK), 0.0, 0.0, 0.0, yard.upright())
    lean = math.radians(float(rng.choice([45.0, 44.0, 30.0])))
    x = float(rng.choice([0.0, 0.05, 0.1 - 1e-6, 0.1 - 1e-3])) * L
    yaw = float(rng.choice([*YAWS, rng.uniform(-math.pi, math.pi)]))
    up, _ = _stand(yard, _box(yard, (0.1, 0.1, 0.1)), x, 0.0, top + _gap(yard), yard.leaning(lean, yaw))
    return [low, up]
