"""Meshes in other units than metres, and those whose numbers can hardly be metres."""

import contextlib
import io
import warnings
from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.errors import ModelError, ModelWarning
from tests import libs

STEEL = (7800.0, 2e11, 0.3)
ALUMINIUM = (2700.0, 7e10, 0.33)
CONCRETE = (2400.0, 3e10, 0.2)
RUBBER = (1100.0, 5e6, 0.45)
UNITS = {"m": 1.0, "cm": 0.01, "mm": 0.001, "um": 1e-6, "in": 0.0254, "ft": 0.3048, 2.5: 2.5}

pytestmark = pytest.mark.filterwarnings("ignore:mesh.* its stiffness:lcpflex.errors.ModelWarning")  # coarse on purpose


def strip(length=100.0, height=2.3, nx=20):
    return lf.meshes.rectangle(length, height, nx, 2)


def saved(path, mesh):
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
        mesh.save(path)
    return path


SENSIBLE: dict[str, Any] = {  # meshes are made when they are asked for: skfem is dear
    "a watch spring": (lambda: strip(0.02, 1e-4), STEEL, 1e-4),
    "a beam of a machine": (lambda: strip(3.0, 0.1), STEEL, 0.05),
    "the frame of a press": (lambda: lf.meshes.rectangle(8.0, 4.0, 8, 4), STEEL, 0.3),
    "a web of a bridge": (lambda: strip(100.0, 2.3), STEEL, 0.02),
    "a wind turbine's tower": (lambda: strip(120.0, 4.0), STEEL, 0.03),
    "a forged shaft": (lambda: strip(12.0, 2.0), STEEL, 2.0),
    "a wall of concrete": (lambda: strip(40.0, 10.0), CONCRETE, 0.3),
    "a dam": (lambda: lf.meshes.rectangle(60.0, 80.0, 4, 4), CONCRETE, 100.0),
    "a seal": (lambda: strip(0.1, 0.01), RUBBER, 1.0),
    "numbers without units": (lambda: strip(100.0, 10.0), (1.0, 1.0, 0.3), 1.0),
    "a micromachine": (lambda: strip(1e-4, 1e-6), (2330.0, 1.6e11, 0.2), 1e-6),
}


