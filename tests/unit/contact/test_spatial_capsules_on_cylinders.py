"""Capsules by cylinders: their least gap is the distance, and their number what holds the bodies."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import lcpflex as lf
from lcpflex.contact.near import near
from lcpflex.contact.spatial.narrow_phase.rim_line import nearest_on_rim, towards
from lcpflex.contact.spatial.pairs import contact_bias, contact_rows, foot_margin, node_margin, refresh
from lcpflex.contact.spatial.table import EDGE_RIM, EDGE_SIDE, NODE_CAP, NODE_RIM, NODE_SIDE
from lcpflex.jit.struct import pack
from tests.unit.contact.test_spatial_cylinders import distance

Array = Any
SIZES = [(0.5, 1.4, 0.1, 1.5), (0.5, 0.05, 0.05, 3.0), (0.02, 2.0, 0.1, 0.3), (0.6, 0.8, 0.2, 0.01)]  # R, L, rho, H
ALONG_X, ALONG_Y = Rotation.from_euler("y", 90, degrees=True), Rotation.from_euler("x", 90, degrees=True)


def least_distance(a: Array, b: Array, radius: float, length: float) -> float:
    """From a line between two points to a cylinder about z around 0: convex along the line."""
    low, high = 0.0, 1.0
    for _ in range(90):  # thirds, to rounding
        s, t = low + (high - low) / 3.0, high - (high - low) / 3.0
        if distance(a + s * (b - a), radius, length) < distance(a + t * (b - a), radius, length):
            high = t
        else:
            low = s
    return distance(a + 0.5 * (low + high) * (b - a), radius, length)


class Pair:
    """A capsule somewhere by a cylinder about z around 0; which is declared first does not matter."""

    def __init__(self, sizes: tuple[float, float, float, float] = SIZES[0], first: bool = True) -> None:
        radius, length, rho, height = sizes
        scene = lf.SpatialScene()
        log = scene.add(lf.Cylinder(radius, length, mass=1.0)).surface()
        rod = scene.add(lf.Capsule(rho, height, mass=1.0)).surface()
        scene.contact(*((log, rod) if first else (rod, log)))
        compiled = scene.compile(indents=lambda name: True)
        self.model, self.q, self.sizes = pack(compiled.model), compiled.q.copy(), sizes

    def at(self, shift: Array, turn: Rotation, margin: float = 100.0) -> tuple[Any, int]:
        self.q[7:10] = shift
        self.q[10:14] = np.roll(turn.as_quat(), 1)
        return near(self.model, self.q, margin)

    def distance(self, shift: Array, turn: Rotation) -> float:
        """Of the axis of the capsule from the cylinder."""
        radius, length, _, height = self.sizes
        a, b = turn.apply([[0.0, 0.0, -0.5 * height], [0.0, 0.0, 0.5 * height]]) + shift
        return least_distance(a, b, radius, length)


@pytest.mark.parametrize("sizes", SIZES)
def test_the_least_gap_is_the_distance(sizes: tuple[float, float, float, float]) -> None:
    pair, rng, kinds = Pair(sizes), np.random.default_rng(1), set()
    for turn in Rotation.random(500, rng=rng):
        shift = rng.uniform(-1.0, 1.0, 3) * (0.6 * max(sizes) + 0.5)
        expected = pair.distance(shift, turn)
        if expected < 1e-6:
            continue
        table, n = pair.at(shift, turn)
        least = int(np.argmin(table.gap[:n]))
        kinds.add(int(table.kind[least]))
        assert abs(table.gap[least] + sizes[2] - expected) < 1e-12
        assert len(set(table.key[:n])) == n
    assert len(kinds) >= 4


def test_the_gap_changes_by_no_more_than_the_way() -> None:
    pair, rng = Pair(), np.random.default_rng(2)
    for turn in Rotation.random(6, rng=rng):
        start, end = rng.uniform(-1.0, 1.0, (2, 3)) * 0.4 + [1.0, 0.0, 0.9]
        path, gaps = start + np.linspace(0.0, 1.0, 600)[:, None] * (end - start), []
        for place in path:
            table, n = pair.at(place, turn)
            gaps.append(float(table.gap[:n].min()))
        steps = np.linalg.norm(np.diff(path, axis=0), axis=1)
        outside = np.minimum(gaps[1:], gaps[:-1]) > -pair.sizes[2]
        assert (np.abs(np.diff(gaps)) <= steps * (1.0 + 1e-9) + 1e-15)[outside].all()


@pytest.mark.parametrize("tilt", [0.0, 1e-12, -1e-12, 1e-7])
@pytest.mark.parametrize(
    ("place", "turn", "expected"),
    [
        ((0.1, 0.2, 0.8), ALONG_X, [EDGE_RIM, EDGE_RIM]),  # across an end
        ((0.0, 0.0, 0.8), ALONG_X, [EDGE_RIM, EDGE_RIM]),  # over its middle
        ((0.6, 0.0, 0.8), ALONG_X, [EDGE_RIM, NODE_CAP]),  # beyond one side of it
        ((0.6, 0.0, 0.0), Rotation.identity(), [EDGE_RIM, EDGE_RIM]),  # along the side, and longer
        ((0.0, 0.6, 0.3), Rotation.identity(), [EDGE_RIM, NODE_SIDE]),  # beyond an end of it
        ((0.6, 0.0, 0.1), ALONG_Y, [EDGE_SIDE]),  # across the side
        ((0.0, 0.0, 1.55), Rotation.identity(), [NODE_CAP]),  # standing on the middle of an end
    ],
)
def test_a_capsule_that_lies_is_held_at_both_ends_of_a_line(
    place: Any, turn: Rotation, expected: list[int], tilt: float
) -> None:
    pair = Pair(first=tilt >= 0.0)
    table, n = pair.at(np.array(place), Rotation.from_euler("y", tilt) * turn, 1e-6)
    assert sorted(table.kind[:n]) == sorted(expected)
    np.testing.assert_allclose(table.gap[:n], 0.0, atol=1e-6 if tilt == 1e-7 else 2e-12)
    rows, u = np.zeros((3, 2, 6)), np.arange(1.0, 13.0)
    for k in range(n):
        contact_rows(pair.model, pair.q, table, k, rows[0], rows[1:])
        assert np.isfinite(rows).all()
        assert np.isfinite(contact_bias(pair.model, pair.q, u, table, k)).all()


@pytest.mark.parametrize("turn", [Rotation.identity(), ALONG_X, ALONG_Y])
def test_axes_that_meet_or_coincide_have_numbers(turn: Rotation) -> None:
    pair = Pair()
    for place in ((0.0, 0.0, 0.0), (0.0, 0.0, 0.7), (0.5, 0.0, 0.7), (0.5, 0.0, 0.0), (0.0, 0.0, 1.0)):
        table, n = pair.at(np.array(place), turn)
        assert n > 0
        assert np.isfinite(table.gap[:n]).all()
        rows, u = np.zeros((3, 2, 6)), np.arange(1.0, 13.0)
        for k in range(n):
            contact_rows(pair.model, pair.q, table, k, rows[0], rows[1:])
            assert np.isfinite(rows).all()
            assert np.isfinite(contact_bias(pair.model, pair.q, u, table, k)).all()


def test_margins_are_positive_where_detection_finds_the_pair() -> None:
    pair, rng, seen = Pair(), np.random.default_rng(3), []
    for turn in Rotation.random(40, rng=rng):
        table, n = pair.at(rng.uniform(-0.9, 0.9, 3) * [1.0, 1.0, 1.4], turn)
        seen.append((pair.q.copy(), table, {int(table.key[k]): float(table.sense[k]) for k in range(n)}))
    told: dict[bool, set[int]] = {True: set(), False: set()}
    for _, table, keys in seen:
        for q, _, found in seen:
            for k in range(len(keys)):
                refresh(pair.model, q, table, k)
                margin = min(foot_margin(pair.model, q, table, k), node_margin(pair.model, q, table, k))
                if table.gap[k] > -0.1 and abs(margin) > 1e-6:
                    present = found.get(int(table.key[k])) == table.sense[k]
                    assert present == (margin > 0.0)
                    told[present].add(int(table.kind[k]))
    assert told[True] == told[False] == {NODE_SIDE, NODE_CAP, NODE_RIM, EDGE_SIDE, EDGE_RIM}


@pytest.mark.parametrize("seed", range(4))
def test_nearest_places_of_a_circle_and_a_line_are_all_minima(seed: int) -> None:
    rng = np.random.default_rng(seed)
    angles = np.linspace(0.0, 2.0 * np.pi, 20001)[:-1]
    numbers = set()
    for _ in range(100):
        a, e = rng.normal(size=(2, 3))
        a /= np.linalg.norm(a)
        d = rng.normal(size=3) * 0.4
        found = nearest_on_rim(tuple(a), 0.7, tuple(e), tuple(d))
        f = e / np.linalg.norm(e)
        circle = d + 0.7 * (np.outer(np.cos(angles), found.u) + np.outer(np.sin(angles), found.v))
        apart = np.linalg.norm(circle - np.outer(circle @ f, f), axis=1)
        minima = np.flatnonzero((apart < np.roll(apart, 1)) & (apart <= np.roll(apart, -1)))
        places = [found.first, found.second] if found.two else [found.first]
        numbers.add(len(places))
        assert len(minima) == len(places)
        told = sorted(
            float(np.linalg.norm(to - (to @ f) * f))
            for place in places
            for to in [d + 0.7 * np.array(towards(found, place))]
        )
        np.testing.assert_allclose(told, np.sort(apart[minima]), atol=1e-5)
        assert (np.array(told) <= np.sort(apart[minima]) + 1e-14).all()
    assert numbers == {1, 2}


def test_a_rule_finds_what_a_declared_contact_finds() -> None:
    found = []
    for ruled in (False, True):
        scene, rng = lf.SpatialScene(), np.random.default_rng(4)
        for k in range(40):
            place = 0.3 * np.array(np.unravel_index(k, (4, 4, 3)))
            body = lf.Capsule(0.03, 0.2, mass=1.0) if k % 2 else lf.Cylinder(0.1, 0.2, mass=1.0)
            scene.add(body, position=place, orientation=Rotation.random(rng=rng))
        scene.contact_all()
        compiled = scene.compiled() if ruled else scene.compiled(indents=lambda name: True)  # cylinders pass each other
        assert (len(compiled.layout.contacts) == 0) == ruled
        table, n = near(pack(compiled.model), compiled.q.copy(), 0.2)
        found.append({(*table.body[k].tolist(), int(table.kind[k]), round(float(table.gap[k]), 12)) for k in range(n)})
    assert found[0] == found[1]
    assert {EDGE_SIDE, EDGE_RIM, NODE_SIDE} < {kind for _, _, kind, _ in found[0]}


def test_both_passes_are_made_whichever_side_is_chosen() -> None:
    scene = lf.SpatialScene()
    log = scene.ground.cylinder((0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 0.5, 1.4)
    rod = scene.add(lf.Capsule(0.1, 1.5, mass=1.0), position=(0.6, 0.0, 0.0), orientation=ALONG_Y).surface()
    scene.contact(log, rod, node_side=rod)
    compiled = scene.compile()
    table, n = near(pack(compiled.model), compiled.q.copy(), 1e-6)
    assert list(table.kind[:n]) == [EDGE_SIDE]


def test_on_bodies_that_deform_the_least_gap_is_the_distance_to_a_right_cylinder() -> None:
    """Carried by the material at its start, however far that is turned by modes; the capsule's ends are two others."""
    pair, rng = Pair(), np.random.default_rng(5)
    phi, psi, modal = rng.normal(size=(3, 2, 3)), rng.normal(size=(2, 3)), np.array([0.3, -0.4])
    places = {"tip": np.array([0.2, 0.1, 0.0]), "a": np.array([1.0, 0.0, 0.0]), "b": np.array([0.3, 1.0, 0.2])}
    nodes = {
        name: lf.SpatialPoint(place, shapes, psi if name == "tip" else np.zeros((2, 3)))
        for (name, place), shapes in zip(places.items(), phi, strict=True)
    }
    soft = {"mass": 1.0, "inertia": np.eye(3), "stiffness": [1.0, 2.0], "points": nodes}
    scene = lf.SpatialScene()
    first, second = (scene.add(lf.SpatialBody(**soft), modal=modal) for _ in range(2))
    radius, length, rho, _ = pair.sizes
    scene.contact(second.capsule("a", "b", rho), first.cylinder("tip", (0.0, 0.0, 2.0), radius, length))
    compiled = scene.compile(indents=lambda name: True)
    model, q = pack(compiled.model), compiled.q.copy()
    turned, start = Rotation.from_rotvec(psi.T @ modal), np.array([0.0, 0.0, -0.5 * length])
    middle = places["tip"] + start + (phi[0] + np.cross(psi, start)).T @ modal - turned.apply(start)
    ends = np.array([places[name] + phi[k].T @ modal for k, name in ((1, "a"), (2, "b"))])
    kinds = set()
    for _ in range(300):
        q[9:12] = rng.uniform(-1.5, 1.5, 3)
        q[12:16] = np.roll(Rotation.random(rng=rng).as_quat(), 1)
        a, b = turned.inv().apply(Rotation.from_quat(np.roll(q[12:16], -1)).apply(ends) + q[9:12] - middle)
        expected = least_distance(a, b, radius, length)
        if expected > 1e-3:
            table, n = near(model, q, 100.0)
            kinds.add(int(table.kind[np.argmin(table.gap[:n])]))
            assert abs(expected - rho - table.gap[:n].min()) < 1e-12
    assert len(kinds) >= 4
