"""What touches between surfaces of triangles whose faces lie on each other, turned or aside by hardly anything."""

from __future__ import annotations

from itertools import product
from typing import Any

import numpy as np
import pytest
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

import lcpflex as lf
from lcpflex.contact.near import near
from lcpflex.contact.spatial.kinds import FACET
from lcpflex.contact.spatial.table import NODE_FACET
from lcpflex.jit.struct import pack
from tests.split_surfaces import soft_block, solid, split_box

Array = Any
EDGES = (0.24, 0.1, 0.06)
SIZE = float(np.linalg.norm(EDGES))
LITTLE = (0.0, 1e-12, 3e-10, 2e-9, 7e-8, 3e-6, 4e-5, 6e-4, 9e-3)
BODIES = {
    "split": lambda: split_box(EDGES, (4, 2, 1)),
    "other cells": lambda: split_box(EDGES, (3, 3, 2)),
    "cuboid": lambda: lf.Cuboid(*EDGES, mass=1.0),
    "soft": lambda: soft_block(EDGES, (4, 2, 2), 8),
    "soft and fine": lambda: soft_block(EDGES, (5, 3, 2), 8),
}
PAIRS = [("split", "split"), ("split", "cuboid"), ("cuboid", "other cells"), ("other cells", "split"), ("soft", "soft"),
         ("soft and fine", "soft"), ("soft", "soft and fine"), ("cuboid", "soft"), ("soft", "split")]  # fmt: skip


class OnTop:
    """What a body has with one below it."""

    def __init__(self, low: lf.SpatialBody, top: lf.SpatialBody) -> None:
        scene = lf.SpatialScene()
        scene.contact(scene.add(low).surface(), scene.add(top).surface())
        self.compiled = scene.compile(indents=lambda name: True)
        self.model, self.q = pack(self.compiled.model), self.compiled.q.copy()
        self.at = len(self.q) - 7 - top.modes

    def rows(self, place: Array, turn: Rotation, margin: float = 1e-3) -> Any:
        """Gaps, normals on the upper body, places on body i, and keys."""
        self.q[self.at : self.at + 3] = place
        self.q[self.at + 3 : self.at + 7] = np.roll(turn.as_quat(), 1)
        table, n = near(self.model, self.q, margin)
        assert n <= len(table.key)
        point, body = self.compiled.model.points, self.compiled.model.points.body
        frames = [(np.zeros(3), Rotation.identity()), (np.array(place), turn)]
        places = []
        for k in range(n):
            p = table.point[k, :2]
            s = table.foot[k, 0] if table.kind[k] != NODE_FACET else 0.0
            at = point.place[p[0]] if s == 0.0 else (1.0 - s) * point.place[p[0]] + s * point.place[p[1]]
            origin, axes = frames[body[p[0]]]
            places.append(origin + axes.apply(np.array(at)))
        sense = np.where(table.body[:n, 0] == 1, 1.0, -1.0)
        return table.gap[:n].copy(), sense[:, None] * table.normal[:n], np.array(places), table.key[:n].copy()


def patch(shift: Array, yaw: float) -> Array:
    """Corners of the polygon in which the rectangle of EDGES and one that is shifted and turned overlap."""
    half = 0.5 * np.array(EDGES[:2])
    square = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    turn = np.array([[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]])
    polygon = list(square * half @ turn.T + shift)
    for axis, sign in product((0, 1), (-1.0, 1.0)):
        clipped = []
        for a, b in zip(polygon, polygon[1:] + polygon[:1], strict=True):
            da, db = sign * a[axis] - half[axis], sign * b[axis] - half[axis]
            if da <= 0.0:
                clipped.append(a)
            if (da < 0.0 < db) or (db < 0.0 < da):
                clipped.append(a + da / (da - db) * (b - a))
        polygon = clipped
    return np.array(polygon)


def beyond(places: Array, corner: Array) -> float:
    """How far a corner is outside the convex hull of places in the plane."""
    return float(max(ConvexHull(places).equations @ [*corner, 1.0]))


@pytest.mark.parametrize(("low", "top"), PAIRS)
def test_faces_touch_all_over_at_any_offset_and_yaw(low: str, top: str) -> None:
    """All gaps are that of the faces, and no corner of the patch is farther outside of them than the band is wide."""
    pair = OnTop(BODIES[low](), BODIES[top]())
    for k, (aside, yaw) in enumerate(product(LITTLE, LITTLE)):
        shift = np.array([aside, (-1.0) ** k * 0.7 * aside])
        for gap in (0.0, -2e-5):
            gaps, normals, places, _ = pair.rows([*shift, EDGES[2] + gap], Rotation.from_euler("z", yaw))
            assert np.abs(normals - [0.0, 0.0, 1.0]).max() < 1e-12, (aside, yaw)
            assert np.abs(gaps - gap).max() < 1e-14
            for corner in patch(shift, yaw):
                assert beyond(places[:, :2], corner) < 3e-4 * SIZE, (aside, yaw, corner)


