"""Detection between bodies flush, equal and aligned, or next to it: never nothing, and the least gap is right."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.flush.pairs import KINDS, anywhere, box, deviations, on_top
from tests.flush.places import mixed, single
from tests.flush.polytopes import between, polytope, separation, shadows_overlap

MARGIN = 2e-3  # [m] up to which detection looks
GAPS = {"touching": 0.0, "one step deep": -1e-3, "apart": 2e-4}  # at 1 m/s and 1e-3 s; 1e-3 of the size [m]

over_kinds = pytest.mark.parametrize("name", KINDS)
over_gaps = pytest.mark.parametrize("gap", GAPS)


@over_kinds
@over_gaps
def test_flush_bodies_are_found_and_their_gap_is_right(name: str, gap: str) -> None:
    places = [*list(single())[:: 9 if "gem" in name else 3], *mixed(30, 1)]
    assert not any(deviations(KINDS[name], on_top(KINDS[name], places, GAPS[gap]), MARGIN).values())


@over_kinds
def test_what_is_found_anywhere_is_near_and_right(name: str) -> None:
    kind = KINDS[name]
    assert not any(deviations(kind, anywhere(kind, 30 if "gem" in name else 150, 5), MARGIN).values())


@pytest.mark.campaign
@over_kinds
def test_what_is_found_at_many_places_anywhere(name: str) -> None:
    kind = KINDS[name]
    assert not any(deviations(kind, anywhere(kind, 10_000, 6), MARGIN).values())


@pytest.mark.slow
@over_kinds
@over_gaps
def test_at_all_places(name: str, gap: str) -> None:
    assert not any(deviations(KINDS[name], on_top(KINDS[name], single(), GAPS[gap]), MARGIN).values())


@pytest.mark.campaign
@over_kinds
@over_gaps
def test_at_many_places(name: str, gap: str) -> None:
    assert not any(deviations(KINDS[name], on_top(KINDS[name], mixed(20_000, 2), GAPS[gap]), MARGIN).values())


def test_brute_force_knows_boxes_whose_distance_is_known() -> None:
    """Face, edge and corner next to each other; depth of what overlaps; edges that cross."""
    cube = polytope(box(1.0, 1.0, 1.0).corners)

    def at(*place: float, turn: Rotation | None = None) -> tuple[float, float]:
        return between(cube, cube.moved(turn or Rotation.identity(), np.array(place)))

    assert len(cube.edges) == 12
    assert len(cube.normals) == 6
    np.testing.assert_allclose(at(1.2, 0.3, 0.0), 0.2)
    np.testing.assert_allclose(at(1.3, 1.4, 0.0), [0.4, 0.5])  # of edges: no axis of a face or pair of edges tells it
    np.testing.assert_allclose(at(1.1, 1.2, 1.2), [0.2, 0.3])
    np.testing.assert_allclose(at(0.9, 0.3, 0.2), -0.1)
    ridge = Rotation.from_euler("yx", [90.0, 45.0], degrees=True)
    roof = cube.moved(Rotation.from_euler("y", 45.0, degrees=True), np.zeros(3))
    crossing = cube.moved(ridge, np.array([0.0, 0.0, np.sqrt(2.0) + 0.1]))
    np.testing.assert_allclose(between(roof, crossing), 0.1)
    assert separation(roof, crossing.moved(Rotation.identity(), np.array([0.0, 0.0, -0.2]))) == pytest.approx(-0.1)


def test_brute_force_knows_how_shadows_overlap() -> None:
    cube = polytope(box(1.0, 1.0, 1.0).corners)
    for x, angle, expected in ((0.3, 0.0, 0.7), (1.2, 0.0, -0.2), (1.0, 45.0, 0.5 * np.sqrt(2.0) - 0.5)):
        turn = Rotation.from_euler("z", angle, degrees=True)
        assert shadows_overlap(cube, cube.moved(turn, np.array([x, 0.0, 9.0]))) == pytest.approx(expected)
