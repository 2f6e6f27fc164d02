"""Contacts of spatial scenes as they are declared and compiled."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import lcpflex as lf
from lcpflex.bodies.spatial.shapes import SurfaceShape
from lcpflex.contact.near import near
from lcpflex.jit.struct import pack

UP = (0.0, 0.0, 1.0)


def two_balls() -> tuple[lf.SpatialScene, Any, Any]:
    scene = lf.SpatialScene()
    low = scene.add(lf.Sphere(0.1, mass=1.0), "low", position=(0.0, 0.0, 0.1))
    high = scene.add(lf.Sphere(0.2, mass=2.0), "high", position=(0.0, 0.0, 0.4))
    return scene, low, high


def test_what_is_declared_is_compiled_by_its_names_and_laws() -> None:
    scene, low, high = two_balls()
    floor = scene.ground.plane((0.0, 0.0, 0.0), (0.0, 0.0, 2.0))
    assert scene.contact(low.surface(), floor, friction=0.3, restitution=0.5, name="floor") == "floor"
    assert scene.contact(high.surface(), low.surface(), tangential_restitution=0.25) == "contact2"
    compiled = scene.compile()
    contacts = compiled.model.contacts
    assert compiled.layout.contacts == ("floor", "contact2")
    np.testing.assert_array_equal(contacts.friction, [0.3, 0.0])
    np.testing.assert_array_equal(contacts.restitution, [0.5, 0.0])
    np.testing.assert_array_equal(contacts.tangential_restitution, [0.0, 0.25])
    points = compiled.model.points.place[contacts.feature_point[contacts.feature_start[0]]]
    np.testing.assert_allclose(np.cross(points[1] - points[0], points[2] - points[0]), [0.0, 0.0, 1.0], atol=1e-15)


def log(body: Any) -> Any:
    return body.cylinder((0.0, 0.0, 0.0), UP, 0.1, 0.3)


def mesh_of(scene: lf.SpatialScene) -> Any:
    corners = np.vstack([np.zeros(3), np.eye(3)])
    shape = SurfaceShape(corners, np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]), np.zeros((4, 0, 3)))
    return scene.add(lf.SpatialBody(mass=1.0, inertia=np.eye(3), shape=shape)).surface()


@pytest.mark.parametrize(
    ("declare", "text"),
    [
        (lambda s, a, b: s.contact(a, b.surface()), "a: .*expected a surface"),
        (lambda s, a, b: s.contact(a.surface(), a.sphere("center", 0.1)), "both on the same body"),
        (lambda s, a, b: s.contact(a.surface(), a.surface()), "given twice"),
        (lambda s, a, b: s.contact(a.surface(), b.surface(), friction=-0.1), "friction: -0.1"),
        (lambda s, a, b: s.contact(a.surface(), b.surface(), restitution=1.5), "restitution: 1.5"),
        (lambda s, a, b: s.contact(a.plane((0, 0, 0), UP), s.ground.plane((0, 0, 0), UP)), "a plane with"),
        (lambda s, a, b: s.contact(a.node((0, 0, 0)), b.node((0, 0, 0))), "cannot touch each other, expected a node"),
        (lambda s, a, b: s.contact(a.surface(), two_balls()[1].surface()), "b: .*not of another one"),
        (lambda s, a, b: s.contact(a.surface(), lf.Scene().ground.half_plane((0, 0), (0, 1))), "b: .*another"),
        (lambda s, a, b: s.ground.plane((0, 0, 0), (0, 0, 0)), "normal: .*not all 0"),
        (lambda s, a, b: s.ground.plane((0, 0), (0, 0, 1)), "point"),
        (lambda s, a, b: s.ground.plane((0, 0, 0), (0, float("nan"), 1)), "normal"),
        (lambda s, a, b: a.sphere("center", 0.0), "radius"),
        (lambda s, a, b: a.sphere("centre", 1.0), "center: .*no point"),
        (lambda s, a, b: a.rim("center", (0, 0, 0), 1.0), "axis: .*not all 0"),
        (lambda s, a, b: a.rim("center", UP, -1.0), "radius: -1"),
        (lambda s, a, b: a.rim(b.point("center"), UP, 1.0), "center: .*expected a point of 'low'"),
        (lambda s, a, b: s.contact(a.rim("center", UP, 1.0), b.surface()), "rim with one of: plane"),
        (lambda s, a, b: s.contact(a.rim("center", UP, 1.0), b.rim("center", UP, 1.0)), "rim with one of: plane"),
        (lambda s, a, b: s.contact(a.rim("center", UP, 1.0), log(b)), "rim.*cylinder.*with one of: plane$"),
        (
            lambda s, a, b: s.contact(log(a), mesh_of(s)),
            "a cylinder with one of: node, sphere, capsule, cylinder, face, convex polyhedron, plane; .*ConvexHull",
        ),
        (lambda s, a, b: s.contact(log(a), b.hole(UP, 1.0)), "a cylinder.*a hole.*which cannot touch each other"),
        (lambda s, a, b: s.contact(log(a), b.surface(), node_side=log(a)), "node_side"),
        (lambda s, a, b: a.cylinder((0, 0, 0), (0, 0, 0), 1.0, 1.0), "axis: .*not all 0"),
        (lambda s, a, b: a.cylinder((0, 0, 0), UP, 0.0, 1.0), "radius: 0"),
        (lambda s, a, b: a.cylinder((0, 0, 0), UP, 1.0, -1.0), "length: -1"),
        (lambda s, a, b: a.cylinder((0, 0, float("nan")), UP, 1.0, 1.0), "center"),
        (lambda s, a, b: a.capsule((0, 0, 0), (0, 0, 0), 1.0), "second: .*another place than that of first"),
        (lambda s, a, b: a.capsule((0, 0, 0), (0, 0, 1), 0.0), "radius: 0"),
        (lambda s, a, b: a.node(b.point("center")), "expected a point of 'low'"),
        (lambda s, a, b: s.ground.surface(), "the ground"),
        (lambda s, a, b: s.contact(a.surface(), b.hole(UP, 1.0), node_side=b.surface()), "node_side: .*one of the two"),
    ],
)
def test_what_cannot_be_is_refused(declare: Callable[[lf.SpatialScene, Any, Any], object], text: str) -> None:
    scene, low, high = two_balls()
    with pytest.raises(lf.ModelError, match=text):
        declare(scene, low, high)


def test_a_pair_is_declared_once_and_nodes_are_on_the_side_that_has_them() -> None:
    scene, low, _ = two_balls()
    hole = scene.ground.hole((0.0, 0.0, 0.0), 1.0)
    with pytest.raises(lf.ModelError, match="as it has no nodes"):
        scene.contact(low.surface(), hole, node_side=hole)
    scene.contact(low.surface(), hole)
    with pytest.raises(lf.ModelError, match="given twice, 'contact1'"):
        scene.contact(hole, low.surface())


def test_a_start_with_a_penetration_is_refused_by_the_name_of_the_contact() -> None:
    scene, low, _ = two_balls()
    scene.contact(low.surface(), scene.ground.plane((0.0, 0.0, 0.01), (0.0, 0.0, 1.0)), name="floor")
    with pytest.raises(lf.ModelError, match=r"'floor': its surfaces penetrate by 0\.01 m"):
        scene.compile()
    scene.compile(indents=lambda name: name == "floor")


def heap(number: int, seed: int = 0) -> lf.SpatialScene:
    """Balls, boxes and capsules in a box that is open above."""
    scene, rng = lf.SpatialScene(), np.random.default_rng(seed)
    bodies = (lf.Sphere(0.1, mass=1.0), lf.Cuboid(0.2, 0.1, 0.15, mass=1.0), lf.Capsule(0.05, 0.1, mass=1.0))
    for k in range(number):
        place = 0.3 * np.array(np.unravel_index(k, (4, 4, 1 + number // 16)))
        scene.add(bodies[k % 3], position=place, orientation=Rotation.random(rng=rng))
    scene.ground.plane((0.0, 0.0, -0.2), UP)
    scene.contact_all(friction=0.3)
    return scene


def gaps_of(compiled: Any) -> set[Any]:
    table, n = near(pack(compiled.model), compiled.q.copy(), 0.2)
    return {(*table.body[k].tolist(), int(table.kind[k]), round(float(table.gap[k]), 12)) for k in range(n)}


def test_a_rule_finds_by_cells_what_contacts_that_are_listed_find() -> None:
    scene = heap(40)
    by_cells, listed = scene.compile(), scene.compile(indents=lambda name: True)
    assert len(by_cells.layout.contacts) == 0
    assert len(listed.layout.contacts) == 40 * 39 // 2 + 40
    assert listed.layout.contacts[0] == "body1.surface/body2.surface"
    assert len(by_cells.layout.rule_surfaces) == 41
    found = gaps_of(by_cells)
    assert len(found) > 60
    assert found == gaps_of(listed)


def test_few_surfaces_are_listed_and_pairs_that_are_excluded_or_jointed_are_not() -> None:
    scene, low, high = two_balls()
    floor = scene.ground.plane((0.0, 0.0, 0.0), UP)
    third = scene.add(lf.Sphere(0.1, mass=1.0), "third", position=(1.0, 0.0, 0.5))
    scene.join(lf.Ball(third.at(0.0, 0.0, 0.0), high.at(1.0, 0.0, 0.1)))
    scene.contact_all(restitution=0.5, exclude=[(low, floor)])
    scene.contact(low.surface(), third.surface(), name="own")
    assert scene.compile().layout.contacts == (
        "own",
        "low.surface/high.surface",
        "high.surface/ground.plane1",
        "third.surface/ground.plane1",
    )


def test_a_penetration_under_a_rule_is_told_by_the_names_of_its_surfaces() -> None:
    scene = heap(40)
    scene.add(lf.Cuboid(0.2, 0.1, 0.15, mass=1.0), "sunk", position=(3.0, 0.0, -0.15))
    with pytest.raises(lf.ModelError, match=r"'ground.plane1/sunk.surface'|'sunk.surface/ground.plane1'"):
        scene.compile()


def test_a_rim_has_the_gap_of_its_lowest_point() -> None:
    """Of a circle of radius R about a tilted axis a over z = 0: o_z - R sqrt(1 - a_z^2)."""
    for axis in ([0.0, 0.0, 2.0], [1.0, 2.0, -0.5], [1e200, 0.0, 0.0]):
        scene = lf.SpatialScene()
        body = scene.add(
            lf.Sphere(0.1, mass=1.0), position=(0.3, -0.2, 0.5), orientation=Rotation.from_rotvec([1, 2, 3])
        )
        scene.contact(body.rim((0.0, 0.0, 0.1), axis, 0.2), scene.ground.plane((0.0, 0.0, 0.0), UP))
        compiled = scene.compile()
        table, n = near(pack(compiled.model), compiled.q.copy(), 10.0)
        turned = Rotation.from_rotvec([1, 2, 3])
        height = 0.5 + 0.1 * turned.apply([0.0, 0.0, 1.0])[2]
        a = turned.apply(np.array(axis) / np.abs(axis).max())[2] / np.linalg.norm(np.array(axis) / np.abs(axis).max())
        assert n == 1
        assert table.gap[0] == pytest.approx(height - 0.2 * np.sqrt(1.0 - a * a), abs=1e-15)


def test_a_capsule_on_a_body_touches_as_a_body_that_is_one() -> None:
    turned = Rotation.from_rotvec([0.3, -0.5, 0.2])
    scene = lf.SpatialScene()
    own = scene.add(lf.Capsule(0.1, 0.4, mass=1.0), position=(0.0, 0.0, 1.0), orientation=turned)
    made = scene.add(lf.SpatialBody(mass=1.0, inertia=np.eye(3)), position=(0.0, 0.0, 1.0), orientation=turned)
    ball = scene.add(lf.Sphere(0.1, mass=1.0), position=(0.5, 0.1, 1.1))
    floor = scene.ground.plane((0.0, 0.0, 0.0), UP)
    rod = made.capsule((0.0, 0.0, -0.2), (0.0, 0.0, 0.2), 0.1)
    for surface in (own.surface(), rod):
        scene.contact(surface, floor)
        scene.contact(surface, ball.surface())
    compiled = scene.compile()
    table, n = near(pack(compiled.model), compiled.q.copy(), 10.0)
    gaps = {law: sorted(table.gap[:n][table.law[:n] == law]) for law in range(4)}
    assert len(gaps[0]) == 2
    assert len(gaps[1]) == 1
    np.testing.assert_allclose(gaps[0], gaps[2], rtol=0, atol=1e-15)
    np.testing.assert_allclose(gaps[1], gaps[3], rtol=0, atol=1e-15)
