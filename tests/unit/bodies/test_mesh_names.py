"""Surfaces of meshes and named nodes: orientation, holes, mid-side nodes; points, sets and chains; what is refused."""

from __future__ import annotations

import numpy as np
import pytest

from lcpflex.bodies.continuum import Continuum
from lcpflex.bodies.fem import meshes
from lcpflex.bodies.solid_of_revolution import SolidOfRevolution
from lcpflex.errors import ModelError, ModelWarning
from tests import libs

pytestmark = pytest.mark.filterwarnings("ignore:mesh. its stiffness:lcpflex.errors.ModelWarning")  # coarse on purpose

STEEL = (7800.0, 2e11, 0.3)


def area(chain) -> float:
    x, y = np.array([point.place for point in chain.points]).T
    return 0.5 * float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))


def plate_with_hole(quadratic: bool):
    mesh = meshes.rectangle(5.0, 5.0, 5, 5, order=1)
    mesh = mesh.remove_elements(
        mesh.elements_satisfying(lambda at: (abs(at[0] - 2.5) < 0.1) & (abs(at[1] - 2.5) < 0.1))
    )
    return meshes.quadratic(mesh) if quadratic else mesh


@pytest.mark.parametrize("quadratic", [False, True])
def test_outline_is_counter_clockwise_and_holes_are_clockwise(quadratic):
    body = Continuum(plate_with_hole(quadratic), *STEEL).reduce(0)
    outline, hole = body.surfaces["outline"], body.surfaces["hole1"]
    assert outline.closed
    assert hole.closed
    assert len(outline.points) == 20 * (1 + quadratic)
    assert len(hole.points) == 4 * (1 + quadratic)
    assert area(outline) == pytest.approx(25.0)
    assert area(hole) == pytest.approx(-1.0)
    steps = np.diff(np.array([p.place for p in outline.points]), axis=0)
    assert np.hypot(*steps.T) == pytest.approx(0.5 if quadratic else 1.0)  # no node is left out


def test_holes_are_numbered_from_left_to_right():
    mesh = meshes.rectangle(7.0, 3.0, 7, 3, order=1)
    holes = lambda at: (abs(at[1] - 1.5) < 0.1) & ((abs(at[0] - 5.5) < 0.1) | (abs(at[0] - 1.5) < 0.1))  # noqa: E731
    body = Continuum(mesh.remove_elements(mesh.elements_satisfying(holes)), *STEEL).reduce(0)
    middles = [np.mean([p.place[0] for p in body.surfaces[name].points]) for name in ("hole1", "hole2")]
    assert middles == pytest.approx([1.5, 5.5])


@pytest.mark.parametrize("triangles", [True, False])
@pytest.mark.parametrize("quadratic", [False, True])
def test_sides_of_a_rectangle_run_with_the_solid_on_their_left(triangles, quadratic):
    mesh = meshes.rectangle(3.0, 2.0, 3, 2, triangles=triangles, order=1 + quadratic)
    body = Continuum(mesh, *STEEL).reduce(0)
    ends = {name: (c.points[0].place.tolist(), c.points[-1].place.tolist()) for name, c in body.surfaces.items()}
    assert ends["bottom"] == ([0.0, 0.0], [3.0, 0.0])
    assert ends["right"] == ([3.0, 0.0], [3.0, 2.0])
    assert ends["top"] == ([3.0, 2.0], [0.0, 2.0])
    assert ends["left"] == ([0.0, 2.0], [0.0, 0.0])
    assert len(body.surfaces["bottom"].points) == 3 * (1 + quadratic) + 1


