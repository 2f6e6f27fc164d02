"""Flush and nearly flush bodies: a tower of ten boxes level and turned at random, and detection of a pair."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import lcpflex as lf
from lcpflex.contact.detection import detect
from lcpflex.contact.table import most_corners, table_maker
from lcpflex.jit.struct import pack
from tests.flush.pairs import BRICK, box, gem
from tests.flush.scenes import STEPPERS, level

BOXES = 10
MOST = {"EventDriven": 8.0, "MoreauJean": 3.0, "GeneralizedAlpha": 3.0}  # of the level one; measured 5.0, 1.6, 0.8
DURATION = {"EventDriven": 0.02, "MoreauJean": 0.3, "GeneralizedAlpha": 0.05}  # [s]

Interleave = Callable[..., Mapping[str, float]]


def tower(yaw: float) -> lf.SpatialScene:
    """Boxes on each other, each turned by up to ``yaw`` either way [rad]."""
    scene, rng = level(), np.random.default_rng(2)
    scene.ground.plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    for k in range(BOXES):
        turn = Rotation.from_euler("z", float(rng.uniform(-yaw, yaw)))
        scene.add(box(*BRICK).body, f"box {k}", (0.0, 0.0, 0.06 * (k + 0.5)), turn)
    scene.contact_all(friction=0.5)
    return scene


def seconds(scene: lf.SpatialScene, stepper: str) -> float:
    """Of a millisecond of motion."""
    duration = DURATION[stepper]
    result = lf.simulate(scene, duration, STEPPERS[stepper], record=duration, progress=False)
    assert np.abs(result.q[-1] - result.q[0]).max() < 1e-3
    return float(1e-3 * result.wall_time / duration)


@pytest.mark.parametrize("stepper", STEPPERS)
def test_a_tower_turned_at_random_costs_little_more_than_a_level_one(interleave: Interleave, stepper: str) -> None:
    """A pair of turned boxes touches at eight corners instead of four: twice the rows, and what solving them costs."""
    level_one, turned = tower(0.0), tower(np.pi)
    medians = interleave(
        {
            f"level tower, {stepper}": lambda: seconds(level_one, stepper),
            f"turned tower, {stepper}": lambda: seconds(turned, stepper),
        },
        rounds=3,
    )
    assert medians[f"turned tower, {stepper}"] <= MOST[stepper] * medians[f"level tower, {stepper}"]


def detection(low: lf.SpatialBody, up: lf.SpatialBody, height: float, turn: Rotation) -> Callable[[], int]:
    """A call that detects what touches between two bodies."""
    scene = lf.SpatialScene()
    first = scene.add(low)
    second = scene.add(up, position=(0.0, 0.0, height), orientation=turn)
    scene.contact(first.surface(), second.surface())
    compiled = scene.compile(indents=lambda name: True)
    model, q = pack(compiled.model), compiled.q.copy()
    corners = most_corners(model.contacts)
    table = table_maker(True)(64, len(model.contacts.surface_body), corners=corners)
    assert 0 < detect(model, q, 1e-3, table) <= 64
    return lambda: int(detect(model, q, 1e-3, table))


def test_detection_of_a_pair(
    report: Callable[[str], None], per_call: Callable[[Callable[[], object], float], float], interleave: Interleave
) -> None:
    """Microseconds a pair; those of calls from Python are in all of them, about one."""
    brick, stone = box(*BRICK), gem(3)
    turned, still = Rotation.from_euler("z", 0.3), Rotation.identity()
    calls = {
        "boxes flush": detection(brick.body, brick.body, 0.06, still),
        "boxes turned": detection(brick.body, brick.body, 0.06, turned),
        "boxes tilted": detection(brick.body, brick.body, 0.06, Rotation.from_rotvec([1e-3, 2e-3, 0.3])),
        f"hulls of {len(stone.corners)} corners": detection(stone.body, stone.body, 2.0 * stone.height, turned),
    }
    medians = interleave({name: lambda call=call: per_call(call, 2e-3) for name, call in calls.items()}, rounds=3)
    assert medians["boxes turned"] <= 10.0 * medians["boxes flush"]
