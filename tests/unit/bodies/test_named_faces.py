"""Named faces of reduced solids: their facets, the material of their nodes, and names that are none."""

from __future__ import annotations

import copy
import pickle
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.bodies.spatial.face_nodes import FaceNodes
from lcpflex.bodies.spatial.surface import CODES, RANKS, SpatialKind
from tests.solid_meshes import EDGES, QUIET, SOLIDS, STEEL, solid

# made when they are needed: collecting loads no finite elements
SHAPES: dict[str, tuple[Callable[[], lf.Solid], tuple[str, ...]]] = {
    "box": (
        lambda: lf.Solid.box((0.1, 0.05, 0.02), 0.02, **STEEL),
        ("left", "right", "front", "back", "bottom", "top"),
    ),
    "bar": (lambda: lf.Solid.bar(0.1, 0.05, 0.02, 0.02, **STEEL), ("left", "right", "front", "back", "bottom", "top")),
    "cylinder": (lambda: lf.Solid.cylinder(0.05, 0.02, 0.04, **STEEL), ("side", "bottom", "top")),
    "tube": (lambda: lf.Solid.tube(0.03, 0.05, 0.02, 0.03, **STEEL), ("inner", "outer", "bottom", "top")),
    "ball": (lambda: lf.Solid.ball(0.05, 0.04, **STEEL), ()),
}


def places_of(face: FaceNodes) -> Any:
    return np.array([point.place for point in face.points])


def normals_of(face: FaceNodes) -> Any:
    """(F, 3) twice the areas of the first three corners."""
    x = places_of(face)
    return np.array([np.cross(x[c[1]] - x[c[0]], x[c[2]] - x[c[0]]) for c in face.cells])


@QUIET
@pytest.mark.parametrize("kind", SOLIDS)
@pytest.mark.parametrize("reduced", [{"modes": 4}, {"modes": 0}, {"modes": 2, "clamped": "end"}])
def test_facets_have_all_their_nodes_and_look_outwards(kind: str, reduced: Any) -> None:
    body = solid(kind, sets={"end": lambda x, y, z: x > EDGES[0] - 1e-9}).reduce(**reduced)
    face = body.face("end")
    x = places_of(face)
    assert x[:, 0] == pytest.approx(np.full(len(x), EDGES[0] - body.origin[0]))
    corners = 3 if "tetra" in kind else 4
    nodes = {"tetra": 3, "tetra10": 6, "hexahedron": 4, "hexahedron20": 8, "hexahedron27": 9}[kind]
    for cell in face.cells:
        assert cell.shape == (nodes,)
        around = x[cell[:corners]]
        for i in range(corners if nodes > corners else 0):
            assert x[cell[corners + i]] == pytest.approx(0.5 * (around[i] + around[(i + 1) % corners]))
        if nodes == 9:
            assert x[cell[8]] == pytest.approx(around.mean(axis=0))
    normals = normals_of(face)
    assert (normals[:, 0] > 0.0).all()
    assert normals[:, 1:] == pytest.approx(0.0, abs=1e-12)
    assert normals[:, 0].sum() * (0.5 if corners == 3 else 1.0) == pytest.approx(EDGES[1] * EDGES[2])
    for point in (face.points[0], face.points[-1]):
        own = body.at_nodes(point.made_at)
        assert point.place == pytest.approx(own.place)
        assert np.array_equal(point.phi, own.phi)
        assert not point.psi.any()
        assert point.turns is (body.modes == 0)


@pytest.mark.parametrize("shape", SHAPES)
def test_shapes_name_their_faces(shape: str) -> None:
    """Each looks away from the body, apart from the wall of the tube; all of them are the surface."""
    made, names = SHAPES[shape]
    body = made().reduce(0)
    assert set(body.faces) == {"surface", *names}
    assert sum(len(body.face(name).cells) for name in names or ["surface"]) == len(body.face("surface").cells)
    for name in body.faces:
        face = body.face(name)
        x = places_of(face)
        away = np.array(
            [(normal * x[cell].mean(axis=0)).sum() for normal, cell in zip(normals_of(face), face.cells, strict=True)]
        )
        if name != "surface" or shape == "ball":
            assert (away < 0.0 if name == "inner" else away > 0.0).all()


