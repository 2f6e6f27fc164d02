"""Faces of solids in scenes: handles, what of them touches, which of two is the node side, and rules for all."""

from __future__ import annotations

import copy
import pickle
import warnings
from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import lcpflex as lf
from lcpflex.bodies.spatial.surface import SpatialKind
from lcpflex.scene.contact_rules import by_rules
from tests.pressed_solids import grid_block
from tests.solid_meshes import QUIET, STEEL, solid

UP = (0.0, 0.0, 1.0)


@cache
def box(size: float = 0.025) -> lf.Solid:
    return lf.Solid.box((0.1, 0.05, 0.05), size, near={"hit": ((0.02, 0.0, -0.025), size, size * 1.5)}, **STEEL)


def scene_of(*heights: float, size: float = 0.025, modes: int = 0) -> tuple[lf.SpatialScene, list[Any], Any]:
    """Boxes with their middles at these heights, over the ground."""
    scene = lf.SpatialScene()
    blocks = [scene.add(box(size), f"b{k}", (0.0, 0.0, z), modes=modes) for k, z in enumerate(heights)]
    return scene, blocks, scene.ground.plane((0.0, 0.0, 0.0), UP)


def ruled(scene: lf.SpatialScene, listed: bool = True) -> set[str]:
    """The names of the contacts by rules that are listed."""
    parts = scene.parts()
    found = by_rules(parts.placed, parts.surfaces, parts.contacts, parts.rules, tuple(parts.joints.values()), listed)
    return set(found.contacts)


def test_a_face_is_one_surface_of_its_body() -> None:
    scene, (block,), _ = scene_of(0.03)
    face = block.face("top")
    assert block.face("top") is face
    assert face.label == "b0.face(top)"
    assert face.shape.kind is SpatialKind.FACE
    assert len(face.shape.triangles) == 2 * len(face.shape.cells)
    other = scene.add(box().reduce(0), "rigid")
    assert other.face("top").label == "rigid.face(top)"
    copied = copy.deepcopy(scene)
    assert copied.body("b0").face("top") is copied.parts().surfaces[1]
    assert copied.body("b0").face("top") is not face
    assert pickle.loads(pickle.dumps(scene)).body("b0").face("top").label == face.label


@QUIET
def test_a_face_is_made_again_when_its_body_is_reduced() -> None:
    scene, (block,), floor = scene_of(0.026, modes=3)
    name = scene.contact(block.face("hit"), floor, points="areas")
    reduced = scene.reduced().parts()
    face = reduced.contacts[name].pair[0]
    assert face.label == "b0.face(hit)"
    assert len(face.shape.points[0].phi) >= 3
    assert reduced.contacts[name].points == "areas"
    assert face is reduced.surfaces[1]


@QUIET
@pytest.mark.parametrize(
    ("kind", "other", "points"),
    [
        ("hexahedron", "plane", "nodes"),
        ("tetra", "sphere", "nodes"),
        ("hexahedron", "cylinder", "nodes"),
        ("hexahedron", "box", "areas"),
        ("tetra10", "plane", "areas"),
        ("hexahedron20", "sphere", "areas"),
        ("hexahedron27", "cylinder", "areas"),
    ],
)
def test_what_a_face_touches_with(kind: str, other: str, points: str) -> None:
    """Nodes of linear facets on simple shapes, areas of all else, if nothing is chosen."""
    scene = lf.SpatialScene()
    body = scene.add(solid(kind, sets={"end": lambda x, y, z: x > 0.29}).reduce(0), "body")
    made = {
        "plane": lambda: scene.ground.plane((0.0, 0.0, -1.0), UP),
        "sphere": lambda: scene.ground.sphere((0.0, 0.0, -1.0), 0.1),
        "cylinder": lambda: scene.ground.cylinder((0.0, 0.0, -1.0), UP, 0.1, 0.1),
        "box": lambda: scene.ground.box((0.0, 0.0, -1.0), (1.0, 1.0, 1.0)),
    }[other]
    for chosen, found in ((None, points), ("nodes", "nodes"), ("areas", "areas")):
        name = scene.contact(body.face("end"), made(), points=chosen)
        assert scene.parts().contacts[name].points == found


