"""Spheres and nodes by a cylinder: one owner of every place, by the exact distance, whatever carries the cylinder."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import lcpflex as lf
from lcpflex.contact.near import near
from lcpflex.contact.spatial.pairs import contact_bias, contact_rows, foot_margin, node_margin, refresh
from lcpflex.contact.spatial.table import NODE_CAP, NODE_RIM, NODE_SIDE
from lcpflex.jit.struct import pack

Array = Any
FAR = 100.0
RADIUS, LENGTH = 0.5, 1.4
TURN, SHIFT = Rotation.from_rotvec([0.3, -0.8, 0.5]), np.array([0.2, 0.1, -0.4])


def distance(place: Array, radius: float = RADIUS, length: float = LENGTH) -> float:
    """To a solid cylinder about z around 0, < 0 inside: of a rectangle in the half plane of z and the place."""
    beside, above = np.hypot(place[0], place[1]) - radius, abs(place[2]) - 0.5 * length
    if beside <= 0.0 and above <= 0.0:
        return float(max(beside, above))
    return float(np.hypot(max(beside, 0.0), max(above, 0.0)))


class Detector:
    """What a node or sphere has with a cylinder, at a place in the frame of that, which is turned and moved."""

    def __init__(self, radius: float = 0.0, grounded: bool = False, first: bool = True) -> None:
        scene = lf.SpatialScene()
        if grounded:
            solid = scene.ground.cylinder(SHIFT, TURN.apply([0.0, 0.0, 1.0]), RADIUS, LENGTH)
        else:
            solid = scene.add(lf.Cylinder(RADIUS, LENGTH, mass=1.0), position=SHIFT, orientation=TURN).surface()
        probe = scene.add(lf.Sphere(0.1, mass=1.0), "probe")
        tip = probe.sphere((0.0, 0.0, 0.0), radius) if radius else probe.node((0.0, 0.0, 0.0))
        scene.contact(*((tip, solid) if first else (solid, tip)))
        compiled = scene.compile(indents=lambda name: True)
        self.model, self.q, self.place = pack(compiled.model), compiled.q.copy(), -7
        self.table: Any = None

    def put(self, place: Array) -> None:
        self.q[-7:-4] = SHIFT + TURN.apply(place)

    def at(self, place: Array, margin: float = FAR) -> tuple[Any, int]:
        self.put(place)
        self.table, n = near(self.model, self.q, margin)
        return self.table, n


def places(seed: int, number: int) -> Array:
    """In a box about the cylinder, and the special ones: on its axis, its borders and its circles."""
    rng = np.random.default_rng(seed)
    return rng.uniform(-1.0, 1.0, (number, 3)) * [1.2, 1.2, 1.6]


@pytest.mark.parametrize(("radius", "grounded", "first"), [(0.0, False, True), (0.3, False, False), (0.3, True, True)])
def test_every_place_has_one_owner_at_the_exact_distance(radius: float, grounded: bool, first: bool) -> None:
    detector, kinds = Detector(radius, grounded, first), {"outside": set(), "inside": set()}
    for place in places(1, 1500):
        table, n = detector.at(place)
        assert n == 1
        expected = distance(place)
        assert abs(table.gap[0] + radius - expected) < 1e-14
        kinds["outside" if expected > 0.0 else "inside"].add(int(table.kind[0]))
    assert kinds == {"outside": {NODE_SIDE, NODE_CAP, NODE_RIM}, "inside": {NODE_SIDE, NODE_CAP}}


def test_the_normal_leads_to_the_nearest_place_of_the_surface() -> None:
    detector = Detector()
    for place in places(2, 500):
        table, _ = detector.at(place)
        step = 1e-6
        slope = [(distance(place + step * e) - distance(place - step * e)) / (2.0 * step) for e in np.eye(3)]
        np.testing.assert_allclose(table.normal[0], TURN.apply(slope), atol=1e-8)
        axes = np.array([table.normal[0], table.tangent[0]])
        np.testing.assert_allclose(axes @ axes.T, np.eye(2), atol=1e-14)


@pytest.mark.parametrize("radius", [0.0, 0.05])
def test_the_gap_changes_by_no_more_than_the_way(radius: float) -> None:
    """Along straight paths through and about the cylinder."""
    detector, rng = Detector(radius), np.random.default_rng(3)
    for _ in range(12):
        start, end = rng.uniform(-1.2, 1.2, (2, 3))
        path = start + np.linspace(0.0, 1.0, 800)[:, None] * (end - start)
        gaps = []
        for place in path:
            table, n = detector.at(place)
            assert n == 1
            gaps.append(float(table.gap[0]))
        steps = np.linalg.norm(np.diff(path, axis=0), axis=1)
        assert (np.abs(np.diff(gaps)) <= steps * (1.0 + 1e-9) + 1e-15).all()


@pytest.mark.parametrize("radius", [0.0, 0.3])
@pytest.mark.parametrize("off", [0.0, 1e-17, 1e-13, 1e-9])
def test_places_without_a_direction_have_numbers(radius: float, off: float) -> None:
    """On the axis, in the middle of an end, on the circle of a rim, on both borders; just beside them as well."""
    detector = Detector(radius)
    heights = (0.0, 0.1, 0.5 * LENGTH - RADIUS, 0.5 * LENGTH, 0.5 * LENGTH + 0.2, -0.5 * LENGTH, -0.9)
    for z in heights:
        for r in (0.0, RADIUS, RADIUS + 0.1):
            place = np.array([r + off, off, z + off])
            table, n = detector.at(place)
            assert n == 1
            assert abs(table.gap[0] + radius - distance(place)) < 2e-9 * LENGTH
            rows = np.zeros((3, 2, 6))
            u = np.arange(1.0, 13.0)
            contact_rows(detector.model, detector.q, table, 0, rows[0], rows[1:])
            assert np.isfinite(rows).all()
            assert np.isfinite(contact_bias(detector.model, detector.q, u, table, 0)).all()
            axes = np.array([table.normal[0], table.tangent[0]])
            np.testing.assert_allclose(axes @ axes.T, np.eye(2), atol=1e-14)


def test_margins_end_where_detection_finds_another_part() -> None:
    detector, seen = Detector(0.1), []
    for place in places(4, 60):
        table, _ = detector.at(place)
        seen.append((place, table, int(table.key[0])))
    told: dict[bool, set[int]] = {True: set(), False: set()}
    for _, table, key in seen:
        for place, _, found in seen:
            detector.put(place)
            refresh(detector.model, detector.q, table, 0)
            margin = foot_margin(detector.model, detector.q, table, 0)
            assert node_margin(detector.model, detector.q, table, 0) == np.inf
            if distance(place) > 0.0 and table.gap[0] > -0.1 and abs(margin) > 1e-6:
                assert (key == found) == (margin > 0.0)
                told[key == found].add(int(table.kind[0]))
    assert told == {flag: {NODE_SIDE, NODE_CAP, NODE_RIM} for flag in (True, False)}


def test_of_contacts_those_within_the_margin_are_found() -> None:
    detector = Detector(0.1)
    for place, gap in (((0.9, 0.0, 0.3), 0.3), ((0.2, 0.0, 1.0), 0.2), ((0.8, 0.0, -1.1), 0.4)):
        assert [detector.at(np.array(place), margin)[1] for margin in (gap - 1e-9, gap + 1e-9)] == [0, 1]


def test_a_cylinder_on_a_body_that_deforms_stays_a_right_one() -> None:
    """It is carried by the material at its start, however far that is turned by modes."""
    rng = np.random.default_rng(5)
    phi, psi, modal = rng.normal(size=(2, 3)), rng.normal(size=(2, 3)), np.array([0.3, -0.4])
    tip = lf.SpatialPoint(np.array([0.2, 0.1, 0.0]), phi, psi)
    scene = lf.SpatialScene()
    soft = scene.add(
        lf.SpatialBody(mass=1.0, inertia=np.eye(3), stiffness=[1.0, 2.0], points={"tip": tip}),
        position=SHIFT,
        orientation=TURN,
        modal=modal,
    )
    ball = scene.add(lf.Sphere(0.2, mass=1.0))
    scene.contact(ball.surface(), soft.cylinder("tip", (0.0, 0.0, 2.0), RADIUS, LENGTH))
    compiled = scene.compile(indents=lambda name: True)
    model, q = pack(compiled.model), compiled.q.copy()
    turned = TURN * Rotation.from_rotvec(psi.T @ modal)
    start = np.array([0.0, 0.0, -0.5 * LENGTH])
    low = tip.place + start + (phi + np.cross(psi, start)).T @ modal
    middle = SHIFT + TURN.apply(low) - turned.apply(start)
    kinds = set()
    for place in places(6, 300):
        q[-7:-4] = middle + turned.apply(place)
        table, n = near(model, q, FAR)
        assert n == 1
        kinds.add(int(table.kind[0]))
        assert abs(table.gap[0] + 0.2 - distance(place)) < 1e-14
    assert kinds == {NODE_SIDE, NODE_CAP, NODE_RIM}


def test_a_rule_finds_by_cells_what_contacts_that_are_listed_find() -> None:
    scene, rng = lf.SpatialScene(), np.random.default_rng(7)
    bodies = (lf.Sphere(0.1, mass=1.0), lf.Cylinder(0.1, 0.2, mass=1.0))
    for k in range(40):
        place = 0.3 * np.array(np.unravel_index(k, (4, 4, 3)))
        scene.add(bodies[k % 2], position=place, orientation=Rotation.random(rng=rng))
    scene.ground.cylinder((0.5, 0.5, 0.9), (1.0, 0.0, 0.0), 0.1, 2.0)
    scene.contact_all()
    by_cells, listed = scene.compiled(), scene.compiled(indents=lambda name: True)  # cylinders pass each other
    assert len(by_cells.layout.contacts) == 0
    assert len(listed.layout.contacts) == 40 * 39 // 2 + 40
    found = []
    for compiled in (by_cells, listed):
        table, n = near(pack(compiled.model), compiled.q.copy(), 0.2)
        found.append({(*table.body[k].tolist(), int(table.kind[k]), round(float(table.gap[k]), 12)) for k in range(n)})
    assert len(found[0]) > 60
    assert {NODE_SIDE, NODE_CAP, NODE_RIM} < {kind for _, _, kind, _ in found[0]}
    assert found[0] == found[1]
