"""Outlines that begin deep inside each other are refused: no gap tells of them, and they would pass through."""

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.errors import ModelError


def box(scale=1.0):
    return lf.Box(0.2 * scale, 0.2 * scale, mass=1.0)


def pair(place, first=None, second=None, angle=0.0, declare=None):
    scene = lf.Scene()
    a = scene.add(first or box(), name="a")
    b = scene.add(second or box(), name="b", position=place, angle=angle)
    (declare or (lambda scene, a, b: scene.contact_all(friction=0.3)))(scene, a, b)
    return scene


REFUSED = r"overlap at the start by more than half the thickness|penetrate by"


class TestRefused:
    @pytest.mark.parametrize("angle", [0.0, 0.3, np.pi / 4])
    @pytest.mark.parametrize("place", [(0.0, 0.0), (0.02, 0.0), (0.05, 0.03), (0.08, 0.03), (0.0, 0.09), (0.15, 0.1)])
    def test_at_any_depth(self, place, angle):
        with pytest.raises(ModelError, match=rf"'a.outline/b.outline': .*({REFUSED})"):
            pair(place, angle=angle).compile()

    @pytest.mark.parametrize("scale", [1e-3, 1.0, 1e3])
    def test_in_any_unit(self, scale):
        with pytest.raises(ModelError, match=REFUSED):
            pair((0.05 * scale, 0.03 * scale), box(scale), box(scale)).compile()

    @pytest.mark.parametrize("angle", [0.0, 0.4])
    def test_plates_that_cross(self, angle):
        plate = lf.Box(1.0, 0.05, mass=1.0)
        with pytest.raises(ModelError, match=REFUSED):
            pair((0.02, 0.01), plate, plate, angle=np.pi / 2 + angle).compile()

    def test_a_small_one_in_a_large_one(self):
        with pytest.raises(ModelError, match=REFUSED):
            pair((0.01, 0.02), box(), box(0.1)).compile()

    def test_declared_contacts_by_their_names(self):
        scene = pair((0.05, 0.03), declare=lambda s, a, b: s.contact(a.surface(), b.surface(), name="pair"))
        with pytest.raises(ModelError, match="contact 'pair': its surfaces overlap"):
            scene.compile()

    def test_in_runs_and_where_it_is_asked_to_push(self):
        scene = pair((0.05, 0.03))
        for project in (False, True):
            with pytest.raises(ModelError, match="expected bodies beside each other"):
                lf.simulate(scene, 0.01, lf.MoreauJean(step=1e-3), project=project)

    def test_flexible_bodies_and_ground(self):
        beam = lf.Beam(1.0, 0.1, 0.2, 7800.0, 2e11, elements=4).reduce(modes=2)
        with pytest.raises(ModelError, match=REFUSED):
            pair((0.5, 0.0), beam, box(0.5)).compile()
        scene = lf.Scene()
        scene.add(box(), name="box", position=(0.05, 0.03))
        scene.ground.chain([(-0.1, -0.1), (0.1, -0.1), (0.1, 0.1), (-0.1, 0.1)], closed=True)
        scene.contact_all()
        with pytest.raises(ModelError, match=REFUSED):
            scene.compile()


class TestLeftInPeace:
    @pytest.mark.parametrize(
        "place", [(0.2, 0.0), (0.2, 0.1), (0.2, 0.03), (0.2, 0.2), (0.2 - 1e-12, 0.07), (0.5, 0.0)]
    )
    def test_beside_each_other(self, place):
        pair(place).compile()

    @pytest.mark.parametrize("turn", [0.0, 0.1, 1.0])
    def test_stacks_at_any_angle(self, turn):
        """Flush, one on the other and one beside it, to rounding."""
        scene = lf.Scene()
        c, s = np.cos(turn), np.sin(turn)
        for k, (x, y) in enumerate([(0.0, 0.0), (0.2, 0.0), (0.1, 0.2), (0.0, 0.4)]):
            scene.add(box(), name=f"b{k}", position=(c * x - s * y, s * x + c * y), angle=turn)
        scene.contact_all()
        scene.compile()

    def test_those_without_a_contact(self):
        place = (0.05, 0.03)
        pair(place, declare=lambda s, a, b: None).compile()
        pair(place, declare=lambda s, a, b: s.contact_all(exclude=[(a, b)])).compile()

        def jointed(scene, a, b):
            scene.join(lf.Revolute(a.at(*place), b.at(0.0, 0.0)))
            scene.contact_all()

        pair(place, declare=jointed).compile()

    def test_soft_contacts(self):
        pair((0.05, 0.03), declare=lambda s, a, b: s.contact(a.surface(), b.surface(), law=lf.Penalty(1e5))).compile()

    def test_what_is_in_a_hollow(self):
        """In the notch of a bracket, or in a frame with a hole."""
        corners = [(0, 0), (1, 0), (1, 1), (0.7, 1), (0.7, 0.3), (0.3, 0.3), (0.3, 1), (0, 1)]
        for y, sound in ((0.5, True), (0.35 - 1e-3, False), (0.2, False), (0.15, False)):
            scene = lf.Scene()
            scene.add(lf.RigidBody(mass=1.0, inertia=1.0), name="bracket").chain(corners, closed=True)
            scene.add(box(0.5), name="box", position=(0.5, y))
            scene.contact_all()
            if sound:
                scene.compile()
                continue
            with pytest.raises(ModelError, match=REFUSED):
                scene.compile()

        def with_hole(scene, a, b):
            scene.contact(a.hole((0.0, 0.0), 0.3), b.circle((0.0, 0.0), 0.2))
            scene.contact_all(exclude=[(a.surface(), b)])

        pair((0.0, 0.0), lf.Box(1.0, 1.0, mass=1.0), box(), declare=with_hole).compile()