def test_the_finer_of_two_faces_is_the_node_side() -> None:
    """However they are given; the coarser one by choice, with a warning. Equal ones: the first."""
    scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
    low, high = (
        scene.add(box(size).reduce(0), n, p) for size, n, p in ((0.025, "low", (0, 0, 0)), (0.02, "high", (0, 0, 0.06)))
    )
    coarse, fine = low.face("top"), high.face("bottom")
    for pair, chosen, side in (
        ((coarse, fine), None, fine),
        ((fine, coarse), None, fine),
        ((coarse, fine), fine, fine),
        ((coarse, fine), coarse, coarse),
    ):
        one = copy.deepcopy(scene)
        mine = {s.label: s for s in one.parts().surfaces}
        name = one.contact(*(mine[s.label] for s in pair), node_side=None if chosen is None else mine[chosen.label])
        declared = one.parts().contacts[name]
        assert (declared.node_side.label, declared.points) == (side.label, "areas")  # type: ignore[union-attr]
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            told = one.compiled().warnings
        assert not caught
        assert any("'low.face(top)' is the coarser face" in text for text in told) is (side is coarse)
    twin = scene.add(box(0.025).reduce(0), "twin", (0, 0, -0.06))
    name = scene.contact(twin.face("top"), low.face("bottom"))
    assert scene.parts().contacts[name].node_side is twin.face("top")


def plates() -> tuple[lf.SpatialBody, lf.SpatialBody]:
    """One of 100 mm with sub-faces from 2 mm in its middle to 30 mm at its rim, 11 in the mean; one of 24 mm with 8."""
    steps, even = np.array([-50.0, -20.0, -8.0, -3.0, -1.0, 1.0, 3.0, 8.0, 20.0, 50.0]), np.linspace(-12.0, 12.0, 4)
    thick = np.array([-5.0, 5.0])
    meshes = (grid_block("hexahedron", [1e-3 * line for line in (own, own, thick)]) for own in (steps, even))
    ends = {"top": lambda x, y, z: z > 4.9e-3, "bottom": lambda x, y, z: z < -4.9e-3}
    graded, small = (lf.Solid(mesh, sets=ends, **STEEL).reduce(0) for mesh in meshes)
    return graded, small


@QUIET
@pytest.mark.parametrize(("offset", "finer"), [(0.0, "graded"), (0.035, "small")])
@pytest.mark.parametrize("turned", [False, True])
def test_a_graded_face_is_as_fine_as_where_the_other_one_is(offset: float, finer: str, turned: bool) -> None:
    """In its middle it is finer than another one that has smaller sub-faces in the mean; not at its rim."""
    turn = Rotation.from_euler("z", 0.5 * np.pi) if turned else Rotation.identity()
    graded, small = plates()
    for by_choice in (False, True):
        scene = lf.SpatialScene()
        low = scene.add(graded, "graded", (0.3, -0.1, 0.0), orientation=turn).face("top")
        high = scene.add(small, "small", (0.3 + offset, -0.1 - offset, 0.0101)).face("bottom")
        other = low if finer == "small" else high
        name = scene.contact(low, high, node_side=other if by_choice else None)
        taken = scene.parts().contacts[name].node_side
        assert taken is (other if by_choice else low if other is high else high)
        told = [text for text in scene.compiled().warnings if f"node_side {other.label!r} is the coarser face" in text]
        assert bool(told) is by_choice


@pytest.mark.parametrize(
    ("attempt", "words"),
    [
        (lambda s, b, p: b.face("nose"), r"name: there is no face 'nose', expected one of .*'top'.*, of 'b0'"),
        (lambda s, b, p: b.face(3), "name: there is no face 3"),
        (lambda s, b, p: s.ground.face("top"), "name: 'top' was given for the ground, which has no faces"),
        (lambda s, b, p: s.add(lf.Sphere(0.1, mass=1.0), "ball").face("top"), "name: 'ball' has no faces"),
        (lambda s, b, p: s.contact(b.face("top"), p, points="area"), "points: 'area' was given, expected one of 'ar"),
        (lambda s, b, p: s.contact(b.face("top"), p, points=1), "points: 1 was given"),
        (lambda s, b, p: s.contact(b.surface(), p, points="nodes"), r"points: 'nodes' was given for 'b0\.surface' and"),
        (lambda s, b, p: s.contact(b.face("top"), p, node_side=p), r"node_side: .* expected the other one"),
        (lambda s, b, p: s.contact(b.face("top"), s.ground.node((0, 0, 0))), "which cannot touch each other"),
        (lambda s, b, p: s.contact(b.face("top"), b.face("bottom")), "both on the same body"),
    ],
)  # fmt: skip
def test_what_cannot_be_is_refused(attempt: Any, words: str) -> None:
    scene, (block,), floor = scene_of(0.03)
    with pytest.raises(lf.ModelError, match=words):
        attempt(scene, block, floor)


