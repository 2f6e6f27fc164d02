"""Pins in slots and in holes with play: names, laws, other bodies, what cannot be; radii taken from surfaces."""

from __future__ import annotations

import math

import numpy as np
import pytest

import lcpflex as lf
from lcpflex import laws
from lcpflex.errors import ModelError
from lcpflex.scene.slots import SlotParts

STEEL, BRASS = laws.Material(207e9, 0.3), laws.Material(100e9, 0.35)
ARC = {"radius": 60e-3, "width": 16e-3, "start": -1.0, "extent": 2.0}


def yoke(place=(0.06, 0.0)):
    """A pin on a body of its own, and a slider."""
    scene = lf.Scene()
    pin = scene.add(lf.Disc(radius=7.9e-3, mass=0.015), "pin", place)
    return scene, pin, scene.add(lf.RigidBody(0.353, 3.5e-3), "slider")


def test_a_slot_makes_four_contacts_with_names_and_laws():
    scene, pin, slider = yoke()
    slot = slider.curved_slot((0.0, 0.0), **ARC)
    pairs = [laws.CylinderPair.between(part, pin.surface(), 0.01, STEEL) for part in slot.parts]
    given = SlotParts(*(laws.ContactLaw(laws.Johnson(pair)) for pair in pairs))
    names = scene.contact_slot(pin.surface(), slot, friction=0.2, law=given)
    assert names == ("slot1.inner", "slot1.outer", "slot1.first", "slot1.last")
    assert names.outer == "slot1.outer"
    compiled = scene.compiled()
    assert compiled.layout.contacts == names
    assert compiled.laws == given
    np.testing.assert_array_equal(compiled.model.contacts.friction, 0.2)
    second = scene.contact_slot(pin.surface(), slider.straight_slot((0.0, 0.0), (0.1, 0.0), 0.03), restitution=0.5)
    assert second.first == "slot2.first"
    np.testing.assert_array_equal(scene.compiled().model.contacts.restitution, [0.0] * 4 + [0.5] * 4)


@pytest.mark.parametrize("kind", ["curved", "straight"])
def test_other_bodies_get_the_same_slot(kind):
    scene, pin, slider = yoke()
    middle = slider.at(0.0, 0.0)
    slot = slider.curved_slot(middle, **ARC) if kind == "curved" else slider.straight_slot(middle, (0.1, 0.0), 0.016)
    law = laws.ContactLaw(laws.PowerLaw(1e8))
    scene.contact_slot(pin.surface(), slot, friction=0.1, name="slot", law=law)
    heavier = scene.with_bodies({"slider": lf.RigidBody(1.0, 1e-2)})
    old, new = (one.compiled() for one in (scene, heavier))
    assert new.layout.contacts == old.layout.contacts
    assert new.laws == old.laws == (law,) * 4
    for a, b in zip(old.model.contacts, new.model.contacts, strict=True):
        np.testing.assert_array_equal(a, b)
    np.testing.assert_array_equal(old.model.points.place, new.model.points.place)


def test_a_slot_moves_with_a_flexible_body_as_one():
    """Of a curved slot, all parts are carried by the material at its centre."""
    beam = lf.Beam(0.3, 0.02, 0.01, density=7800.0, youngs_modulus=2.1e11, elements=6).reduce(modes=3)
    scene = lf.Scene()
    slot = scene.add(beam, "beam").curved_slot((0.1, 0.002), **ARC)
    center = slot.inner.shape.points[0]
    for part in slot.parts:
        point = part.shape.points[0]
        offset = point.place - center.place
        np.testing.assert_array_equal(point.psi, center.psi)
        turned = np.array([-offset[1], offset[0]])
        np.testing.assert_allclose(point.phi, center.phi + center.psi[:, None] * turned, rtol=1e-14)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"radius": 0.0}, "radius: 0.0"),
        ({"width": 0.12}, "width: 0.12"),
        ({"width": -1e-3}, "width: -0.001"),
        ({"start": math.nan}, "start: nan"),
        ({"extent": 0.0}, "extent: 0.0"),
        ({"extent": 6.2}, "extent: 6.2 .* run into each other"),
    ],
)
def test_curved_slots_that_cannot_be(change, message):
    with pytest.raises(ModelError, match=message):
        yoke()[2].curved_slot((0.0, 0.0), **{**ARC, **change})


def test_straight_slots_that_cannot_be():
    slider = yoke()[2]
    with pytest.raises(ModelError, match="two places"):
        slider.straight_slot((0.1, 0.0), (0.1, 0.0), 0.016)
    with pytest.raises(ModelError, match="width: 0"):
        slider.straight_slot((0.1, 0.0), (0.2, 0.0), 0)


