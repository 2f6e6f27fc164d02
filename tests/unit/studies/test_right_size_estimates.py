"""What a study of fidelity extrapolates: the law of errors, and the cost of a run."""

from __future__ import annotations

import math

import pytest

from lcpflex.studies.model_order.estimate import Sample, cost_of, lacking, left_at, trend_of


@pytest.mark.parametrize("rate", [0.7, 1.0, 2.0])
def test_the_law_of_errors_is_found(rate: float) -> None:
    z = {modes: (modes + 0.5) ** -rate for modes in (0, 1, 2, 4, 8, 16, 64, 100)}
    samples = [Sample(modes, 0.3 * (z[modes] - z[64])) for modes in (0, 2, 4, 8, 16)]
    trend = trend_of(samples, 64)
    assert trend.rate == pytest.approx(rate, abs=0.05)
    assert left_at(trend, 64, 100) == pytest.approx(0.3 * (z[64] - z[100]), rel=0.1)
    assert left_at(trend, 100, 100) == 0.0
    assert lacking(samples, 64, 100) >= left_at(trend, 64, 100)


def test_differences_that_do_not_fall_are_not_extrapolated() -> None:
    falling = [Sample(8, 0.08), Sample(16, 0.04), Sample(32, 0.015)]
    scattered = [Sample(8, 0.08), Sample(16, 0.02), Sample(32, 0.03)]
    assert lacking(falling, 64, 100) < 0.01
    assert lacking(scattered, 64, 100) == pytest.approx(math.sqrt(0.02 * 0.03))
    assert lacking(scattered, 100, 100) == 0.0
    assert lacking([], 64, 100) == math.inf
    assert lacking([Sample(0, 0.0), Sample(8, 0.0)], 64, 100) == 0.0


def test_costs_grow_with_the_coordinates() -> None:
    known = [(n, 1e-3 * (20.0 + n)) for n in (3, 11, 67)]
    assert cost_of(known, 123) == pytest.approx(0.143, rel=1e-6)
    assert cost_of([(3, 2.0), (11, 1.0)], 100) >= 1.0  # noise does not make rich ones cheap
    assert cost_of([(n, 1e-3 * (1.0 + n * n)) for n in (3, 5, 11, 35)], 67) == pytest.approx(4.49, rel=1e-3)
    assert cost_of([(3, 0.2), (11, 0.2), (67, 0.77)], 123) >= 0.77
    assert math.isnan(cost_of([], 5))
