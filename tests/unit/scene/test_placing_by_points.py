"""Bodies are put where one of their points is to be, in the plane and in space alike; drives have one order."""

import warnings

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import lcpflex as lf
from lcpflex.errors import ModelError

PLANAR = lf.Beam(2.0, 0.02, 0.01, 7800.0, 2e11, elements=8)
SPATIAL = lf.SpatialBeam(2.0, 2e-4, (2e-9, 6e-9), 5e-9, 7800.0, 2e11, 0.3, elements=8)
POINTS = ["left", "center", "right"]


def at_start(scene, placed, point):
    """Place and velocity of a point at the start."""
    compiled = scene.compile()
    state = compiled.state(0.0, compiled.q, compiled.u)
    known = placed.point(point) if isinstance(point, str) else placed.at(*point)
    return state.position(known), state.velocity(known)


class TestInThePlane:
    @pytest.mark.parametrize("point", [*POINTS, (0.3, 0.005)])
    @pytest.mark.parametrize("angle", [0.0, 0.7, -2.0])
    def test_the_point_is_there(self, point, angle):
        scene = lf.Scene()
        body = PLANAR.reduce(modes=3)
        modal = np.array([0.3, -0.2, 0.1])
        placed = scene.add(body, None, (1.0, 2.0), angle, (3.0, -1.0), 0.5, modal, -2.0 * modal, point=point)
        place, velocity = at_start(scene, placed, point)
        assert place == pytest.approx([1.0, 2.0], abs=1e-14)
        assert velocity == pytest.approx([3.0, -1.0], abs=1e-13)

    def test_of_bodies_that_are_reduced_with_the_scene(self):
        scene = lf.Scene()
        beam = scene.add(PLANAR, position=(1.0, 2.0), angle=0.7, angular_velocity=2.0, modes=4, point="right")
        scene.join(lf.Revolute(beam.point("left"), scene.ground.at(1.0 - 2.0 * np.cos(0.7), 2.0 - 2.0 * np.sin(0.7))))
        # the joint fits, and what turns about the right end does not turn about the left one
        with pytest.raises(ModelError, match="the initial velocity violates it by 4 m/s"):
            scene.compile()

    def test_without_it_nothing_changes(self):
        a, b = lf.Scene(), lf.Scene()
        for scene, more in ((a, {}), (b, {"point": "left"})):
            scene.add(PLANAR.reduce(modes=3), position=(1.0, 2.0), angle=0.7, velocity=(1.0, 0.0), **more)
        assert a.compile().q.tobytes() == b.compile().q.tobytes()
        assert a.compile().u.tobytes() == b.compile().u.tobytes()

    @pytest.mark.parametrize(("point", "words"), [("middle", "no point 'middle'"), ((9.0, 0.0), "x"), (3, "point")])
    def test_what_is_no_point(self, point, words):
        scene = lf.Scene()
        with pytest.raises(ModelError, match=words):
            scene.add(PLANAR.reduce(modes=3), point=point)
        assert scene.parts().placed == ()


class TestInSpace:
    @pytest.mark.parametrize("point", [*POINTS, (0.3, 0.1, -0.2)])
    def test_the_point_is_there(self, point):
        scene = lf.SpatialScene()
        body = SPATIAL.reduce(modes=3)
        modal = np.array([0.03, -0.02, 0.01])
        turn = Rotation.from_rotvec([0.4, -1.0, 2.0])
        placed = scene.add(
            body, None, (1.0, 2.0, 3.0), turn, (3.0, -1.0, 2.0), (0.5, 1.0, -2.0), modal, modal, point=point
        )
        place, velocity = at_start(scene, placed, point)
        assert place == pytest.approx([1.0, 2.0, 3.0], abs=1e-14)
        assert velocity == pytest.approx([3.0, -1.0, 2.0], abs=1e-13)

    def test_without_it_nothing_changes(self):
        a, b = lf.SpatialScene(), lf.SpatialScene()
        for scene, more in ((a, {}), (b, {"point": "center"})):
            scene.add(SPATIAL.reduce(modes=3), position=(1.0, 2.0, 3.0), velocity=(1.0, 0.0, 0.0), **more)
        assert a.compile().q.tobytes() == b.compile().q.tobytes()

    def test_what_is_no_point(self):
        with pytest.raises(ModelError, match="no point 'middle'"):
            lf.SpatialScene().add(SPATIAL.reduce(modes=3), point="middle")


@pytest.mark.parametrize("point", POINTS)
def test_both_beams_lie_in_one_place(point):
    plane, space = lf.Scene(), lf.SpatialScene()
    flat = plane.add(PLANAR.reduce(modes=2), position=(1.0, 2.0), point=point)
    solid = space.add(SPATIAL.reduce(modes=2), position=(1.0, 2.0, 0.0), point=point)
    for other in POINTS:
        assert at_start(plane, flat, other)[0] == pytest.approx(at_start(space, solid, other)[0][:2], abs=1e-15)


class TestOrderOfDrives:
    MOTIONS = (2.0, lf.Harmonic(0.1, 3.0), lf.Table([0.0, 1.0], [0.0, 1.0]), abs, lf.Function(abs))

    @staticmethod
    def points(space):
        scene = lf.SpatialScene() if space else lf.Scene()
        place = (0.0,) * (3 if space else 2)
        body = scene.add(lf.Sphere(1.0, mass=1.0) if space else lf.Disc(1.0, mass=1.0))
        return body.at(*place), scene.ground.at(*place)

    @pytest.mark.parametrize("motion", MOTIONS, ids=lambda m: type(m).__name__)
    @pytest.mark.parametrize("space", [False, True])
    def test_both_are_taken_and_the_old_one_warns(self, motion, space):
        P, Q = self.points(space)
        axis = (1.0, 0.0, 0.0) if space else (1.0, 0.0)
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            new = lf.DrivenDisplacement(P, Q, motion, axis, name="push")
            named = lf.DrivenDisplacement(P, Q, axis=axis, motion=motion, name="push")
        for way in (axis, list(axis), np.array(axis)):
            with pytest.warns(DeprecationWarning, match=r"its motion before its axis.*\(P, Q, motion, axis\)") as told:
                old = lf.DrivenDisplacement(P, Q, way, motion, name="push")
            assert told[0].filename == __file__
            assert new == named == old
        assert new.motion is motion or new.motion == motion

    @pytest.mark.parametrize(("third", "fourth"), [((1.0, 0.0), (0.0, 1.0)), (1.0, 2.0), ("x", (1.0, 0.0))])
    def test_what_is_neither(self, third, fourth):
        with pytest.raises(ModelError, match="DrivenDisplacement"):
            lf.DrivenDisplacement(*self.points(False), third, fourth)

    def test_it_is_that_of_the_other_drive(self):
        P, Q = self.points(False)
        assert lf.DrivenAngle(P, Q, 2.0).motion == lf.DrivenDisplacement(P, Q, 2.0, (1.0, 0.0)).motion == 2.0
