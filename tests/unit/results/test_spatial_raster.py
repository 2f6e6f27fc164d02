"""The depth buffer of spatial pictures: what is nearer hides what is behind."""

from __future__ import annotations

import numpy as np
import pytest

from lcpflex.results.spatial.raster import NOBODY, blank, fill_strokes, fill_triangles, resolved


def test_what_is_nearer_hides_what_is_behind_even_where_bodies_cut_into_each_other() -> None:
    """Two triangles that cross in the middle column: each is seen on the side where it is nearer, in any order."""
    first = np.array([[0.0, 0.0, 0.0], [40.0, 0.0, 40.0], [20.0, 80.0, 20.0]])
    second = first * [1.0, 1.0, -1.0] + [0.0, 0.0, 40.0]
    seen = []
    for order in ((0, 1), (1, 0)):
        canvas = blank(40, 20)
        places, owners = np.array([first, second])[list(order)], np.array(order)
        fill_triangles(places, np.ones((2, 3)), np.full((2, 3), 200.0), owners, *canvas)
        seen.append(canvas.owner)
        assert (canvas.owner[10, 5:19] == 1).all()
        assert (canvas.owner[10, 21:35] == 0).all()
        assert canvas.depth[10, 30] == pytest.approx(30.5)
        assert canvas.owner[79, 0] == NOBODY
    np.testing.assert_array_equal(*seen)


def test_lines_are_hidden_by_what_is_nearer_and_shine_through_if_asked_to() -> None:
    wall = np.array([[[0.0, 0.0, 5.0], [80.0, 0.0, 5.0], [0.0, 80.0, 5.0]]])
    line = np.array([[[2.0, 10.0, 0.0], [42.0, 10.0, 10.0]]])
    tint, owner = np.array([[250.0, 0.0, 0.0]]), np.array([1])
    for behind, found in ((0.0, 0), (0.4, 100)):
        canvas = blank(20, 30)
        fill_triangles(wall, np.ones((1, 3)), np.zeros((1, 3)), np.array([0]), *canvas)
        fill_strokes(line, np.array([1.5]), tint, owner, 0.0, behind, *canvas)
        assert canvas.colour[10, 12, 0] == found
        assert canvas.colour[10, 32, 0] == 250
        assert (canvas.colour[14] == 0).all()
    picture = np.zeros((20, 30, 4), np.uint8)
    resolved(*canvas, 100.0, 1, np.zeros((20, 30), np.float32), picture)
    assert picture[5, 5, 3] == 255
    assert picture[19, 29, 3] == 0
