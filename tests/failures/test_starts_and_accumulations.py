"""Scenes that begin or go on in awkward states: penetration, touching at the start, infinitely many impacts, drift."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import lcpflex as lf
from lcpflex import gallery
from tests.scenes import disc_on_floor

ALL_IMPACTS_END = 1.354570923  # [s] ball from 1 m, e = 1/2, g = 9.81


def resting_ball(depth: float, speed: float = 0.0, restitution: float = 0.5) -> lf.Scene:
    """A ball of 0.1 m ``depth`` deep in the floor, arriving at ``speed``."""
    return disc_on_floor(0.1 - depth, (0.0, -speed), restitution=restitution)


@pytest.mark.parametrize("stepper", [lf.MoreauJean(step=1e-4), lf.EventDriven()], ids=["moreau-jean", "event-driven"])
def test_initial_penetration(stepper: Any, loud: Any) -> None:
    """A millimetre deep is refused, with the depth; what rounding leaves neither throws the ball up nor sinks it."""
    said = loud(resting_ball(1e-3), 0.1, stepper)
    assert "ModelError" in said
    assert "0.001" in said
    result = lf.simulate(resting_ball(5e-8), 0.5, stepper)
    assert np.abs(result.q[:, 1] - 0.1).max() < 1e-7
    assert np.abs(result.u[-1]).max() < 1e-9
    assert not result.warnings


@pytest.mark.parametrize(
    ("stepper", "error"),
    [(lf.MoreauJean(step=1e-4), 1e-3), (lf.EventDriven(), 1e-9)],
    ids=["moreau-jean", "event-driven"],
)
def test_no_time_to_the_first_impact(stepper: Any, error: float, loud: Any) -> None:
    """Touching and approaching at t = 0: there is no sign change of the gap to be found; the impact is at once.

    A spring takes the time that it takes, and has no restitution to offer, and says so.
    """
    assert "restitution" in loud(resting_ball(0.0, speed=1.0), 0.05, lf.Smooth(lf.Penalty(1e5)))
    result = lf.simulate(resting_ball(0.0, speed=1.0), 0.05, stepper)
    assert result.u[-1, 1] == pytest.approx(0.5 - 9.81 * 0.05, abs=error)
    assert result.q[:, 1].min() > 0.1 - 1e-3


def test_accumulation_of_impacts(loud: Any) -> None:
    """Infinitely many impacts in a finite time; with e nearly 1 they are too many to locate, and the run says so."""
    said = loud(gallery.bouncing_ball(height=1e-6, restitution=0.99999), 2.0, lf.EventDriven(most_events=100.0))
    assert "StepError" in said
    assert "events" in said
    exact = lf.simulate(gallery.bouncing_ball(), 2.0, lf.EventDriven())
    last = [event.time for event in exact.events if event.kind == "impact"][-1]
    assert last == pytest.approx(ALL_IMPACTS_END, abs=1e-6)
    stepped = lf.simulate(gallery.bouncing_ball(), 2.0, lf.MoreauJean(step=1e-4))
    moving = np.abs(stepped.u[:, 1]) > 1e-3
    assert stepped.times[moving][-1] == pytest.approx(ALL_IMPACTS_END, abs=2e-2)
    for result in (exact, stepped):
        assert result.q[-1, 1] == pytest.approx(0.1, abs=1e-6)
        assert not result.warnings


def unprojected_pendulum(duration: float) -> float:
    """Length that a pendulum's rod of 1 m has gained when its constraint is kept at acceleration level only [m]."""

    def rate(_: float, y: np.ndarray) -> np.ndarray:
        position, velocity = y[:2], y[2:]
        tension = (velocity @ velocity - 9.81 * position[1]) / (position @ position)
        return np.array([*velocity, *(np.array([0.0, -9.81]) - tension * position)])

    end = solve_ivp(rate, (0.0, duration), [1.0, 0.0, 0.0, 0.0], rtol=1e-6, atol=1e-6).y[:2, -1]
    return float(np.hypot(*end)) - 1.0


def test_drift_of_constraints_kept_as_accelerations() -> None:
    """The same tolerances: kept at acceleration level alone, the rod grows; here its drift is projected out."""
    assert abs(unprojected_pendulum(40.0)) > 1e-3
    scene = lf.Scene(gravity=(0.0, -9.81))
    bob = scene.add(lf.RigidBody(mass=1.0, inertia=1e-3), name="bob", position=(1.0, 0.0))
    scene.join(lf.Distance(bob.point("center"), scene.ground.at(0.0, 0.0), name="rod"))
    for stepper in (lf.EventDriven(rtol=1e-6, atol=1e-6), lf.MoreauJean(step=1e-3)):
        result = lf.simulate(scene, 40.0, stepper)
        assert np.hypot(result.q[-1, 0], result.q[-1, 1]) == pytest.approx(1.0, abs=1e-8)
        assert result.joint_drift.max() < 1e-4  # of a step, before its projection