def test_no_facet_touches_the_same_partner_twice() -> None:
    """By two faces with a facet in common, or a face and the whole surface; faces beside each other may."""
    scene, (block,), floor = scene_of(0.03)
    for name in ("bottom", "left", "top"):
        scene.contact(block.face(name), floor)
    scene.compiled()
    for twice in (block.face("hit"), block.surface()):
        other = copy.deepcopy(scene)
        mine = {s.label: s for s in other.parts().surfaces}
        other.contact(
            other.body("b0").surface() if twice.label.endswith("surface") else mine[twice.label], mine[floor.label]
        )
        with pytest.raises(lf.ModelError, match=r"'b0\.face\(bottom\)' and 'ground\.plane1' and contact 'contact4'"):
            other.compiled()
    scene.contact_all()
    with pytest.raises(lf.ModelError, match=r"'b0\.surface/ground\.plane1' of 'b0\.surface'.* are both for the same"):
        scene.compiled()


@pytest.mark.parametrize("many", [0, 40])
def test_rules_are_for_faces_where_they_are_for_no_whole_surface(many: int) -> None:
    """Also where the pairs of other surfaces are too many to be listed."""
    scene, (low, high), floor = scene_of(0.03, 0.09)
    bottom, top, under = low.face("bottom"), low.face("top"), high.face("bottom")
    for k in range(many):
        scene.add(lf.Sphere(0.1, mass=1.0), f"s{k}", (float(k + 1), 0.0, 1.0))
    plain = scene.parts()
    scene.contact_all()
    assert not any("face(" in name for name in ruled(scene, False))
    scene._rules.clear()
    left_out = [(low.surface(), floor), (low.surface(), high.surface())]
    scene.contact_all(0.2, exclude=left_out)
    names = {name for name in ruled(scene, False) if "face(" in name}
    expected = {"ground.plane1/b0.face(bottom)", "ground.plane1/b0.face(top)"}
    expected |= {f"{own.label}/{under.label}" for own in (bottom, top)}
    assert names == expected
    parts = scene.parts()
    found = by_rules(parts.placed, parts.surfaces, parts.contacts, parts.rules, (), False)
    contact = found.contacts[f"{top.label}/{under.label}"]
    assert (contact.friction, contact.points, contact.node_side) == (0.2, "areas", top)
    if many:
        assert found.kept is not None
        kept = [surface.label for surface in found.kept.surfaces]
        assert len(kept) == len(plain.placed) + 1
        barred = {frozenset((kept[i], kept[j])) for i, j in found.kept.barred}
        assert barred == {frozenset(s.label for s in pair) for pair in left_out}
        scene.contact(high.face("left"), floor)
        with pytest.raises(lf.ModelError, match=r"'b1\.face\(left\)' and 'ground\.plane1' and that of contact_all"):
            ruled(scene, False)


@QUIET
def test_matrices_that_tell_faces_alone_touch_with_these() -> None:
    """Their triangles are no closed surface; without a face that was made, the scene says so."""
    mesh = solid("hexahedron", (3, 2, 2)).finite_elements()
    low = mesh.facets[(mesh.places[mesh.facets][..., 2] < 1e-9).all(axis=1)]
    body = lf.SpatialMatrices(mesh.mass, mesh.stiffness, mesh.places, faces={"low": low}).reduce(0)
    scene = lf.SpatialScene()
    placed = scene.add(body, "block", (0.0, 0.0, 1.0))
    scene.ground.plane((0.0, 0.0, 0.0), UP)
    scene.contact_all()
    with pytest.raises(lf.ModelError, match="surface of 'block'"):
        scene.compiled()
    placed.face("low")
    assert ruled(scene) == {"ground.plane1/block.face(low)"}
    scene.compiled()


def test_a_face_lands_on_the_ground() -> None:
    """With the weight of its body, at its nodes."""
    scene, (block,), floor = scene_of(0.025)
    name = scene.contact(block.face("bottom"), floor, points="nodes")
    result = lf.simulate(scene, 2e-3, lf.MoreauJean(step=1e-4), progress=False)
    weight = block.source.mass * 9.81
    assert result.contact(name).normal_force[-1].sum() == pytest.approx(weight, rel=1e-6)
    assert np.abs(result.q[-1][:3] - [0.0, 0.0, 0.025]).max() < 1e-9


@pytest.mark.parametrize(
    ("points", "larger", "told"), [("nodes", True, True), ("areas", True, False), ("nodes", False, False)]
)
def test_nodes_of_a_larger_face_are_told(points: str, larger: bool, told: bool) -> None:
    """Those at its rim are beside the other one, even if it is larger by a thousandth."""
    scene = lf.SpatialScene()
    bodies = []
    for k, width in enumerate((0.1, 0.1001)):
        solid = lf.Solid.box((width, width, 0.05), elements=(2, 2, 1), **STEEL)
        bodies.append(scene.add(solid.reduce(0), position=(0.0, 0.0, 0.06 * k)))
    low, high = bodies[0].face("top"), bodies[1].face("bottom")
    scene.contact(low, high, points=points, node_side=high if larger else low)
    assert any("which is smaller" in text for text in scene.compiled().warnings) is told