class TestUnits:
    @pytest.mark.parametrize("unit", UNITS)
    @pytest.mark.parametrize("from_file", [True, False])
    def test_a_mesh_in_it_is_the_body_in_metres(self, tmp_path, unit, from_file):
        factor = UNITS[unit]
        mesh, scaled = strip(0.1, 0.0023), strip(0.1 / factor, 0.0023 / factor)
        given = saved(tmp_path / "mesh.vtu", scaled) if from_file else scaled
        body = lf.Continuum(given, *STEEL, thickness=0.01, length_unit=unit).reduce(modes=3)
        known = lf.Continuum(mesh, *STEEL, thickness=0.01).reduce(modes=3)
        assert body.mass == pytest.approx(known.mass, rel=1e-12)
        assert body.frequencies() == pytest.approx(known.frequencies(), rel=1e-9)
        assert body.surfaces["outline"].points[0].place == pytest.approx(known.surfaces["outline"].points[0].place)

    def test_sets_are_in_metres(self):
        body = lf.Continuum(strip(), *STEEL, length_unit="mm", sets={"end": lambda x, y: x > 0.0999})
        assert len(body.finite_elements().sets["end"]) == 5

    def test_solids_of_revolution(self):
        mesh, scaled = (lf.meshes.half_section_of_rod(s * 0.1, s * 0.01, s * 0.005) for s in (1.0, 1000.0))
        body = lf.SolidOfRevolution(scaled, *STEEL, length_unit="mm").reduce(modes=2)
        known = lf.SolidOfRevolution(mesh, *STEEL).reduce(modes=2)
        assert body.mass == pytest.approx(known.mass, rel=1e-12)
        assert body.frequencies() == pytest.approx(known.frequencies(), rel=1e-9)

    @pytest.mark.filterwarnings("ignore")
    def test_coordinates_of_matrices(self, tmp_path):
        elements = lf.Continuum(strip(0.1, 0.0023), *STEEL).finite_elements()
        for name, matrix in (("M", elements.mass), ("K", elements.stiffness)):
            np.save(tmp_path / f"{name}.npy", matrix.toarray())
        files = tmp_path / "M.npy", tmp_path / "K.npy"
        known = lf.matrices_from_files(*files, elements.places)
        inches = lf.matrices_from_files(*files, elements.places / 0.0254, length_unit="in")
        assert inches.finite_elements().places == pytest.approx(known.finite_elements().places, rel=1e-14)
        assert inches.reduce(modes=2).inertia == pytest.approx(known.reduce(modes=2).inertia)

    def test_one_metre_changes_no_bit(self):
        for unit in ("m", 1, 1.0):
            one = lf.Continuum(strip(0.1, 0.0023), *STEEL, length_unit=unit).finite_elements()
            other = lf.Continuum(strip(0.1, 0.0023), *STEEL).finite_elements()
            assert one.places.tobytes() == other.places.tobytes()
            assert one.stiffness.data.tobytes() == other.stiffness.data.tobytes()

    @pytest.mark.parametrize("unit", ["millimetre", "", "MM", 0.0, -1.0, np.nan, np.inf, True, [1.0], "0.001"])
    def test_what_is_no_unit(self, unit):
        with pytest.raises(ModelError, match="length_unit"):
            lf.Continuum(strip(), *STEEL, length_unit=unit)
        with pytest.raises(ModelError, match="length_unit"):
            lf.SolidOfRevolution(lf.meshes.half_section_of_rod(1.0, 0.1, 0.1), *STEEL, length_unit=unit)


class TestSuspects:
    @pytest.mark.parametrize("material", [STEEL, ALUMINIUM])
    @pytest.mark.parametrize(("length", "height"), [(100.0, 2.3), (400.0, 3.0), (60.0, 40.0), (1e4, 500.0)])
    def test_a_body_in_millimetres(self, material, length, height):
        with pytest.warns(ModelWarning, match="are its places in mm. length_unit='mm' makes it"):
            lf.Continuum(strip(length, height), *material, thickness=10.0)

    def test_it_tells_the_first_frequency(self):
        with pytest.warns(
            ModelWarning, match=r"100 m long and 2\.2\d m wide .* about 1\.2 Hz .* 0\.1 m long, with 1\.2"
        ):
            body = lf.Continuum(strip(nx=40), *STEEL)
        assert body.reduce(modes=1).frequencies()[0] / (2.0 * np.pi) == pytest.approx(1.18, abs=0.04)

    @pytest.mark.parametrize("material", [STEEL, ALUMINIUM, RUBBER])
    def test_files_are_suspected_sooner(self, tmp_path, material):
        path = saved(tmp_path / "thin.vtu", strip(50.0, 1.5))
        with pytest.warns(ModelWarning, match=r"thin.vtu.*length_unit='mm'"):
            lf.Continuum(path, *material, thickness=0.01)

    def test_half_sections(self):
        with pytest.warns(ModelWarning, match="length_unit='mm'"):
            lf.SolidOfRevolution(lf.meshes.half_section_of_rod(100.0, 20.0, 10.0), *STEEL)

    @pytest.mark.parametrize("unit", ["m", 1.0, "mm", "ft"])
    def test_one_who_says_it_means_it(self, tmp_path, unit):
        with warnings.catch_warnings():
            warnings.simplefilter("error", ModelWarning)
            lf.Continuum(saved(tmp_path / "x.vtu", strip(200.0, 80.0)), *STEEL, length_unit=unit)

    @pytest.mark.parametrize("name", SENSIBLE)
    def test_what_is_sensible_is_left_in_peace(self, name):
        mesh, material, thickness = SENSIBLE[name]
        with warnings.catch_warnings():
            warnings.simplefilter("error", ModelWarning)
            warnings.filterwarnings("ignore", message="mesh.* its stiffness")
            lf.Continuum(mesh(), *material, thickness=thickness)

    @pytest.mark.parametrize("name", ["a beam of a machine", "a wall of concrete", "a dam", "a seal"])
    def test_from_a_file_too(self, tmp_path, name):
        mesh, material, thickness = SENSIBLE[name]
        with warnings.catch_warnings():
            warnings.simplefilter("error", ModelWarning)
            warnings.filterwarnings("ignore", message="mesh.* its stiffness")
            lf.Continuum(saved(tmp_path / "x.vtu", mesh()), *material, thickness=thickness)


