"""Named faces that touch, of solids that are reduced when their scene is compiled: they give way as their mesh does."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.bodies.reduction.interface import NodeMean
from lcpflex.bodies.spatial.body import SpatialBody
from lcpflex.compile.spatial.interfaces import FACE_PATCHES, spatial_acting_on
from tests.solid_meshes import STEEL

UP = (0.0, 0.0, 1.0)


@cache
def bar() -> lf.Solid:
    """Nine nodes at its ends, 27 on its sides."""
    return lf.Solid.bar(0.2, 0.02, 0.02, elements=(8, 2, 2), **STEEL)


@cache
def block() -> lf.Solid:
    """63 nodes at the bottom."""
    return lf.Solid.box((0.08, 0.06, 0.04), elements=(8, 6, 3), **STEEL)


def scene_of(model: Any, face: str, friction: float = 0.0, **options: Any) -> lf.SpatialScene:
    scene = lf.SpatialScene()
    body = scene.add(model, "body", (0.0, 0.0, 0.1), **options)
    scene.contact(body.face(face), scene.ground.plane((0.0, 0.0, 0.0), UP), friction, name="hit")
    return scene


def reduced(scene: lf.SpatialScene) -> SpatialBody:
    return scene.reduced().parts().bodies[0]


@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_of_a_small_face_each_node_has_residual_modes(friction: float) -> None:
    """Along the normal where nothing rubs, the same as those of ``reduce(contact=face)``."""
    scene = scene_of(bar(), "right", friction, modes=4)
    body, compiled = reduced(scene), scene.compiled()
    assert body.residual_modes == 9 * (3 if friction else 1)
    assert compiled.notes == ("residual modes for 9 nodes of 'body.face(right)' (contact 'hit')",)
    assert not compiled.warnings
    by_hand = bar().reduce(4, contact="right", rows="all" if friction else "normal")
    assert body.stiffness == pytest.approx(by_hand.stiffness, rel=1e-6)


def test_a_large_face_is_divided_into_patches_that_make_a_uniform_pressure() -> None:
    """Each node is of one of them, and they give way to that pressure as the mesh does."""
    scene = scene_of(block(), "bottom", modes=4, contact_nodes=20)
    parts = scene.parts()
    acting = spatial_acting_on(0, parts.bodies[0], {}, (), parts.contacts, None, parts.rotation, 20)
    assert len(acting) == 20
    places = [one.interface.place for one in acting]
    groups = [place.nodes if isinstance(place, NodeMean) else (place,) for place in places]
    nodes = [point.made_at for point in parts.bodies[0].face("bottom").points]
    assert sorted(node for group in groups for node in group) == sorted(nodes)
    assert all(one.interface.along == pytest.approx((0.0, 0.0, -1.0)) for one in acting)
    assert all(one.named and not one.interface.moment for one in acting)

    share = dict.fromkeys(nodes, 1.0)  # of the area of a facet, in quarters
    x = {point.made_at: point.place for point in parts.bodies[0].face("bottom").points}
    for node, place in x.items():
        share[node] *= (0.5 if abs(abs(place[0]) - 0.04) < 1e-9 else 1.0) * (
            0.5 if abs(abs(place[1]) - 0.03) < 1e-9 else 1.0
        )
    load = np.array([share[node] for node in sorted(nodes)])
    body, whole = reduced(scene), block().reduce(4, contact="bottom", rows="normal")
    found = []
    for one in (body, whole):
        shapes = np.array([one.at_nodes(int(node)).phi[:, 2] for node in sorted(nodes)])
        forces = shapes.T @ load
        found.append(forces @ (forces / one.stiffness))
    assert (body.residual_modes, whole.residual_modes) == (20, 63)
    assert found[0] == pytest.approx(found[1], rel=1e-6)


def test_what_rubs_on_a_large_face_gives_way_along_it_by_patches() -> None:
    """All nodes along the normal, FACE_PATCHES in two directions across."""
    scene = scene_of(block(), "bottom", 0.3, modes=4)
    assert reduced(scene).residual_modes == 63 + 2 * FACE_PATCHES
    compiled = scene.compiled()
    assert not compiled.warnings
    parts = scene.parts()
    acting = spatial_acting_on(0, parts.bodies[0], {}, (), parts.contacts, None, parts.rotation)
    ways = np.array([one.interface.along for one in acting])
    assert np.abs(ways[:63] + UP).max() < 1e-12
    assert np.abs(ways[63:, 2]).max() < 1e-12
    assert ways[63::2] * ways[64::2] == pytest.approx(0.0, abs=1e-12)
    asked = spatial_acting_on(0, parts.bodies[0], {}, (), parts.contacts, None, parts.rotation, FACE_PATCHES)
    assert [one.interface.along for one in asked] == [None] * FACE_PATCHES


@pytest.mark.parametrize("count", [0, 5])
def test_fewer_patches_may_be_asked_for_and_what_is_missing_is_told(count: int) -> None:
    scene = scene_of(block(), "bottom", modes=4, contact_nodes=count)
    assert reduced(scene).residual_modes == count
    compiled = scene.compiled()
    assert compiled.notes == (
        (f"residual modes for {count} patches of 'body.face(bottom)' (contact 'hit')",) if count else ()
    )
    (warning,) = compiled.warnings
    assert "less than its mesh to a force along (0, 0, 1) of contact 'hit'" in warning
    assert "scene.add(unreduced, modes=4), or contact= of its reduce() with that face, has it" in warning


def test_a_body_that_was_reduced_by_hand_is_looked_at_as_well() -> None:
    """It misses compliance at the face, but with residual modes or a boundary there."""
    assert len(scene_of(bar().reduce(4), "right").compiled().warnings) == 1
    for options in ({"contact": "right"}, {"contact": "right", "rows": "normal"}, {"boundary": "right", "modes": 40}):
        assert not scene_of(bar().reduce(**{"modes": 4, **options}), "right").compiled().warnings
    assert not scene_of(bar().reduce(0), "right").compiled().warnings


def test_patches_that_bend_give_way_in_all_directions() -> None:
    ball = lf.Solid.ball(0.05, 0.02, **STEEL)
    scene = scene_of(ball, "surface", modes=2, contact_nodes=6)
    parts = scene.parts()
    acting = spatial_acting_on(0, parts.bodies[0], {}, (), parts.contacts, None, parts.rotation, 6)
    assert [one.interface.along for one in acting] == [None] * 6
    assert reduced(scene).residual_modes == 18


def test_pictures_and_files_hold_faces_as_the_surface_of_their_body(tmp_path: Path) -> None:
    plain = lf.SpatialScene()
    plain.add(bar(), "body", (0.0, 0.0, 0.1), modes=0)
    plain.ground.plane((0.0, 0.0, 0.0), UP)
    drawn = []
    for scene in (scene_of(bar(), "bottom", modes=0), plain):
        result = lf.simulate(scene, 1e-3, lf.MoreauJean(step=1e-3), progress=False)
        for name in ("a.npz", "a.h5"):
            result.save(tmp_path / name)
            assert np.array_equal(lf.Result.load(tmp_path / name).q, result.q)
        drawn.append([len(axis.collections) for axis in result.draw(0.0).figure.axes])
    assert drawn[0] == drawn[1]
