"""Meshes through files: Gmsh with physical groups, Abaqus with sets, VTK, and files that hold no planar mesh."""

from __future__ import annotations

import contextlib
import io
import sys

import numpy as np
import pytest

from lcpflex.basics import libs as basics_libs
from lcpflex.bodies.continuum import Continuum
from lcpflex.bodies.fem import meshes
from lcpflex.errors import ModelError, ModelWarning
from tests import libs

pytestmark = pytest.mark.filterwarnings("ignore:mesh. its stiffness:lcpflex.errors.ModelWarning")  # coarse on purpose

STEEL = (7800.0, 2e11, 0.3)
KINDS = [(triangles, quadratic) for triangles in (True, False) for quadratic in (True, False)]
NAMES = {(True, True): "triangle6", (True, False): "triangle", (False, True): "quad9", (False, False): "quad"}


def strip(triangles: bool, quadratic: bool):
    return meshes.rectangle(3.0, 1.0, 6, 2, triangles=triangles, order=1 + quadratic)


def quietly(write, *args, **more):
    """meshio talks while it writes."""
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
        write(*args, **more)


def same_body(path, grid, names):
    model, known = Continuum(path, *STEEL), Continuum(grid, *STEEL)
    assert model.reduce(5).frequencies() == pytest.approx(known.reduce(5).frequencies(), rel=1e-9)
    mesh, wanted = model.finite_elements(), known.finite_elements()
    for name in names:
        nodes, closed = wanted.chains[name]
        assert mesh.chains[name][1] == closed
        assert mesh.places[mesh.chains[name][0]] == pytest.approx(wanted.places[nodes], abs=1e-12)
    return mesh


@pytest.mark.parametrize("suffix", ["vtk", "vtu", "msh", "xdmf"])
@pytest.mark.parametrize(("triangles", "quadratic"), KINDS)
def test_what_scikit_fem_saves_is_the_same_body(tmp_path, triangles, quadratic, suffix):
    grid = strip(triangles, quadratic)
    path = tmp_path / f"strip.{suffix}"
    quietly(grid.save, path)
    same_body(path, grid, ["left", "right", "bottom", "top", "outline"])


@pytest.mark.parametrize(("triangles", "quadratic"), KINDS)
def test_physical_groups_of_gmsh_are_sets_and_surfaces(tmp_path, triangles, quadratic):
    grid = strip(triangles, quadratic)
    cells = grid.dofs.element_dofs.T
    right = grid.boundaries["right"]
    edges = grid.facets[:, right].T
    line = "line"
    if quadratic:
        edges, line = np.column_stack([edges, grid.dofs.facet_dofs[0, right]]), "line3"
    tip = int(np.argmin(np.hypot(grid.p[0] - 3.0, grid.p[1] - 1.0)))
    physical = [np.ones(len(cells), int), np.full(len(edges), 2), np.array([3])]
    written = libs.meshio.Mesh(
        np.column_stack([grid.p.T, np.zeros(grid.p.shape[1])]),
        [(NAMES[triangles, quadratic], cells), (line, edges), ("vertex", np.array([[tip]]))],
        cell_data={"gmsh:physical": physical, "gmsh:geometrical": physical},
        field_data={"steel": np.array([1, 2]), "right": np.array([2, 1]), "tip": np.array([3, 0])},
    )
    path = tmp_path / "strip.msh"
    quietly(libs.meshio.write, path, written, file_format="gmsh22")
    mesh = same_body(path, grid, ["right", "outline"])
    assert mesh.places[mesh.points["tip"]] == pytest.approx([3.0, 1.0])
    assert len(mesh.sets["steel"]) == len(mesh.places)
    assert Continuum(path, *STEEL, sets={"end": "right"}).finite_elements().chains["end"][0].tolist() == (
        mesh.chains["right"][0].tolist()
    )


