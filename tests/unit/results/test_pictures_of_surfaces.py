"""What pictures of space show of the ground and of the surfaces of contacts."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import lcpflex as lf
from lcpflex.results.spatial.scenery import Scenery
from tests.unit.results.drawn import draw_patches_of, picture_of, sliding


def test_a_plane_of_the_ground_is_drawn_where_the_floor_is_not_it() -> None:
    assert len(draw_patches_of(sliding(0.4))) == 1
    assert len(draw_patches_of(sliding(0.0))) == 0
    corners = draw_patches_of(sliding(0.4))[0]
    np.testing.assert_allclose(corners @ [np.sin(0.4), 0.0, np.cos(0.4)], 0.0, atol=1e-15)


@pytest.mark.parametrize(
    ("height", "floor"),
    [(0.0, 0.0), (0.7, 0.7), (0.96, 0.896), (-0.2, 0.896)],  # touched, below, within the ball, too far for a picture
)
def test_the_floor_is_the_level_plane_below(height: float, floor: float) -> None:
    """Also beside an inclined plane, of which nothing below the floor is shown."""
    for tilted in (False, True):
        scene = lf.SpatialScene()
        scene.add(lf.Sphere(0.1, mass=1.0), position=(0.0, 0.0, 1.0))
        scene.ground.plane((0.0, 0.0, height), (0.0, 0.0, 1.0))
        if tilted:
            scene.ground.plane((0.0, 0.0, 0.85), (0.3, 0.0, 1.0))
        picture, _ = picture_of(scene)
        levels = [corners for corners in picture._patches if np.ptp(corners[:, 2]) < 1e-12]
        if floor == height:
            assert picture.floor.low[2] == height
            assert levels == []
            assert all((corners[:, 2] >= height - 1e-12).all() for corners in picture._patches)
        elif not tilted:
            assert picture.floor.low[2] <= min(0.896, 1.0 if height < 0.0 else height)
        assert len(picture._patches) - len(levels) == tilted


def solids_on(placed: Any) -> dict[str, tuple[Any, float]]:
    """One surface of each kind at x = 0, 1, ...; its half height."""
    turn = Rotation.from_rotvec([0.0, 0.0, 0.4])
    cube = np.array([[x, y, z] for x in (4.8, 5.2) for y in (-0.2, 0.2) for z in (-0.1, 0.1)])
    return {
        "sphere": (placed.sphere((0.0, 0.0, 0.0), 0.2), 0.2),
        "capsule": (placed.capsule((1.0, 0.0, -0.2), (1.0, 0.0, 0.2), 0.1), 0.3),
        "cylinder": (placed.cylinder((2.0, 0.0, 0.0), (0.0, 1.0, 0.0), 0.25, 0.2), 0.25),
        "rim": (placed.rim((3.0, 0.0, 0.0), (0.0, 1.0, 0.0), 0.15), 0.15),
        "box": (placed.box((4.0, 0.0, 0.0), (0.3, 0.3, 0.4), turn), 0.2),
        "hull": (placed.hull(cube), 0.1),
        "hole": (placed.hole((6.0, 0.0, 0.0), 0.3), 0.3),
    }


@pytest.mark.parametrize("grounded", [True, False])
def test_surfaces_are_drawn_where_they_are(grounded: bool) -> None:
    """On the ground and on a body that is turned; each as high as it is, and seen."""
    scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
    turned = Rotation.from_rotvec([0.2, -0.1, 0.3])
    body = lf.SpatialRigidBody(1.0, [0.1, 0.1, 0.1])
    one = scene.add(
        body, position=(3.0, 2.0, 0.0) if grounded else (1.0, 2.0, 3.0), orientation=None if grounded else turned
    )
    made = solids_on(scene.ground if grounded else one)
    picture, compiled = picture_of(scene)
    scenery = picture._scenery
    assert len(scenery.solids if grounded else scenery.parts) == len(made)
    for k, (_, half) in enumerate(made.values()):
        if grounded:
            places = scenery.solids[k].vertices
        else:
            places = turned.inv().apply(scenery.vertices(compiled.q, scenery.parts[k], 1.0) - [1.0, 2.0, 3.0])
        np.testing.assert_allclose(places.min(axis=0)[2], -half, atol=1e-12)
        np.testing.assert_allclose(places.max(axis=0)[2], half, atol=1e-12)
        np.testing.assert_allclose(0.5 * (places.min(axis=0) + places.max(axis=0)), [k, 0.0, 0.0], atol=1e-12)
    assert (scenery.drawn[0].facets is None) == (not grounded)  # an ellipsoid stands for a body without a surface


def test_the_shape_of_a_body_is_drawn_once() -> None:
    scene = lf.SpatialScene()
    bodies = (
        lf.Sphere(0.1, mass=1.0),
        lf.Capsule(0.1, 0.3, mass=1.0),
        lf.Cylinder(0.1, 0.3, mass=1.0),
        lf.Cuboid(0.1, 0.2, 0.3, mass=1.0),
        lf.ConvexHull([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], mass=1.0),
    )
    for k, body in enumerate(bodies):
        scene.add(body, position=(2.0 * k, 0.0, 2.0))
    scene.ground.plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    scene.contact_all(exclude=[(scene.body("body3"), scene.body(f"body{k}")) for k in (4, 5)])
    scenery = Scenery(scene.compiled())
    assert scenery.parts == []
    assert scenery.solids == []
    scene.body("body4").box((0.0, 0.0, 0.2), (0.1, 0.1, 0.1))
    (part,) = Scenery(scene.compiled()).parts
    assert part.body == 3


def test_a_surface_moves_with_the_material_that_carries_it() -> None:
    """Of a beam that bends: a ball and a capsule at its tip, and a cylinder that turns with it."""
    scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
    beam = lf.SpatialBeam(1.0, 4e-4, (1.3e-8, 1.3e-8), 2.2e-8, 7800.0, 2e9, poissons_ratio=0.3, elements=4).reduce(
        modes=2
    )
    eta = np.array([0.03, -0.02])
    body = scene.add(beam, "beam", position=(0.0, 0.0, 1.0), modal=eta)
    body.sphere("right", 0.05)
    body.capsule("center", "right", 0.02)
    body.cylinder("right", (1.0, 0.0, 0.0), 0.03, 0.2)
    picture, compiled = picture_of(scene)
    ball, rod, drum = (picture._scenery.vertices(compiled.q, part, 1.0) for part in picture._scenery.parts)
    tip, middle = beam.points["right"], beam.points["center"]
    at = np.array([0.0, 0.0, 1.0]) + tip.place + eta @ tip.phi
    np.testing.assert_allclose(np.linalg.norm(ball - at, axis=1), 0.05, atol=1e-12)
    ends = np.array([0.0, 0.0, 1.0]) + np.array([middle.place + eta @ middle.phi, tip.place + eta @ tip.phi])
    np.testing.assert_allclose(np.linalg.norm(rod[:, None] - ends, axis=2).min(axis=1), 0.02, atol=1e-12)
    turn = np.cross(eta @ tip.psi, [0.1, 0.0, 0.0])
    np.testing.assert_allclose(
        drum[[0, -1]], at + np.array([[-0.1], [0.1]]) * [1.0, 0.0, 0.0] + [-turn, turn], atol=1e-12
    )


def test_what_is_much_larger_is_cut() -> None:
    """A block of 100 m under one of 20 cm, cut to what is near it; a face in one plane has no lines across."""
    scene = lf.SpatialScene()
    scene.ground.box((0.0, 0.0, -50.0), (100.0, 100.0, 100.0), Rotation.from_euler("z", 0.3))
    scene.ground.box((40.0, 0.0, 1.0), (0.1, 0.1, 0.1))  # too far to be seen
    scene.add(lf.Cuboid(0.2, 0.1, 0.1, mass=1.0), position=(0.0, 0.0, 0.05))
    picture, compiled = picture_of(scene, (30.0, -60.0))
    (ground,) = picture._ground
    assert ground.facets is not None
    places = ground.facets.vertices
    np.testing.assert_allclose(places.min(axis=0), [-0.3, -0.25, 0.0], atol=1e-9)
    np.testing.assert_allclose(places.max(axis=0), [0.3, 0.25, 0.0], atol=1e-9)
    assert len(ground.facets.edges) == len(places)  # once around
    canvas, _ = picture.canvas(compiled.q, 100, 150)
    assert (canvas.owner == picture._ground_owner()).sum() > 3000
    assert (canvas.owner == 0).sum() > 1000
