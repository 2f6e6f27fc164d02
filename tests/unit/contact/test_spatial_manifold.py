"""Convex polyhedra that lie on each other: the patch, its least gap, its keys and weights have no jump.

References know no features: the least gap is that of all separating axes, patches are those of half planes, and rows
those of a node that stands where edges cross.
"""

from __future__ import annotations

from itertools import product
from typing import Any

import numpy as np
import pytest
from scipy.spatial import HalfspaceIntersection
from scipy.spatial.transform import Rotation

import lcpflex as lf
from lcpflex.contact.near import near
from lcpflex.contact.spatial.pairs import contact_bias, contact_point, contact_rows, gap_rate
from lcpflex.contact.spatial.table import EDGE_FACET, NODE_FACET
from lcpflex.jit.struct import pack
from tests.unit.contact.test_spatial_pairs_found import sides

Array = Any
BRICK = lf.Cuboid(0.2, 0.1, 0.06, mass=1.0)
SIZE = float(np.linalg.norm([0.2, 0.1, 0.06]))
ANGLES = (0.0, 1e-12, 1e-9, 3e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 0.01, 0.1, 0.4, 1.0)
PIS = (3.1415927, 3.14159265, 3.141592654, float(np.float32(np.pi)))


class Lying:
    """The second of two bodies somewhere on, or near, the first one, which is in its own frame."""

    def __init__(self, below: lf.SpatialBody, above: lf.SpatialBody, reverse: bool = False) -> None:
        scene = lf.SpatialScene()
        first, second = scene.add(below, name="below"), scene.add(above, name="above")
        pair = (second.surface(), first.surface()) if reverse else (first.surface(), second.surface())
        scene.contact(*pair)
        self.bodies = below, above
        compiled = scene.compile(indents=lambda name: True)
        self.model, self.q = pack(compiled.model), compiled.q.copy()

    def at(self, shift: Array, turn: Rotation, margin: float) -> tuple[Any, int]:
        self.q[7:10] = shift
        self.q[10:14] = np.roll(turn.as_quat(), 1)
        return near(self.model, self.q, margin)

    def separation(self) -> float:
        """Along the axis on which both are farthest apart, of all normals and all products of two edges."""
        turn = Rotation.from_quat(np.roll(self.q[10:14], -1))
        one = np.array(self.bodies[0].shape.vertices)
        two = turn.apply(np.array(self.bodies[1].shape.vertices)) + self.q[7:10]
        axes = [normals(one, self.bodies[0].shape.triangles), normals(two, self.bodies[1].shape.triangles)]
        e, f = (
            np.array([places[b] - places[a] for a, b in sides(body.shape.triangles)])
            for places, body in zip((one, two), self.bodies, strict=True)
        )
        across = np.cross((e / np.linalg.norm(e, axis=1)[:, None])[:, None], f / np.linalg.norm(f, axis=1)[:, None])
        sines = np.linalg.norm(across, axis=2)
        axes.append(across[sines > 1e-6] / sines[sines > 1e-6][:, None])
        n = np.concatenate(axes)
        apart = (two @ n.T).min(axis=0) - (one @ n.T).max(axis=0), (one @ n.T).min(axis=0) - (two @ n.T).max(axis=0)
        return float(np.maximum(*apart).max())


def normals(places: Array, triangles: Array) -> Array:
    a, b, c = np.moveaxis(places[triangles], 1, 0)
    n = np.cross(b - a, c - a)
    return n / np.linalg.norm(n, axis=1)[:, None]


def outline(half: tuple[float, float], offset: Array, yaw: float) -> Array:
    """(4, 3) half planes n.x + c <= 0 of a rectangle."""
    turn = np.array([[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]])
    ways = np.array([[1, 0], [-1, 0], [0, 1], [0, -1]]) @ turn.T
    reach = np.array([half[0], half[0], half[1], half[1]])
    return np.column_stack([ways, -(reach + ways @ offset)])


def support(corners: Array, way: Array) -> float:
    return float((corners @ way).max())


