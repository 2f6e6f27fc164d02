"""Differences at equal times: what cannot be compared never counts as agreement."""

from __future__ import annotations

import math

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.accuracy.outputs import Measured, Output, Part
from lcpflex.studies.convergence.equal_times import apart_at_equal_times

TIP = Output("tip", lambda result: 0.0)


def curve(begin: float, end: float, width: int = 1, lift: float = 0.0) -> Measured:
    times = np.linspace(begin, end, 11)
    return Measured(times, (Part("tip", lift + np.repeat(times[:, None, None], width, axis=2)),), None)


@pytest.mark.parametrize("unit", [1e-9, 1.0, 1e9])
def test_curves_without_common_times_are_infinitely_far_apart(unit: float) -> None:
    found = apart_at_equal_times(TIP, curve(2.0 * unit, 3.0 * unit), curve(0.0, unit))
    assert found.mean == math.inf
    assert found.largest == math.inf


def test_a_curve_that_ends_early_is_compared_where_it_is_known() -> None:
    found = apart_at_equal_times(TIP, curve(0.0, 0.5, lift=0.25), curve(0.0, 1.0))
    assert found.mean == pytest.approx(0.25)
    assert found.largest == pytest.approx(0.25)


@pytest.mark.parametrize("widths", [(1, 2), (2, 1)])
def test_curves_of_different_shapes_are_refused(widths: tuple[int, int]) -> None:
    with pytest.raises(lf.ModelError, match="'tip' has curves of shape"):
        apart_at_equal_times(TIP, curve(0.0, 1.0, widths[0]), curve(0.0, 1.0, widths[1]))
