"""Solids from files: their mass, and what the names of the file are on them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import lcpflex as lf
from tests.unit.bodies.gmsh_writer import Sample

FOLDER = Path(__file__).parent / "mesh_files"
STEEL = (7800.0, 2e11, 0.3)
CORNERS = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1]])
pytestmark = [
    pytest.mark.filterwarnings("ignore:mesh .*stiff:lcpflex.errors.ModelWarning"),  # coarse on purpose
]


def solid(tmp_path, blocks, names, places=CORNERS):
    path = tmp_path / "part.msh"
    path.write_bytes(Sample(list(range(1, 1 + len(places))), places, blocks, names).written("4.1", ""))
    return lf.Solid(path, *STEEL)


@pytest.mark.parametrize(
    ("name", "end"),
    [
        ("gmsh_hexahedron20_binary.msh", "right"),
        ("gmsh_hexahedron27_parametric.msh", "right"),
        ("gmsh_tetra10_binary.msh", "right"),
        ("netgen_tetra10_2.msh", "4"),  # whose elements are inside out
        ("cgx_hexahedron20.inp", "right"),
    ],
)
def test_solids_of_files_have_their_mass_and_faces(name, end):
    mesh = lf.Solid(FOLDER / name, *STEEL).finite_elements()
    along = np.zeros(mesh.mass.shape[0])
    along[::3] = 1.0
    assert along @ (mesh.mass @ along) == pytest.approx(2.0 * 7800.0, rel=1e-9)
    assert mesh.places[mesh.sets[end], 0] == pytest.approx(2.0, abs=1e-9)
    assert end in mesh.faces


def test_a_group_amid_the_solid_is_one_of_nodes(tmp_path):
    """A surface between two materials, one of both sorts of facets, and one of a shell that stands apart."""
    places = np.vstack([CORNERS, [[5.0, 5, 5], [6, 5, 5], [5, 6, 5]]])
    blocks = [
        ("triangle", [[2, 3, 4]], [1]),
        ("triangle", [[2, 3, 4], [1, 2, 3]], [2]),
        ("triangle", [[1, 2, 3]], [3]),
        ("triangle", [[6, 7, 8]], [4]),
        ("tetra", [[1, 2, 3, 4], [2, 3, 4, 5]], [5]),
    ]
    names = {(2, 1): "between", (2, 2): "both", (2, 3): "below", (2, 4): "apart", (3, 5): "all"}
    with pytest.warns(lf.ModelWarning, match="node 5 and 2 more without an element|four nodes"):
        mesh = solid(tmp_path, blocks, names, places).finite_elements()
    assert mesh.sets["between"].tolist() == [1, 2, 3]
    assert "between" not in mesh.faces
    assert "apart" not in mesh.sets
    assert len(mesh.faces["below"]) == 1
    assert mesh.sets["both"].tolist() == [0, 1, 2, 3]


@pytest.mark.parametrize(
    ("blocks", "said"),
    [
        ([("triangle", [[1, 2, 3]], [])], "elements 1 triangle were found, expected .*tetra10.*has no volume"),
        ([("tetra", [[1, 2, 3, 4]], []), ("pyramid", [[1, 2, 3, 4, 5]], [])], "elements 1 tetra, 1 pyramid were found"),
        ([("tetra", [[1, 2, 3, 4]], []), ("quad", [[1, 2, 3, 4]], [7])], "'7' of the surface has elements quad"),
    ],
)
def test_files_without_a_solid_of_one_kind_are_refused(tmp_path, blocks, said):
    with pytest.raises(lf.ModelError, match=said):
        solid(tmp_path, blocks, {})
