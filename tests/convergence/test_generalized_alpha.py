"""Rates of the generalised-alpha stepper: 2 in smooth motion with joints, damping, sliding, rolling; 1 at impacts."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import numpy.typing as npt
import pytest

import lcpflex as lf
from lcpflex.gallery.mechanisms.rigid import stick_slip_block
from lcpflex.steppers.generalized_alpha.stepper import GeneralizedAlpha
from tests.rates import assert_rate
from tests.scenes import THREE_BOUNCES, after_three_bounces, sliding_beam, swinging_beam, three_bounces

Build = Callable[[], lf.Scene]
Array = npt.NDArray[np.float64]


def rigid_pendulum() -> lf.Scene:
    scene = lf.Scene(gravity=(0.0, -9.81))
    body = scene.add(lf.Box(1.0, 0.1, mass=1.0), position=(0.5, 0.0), velocity=(0.0, 0.5), angular_velocity=1.0)
    scene.join(lf.Revolute(body.at(-0.5, 0.0), scene.ground.at(0.0, 0.0)))
    return scene


def disc_in_bowl(friction: float) -> lf.Scene:
    """A disc rolls down within a circle, or slides, and would bounce if approach by curvature were reflected."""
    scene = lf.Scene(gravity=(0.0, -9.81))
    disc = scene.add(lf.Disc(radius=0.1, mass=1.0), position=(0.9 * math.sin(0.8), -0.9 * math.cos(0.8)))
    bowl = scene.ground.arc((0.0, 0.0), 1.0, start=math.pi, extent=math.pi, hole=True)
    scene.contact(disc.surface(), bowl, friction=friction, restitution=0.7)
    return scene


CASES: dict[str, tuple[Build, float, int]] = {
    "rigid pendulum": (rigid_pendulum, 0.5, 100),
    "damped flexible pendulum": (lambda: swinging_beam(0.05), 0.4, 200),
    "sliding beam": (sliding_beam, 0.12, 60),
    "rolling disc": (lambda: disc_in_bowl(0.5), 0.5, 60),
    "sliding disc": (lambda: disc_in_bowl(0.05), 0.5, 60),
}


@pytest.mark.parametrize("rho_inf", [1.0, pytest.param(0.8, marks=pytest.mark.slow), 0.3])
@pytest.mark.parametrize("name", CASES)
def test_order_two_in_smooth_motion(name: str, rho_inf: float) -> None:
    """State and contact force, against event-driven stepping with tolerance 1e-12."""
    build, duration, coarsest = CASES[name]
    exact = lf.simulate(build(), duration, lf.EventDriven(rtol=1e-12, atol=1e-13), record=duration)
    steps = coarsest * 2 ** np.arange(4)
    states, forces = [], []
    for n in steps:
        result = lf.simulate(build(), duration, GeneralizedAlpha(duration / n, rho_inf), record=duration)
        assert result.steps == n
        assert result.joint_drift.max() < 1e-12
        assert result.penetration.max() < 1e-12
        states.append(np.abs(np.concatenate([result.q[-1] - exact.q[-1], result.u[-1] - exact.u[-1]])).max())
        forces.append(np.abs(result.force[-1] - exact.force[-1]).max(initial=0.0))
    errors = [states, forces] if exact.force.size else [states]
    for error in errors:
        assert_rate(1.0 / steps, error, 2.0, within=(0.1, 0.5))
    assert states[-1] < 1e-3


def test_order_two_through_stick_and_slip() -> None:
    """A switch of friction happens somewhere in a step: the error jumps about, its size falls with h^2."""
    duration = 2.0
    exact = lf.simulate(stick_slip_block(), duration, lf.EventDriven(rtol=1e-12, atol=1e-13), record=duration)
    assert len([e for e in exact.events if e.time > 0.0]) == 3
    steps = np.round(300 * 2.0 ** np.arange(0, 4, 0.25))
    errors = []
    for n in steps:
        result = lf.simulate(stick_slip_block(), duration, GeneralizedAlpha(duration / n), record=duration)
        errors.append(np.abs(np.concatenate([result.q[-1] - exact.q[-1], result.u[-1] - exact.u[-1]])).max())
    assert_rate(1.0 / steps, errors, 2.0, within=0.4)
    assert errors[-1] < 1e-5


def bouncing(step: float) -> Array:
    """Height and speed after three bounces of a ball, of which the times are no multiples of the step."""
    result = lf.simulate(three_bounces(), THREE_BOUNCES, GeneralizedAlpha(step))
    assert result.penetration.max() < 1e-12
    return np.array([result.q[-1, 1] - 0.1, result.u[-1, 1]])


def test_order_one_across_impacts() -> None:
    steps = 1e-2 * 2.0 ** -np.arange(0, 8, 0.25)
    errors = [np.abs(bouncing(float(h)) - after_three_bounces()).max() for h in steps]
    assert_rate(steps, errors, 1.0, within=(0.2, 0.3))
    assert errors[-1] < 1e-3
