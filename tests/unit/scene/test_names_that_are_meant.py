"""What a user of another scene, program or version types is answered with what it is called here."""

import copy
import pickle

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.errors import ModelError
from tests import libs

BEAM = lf.SpatialBeam(1.0, 1e-4, (1e-9, 1e-9), 2e-9, 7800.0, 2e11, 0.3)


@pytest.fixture(scope="module")
def result():
    scene = lf.Scene()
    scene.add(lf.Disc(0.1, mass=1.0), name="disc", position=(0.0, 0.1))
    scene.ground.half_plane((0.0, 0.0), (0.0, 1.0))
    scene.contact_all(friction=0.3)
    scene.sensor(lf.sensors.Energy(name="E"))
    return lf.simulate(scene, 0.01, lf.MoreauJean(step=1e-3), progress=False)


class TestAttributes:
    @pytest.mark.parametrize(
        ("of", "name", "words"),
        [
            (lambda: lf.SpatialScene(), "slot", "slots are planar"),
            (lambda: lf.SpatialScene(), "contact_slot", "slots are planar"),
            (lambda: lf.SpatialScene(), "jion", "did you mean 'join'"),
            (lambda: lf.Scene(), "slot", "scene.contact_slot"),
            (lambda: lf.Scene(), "contact_al", "did you mean 'contact_all'"),
            (lambda: lf.SpatialScene().ground, "half_plane", r"plane\(point, normal\)"),
            (lambda: lf.SpatialScene().ground, "straight_slot", "slots are planar"),
            (lambda: lf.SpatialScene().ground, "chain", "box"),
            (lambda: lf.SpatialScene().add(lf.Sphere(1.0, 1.0)), "circle", "sphere"),
            (lambda: lf.Scene().ground, "plane", "half_plane"),
            (lambda: lf.Scene().add(lf.Disc(1.0, mass=1.0)), "sphere", "circle"),
            (lambda: lf.Scene().ground, "halfplane", "did you mean 'half_plane'"),
        ],
    )
    def test_of_scenes(self, of, name, words):
        with pytest.raises(AttributeError, match=f"no attribute '{name}': .*{words}"):
            getattr(of(), name)

    @pytest.mark.parametrize("name", ["t", "time", "ts", "instants"])
    def test_times(self, result, name):
        contact = result.contact("disc.outline/ground.half_plane1")
        for one in (result, contact, result.sensor("E")):
            with pytest.raises(AttributeError, match=f"no attribute '{name}': did you mean 'times'"):
                getattr(one, name)
        with pytest.raises(AttributeError, match="no attribute 't': did you mean 'time'"):
            _ = result.at(0.005).t

    def test_of_the_state_that_forces_are_asked_at(self):
        scene = lf.Scene()
        disc = scene.add(lf.Disc(0.1, mass=1.0), name="disc")
        scene.load(lf.Force(disc.at(0.0, 0.0), lambda t, state: (state.t, 0.0)))
        with pytest.raises(ModelError, match="no attribute 't': did you mean 'time'"):
            lf.simulate(scene, 0.01, lf.MoreauJean(step=1e-3), progress=False)

    def test_errors_of_properties_stay_what_they_are(self):
        class Broken(lf.Scene):
            @property
            def best(self):
                return None.nothing

        with pytest.raises(AttributeError, match="'NoneType' object has no attribute 'nothing'"):
            _ = Broken().best

    def test_what_tools_ask_for(self, result):
        scene = lf.SpatialScene()
        for one in (scene, scene.ground, result):
            assert not hasattr(one, "_repr_html_")
            assert not hasattr(one, "__wrapped__")
            copy.copy(one)
        assert pickle.loads(pickle.dumps(scene)).ground.name == "ground"


class TestAddInSpace:
    @pytest.mark.parametrize(
        ("body", "given", "words"),
        [
            (lf.Sphere(1.0, 1.0), {"modes": 4}, r"modes: it was given for a SpatialBody, .* such as Solid\(...\)"),
            (lf.Sphere(1.0, 1.0), {"angle": 0.3}, "orientation=Rotation.from_rotvec"),
            (BEAM.reduce(modes=2), {"contact_nodes": 3}, "contact_nodes: it was given for a SpatialBody"),
            (BEAM.reduce(modes=2), {"stiffening": lf.Stiffening()}, "stiffening: it was given for a SpatialBody"),
            (BEAM, {}, "modes: none were given for SpatialBeam, expected a number of free modes, modes=8"),
            (lf.Beam(1.0, 0.1, 0.1, 7800.0, 2e11), {"modes": 8}, "planar ones belong into a Scene"),
        ],
    )
    def test_what_the_plane_has_is_told(self, body, given, words):
        scene = lf.SpatialScene()
        with pytest.raises(ModelError, match=words):
            scene.add(body, **given)
        assert scene.parts().placed == ()

    def test_what_none_has(self):
        with pytest.raises(TypeError, match="unexpected keyword argument 'colour'"):
            lf.SpatialScene().add(lf.Sphere(1.0, 1.0), colour="red")


