"""Matrices of solids from files: written and read back they are the same to the bit; what they cannot be is refused."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy.io import mmwrite
from scipy.sparse import save_npz

import lcpflex as lf
from lcpflex.errors import ModelError, ModelWarning
from tests import solids


@cache
def block() -> dict[str, Any]:
    return solids.block((0.3, 0.2, 0.1), (3, 2, 1), "hex1")


@cache
def known() -> lf.SpatialMatrices:
    return lf.SpatialMatrices(**block(), damping=1e-6 * block()["stiffness"], node_sets={"end": end()})


def end() -> list[int]:
    return np.flatnonzero(block()["coordinates"][:, 0] == 0.0).tolist()


@cache
def labels() -> np.ndarray:
    """Of the nodes in the other program."""
    return 7 * np.random.default_rng(2).permutation(len(block()["coordinates"])) + 11


@cache
def top() -> np.ndarray:
    """The facets at z = .1 m, counter-clockwise seen from above."""
    places = block()["coordinates"]
    corners = [[0, 0], [0.1, 0], [0.1, 0.1], [0, 0.1]]
    found = []
    for x, y in ((x, y) for x in (0.0, 0.1, 0.2) for y in (0.0, 0.1)):
        at = [[x + i, y + j, 0.1] for i, j in corners]
        found.append([int(np.linalg.norm(places - one, axis=1).argmin()) for one in at])
    return np.array(found)


def write(path, matrix, form: str):
    path = path.with_suffix(form)
    if form == ".npz":
        save_npz(path, matrix)
    elif form == ".npy":
        np.save(path, matrix.toarray())
    else:
        mmwrite(path, matrix, symmetry="symmetric", precision=17)
    return path


def written(folder, form: str) -> list[Any]:
    names = ("mass", "stiffness", "damping")
    return [write(folder / name, getattr(known(), name), form) for name in names]


def abaqus(path, matrix, more: str = ""):
    """Entries of the lower half, named by node and degree of freedom."""
    whole = matrix.tocoo()
    lower = whole.row >= whole.col
    lines = [
        f"{labels()[i // 3]}, {i % 3 + 1}, {labels()[j // 3]}, {j % 3 + 1}, {value:.17e}"
        for i, j, value in zip(whole.row[lower], whole.col[lower], whole.data[lower], strict=True)
    ]
    path.write_text("\n".join(["** written by a test", *lines, more]) + "\n")
    return path


def same(one: Any, other: Any) -> bool:
    return (one != other).nnz == 0 and one.shape == other.shape


@pytest.mark.parametrize("form", [".npz", ".npy", ".mtx"])
@pytest.mark.parametrize("numbered", [False, True])
def test_matrices_are_the_same_to_the_bit(tmp_path, form, numbered):
    mass, stiffness, damping = written(tmp_path, form)
    places = block()["coordinates"]
    if numbered:
        table = np.column_stack([labels(), places])
        model = lf.matrices_from_files(
            mass, stiffness, table, {"end": labels()[end()].tolist()}, damping, faces={"top": labels()[top()]}
        )
    else:
        model = lf.matrices_from_files(mass, stiffness, places, {"end": end()}, damping, faces={"top": top()})
    assert isinstance(model, lf.SpatialMatrices)
    for name in ("mass", "stiffness", "damping"):
        assert same(getattr(model, name), getattr(known(), name))
    assert (np.asarray(model.coordinates) == places).all()
    assert (np.asarray(model.faces["top"]) == top()).all()
    assert (model.reduce(6, clamped="end").frequencies() == known().reduce(6, clamped="end").frequencies()).all()


def test_matrix_output_of_abaqus(tmp_path):
    mass, stiffness = abaqus(tmp_path / "M.mtx", known().mass), abaqus(tmp_path / "K.mtx", known().stiffness)
    order = np.argsort(labels())
    places = block()["coordinates"]
    rows = (3 * order[:, None] + np.arange(3)).ravel()
    for coordinates in (np.column_stack([labels(), places]), places[order]):
        model = lf.matrices_from_files(mass, stiffness, coordinates)
        assert isinstance(model, lf.SpatialMatrices)
        assert same(model.mass, known().mass[rows][:, rows])
        assert same(model.stiffness, known().stiffness[rows][:, rows])
    named = lf.matrices_from_files(mass, stiffness, np.column_stack([labels(), places]), faces={"top": labels()[top()]})
    assert np.asarray(named.coordinates)[np.asarray(named.faces["top"])] == pytest.approx(places[top()])


def test_coordinates_from_files_in_millimetres(tmp_path):
    mass, stiffness, _ = written(tmp_path, ".npz")
    np.savetxt(tmp_path / "x.csv", 1e3 * block()["coordinates"], delimiter=",", header="x, y, z")
    np.savetxt(tmp_path / "n.txt", np.column_stack([labels(), 1e3 * block()["coordinates"]]))
    for name in ("x.csv", "n.txt"):
        model = lf.matrices_from_files(mass, stiffness, tmp_path / name, length_unit="mm")
        assert np.asarray(model.coordinates) == pytest.approx(block()["coordinates"], rel=1e-12)


def test_millimetres_tonnes_and_seconds_are_told(tmp_path):
    mass = write(tmp_path / "m", 1e-3 * known().mass, ".npz")
    stiffness = write(tmp_path / "k", 1e-3 * known().stiffness, ".npz")
    with pytest.warns(ModelWarning, match="which no material has: expected N/m, kg and m"):
        lf.matrices_from_files(mass, stiffness, 1e3 * block()["coordinates"])


@pytest.mark.parametrize(
    ("more", "said"),
    [
        ("11,4, 11,4, 1.0", "degree of freedom 4 was found, a rotation of a node of a beam or shell, expected 1, 2"),
        ("11,6, 11,1, 1.0", "degree of freedom 6 was found, a rotation"),
        ("11,7, 11,1, 1.0", "degree of freedom 7 was found, no displacement"),
        ("11,3, 11,3, 1e36", "1e\\+36 at node 11 was found, a support"),
        ("11,1, 11,1, 2.0", "entry \\(11, 1, 11, 1\\) comes twice"),
    ],
)
def test_entries_of_abaqus_that_are_refused(tmp_path, more, said):
    mass = abaqus(tmp_path / "M.mtx", known().mass, more)
    with pytest.raises(ModelError, match=said):
        lf.matrices_from_files(mass, mass, np.column_stack([labels(), block()["coordinates"]]))


def test_dimensions_that_do_not_fit(tmp_path):
    mass, stiffness, _ = written(tmp_path, ".npz")
    places = block()["coordinates"]
    numbered = np.column_stack([labels(), places])
    with pytest.raises(ModelError, match=r"mass: a matrix of 72 rows was given, expected 69, three for .* or 46 if"):
        lf.matrices_from_files(mass, stiffness, places[1:])
    with pytest.raises(ModelError, match=r"mass: .* \(72, 72\) was given, expected \(69, 69\), three rows a node"):
        lf.matrices_from_files(mass, stiffness, numbered[1:])
    with pytest.raises(ModelError, match=r"mass: .* \(72, 72\) was given, expected \(48, 48\), two rows a node"):
        lf.matrices_from_files(mass, stiffness, places[:, :2])
    with pytest.raises(ModelError, match=r"coordinates: .* shape \(24, 5\)"):
        lf.matrices_from_files(mass, stiffness, np.column_stack([numbered, labels()]))
    with pytest.raises(ModelError, match="first of four columns has no whole numbers, or one twice"):
        lf.matrices_from_files(mass, stiffness, np.column_stack([0 * labels(), places]))
    half = write(tmp_path / "half", known().stiffness[:48][:, :48], ".npz")
    with pytest.raises(ModelError, match=r"stiffness: .* \(48, 48\) was given, expected \(72, 72\)"):
        lf.matrices_from_files(mass, half, places)


def test_planar_degrees_of_freedom_with_places_in_space(tmp_path):
    path = tmp_path / "M.mtx"
    path.write_text("1,1, 1,1, 2.0\n1,2, 1,2, 2.0\n2,1, 2,1, 2.0\n2,2, 2,2, 2.0\n")
    with pytest.raises(ModelError, match=r"no degree of freedom 3 was found, expected 1, 2 and 3 with coordinates"):
        lf.matrices_from_files(path, path, [[1, 0.0, 0.0, 0.0], [2, 1.0, 0.0, 0.0]])


@pytest.mark.parametrize(
    ("faces", "said"),
    [
        ({"top": [[11, 18, 25], [11, 18]]}, r"faces\['top'\]: .* was given, expected rows of node numbers"),
        ({"top": [11, 18, 25]}, r"faces\['top'\]: .* expected rows of node numbers"),
        ({"top": [[11, 18, 12]]}, r"faces\['top'\]: node 12 was given, expected nodes of the coordinates"),
        ({"top": [[11.5, 18.0, 25.0]]}, r"faces\['top'\]: .* expected rows"),
        ({"top": [[11, 18, 18]]}, "has a node twice"),
        ([[11, 18, 25]], "faces: .* expected a mapping from names"),
    ],
)
def test_faces_that_are_refused(tmp_path, faces, said):
    mass, stiffness, _ = written(tmp_path, ".npz")
    with pytest.raises(ModelError, match=said):
        lf.matrices_from_files(mass, stiffness, np.column_stack([labels(), block()["coordinates"]]), faces=faces)


def test_faces_of_a_planar_body(tmp_path):
    path = write(tmp_path / "m", known().mass[:8][:, :8], ".npz")
    with pytest.raises(ModelError, match=r"faces: \['top'\] were given, expected none of a body in the plane"):
        lf.matrices_from_files(path, path, block()["coordinates"][:4, :2], faces={"top": [[0, 1, 2]]})
