"""Faces of solids that are given as matrices: they are those of the solid that the matrices come from."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from tests import libs
from tests.solid_meshes import EDGES, QUIET, SOLIDS, STEEL, bent, meshed_block, solid


@QUIET
def test_matrices_with_faces_are_the_solid_that_they_come_from() -> None:
    """Points by area, normal rows, boundaries; names of faces are names of sets."""
    given = solid("tetra10", (3, 2, 1), bent, sets={"low": lambda x, y, z: np.arange(len(x)) < 0.3 * len(x)})
    mesh = given.finite_elements()
    facets = mesh.facets[np.isin(mesh.facets, np.flatnonzero(mesh.places[:, 0] < 0.12)).all(axis=1)]
    other = lf.SpatialMatrices(mesh.mass, mesh.stiffness, mesh.places, faces={"face": facets})
    chosen = np.unique(facets)
    assert np.array_equal(other.finite_elements().sets["face"], chosen)
    for options in ({"interfaces": ["face"]}, {"contact": "face", "rows": "normal"}, {"boundary": "face"}):
        own = {key: [list(chosen)] if key == "interfaces" else value for key, value in options.items()}
        own = {key: list(chosen) if value == "face" else value for key, value in own.items()}
        assert other.reduce(3, **options).stiffness == pytest.approx(given.reduce(3, **own).stiffness, rel=1e-6)
    shape = other.reduce(0).shape
    assert len(shape.triangles) == 4 * len(facets)  # type: ignore[union-attr]


@pytest.mark.parametrize(
    ("faces", "words"),
    [
        ({"a": [[0, 1, 99999, 3]]}, r"faces\['a'\]: node 99999 was given"),
        ({"a": [[0, 1, 1]]}, r"faces\['a'\]: facet 0 has a node twice"),
        ({"a": [[0, 1, 2]], "b": [[0, 1, 2, 3]]}, r"faces: facets of \[3, 4\] nodes were given"),
        ({"a": [[0, 1]]}, r"faces\['a'\]: an array of shape \(1, 2\)"),
        ({"foot": [[0, 1, 2]]}, "faces: the name 'foot' was given, expected another one: a node set has it"),
        (3, "faces: 3 was given"),
    ],
)
def test_faces_that_cannot_be_are_refused(faces: Any, words: str) -> None:
    mesh = solid().finite_elements()
    with pytest.raises(lf.ModelError, match=words):
        lf.SpatialMatrices(mesh.mass, mesh.stiffness, mesh.places, {"foot": [0, 1]}, faces=faces)


TURNED = {
    3: [0, 2, 1],
    4: [0, 3, 2, 1],
    6: [0, 2, 1, 5, 4, 3],
    8: [0, 3, 2, 1, 7, 6, 5, 4],
    9: [0, 3, 2, 1, 7, 6, 5, 4, 8],
}


@QUIET
@pytest.mark.parametrize("kind", SOLIDS)
def test_facets_are_counter_clockwise_seen_from_outside(kind: str) -> None:
    """Also on bent elements, and in a slot whose walls are heavier than its floor."""
    mesh = solid(kind, (3, 2, 2), bent).finite_elements()
    facets = mesh.facets
    lf.SpatialMatrices(mesh.mass, mesh.stiffness, mesh.places, faces={"all": facets})
    wrong = facets.copy()
    wrong[2] = wrong[2][TURNED[facets.shape[1]]]
    with pytest.raises(lf.ModelError, match=r"faces\['one'\]: 1 facet\(s\) are clockwise .* \(the first one is 2\)"):
        lf.SpatialMatrices(mesh.mass, mesh.stiffness, mesh.places, faces={"one": wrong})


def test_the_floor_of_a_slot_looks_up() -> None:
    """Where the elements beside it reach far in front of it."""
    x, y, z = np.array([0.0, 1.0, 2.0, 3.0]), np.array([0.0, 1.0]), np.array([0.0, 0.1, 2.0])
    whole = libs.skfem.MeshHex1.init_tensor(x, y, z)
    middle = whole.p[:, whole.t].mean(axis=1)
    slotted = whole.remove_elements(np.flatnonzero((abs(middle[0] - 1.5) < 0.1) & (middle[2] > 0.1)))
    mesh = lf.Solid(slotted, **STEEL).finite_elements()
    at = mesh.places[mesh.facets]
    floor = mesh.facets[(abs(at[..., 2] - 0.1) < 1e-9).all(axis=1) & (abs(at[..., 0].mean(axis=1) - 1.5) < 0.1)]
    assert len(floor) == 1
    lf.SpatialMatrices(mesh.mass, mesh.stiffness, mesh.places, faces={"floor": floor})
    with pytest.raises(lf.ModelError, match="clockwise seen from outside"):
        lf.SpatialMatrices(mesh.mass, mesh.stiffness, mesh.places, faces={"floor": floor[:, ::-1]})


@QUIET
def test_matrices_that_link_all_nodes_do_not_tell_where_outside_is() -> None:
    """Condensed to some nodes, they are dense: the mean of all nodes of an angle is in front of its inner sides."""
    mesh = solid("hexahedron", (6, 4, 3)).finite_elements()
    stiffness = mesh.stiffness.toarray()
    stiffness[stiffness == 0.0] = 1e-30  # as entries that are stored
    inside = mesh.facets[:1][:, ::-1]
    lf.SpatialMatrices(mesh.mass, stiffness, mesh.places, faces={"one": inside})


@QUIET
@pytest.mark.parametrize(
    ("kind", "order"),
    [
        ("tetra10", [0, 3, 1, 4, 2, 5]),
        ("tetra10", [0, 1, 2, 4, 5, 3]),
        ("hexahedron20", [0, 4, 1, 5, 2, 6, 3, 7]),
        ("hexahedron20", [0, 1, 2, 3, 7, 4, 5, 6]),
        ("hexahedron27", [0, 1, 2, 3, 4, 5, 6, 8, 7]),
        ("hexahedron27", [8, 0, 1, 2, 3, 4, 5, 6, 7]),
    ],
)
def test_nodes_amid_edges_are_behind_the_corners_in_their_order(kind: str, order: list[int]) -> None:
    mesh = solid(kind, (3, 2, 2), bent).finite_elements()
    with pytest.raises(lf.ModelError, match=r"faces\['end'\]: node \d+ of facet 0 is not near the middle of its edge"):
        lf.SpatialMatrices(mesh.mass, mesh.stiffness, mesh.places, faces={"end": mesh.facets[:4][:, order]})


@QUIET
@pytest.mark.parametrize("kind", SOLIDS)
def test_a_facet_that_is_given_again_is_refused(kind: str) -> None:
    """Also from another corner on: what touches it would count twice."""
    mesh = solid(kind, (3, 2, 2), bent).finite_elements()
    facets = mesh.facets[:5]
    corners = 3 if facets.shape[1] in (3, 6) else 4
    around = np.r_[np.roll(np.arange(corners), 1), np.arange(corners, facets.shape[1])]
    if facets.shape[1] > corners:
        around[corners : 2 * corners] = corners + np.roll(np.arange(corners), 1)
    for again in (facets[2], facets[2][around]):
        twice = np.vstack([facets, again])
        words = r"faces\['foot'\]: facets 2 and 5 have the same corners .* \(1 facet\(s\) are given again\)"
        with pytest.raises(lf.ModelError, match=words):
            lf.SpatialMatrices(mesh.mass, mesh.stiffness, mesh.places, faces={"foot": twice})
    shared = {"foot": facets, "toe": facets[2:3]}
    lf.SpatialMatrices(mesh.mass, mesh.stiffness, mesh.places, faces=shared)


@QUIET
@pytest.mark.parametrize("bend", [None, bent])
def test_facets_that_cover_one_another_are_refused(bend: Any) -> None:
    """A side cut along its other diagonal; coarse ones over fine ones; in one face or in two."""
    mesh = solid("tetra", (4, 4, 1), bend).finite_elements()
    start = meshed_block("tetra", EDGES, (4, 4, 1)).places
    top = mesh.facets[(abs(start[mesh.facets][..., 2] - EDGES[2]) < 1e-9).all(axis=1)]
    lf.SpatialMatrices(mesh.mass, mesh.stiffness, mesh.places, faces={"top": top})
    number = {tuple(np.rint(place[:2] / EDGES[:2] * 4).astype(int)): k for k, place in enumerate(start) if place[2] > 0}
    small = [number[at] for at in ((1, 1), (2, 1), (2, 2), (1, 2))]
    large = [number[at] for at in ((0, 0), (4, 0), (4, 4))]
    cuts = [[small[i] for i in cut] for cut in ((0, 1, 2), (0, 2, 3), (0, 1, 3), (1, 2, 3))]
    other = [cut for cut in cuts if sorted(cut) not in np.sort(top, axis=1).tolist()]
    assert len(other) == 2
    wrong = [{"top": np.vstack([top, other[:1]])}, {"top": top, "side": np.array(other[:1])}]
    if bend is None:
        wrong.append({"top": np.vstack([top, [large]])})
    for faces in wrong:
        with pytest.raises(lf.ModelError, match=r"faces\['top'\], facet \d+ .* and faces\['.*cover one another"):
            lf.SpatialMatrices(mesh.mass, mesh.stiffness, mesh.places, faces=faces)
