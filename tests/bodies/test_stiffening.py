"""Geometric stiffening of bodies: Euler's columns, strings, tension of spinning beams, and what is refused."""

from __future__ import annotations

import math

import numpy as np
import pytest

from lcpflex import Beam, Force, PointOnLine, Revolute, Scene, Weld
from lcpflex.bodies.stiffening import Stiffening
from lcpflex.errors import ModelError
from lcpflex.placed import Placed
from lcpflex.studies.vibrations import Vibrations, small_vibrations

THICKNESS = 0.01
EULER = math.pi**2  # of the beam below: E I = rho A = L = 1, axis inextensible


def unit_beam(elements: int = 20) -> Beam:
    return Beam(1.0, 1.0, THICKNESS, 1.0 / THICKNESS, 12.0 / THICKNESS**3, elements, axial=False)


def pinned(axial_force: float) -> Scene:
    scene = Scene(gravity=(0, 0))
    beam = scene.add(unit_beam().reduce(None, stiffening=Stiffening(axial_force=axial_force)))
    scene.join(Revolute(beam.point("left"), scene.ground.at(0, 0)))
    scene.join(PointOnLine(beam.point("right"), scene.ground.at(0, 0)))
    return scene


@pytest.mark.parametrize("force", [-0.999 * EULER, -5.0, 0.0, 100.0, 1e4])
def test_pinned_beam_under_axial_force(force):
    """omega_k^2 = (k pi)^4 + N (k pi)^2: zero at Euler's load, a string's k pi sqrt(N) at great tension."""
    k = math.pi * np.arange(1, 4)
    found = small_vibrations(pinned(force)).frequencies[:3]
    assert found**2 == pytest.approx(k**4 + force * k**2, rel=1e-3, abs=1e-5 * EULER**2)
    if force == 1e4:
        assert found == pytest.approx(k * math.sqrt(force), rel=6e-3)


def test_column_buckles_at_eulers_load():
    unit_beam().reduce(3, stiffening=Stiffening(axial_force=-0.9999 * EULER))
    for modes in (0, 3):
        with pytest.raises(ModelError, match=r"axial_force: -9.8\d+ was given.*buckles"):
            unit_beam().reduce(modes, stiffening=Stiffening(axial_force=-1.0001 * EULER))


def loaded_column(part: float) -> Vibrations:
    """A cantilever under a dead load at its tip, of that part of its buckling load, a quarter of Euler's.

    The axial force points from tip to clamp, and buckles it at Euler's load only. A dead load P does not turn with
    the tip's height y: it has P y / L more across.
    """
    load = part * EULER / 4
    scene = Scene(gravity=(0, 0))
    beam = scene.add(unit_beam().reduce(None, stiffening=Stiffening(axial_force=-load)))
    clamp(scene, beam)
    tip = beam.point("right")
    scene.load(Force(tip, lambda t, state: (0.0, load * state.position(tip)[1])))
    return small_vibrations(scene)


def clamp(scene: Scene, beam: Placed) -> None:
    scene.join(Weld(beam.point("left"), scene.ground.at(0, 0)))


def test_column_under_a_load_that_keeps_its_direction():
    assert loaded_column(0.0).frequencies[0] == pytest.approx(3.5160, rel=1e-4)
    assert loaded_column(0.9999).frequencies[0] ** 2 == pytest.approx(0.0, abs=2e-3)
    assert loaded_column(0.9999).growth < 1e-6
    assert loaded_column(1.0001).growth > 0.01