BOXES: dict[str, Any] = {  # sizes and materials of solids that are sensible
    "a watch spring": ((0.02, 1e-3, 1e-4), STEEL),
    "the frame of a press": ((8.0, 4.0, 1.5), STEEL),
    "a plate of a bridge": ((100.0, 20.0, 0.03), STEEL),
    "a wall of concrete": ((40.0, 10.0, 0.3), CONCRETE),
    "a dam": ((60.0, 80.0, 50.0), CONCRETE),
    "a seal": ((0.1, 0.01, 0.01), RUBBER),
    "numbers without units": ((100.0, 10.0, 10.0), (1.0, 1.0, 0.3)),
}


def solid_box(sizes, material, **more):
    density, youngs_modulus, poissons_ratio = material
    return lf.Solid.box(
        sizes, max(sizes) / 4.0, density=density, youngs_modulus=youngs_modulus, poissons_ratio=poissons_ratio, **more
    )


class TestSolids:
    @pytest.mark.parametrize("material", [STEEL, ALUMINIUM])
    @pytest.mark.parametrize(
        ("sizes", "width"), [((100.0, 23.0, 20.0), 14.5), ((400.0, 30.0, 30.0), 21.7), ((60.0, 40.0, 8.0), 9.0)]
    )
    def test_one_in_millimetres(self, sizes, width, material):
        """3 V / A: 3 * 60 * 40 * 8 / (2 (60 * 40 + 60 * 8 + 40 * 8)) = 9."""
        words = rf"{sizes[0]:.0f} m long and {width:g} m wide in the mean.*length_unit='mm' makes it"
        with pytest.warns(ModelWarning, match=words):
            solid_box(sizes, material)

    @pytest.mark.parametrize("name", BOXES)
    def test_what_is_sensible_is_left_in_peace(self, name):
        with warnings.catch_warnings():
            warnings.simplefilter("error", ModelWarning)
            solid_box(*BOXES[name])

    def test_one_who_says_it_means_it(self):
        with warnings.catch_warnings():
            warnings.simplefilter("error", ModelWarning)
            solid_box((100.0, 23.0, 20.0), STEEL, length_unit="m")

    @pytest.mark.parametrize("unit", UNITS)
    def test_a_shape_in_it_is_the_body_in_metres(self, unit):
        factor = UNITS[unit]
        given = solid_box((0.1 / factor, 0.02 / factor, 0.03 / factor), STEEL, length_unit=unit).finite_elements()
        known = solid_box((0.1, 0.02, 0.03), STEEL).finite_elements()
        assert given.places == pytest.approx(known.places, rel=1e-12, abs=1e-16)
        assert given.stiffness.diagonal() == pytest.approx(known.stiffness.diagonal(), rel=1e-9)

    def test_tetrahedra_have_the_width_of_their_boundary(self):
        mesh = libs.skfem.MeshTet2.from_mesh(libs.skfem.MeshTet().refined(2).scaled((60.0, 40.0, 8.0)))
        with pytest.warns(ModelWarning, match="60 m long and 9 m wide in the mean"):
            lf.Solid(mesh, *STEEL)
