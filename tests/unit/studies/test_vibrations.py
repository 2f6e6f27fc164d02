"""Small vibrations about steady states, against closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest

from lcpflex import Beam, Disc, DrivenAngle, Force, ModelError, Revolute, Scene, SolverError, Spring, Table, Weld
from lcpflex.studies.vibrations import small_vibrations

DISC = Disc(0.1, thickness=0.1, density=1000.0)


def pendulum(angle: float) -> Scene:
    scene = Scene()
    bob = scene.add(DISC, angle=angle, position=(math.sin(angle), -math.cos(angle)))
    scene.join(Revolute(bob.at(0.0, 1.0), scene.ground.at(0, 0)))
    return scene


RATE = math.sqrt(9.81 / (1.0 + 0.5 * 0.1**2))  # m g l / (J + m l^2)


@pytest.mark.parametrize("start", [0.0, 0.3])
def test_pendulum_about_where_it_hangs(start):
    found = small_vibrations(pendulum(start))
    assert found.frequencies == pytest.approx([RATE], rel=1e-8)
    assert found.growth == pytest.approx(0.0, abs=1e-8)
    assert found.q == pytest.approx([0.0, -1.0, 0.0], abs=1e-8)


def test_pendulum_upside_down_falls():
    found = small_vibrations(pendulum(math.pi - 0.1))
    assert found.frequencies.size == 0
    assert found.growth == pytest.approx(RATE, rel=1e-8)


def test_dampers_take_energy():
    scene = Scene(gravity=(0, 0))
    disc = scene.add(DISC)
    mass = DISC.mass
    ratio, rate = 0.1, 50.0
    spring = {"stiffness": mass * rate**2, "damping": 2.0 * ratio * rate * mass, "length": 1.0}
    scene.load(Spring(disc.at(0, 0), scene.ground.at(1.0, 0.0), **spring))
    found = small_vibrations(scene)
    moving = found.exponents[np.abs(found.exponents) > 1.0]
    assert moving.real == pytest.approx([-ratio * rate] * 2, rel=1e-6)
    assert np.abs(moving) == pytest.approx([rate] * 2, rel=1e-6)


def test_bead_on_a_turning_spring():
    """Two coupled directions: the exponents s^2 of a turning isotropic spring are -(omega0 +- spin)^2."""
    scene = Scene(gravity=(0, 0))
    disc = scene.add(DISC, angular_velocity=3.0)
    rate = 10.0
    for x, y in ((1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)):
        spring = {"stiffness": 0.25 * DISC.mass * rate**2, "damping": 0.0, "length": 0.0}
        scene.load(Spring(disc.at(0, 0), scene.ground.at(x, y), **spring))
    found = small_vibrations(scene, 3.0).frequencies
    assert found[found > 1.0] == pytest.approx([rate - 3.0, rate + 3.0], rel=1e-6)


def test_a_free_beam_keeps_its_frequencies():
    body = Beam(1.0, 0.02, 0.01, 2700.0, 6.9e10).reduce(6)
    scene = Scene(gravity=(0, 0))
    scene.add(body)
    found = small_vibrations(scene).frequencies
    assert found[found > 1.0] == pytest.approx(body.frequencies(), rel=1e-7)


def test_what_is_never_steady_is_refused():
    scene = Scene()
    disc = scene.add(DISC, angular_velocity=2.0)
    scene.join(Revolute(disc.at(0, 0), scene.ground.at(0, 0)))
    scene.join(DrivenAngle(disc.at(0, 0), scene.ground.at(0, 0), Table((0.0, 1.0), (0.0, 2.0))))
    with pytest.raises(ModelError, match="gravity"):
        small_vibrations(scene, 2.0)
    with pytest.raises(ModelError, match="spin"):
        small_vibrations(scene, math.nan)
    pushed = Scene(gravity=(0, 0))
    pushed.load(Force(pushed.add(DISC).at(0, 0), (1.0, 0.0)))
    with pytest.raises(SolverError, match="steady"):
        small_vibrations(pushed)


@pytest.mark.parametrize("size", [1e-3, 1e-2, 1.0, 1e3])
def test_frequencies_know_no_units(size: float) -> None:
    """Of a cantilever from a millimetre to a kilometre: 3.516 sqrt(E I / (rho A L^4))."""
    scene = Scene(gravity=(0.0, 0.0))
    beam = Beam(size, 0.02 * size, 0.005 * size, 2700.0, 7e10, elements=30).reduce(modes=None)
    arm = scene.add(beam)
    scene.join(Weld(arm.point("left"), scene.ground.at(0.0, 0.0)))
    found = small_vibrations(scene)
    exact = 3.5160153 * math.sqrt(7e10 * 0.005**2 / 12.0 / 2700.0) / size
    assert found.frequencies[0] == pytest.approx(exact, rel=1e-4)
    assert found.growth <= 1e-6 * found.frequencies[0]