def test_pins_that_do_not_run_in_a_slot():
    scene, pin, slider = yoke()
    slot = slider.curved_slot((0.0, 0.0), **ARC)
    with pytest.raises(ModelError, match=r"pin: a radius of 0\.008 m was given, expected less than 0\.008 m"):
        scene.contact_slot(pin.circle((0.0, 0.0), 0.008), slot)
    with pytest.raises(ModelError, match="expected a disc"):
        scene.contact_slot(pin.node(0.0, 0.0), slot)
    with pytest.raises(ModelError, match="slot: 3 was given"):
        scene.contact_slot(pin.surface(), 3)
    with pytest.raises(ModelError, match="parts of this scene"):
        yoke()[0].contact_slot(pin.surface(), slot)
    with pytest.raises(ModelError, match="law: 1"):
        scene.contact_slot(pin.surface(), slot, law=1)
    away, outside, other = yoke(place=(0.06, 0.07))
    with pytest.raises(ModelError, match=r"is 0\.0241954 m outside of the slot"):
        away.contact_slot(outside.surface(), other.curved_slot((0.0, 0.0), **ARC))


def test_a_revolute_joint_with_clearance():
    scene = lf.Scene()
    arm = scene.add(lf.Box(0.2, 0.02, mass=1.0), "arm", (1.0, 0.0), math.pi / 2)
    end, pivot = arm.at(-0.1, 0.0), scene.ground.at(1.0, -0.1005)
    assert scene.revolute_with_clearance(pivot, end, 9e-3, 10e-3, restitution=0.3, name="bearing") == "bearing"
    assert not scene.parts().joints
    pin, hole = scene.parts().contacts["bearing"].pair
    assert (pin.body, pin.shape.radius, hole.body, hole.shape.radius) == (0, 9e-3, -1, 10e-3)
    assert scene.with_bodies({"arm": lf.Box(0.2, 0.02, mass=2.0)}).compiled().layout.contacts == ("bearing",)
    with pytest.raises(ModelError, match=r"pin_radius: a radius of 0\.01 m was given, expected less than 0\.01 m"):
        scene.revolute_with_clearance(pivot, end, 10e-3, 10e-3)
    with pytest.raises(ModelError, match=r"0\.0005 m from .* expected at most the play of 0\.0004 m"):
        scene.revolute_with_clearance(pivot, end, 9.6e-3, 10e-3)
    with pytest.raises(ModelError, match="points of two bodies"):
        scene.revolute_with_clearance(arm.at(0.0, 0.0), end, 9e-3, 10e-3)
    with pytest.raises(ModelError, match="hole_radius: -1"):
        scene.revolute_with_clearance(pivot, end, 9e-3, -1.0)


def surfaces():
    ground = lf.Scene().ground
    return {
        "disc": ground.circle((0.0, 0.0), 7.9e-3),
        "hole": ground.hole((0.0, 0.0), 8e-3),
        "arc": ground.arc((0.0, 0.0), 52e-3, 0.0, 1.0),
        "track": ground.arc((0.0, 0.0), 68e-3, 0.0, 1.0, hole=True),
        "plane": ground.half_plane((0.0, 0.0), (0.0, 1.0)),
        "node": ground.node(0.0, 0.0),
        "chain": ground.chain([(0.0, 0.0), (1.0, 0.0)]),
    }


def test_radii_of_a_pair_come_from_its_surfaces():
    of = surfaces()
    between, internal, external = laws.CylinderPair.between, laws.CylinderPair.internal, laws.CylinderPair.external
    assert between(of["disc"], of["hole"], 0.01, STEEL) == internal(8e-3, 7.9e-3, 0.01, STEEL)
    assert between(of["hole"], of["disc"], 0.01, STEEL, BRASS) == internal(8e-3, 7.9e-3, 0.01, STEEL, BRASS)
    assert between(of["disc"], of["hole"], 0.01, STEEL, BRASS) == internal(8e-3, 7.9e-3, 0.01, BRASS, STEEL)
    assert between(of["track"], of["disc"], 0.01, STEEL) == internal(68e-3, 7.9e-3, 0.01, STEEL)
    assert between(of["arc"], of["disc"], 0.01, STEEL) == external(52e-3, 7.9e-3, 0.01, STEEL)
    sphere = laws.Hertz
    assert sphere.between(of["disc"], of["arc"], STEEL) == sphere.spheres(7.9e-3, 52e-3, STEEL)
    assert sphere.between(of["plane"], of["disc"], STEEL, BRASS) == sphere.sphere_on_plane(7.9e-3, STEEL, BRASS)
    assert sphere.between(of["hole"], of["disc"], STEEL) == sphere.sphere_in_cup(7.9e-3, 8e-3, STEEL)


@pytest.mark.parametrize(
    ("a", "b", "message"),
    [
        ("disc", "plane", "b: 'ground.half_plane1' .* expected a round surface"),
        ("plane", "hole", "expected a disc or a round part"),
        ("hole", "track", "expected a disc or a round part"),
        ("node", "disc", "a: 'ground.node1' .* without a radius"),
        ("disc", "chain", "b: 'ground.chain1' .* without a radius"),
        ("arc", "hole", "pin_radius: 0.052"),
    ],
)
def test_surfaces_that_are_no_pair_of_cylinders(a, b, message):
    of = surfaces()
    with pytest.raises(ModelError, match=message):
        laws.CylinderPair.between(of[a], of[b], 0.01, STEEL)


def test_what_is_no_surface():
    with pytest.raises(ModelError, match="a: 3 was given"):
        laws.CylinderPair.between(3, surfaces()["disc"], 0.01, STEEL)
