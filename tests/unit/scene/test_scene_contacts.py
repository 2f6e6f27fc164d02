"""Contacts of a scene: declaration, everything against everything, and refusal of what cannot be."""

import math

import numpy as np
import pytest

import lcpflex as lf
from tests.scenes import floor_of


def boxes(n=3, gap=0.1):
    """n unit boxes in a row, on nothing."""
    scene = lf.Scene()
    box = lf.Box(width=1.0, height=1.0, mass=1.0)
    return scene, [scene.add(box, f"box{k + 1}", position=((1.0 + gap) * k, 0.5)) for k in range(n)]


def test_the_scene_of_the_readme():
    bar = lf.Beam(length=0.7, width=0.028, thickness=0.005, density=2700, youngs_modulus=6.9e10).reduce(modes=8)
    scene = lf.Scene(gravity=(0, -9.81))
    pendulum = scene.add(bar, name="pendulum")
    scene.join(lf.Revolute(pendulum.point("left"), scene.ground.at(0, 0)))
    stop = scene.ground.circle(center=(-0.0125, -0.69), radius=0.01)
    scene.contact(pendulum.surface(), stop, friction=0.3, restitution=0.0)
    compiled = scene.compiled()
    assert compiled.layout.bodies == ("pendulum",)
    assert compiled.layout.contacts == ("contact1",)
    assert compiled.layout.joints == ("joint1",)
    assert len(compiled.q) == 3 + 8
    np.testing.assert_array_equal(compiled.model.contacts.friction, [0.3])


def test_laws_keep_the_order_of_declaration():
    scene, (a, b, c) = boxes()
    floor = floor_of(scene)
    assert scene.contact(a.surface(), floor, friction=0.1, name="first") == "first"
    assert scene.contact(b.surface(), floor, restitution=0.2) == "contact2"
    assert scene.contact(c.surface(), floor, friction=0.3, tangential_restitution=0.4) == "contact3"
    compiled = scene.compiled()
    assert compiled.layout.contacts == ("first", "contact2", "contact3")
    np.testing.assert_array_equal(compiled.model.contacts.friction, [0.1, 0.0, 0.3])
    np.testing.assert_array_equal(compiled.model.contacts.restitution, [0.0, 0.2, 0.0])
    np.testing.assert_array_equal(compiled.model.contacts.tangential_restitution, [0.0, 0.0, 0.4])


def test_everything_against_everything():
    scene, (a, b, c) = boxes()
    scene.contact_all(friction=0.5, exclude=[(a, c)])
    floor = floor_of(scene)  # later than the rule
    scene.contact(b.surface(), floor, friction=0.9, name="mine")
    compiled = scene.compiled()
    assert compiled.layout.contacts == (
        "mine",
        "box1.outline/box2.outline",
        "box1.outline/ground.half_plane1",
        "box2.outline/box3.outline",
        "box3.outline/ground.half_plane1",
    )
    np.testing.assert_array_equal(compiled.model.contacts.friction, [0.9, 0.5, 0.5, 0.5, 0.5])


def test_jointed_bodies_are_left_out_but_meet_the_ground():
    scene, (a, b, _) = boxes()
    scene.join(lf.Revolute(a.at(0.55, 0), b.at(-0.55, 0)))
    scene.join(lf.Revolute(a.at(0, 0), scene.ground.at(0, 0.5)))
    floor_of(scene)
    scene.contact_all()
    names = scene.compiled().layout.contacts
    assert "box1.outline/box2.outline" not in names
    assert {"box1.outline/box3.outline", "box1.outline/ground.half_plane1"} <= set(names)


def test_everything_leaves_out_what_cannot_touch():
    scene, (a, _) = boxes(2)
    a.hole((0, 0), 0.1)
    floor_of(scene)
    scene.contact_all(exclude=[(a, scene.ground)])
    assert scene.compiled().layout.contacts == (
        "box1.outline/box2.outline",
        "box2.outline/box1.hole1",
        "box2.outline/ground.half_plane1",
    )


