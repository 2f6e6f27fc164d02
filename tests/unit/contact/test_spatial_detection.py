"""What touches in space, and by what gap: against closed forms."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import lcpflex as lf
from lcpflex.bodies.spatial.shapes import SurfaceShape
from lcpflex.contact.near import near
from lcpflex.contact.spatial.table import NODE_FACET, NODE_POINT
from lcpflex.jit.struct import pack

PLACE, TURN = np.array([0.3, -0.2, 0.5]), Rotation.from_rotvec([0.4, 0.7, -0.2])


def found(scene: lf.SpatialScene, margin: float = 10.0) -> tuple[Any, int]:
    compiled = scene.compile(indents=lambda name: True)
    return near(pack(compiled.model), compiled.q.copy(), margin)


def test_corners_of_a_box_have_their_heights_above_a_plane_as_gaps() -> None:
    scene = lf.SpatialScene()
    box = scene.add(lf.Cuboid(0.1, 0.2, 0.3, mass=1.0), position=PLACE, orientation=TURN)
    normal = np.array([0.1, -0.3, 0.9]) / np.linalg.norm([0.1, -0.3, 0.9])
    scene.contact(box.surface(), scene.ground.plane((0.0, 0.0, 0.1), normal))
    table, n = found(scene)
    corners = np.array([[x, y, z] for x in (-0.05, 0.05) for y in (-0.1, 0.1) for z in (-0.15, 0.15)])
    heights = (PLACE + TURN.apply(corners) - [0.0, 0.0, 0.1]) @ normal
    assert n == 8
    assert set(table.kind[:n]) == {NODE_FACET}
    assert len(set(table.key[:n])) == 8
    np.testing.assert_allclose(np.sort(table.gap[:n]), np.sort(heights), atol=1e-15)


def test_of_contacts_those_within_the_margin_are_found() -> None:
    scene = lf.SpatialScene()
    box = scene.add(lf.Cuboid(0.1, 0.2, 0.3, mass=1.0), position=(0.0, 0.0, 0.15))
    scene.contact(box.surface(), scene.ground.plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0)))
    assert [found(scene, margin)[1] for margin in (-1e-9, 1e-9, 0.299, 0.301)] == [0, 4, 4, 8]


def test_spheres_touch_spheres_and_holes_about_points_of_turned_bodies() -> None:
    scene = lf.SpatialScene()
    ball = scene.add(lf.Sphere(0.1, mass=1.0), position=PLACE, orientation=TURN)
    other = scene.add(lf.Sphere(0.2, mass=1.0), position=-PLACE, orientation=TURN.inv())
    knob, cave = ball.sphere((0.0, 0.3, 0.0), 0.05), other.hole((0.0, 0.0, 0.4), 3.0)
    scene.contact(ball.surface(), other.surface())
    scene.contact(knob, cave)
    scene.contact(other.sphere((0.0, 0.3, 0.0), 0.05), ball.node((0.1, 0.0, 0.0)))
    table, n = found(scene)
    center, hollow = PLACE + TURN.apply([0.0, 0.3, 0.0]), -PLACE + TURN.inv().apply([0.0, 0.0, 0.4])
    tip, nub = PLACE + TURN.apply([0.1, 0.0, 0.0]), -PLACE + TURN.inv().apply([0.0, 0.3, 0.0])
    expected = [
        2.0 * np.linalg.norm(PLACE) - 0.3,
        3.0 - 0.05 - np.linalg.norm(center - hollow),
        np.linalg.norm(tip - nub) - 0.05,
    ]
    assert n == 3
    assert set(table.kind[:n]) == {NODE_POINT}
    np.testing.assert_allclose(table.gap[:n], expected, atol=1e-15)
    np.testing.assert_array_equal(table.sense[:n], [1.0, -1.0, 1.0])
    np.testing.assert_array_equal(table.law[:n], [0, 1, 2])


def test_a_capsule_touches_planes_and_holes_by_its_ends() -> None:
    scene = lf.SpatialScene()
    rod = scene.add(lf.Capsule(0.1, 0.6, mass=1.0), position=PLACE, orientation=TURN)
    scene.contact(rod.surface(), scene.ground.plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0)))
    scene.contact(rod.surface(), scene.ground.hole((0.0, 0.0, 0.0), 2.0))
    table, n = found(scene)
    ends = PLACE + TURN.apply([[0.0, 0.0, -0.3], [0.0, 0.0, 0.3]])
    expected = [*(ends[:, 2] - 0.1), *(2.0 - 0.1 - np.linalg.norm(ends, axis=1))]
    np.testing.assert_allclose(table.gap[:n], expected, atol=1e-15)


def test_a_plane_moves_with_its_body() -> None:
    scene = lf.SpatialScene()
    tray = scene.add(lf.Cuboid(1.0, 1.0, 0.1, mass=1.0), position=PLACE, orientation=TURN)
    ball = scene.add(lf.Sphere(0.1, mass=1.0), position=(0.0, 0.0, 1.0))
    scene.contact(tray.plane("top", (0.0, 0.0, 1.0)), ball.surface())
    table, n = found(scene)
    up = TURN.apply([0.0, 0.0, 1.0])
    assert n == 1
    assert abs(table.gap[0] - ((np.array([0.0, 0.0, 1.0]) - PLACE) @ up - 0.05 - 0.1)) < 1e-15


@pytest.mark.parametrize("depth", [0.0, 1e-9, 1e-7, 1e-5, 1e-3])
@pytest.mark.parametrize(("place", "size"), [((0.0, 0.08), (0.04, 0.08)), ((0.0, 0.03), (0.03, 0.03))])
def test_faces_that_are_pressed_into_each_other_touch_across_them_alone(
    depth: float, place: tuple[float, float], size: tuple[float, float]
) -> None:
    scene = lf.SpatialScene()
    box = scene.add(lf.Cuboid(0.06, 0.06, 0.06, mass=0.5), position=(0.0, 0.0, 0.03))
    finger = scene.add(lf.Cuboid(0.02, *size, mass=0.1), position=(-0.04, *place))
    scene.contact(finger.surface(), box.surface())
    compiled = scene.compile()
    q = compiled.q.copy()
    q[7] += depth
    told = compiled.at(q, compiled.u)
    np.testing.assert_allclose(told.gaps, np.full(4, -depth), atol=1e-15)
    np.testing.assert_allclose(told.normals, np.tile([-1.0, 0.0, 0.0], (4, 1)), atol=1e-12)


def paved(nx: int, ny: int) -> SurfaceShape:
    """A slab of 2 x 1 x .2 m whose top, at z = 0, and bottom are cut into nx times ny pairs of triangles."""
    x, y = np.linspace(-1.0, 1.0, nx + 1), np.linspace(-0.5, 0.5, ny + 1)
    top = np.array([(a, b, 0.0) for a in x for b in y])
    n = len(top)
    cells = [(i * (ny + 1) + j, (i + 1) * (ny + 1) + j) for i in range(nx) for j in range(ny)]
    upper = [t for a, b in cells for t in ((a, b, b + 1), (a, b + 1, a + 1))]
    ring = [i * (ny + 1) for i in range(nx)] + [nx * (ny + 1) + j for j in range(ny)]
    ring += [i * (ny + 1) + ny for i in range(nx, 0, -1)] + list(range(ny, 0, -1))
    around = zip(ring, (*ring[1:], ring[0]), strict=True)
    sides = [t for a, b in around for t in ((a + n, b + n, b), (a + n, b, a))]
    triangles = np.array([*upper, *((c + n, b + n, a + n) for a, b, c in upper), *sides])
    return SurfaceShape(np.vstack([top, top - [0.0, 0.0, 0.2]]), triangles, np.zeros((2 * n, 0, 3)))


def on_pavement(place: tuple[float, float, float], **motion: tuple[float, float, float]) -> lf.SpatialScene:
    """A box without friction on a floor of many triangles."""
    scene = lf.SpatialScene()
    slab = scene.add(lf.SpatialBody(mass=1e3, inertia=100.0 * np.eye(3), shape=paved(20, 9)))
    scene.join(lf.Weld(slab.at(0.0, 0.0, 0.0), scene.ground.at(0.0, 0.0, 0.0)))
    box = scene.add(lf.Cuboid(0.2, 0.15, 0.1, mass=1.0), "box", place, Rotation.from_rotvec([0, 0, 0.3]), **motion)
    scene.contact(box.surface(), slab.surface())
    return scene


def test_what_stands_on_a_face_of_many_triangles_touches_no_vertex_within_that_face() -> None:
    """Those beside the box are level with its bottom, in front of its sides: they would catch it where it slides."""
    table, n = found(on_pavement((-0.3, 0.02, 0.05)), 0.05)
    assert n >= 4
    np.testing.assert_allclose(np.abs(table.normal[:n, 2]), 1.0, atol=1e-12)


@pytest.mark.parametrize("y", [0.02, -0.07, 0.055])
def test_a_box_slides_over_a_face_of_many_triangles_as_over_a_plane(y: float) -> None:
    scene = on_pavement((-0.7, y, 0.05), velocity=(1.0, 0.21, 0.0), angular_velocity=(0.0, 0.0, 2.0))
    result = lf.simulate(scene, 0.8, lf.EventDriven(), progress=False)
    np.testing.assert_allclose(result.velocity("box", (0.0, 0.0, 0.0))[-1], [1.0, 0.21, 0.0], atol=1e-9)
    np.testing.assert_allclose(result.angular_velocity("box")[-1], [0.0, 0.0, 2.0], atol=1e-9)