@QUIET
def test_sets_are_faces_where_they_hold_whole_ones() -> None:
    """Of a solid, nodes within it and parts of facets do no harm."""
    sets = {"half": lambda x, y, z: x > 0.14, "corner": [0], "line": lambda x, y, z: (y == 0.0) & (z == 0.0)}
    body = solid("hexahedron27", sets=sets).reduce(2)
    assert set(body.faces) == {"surface", "half"}
    x = places_of(body.face("half"))
    assert x[:, 0].min() == pytest.approx(0.2 - body.origin[0])  # 0.15 is amid elements
    for name, words in (
        ("line", r"name: 'line' was given, whose nodes hold no whole face .* \('half', 'surface'\)"),
        ("nose", "name: there is no face 'nose'"),
        (["half"], r"name: there is no face \['half'\]"),
    ):
        with pytest.raises(lf.ModelError, match=words):
            body.face(name)  # type: ignore[arg-type]


@QUIET
def test_matrices_have_the_faces_that_were_given() -> None:
    """And sets that are some of these facets alone: what others have beyond them is not known."""
    mesh = solid("hexahedron20").finite_elements()
    end = mesh.facets[(mesh.places[mesh.facets][..., 0] > EDGES[0] - 1e-9).all(axis=1)]
    sets = {"one": np.unique(end[0]).tolist(), "more": [0, *np.unique(end[0]).tolist()], "node": 3}
    body = lf.SpatialMatrices(mesh.mass, mesh.stiffness, mesh.places, sets, faces={"end": end}).reduce(2)
    assert set(body.faces) == {"end", "one"}
    nodes = np.array([point.made_at for point in body.face("end").points])
    assert {tuple(nodes[cell]) for cell in body.face("end").cells} == {tuple(facet) for facet in end.tolist()}
    with pytest.raises(lf.ModelError, match=r"'more' was given, whose nodes hold no whole face"):
        body.face("more")
    bare = lf.SpatialMatrices(mesh.mass, mesh.stiffness, mesh.places, sets).reduce(2)
    with pytest.raises(lf.ModelError, match=r"expected one of those that do \(no face\)"):
        bare.face("one")


def test_faces_are_copied_and_checked() -> None:
    body = SHAPES["box"][0]().reduce(2)
    for other in (copy.deepcopy(body), pickle.loads(pickle.dumps(body))):
        assert np.array_equal(places_of(other.face("top")), places_of(body.face("top")))
    with pytest.raises(lf.ModelError, match=r"faces\['top'\]: 3 was given, expected that of a reduced body"):
        lf.SpatialBody(1.0, inertia=np.eye(3), faces={"top": 3})  # type: ignore[dict-item]
    with pytest.raises(lf.ModelError, match=r"faces\['top'\]: it is of another body, expected points with 0 modes"):
        lf.SpatialBody(1.0, inertia=np.eye(3), faces={"top": body.face("top")})


def test_files_of_results_know_kinds_by_codes_that_stay() -> None:
    """And the rank of a face is between those of rims and polyhedra."""
    assert (CODES[SpatialKind.POLYHEDRON], CODES[SpatialKind.PLANE]) == (5, 8)
    rank = {kind: RANKS[code] for kind, code in CODES.items()}
    assert rank[SpatialKind.RIM] < rank[SpatialKind.FACE] < rank[SpatialKind.POLYHEDRON] < rank[SpatialKind.MESH]


@QUIET
@pytest.mark.parametrize(
    "corners",
    [(0, 4, 1, 3), (0, 1, 3, 4), (0, 5, 6, 4), (0, 1, 2), (0, 1, 2, 8)],
    ids=["crossed", "crossed otherwise", "concave", "on one line", "three on one line"],
)
@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e3])
def test_facets_whose_corners_do_not_go_around_are_refused(corners: tuple[int, ...], scale: float) -> None:
    """Of nodes 0, 1, 2 along y, and 3 to 5, 6 to 8 above them; what the area of such a facet is nobody knows."""
    mesh = lf.Solid.box((0.1 * scale,) * 3, elements=(2, 2, 2), **STEEL).finite_elements()
    end = np.flatnonzero(mesh.places[:, 0] > 0.0499 * scale)
    end = end[np.lexsort((mesh.places[end, 1], (mesh.places[end, 2] / scale).round(9)))]
    good = [4, 5, 8] if len(corners) == 3 else [4, 5, 8, 7]
    matrices = mesh.mass, mesh.stiffness, mesh.places
    assert lf.SpatialMatrices(*matrices, faces={"end": [end[good]]}).faces
    with pytest.raises(lf.ModelError, match=r"faces\['end'\]: facet 1 has nodes .* expected those of a convex facet"):
        lf.SpatialMatrices(*matrices, faces={"end": [end[good], end[list(corners)]]})
