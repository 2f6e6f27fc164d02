"""Corners of a tilted face that slide over the edge of another one: no run takes them for a strike.

A body tips over the edge of a box as it slides. It rests on where that edge crosses the sides of its lower face, and
each corner of the face comes down to the edge as it leaves, at up to .3 m/s against the plane of the box.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import lcpflex as lf


def prism(n: int, turned: float) -> lf.bodies.SpatialBody:
    """Regular, with n sides, 100 mm high."""
    angles = 2.0 * math.pi * np.arange(n) / n + turned
    return lf.ConvexHull([(0.05 * math.cos(a), 0.05 * math.sin(a), z) for a in angles for z in (-0.05, 0.05)], mass=1.0)


def tipped(
    body: lf.bodies.SpatialBody, yaw: float, stepper: lf.EventDriven | lf.MoreauJean, ahead: float = 0.0
) -> lf.Result:
    """It leaves the edge before the end."""
    scene = lf.SpatialScene(gravity=(0.0, 0.0, -9.81))
    table = scene.ground.box((-0.5, 0.0, -0.1), (1.0, 1.0, 0.2))
    turn = Rotation.from_euler("z", yaw)
    moved = scene.add(body, "moved", position=(ahead - 0.1, 0.0, 0.05), orientation=turn, velocity=(1.0, 0.0, 0.0))
    scene.contact(moved.surface(), table, friction=0.2)
    return lf.simulate(scene, 0.21, stepper, progress=False)


@pytest.mark.parametrize(
    ("body", "yaw"),
    [
        (lf.Cuboid(0.1, 0.1, 0.1, mass=1.0), 0.3),
        (prism(6, 0.0), 0.0),
        (prism(6, 0.3), 0.0),
        (prism(16, 0.0), 0.0),
        (lf.Cylinder(0.05, 0.1, mass=1.0), 0.0),
    ],
)
@pytest.mark.parametrize("rtol", [1e-6, 1e-9])
def test_corners_that_leave_over_an_edge_strike_nothing(body: lf.bodies.SpatialBody, yaw: float, rtol: float) -> None:
    result = tipped(body, yaw, lf.EventDriven(rtol=rtol))
    known = tipped(body, yaw, lf.MoreauJean(step=1e-4))
    assert result.u[-1] == pytest.approx(known.u[-1], abs=2e-3)  # of 5.7 rad/s; .04 to 2 with strikes
    later = [event for event in result.events if event.kind == "impact" and event.time > 0.11]
    assert not later  # before the body tips, corners of the aligned ones leave side by side


@pytest.mark.parametrize(("step", "ahead"), [(1e-3, 5.966e-4), (1e-4, 9.090909e-5), (2e-5, 0.0)])
def test_corners_that_a_step_finds_just_before_they_leave_strike_nothing(step: float, ahead: float) -> None:
    result = tipped(lf.Cuboid(0.1, 0.1, 0.1, mass=1.0), 0.3, lf.MoreauJean(step=step), ahead)
    assert result.u[-1, 3] == pytest.approx(1.6975, abs=3e-3)  # by event-driven runs; 1.79 with a strike
