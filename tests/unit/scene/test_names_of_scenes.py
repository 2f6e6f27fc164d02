"""Every name of a scene that looks public is for users, and checks what it is given."""

import copy
import pickle

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.errors import ModelError

VERBS = {"add", "body", "compile", "contact", "contact_all", "join", "load", "sensor"}
READ = {"compiled", "parts", "gravity", "ground", "spatial"}
BOTH = {"reduced", "revolute_with_clearance", "with_bodies"}
PLANAR = {"contact_slot"}


@pytest.mark.parametrize(("kind", "more"), [(lf.Scene, PLANAR), (lf.SpatialScene, set())])
def test_public_names(kind, more):
    assert {name for name in dir(kind()) if not name.startswith("_")} == VERBS | READ | BOTH | more


@pytest.mark.parametrize("kind", [lf.Scene, lf.SpatialScene])
def test_public_names_of_handles(kind):
    ground = kind().ground
    assert not {"keep", "label", "made_of", "put", "holder"} & set(dir(ground))


@pytest.mark.parametrize("kind", [lf.Scene, lf.SpatialScene])
class TestWhatCanBeSet:
    @pytest.mark.parametrize("value", ["down", None, [1.0], [0.0, np.nan, 0.0], [np.inf, 0.0], [[1.0, 2.0]], 9.81, {}])
    def test_gravity_is_checked(self, kind, value):
        scene = kind()
        before = scene.gravity
        with pytest.raises(ModelError, match="gravity"):
            scene.gravity = value
        assert scene.gravity is before

    def test_gravity_of_the_other_kind_is_told(self, kind):
        with pytest.raises(ModelError, match="planar"):
            kind().gravity = [0.0] * (3 if kind is lf.Scene else 2)

    def test_gravity_can_be_set_anew(self, kind):
        scene, other = kind(), kind()
        n = len(scene.gravity)
        scene.gravity = [1.0] * n
        assert scene.gravity.tolist() == [1.0] * n
        assert other.gravity[-1] == -9.81
        with pytest.raises(ValueError, match="read-only"):
            scene.gravity[0] = 7.0
        for again in (copy.deepcopy(scene), pickle.loads(pickle.dumps(scene))):
            assert again.gravity.tolist() == [1.0] * n
            assert again.ground.scene is again

    def test_the_ground_stays(self, kind):
        scene = kind()
        with pytest.raises(AttributeError):
            scene.ground = 3
        assert scene.ground.scene is scene