GMSH_41 = """$MeshFormat
4.1 0 8
$EndMeshFormat
$PhysicalNames
3
0 7 "corner"
1 8 "right"
2 9 "steel"
$EndPhysicalNames
$Entities
4 4 1 0
1 0 0 0 1 7
2 2 0 0 0
3 2 1 0 0
4 0 1 0 0
1 0 0 0 2 0 0 0 2 1 -2
2 2 0 0 2 1 0 1 8 2 2 -3
3 0 1 0 2 1 0 0 2 3 -4
4 0 0 0 0 1 0 0 2 4 -1
1 0 0 0 2 1 0 1 9 4 1 2 3 4
$EndEntities
$Nodes
1 6 1 6
2 1 0 6
1
2
3
4
5
6
0 0 0
1 0 0
2 0 0
0 1 0
1 1 0
2 1 0
$EndNodes
$Elements
3 4 1 4
0 1 15 1
1 1
1 2 1 1
2 3 6
2 1 3 2
3 1 2 5 4
4 2 3 6 5
$EndElements
"""


def test_a_file_of_gmsh_4_with_entities(tmp_path):
    path = tmp_path / "two.msh"
    path.write_text(GMSH_41)
    mesh = Continuum(path, *STEEL).finite_elements()
    assert mesh.points == {"corner": 0}
    assert mesh.chains["right"][0].tolist() == [2, 5]
    assert mesh.sets["steel"].tolist() == [0, 1, 2, 3, 4, 5]
    assert set(mesh.sets) == {"corner", "right", "steel", "outline"}


@pytest.mark.parametrize("element", ["CPS", "cpe", "CAX"])
@pytest.mark.parametrize(("triangles", "quadratic"), [kind for kind in KINDS if kind != (False, True)])
def test_sets_of_abaqus_are_sets_and_surfaces(tmp_path, triangles, quadratic, element):
    """Node numbers in the file have gaps; those here count from 0 in its order."""
    grid = strip(triangles, quadratic)
    cells = grid.dofs.element_dofs.T
    nodes = [f"{10 * k + 10}, {x!r}, {y!r}" for k, (x, y) in enumerate(grid.p.T.tolist())]
    elements = [", ".join(map(str, [k + 1, *(10 * row + 10)])) for k, row in enumerate(cells)]
    right = np.flatnonzero(grid.p[0] == 3.0)
    text = [
        "*HEADING",
        "** a comment",
        "*NODE",
        *nodes,
        f"*ELEMENT, TYPE={element}{cells.shape[1]}, ELSET=steel",
        *elements,
        "*NSET, NSET=right",
        ", ".join(str(10 * k + 10) for k in right),
        "*NSET, NSET=few, GENERATE",
        "10, 30, 10",
        "*MATERIAL, NAME=M",
    ]
    path = tmp_path / "strip.inp"
    path.write_text("\n".join(text) + "\n")
    mesh = same_body(path, grid, ["right", "outline"])
    assert mesh.sets["few"].tolist() == [0, 1, 2]
    assert len(mesh.sets["steel"]) == len(mesh.places)


def test_nodes_of_the_file_keep_their_order(tmp_path):
    """Those of arcs' centres, which no element has, are left out."""
    points = np.array([[1.0, 1.0, 0], [5.0, 5.0, 0], [0.0, 0.0, 0], [1.0, 0.0, 0], [0.0, 1.0, 0]])
    path = tmp_path / "square.vtk"
    quietly(libs.meshio.write, path, libs.meshio.Mesh(points, [("quad", np.array([[2, 3, 0, 4]]))]))
    with pytest.warns(ModelWarning, match="node 1 without an element"):
        mesh = Continuum(path, *STEEL).finite_elements()
    assert mesh.places.tolist() == [[1, 1], [0, 0], [1, 0], [0, 1]]


SQUARE = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [2, 0, 0], [2, 1, 0]])


