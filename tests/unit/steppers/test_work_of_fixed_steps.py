"""What forces do in Verlet's steps: a kick changes the kinetic energy by what they do at the mean velocity, exactly.

Without springs, then, any step accounts for all energy, but for rounding.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

import lcpflex as lf

ROUNDING = 1e-12  # of the largest stored energy, of some dozen steps
WEIGHT, STIFFNESS = 9.81, 1e5


def accounted(scene, step, duration=0.1):
    """Energies of a run in which all is explained."""
    energies = lf.simulate(scene, duration, lf.Smooth(integrator=lf.Verlet(step)), progress=False).energies
    assert energies.largest_remainder < ROUNDING * energies.scale
    return energies


def a_ball(in_space, gravity=0.0, height=1.0, **motion):
    """Of 1 kg, with its scene."""
    up = (0.0, 0.0, 1.0) if in_space else (0.0, 1.0)
    scene = (lf.SpatialScene if in_space else lf.Scene)(gravity=tuple(-gravity * x for x in up))
    shape = (lf.Sphere if in_space else lf.Disc)(0.05, mass=1.0)
    return scene, scene.add(shape, position=tuple(height * x for x in up), **motion)


@pytest.mark.parametrize("in_space", [False, True], ids=["plane", "space"])
def test_loads_do_their_work_once(in_space):
    for step in (2e-2, 5e-3):
        scene, ball = a_ball(in_space)
        still = (0.0,) * (2 if in_space else 1)
        scene.load(lf.Force(ball.point("center"), (lf.Harmonic(3.0, 40.0, 0.3), *still)))
        energies = accounted(scene, step)
        assert np.abs(energies.work).max() > 1e-3


@pytest.mark.parametrize("in_space", [False, True], ids=["plane", "space"])
def test_friction_takes_what_the_body_loses(in_space):
    """It slides at the depth at which the law bears it, and is braked within few steps."""
    for step in (1e-2, 1e-3):
        along = (1.0, 0.0, 0.0) if in_space else (1.0, 0.0)
        scene, ball = a_ball(in_space, WEIGHT, 0.05 - WEIGHT / STIFFNESS, velocity=along)
        floor = scene.ground.plane((0, 0, 0), (0, 0, 1)) if in_space else scene.ground.half_plane((0, 0), (0, 1))
        scene.contact(ball.surface(), floor, friction=0.8, law=lf.Penalty(STIFFNESS, slip_speed=0.1))
        energies = accounted(scene, step)
        assert energies.friction[-1] > 0.1


@pytest.mark.parametrize("in_space", [False, True], ids=["plane", "space"])
def test_a_drive_does_what_the_body_gains(in_space):
    """A ball is turned about its middle: what the joints correct is of the order of the method, 2."""
    unexplained = []
    for step in (1e-2, 1e-3):
        scene, ball = a_ball(in_space)
        middle = scene.ground.at(*((0.0, 0.0, 1.0) if in_space else (0.0, 1.0)))
        about = {"axis": (0.0, 1.0, 0.0)} if in_space else {}
        scene.join(lf.Revolute(ball.point("center"), middle, **about))
        motion = lf.Harmonic(0.5, 30.0, 0.5 * math.pi, -0.5)
        scene.join(lf.DrivenAngle(ball.point("center"), middle, motion, **about))
        energies = lf.simulate(scene, 0.1, lf.Smooth(integrator=lf.Verlet(step)), progress=False).energies
        unexplained.append(energies.relative_remainder)
        assert energies.work.max() > 1e-2
    assert unexplained[1] < 0.02 * unexplained[0]
