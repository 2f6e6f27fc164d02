"""The sphere on a rod as two meshes of revolution, against Hertz' law with one-dimensional waves."""

from __future__ import annotations

import numpy as np
import pytest

import lcpflex as lf
from lcpflex import gallery
from lcpflex.checks.resolution_rules import PAIRS
from lcpflex.gallery.mechanisms import coaxial

CASE = gallery.scenes()["meshed_sphere_on_rod"]
SPEED = 0.3


def run(finest: float = 5e-5, modes: int = 20, stepper: object = None) -> lf.Result:
    scene = gallery.meshed_sphere_on_rod(finest, SPEED, modes)
    stepper = stepper or lf.MasslessBoundary(dynamic_modes=modes)
    return lf.simulate(scene, CASE.duration, stepper, record=2e-7)  # type: ignore[arg-type]


def speeds(result: lf.Result) -> np.ndarray:
    """Of the rod and of the ball, along the axis [m/s]."""
    assert result.compiled is not None
    return result.u[:, result.compiled.model.bodies.dof[:2]]


def restitution(result: lf.Result) -> float:
    rod, ball = speeds(result)[-1]
    return float(rod - ball) / SPEED


@pytest.fixture(scope="module")
def fine() -> lf.Result:
    return run()


def test_restitution_and_contact_time_without_any_law(fine: lf.Result) -> None:
    """Within 5 % of the reference; one push, of at least nine pairs at its peak; nothing to warn of."""
    contact = fine.contact("ball")
    pressed = np.flatnonzero(contact.force[:, 0] > 0.0)
    assert (np.diff(pressed) == 1).all()
    duration = fine.times[pressed[-1]] - fine.times[pressed[0]]
    assert duration == pytest.approx(CASE.reference["contact_time"], rel=0.05)
    assert restitution(fine) == pytest.approx(CASE.reference["restitution"], rel=0.05)
    assert contact.peak_force == pytest.approx(CASE.reference["force"], rel=0.05)
    assert contact.pairs[np.argmax(contact.force[:, 0])] >= PAIRS
    assert not fine.warnings


def test_pairs_close_from_the_middle_and_open_from_the_rim(fine: lf.Result) -> None:
    """Node by node up to the peak, node by node down: none drops out in between."""
    pairs = fine.contact("ball").pairs
    top = int(np.argmax(pairs))
    assert (np.diff(pairs[: top + 1]) >= 0).all()
    assert (np.diff(pairs[top:]) <= 0).all()


def test_momentum_and_energy(fine: lf.Result) -> None:
    assert fine.compiled is not None
    along = speeds(fine) @ fine.compiled.model.bodies.mass
    np.testing.assert_allclose(along, along[0], rtol=1e-9)
    assert fine.energies.largest_remainder < 1e-4 * fine.energies.scale
    kinetic = 0.5 * speeds(fine)[-1] ** 2 @ fine.compiled.model.bodies.mass
    assert kinetic / fine.energies.kinetic[0] == pytest.approx(0.47, abs=0.05)  # the rest is in waves


@pytest.mark.slow
def test_meshes_and_modes_converge(fine: lf.Result) -> None:
    """What is left to the reference is no error of mesh or modes: half as fine, half as many change a part of it."""
    apart = abs(restitution(fine) - CASE.reference["restitution"])
    for other in (run(finest=1e-4), run(modes=10)):
        assert abs(restitution(other) - restitution(fine)) < 0.1 * apart


def test_too_coarse_meshes_are_warned_of() -> None:
    (text,) = run(finest=1.5e-4).warnings
    assert "pairs of touching points" in text
    assert "'ball'" in text


def test_masses_of_the_bodies() -> None:
    ball, rod = coaxial.meshed_ball(modes=4), coaxial.meshed_rod(modes=4)
    assert ball.mass == pytest.approx(4.0 / 3.0 * np.pi * 0.015**3 * 7780.0, rel=2e-3)
    assert rod.mass == pytest.approx(np.pi * 0.01**2 * 2700.0, rel=1e-9)
