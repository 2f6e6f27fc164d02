"""Cylinders among convex bodies: what touches is what separates them most, and what is flush stands."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import lcpflex as lf
from lcpflex.contact.near import near
from lcpflex.contact.spatial.table import (
    EDGE_CAP,
    EDGE_EDGE,
    EDGE_RIM,
    EDGE_SIDE,
    NODE_CAP,
    NODE_EDGE,
    NODE_FACET,
    NODE_SIDE,
    RIM_FACET,
    RIM_RIM,
)
from lcpflex.jit.kernel import FloatArray
from lcpflex.jit.struct import pack

UP, DOWN = (0.0, 0.0, 1.0), (0.0, 0.0, -9.81)
LYING = Rotation.from_euler("x", 0.5 * math.pi)  # along y
STEPPERS = [lf.MoreauJean(step=1e-3), lf.EventDriven(), lf.GeneralizedAlpha(step=1e-3)]
R = 0.05

Support = Callable[[FloatArray], FloatArray]


def of_cylinder(middle: FloatArray, axis: FloatArray, length: float, radius: float) -> Support:
    """The largest n.x of a cylinder, for directions (k, 3)."""

    def support(n: FloatArray) -> FloatArray:
        along = n @ axis
        across = np.sqrt(np.maximum(1.0 - along**2, 0.0))
        return np.asarray(n @ middle + 0.5 * length * np.abs(along) + radius * across)

    return support


def of_corners(corners: FloatArray) -> Support:
    return lambda n: np.asarray((n @ corners.T).max(axis=1))


def turned_alike(of: Rotation, case: int, random: np.random.Generator) -> Rotation:
    """Anyhow, or with ends or sides that are nearly parallel."""
    if case % 3 == 0:
        return Rotation.random(rng=random)
    nearly = Rotation.from_rotvec(random.standard_normal(3) * 10.0 ** random.uniform(-9, -4))
    angles = [0.5 * math.pi if case % 3 == 1 else 0.0, random.uniform(0.0, 6.0)]
    return of * Rotation.from_euler("yz", angles) * nearly


@pytest.mark.parametrize("scale", [1.0, 1e3])
@pytest.mark.parametrize("other", ["box", "cylinder"])
def test_the_least_gap_is_the_largest_separation(other: str, scale: float) -> None:
    """That along its own normal, and none of many directions separates more."""
    random = np.random.default_rng(3)
    directions = random.standard_normal((3000, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    corners = 0.5 * scale * np.array(np.meshgrid([-0.2, 0.2], [-0.14, 0.14], [-0.1, 0.1])).reshape(3, -1).T
    scene = lf.SpatialScene()
    can = scene.add(lf.Cylinder(R * scale, 0.1 * scale, mass=1.0), position=(scale, 0, 0))
    made = lf.Cuboid(*(scale * np.array([0.2, 0.14, 0.1])), mass=1.0)
    low = scene.add(made if other == "box" else lf.Cylinder(0.04 * scale, 0.16 * scale, mass=1.0))
    scene.contact(can.surface(), low.surface())
    compiled = scene.compile()
    model, q = pack(compiled.model), compiled.q.copy()
    kinds: set[int] = set()
    for case in range(60):
        below = Rotation.random(rng=random)
        above = turned_alike(below, case, random)
        if other == "box":
            second = of_corners(below.apply(corners))
        else:
            second = of_cylinder(np.zeros(3), below.apply(UP), 0.16 * scale, 0.04 * scale)
        way = random.standard_normal(3)
        way /= np.linalg.norm(way)

        def separation(
            n: FloatArray, far: float, above: Rotation = above, second: Support = second, way: FloatArray = way
        ) -> FloatArray:
            return -of_cylinder(far * way, above.apply(UP), 0.1 * scale, R * scale)(-n) - second(n)

        near_by, far = 0.0, 0.4 * scale
        for _ in range(30):
            middle = 0.5 * (near_by + far)
            apart = separation(directions, middle).max() > 0.0
            near_by, far = (near_by, middle) if apart else (middle, far)
        q[:3], q[3:7] = far * way, above.as_quat(scalar_first=True)
        q[7:10], q[10:14] = 0.0, below.as_quat(scalar_first=True)
        table, n = near(model, q, 1e-2 * scale)
        assert n > 0, case
        k = int(np.argmin(table.gap[:n]))
        normal = table.normal[k] if table.body[k, 0] == 0 else -table.normal[k]
        own = float(separation(normal[None], far)[0])
        assert abs(own - table.gap[k]) < 2e-6 * R * scale, case  # nearly parallel sides are taken as such
        assert separation(directions, far).max() < table.gap[k] + 2e-6 * R * scale, case
        kinds.add(int(table.kind[k]))
    expected = {NODE_CAP, EDGE_RIM, RIM_FACET, EDGE_SIDE, NODE_SIDE, NODE_FACET}
    assert kinds >= (expected if other == "box" else {EDGE_CAP, EDGE_RIM, RIM_FACET, RIM_RIM, EDGE_EDGE, NODE_EDGE})


def stacked(
    low: Any, high: Any, below: Rotation, above: Rotation, aside: float, on_ground: bool = False
) -> lf.SpatialScene:
    scene = lf.SpatialScene(gravity=DOWN)
    if on_ground:
        scene.ground.cylinder((0, 0, R), UP, R, 2 * R)
    else:
        scene.add(low, position=(0, 0, R), orientation=below)
    scene.add(high, name="high", position=(aside, 0.3 * aside, 3 * R), orientation=above)
    scene.ground.plane((0, 0, 0), UP)
    scene.contact_all(friction=0.3)
    return scene


@pytest.mark.parametrize("stepper", STEPPERS)
@pytest.mark.parametrize(("yaw", "aside"), [(0.0, 0.0), (1e-9, 1e-9), (0.3, 0.02)])
def test_what_is_flush_stands(stepper: Any, yaw: float, aside: float) -> None:
    box, can = lf.Cuboid(0.2, 0.2, 2 * R, mass=1.0), lf.Cylinder(R, 2 * R, mass=1.0)
    wide, narrow = lf.Cylinder(0.08, 2 * R, mass=1.0), lf.Cuboid(0.2, 0.1, 2 * R, mass=1.0)
    turn, upright = Rotation.from_euler("z", yaw), Rotation.identity()
    scenes = {
        "on a box": stacked(box, can, upright, turn, aside),
        "under a box": stacked(can, box, upright, turn, aside),
        "end on end": stacked(can, can, upright, turn, aside),
        "wider": stacked(can, wide, upright, turn, aside),
        "on the ground": stacked(None, can, upright, turn, aside, on_ground=True),
        "lying": stacked(box, can, upright, turn * LYING, aside),
        "lying beyond": stacked(narrow, lf.Cylinder(R, 0.16, mass=1.0), upright, turn * LYING, aside),
        "crossed": stacked(can, can, LYING, turn * Rotation.from_euler("y", 0.5 * math.pi), 0.0),
    }
    for name, scene in scenes.items():
        result = lf.simulate(scene, 0.03, stepper, progress=False)
        assert abs(result.q[-1, -5] - 3 * R) < 1e-9, name


@pytest.mark.parametrize("yaw", [0.0, 1e-9])
def test_a_cylinder_rolls_off_a_box(yaw: float) -> None:
    """At 1 m/s off an end of it: v^2 > g R, so that it flies at once."""
    scene = lf.SpatialScene(gravity=DOWN)
    scene.add(lf.Cuboid(1.0, 0.3, 0.1, mass=1e3), position=(0, 0, 0.05))
    can = lf.Cylinder(R, 0.16, mass=1.0)
    turn = Rotation.from_euler("z", yaw) * LYING
    scene.add(can, "can", position=(0.2, 0, 0.15), orientation=turn, velocity=(1, 0, 0), angular_velocity=(0, 20, 0))
    scene.ground.plane((0, 0, 0), UP)
    scene.contact_all(friction=0.3)
    for stepper, near_to in ((lf.MoreauJean(step=1e-3), 1e-9), (lf.EventDriven(), 1e-8)):
        result = lf.simulate(scene, 0.4, stepper, progress=False)
        x, z = result.q[-1, -7], result.q[-1, -5]
        assert abs(x - 0.6) < near_to
        assert abs(z - (0.15 - 0.5 * 9.81 * 0.1**2)) < near_to


@pytest.mark.parametrize("body", [lf.Cuboid(2 * R, 2 * R, 2 * R, mass=1.0), lf.Cylinder(R, 2 * R, mass=1.0)])
def test_what_slides_off_a_round_end_tips_over_its_arc(body: Any) -> None:
    """Without friction, where its middle is over the rim: not over a chord of its 16 points, which is 2.8 mm before."""
    scene = lf.SpatialScene(gravity=DOWN)
    scene.ground.cylinder((0, 0, R), UP, 0.15, 2 * R)
    scene.add(body, position=(0.1, 0.01, 3 * R), velocity=(0.5, 0.05, 0))
    scene.contact_all()
    over = 1.0 / math.hypot(0.5, 0.05) * (0.15 - math.hypot(0.1, 0.01))
    leans = []
    for until in (over, over + 0.02):
        q = lf.simulate(scene, until, lf.EventDriven(), progress=False).q[-1]
        leans.append(2.0 * math.hypot(q[4], q[5]))
    assert leans[0] < 1e-8
    assert leans[1] > 1e-4


@pytest.mark.parametrize("yaw", [0.0, 0.1])
def test_a_cylinder_that_slides_off_a_box_tips_over_its_edge(yaw: float) -> None:
    """Without friction; points of its rim come over the edge while it tips, and are no vertices."""
    found = []
    for stepper in (lf.EventDriven(), lf.MoreauJean(step=1e-4)):
        scene = lf.SpatialScene(gravity=DOWN)
        scene.ground.box((0, 0, 0.05), (0.4, 0.2, 0.1))
        turn = Rotation.from_euler("z", yaw)
        can = lf.Cylinder(R, 2 * R, mass=1.0)
        scene.add(can, position=(0.1, 0.01, 0.15), orientation=turn, velocity=(0.5, 0.05, 0))
        scene.contact_all()
        result = lf.simulate(scene, 0.36, stepper, progress=False)
        found.append(result.q[-1])
        assert result.energies.relative_remainder < 1e-3
    np.testing.assert_allclose(found[0], found[1], atol=1e-4)  # of first order: the step; 1.2e-3 as it was
    assert found[0][2] < 0.11  # it has tipped


def test_a_cylinder_lies_in_the_valley_of_two() -> None:
    scene = lf.SpatialScene(gravity=DOWN)
    for x in (-0.06, 0.06):
        scene.ground.cylinder((x, 0, R), (0, 1, 0), R, 0.3)
    height = R + math.sqrt(4 * R**2 - 0.06**2)
    scene.add(lf.Cylinder(R, 0.16, mass=1.0), "can", position=(0, 0, height), orientation=LYING)
    scene.contact_all(friction=0.3)
    result = lf.simulate(scene, 0.1, lf.MoreauJean(step=1e-3), progress=False)
    assert abs(result.q[-1, -5] - height) < 1e-5
    compiled = scene.compile()
    table, n = near(pack(compiled.model), compiled.q, 1e-6)
    assert table.kind[:n].tolist() == [NODE_EDGE] * 4


def test_crossed_cylinders_touch_at_one_place() -> None:
    can = lf.Cylinder(R, 0.3, mass=1.0)
    scene = stacked(can, can, LYING, Rotation.from_euler("y", 0.5 * math.pi), 0.0)
    compiled = scene.compile()
    table, n = near(pack(compiled.model), compiled.q, 1e-6)
    of_pair = [k for k in range(n) if table.body[k].min() >= 0]
    assert table.kind[of_pair].tolist() == [EDGE_EDGE]
    assert abs(table.gap[of_pair[0]]) < 1e-15
