"""Faces of solids that are given as matrices: they are those of the solid that the matrices come from."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from tests.solid_meshes import QUIET, bent, solid


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
