"""Matrices from files: Matrix Market, npz, the matrix output of Abaqus in all its halves; forms that are refused."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from scipy.io import mmwrite
from scipy.sparse import save_npz

from lcpflex.bodies import Matrices
from lcpflex.bodies.continuum import Continuum
from lcpflex.bodies.fem import meshes
from lcpflex.bodies.fem.matrix_files import matrices_from_files
from lcpflex.errors import ModelError


@cache
def grid():
    return Continuum(meshes.rectangle(2.0, 1.0, 4, 2, order=1), 7800.0, 2e11, 0.3).finite_elements()


@cache
def known():
    """Frequencies [rad/s]."""
    return Matrices(grid().mass, grid().stiffness, grid().places).reduce(6).frequencies()


@cache
def labels():
    """Of the nodes in the other program."""
    return 10 * np.random.default_rng(1).permutation(len(grid().places)) + 3


def save(path, matrix, form):
    path = path.with_suffix(form)
    if form == ".npz":
        save_npz(path, matrix)
    elif form == ".npy":
        np.save(path, matrix.toarray())
    else:
        mmwrite(path, matrix, symmetry="symmetric")
    return path


@pytest.mark.parametrize("form", [".npz", ".npy", ".mtx"])
def test_matrices_of_each_form_are_the_same_body(tmp_path, form):
    damping = 1e-6 * grid().stiffness
    files = [
        save(tmp_path / name, m, form) for name, m in (("m", grid().mass), ("k", grid().stiffness), ("c", damping))
    ]
    right = np.flatnonzero(grid().places[:, 0] == 2.0).tolist()
    model = matrices_from_files(files[0], files[1], grid().places, {"right": right}, files[2])
    body = model.reduce(6)
    assert body.frequencies() == pytest.approx(known(), rel=1e-10)
    assert body.damping == pytest.approx(1e-6 * known() ** 2, rel=1e-6)
    assert len(body.surfaces["right"].points) == 3


@pytest.mark.parametrize("symmetry", ["symmetric", "general"])
@pytest.mark.parametrize("dense", [True, False])
def test_all_kinds_of_matrix_market(tmp_path, symmetry, dense):
    paths = []
    for name, matrix in (("m.mtx", grid().mass), ("k.mtx", grid().stiffness)):
        paths.append(tmp_path / name)
        mmwrite(paths[-1], matrix.toarray() if dense else matrix, symmetry=symmetry)
    assert matrices_from_files(*paths, grid().places).reduce(6).frequencies() == pytest.approx(known(), rel=1e-10)


def test_one_array_of_savez_and_places_of_each_form(tmp_path):
    np.savez(tmp_path / "m.npz", mass=grid().mass.toarray())
    np.savez(tmp_path / "k.npz", grid().stiffness.toarray())
    np.save(tmp_path / "x.npy", grid().places)
    np.savez(tmp_path / "x.npz", grid().places)
    np.savetxt(tmp_path / "x.csv", grid().places, delimiter=",", header="x, y")
    np.savetxt(tmp_path / "x.txt", grid().places)
    for name in ("x.npy", "x.npz", "x.csv", "x.txt"):
        model = matrices_from_files(tmp_path / "m.npz", tmp_path / "k.npz", tmp_path / name)
        assert model.reduce(6).frequencies() == pytest.approx(known(), rel=1e-10)


def abaqus(path, matrix, half, comma=","):
    """Entries named by node and degree of freedom, those of one half or of both."""
    whole = matrix.tocoo()
    keep = {"lower": whole.row >= whole.col, "upper": whole.row <= whole.col, "both": whole.row >= 0}.get(half)
    if keep is None:  # one of each pair, now from this half, now from that
        low = np.minimum(whole.row, whole.col) + np.maximum(whole.row, whole.col)
        keep = np.where(low % 2 == 0, whole.row >= whole.col, whole.row <= whole.col)
    lines = ["** written by a test"]
    for i, j, value in zip(whole.row[keep], whole.col[keep], whole.data[keep], strict=True):
        heads = (labels()[i // 2], i % 2 + 1, labels()[j // 2], j % 2 + 1)
        lines.append(f"{comma} ".join([*map(str, heads), f"{value:.17e}"]))
    path.write_text("\n".join(lines) + "\n")
    return path


@pytest.mark.parametrize("half", ["lower", "upper", "both", "mixed"])
@pytest.mark.parametrize("comma", [",", ""])
def test_matrix_output_of_abaqus_is_the_same_body(tmp_path, half, comma):
    mass = abaqus(tmp_path / "MASS1.mtx", grid().mass, half, comma)
    stiffness = abaqus(tmp_path / "STIF1.mtx", grid().stiffness, half, comma)
    tip = int(labels()[np.argmax(grid().places.sum(axis=1))])
    model = matrices_from_files(mass, stiffness, np.column_stack([labels(), grid().places]), {"tip": tip})
    body = model.reduce(6)
    assert body.frequencies() == pytest.approx(known(), rel=1e-9)
    assert body.points["tip"].place == pytest.approx([2.0, 1.0])
    order = np.argsort(labels())
    assert np.asarray(model.coordinates) == pytest.approx(grid().places[order])
    plain = matrices_from_files(mass, stiffness, grid().places[order])  # places in the order of ascending labels
    assert plain.reduce(6).frequencies() == pytest.approx(known(), rel=1e-9)


GOOD = ["1,1, 1,1, 2.0", "1,2, 1,2, 2.0", "2,1, 2,1, 2.0", "2,2, 2,2, 2.0", "1,1, 2,1, 1.0", "1,2, 2,2, 1.0"]


@pytest.mark.parametrize(
    ("lines", "said"),
    [
        ([], "has no entries"),
        ([*GOOD, "1,1, 2,1, 1.0"], r"entry \(1, 1, 2, 1\) comes twice"),
        ([*GOOD, "2,1, 1,1, 1.5"], "its mirror image differ"),
        ([*GOOD, "2,3, 2,3, 1.0"], "degree of freedom 3 was found, expected 1 and 2 only"),
        ([*GOOD, "0,1, 2,1, 1.0"], "node 0 was found"),
        ([*GOOD, "-1,1, 2,1, 1.0"], "node -1 was found"),
        ([*GOOD, "3,1, 3,1, 1e36"], "1e\\+36 at node 3 was found, a support"),
        ([*GOOD, "3,1, 3,1, nan"], "nan at node 3"),
        (["*MATRIX,TYPE=STIFFNESS", "1.0, 2.0"], "line 1: .*an element or a substructure"),
        (["1, 1, 2.0", "1, 2, 1.0"], "line 1: three columns, as FORMAT=COORDINATE writes"),
        ([*GOOD, "3,1, three,1, 1.0"], "line 7: '3,1, three,1, 1.0'"),
        (["4 4 10", "1 1 2.0"], "three columns"),
        (["nonsense"], "line 1: 'nonsense', expected lines 'node, dof"),
    ],
)
def test_other_texts_are_not_taken_for_matrices_of_abaqus(tmp_path, lines, said):
    path = tmp_path / "K.mtx"
    path.write_text("\n".join(lines))
    with pytest.raises(ModelError, match=said):
        matrices_from_files(path, path, [[0.0, 0.0], [1.0, 0.0]])


def test_matrices_and_nodes_that_do_not_belong_together(tmp_path):
    mass, other = abaqus(tmp_path / "M.mtx", grid().mass, "lower"), save(tmp_path / "k", grid().stiffness, ".npz")
    stiffness = abaqus(tmp_path / "K.mtx", grid().stiffness, "upper")
    with pytest.raises(ModelError, match="some name their nodes and some do not"):
        matrices_from_files(mass, other, grid().places)
    count = len(grid().places)
    with pytest.raises(ModelError, match=f"{count - 1} places were given, expected those of the {count} nodes"):
        matrices_from_files(mass, stiffness, grid().places[1:])
    with pytest.raises(ModelError, match="is not both there and in the matrices"):
        matrices_from_files(mass, stiffness, np.column_stack([labels() + 1, grid().places]))
    with pytest.raises(ModelError, match="expected nodes of the coordinates"):
        matrices_from_files(mass, stiffness, np.column_stack([labels(), grid().places]), {"tip": 1})
    with pytest.raises(ModelError, match="first of three columns has no whole numbers, or one twice"):
        matrices_from_files(mass, stiffness, np.column_stack([labels() * 0, grid().places]))
    few = tmp_path / "few.mtx"
    few.write_text("\n".join(GOOD))
    with pytest.raises(ModelError, match="is not in every matrix"):
        matrices_from_files(few, stiffness, grid().places)


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("k.npz", b"no archive", "cannot be read"),
        ("k.npy", b"", "cannot be read"),
        (
            "k.mtx",
            b"%%MatrixMarket matrix coordinate real general\n2 2",
            "0 numbers were found|the size .2, 2. was found",
        ),
        (
            "k.mtx",
            b"%%MatrixMarket matrix coordinate real symmetric\n2 2 3\n1 1 1.0\n2 2",
            "5 numbers were found, expected 9",
        ),
        ("k.mtx", b"%%MatrixMarket matrix coordinate real general\n2 2 1\n1 3 1.0", "beyond column 1 to 2"),
        ("k.mtx", b"%%MatrixMarket matrix coordinate real general\n2 2 1\n1.5 1 1.0", "beyond row 1 to 2"),
        ("k.mtx", b"%%MatrixMarket matrix coordinate complex general\n2 2 1\n1 1 1.0 0", "expected a matrix, .* real"),
        ("k.mtx", b"%%MatrixMarket matrix coordinate real general\n2 2 1\n1 one 1.0", "'one', expected numbers"),
        (
            "k.mtx",
            b"%%MatrixMarket matrix coordinate real general\n99999999 99999999 1\n1 1 1.0",
            "at most 10000000 rows",
        ),
        ("k.mat", b"", "expected a file .mtx, .npz or .npy"),
        ("k.mtx", b"", "has no entries"),
    ],
)
def test_broken_files(tmp_path, name, content, said):
    path = tmp_path / name
    path.write_bytes(content)
    with pytest.raises(ModelError, match=said):
        matrices_from_files(path, path, grid().places)


def test_arguments_that_are_no_files(tmp_path):
    good = save(tmp_path / "m", grid().mass, ".npz")
    with pytest.raises(ModelError, match=r"mass: .*missing.mtx' was given, expected the name of a file that is there"):
        matrices_from_files(tmp_path / "missing.mtx", good, grid().places)
    with pytest.raises(ModelError, match="stiffness: 7 was given"):
        matrices_from_files(good, 7, grid().places)
    np.savez(tmp_path / "two.npz", a=grid().places, b=grid().places)
    with pytest.raises(ModelError, match="holds a, b, expected one array"):
        matrices_from_files(good, good, tmp_path / "two.npz")
    (tmp_path / "x.txt").write_text("0 0\n1 0 0 0\n")
    with pytest.raises(ModelError, match="cannot be read"):
        matrices_from_files(good, good, tmp_path / "x.txt")
    with pytest.raises(ModelError, match=r"expected a file .npy, .npz, .txt or .csv"):
        matrices_from_files(good, good, save(tmp_path / "x", grid().mass, ".mtx"))
