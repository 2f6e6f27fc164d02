"""Drift over a million steps: bounded by projection, and reported, with every stepper."""

from __future__ import annotations

import numpy as np
import pytest

import lcpflex as lf

STEPPERS = [
    pytest.param(lf.MoreauJean(step=1e-4), id="moreau-jean"),
    pytest.param(lf.EventDriven(max_step=1e-4), id="event-driven", marks=pytest.mark.slow),
]


@pytest.mark.parametrize("stepper", STEPPERS)
def test_a_million_steps_keep_joints_and_contacts_in_place(stepper: lf.MoreauJean | lf.EventDriven) -> None:
    """A ball with a rider hinged to it rolls and slides in a bowl: each step leaves it along a tangent."""
    scene = lf.Scene()
    ball = scene.add(lf.Disc(radius=0.1, mass=1.0), position=(0.9, 0.0), name="ball")
    rider = scene.add(lf.RigidBody(0.1, 0.001), position=(0.9, 0.0), name="rider")
    scene.join(lf.Revolute(ball.at(0.0, 0.0), rider.at(0.0, 0.0)))
    scene.contact(ball.surface(), scene.ground.hole((0.0, 0.0), 1.0), friction=0.1)
    result = lf.simulate(scene, 100.0, stepper)
    assert result.steps >= 1_000_000
    assert result.penetration.max() < 1e-6
    assert result.joint_drift.max() < 1e-9
    distance = np.hypot(result.q[:, 0], result.q[:, 1])
    assert np.abs(distance - 0.9).max() < 1e-5
    assert np.abs(result.q[:, 0:2] - result.q[:, 3:5]).max() < 1e-9
    assert result.energies.stored[-1] < result.energies.stored[0]