def patch_of(table: Any, model: Any, q: Array, n: int) -> Array:
    return np.array([contact_point(model, q, table, k) for k in range(n)])


@pytest.mark.parametrize("gap", [0.0, -2e-4, 1e-3])
@pytest.mark.parametrize("reverse", [False, True])
def test_flush_boxes_never_lose_their_support(gap: float, reverse: bool) -> None:
    lying = Lying(BRICK, BRICK, reverse)
    ways = [np.array([np.cos(a), np.sin(a), 0.0]) for a in np.linspace(0.0, 2 * np.pi, 16, endpoint=False)]
    offsets = [(0.0, 0.0), (1e-12, 0.0), (1e-9, 1e-9), (1e-7, 0.0), (1e-4, -1e-6), (0.03, 0.0), (0.03, 0.02)]
    for yaw, offset in product((*ANGLES, *PIS), offsets):
        table, n = lying.at([*offset, 0.06 + gap], Rotation.from_euler("z", yaw), 2e-3)
        assert n >= 4, (yaw, offset)
        assert abs(table.gap[:n].min() - gap) < 1e-9 * SIZE
        assert abs(np.abs(table.normal[:n, 2]) - 1.0).max() < 1e-14
        planes = np.vstack([outline((0.1, 0.05), np.zeros(2), 0.0), outline((0.1, 0.05), np.array(offset), yaw)])
        truth = HalfspaceIntersection(planes, 0.5 * np.array(offset)).intersections
        found = patch_of(table, lying.model, lying.q, n)[:, :2]
        assert max(abs(support(found, way[:2]) - support(truth, way[:2])) for way in ways) < 2e-9 * SIZE, (yaw, offset)


def test_gaps_of_tilted_boxes_are_the_separation() -> None:
    lying = Lying(BRICK, BRICK)
    for tilt, yaw, offset in product((1e-12, 1e-9, 1e-6, 1e-4, 5e-3), (0.0, 1e-8, 1e-3, 0.3), (0.0, 1e-9, 1e-5, 0.04)):
        turn = Rotation.from_euler("z", yaw) * Rotation.from_euler("xy", [0.6 * tilt, tilt])
        for height in (0.06, 0.06 - 2e-4):
            table, n = lying.at([offset, 0.3 * offset, height], turn, 1e-3)
            assert n >= 2
            truth = lying.separation()  # along one normal; depths along that of the other face differ by cosines
            assert abs(table.gap[:n].min() - truth) < 1e-9 * SIZE + tilt**2 * abs(truth), (tilt, yaw, offset)


@pytest.mark.parametrize("parallel", [None, 1e-12, 1e-8, 1e-5, 1e-2])
def test_no_pair_of_hulls_is_lost(parallel: float | None) -> None:
    rng = np.random.default_rng(3)
    for k in range(12):
        hulls = [lf.ConvexHull(rng.normal(size=(10, 3)), mass=1.0) for _ in range(2)]
        lying = Lying(*(hulls if parallel is None else (BRICK, BRICK)))
        turn = Rotation.random(rng=rng)
        if parallel is not None:
            turn = Rotation.from_rotvec(parallel * rng.normal(size=3)) * Rotation.from_euler("z", 90 * (k % 4), True)
        way = rng.normal(size=3)
        low, high = 0.0, 20.0
        for _ in range(60):
            middle = 0.5 * (low + high)
            lying.q[7:10], lying.q[10:14] = middle * way, np.roll(turn.as_quat(), 1)
            low, high = (middle, high) if lying.separation() < 0.0 else (low, middle)
        size = SIZE if parallel is not None else 2.0 * min(float(s) for s in lying.model.contacts.surface_extent)
        for share in (1.0, 1.0 - 1e-6, 1.0 - 1e-4):
            table, n = lying.at(share * high * way, turn, 1e-7 * size)
            assert n > 0
            assert abs(table.gap[:n].min() - lying.separation()) < 2e-6 * size


