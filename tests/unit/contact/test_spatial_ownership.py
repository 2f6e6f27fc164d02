"""Which feature of a polyhedron a place belongs to: one owner outside, and by the exact distance."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import lcpflex as lf
from lcpflex.bodies.spatial.shapes import SurfaceShape
from lcpflex.contact.near import near
from lcpflex.contact.spatial.table import NODE_EDGE, NODE_FACET, NODE_POINT
from lcpflex.jit.struct import pack

Array = Any
FAR = 100.0


def distance_to_triangle(place: Array, a: Array, b: Array, c: Array) -> float:
    """By the least of the distances to its plane, where the foot is inside, and to its sides."""
    n = np.cross(b - a, c - a)
    n /= np.linalg.norm(n)
    inside = all(np.cross(q - p, place - p) @ n >= 0.0 for p, q in ((a, b), (b, c), (c, a)))
    found = [abs((place - a) @ n)] if inside else []
    for p, q in ((a, b), (b, c), (c, a)):
        s = np.clip((place - p) @ (q - p) / ((q - p) @ (q - p)), 0.0, 1.0)
        found.append(float(np.linalg.norm(place - p - s * (q - p))))
    return min(found)


def distance(shape: SurfaceShape, place: Array) -> float:
    return min(distance_to_triangle(place, *shape.vertices[t]) for t in shape.triangles)


def inside(shape: SurfaceShape, place: Array) -> bool:
    """By the solid angle that the surface is seen under."""
    angle = 0.0
    for t in shape.triangles:
        a, b, c = shape.vertices[t] - place
        la, lb, lc = (np.linalg.norm(x) for x in (a, b, c))
        angle += 2.0 * np.arctan2(a @ np.cross(b, c), la * lb * lc + (a @ b) * lc + (b @ c) * la + (c @ a) * lb)
    return bool(abs(angle) > 2.0 * np.pi)


def detector(body: lf.SpatialBody, radius: float = 0.0) -> Callable[[Array], tuple[Any, int]]:
    """What a node has with the surface of a body, at a place in the frame of that, which is turned and moved."""
    scene = lf.SpatialScene()
    turn, shift = Rotation.from_rotvec([0.3, -0.8, 0.5]), np.array([0.2, 0.1, -0.4])
    solid = scene.add(body, position=shift, orientation=turn)
    probe = scene.add(lf.Sphere(0.1, mass=1.0))
    tip = probe.sphere((0.0, 0.0, 0.0), radius) if radius else probe.node((0.0, 0.0, 0.0))
    scene.contact(tip, solid.surface())
    compiled = scene.compile(indents=lambda name: True)
    model, q = pack(compiled.model), compiled.q.copy()

    def at(place: Array, margin: float = FAR) -> tuple[Any, int]:
        q[7:10] = shift + turn.apply(place)
        return near(model, q, margin)

    return at


def hull(seed: int) -> lf.SpatialBody:
    rng = np.random.default_rng(seed)
    return lf.ConvexHull(rng.normal(size=(14, 3)) * [1.0, 0.7, 0.4], mass=1.0)


@pytest.mark.parametrize("seed", range(4))
def test_a_place_outside_of_a_convex_body_has_one_owner_at_the_exact_distance(seed: int) -> None:
    body = hull(seed)
    at, rng = detector(body), np.random.default_rng(100 + seed)
    kinds = set()
    for place in rng.normal(size=(150, 3)) * 1.2:
        if inside(body.shape, place):
            continue
        table, n = at(place)
        assert n == 1
        kinds.add(int(table.kind[0]))
        assert abs(table.gap[0] - distance(body.shape, place)) < 1e-14
    assert kinds == {NODE_FACET, NODE_EDGE, NODE_POINT}


def test_the_corners_and_sides_of_a_box_have_one_owner_each() -> None:
    at = detector(lf.Cuboid(2.0, 2.0, 2.0, mass=1.0))
    for x, y, z in np.ndindex(5, 5, 5):
        place = 0.75 * np.array([x - 2.0, y - 2.0, z - 2.0])
        if np.abs(place).max() < 1.0:
            continue
        table, n = at(place)
        assert n == 1
        assert abs(table.gap[0] - np.linalg.norm(np.maximum(np.abs(place) - 1.0, 0.0))) < 1e-14


def test_places_exactly_on_the_surface_of_a_box_have_a_facet_with_its_normal() -> None:
    at = detector(lf.Cuboid(2.0, 2.0, 2.0, mass=1.0))
    for x, y in ((0.0, 0.0), (0.5, 0.5), (0.3, -0.8), (1.0, 0.2), (1.0, 1.0)):
        table, n = at(np.array([x, y, 1.0]))
        assert n == 1
        assert table.kind[0] == NODE_FACET
        assert abs(table.gap[0]) < 1e-15


def test_below_the_surface_the_nearest_facet_holds_a_place_down_to_a_depth() -> None:
    at = detector(lf.Cuboid(2.0, 2.0, 0.4, mass=1.0))
    table, n = at(np.array([0.3, 0.2, 0.15]))
    assert n == 1
    assert abs(table.gap[0] + 0.05) < 1e-15
    table, n = at(np.array([0.95, 0.2, 0.12]))
    assert n == 1
    assert abs(table.gap[0] + 0.05) < 1e-15  # the way out sideways is shorter


def test_the_gap_is_continuous_along_a_path_about_a_convex_body() -> None:
    body = hull(7)
    at = detector(body, radius=0.05)
    angles = np.linspace(0.0, 2.0 * np.pi, 2001)
    path = np.stack([1.6 * np.cos(angles), 1.1 * np.sin(angles), 0.6 * np.sin(3.0 * angles)], axis=1)
    gaps = []
    for place in path:
        table, n = at(place)
        assert n == 1
        gaps.append(float(table.gap[0]))
    steps = np.linalg.norm(np.diff(path, axis=0), axis=1)
    assert (np.abs(np.diff(gaps)) <= steps * (1.0 + 1e-12)).all()


def l_block() -> lf.SpatialBody:
    """Two boxes in one: a floor 2 x 1 x 1 and a wall 1 x 1 x 2, hollow at x = 1, z = 1."""
    outline = np.array([[0, 0], [2, 0], [2, 1], [1, 1], [1, 2], [0, 2]], dtype=float)  # x, z; counter-clockwise
    k = len(outline)
    vertices = np.array([[x, y, z] for y in (0.0, 1.0) for x, z in outline])
    caps = [(0, 1, 2), (0, 2, 3), (0, 3, 5), (3, 4, 5)]
    triangles = [(a, b, c) for a, b, c in caps] + [(k + a, k + c, k + b) for a, b, c in caps]
    for i in range(k):
        j = (i + 1) % k
        triangles += [(i, k + j, j), (i, k + i, k + j)]
    shape = SurfaceShape(vertices, np.array(triangles), np.zeros((len(vertices), 0, 3)))
    return lf.SpatialBody(mass=1.0, inertia=np.eye(3), shape=shape)


def test_about_a_block_with_a_hollow_each_place_outside_has_one_or_two_owners() -> None:
    body = l_block()
    at, rng = detector(body), np.random.default_rng(3)
    numbers = set()
    for place in rng.uniform(-1.0, 3.0, size=(400, 3)) * [1.0, 0.6, 1.0]:
        if inside(body.shape, place):
            continue
        table, n = at(place)
        numbers.add(n)
        assert abs(table.gap[:n].min() - distance(body.shape, place)) < 1e-14
    assert numbers == {1, 2}


@pytest.mark.parametrize("sunk", [(-1e-3, 2e-3), (2e-3, -1e-3), (-1e-3, -2e-3), (1e-3, 1e-3), (0.0, 0.0)])
def test_a_hollow_holds_a_node_between_both_its_walls(sunk: tuple[float, float]) -> None:
    dx, dz = sunk
    table, n = detector(l_block())(np.array([1.0 + dx, 0.4, 1.0 + dz]), 0.01)
    assert n == 2
    np.testing.assert_allclose(np.sort(table.gap[:2]), np.sort([dx, dz]), atol=1e-15)
