"""How far contacts in space are inside their features: to leave one is what detection takes for it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import lcpflex as lf
from lcpflex.contact.near import near
from lcpflex.contact.spatial.narrow_phase.rim import FLAT
from lcpflex.contact.spatial.pairs import foot_margin, node_margin, refresh
from lcpflex.contact.spatial.table import EDGE_EDGE, NODE_EDGE, NODE_FACET, NODE_POINT, RIM_FACET
from lcpflex.jit.struct import pack
from tests.unit.contact.test_spatial_ownership import l_block
from tests.unit.contact.test_spatial_pairs_found import Pair, turns

Array = Any
UP = (0.0, 0.0, 1.0)


def some_hull(seed: int) -> lf.SpatialBody:
    return lf.ConvexHull(np.random.default_rng(seed).normal(size=(8, 3)), mass=1.0)


BODIES = {  # at which distance, and the kinds of pairs they have
    "polyhedra": (
        some_hull(0),
        lf.Cuboid(1.0, 0.6, 0.8, mass=1.0),
        3.5,
        {NODE_FACET, NODE_EDGE, NODE_POINT, EDGE_EDGE},
    ),
    "capsules": (
        lf.Capsule(0.1, 1.0, mass=1.0),
        lf.Capsule(0.2, 0.6, mass=1.0),
        0.6,
        {NODE_EDGE, NODE_POINT, EDGE_EDGE},
    ),
    "capsule and box": (
        lf.Cuboid(1.0, 0.6, 0.8, mass=1.0),
        lf.Capsule(0.1, 1.5, mass=1.0),
        1.2,
        {NODE_FACET, EDGE_EDGE},
    ),
}


@pytest.mark.parametrize("name", BODIES)
def test_margins_are_positive_where_detection_finds_the_pair(name: str) -> None:
    one, two, distance, kinds = BODIES[name]
    pair, rng = Pair(one, two), np.random.default_rng(1)
    seen = []
    for turn in turns(2, 16):
        way = rng.normal(size=3)
        table, n = pair.at(distance * way / np.linalg.norm(way), turn)
        seen.append((pair.q.copy(), table, {int(table.key[k]): float(table.sense[k]) for k in range(n)}))
    told: dict[bool, set[int]] = {True: set(), False: set()}
    for _, table, keys in seen:
        for q, _, found in seen:
            for k in range(len(keys)):
                refresh(pair.model, q, table, k)
                margin = min(foot_margin(pair.model, q, table, k), node_margin(pair.model, q, table, k))
                if table.gap[k] > 0.0 and abs(margin) > 1e-6:
                    present = found.get(int(table.key[k])) == table.sense[k]
                    assert present == (margin > 0.0)
                    told[present].add(int(table.kind[k]))
    assert told[True] >= kinds
    assert told[False] >= kinds


def test_spheres_have_no_end() -> None:
    pair = Pair(lf.Sphere(0.3, mass=1.0), lf.Sphere(0.2, mass=1.0))
    table, n = pair.at(np.array([0.4, 0.2, 0.6]), Rotation.identity())
    assert n == 1
    assert foot_margin(pair.model, pair.q, table, 0) == np.inf
    assert node_margin(pair.model, pair.q, table, 0) == np.inf


def over_facet(body: lf.SpatialBody) -> tuple[Any, Array]:
    """A scene with a node over that body, which stays where it is; the node is the frame of the second one."""
    scene = lf.SpatialScene()
    solid = scene.add(body)
    probe = scene.add(lf.Sphere(0.1, mass=1.0))
    scene.contact(probe.node((0.0, 0.0, 0.0)), solid.surface())
    compiled = scene.compile(indents=lambda name: True)
    return pack(compiled.model), compiled.q.copy()


def test_margins_over_a_facet_are_distances_from_its_sides_in_extents_of_the_surface() -> None:
    model, q = over_facet(lf.Cuboid(2.0, 1.0, 0.4, mass=1.0))
    extent = float(np.linalg.norm([1.0, 0.5, 0.2]))
    for x, y in ((0.9, 0.3), (0.7, -0.45), (-0.95, 0.1), (-0.8, -0.4)):
        q[7:10] = x, y, 0.5
        table, n = near(model, q, 1.0)
        assert n == 1
        assert table.kind[0] == NODE_FACET
        diagonal = min(abs(side @ [x, y]) for side in ([0.5, -1.0] / np.sqrt(1.25), [0.5, 1.0] / np.sqrt(1.25)))
        sides = min(1.0 - abs(x), 0.5 - abs(y))
        margin = foot_margin(model, q, table, 0) * extent
        assert min(abs(margin - sides), abs(margin - min(diagonal, sides))) < 1e-14  # of which triangle the side is


def test_a_facet_has_no_end_at_a_hollow() -> None:
    model, q = over_facet(l_block())  # a floor at z = 1 beside a wall at x = 1
    q[7:10] = 1.0 + 1e-6, 0.4, 1.0 + 1e-6
    table, n = near(model, q, 1e-3)
    assert n == 2
    q[7:10] = 1.0 - 1e-4, 0.4, 1.0 - 1e-4
    for k in range(n):
        refresh(model, q, table, k)
        assert table.gap[k] == pytest.approx(-1e-4, abs=1e-14)
        assert foot_margin(model, q, table, k) > 0.01


def test_a_plane_has_no_end_and_a_disc_ends_where_it_lies_flat() -> None:
    scene = lf.SpatialScene()
    scene.contact(scene.add(lf.Cylinder(0.5, 1.0, mass=1.0)).surface(), scene.ground.plane((0.0, 0.0, 0.0), UP))
    compiled = scene.compile(indents=lambda name: True)
    model, q = pack(compiled.model), compiled.q.copy()
    for tilt in (1e-1, 1e-3, 1e-6):
        q[3:7] = np.roll(Rotation.from_rotvec([tilt, 0.0, 0.0]).as_quat(), 1)
        table, n = near(model, q, 0.1)
        rims = [k for k in range(n) if table.kind[k] == RIM_FACET]
        assert rims
        for k in range(n):
            assert foot_margin(model, q, table, k) == np.inf
        for k in rims:
            assert node_margin(model, q, table, k) == pytest.approx(np.sin(tilt) - FLAT, abs=1e-15)
    q[3:7] = 1.0, 0.0, 0.0, 0.0
    refresh(model, q, table, rims[0])
    assert node_margin(model, q, table, rims[0]) == -FLAT
