"""The distance of graphs is a metric, does not see how a graph is sampled, and forgives a jump its time."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from lcpflex.errors import ModelError
from lcpflex.studies import graph_distance
from tests.chance import given, settings, st

numbers = st.floats(-1.0, 1.0, allow_subnormal=False)
graphs = st.integers(2, 12).flatmap(
    lambda m: st.tuples(
        st.lists(st.floats(0.0, 1.0), min_size=m, max_size=m).map(lambda t: np.sort(np.array(t))),
        st.lists(st.tuples(numbers, numbers), min_size=m, max_size=m).map(np.array),
    )
)
ACCURACY = 1.03  # documented: 2 % or 5e-6, of each of two distances that are compared


def step(at: float, height: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    return np.array([0.0, at, at, 1.0]), np.array([0.0, 0.0, height, height])


@given(graphs)
@settings(max_examples=25)
def test_equal_graphs_have_no_distance(graph) -> None:
    assert graph_distance(*graph, *graph) < 1e-14


@given(graphs, graphs)
@settings(max_examples=25)
def test_it_is_symmetric_and_the_larger_of_its_sides(one, other) -> None:
    both = graph_distance(*one, *other)
    assert both == pytest.approx(graph_distance(*other, *one), rel=0.03, abs=1e-5)
    sides = [graph_distance(*a, *b, two_sided=False) for a, b in ((one, other), (other, one))]
    assert both == pytest.approx(max(sides), rel=0.03, abs=1e-5)


@given(graphs, graphs, graphs)
@settings(max_examples=25)
def test_a_detour_is_not_shorter(one, between, other) -> None:
    direct = graph_distance(*one, *other)
    detour = graph_distance(*one, *between) + graph_distance(*between, *other)
    assert direct <= ACCURACY * detour + 1e-5


@given(graphs, st.integers(2, 7))
@settings(max_examples=25)
def test_points_between_change_nothing(graph, parts: int) -> None:
    t, y = graph
    share = np.linspace(0.0, 1.0, parts, endpoint=False)
    finer_t = np.append((t[:-1, None] + share * np.diff(t)[:, None]).ravel(), t[-1])
    finer_y = np.vstack([(y[:-1, None] + share[:, None] * np.diff(y, axis=0)[:, None]).reshape(-1, 2), y[-1]])
    finer_t = np.maximum.accumulate(finer_t)  # rounding
    assert graph_distance(t, y, finer_t, finer_y) < 1e-12


@given(graphs, graphs)
@settings(max_examples=15)
def test_it_is_that_of_dense_clouds_of_points(one, other) -> None:
    from scipy.spatial import cKDTree

    def cloud(graph):
        points = np.column_stack(graph)
        share = np.linspace(0.0, 1.0, 400)[:, None]
        return np.vstack([a + share * (b - a) for a, b in pairwise(points)])

    a, b = cloud(one), cloud(other)
    expected = max(cKDTree(b).query(a)[0].max(), cKDTree(a).query(b)[0].max())
    assert graph_distance(*one, *other) == pytest.approx(expected, rel=0.03, abs=0.01)


@pytest.mark.parametrize("late", [1e-6, 1e-4, 1e-2])
@pytest.mark.parametrize("height", [1.0, 100.0])
def test_a_late_jump_costs_its_delay_and_not_its_height(late: float, height: float) -> None:
    assert graph_distance(*step(0.5, height), *step(0.5 + late, height)) == pytest.approx(late, rel=1e-6)


def test_a_jump_of_another_height_costs_the_difference() -> None:
    assert graph_distance(*step(0.5, 1.0), *step(0.5, 1.1)) == pytest.approx(0.1)


def test_a_missing_excursion_is_seen_from_one_side_only() -> None:
    flat = np.array([0.0, 1.0]), np.zeros(2)
    spike = np.array([0.0, 0.5, 0.5, 0.5, 1.0]), np.array([0.0, 0.0, 0.3, 0.0, 0.0])
    assert graph_distance(*flat, *spike, two_sided=False) == 0.0
    assert graph_distance(*spike, *flat, two_sided=False) == pytest.approx(0.3)
    assert graph_distance(*flat, *spike) == pytest.approx(0.3)


def test_the_middle_of_a_segment_may_be_farthest() -> None:
    roof = np.array([0.0, 1.0]), np.array([0.5, 0.5])
    valley = np.array([0.0, 0.5, 1.0]), np.array([0.5, 0.0, 0.5])
    ends = graph_distance(*roof, *valley, two_sided=False)
    assert ends == pytest.approx(0.5 / np.sqrt(2.0), rel=0.02)


def test_scales_divide() -> None:
    one, other = (np.array([0.0, 4.0]), np.zeros(2)), (np.array([0.0, 4.0]), np.full(2, 3.0))
    assert graph_distance(*one, *other, time_scale=4.0, value_scale=30.0) == pytest.approx(0.1)


def test_long_graphs_take_no_time() -> None:
    t = np.linspace(0.0, 1.0, 100_001)
    wave = np.sin(200.0 * t)
    assert graph_distance(t, wave, t, wave + 1e-5) == pytest.approx(1e-5, rel=0.02)


@pytest.mark.parametrize(
    "wrong",
    [
        (np.array([0.0, 1.0]), np.zeros(3)),
        (np.array([1.0, 0.0]), np.zeros(2)),
        (np.array([0.0, 1.0]), np.array([0.0, np.nan])),
        (np.zeros(0), np.zeros(0)),
        (np.array([0.0, 1.0]), np.zeros((2, 2))),
    ],
)
def test_what_is_no_graph_is_refused(wrong) -> None:
    with pytest.raises(ModelError):
        graph_distance(np.array([0.0, 1.0]), np.zeros(2), *wrong)
