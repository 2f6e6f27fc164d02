"""Rates of the event-driven stepper in smooth motion with constraints, at fixed steps."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt
import pytest

import lcpflex as lf
from tests.rates import assert_rate, rate
from tests.scenes import sliding_beam, swinging_beam

Build = Callable[[], lf.Scene]


def final_state(build: Build, duration: float, steps: int) -> npt.NDArray[np.float64]:
    h = duration / steps
    fixed = lf.EventDriven(rtol=1e9, atol=1e9, first_step=h, max_step=h)
    result = lf.simulate(build(), duration, fixed, record=duration)
    assert not [e for e in result.events if e.time > 0.0]
    assert result.steps == steps
    assert result.joint_drift.max() < 1e-8
    return np.concatenate([result.q[-1], result.u[-1]])


@pytest.mark.parametrize(
    ("build", "duration", "counts", "error"),
    [(swinging_beam, 0.4, (100, 200, 400), 6e-10), (sliding_beam, 0.12, (50, 100, 200), 4e-13)],
    ids=["hinged beam", "sliding beam"],
)
def test_order_between_events(build: Build, duration: float, counts: tuple[int, ...], error: float) -> None:
    """Order 5: rates come to it from below, 4.8 and 4.9, 4.1 and 4.6.

    At shorter steps rounding would show: it is a tenth of the smallest error of the beam, .14 in its last rate.
    """
    exact = final_state(build, duration, 1600)
    steps = 1.0 / np.array(counts)
    errors = [np.abs(final_state(build, duration, n) - exact).max() for n in counts]
    assert 4.0 < rate(steps[:2], errors[:2]) < rate(steps[1:], errors[1:])
    assert_rate(steps[1:], errors[1:], 5.0, within=0.5)
    assert errors[-1] < error


def test_error_follows_the_tolerance() -> None:
    """Errors are proportional to the tolerance, nearly: a measured exponent of 0.94 over four decades."""

    def state(rtol: float) -> npt.NDArray[np.float64]:
        stepper = lf.EventDriven(rtol=rtol, atol=1e-2 * rtol)
        result = lf.simulate(swinging_beam(), 0.4, stepper, record=0.4)
        return np.concatenate([result.q[-1], result.u[-1]])

    exact = state(1e-12)
    tolerances = np.geomspace(1e-5, 1e-9, 9)
    errors = [np.abs(state(rtol) - exact).max() for rtol in tolerances]
    assert_rate(tolerances, errors, 0.94, within=0.08)
    assert errors[-1] < 1e-9
