"""Contacts between two bodies of space: their least gap is the distance, and their number what holds the bodies."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import lcpflex as lf
from lcpflex.contact.near import near
from lcpflex.contact.spatial.table import EDGE_EDGE, NODE_EDGE, NODE_FACET, NODE_POINT, RIM_FACET
from lcpflex.jit.struct import pack
from tests.unit.contact.test_spatial_ownership import distance

Array = Any
UP = (0.0, 0.0, 1.0)


class Pair:
    """Two bodies with a contact: what there is with the second one put somewhere."""

    def __init__(self, first: lf.SpatialBody, second: lf.SpatialBody) -> None:
        scene = lf.SpatialScene()
        scene.contact(scene.add(first).surface(), scene.add(second).surface())
        compiled = scene.compile(indents=lambda name: True)
        self.model, self.q = pack(compiled.model), compiled.q.copy()

    def at(self, shift: Array, turn: Rotation, margin: float = 100.0) -> tuple[Any, int]:
        self.q[7:10] = shift
        self.q[10:14] = np.roll(turn.as_quat(), 1)
        return near(self.model, self.q, margin)


def between_segments(a: Array, b: Array, c: Array, d: Array) -> float:
    """The least over the inside, if both feet are there, and the ends."""
    e, f, y = b - a, d - c, a - c
    n = np.cross(e, f)
    found = []
    if n @ n > 1e-20:
        s, t = np.cross(-y, f) @ n / (n @ n), np.cross(-y, e) @ n / (n @ n)
        if 0.0 <= s <= 1.0 and 0.0 <= t <= 1.0:
            found.append(abs(y @ n) / np.sqrt(n @ n))
    for p, u, v in ((a, c, d), (b, c, d), (c, a, b), (d, a, b)):
        s = np.clip((p - u) @ (v - u) / ((v - u) @ (v - u)), 0.0, 1.0)
        found.append(float(np.linalg.norm(p - u - s * (v - u))))
    return min(found)


def sides(triangles: Array) -> set[tuple[int, int]]:
    return {tuple(sorted(side)) for t in triangles for side in pairwise([*t, t[0]])}


def between_hulls(one: Any, two: Any, shift: Array, turn: Rotation) -> float:
    """Of disjoint convex bodies, the second one moved."""
    there = turn.apply(np.array(two.vertices)) + shift
    found = [distance(one, place) for place in there]
    found += [distance(two, turn.inv().apply(place - shift)) for place in one.vertices]
    found += [
        between_segments(one.vertices[a], one.vertices[b], there[c], there[d])
        for a, b in sides(one.triangles)
        for c, d in sides(two.triangles)
    ]
    return min(found)


def turns(seed: int, number: int) -> list[Rotation]:
    return list(Rotation.random(number, rng=np.random.default_rng(seed)))


@pytest.mark.parametrize("seed", [0, 2])
def test_the_least_gap_of_two_convex_bodies_is_their_distance(seed: int) -> None:
    rng = np.random.default_rng(seed)
    bodies = [lf.ConvexHull(rng.normal(size=(8, 3)), mass=1.0), lf.Cuboid(1.0, 0.6, 0.8, mass=1.0)]
    pair = Pair(*bodies)
    kinds = set()
    for turn in turns(seed, 9):
        way = rng.normal(size=3)
        shift = 4.0 * way / np.linalg.norm(way)
        table, n = pair.at(shift, turn)
        least = int(np.argmin(table.gap[:n]))
        kinds.add(int(table.kind[least]))
        assert abs(table.gap[least] - between_hulls(bodies[0].shape, bodies[1].shape, shift, turn)) < 1e-13
    assert EDGE_EDGE in kinds
    assert len(kinds) > 2


def test_the_least_gap_of_two_capsules_is_that_of_their_axes_less_their_radii() -> None:
    pair, rng = Pair(lf.Capsule(0.1, 1.0, mass=1.0), lf.Capsule(0.2, 0.6, mass=1.0)), np.random.default_rng(5)
    ends = [np.array([[0, 0, -0.5 * length], [0, 0, 0.5 * length]]) for length in (1.0, 0.6)]
    kinds = set()
    for turn in turns(8, 60):
        shift = rng.normal(size=3)
        table, n = pair.at(shift, turn)
        least = int(np.argmin(table.gap[:n]))
        kinds.add(int(table.kind[least]))
        assert abs(table.gap[least] + 0.3 - between_segments(*ends[0], *(turn.apply(ends[1]) + shift))) < 1e-14
        assert len(set(table.key[:n])) == n
    assert kinds == {EDGE_EDGE, NODE_EDGE, NODE_POINT}


def test_parallel_capsules_touch_at_both_ends_of_the_overlap() -> None:
    pair = Pair(lf.Capsule(0.1, 1.0, mass=1.0), lf.Capsule(0.2, 0.6, mass=1.0))
    table, n = pair.at(np.array([0.3, 0.0, 0.4]), Rotation.identity(), 1e-9)
    assert n == 2
    assert set(table.kind[:n]) == {NODE_EDGE}
    np.testing.assert_allclose(table.gap[:n], 0.0, atol=1e-15)


def test_the_least_gap_of_a_capsule_and_a_box_is_their_distance() -> None:
    box = lf.Cuboid(1.0, 0.6, 0.8, mass=1.0)
    pair, rng = Pair(box, lf.Capsule(0.1, 1.5, mass=1.0)), np.random.default_rng(6)
    ends = np.array([[0.0, 0.0, -0.75], [0.0, 0.0, 0.75]])
    for turn in turns(9, 40):
        way = rng.normal(size=3)
        shift = 1.6 * way / np.linalg.norm(way)
        table, n = pair.at(shift, turn)
        a, b = turn.apply(ends) + shift
        expected = min(
            *(distance(box.shape, end) for end in (a, b)),
            *(between_segments(a, b, *box.shape.vertices[list(side)]) for side in sides(box.shape.triangles)),
        )
        assert abs(table.gap[:n].min() + 0.1 - expected) < 1e-13


CUBE = lf.Cuboid(1.0, 1.0, 1.0, mass=1.0)


@pytest.mark.parametrize(
    ("second", "shift", "angle", "expected"),
    [
        (CUBE, (0.0, 0.0), 0.0, 4),  # corners on corners
        (CUBE, (0.3, 0.0), 0.0, 4),  # two corners of each on the border of the other
        (CUBE, (0.3, 0.2), 0.0, 4),  # a corner of each, and two crossings
        (CUBE, (0.0, 0.0), np.pi / 4, 8),  # an octagon of crossings
        (lf.Cuboid(0.5, 0.5, 1.0, mass=1.0), (0.1, 0.05), 0.3, 4),  # all corners of the smaller one
        (lf.Cuboid(2.0, 0.5, 1.0, mass=1.0), (0.0, 0.0), 0.0, 4),  # a cross
    ],
)
@pytest.mark.parametrize("tilt", [0.0, 1e-12, -1e-12])
def test_boxes_on_each_other_touch_at_the_corners_of_the_patch(
    second: lf.SpatialBody, shift: tuple[float, float], angle: float, expected: int, tilt: float
) -> None:
    turn = Rotation.from_rotvec([tilt, -0.7 * tilt, 0.0]) * Rotation.from_rotvec([0.0, 0.0, angle])
    table, n = Pair(CUBE, second).at(np.array([*shift, 1.0]), turn, 1e-6)
    assert n == expected
    np.testing.assert_allclose(np.abs(table.normal[:n, 2]), 1.0, atol=1e-9)
    np.testing.assert_allclose(table.gap[:n], 0.0, atol=1e-11)


def test_boxes_side_by_side_touch_with_their_sides_alone() -> None:
    table, n = Pair(CUBE, CUBE).at(np.array([1.0, 0.0, 0.0]), Rotation.identity(), 1e-6)
    assert n == 4
    np.testing.assert_allclose(np.abs(table.normal[:n, 0]), 1.0)


def cylinder_on_a_plane(margin: float = 1e-3) -> Any:
    scene = lf.SpatialScene()
    scene.contact(scene.add(lf.Cylinder(0.5, 1.0, mass=1.0)).surface(), scene.ground.plane((0.0, 0.0, 0.0), UP))
    compiled = scene.compile(indents=lambda name: True)
    model, q = pack(compiled.model), compiled.q.copy()

    def at(tilt: float, axis: float, height: float) -> tuple[Any, int]:
        turn = Rotation.from_rotvec(tilt * np.array([np.cos(axis), np.sin(axis), 0.0]))
        q[:3] = 0.0, 0.0, height
        q[3:7] = np.roll(turn.as_quat(), 1)
        return near(model, q, margin)

    return at


def lowest(tilt: float) -> float:
    """Of a cylinder about its centre: the lowest point of its lower rim."""
    return 0.5 * abs(np.sin(tilt)) + 0.5 * np.cos(tilt)


def test_a_tilted_cylinder_touches_with_the_lowest_point_of_its_rim() -> None:
    at = cylinder_on_a_plane()
    for tilt in (0.02, 0.5, 1.5):
        table, n = at(tilt, 0.4, lowest(tilt) + 1e-5)
        assert n == 1
        assert table.kind[0] == RIM_FACET
        assert abs(table.gap[0] - 1e-5) < 1e-15


def test_a_cylinder_stands_on_points_of_its_rim_and_lies_on_the_ends_of_a_line() -> None:
    at = cylinder_on_a_plane()
    table, n = at(0.0, 0.0, 0.5)
    assert n == 8
    assert set(table.kind[:n]) == {NODE_FACET}
    np.testing.assert_allclose(table.gap[:n], 0.0, atol=1e-15)
    table, n = at(np.pi / 2, 0.0, 0.5)
    assert n == 2
    assert set(table.kind[:n]) == {RIM_FACET}
    np.testing.assert_allclose(table.gap[:n], 0.0, atol=1e-15)


def test_the_least_gap_has_no_jump_where_a_cylinder_stands_up() -> None:
    at = cylinder_on_a_plane(0.1)
    for tilt in np.concatenate([-np.logspace(-1, -12, 300), [0.0], np.logspace(-12, -1, 300)]):
        table, n = at(float(tilt), 0.3, 0.5)
        assert abs(table.gap[:n].min() - (0.5 - lowest(tilt))) < 4e-9  # where rounding hides the lowest point: 0.5e-7
        if abs(tilt) > 1e-6:
            assert abs(table.gap[:n].min() - (0.5 - lowest(tilt))) < 1e-15