class TestTables:
    @pytest.mark.parametrize("values", [[[0.0, 1.0], [2.0, 3.0]], np.zeros((2, 1)), np.zeros((2, 3))])
    def test_of_vectors(self, values):
        with pytest.raises(ModelError, match=r"Table: values: .*expected \(2,\), one number for each time; each comp"):
            lf.Table([0.0, 1.0], values)

    def test_what_it_tells_works(self):
        scene = lf.Scene(gravity=(0.0, 0.0))
        disc = scene.add(lf.Disc(0.1, mass=1.0), name="disc")
        scene.load(lf.Force(disc.at(0.0, 0.0), (lf.Table([0.0, 1.0], [1.0, 1.0]), lf.Table([0.0, 1.0], [0.0, 2.0]))))
        result = lf.simulate(scene, 1.0, lf.MoreauJean(step=1e-3), progress=False)
        assert result.u[-1, :2] == pytest.approx([1.0, 1.0])

    def test_of_times_in_two_dimensions(self):
        with pytest.raises(ModelError, match=r"Table: times: .*expected shape \(n,\)"):
            lf.Table([[0.0, 1.0]], [0.0, 1.0])


@pytest.mark.parametrize("kind", ["Tri", "Quad"])
class TestMeshesOfCorners:
    """A quadratic class on the corners of a quadratic mesh ended in IndexError."""

    @staticmethod
    def of_corners(kind):
        whole = lf.meshes.rectangle(1.0, 0.1, 4, 2, triangles=kind == "Tri")
        corners = np.asarray(whole.p)[:, : whole.nvertices]
        return getattr(libs.skfem, f"Mesh{kind}2")(corners, whole.t), corners, whole.t

    def test_every_reader_of_it(self, kind):
        broken, _, _ = self.of_corners(kind)
        words = rf"Mesh{kind}2 with 15 places .* 45 nodes.* skfem.Mesh{kind}1\(p, t\)"
        with pytest.raises(ModelError, match=words):
            lf.Continuum(broken, density=1e3, youngs_modulus=1e9, poissons_ratio=0.3).reduce(modes=2)
        with pytest.raises(ModelError, match=words):
            lf.meshes.quadratic(broken)
        if kind == "Tri":
            with pytest.raises(ModelError, match=words):
                lf.meshes.graded(broken, (0.0, 0.0), 0.01)

    def test_what_it_tells_works(self, kind):
        _, p, t = self.of_corners(kind)
        mesh = lf.meshes.quadratic(getattr(libs.skfem, f"Mesh{kind}1")(p, t))
        body = lf.Continuum(mesh, density=1e3, youngs_modulus=1e9, poissons_ratio=0.3).reduce(modes=2)
        assert body.mass == pytest.approx(100.0)


class TestAdmissibleMotions:
    """One solution is listed once, and what rests in several ways does one thing."""

    @staticmethod
    def pressed(body, force, friction=0.3, scale=1.0):
        scene = lf.Scene(gravity=(0.0, -9.81 * scale))
        placed = scene.add(body, name="body", position=(0.0, 0.1 * scale))
        scene.ground.half_plane((0.0, 0.0), (0.0, 1.0))
        scene.contact_all(friction=friction)
        scene.load(lf.Force(placed.at(0.0, 0.0), force))
        return lf.admissible_accelerations(scene, gap_tolerance=1e-9 * scale, velocity_threshold=1e-6 * scale)

    @pytest.mark.parametrize("scale", [1.0, 1000.0])
    @pytest.mark.parametrize("up", [9.81, 12.0, 1e3])
    @pytest.mark.parametrize("along", [0.0, 3.0])
    def test_what_lifts_off_does_so_once(self, scale, up, along):
        if up == 9.81 and along:
            return
        force = (along * scale, up * scale)
        for body in (lf.Disc(0.1 * scale, mass=1.0), lf.Box(0.2 * scale, 0.2 * scale, mass=1.0)):
            found = self.pressed(body, force, scale=scale)
            assert (found.count, len(found.solutions), found.forces_unique) == ("unique", 1, True)

    @pytest.mark.parametrize("along", [0.0, 0.5, 1.0, -1.0])
    def test_a_box_at_rest_rests_in_one_way(self, along):
        found = self.pressed(lf.Box(0.2, 0.2, mass=1.0), (along, 0.0))
        assert (found.count, found.forces_unique) == ("unique", False)
        first, second = (one.force for one in found.solutions)
        assert np.abs(first - second).max() > 0.1

    def test_a_tilted_rod_that_jams_does_several(self):
        found = lf.admissible_accelerations(lf.gallery.painleve_rod(1.4, 60.0, 1.2))
        assert found.count == "several"
        accelerations = [one.acceleration.tobytes() for one in found.solutions]
        assert len(set(accelerations)) == len(accelerations) == 2
