"""The helper of all rates: it tells a rate, and holds it from both sides."""

from __future__ import annotations

import numpy as np
import pytest

from tests.rates import assert_rate, assert_rates, growth, rate

STEPS = np.array([0.1, 0.05, 0.02, 0.01])


def test_powers_are_told() -> None:
    assert rate(STEPS, 3.0 * STEPS**2) == pytest.approx(2.0)
    assert rate(1.0 / STEPS, np.column_stack([STEPS, STEPS**4])) == pytest.approx([-1.0, -4.0])
    assert growth([0.0, 1.0, 3.0], [-2.0, -2.0 * np.exp(-0.5), -2.0 * np.exp(-1.5)]) == pytest.approx(-0.5)


def test_both_sides_are_held() -> None:
    """Slower and faster than expected, either of two quantities, one step of several."""
    assert_rate(STEPS, STEPS**2, 2.0, within=0.1)
    assert_rate(STEPS, STEPS**2.3, 2.0, within=(0.1, 0.4))
    for power in (1.8, 2.5):
        with pytest.raises(AssertionError, match="expected 2"):
            assert_rate(STEPS, STEPS**power, 2.0, within=(0.1, 0.4))
        with pytest.raises(AssertionError, match="expected 2"):
            assert_rate(STEPS, np.column_stack([STEPS**2, STEPS**power]), 2.0, within=(0.1, 0.4))
    late = np.array([1e-1, 2.5e-2, 4e-3, 2e-3])
    assert_rate(STEPS, late, 1.75, within=0.1)
    with pytest.raises(AssertionError, match="expected 2"):
        assert_rates(STEPS, late, 2.0, within=0.1)


def test_an_error_that_does_not_fall_or_is_no_number_fails() -> None:
    for errors in (np.ones(4), np.full(4, np.nan)):
        with pytest.raises(AssertionError, match="expected 2"):
            assert_rate(STEPS, errors, 2.0, within=0.5)