def test_what_a_set_becomes():
    sets = {
        "tip": lambda x, y: (x == 3.0) & (y == 1.0),
        "scalar": lambda x, y: x == 3.0 and y > 0.5,  # written for numbers
        "area": lambda x, y: x < 1.5,
        "ends": lambda x, y: (x == 0.0) | (x == 3.0),
        "numbers": [0, 1, 2],
        "pair": np.array([0, 1]),
        "same as right": "right",
        "around": lambda x, y: (x == 0.0) | (x == 3.0) | (y == 0.0) | (y == 2.0),
        "number": 4,
    }
    model = Continuum(meshes.rectangle(3.0, 2.0, 3, 2, order=1), *STEEL, sets=sets)
    mesh = model.finite_elements()
    assert mesh.places[mesh.points["tip"]] == pytest.approx([3.0, 1.0])
    assert mesh.places[mesh.chains["scalar"][0]].tolist() == [[3.0, 1.0], [3.0, 2.0]]
    assert "area" not in mesh.chains
    assert len(mesh.sets["area"]) == 6
    assert "ends" not in mesh.chains  # two rows are no surface
    assert len(mesh.sets["ends"]) == 6
    assert mesh.chains["same as right"][0].tolist() == mesh.chains["right"][0].tolist()
    assert mesh.chains["around"][1]
    assert sorted(mesh.chains["around"][0]) == sorted(mesh.chains["outline"][0])
    assert mesh.points["number"] == 4
    assert mesh.places[mesh.chains["pair"][0]].tolist() == mesh.places[[1, 0]].tolist()  # x = 0, walked downwards
    assert set(mesh.sets) == {*sets, "left", "right", "bottom", "top", "outline"}


def raising(x, y):
    raise ZeroDivisionError("no")


@pytest.mark.parametrize(
    ("value", "said"),
    [
        ([], "expected a predicate"),
        ([0, 99], "node 99 was given, expected nodes from 0 to 11"),
        ([-1], "node -1"),
        ([0.5], "expected a predicate"),
        ([[0, 1], [2]], "expected a predicate"),
        (None, "expected a predicate"),
        (True, "expected a predicate"),
        ("rihgt", "expected a group of the mesh .*'right'"),
        (lambda x, y: x > 7.0, "no node fulfils the predicate.*0 <= x <= 3"),
        (lambda x, y: 1.0, "gave 1.0 at"),
        (lambda x, y: np.where(x > 1.0, 1, 0), "gave an array of int64, expected bool"),
        (np.array([True, False]), "expected a predicate"),
        (lambda x: x > 0.0, "the predicate raised TypeError"),
        (raising, "the predicate raised ZeroDivisionError"),
    ],
)
def test_sets_that_are_none(value, said):
    with pytest.raises(ModelError, match=rf"sets\['bad'\]: .*{said}"):
        Continuum(meshes.rectangle(3.0, 2.0, 3, 2, order=1), *STEEL, sets={"bad": value})


def test_names_of_loops_are_taken():
    with pytest.raises(ModelError, match="'outline' was given, expected another one"):
        Continuum(meshes.rectangle(3.0, 2.0, 3, 2, order=1), *STEEL, sets={"outline": [0]})
    with pytest.raises(ModelError, match=r"sets: .*expected a mapping"):
        Continuum(meshes.rectangle(3.0, 2.0, 3, 2, order=1), *STEEL, sets=["tip"])


@pytest.mark.parametrize(
    ("numbers", "said"),
    [
        ({"density": 0.0}, "density: 0"),
        ({"density": float("nan")}, "density: nan"),
        ({"youngs_modulus": -1.0}, "youngs_modulus: -1"),
        ({"youngs_modulus": "2e11 Pa"}, "youngs_modulus: '2e11 Pa'"),
        ({"poissons_ratio": 0.5}, "poissons_ratio: 0.5 .*-1, 0.5"),
        ({"poissons_ratio": -1.0}, "poissons_ratio: -1"),
        ({"thickness": 0.0}, "thickness: 0"),
        ({"plane_strain": 1}, "plane_strain: 1 was given, expected True or False"),
        ({"mesh": "no such file.msh"}, "'no such file.msh' was given, expected the name of a file that is there"),
        ({"mesh": None}, "mesh: None was given, expected a scikit-fem mesh"),
    ],
)
def test_numbers_and_meshes_that_cannot_be(numbers, said):
    given = {
        "mesh": meshes.rectangle(1.0, 1.0, 1, 1, order=1),
        "density": 7800.0,
        "youngs_modulus": 2e11,
        "poissons_ratio": 0.3,
    }
    with pytest.raises(ModelError, match=said):
        Continuum(**{**given, **numbers})


