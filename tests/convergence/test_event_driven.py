"""Rates of the event-driven stepper in smooth motion with constraints, at fixed steps."""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import pairwise

import numpy as np
import numpy.typing as npt
import pytest

import lcpflex as lf

Build = Callable[[], lf.Scene]


def flexible_pendulum() -> lf.Scene:
    """A soft beam, hinged at one end, swings: joint rows and large rotation."""
    beam = lf.Beam(1.0, 0.05, 0.01, 1000.0, 2e8, axial=False).reduce(modes=2)
    scene = lf.Scene(gravity=(0.0, -9.81))
    swinging = scene.add(beam, name="beam", angular_velocity=3.0)
    scene.join(lf.Revolute(swinging.point("left"), scene.ground.at(0.0, 0.0)))
    return scene


def sliding_beam() -> lf.Scene:
    """The end of a swinging beam slides along a wall with friction: joint, closed contact and sliding column."""
    beam = lf.Beam(1.0, 0.05, 0.01, 1000.0, 2e8, axial=False).reduce(modes=2)
    scene = lf.Scene(gravity=(0.0, -9.81))
    a = scene.add(beam, name="beam", angle=0.5, position=(0.0, 0.0))
    foot = (math.cos(0.5), math.sin(0.5))
    scene.join(lf.PointOnLine(a.point("left"), scene.ground.at(0.0, 0.0), axis=(1.0, 0.0)))
    wall = scene.ground.half_plane((0.0, foot[1] - 0.02), (0.0, 1.0))
    block = scene.add(lf.Disc(radius=0.02, mass=0.1), name="disc", position=foot)
    scene.join(lf.Weld(block.point("center"), a.point("right")))
    scene.contact(block.surface(), wall, friction=0.2)
    return scene


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
    [(flexible_pendulum, 0.4, (100, 200, 400), 6e-10), (sliding_beam, 0.12, (50, 100, 200), 4e-13)],
    ids=["hinged beam", "sliding beam"],
)
def test_order_between_events(build: Build, duration: float, counts: tuple[int, ...], error: float) -> None:
    """Order 5: rates come to it from below, 4.8 and 4.9, 4.1 and 4.6.

    At shorter steps rounding would show: it is a tenth of the smallest error of the beam, .14 in its last rate.
    """
    exact = final_state(build, duration, 1600)
    errors = [np.abs(final_state(build, duration, n) - exact).max() for n in counts]
    first, last = [math.log2(coarse / fine) for coarse, fine in pairwise(errors)]
    assert 4.0 < first < last
    assert last == pytest.approx(5.0, abs=0.5)
    assert errors[-1] < error


def test_error_follows_the_tolerance() -> None:
    """Errors are proportional to the tolerance, nearly: a measured exponent of 0.94 over four decades."""

    def state(rtol: float) -> npt.NDArray[np.float64]:
        stepper = lf.EventDriven(rtol=rtol, atol=1e-2 * rtol)
        result = lf.simulate(flexible_pendulum(), 0.4, stepper, record=0.4)
        return np.concatenate([result.q[-1], result.u[-1]])

    exact = state(1e-12)
    tolerances = np.geomspace(1e-5, 1e-9, 9)
    errors = [np.abs(state(rtol) - exact).max() for rtol in tolerances]
    assert np.polyfit(np.log(tolerances), np.log(errors), 1)[0] == pytest.approx(0.94, abs=0.08)
    assert errors[-1] < 1e-9