def test_a_later_rule_adds_only_what_is_left():
    scene, (a, b, _c) = boxes()
    scene.contact_all(friction=0.1, exclude=[(a.surface(), b.surface())])
    scene.contact_all(friction=0.2)
    compiled = scene.compiled()
    assert dict(zip(compiled.layout.contacts, compiled.model.contacts.friction, strict=True)) == {
        "box1.outline/box3.outline": 0.1,
        "box2.outline/box3.outline": 0.1,
        "box1.outline/box2.outline": 0.2,
    }


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda s, a, b: s.contact(a.surface(), a.surface()), "'box1.outline' was given twice"),
        (lambda s, a, b: s.contact(a.surface(), a.surface("top")), "both on the same body"),
        (lambda s, a, b: s.contact(s.ground.node(0, 0), s.ground.circle((3, 0), 1)), "both on the ground"),
        (lambda s, a, b: s.contact(a.hole((0, 0), 0.1), b.half_plane((0, 0), (0, 1))), r"\(a hole\).*cannot touch"),
        (lambda s, a, b: s.contact(a.node(0, 0), b.node(0, 0)), "cannot touch"),
        (lambda s, a, b: s.contact(a, b.surface()), "a: .*expected a surface"),
        (lambda s, a, b: s.contact(a.surface(), b.surface(), friction=-0.1), "friction: -0.1"),
        (lambda s, a, b: s.contact(a.surface(), b.surface(), friction=math.nan), "friction: nan"),
        (lambda s, a, b: s.contact(a.surface(), b.surface(), restitution=1.5), "restitution: 1.5"),
        (lambda s, a, b: s.contact(a.surface(), b.surface(), tangential_restitution=-1), "tangential_restitution"),
        (lambda s, a, b: s.contact_all(restitution=2.0), "restitution: 2.0"),
        (lambda s, a, b: s.contact_all(exclude=[(a,)]), "exclude"),
        (lambda s, a, b: s.contact_all(exclude=(a, b)), "exclude"),
        (lambda s, a, b: a.at("x", 1), "x: 'x' was given"),
        (lambda s, a, b: s.contact_all(exclude=[("box1", "box2")]), "exclude"),
        (lambda s, a, b: s.contact(a.surface(), lf.Scene().ground.node(0, 0)), "not of another one"),
    ],
)
def test_bad_contacts(build, message):
    scene, (a, b) = boxes(2)
    with pytest.raises(lf.ModelError, match=message):
        build(scene, a, b)


def test_duplicate_contact_names_are_refused():
    scene, (a, b, c) = boxes()
    scene.contact(a.surface(), b.surface(), name="pair")
    with pytest.raises(lf.ModelError, match="'pair' was given twice"):
        scene.contact(b.surface(), c.surface(), name="pair")


def test_a_pair_is_declared_once():
    scene, (a, b) = boxes(2)
    scene.contact(a.surface(), b.surface(), friction=0.1, name="pair")
    with pytest.raises(lf.ModelError, match="given twice, 'pair' is between them"):
        scene.contact(b.surface(), a.surface(), friction=0.2)


def test_initial_penetration_is_refused_with_contact_and_depth():
    scene, (a, b) = boxes(2, gap=-0.03)
    scene.contact(a.surface(), b.surface(), name="pair")
    with pytest.raises(lf.ModelError, match=r"'pair': its surfaces penetrate by 0\.03 m"):
        scene.compiled()


@pytest.mark.parametrize("gap", [0.0, -1e-12, 1e-12])
def test_touching_is_no_penetration(gap):
    scene, (_a, _b) = boxes(2, gap=gap)
    floor_of(scene)
    scene.contact_all()
    assert len(scene.compiled().layout.contacts) == 3


def test_surfaces_are_drawn():
    scene, (a, _) = boxes(2)
    a.circle((0, 0), 0.2)
    compiled = scene.compiled()
    assert [radius for _, radius in compiled.layout.circles] == [0.2]
    assert [body for body, _, _ in compiled.layout.outlines] == [0, 1]
