"""Universal joints against closed forms and another program."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import lcpflex as lf


def test_ratio_of_speeds() -> None:
    """Shafts at an angle b: w_2 = w_1 cos b / (1 - sin^2 b sin^2 theta), theta = 0 where axis_P is across both."""
    b, rate = 0.5, 10.0
    out = np.array([math.cos(b), math.sin(b), 0.0])
    scene = lf.SpatialScene((0.0, 0.0, 0.0))
    turns = Rotation.from_rotvec([0.0, math.pi / 2.0, 0.0]), Rotation.align_vectors([out], [[0.0, 0.0, 1.0]])[0]
    shaft = lf.Cylinder(0.02, 0.3, mass=1.0)
    first = scene.add(shaft, "first", (-0.15, 0.0, 0.0), turns[0])
    second = scene.add(shaft, "second", 0.15 * out, turns[1])
    scene.join(lf.Revolute(first.at(0, 0, -0.15), scene.ground.at(-0.3, 0, 0), axis=(1, 0, 0)))
    scene.join(lf.Cylindrical(second.at(0, 0, 0.15), scene.ground.at(*(0.3 * out)), out))
    across = np.array([0.0, 0.0, 1.0])
    axis, axis_p = turns[0].inv().apply(across), turns[1].inv().apply(np.cross(out, across))
    scene.join(lf.Universal(second.at(0, 0, -0.15), first.at(0, 0, 0.15), axis, axis_p))
    drive = lf.DrivenAngle(
        first.at(0, 0, 0), scene.ground.at(-0.15, 0, 0), lambda t: (rate * t, rate, 0.0), axis=(1, 0, 0)
    )
    scene.join(drive)
    result = lf.simulate(scene, 1.0, lf.EventDriven(rtol=1e-9), record=0.02, project=True)
    expected = rate * math.cos(b) / (1.0 - math.sin(b) ** 2 * np.sin(rate * result.times) ** 2)
    assert result.angular_velocity("second") @ out == pytest.approx(expected, abs=1e-6)


def test_double_pendulum_of_another_program() -> None:
    """Two bodies on universal joints, each two hinges in series, by MuJoCo 4.0.0 (Runge-Kutta, step 1e-4)."""
    scene = lf.SpatialScene()
    inertia = [[0.02, 0.002, 0.0], [0.002, 0.03, 0.001], [0.0, 0.001, 0.015]]
    upper = scene.add(lf.SpatialRigidBody(2.0, inertia, center=(0.2, 0.05, 0.0)))
    inertia = [[0.01, 0.0, 0.001], [0.0, 0.02, 0.0], [0.001, 0.0, 0.015]]
    lower = scene.add(lf.SpatialRigidBody(1.0, inertia, center=(0.1, -0.05, 0.2)), "lower", (0.5, 0.1, 0.0))
    scene.join(lf.Universal(upper.at(0, 0, 0), scene.ground.at(0, 0, 0), (0, 1, 0), (0, 0, 1)))
    scene.join(lf.Universal(lower.at(0, 0, 0), upper.at(0.5, 0.1, 0), (1, 0, 0), (0, 1, 0)))
    result = lf.simulate(scene, 2.0, lf.EventDriven(rtol=1e-10), record=1.0)
    place = result.point("lower", (0.3, 0.0, 0.1))[-1]
    assert place == pytest.approx([0.42923424, 0.20291872, -0.15455449], abs=2e-8)