@pytest.mark.parametrize("scale", [1e-3, 1e3])
def test_the_unit_of_length_changes_nothing(scale: float) -> None:
    counts = []
    for unit in (1.0, scale):
        box = split_box(tuple(unit * e for e in EDGES), (4, 2, 1))
        pair = OnTop(box, split_box(tuple(unit * e for e in EDGES), (3, 3, 2)))
        counts.append([
            len(pair.rows([unit * a, 0.0, unit * EDGES[2]], Rotation.from_euler("z", yaw), 1e-3 * unit)[0])
            for a, yaw in product(LITTLE, (0.0, 1e-7, 1e-3))
        ])  # fmt: skip
    assert counts[0] == counts[1]
    assert min(counts[0]) >= 4


@pytest.mark.parametrize(("low", "top"), [("split", "split"), ("soft and fine", "soft")])
def test_what_comes_twice_does_not_depend_on_how_near_is_asked_for(low: str, top: str) -> None:
    pair = OnTop(BODIES[low](), BODIES[top]())
    for aside, tilt in product((0.0, 1e-9, 2e-5, 1e-3), (0.0, 1e-6, 1e-3)):
        turn, place = Rotation.from_euler("y", tilt), [aside, aside / 3.0, EDGES[2] + 1e-4]
        gaps, _, _, keys = pair.rows(place, turn, 1e-3)
        for margin in (3e-4, 1.5e-4, 1e-4, 5e-5):
            assert set(pair.rows(place, turn, margin)[3]) == set(keys[gaps <= margin])


@pytest.mark.parametrize("cells", [(4, 2, 1), (3, 3, 2), (5, 4, 3)])
@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e3])
def test_the_depth_below_a_facet_ends_where_a_ray_meets_an_edge_on_the_other_side(
    cells: tuple[int, int, int], scale: float
) -> None:
    pair = OnTop(split_box(tuple(scale * e for e in EDGES), cells), lf.Cuboid(1.0, 1.0, 1.0, mass=1.0))
    contacts = pair.compiled.model.contacts
    depths = contacts.feature_depth[: contacts.feature_start[1]][
        contacts.feature_kind[: contacts.feature_start[1]] == FACET
    ]
    assert set(np.round(depths / scale, 12)) == {0.5 * e for e in EDGES}


def test_uneven_faces_touch_up_and_down_alone() -> None:
    for uneven, seed in product((1e-9, 1e-7, 1e-5), range(3)):
        pair = OnTop(split_box(EDGES, (4, 2, 1), uneven, seed), split_box(EDGES, (4, 2, 1), uneven, seed + 10))
        for aside, yaw in product((0.0, 1e-9, 1e-6, 1e-4, 1e-2), (0.0, 1e-8, 1e-4)):
            gaps, normals, places, _ = pair.rows([aside, aside / 2, EDGES[2]], Rotation.from_euler("z", yaw))
            assert normals[:, 2].min() > 0.99
            assert np.abs(gaps).max() < 6.0 * uneven
            for corner in patch(np.array([aside, aside / 2]), yaw):
                assert beyond(places[:, :2], corner) < 3e-4 * SIZE


def step_of(a: float, b: float, h: float) -> tuple[Array, Array]:
    """A block a x b x h with another one a/2 x b x h on its left half, its corner at the origin."""
    outline = np.array([[0.0, 0.0], [a, 0.0], [a, h], [a / 2, h], [a / 2, 2 * h], [0.0, 2 * h]])
    vertices = np.array([[x, y, z] for y in (0.0, b) for x, z in outline])
    caps = [(0, 1, 2), (0, 2, 3), (0, 3, 5), (3, 4, 5)]
    triangles = [*caps, *((6 + i, 6 + k, 6 + j) for i, j, k in caps)]
    for i in range(6):
        j = (i + 1) % 6
        triangles += [(i, 6 + j, j), (i, 6 + i, 6 + j)]
    return vertices, np.array(triangles)


def scene_of(*bodies: tuple[lf.SpatialBody, Array, Rotation]) -> lf.SpatialScene:
    scene = lf.SpatialScene()
    floor = scene.ground.plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    held = []
    for k, (body, place, turn) in enumerate(bodies):
        held.append(scene.add(body, f"body{k}", place, turn).surface())
        scene.contact(held[-1], floor, friction=0.4, name=f"floor{k}")
        for i in range(k):
            scene.contact(held[i], held[k], friction=0.4, name=f"{i} and {k}")
    return scene


def weight_of(result: lf.Result, names: tuple[str, ...]) -> float:
    """Mean force upwards over the run by these contacts."""
    return sum(result.contact(name).impulse[-1, 0] for name in names) / result.times[-1]


STEPPERS = [lf.EventDriven(), lf.MoreauJean(step=1e-3), lf.GeneralizedAlpha(step=1e-3)]