@pytest.mark.parametrize(
    ("kind", "said"),
    [("MeshTet", "MeshTet1 was given, expected a scikit-fem mesh"), ("MeshLine", "MeshLine1 was given")],
)
def test_meshes_that_are_not_of_the_plane(kind, said):
    with pytest.raises(ModelError, match=said):
        Continuum(getattr(libs.skfem, kind)(), 7800.0, 2e11, 0.3)


def quads(places, *cells):
    """What makes the mesh."""
    return lambda: libs.skfem.MeshQuad1(np.array(places, dtype=float).T, np.array(cells).T)


SQUARE = [[0, 0], [1, 0], [1, 1], [0, 1]]


@pytest.mark.parametrize(
    ("mesh", "said"),
    [
        (quads([*SQUARE, [3, 0], [4, 0], [4, 1], [3, 1]], [0, 1, 2, 3], [4, 5, 6, 7]), "2 parts that share no edge"),
        (quads([*SQUARE, [2, 1], [2, 2], [1, 2]], [0, 1, 2, 3], [2, 4, 5, 6]), "2 parts that share no edge"),
        (quads([[0, 0], [1, 0], [2, 0], [3, 0]], [0, 1, 2, 3]), "element 0 .* has the area 0"),
        (quads([[0, 0], [1, 0], [1, 1], [0.9, 0.1]], [0, 1, 2, 3]), "is folded"),
        (quads([[0, 0], [1, 1], [1, 0], [0, 1.5]], [0, 1, 2, 3]), "is folded"),
        (quads(SQUARE[:3], [0, 1, 2, 2]), "a node twice"),
        (quads(SQUARE, [0, 1, 2, 3], [0, 1, 2, 3]), "on the same side of an edge"),
        (quads([*SQUARE, [0.5, 2], [1, 2]], [0, 1, 2, 3], [3, 2, 5, 4], [3, 2, 5, 4]), "share an edge"),
        (quads([[0, 0], [np.nan, 0], [1, 1], [0, 1]], [0, 1, 2, 3]), "nan"),
        (quads(SQUARE, [0, 1, 2, 9]), "1 elements on 4 nodes, expected elements on nodes that are there"),
        (quads(SQUARE, [0, 1, 2, -1]), "expected elements on nodes that are there"),
        (lambda: libs.skfem.MeshTri1(np.zeros((2, 3)), np.zeros((3, 0), dtype=int)), "0 elements on 3 nodes"),
    ],
)
def test_meshes_that_are_no_body(mesh, said):
    with pytest.raises(ModelError, match=said):
        Continuum(mesh(), *STEEL)


def test_a_boundary_that_touches_itself_is_refused():
    mesh = meshes.rectangle(4.0, 4.0, 4, 4, order=1)
    two = lambda at: (abs(at[0] - at[1]) < 0.1) & (abs(at[0] - 2.0) < 0.9)  # noqa: E731  # two holes that share a corner
    with pytest.raises(ModelError, match="touch at one node only"):
        Continuum(mesh.remove_elements(mesh.elements_satisfying(two)), *STEEL)


def test_a_mid_side_node_far_from_the_middle_folds_its_element():
    mesh = meshes.rectangle(1.0, 1.0, 1, 1)
    places = mesh.doflocs.copy()
    places[:, 4] += [0.0, 0.9]
    with pytest.raises(ModelError, match="is folded"):
        Continuum(libs.skfem.MeshQuad2(places, mesh.t), *STEEL)


def test_clockwise_elements_are_turned_around():
    good = Continuum(meshes.rectangle(3.0, 2.0, 3, 2, order=1), *STEEL).reduce(4)
    mesh = meshes.rectangle(3.0, 2.0, 3, 2, order=1)
    cells = mesh.t.copy()
    cells[:, ::2] = cells[::-1, ::2]
    turned = Continuum(libs.skfem.MeshQuad1(mesh.p, cells), *STEEL).reduce(4)
    assert turned.frequencies() == pytest.approx(good.frequencies(), rel=1e-10)
    assert area(turned.surfaces["outline"]) == pytest.approx(6.0)


def test_unused_nodes_are_left_out_with_a_warning():
    mesh = libs.skfem.MeshQuad1(np.array([[9.0, 9.0], *SQUARE], dtype=float).T, np.array([[1, 2, 3, 4]]).T)
    with pytest.warns(ModelWarning, match="node 0 without an element left out"):
        model = Continuum(mesh, *STEEL, sets={"corner": 0})
    assert model.finite_elements().places.tolist() == np.array(SQUARE, dtype=float).tolist()