def test_what_touches_keeps_its_key_whichever_face_is_the_reference() -> None:
    lying = Lying(BRICK, BRICK)
    for yaw, offset in product((0.0, 1e-5, 0.3), (0.0, 0.02)):
        found = []
        for tilt in (-1e-7, 1e-7):  # the face of the other body is the reference
            turn = Rotation.from_euler("z", yaw) * Rotation.from_euler("y", tilt)
            table, n = lying.at(turn.apply([0.0, 0.0, 0.03]) + np.array([offset, 0.3 * offset, 0.03]), turn, 1e-3)
            found.append(sorted(table.key[:n].tolist()))
        assert found[0] == found[1]


def test_forces_by_weight_make_no_jump() -> None:
    """Second moments of shares of a load in the middle, as a box begins to turn, or moves aside."""

    def moments(yaw: float, offset: float) -> Array:
        lying = Lying(BRICK, BRICK)
        table, n = lying.at([offset, 0.0, 0.06], Rotation.from_euler("z", yaw), 1e-3)
        at, w = patch_of(table, lying.model, lying.q, n), table.weight[:n]
        middle = w @ at / w.sum()
        rows = np.stack([np.ones(n), *(at[:, :2] - middle[:2]).T])
        force = w * (rows.T @ np.linalg.solve(rows * w @ rows.T, [1.0, 0.0, 0.0]))
        return np.array([force @ at[:, 0] ** 2, force @ at[:, 1] ** 2, np.sqrt(force @ (at[:, :2] ** 2).sum(axis=1))])

    for offset in (0.0, 0.03):
        before = moments(0.0, offset)
        for yaw in (1e-12, 1e-9, 3e-9, 1e-8, 1e-7, 1e-6):
            assert abs(moments(yaw, offset) - before).max() < 1e-6 * before.max() + 10.0 * yaw


def test_rows_of_crossings_are_those_of_a_node_there() -> None:
    """On a body whose face is level with that of the other or tilted, whichever has the face, moving anyhow."""
    rng = np.random.default_rng(4)
    told = set()
    for k in range(24):
        lying = Lying(BRICK, lf.Cuboid(0.15, 0.12, 0.05, mass=1.0), reverse=k % 2 == 1)
        turn = Rotation.from_euler("zyx", [rng.uniform(0.1, 1.2), *(1e-3 * rng.normal(size=2))])
        table, n = lying.at([0.04, 0.03, 0.055 + 1e-5], turn, 2e-3)
        u = rng.normal(size=12)
        for e in np.flatnonzero(table.kind[:n] == EDGE_FACET).tolist():
            i, j = table.body[e].tolist()
            points, feet = lying.model.points, table.foot[e]
            face = int(points.body[table.point[e, 4]])
            told.add((face == j, face))
            ends = points.place[table.point[e, :2]] if face == j else points.place[table.point[e, 2:4]]
            s = feet[0] if face == j else feet[1]
            there = scene_of_a_node(lying, (1.0 - s) * ends[0] + s * ends[1], i if face == j else j, face, table, e)
            np.testing.assert_allclose(rates(there, u), rates((lying.model, lying.q, table, e), u), atol=1e-12)
    assert len(told) == 4


def scene_of_a_node(lying: Lying, place: Array, b: int, face: int, table: Any, e: int) -> tuple[Any, Array, Any, int]:
    """An entry of a node of body b over the plane of the face."""
    scene = lf.SpatialScene()
    bodies = [scene.add(body) for body in lying.bodies]
    turns = [Rotation.from_quat(np.roll(lying.q[7 * k + 3 : 7 * k + 7], -1)) for k in range(2)]
    outward = table.normal[e] if face == table.body[e, 1] else -table.normal[e]
    corner = lying.model.points.place[table.point[e, 4]]
    plane = bodies[face].plane(corner, turns[face].inv().apply(outward))
    scene.contact(bodies[b].node(place), plane)
    compiled = scene.compile(indents=lambda name: True)
    model = pack(compiled.model)
    found, n = near(model, lying.q, 1.0)
    assert (n, found.kind[0]) == (1, NODE_FACET)
    return model, lying.q, found, 0


