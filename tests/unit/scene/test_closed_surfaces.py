"""Surfaces of triangles that no solid lies behind are refused."""

from __future__ import annotations

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.bodies.spatial.shapes import SurfaceShape

CORNERS = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
FACES = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])


def surface_of(vertices: np.ndarray, triangles: np.ndarray) -> object:
    shape = SurfaceShape(vertices, triangles, np.zeros((len(vertices), 0, 3)))
    body = lf.SpatialBody(mass=1.0, inertia=np.diag([1.0, 1.0, 1.0]), shape=shape)
    return lf.SpatialScene().add(body, name="wedge").surface()


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e3])
def test_a_tetrahedron_is_taken(scale: float) -> None:
    assert surface_of(scale * CORNERS, FACES)


@pytest.mark.parametrize(
    ("vertices", "triangles", "words"),
    [
        (CORNERS, FACES[:, ::-1], "'wedge'.*enclose -0.167 m.3.*positive volume"),
        (CORNERS * [1.0, 1.0, -1.0], FACES, "'wedge'.*positive volume.*right-handed"),
        (CORNERS, FACES[:3], "'wedge'.*only one triangle has the edge.*closed surface"),
        (CORNERS, np.vstack([FACES[:3], [[1, 3, 2]]]), "'wedge'.*same direction"),
        (CORNERS * [1.0, 1.0, 0.0], FACES, "'wedge'.*triangle 1 .*area 0 m.2"),
        (CORNERS * np.nan, FACES, "vertices: an array with nan in it was given"),
    ],
    ids=["inside out", "left-handed", "open", "one turned", "degenerate", "not a number"],
)
def test_what_is_no_boundary_is_refused(vertices: np.ndarray, triangles: np.ndarray, words: str) -> None:
    with pytest.raises(lf.ModelError, match=words):
        surface_of(vertices, triangles)


RIGID = np.zeros((4, 0, 3))


@pytest.mark.parametrize(
    ("vertices", "triangles", "phi", "message"),
    [
        (CORNERS, FACES + 1, RIGID, "triangles: vertex 4 was given, expected numbers from 0 to 3"),
        (CORNERS, FACES - 1, RIGID, "triangles: vertex -1 was given, expected numbers from 0 to 3"),
        (CORNERS, FACES.astype(float), RIGID, "triangles: .* float64 was given, expected .* integers"),
        (CORNERS, FACES[:, :2], RIGID, r"triangles: .* \(4, 2\) .* expected \(any, 3\) integers"),
        (CORNERS[:, :2], FACES, RIGID, r"vertices: .* shape \(4, 2\) was given, expected shape"),
        (CORNERS, FACES, RIGID[1:], r"phi: .* shape \(3, 0, 3\) was given, expected shape \(4, any, 3\)"),
    ],
)
def test_arrays_that_make_no_surface_are_refused(
    vertices: np.ndarray, triangles: np.ndarray, phi: np.ndarray, message: str
) -> None:
    with pytest.raises(lf.ModelError, match=message):
        SurfaceShape(vertices, triangles, phi)


def test_lists_make_a_surface() -> None:
    shape = SurfaceShape(CORNERS.tolist(), FACES.tolist(), RIGID)
    assert np.array_equal(shape.triangles, FACES)
    assert np.array_equal(shape.vertices, CORNERS)
