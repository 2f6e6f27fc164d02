"""Impacts that accumulate under step control end: a slow approach is stopped, and the result says so."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.jit.struct import allocate
from lcpflex.steppers.clock import StepClock
from lcpflex.steppers.pace import Pace
from tests.scenes import disc_on_floor

SCHEMES = [lf.MoreauJean, lf.GeneralizedAlpha]


def bouncing(restitution: float, size: float = 1.0) -> lf.Scene:
    scale = {"radius": 0.1 * size, "mass": 1.0 / size, "gravity": 9.81 * size}
    return disc_on_floor(1.1 * size, restitution=restitution, **scale)


def rest_time(restitution: float) -> float:
    return math.sqrt(2.0 / 9.81) * (1.0 + restitution) / (1.0 - restitution)


@pytest.mark.parametrize("size", [1.0, 1e3])
@pytest.mark.parametrize("restitution", [0.5, 0.8, 0.95])
@pytest.mark.parametrize("scheme", SCHEMES)
def test_a_ball_comes_to_rest(scheme: Any, restitution: float, size: float) -> None:
    duration = rest_time(restitution) + 2.0
    result = lf.simulate(bouncing(restitution, size), duration, scheme(step=1e-4, adaptive=lf.AdaptiveStep()))
    assert result.steps < 20_000
    assert result.q[-1, 1] / size == pytest.approx(0.1, abs=1e-7)
    assert np.abs(result.u[-1]).max() < 1e-9 * size
    moving = result.times[np.abs(result.u[:, 1]) > 1e-4 * size]
    assert moving[-1] == pytest.approx(rest_time(restitution), abs=2e-3 * duration)
    assert result.warnings == ()
    assert (
        "were stopped, not reflected, below a velocity threshold that follows from the tolerances" in result.summary()
    )


@pytest.mark.parametrize("scheme", SCHEMES)
def test_the_threshold_may_be_given(scheme: Any) -> None:
    control = lf.AdaptiveStep(velocity_threshold=0.5)
    result = lf.simulate(bouncing(0.5), 2.0, scheme(step=1e-4, adaptive=control))
    # it strikes with 4.43, 2.21, 1.11, .55 and .28 m/s, and with the last it stays
    assert result.impulse[-1, 0, 0] == pytest.approx(2.0 * 9.81, rel=1e-6)
    stops = math.sqrt(2.0 / 9.81) * (1.0 + 2.0 * (0.5 + 0.25 + 0.125 + 0.0625))
    moving = result.times[np.abs(result.u[:, 1]) > 1e-3]
    assert moving[-1] == pytest.approx(stops, abs=4e-3)
    assert "approaches of up to 0.277 m/s were stopped, not reflected, below a velocity threshold 0.5 m/s" in (
        result.summary()
    )
    assert "velocity_threshold=0.5" in repr(control)


def test_nothing_is_said_of_a_threshold_that_stopped_nothing() -> None:
    result = lf.simulate(bouncing(0.5), 0.6, lf.MoreauJean(step=1e-4, adaptive=lf.AdaptiveStep()))
    assert result.notes == ()


def test_a_threshold_below_zero_is_refused() -> None:
    with pytest.raises(lf.ModelError, match="velocity_threshold"):
        lf.AdaptiveStep(velocity_threshold=-1.0)


def test_a_run_that_comes_down_to_its_shortest_steps_says_so_while_it_runs(caplog: pytest.LogCaptureFixture) -> None:
    pace = Pace(1e-9)
    clock = allocate(StepClock, {}, time=4.0637, steps=100_000, n_shortest=30)
    pace.update(clock)
    assert pace.warnings(clock) == []
    assert caplog.text == ""
    clock.time, clock.steps, clock.n_shortest = 4.063701, 101_000, 980
    pace.update(clock)
    said = caplog.text
    caplog.clear()
    assert "from t = 4.0637 s on, most steps were as short as allowed, 1e-09 s" in said
    assert pace.warnings(clock)[0] in said
    pace.update(clock)
    assert caplog.text == ""  # once


def test_an_interrupted_run_has_its_warnings(monkeypatch: pytest.MonkeyPatch) -> None:
    from lcpflex.steppers.step_doubling import StepDoubling

    loop = StepDoubling.loop

    def interrupted(self: Any, target: int) -> int:
        if self.clock.steps > 100:
            self.clock.n_shortest = self.clock.steps
            raise KeyboardInterrupt
        return loop(self, target)

    monkeypatch.setattr(StepDoubling, "loop", interrupted)
    result = lf.simulate(bouncing(0.5), 1.0, lf.MoreauJean(step=1e-4, adaptive=lf.AdaptiveStep()))
    assert not result.complete
    assert any("as short as allowed" in text for text in result.warnings)