@pytest.mark.parametrize("stepper", STEPPERS, ids=["event-driven", "Moreau-Jean", "generalised-alpha"])
@pytest.mark.parametrize(("aside", "yaw"), [(0.0, 3e-9), (2e-9, 0.0), (3e-6, 5e-8), (5e-5, 2e-4), (0.004, 0.02)])
def test_split_boxes_stand_on_each_other(aside: float, yaw: float, stepper: Any) -> None:
    box = split_box(EDGES, (4, 2, 1))
    turn = Rotation.from_euler("z", yaw)
    for other in (box, lf.Cuboid(*EDGES, mass=1.0)):
        scene = scene_of((box, (0, 0, 0.03), Rotation.identity()), (other, (aside, -aside, 0.09), turn))
        result = lf.simulate(scene, 0.02, stepper)
        assert not result.warnings
        assert np.abs(result.q - result.q[0]).max() < 1e-9
        assert weight_of(result, ("0 and 1",)) == pytest.approx(9.81, rel=1e-6)
        assert weight_of(result, ("floor0",)) == pytest.approx(19.62, rel=1e-6)


@pytest.mark.parametrize("stepper", STEPPERS, ids=["event-driven", "Moreau-Jean", "generalised-alpha"])
def test_steps_that_interlock_stand(stepper: Any) -> None:
    vertices, triangles = step_of(0.2, 0.1, 0.06)
    body, centre = solid(vertices, triangles)
    whole = np.array([0.1, 0.05, 0.09])
    upside_down = Rotation.from_euler("y", np.pi)
    there = whole + upside_down.apply(centre - whole)
    for aside, yaw in ((0.0, 0.0), (1e-9, 1e-9), (2e-6, 0.0), (1e-4, 1e-4)):
        turn = Rotation.from_euler("z", yaw) * upside_down
        scene = scene_of((body, centre, Rotation.identity()), (body, there + np.array([aside, aside, 0.0]), turn))
        result = lf.simulate(scene, 0.03, stepper)
        assert np.abs(result.q - result.q[0]).max() < 1e-9, (aside, yaw)
        assert weight_of(result, ("floor0", "floor1")) == pytest.approx(19.62, rel=1e-6)


@pytest.mark.parametrize(("cells", "yaw"), [((11, 5, 1), 0.3), ((4, 2, 1), 0.0), ((1, 1, 1), 0.0)])
def test_inner_edges_of_a_floor_catch_nothing(cells: tuple[int, int, int], yaw: float) -> None:
    """A box slides straight over the facets of a flat floor, at the closed form's speed."""
    floor = split_box((1.3, 0.5, 0.1), cells)
    vertices, triangles = step_of(0.2, 0.1, 0.06)
    stepped, centre = solid(vertices, triangles)
    for body, height in (
        (lf.Cuboid(*EDGES, mass=1.0), 0.03),
        (split_box(EDGES, (4, 2, 1)), 0.03),
        (stepped, centre[2]),
    ):
        scene = lf.SpatialScene()
        ground = scene.add(floor, position=(0, 0, -0.05))
        scene.join(lf.Weld(ground.at(0, 0, 0), scene.ground.at(0, 0, -0.05)))
        turn = Rotation.from_euler("z", yaw)
        box = scene.add(body, "box", (-0.4, 0.013, height), turn, velocity=(1.5, 0.1, 0.0))
        scene.contact(ground.surface(), box.surface(), friction=0.3)
        result = lf.simulate(scene, 0.2, lf.EventDriven())
        speed, brake, t = np.hypot(1.5, 0.1), 0.3 * 9.81, result.times
        share = (speed * t - 0.5 * brake * t**2) / speed
        want = np.array([-0.4, 0.013, height]) + share[:, None] * [1.5, 0.1, 0.0]
        assert np.abs(result.q[:, 7:10] - want).max() < 1e-12
        assert np.abs(result.q[:, 10:14] - result.q[0, 10:14]).max() < 1e-12


def test_an_edge_does_not_go_through_the_face_of_a_body_that_deforms() -> None:
    """A bar that falls with its long edge across a block is stopped, though neither has a vertex in the other."""
    block = soft_block((0.2, 0.2, 0.1), (4, 4, 3), 8, density=1000.0, youngs_modulus=2e8)
    bar = lf.Cuboid(0.06, 0.3, 0.04, mass=0.3)
    turn = Rotation.from_euler("y", 50, degrees=True)
    lowest = 0.03 * np.sin(np.radians(50)) + 0.02 * np.cos(np.radians(50))
    scene = lf.SpatialScene()
    low = scene.add(block, position=(0, 0, 0.05))
    top = scene.add(bar, "bar", (0.03, 0.02, 0.1 + lowest + 1e-3), turn, velocity=(0, 0, -0.3))
    scene.contact(low.surface(), scene.ground.plane((0, 0, 0), (0, 0, 1)), friction=0.5)
    scene.contact(low.surface(), top.surface(), friction=0.3, name="pair")
    result = lf.simulate(scene, 0.02, lf.MoreauJean(step=1e-4))
    assert result.contact("pair").impulse[-1, 0] > 0.04
    assert result.penetration.max() < 2e-4