@pytest.mark.parametrize(
    ("density", "modulus", "said"),
    [
        (7800.0, 210.0, "GPa"),
        (7800.0, 210e3, "MPa"),
        (7.8, 2.1e11, "g/cm"),
        (7.8e-9, 2.1e5, "N, mm and t"),
        (1000.0, 0.01, "a modulus in|in Pa"),
    ],
)
def test_units_that_do_not_fit_are_named(density, modulus, said):
    with pytest.warns(ModelWarning, match=rf"give waves of .*{said}"):
        Continuum(meshes.rectangle(1.0, 1.0, 1, 1, order=1), density, modulus, 0.3)


@pytest.mark.parametrize(("density", "modulus"), [(7800.0, 2.1e11), (1100.0, 1e6), (3500.0, 1.05e12), (160.0, 1e8)])
def test_steel_rubber_diamond_and_balsa_raise_no_warning(density, modulus):
    Continuum(meshes.rectangle(1.0, 1.0, 1, 1, order=1), density, modulus, 0.3)


def test_linear_elements_that_lock_are_told():
    """Free bending in plane strain, 4 elements across: linear ones are 32 % too stiff, quadratic ones are not."""
    bar = meshes.bar(1.0, 0.1, 40, across=4, order=1)
    with pytest.warns(ModelWarning, match=r"poissons_ratio: 0\.49 .*they lock"):
        locked = Continuum(bar, 1000.0, 1e9, 0.49, plane_strain=True).reduce(1)
    right = Continuum(meshes.quadratic(bar), 1000.0, 1e9, 0.49, plane_strain=True).reduce(1)
    assert locked.frequencies() > 1.2 * right.frequencies()
    section = meshes.rectangle(1.0, 0.1, 8, 2, order=1)
    with pytest.warns(ModelWarning, match="they lock"):
        SolidOfRevolution(section, 1000.0, 1e9, 0.49)
    Continuum(section, 1000.0, 1e9, 0.49)  # plane stress: free to get thinner


def test_a_place_off_the_body_is_refused_with_the_nearest_one():
    body = Continuum(plate_with_hole(False), *STEEL).reduce(2)
    with pytest.raises(ModelError, match=r"\(2.4, 2.5\) was given.*\(2, 2.5\) is nearest"):
        body.locate(2.4, 2.5)
    with pytest.raises(ModelError, match=r"\(6, 1.2\) was given.*\(5, 1.2\) is nearest"):
        body.locate(6.0, 1.2)


def around_a_triangle():
    """Three triangles within a triangle, around a fourth one 3-4-5 in its middle, and the cells but that one."""
    places = np.array([[0.0, 0], [4, 0], [0, 4], [1, 1], [2, 1], [1, 2]])
    return places, [[0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4], [2, 0, 3], [2, 3, 5]]


def test_a_node_that_hangs_on_an_edge_is_refused():
    places, cells = around_a_triangle()
    places = np.vstack([places, [1.5, 1.0]])  # amid the edge 3-4, of which the element below knows nothing
    mesh = libs.skfem.MeshTri1(places.T, np.array([*cells, [3, 6, 5], [6, 4, 5]]).T)
    with pytest.raises(ModelError, match=r"a node hangs on an edge at \(1, 1\), expected elements that share whole"):
        Continuum(mesh, *STEEL)


def test_a_slit_is_told():
    places, cells = around_a_triangle()
    mid = [[1.5, 1.0], [1.5, 1.0]]
    cells = [[0, 1, 4], [0, 4, 6], [0, 6, 3], *cells[2:], [3, 7, 5], [7, 4, 5]]
    mesh = libs.skfem.MeshTri1(np.vstack([places, mid]).T, np.array(cells).T)
    with pytest.warns(ModelWarning, match=r"it has a slit at \(1, 1\)"):
        body = Continuum(mesh, *STEEL).reduce(1)
    assert area(body.surfaces["hole1"]) == pytest.approx(0.0, abs=1e-12)
