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

Build = Callable[[], lf.Scene]
Array = npt.NDArray[np.float64]


def rigid_pendulum() -> lf.Scene:
    scene = lf.Scene(gravity=(0.0, -9.81))
    body = scene.add(lf.Box(1.0, 0.1, mass=1.0), position=(0.5, 0.0), velocity=(0.0, 0.5), angular_velocity=1.0)
    scene.join(lf.Revolute(body.at(-0.5, 0.0), scene.ground.at(0.0, 0.0)))
    return scene


def damped_pendulum() -> lf.Scene:
    """A soft beam with modal damping, hinged at one end, swings."""
    beam = lf.Beam(1.0, 0.05, 0.01, 1000.0, 2e8, axial=False).reduce(modes=2, damping=0.05)
    scene = lf.Scene(gravity=(0.0, -9.81))
    swinging = scene.add(beam, name="beam", angular_velocity=3.0)
    scene.join(lf.Revolute(swinging.point("left"), scene.ground.at(0.0, 0.0)))
    return scene


def sliding_beam() -> lf.Scene:
    """The end of a swinging beam slides along a wall with friction: joints, closed contact and sliding column."""
    beam = lf.Beam(1.0, 0.05, 0.01, 1000.0, 2e8, axial=False).reduce(modes=2)
    scene = lf.Scene(gravity=(0.0, -9.81))
    body = scene.add(beam, name="beam", angle=0.5, position=(0.0, 0.0))
    foot = (math.cos(0.5), math.sin(0.5))
    scene.join(lf.PointOnLine(body.point("left"), scene.ground.at(0.0, 0.0), axis=(1.0, 0.0)))
    wall = scene.ground.half_plane((0.0, foot[1] - 0.02), (0.0, 1.0))
    disc = scene.add(lf.Disc(radius=0.02, mass=0.1), name="disc", position=foot)
    scene.join(lf.Weld(disc.point("center"), body.point("right")))
    scene.contact(disc.surface(), wall, friction=0.2)
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
    "damped flexible pendulum": (damped_pendulum, 0.4, 200),
    "sliding beam": (sliding_beam, 0.12, 60),
    "rolling disc": (lambda: disc_in_bowl(0.5), 0.5, 60),
    "sliding disc": (lambda: disc_in_bowl(0.05), 0.5, 60),
}


@pytest.mark.parametrize("rho_inf", [1.0, 0.8, 0.3])
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
        rate = -np.polyfit(np.log(steps), np.log(error), 1)[0]
        assert 1.9 < rate < 2.5, error
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
    assert -np.polyfit(np.log(steps), np.log(errors), 1)[0] > 1.6
    assert errors[-1] < 1e-5


def bouncing(step: float) -> Array:
    """Height and speed after three bounces of a ball, of which the times are no multiples of the step."""
    scene = lf.Scene(gravity=(0.0, -10.0))
    ball = scene.add(lf.Disc(radius=0.1, mass=1.0), position=(0.0, 1.1))
    scene.contact(ball.surface(), scene.ground.half_plane((0.0, 0.0), (0.0, 1.0)), restitution=0.8)
    result = lf.simulate(scene, 1.5, GeneralizedAlpha(step))
    assert result.penetration.max() < 1e-12
    return np.array([result.q[-1, 1] - 0.1, result.u[-1, 1]])


def exact_bouncing() -> Array:
    time, speed = math.sqrt(2.0 / 10.0), 0.8 * math.sqrt(20.0)
    while time + 2.0 * speed / 10.0 < 1.5:
        time, speed = time + 2.0 * speed / 10.0, 0.8 * speed
    rest = 1.5 - time
    return np.array([speed * rest - 5.0 * rest**2, speed - 10.0 * rest])


def test_order_one_across_impacts() -> None:
    steps = 1e-2 * 2.0 ** -np.arange(0, 8, 0.25)
    errors = [np.abs(bouncing(float(h)) - exact_bouncing()).max() for h in steps]
    assert 0.8 < np.polyfit(np.log(steps), np.log(errors), 1)[0] < 1.3
    assert errors[-1] < 1e-3
