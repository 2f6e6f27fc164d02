"""Flexible blocks rest on each other, and equal bars part alike, exactly aligned or not."""

from __future__ import annotations

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.results.doubts import doubts
from tests.flush.flexible import bars, blocks
from tests.flush.places import PI, Place

HEIGHTS = (2, 7 + 8 + 2)  # of both blocks, in q
SPEEDS = (2, 6 + 12 + 2)  # of both bars along them, in u
SPINS = (3, 4, 5, 21, 22, 23)

NEAR = (Place(yaw=1e-9), Place(yaw=1e-7), Place(yaw=PI[0]), Place(aside=1e-9), Place(aside=1e-6))
FARTHER = (Place(), *NEAR, Place(yaw=1e-3), Place(yaw=0.3), Place(aside=0.1), Place(aside=0.1, way=2))


def rest(place: Place, stepper: lf.MoreauJean | lf.GeneralizedAlpha | lf.EventDriven, duration: float) -> None:
    """By less than a hundredth of what they would have fallen, with no energy from nowhere."""
    result = lf.simulate(blocks(place), duration, stepper, progress=False)
    heights = result.q[:, HEIGHTS]
    assert np.abs(heights - heights[0]).max() < 0.01 * 4.9 * duration**2
    assert not doubts(result)


@pytest.mark.parametrize("place", [Place(yaw=1e-7), Place(aside=1e-6)])
def test_flexible_blocks_rest(place: Place) -> None:
    rest(place, lf.MoreauJean(step=1e-4), 5e-3)


@pytest.mark.slow
@pytest.mark.parametrize("place", FARTHER)
@pytest.mark.parametrize("step", [1e-4, 1e-3])
@pytest.mark.parametrize("stepper", [lf.MoreauJean, lf.GeneralizedAlpha])
def test_flexible_blocks_rest_at_more_places(place: Place, step: float, stepper: type) -> None:
    rest(place, stepper(step=step), 0.05)


@pytest.mark.slow
@pytest.mark.parametrize("place", FARTHER)
def test_flexible_blocks_rest_event_driven(place: Place) -> None:
    rest(place, lf.EventDriven(), 2e-3)


@pytest.mark.slow
@pytest.mark.parametrize("place", NEAR)
def test_equal_flexible_bars_part_as_aligned_ones(place: Place) -> None:
    """Momentum is kept, the struck bar leaves as fast to a thousandth, and neither spins."""
    stepper = lf.MoreauJean(step=2e-6)
    aligned, result = (lf.simulate(bars(p), 1.5e-3, stepper, progress=False) for p in (Place(), place))
    assert result.u[-1, SPEEDS].sum() == pytest.approx(-1.0)
    np.testing.assert_allclose(result.u[-1, SPEEDS], aligned.u[-1, SPEEDS], atol=1e-3)
    np.testing.assert_allclose(result.u[-1, SPINS], 0.0, atol=0.01)  # 1 mm/s at their ends
