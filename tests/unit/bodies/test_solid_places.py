"""Places, sets and faces of solids: which nodes are meant, how much each counts, and what acts there."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import lcpflex as lf
from lcpflex.bodies.fem.mesh import KINDS, Mesh
from lcpflex.bodies.fem.node_weights import node_weights
from lcpflex.bodies.reduction.kept_factor import free_mesh
from lcpflex.bodies.reduction.normal_rows import normal_loads
from tests.solid_meshes import EDGES, QUIET, STEEL, meshed_block, solid

FACES = {"top": lambda x, y, z: abs(z - 0.1) < 1e-9, "part": lambda x, y, z: (abs(z - 0.1) < 1e-9) & (x < 0.101)}


@QUIET
def test_faces_of_matrices_may_share_facets() -> None:
    """A part of a face that is named, too, does not count twice in the whole."""
    mesh = solid("hexahedron", (3, 2, 1), sets=FACES).finite_elements()
    faces = {name: mesh.facets[mesh.faces[name]] for name in FACES}
    given = lf.SpatialMatrices(mesh.mass, mesh.stiffness, mesh.places, faces=faces)
    body = given.reduce(2, interfaces=["top", "part"])
    assert body.points["top"].place + body.origin == pytest.approx([0.15, 0.1, 0.1], abs=1e-12)
    assert body.points["part"].place + body.origin == pytest.approx([0.05, 0.1, 0.1], abs=1e-12)
    found = given.finite_elements()
    assert len(found.facets) == 6
    for name, rows in found.faces.items():
        assert np.array_equal(np.unique(found.facets[rows]), np.unique(faces[name]))


def test_nodes_of_facets_of_eight_count_alike_however_they_are_numbered() -> None:
    mesh = meshed_block("hexahedron20", EDGES, (2, 2, 1))
    kind = KINDS["hexahedron20"]
    corners = [1, 2, 3, 0, 5, 6, 7, 4]  # the element turned by 90 degrees about z
    amid = {frozenset(pair): 8 + edge for edge, pair in enumerate(kind.pairs)}
    order = [*corners, *(amid[frozenset(corners[k] for k in pair)] for pair in kind.pairs)]
    nodes = np.flatnonzero(np.abs(mesh.places[:, 2] - 0.1) < 1e-9)
    turned = Mesh(kind, mesh.places, mesh.cells[:, order])
    weights = [node_weights(lf.Solid(one, **STEEL).finite_elements(), nodes) for one in (mesh, turned)]
    assert weights[0] == pytest.approx(weights[1], rel=1e-12)
    assert weights[0] @ mesh.places[nodes] == pytest.approx([0.15, 0.1, 0.1], abs=1e-12)


@QUIET
def test_loads_that_inertia_balances_everywhere_add_no_modes() -> None:
    """The mean of all nodes of equal elements moves with the mass centre: moments alone deform the body there."""
    body = solid("hexahedron", (3, 2, 1)).reduce(4, interfaces=[list(range(24))])
    assert body.residual_modes == 6 - 3


@pytest.mark.parametrize(
    ("interface", "words"),
    [
        ([0, [1, 2], 3], r"interfaces\[0\]: .* expected the name of a node set, several, or node numbers; or a place"),
        ((0, 0, 0), r"interfaces\[0\]: node 0 was given 3 times, expected once; or a place \(x, y, z\)"),
        ((0, 1, 2), r"interfaces\[0\]: \(0, 1, 2\) was given, which are nodes and a place of the mesh, too"),
        (lf.Interface("edge", forces=False), r"interfaces\[0\]: forces: False was given at nodes on one line"),
        ((0.0, 1.0, float("nan")), r"interfaces\[0\]: x, y, z: an array with nan"),
    ],
)  # fmt: skip
def test_what_is_no_place_or_two(interface: Any, words: str) -> None:
    given = lf.Solid.box(
        (4.0, 4.0, 4.0), elements=(2, 2, 2), sets={"edge": lambda x, y, z: (x < 0.0) & (z < 0.0)}, **STEEL
    )
    with pytest.raises(lf.ModelError, match=words):
        given.reduce(0, interfaces=[interface])


def test_sets_of_the_faces_of_a_mesh() -> None:
    """A face of the mesh has nodes, and may have another name besides its own."""
    given = lf.Solid.box((1.0, 1.0, 1.0), elements=(2, 2, 2), sets={"pad": "bottom"}, **STEEL).finite_elements()
    assert np.array_equal(given.sets["pad"], given.sets["bottom"])
    assert np.array_equal(given.faces["pad"], given.faces["bottom"])
    with pytest.raises(lf.ModelError, match=r"'base' was given, expected a group of the mesh .*'bottom'"):
        lf.Solid.box((1.0, 1.0, 1.0), elements=(2, 2, 2), sets={"pad": "base"}, **STEEL)


def test_names_that_mean_two_things() -> None:
    near = {"surface": ((0.0, 0.0, 0.5), 0.1)}
    with pytest.raises(lf.ModelError, match="near: the name 'surface' was given, expected another one"):
        lf.Solid.box((1.0, 1.0, 1.0), 0.5, near=near, **STEEL)
    with pytest.raises(lf.ModelError, match="sets: the name 'spot' was given, expected another one: near has it"):
        lf.Solid.box((1.0, 1.0, 1.0), 0.5, near={"spot": near["surface"]}, sets={"spot": [0]}, **STEEL)
    mesh = meshed_block("hexahedron", EDGES, (1, 1, 1))
    for more in ({"groups": {"surface": np.arange(4)}}, {"faces": {"surface": mesh.cells[:, :4]}}):
        with pytest.warns(lf.ModelWarning, match="its group 'surface' is left out, for the whole surface has"):
            lf.Solid(Mesh(mesh.kind, mesh.places, mesh.cells, **more), **STEEL)


def test_remedies_are_those_of_space() -> None:
    with pytest.warns(lf.ModelWarning, match="expected at most 10 %: quadratic elements, or such ones 2 times smaller"):
        lf.Solid.bar(1.0, 0.1, 0.1, elements=(2, 1, 1), **STEEL).reduce(3)


@QUIET
@pytest.mark.parametrize("noise", [0.0, 1e-9, 1e-8, 1e-7, 1e-6, 1e-5])
def test_normals_of_flat_faces_of_rounded_places(noise: float) -> None:
    """Files round places: what nearly leaves a flat face three rigid motions does as one that leaves them does.

    Frequencies are those without noise, and forces along the normals without a resultant deform it as the mesh.
    """
    mesh = meshed_block("hexahedron", EDGES, (3, 2, 2))
    turn = Rotation.from_rotvec((0.3, 0.5, 0.7)).as_matrix()
    off = 0.3 * noise * np.random.default_rng(1).uniform(-1.0, 1.0, mesh.places.shape)
    top = np.flatnonzero(np.abs(mesh.places[:, 2] - 0.1) < 1e-9)
    given, exact = (
        lf.Solid(Mesh(mesh.kind, mesh.places @ turn.T + more, mesh.cells), **STEEL, sets={"top": top})
        for more in (off, 0.0)
    )
    body, clean = (one.reduce(4, boundary="top", rows="normal") for one in (given, exact))
    assert body.modes == 4 + len(top) - 3
    assert body.frequencies() == pytest.approx(clean.frequencies(), rel=10.0 * noise + 1e-9)
    whole = given.finite_elements()
    loads = normal_loads(whole, "boundary", top)
    loads = loads @ np.linalg.svd(whole.rigid.T @ loads)[2][6:].T
    shapes = body.mesh_modes.shapes  # type: ignore[union-attr]
    own, static = shapes.T @ loads, free_mesh(whole).flexibility(loads)
    assert own.T @ (own / body.stiffness[:, None]) == pytest.approx(loads.T @ static, rel=1e-9, abs=1e-20)
