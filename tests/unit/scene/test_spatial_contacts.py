"""Contacts of spatial scenes as they are declared and compiled."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import lcpflex as lf

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
        (lambda s, a, b: a.sphere("centre", 1.0), "no point"),
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
