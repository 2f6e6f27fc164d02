"""Means of areas that detection keeps while they hardly slip."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from lcpflex.bodies.spatial.surface import SpatialSurface
from lcpflex.compile.spatial.face_areas import AREAS
from lcpflex.contact.detection import detect
from lcpflex.contact.near import near
from lcpflex.contact.rows import contact_rows
from lcpflex.jit.kernel import FloatArray
from tests.unit.contact.test_open_faces import grid, touching

WIDE, MARGIN = 0.1, 1e-3  # [m] of an area amid the face of the slave, half as wide at its corners
LEAST = 0.5e-3 * WIDE  # slip that has all areas looked at anew
RADIUS = 5.0


def plate() -> SpatialSurface:
    return grid(4, 3, 0.3)


def faceted(n: int) -> SpatialSurface:
    """A square of plane facets on a cylinder about x below it."""
    flat = grid(4, n, 0.6)
    places = np.array([point.place for point in flat.points])
    places[:, 2] = -0.5 * places[:, 1] ** 2 / RADIUS
    return replace(flat, points=tuple(replace(p, place=place) for p, place in zip(flat.points, places, strict=True)))


def looked_at(table: Any) -> int:
    """Samples in the last search."""
    return int((np.asarray(table.faces.tried) == table.faces.search).sum())


def kept(model: Any, table: Any, q: FloatArray) -> tuple[int, int]:
    """Detect by a table that keeps means; how many entries there are, and how many samples were looked at."""
    table.faces.kept.used = 1
    n = int(detect(model, q, MARGIN, table))
    return n, looked_at(table)


def slid(q: FloatArray, way: tuple[float, float, float], turn: float = 0.0) -> FloatArray:
    """The first body moved by ``way``, and turned about the normal."""
    moved = q.copy()
    moved[:3] += way
    x, y, z, w = (Rotation.from_euler("z", turn) * Rotation.from_quat(q[[4, 5, 6, 3]])).as_quat()
    moved[3:7] = w, x, y, z
    return moved


def rows_of(model: Any, q: FloatArray, table: Any, n: int) -> FloatArray:
    rows = np.zeros((n, 3, 2, 6))
    for k in range(n):
        contact_rows(model, q, table, k, rows[k, 0], rows[k, 1:])
    return rows


def test_what_slips_a_little_has_the_same_entries_without_a_search() -> None:
    model, table, n, q = touching(plate(), grid(4, 4, 0.6), AREAS)
    assert kept(model, table, q) == (n, looked_at(table)) == (16, 225)
    moved = slid(q, (0.6 * LEAST, -0.7 * LEAST, 2e-6))
    assert kept(model, table, moved) == (n, 0)
    again, count = near(model, moved, MARGIN)
    assert count == n
    np.testing.assert_allclose(table.gap[:n], again.gap[:n], atol=1e-16)
    np.testing.assert_allclose(table.normal[:n], again.normal[:n], atol=1e-14)
    np.testing.assert_allclose(table.area[:n], again.area[:n], rtol=1e-12)
    np.testing.assert_allclose(rows_of(model, moved, table, n), rows_of(model, moved, again, n), atol=1e-12)


@pytest.mark.parametrize(
    ("way", "turn"),
    [((3.0 * LEAST, 0.0, 0.0), 0.0), ((0.0, -3.0 * LEAST, 0.0), 0.0), ((0.0, 0.0, 0.0), 2e-3), ((0.0, 0.0, -0.1), 0.0)],
)
def test_what_moves_more_is_looked_at_anew(way: tuple[float, float, float], turn: float) -> None:
    """Sideways, by turning about the normal, or below the face by more than areas are wide: as by a new table."""
    model, table, _, q = touching(plate(), faceted(5), AREAS)
    kept(model, table, q)
    moved = slid(q, way, turn)
    n, tried = kept(model, table, moved)
    again, count = near(model, moved, MARGIN)
    assert tried == looked_at(again) == 225
    assert n == count
    np.testing.assert_array_equal(table.gap[:n], again.gap[:n])
    np.testing.assert_array_equal(table.area[:n], again.area[:n])


def test_tables_keep_nothing_unless_they_are_told() -> None:
    model, table, n, q = touching(plate(), plate(), AREAS)
    moved = slid(q, (0.5 * LEAST, 0.0, 0.0))
    assert int(detect(model, moved, MARGIN, table)) == n
    assert looked_at(table) == 225


def test_over_facets_gaps_are_wrong_by_a_share_of_what_chords_are() -> None:
    """.4 kappa h s, wherever the edges of the facets are; where none is passed there is less to see."""
    worst = 0.0
    for start in np.linspace(0.0, 0.05, 21):
        model, table, _, q = touching(plate(), faceted(5), AREAS, gap=-2e-3)
        began = slid(q, (0.0, float(start), 0.0))
        n, _ = kept(model, table, began)
        moved = slid(began, (0.0, 0.9 * LEAST, 0.0))
        assert kept(model, table, moved) == (n, 0)
        again, count = near(model, moved, MARGIN)
        assert count == n > 0
        worst = max(worst, float(np.abs(table.gap[:n] - again.gap[:n]).max()))
    assert 0.0 < worst <= 0.4 / RADIUS * 0.12 * 0.9 * LEAST


def test_areas_of_a_large_face_that_are_far_from_the_other_are_not_looked_at() -> None:
    model, _, _, q = touching(grid(4, 12, 1.8), grid(4, 2, 0.3), AREAS)
    corner = slid(q, (0.9, 0.9, 0.0))
    found, count = near(model, corner, MARGIN)
    assert 0 < looked_at(found) < 0.2 * 3600
    assert count == 4  # about the corners of the one facet that both have in common
