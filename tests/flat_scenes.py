"""Bodies with modes that close flat or point by point: a bar at a wall, upright or tilted, and one on a roller."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np

import lcpflex as lf
from lcpflex.bodies import craig_bampton, residual_compliance
from lcpflex.jit.kernel import FloatArray
from tests import libs

__all__ = ["STEEL", "bar_at_wall", "bar_on_roller"]

STEEL: dict[str, Any] = {"density": 7850.0, "youngs_modulus": 2.1e11, "poissons_ratio": 0.3}
ALUMINIUM: dict[str, Any] = {"density": 2700.0, "youngs_modulus": 7e10, "poissons_ratio": 0.33}
LENGTH, HALF = 0.2, 0.01
FINE = 4e-5  # elements where the roller touches [m]


@cache
def upright(basis: str = "free", modes: int = 40) -> lf.Body:
    """A bar of steel, .2 x .02 x .02 m, with the five nodes of its end by residual modes or kept."""
    mesh = libs.skfem.MeshQuad.init_tensor(np.linspace(0.0, LENGTH, 41), np.linspace(-HALF, HALF, 5))
    solid = lf.Continuum(mesh, thickness=2.0 * HALF, sets={"end": lambda x, y: x > LENGTH - 1e-9}, **STEEL)
    return residual_compliance(solid, "end", modes) if basis == "free" else craig_bampton(solid, "end", modes)


def bar_at_wall(
    tilt: float = 0.0,
    gap: float = 1e-7,
    speed: float = 1.0,
    weight: float = 0.0,
    spin: float = 0.0,
    basis: str = "free",
) -> lf.Scene:
    """The bar flies with its end against a wall, turned by ``tilt`` [rad]."""
    scene = lf.Scene(gravity=(weight, 0.0))
    reach = float((LENGTH * np.cos(tilt) - np.array([-HALF, HALF]) * np.sin(tilt)).max())
    place = {"position": (-reach - gap, 0.0), "angle": tilt}
    bar = scene.add(upright(basis), "bar", velocity=(speed, 0.0), angular_velocity=spin, **place)
    scene.contact(bar.surface("end"), scene.ground.half_plane((0.0, 0.0), (-1.0, 0.0)), name="hit")
    return scene


def lines(length: float, growth: float, longest: float, fine: int = 0) -> FloatArray:
    """Nodes from 0 to ``length``, ``fine`` elements of the least size and growing ones from there."""
    found, size = [0.0], FINE
    while found[-1] < length:
        found.append(found[-1] + size)
        size = min(size * growth, longest) if len(found) > fine else size
    return np.array(found) * (length / found[-1])


@cache
def lying(modes: int) -> lf.Body:
    """A bar of aluminium, .2 x .005 x .028 m, with residual modes of 25 nodes amid its lower side."""
    x = lines(0.1, 1.25, 2e-3, 12)
    mesh = libs.skfem.MeshQuad.init_tensor(np.concatenate([-x[:0:-1], x]), lines(5e-3, 1.5, 1.0))
    below = {"side": lambda x, y: (y < 1e-9) & (np.abs(x) < 12.5 * FINE)}
    return residual_compliance(lf.Continuum(mesh, thickness=0.028, sets=below, **ALUMINIUM), "side", modes)


def bar_on_roller(modes: int = 60, friction: float = 0.0, restitution: float = 0.0) -> lf.Scene:
    """The bar falls on a fixed roller of 20 mm radius, and slides."""
    scene = lf.Scene(gravity=(0.0, 0.0))
    bar = scene.add(lying(modes), "bar", position=(0.0, 1e-7), velocity=(0.4, -0.4))
    side, roller = bar.surface("side"), scene.ground.circle((0.0, -0.02), 0.02)
    scene.contact(side, roller, friction, restitution, node_side=side, name="hit")
    return scene
