"""Planar scenes and their twins in space: joints, drives and loads of both do the same in the plane."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import lcpflex as lf
from lcpflex.jit.kernel import FloatArray

OUT = (0.0, 0.0, 1.0)  # the normal of the plane
GRAVITY = (0.3, -9.81)
PUSH = lf.Harmonic(2.0, 9.0, 0.4)


class Plane:
    """Makes parts of a planar scene."""

    def __init__(self) -> None:
        self.scene: Any = lf.Scene(GRAVITY)
        self.hinge: dict[str, Any] = {}

    def add(self, m: float, J: float, x: float, y: float, angle: float) -> Any:
        return self.scene.add(lf.RigidBody(m, J), position=(x, y), angle=angle)

    def at(self, of: Any, x: float, y: float) -> Any:
        return of.at(x, y)

    def way(self, x: Any, y: Any) -> Any:
        return (x, y)

    def places(self, q: FloatArray) -> FloatArray:
        return q.reshape(len(q), -1, 3)

    def torque(self, value: Any) -> Any:
        return value


class Space(Plane):
    """Makes the same in space."""

    def __init__(self) -> None:
        self.scene = lf.SpatialScene((*GRAVITY, 0.0))
        self.hinge = {"axis": OUT}

    def add(self, m: float, J: float, x: float, y: float, angle: float) -> Any:
        body = lf.SpatialRigidBody(m, np.diag([0.7 * J, 0.6 * J, J]))
        return self.scene.add(body, position=(x, y, 0.0), orientation=Rotation.from_rotvec([0.0, 0.0, angle]))

    def at(self, of: Any, x: float, y: float) -> Any:
        return of.at(x, y, 0.0)

    def way(self, x: Any, y: Any) -> Any:
        return (x, y, 0.0)

    def torque(self, value: Any) -> Any:
        return (0.0, 0.0, value)

    def places(self, q: FloatArray) -> FloatArray:
        bodies = q.reshape(len(q), -1, 7)
        np.testing.assert_allclose(bodies[..., [2, 4, 5]], 0.0, atol=1e-12)
        angle = 2.0 * np.arctan2(bodies[..., 6], bodies[..., 3])
        return np.stack([bodies[..., 0], bodies[..., 1], angle], axis=-1)


def slider_crank(made: Plane, driven: bool) -> None:
    """Crank of 0.1, rod of 0.3, slider on the x axis, with all kinds of loads; moved by a torque, or by its angle."""
    crank = made.add(1.0, 2e-3, 0.05, 0.0, 0.0)
    rod = made.add(0.5, 4e-3, 0.25, 0.0, 0.0)
    slider = made.add(2.0, 1e-2, 0.4, 0.0, 0.0)
    ground = made.scene.ground
    made.scene.join(lf.Revolute(made.at(crank, -0.05, 0.0), made.at(ground, 0.0, 0.0), **made.hinge))
    made.scene.join(lf.Revolute(made.at(rod, -0.15, 0.0), made.at(crank, 0.05, 0.0), **made.hinge))
    made.scene.join(lf.PointOnLine(made.at(rod, 0.15, 0.0), made.at(ground, 0.0, 0.0), made.way(1.0, 0.0)))
    made.scene.join(lf.Prismatic(made.at(slider, 0.0, 0.0), made.at(ground, 0.0, 0.0), made.way(1.0, 0.0)))
    made.scene.join(lf.Distance(made.at(slider, 0.0, 0.05), made.at(rod, -0.15, 0.0)))
    made.scene.load(lf.Spring(made.at(slider, 0.0, 0.0), made.at(ground, 0.1, 0.2), 40.0, 0.5, 0.1))
    made.scene.load(lf.TorsionSpring(made.at(rod, -0.15, 0.0), made.at(crank, 0.05, 0.0), 0.3, 0.01, 0.2, **made.hinge))
    made.scene.load(lf.Force(made.at(rod, 0.1, 0.02), made.way(1.0, PUSH), follower=True))
    made.scene.load(lf.Force(made.at(rod, -0.1, 0.02), made.way(PUSH, 0.5)))
    if driven:
        made.scene.join(
            lf.DrivenAngle(made.at(crank, 0.0, 0.0), made.at(ground, 0.0, 0.0), lf.Harmonic(4.0, 2.0), **made.hinge)
        )
        return
    made.scene.load(lf.Torque(made.at(crank, 0.0, 0.0), made.torque(lf.Harmonic(0.3, 5.0))))


STEPPERS = {"MoreauJean": lf.MoreauJean(step=1e-3), "EventDriven": lf.EventDriven(rtol=1e-11, atol=1e-12)}


@pytest.mark.parametrize("driven", [False, True])
@pytest.mark.parametrize("stepper", STEPPERS)
def test_a_slider_crank_and_its_twin_in_space_move_alike(stepper: str, driven: bool) -> None:
    """Places and angles agree to 1e-8 for 0.3 s: the crank turns over more than a turn where it is driven."""
    found = []
    for made in (Plane(), Space()):
        slider_crank(made, driven)
        run = lf.simulate(made.scene, 0.3, STEPPERS[stepper], progress=False, record=0.05, project=True)
        found.append((made.places(run.q), run))
    planar, spatial = found[0][0], found[1][0]
    assert np.ptp(planar[:, 0, 2]) > (1.0 if driven else 0.1)
    off = (spatial - planar)[..., 2] / (2.0 * np.pi)
    np.testing.assert_allclose(spatial[..., :2], planar[..., :2], rtol=0.0, atol=1e-8)
    np.testing.assert_allclose(off - np.round(off), 0.0, atol=1e-8)
    energies = [run.energies.potential[-1] for _, run in found]
    assert abs(energies[1] - energies[0]) < 1e-7
