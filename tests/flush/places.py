"""How a body lies on another one: exactly on it, turned, tilted and aside by next to nothing up to a lot."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

__all__ = ["PI", "Place", "few", "mixed", "single"]

AMOUNTS = (0.0, *np.logspace(-12.0, 0.0, 60).tolist())
PI = (round(math.pi, 7), round(math.pi, 8), round(math.pi, 9), float(np.float32(math.pi)))
WAYS = ((0.0, 1.0, 0.0), (1.0, 0.0, 0.0), (0.6, 0.8, 0.0))  # of offsets, and axes of tilts


class Place(NamedTuple):
    """Of the upper body above the lower one, whose faces are horizontal."""

    yaw: float = 0.0  # [rad] about z
    tilt: float = 0.0  # [rad] about a horizontal axis
    aside: float = 0.0  # over the width
    way: int = 0  # direction of the offset, and axis of the tilt

    @property
    def amount(self) -> float:
        """The largest of the three, up to half turns."""
        return max(abs(math.remainder(self.yaw, math.pi)), self.tilt, self.aside)

    def turn(self) -> Rotation:
        """Of the upper body."""
        return Rotation.from_rotvec(self.tilt * np.array(WAYS[self.way])) * Rotation.from_euler("z", self.yaw)

    def at(self, width: float, x: float, z: float) -> Any:
        """(3,) where the upper body is, which would be at (x, 0, z) [m]."""
        return self.aside * width * np.array(WAYS[self.way]) + (x, 0.0, z)


def single(tilts: bool = True) -> Iterator[Place]:
    """One of the three alone, all amounts."""
    yield from (Place(yaw=yaw) for yaw in (*AMOUNTS, *PI))
    for way in range(len(WAYS)):
        yield from (Place(aside=aside, way=way) for aside in AMOUNTS[1:])
        yield from (Place(tilt=tilt, way=way) for tilt in AMOUNTS[1:] if tilts)


def few(tilts: bool = True) -> Iterator[Place]:
    """Eight of them: what was wrong once, and its neighbours."""
    yield from (Place(yaw=yaw) for yaw in (3e-9, 1e-7, PI[0], 0.1))
    yield from (Place(aside=1e-9), Place(aside=1e-5), Place(aside=1e-2, way=2))
    yield Place(tilt=1e-6, way=1) if tilts else Place(yaw=1e-5)


def mixed(count: int, seed: int) -> Iterator[Place]:
    """All three at once, of any size each."""
    rng = np.random.default_rng(seed)
    yaws = (*AMOUNTS, *PI, *(math.pi / 2 + amount for amount in AMOUNTS[::6]))
    for _ in range(count):
        yaw, tilt, aside = (float(rng.choice(values)) for values in (yaws, AMOUNTS, AMOUNTS))
        yield Place(yaw, tilt * (rng.random() < 0.5), aside * (rng.random() < 0.8), int(rng.integers(3)))
