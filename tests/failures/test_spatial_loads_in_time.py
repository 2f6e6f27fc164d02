"""Loads, springs, dampers and drives of space that steps of fixed length do not follow; and ones that they do."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.checks.loads_in_time import _rows, resisted
from lcpflex.checks.run_scales import _turned
from lcpflex.jit.struct import pack
from lcpflex.kinematics.spatial.configuration import advance
from tests.spatial_scenes import thrown

STEP = 1e-3
FAST = 2.0 * math.pi / (2.5 * STEP)  # 2.5 steps in a period


def pushed(load: Callable[[Any, Any], Any]) -> lf.Result:
    """A box without weight, off the middle of which something acts."""
    scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
    box = scene.add(
        lf.Cuboid(0.3, 0.2, 0.1, mass=2.0), "box", velocity=(0.1, 0.0, 0.0), angular_velocity=(0.0, 5.0, 0.0)
    )
    scene.load(load(scene, box))
    return lf.simulate(scene, 0.05, lf.MoreauJean(step=STEP))


def swinging(axis: int, omega: float, amplitude: float = 100.0) -> tuple[Any, ...]:
    return tuple(lf.Harmonic(amplitude, omega) if k == axis else 0.0 for k in range(3))


LOUD = {
    "force": (lambda s, b: lf.Force(b.at(0.1, 0, 0), swinging(2, FAST)), "the force on box has a period of"),
    "follower": (
        lambda s, b: lf.Force(b.point("right"), swinging(1, FAST), follower=True),
        "the force on box.right has a period of",
    ),
    "torque": (lambda s, b: lf.Torque(b.point("center"), swinging(0, FAST)), "the torque on box.center has a period"),
    "spring": (
        lambda s, b: lf.Spring(b.at(0.1, 0, 0), s.ground.at(0.1, 0, 0.5), stiffness=2e6, length=0.45),
        "the spring between box and the ground, which swings, has a period of",
    ),
    "bushing": (
        lambda s, b: lf.Bushing(b.point("center"), s.ground.at(0, 0, 0), rotational_stiffness=3e4),
        "the spring between box.center and the ground, which swings, has a period of",
    ),
    "damper": (
        lambda s, b: lf.Spring(b.at(0.1, 0, 0), s.ground.at(0.6, 0, 0), stiffness=1.0, damping=1e4),
        "the damper between box and the ground takes",
    ),
}
QUIET = {
    "slow force": lambda s, b: lf.Force(b.at(0.1, 0, 0), swinging(2, FAST / 20.0)),
    "weak force": lambda s, b: lf.Force(b.at(0.1, 0, 0), swinging(2, FAST, 1e-3)),
    "soft spring": lambda s, b: lf.Spring(b.at(0.1, 0, 0), s.ground.at(0.1, 0, 0.5), stiffness=2e3, length=0.45),
    "weak damper": lambda s, b: lf.Spring(b.at(0.1, 0, 0), s.ground.at(0.6, 0, 0), stiffness=1.0, damping=10.0),
}


@pytest.mark.parametrize("name", LOUD)
def test_what_a_step_does_not_follow_is_told(name: str) -> None:
    load, words = LOUD[name]
    told = [one for one in pushed(load).warnings if words in one]
    assert told, pushed(load).warnings
    advised = float(told[0].split("a step of ")[-1].split(" s would")[0])
    assert advised < STEP


@pytest.mark.parametrize("name", QUIET)
def test_harmless_loads_bring_no_alarm(name: str) -> None:
    assert not [one for one in pushed(QUIET[name]).warnings if "would" in one]


def test_a_drive_that_turns_back_within_steps_is_told() -> None:
    scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
    box = scene.add(lf.Cuboid(0.3, 0.2, 0.1, mass=2.0), "box", angular_velocity=(0.0, 0.0, 1e-3 * FAST))
    scene.join(
        lf.DrivenAngle(box.point("center"), scene.ground.at(0, 0, 0), lf.Harmonic(1e-3, FAST), axis=(0, 0, 1), name="d")
    )
    result = lf.simulate(scene, 0.05, lf.MoreauJean(step=STEP), project=True)
    assert any("the motion of joint 'd' has a period of" in one for one in result.warnings), result.warnings


def test_free_bodies_bring_no_alarm() -> None:
    assert not lf.simulate(thrown("box", "ball"), 0.1, lf.MoreauJean(step=STEP)).warnings


def test_turns_are_counted_and_swings_are_not() -> None:
    """A ball that turns by 6 rad about z: 6 rad; a box in a stiff bushing swings: its range."""
    result = lf.simulate(thrown("ball"), 2.0, lf.MoreauJean(step=1e-2))
    assert result.compiled is not None
    assert _turned(result, result.compiled.model.bodies)[0] == pytest.approx(6.0, rel=1e-9)
    swings = pushed(lambda s, b: lf.Bushing(b.point("center"), s.ground.at(0, 0, 0), rotational_stiffness=300.0))
    assert swings.compiled is not None
    angle = 2.0 * np.arcsin(swings.q[:, 5])  # about y, its only axis
    assert _turned(swings, swings.compiled.model.bodies)[0] == pytest.approx(np.ptp(angle), rel=1e-9)
    assert np.ptp(angle) > 1.5 * angle.max()


def test_rows_of_points_and_springs_are_derivatives() -> None:
    scene = thrown()
    box, soft = scene.body("box"), scene.body("soft")
    scene.load(lf.Spring(soft.point("3"), box.at(0.1, 0.05, 0.02), stiffness=1.0))
    compiled = scene.compile()
    model, q, h = pack(compiled.model), compiled.q.copy(), 1e-6
    row = resisted(model, q, 0)
    P, Q = compiled.model.loads.spring_point[0].tolist()
    lines = _rows(compiled.model, q, P)[:3] - _rows(compiled.model, q, Q)[:3]

    def apart(u: Any, scale: float) -> Any:
        at = np.zeros_like(q)
        advance(model, q, u, scale, at)
        state = compiled.state(0.0, at, u)
        return state.position(soft.point("3")) - state.position(box.at(0.1, 0.05, 0.02))

    for k in range(len(compiled.u)):
        u = np.zeros(len(compiled.u))
        u[k] = 1.0
        moved = (apart(u, h) - apart(u, -h)) / (2.0 * h)
        np.testing.assert_allclose(lines[:, k], moved, atol=1e-8)
        length = (np.linalg.norm(apart(u, h)) - np.linalg.norm(apart(u, -h))) / (2.0 * h)
        assert row[k] == pytest.approx(length, abs=1e-8)