@pytest.mark.parametrize(
    ("points", "cells", "said"),
    [
        (SQUARE[:4] + [0, 0, 0.5] * np.arange(4)[:, None], [("quad", [[0, 1, 2, 3]])], "has z = 1.5, expected .*z = 0"),
        (SQUARE[:4] + np.array([0, 0, 2.0]), [("quad", [[0, 1, 2, 3]])], "has z = 2"),
        (
            SQUARE,
            [("quad", [[0, 1, 2, 3]]), ("triangle", [[1, 4, 5], [1, 5, 2]])],
            "elements quad, triangle were found",
        ),
        (np.vstack([SQUARE[:4], [0, 0, 1]]), [("tetra", [[0, 1, 2, 4]])], "elements tetra were found"),
        (SQUARE[:4], [("quad", [[0, 1, 2, 9]])], "elements with nodes that it does not have, expected 0 to 3"),
        (SQUARE[:4], [("quad", [[0, 1, 2, 3]]), ("line", [[0, -7]])], "elements with nodes that it does not have"),
        (SQUARE[:4] * 1e30, [("quad", [[0, 1, 2, 3]])], r"extent \[m\]: 1e\+30"),
        (SQUARE[:2], [("line", [[0, 1]])], r"elements \(none\) were found"),
        (
            np.array([[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0], [1, 0, 0], [2, 1, 0], [1, 2, 0], [0, 1, 0.0]]),
            [("quad8", [[0, 1, 2, 3, 4, 5, 6, 7]])],
            "elements quad8 were found.*nine nodes",
        ),
    ],
)
def test_files_without_a_planar_mesh_of_one_kind(tmp_path, points, cells, said):
    path = tmp_path / "wrong.vtk"
    quietly(libs.meshio.write, path, libs.meshio.Mesh(points, [(kind, np.array(nodes)) for kind, nodes in cells]))
    with pytest.raises(ModelError, match=said):
        Continuum(path, *STEEL)


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("empty.msh", b""),
        ("noise.msh", b"\x00\xff\x13 nothing of the kind"),
        ("cut.msh", b"$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n4\n1 0 0 0\n"),
        ("noise.vtk", b"# vtk DataFile Version 9.9\nnothing\n"),
        ("noise.inp", b"*ELEMENT, TYPE=CPS4\n1, 1, 2, 3, 4\n"),
        ("unknown.inp", b"*NODE\n1, 0, 0\n2, 1, 0\n3, 0, 1\n*ELEMENT, TYPE=C3D99\n1, 1, 2, 3\n"),
        ("missing.inp", b"*NODE\n1, 0, 0\n2, 1, 0\n*ELEMENT, TYPE=CPS3\n1, 1, 2, 3\n"),
        ("mesh.nonsense", b"1 2 3"),
        ("none", b""),
        ("noise.xdmf", b"<Xdmf>"),
        ("noise.stl", b"solid nothing"),
    ],
)
def test_broken_files_are_refused_without_noise(tmp_path, capfd, name, content):
    path = tmp_path / name
    path.write_bytes(content)
    with pytest.raises(ModelError, match=r"cannot read it|were found|elements with nodes"):
        Continuum(path, *STEEL)
    assert capfd.readouterr() == ("", "")


def test_without_meshio_its_files_are_read_by_meshlane_or_the_missing_library_is_named(tmp_path, monkeypatch):
    """meshlane is meshio under another name, with more formats."""
    path = tmp_path / "strip.vtk"
    quietly(strip(True, False).save, path)
    monkeypatch.setitem(sys.modules, "meshlane", libs.meshio)
    monkeypatch.delitem(vars(basics_libs), "meshio", raising=False)
    monkeypatch.setitem(sys.modules, "meshio", None)
    same_body(path, strip(True, False), ["left", "outline"])
    assert vars(basics_libs).pop("meshlane") is libs.meshio  # it was loaded for that
    monkeypatch.setitem(sys.modules, "meshlane", None)
    with pytest.raises(ModelError, match=r"neither meshio nor meshlane .*pip install 'lcpflex\[meshes\]'"):
        Continuum(path, *STEEL)
    (tmp_path / "two.msh").write_text(GMSH_41)
    assert Continuum(tmp_path / "two.msh", *STEEL).finite_elements().points == {"corner": 0}


def test_a_folder_is_no_file(tmp_path):
    with pytest.raises(ModelError, match="expected the name of a file that is there"):
        Continuum(tmp_path, *STEEL)
