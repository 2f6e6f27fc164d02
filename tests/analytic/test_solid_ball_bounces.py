"""A solid ball bounces off a plane: contact time, largest force and restitution, against Hertz's law of impact.

    T = 2.9433 d / v,   F = 4/3 E* R^(1/2) d^(3/2),   d = (15 m v^2 / (16 E* R^(1/2)))^(2/5)

Hertz's ball is a half space around the contact, and rigid beyond: a real one differs by a part of a/R (here .026), so
that errors are smaller for the slower of two balls. m is that of the mesh, 1 to 2 % below that of the ball.
"""

from __future__ import annotations

import math
from functools import cache
from typing import Any, NamedTuple

import numpy as np
import pytest

import lcpflex as lf

pytestmark = pytest.mark.slow
STEEL: dict[str, Any] = {"density": 7800.0, "youngs_modulus": 2.1e11, "poissons_ratio": 0.3}
RADIUS, SPEED = 0.01, 0.3
STIFF = 2.1e11 / (1.0 - 0.3**2)  # E*
SLOWER = 32.0  # times; a, which goes with v^(2/5), is a quarter then
MODES = 40  # up to 38 / contact time: the ball does not ring, half of them do as well


def hertz(mass: float, speed: float) -> tuple[float, float]:
    """T [s] and F [N]."""
    approach = (15.0 * mass * speed**2 / (16.0 * STIFF * math.sqrt(RADIUS))) ** 0.4
    whole = math.sqrt(math.pi) * math.gamma(0.4) / math.gamma(0.9) * 0.8
    return whole * approach / speed, 4.0 / 3.0 * STIFF * math.sqrt(RADIUS) * approach**1.5


class Bounce(NamedTuple):
    """What is found over what Hertz says, less one; and the restitution less one."""

    time: float
    force: float
    restitution: float


@cache
def bounce(size: float, finest: float, ring: float, slower: float = 1.0) -> Bounce:
    """Elements of ``finest`` up to ``ring`` of them from the pole, for SPEED; with a slower ball as a shrinks."""
    speed, finest = SPEED / slower, finest / slower**0.4
    solid = lf.Solid.ball(RADIUS, size, near={"pole": ((0.0, 0.0, -RADIUS), finest, ring * finest)}, **STEEL)
    body = solid.reduce(MODES, contact="pole", rows="normal")
    time, force = hertz(body.mass, speed)
    scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
    ball = scene.add(body, "ball", body.origin, velocity=(0.0, 0.0, -speed))
    ground = scene.ground.plane((0.0, 0.0, -RADIUS * (1.0 + 1e-9)), (0.0, 0.0, 1.0))
    scene.contact(ball.face("pole"), ground, points="nodes", name="hit")
    result = lf.simulate(scene, 1.2 * time, lf.MasslessBoundary(step=time / 1300.0), record=0.0)
    found = result.contact("hit").force[:, 0]
    touching = result.times[found > 0.0]
    restitution = float(result.impulse[-1, 0, 0]) / (body.mass * speed) - 1.0
    return Bounce(float(np.ptp(touching)) / time - 1.0, float(found.max()) / force - 1.0, restitution - 1.0)


FINE, COARSE = (1.8e-3, 6.4e-5, 5.6), (2.5e-3, 8e-5, 3.7)  # 12 000 and 4800 nodes, of which 101 and 45 may touch


def test_a_bounce_is_that_of_hertz() -> None:
    found = bounce(*FINE)
    assert abs(found.time) < 0.015
    assert abs(found.force) < 0.015
    assert abs(found.restitution) < 1e-4


def test_errors_fall_with_the_mesh_and_the_contact() -> None:
    fine, coarse, slow = bounce(*FINE), bounce(*COARSE), bounce(*COARSE, SLOWER)
    assert abs(fine.force) < 0.9 * abs(coarse.force)
    assert abs(slow.force) < 0.6 * abs(coarse.force)
    assert abs(slow.time) < 0.5 * abs(coarse.time)
