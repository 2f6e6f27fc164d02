"""Reactions of joints of flexible bodies in space by the balance of momenta, and of drives by their power."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.jit.kernel import FloatArray

GRAVITY = (1.0, -2.0, -9.81)
LENGTH = 0.6


def beam(scene: lf.SpatialScene) -> Any:
    """A soft one along x from the origin, of which the left end bends."""
    bending = 4e-12
    made = lf.SpatialBeam(
        LENGTH,
        1e-5,
        (bending, 2 * bending),
        3 * bending,
        density=2700.0,
        youngs_modulus=7e9,
        shear_modulus=2.6e9,
        elements=12,
    )
    return scene.add(made.reduce(modes=8), "beam", position=(LENGTH / 2, 0, 0))


def rates(values: FloatArray, step: float) -> FloatArray:
    """Time derivative of what is told at equal steps, of order 4, without two at each end."""
    return np.asarray((values[:-4] - 8 * values[1:-3] + 8 * values[3:-1] - values[4:]) / (12 * step))


@pytest.mark.parametrize("on_ground", ["P", "Q"])
@pytest.mark.parametrize("kind", ["ball", "weld"])
def test_flexible_end(kind: str, on_ground: str) -> None:
    """F = dp/dt - m g and M = dL/dt - r_c x m g about the end; a ball joint makes no moment, however its end bends."""
    scene = lf.SpatialScene(gravity=GRAVITY)
    ends = beam(scene).point("left"), scene.ground.at(0, 0, 0)
    ends = ends if on_ground == "Q" else ends[::-1]
    scene.join(lf.Ball(*ends, name="end") if kind == "ball" else lf.Weld(*ends, name="end"))
    step = 1e-4
    result = lf.simulate(scene, 0.02, lf.EventDriven(rtol=1e-10), record=step)
    assert result.compiled is not None
    stiff = result.q[-1, :3] + result.orientation("beam")[-1].apply([-LENGTH / 2, 0, 0])
    assert np.linalg.norm(stiff) > 1e-4, "the end must bend away from where it was in the frame"
    told, momentum = result.reaction("end"), result.momentum()
    sign = 1.0 if on_ground == "Q" else -1.0
    weight = result.compiled.model.bodies.mass[0] * np.array(GRAVITY)
    force = sign * (rates(momentum.linear, step) - weight)
    moment = sign * (rates(momentum.angular, step) - np.cross(momentum.centre[2:-2], weight))
    assert np.abs(told.force[2:-2] - force).max() < 1e-5 * np.abs(force).max()
    if kind == "ball":
        assert np.abs(told.moment).max() < 1e-13 * np.abs(told.force).max()
    assert np.abs(told.moment[2:-2] - moment).max() < 1e-5 * np.abs(force).max() * LENGTH


@pytest.mark.parametrize("stepper", [lf.EventDriven(), lf.MoreauJean(step=1e-5)], ids=lambda s: type(s).__name__)
def test_drives(stepper: Any) -> None:
    """The torque of a driven hinge and the force of a driven slide: those of Newton and Euler."""
    scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
    axis, rate = np.array([1.0, 2.0, -2.0]) / 3.0, 3.0
    J = np.diag([0.2, 0.3, 0.4])
    rotor = scene.add(lf.SpatialRigidBody(2.0, J), "rotor")
    scene.join(lf.Ball(rotor.at(0, 0, 0), scene.ground.at(0, 0, 0)))
    scene.join(lf.Revolute(rotor.at(0, 0, 0), scene.ground.at(0, 0, 0), axis=axis, name="bearing"))
    ends = rotor.at(0, 0, 0), scene.ground.at(0, 0, 0)
    scene.join(lf.DrivenAngle(*ends, lambda t: (0.5 * rate * t * t, rate * t, rate), axis=axis, name="turn"))
    slider = scene.add(lf.SpatialRigidBody(2.0, J), "slider")
    guide = slider.at(0, 0.1, 0), scene.ground.at(0, 0.1, 0)
    scene.join(lf.Prismatic(*guide, axis=axis, name="guide"))
    scene.join(lf.DrivenDisplacement(*guide, lambda t: (-2.0 * t * t, -4.0 * t, -4.0), axis, name="push"))
    result = lf.simulate(scene, 0.01, stepper)
    told = {name: result.reaction(name) for name in ("turn", "push", "bearing", "guide")}
    behind = slice(1, None)  # the first instant: time stepping tells of none
    assert told["turn"].drive is not None
    assert told["push"].drive is not None
    assert told["turn"].drive[behind] == pytest.approx(rate * float(axis @ J @ axis), rel=1e-6)
    assert told["push"].drive[behind] == pytest.approx(-4.0 * 2.0, rel=1e-6)
    assert told["turn"].moment[-1] == pytest.approx(told["turn"].drive[-1] * axis)
    assert told["push"].force[-1] == pytest.approx(told["push"].drive[-1] * axis)
    spin = rate * result.times[-1] * axis  # of the last instant; a step's mean is a little before
    torque = rate * J @ axis + np.cross(spin, J @ spin)
    whole = told["bearing"].moment[-1] + told["turn"].moment[-1]
    assert result.orientation("rotor")[-1].inv().apply(whole) == pytest.approx(torque, abs=2e-4)
    arm = np.array([0.0, 0.1, 0.0])  # of the guide, from the mass centre
    push, hold = told["push"].force[-1], told["guide"].force[-1]
    assert hold @ axis == pytest.approx(0.0, abs=1e-9)
    about_centre = np.cross(arm, push + hold) + told["guide"].moment[-1]
    assert about_centre == pytest.approx(np.zeros(3), abs=1e-9)
    assert push + hold == pytest.approx(-8.0 * axis, abs=1e-8)