def rates(entry: tuple[Any, Array, Any, int], u: Array) -> Array:
    """Gap, its rate, and acceleration and velocity of body 0 against body 1 as vectors, with and without bias."""
    model, q, table, k = entry
    rows = np.zeros((3, 2, 6))
    contact_rows(model, q, table, k, rows[0], rows[1:])
    n, t = table.normal[k], table.tangent[k]
    axes = np.stack([n, t, np.cross(n, t)])
    sign = 1.0 if table.body[k, 0] == 0 else -1.0
    body = {int(b): side for side, b in enumerate(table.body[k])}
    velocity = sum(rows[:, body[b]] @ u[6 * b : 6 * b + 6] for b in range(2))
    bias = np.array(contact_bias(model, q, u, table, k))
    blocks = [sign * axes.T @ rows[:, body[b]] for b in range(2)]
    normal = [rows[0, body[b]] for b in range(2)]
    told = [table.gap[k], gap_rate(model, q, u, table, k), bias[0], *normal[0], *normal[1]]
    return np.concatenate([told, sign * axes.T @ velocity, sign * axes[1:].T @ bias[1:], *(b.ravel() for b in blocks)])


def test_triangles_of_one_plane_are_one_face_though_points_are_noisy() -> None:
    rng = np.random.default_rng(5)
    corners = np.array(list(product((-0.1, 0.1), (-0.05, 0.05), (-0.03, 0.03))))
    for noise in (0.0, 1e-12, 1e-9, 1e-8):
        hull = lf.ConvexHull(corners + noise * rng.normal(size=(8, 3)), mass=1.0)
        lying = Lying(hull, hull)
        assert np.diff(lying.model.contacts.side_start).tolist() == [4] * 12
        table, n = lying.at([0.0, 0.0, 0.06], Rotation.identity(), 1e-4)
        assert n >= 4
        assert abs(table.gap[:n]).max() < 10.0 * noise + 1e-15


@pytest.mark.parametrize("unit", [1e-6, 1e-3, 1e3])
def test_units_do_not_matter(unit: float) -> None:
    far = np.array([7.0, -3.0, 2.0])
    for scale in (1.0, unit):
        lying = Lying(*(lf.Cuboid(0.2 * scale, 0.1 * scale, 0.06 * scale, mass=1.0) for _ in range(2)))
        lying.q[:3] = scale * far
        table, n = lying.at(scale * (far + np.array([0.01, 0.0, 0.06])), Rotation.from_euler("z", 1e-7), 1e-3 * scale)
        if scale == 1.0:
            known = n, table.key[:n].copy(), table.weight[:n].copy()
        assert (n, table.key[:n].tolist()) == (known[0], known[1].tolist())
        np.testing.assert_allclose(table.weight[:n], known[2], atol=1e-6)
        assert abs(table.gap[:n]).max() < 1e-14 * scale * np.linalg.norm(far)


def test_a_force_law_is_as_stiff_whatever_corners_there_are() -> None:
    """A box on an equal one sinks by m g / 4 k, turned or not: corners come and go."""
    for yaw in (0.0, 1e-8, 1e-6, 1e-3, 0.3):
        scene = lf.SpatialScene(gravity=(0.0, 0.0, -9.81))
        low = scene.add(BRICK, position=(0.0, 0.0, 0.03))
        scene.join(lf.Weld(low.at(0.0, 0.0, 0.0), scene.ground.at(0.0, 0.0, 0.03)))
        top = scene.add(BRICK, position=(0.0, 0.0, 0.09), orientation=Rotation.from_euler("z", yaw))
        scene.contact(top.surface(), low.surface(), law=lf.Penalty(stiffness=1e4, damping=50.0))
        result = lf.simulate(scene, 0.3, lf.MoreauJean(step=1e-3), progress=False)
        assert abs(0.09 - result.q[-1, 9] - 9.81 / 4e4) < 1e-9
