"""Momenta of results against sums over the masses that bodies are made of."""

from __future__ import annotations

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.errors import ModelError
from tests.spatial_scenes import soft_body, thrown


@pytest.fixture(scope="module")
def flight() -> lf.Result:
    return lf.simulate(thrown(), 0.2, lf.MoreauJean(step=1e-3), record=0.02)


def test_momentum_of_a_soft_body_is_the_sum_over_its_masses(flight: lf.Result) -> None:
    masses = soft_body().mass.sum(axis=0)
    places = np.stack([flight.point("soft", str(i)) for i in range(len(masses))], axis=1)
    rates = np.stack([flight.velocity("soft", str(i)) for i in range(len(masses))], axis=1)
    found = flight.momentum("soft")
    assert found.mass == pytest.approx(masses.sum(), rel=1e-14)
    np.testing.assert_allclose(found.linear, np.einsum("n,mni->mi", masses, rates), rtol=0.0, atol=1e-13)
    turning = np.einsum("n,mni->mi", masses, np.cross(places, rates))
    np.testing.assert_allclose(found.angular, turning, rtol=0.0, atol=1e-12)
    centre = np.einsum("n,mni->mi", masses, places) / masses.sum()
    np.testing.assert_allclose(found.centre, centre, rtol=0.0, atol=1e-14)
    own = np.einsum("n,mni->mi", masses, np.cross(places - centre[:, None], rates))
    np.testing.assert_allclose(found.about_centre, own, rtol=0.0, atol=1e-12)


def test_momentum_of_a_rigid_body_is_that_of_its_inertia(flight: lf.Result) -> None:
    J = 2.0 / 12.0 * np.array([0.2**2 + 0.1**2, 0.3**2 + 0.1**2, 0.3**2 + 0.2**2])
    omega, turn = flight.angular_velocity("box", "body"), flight.orientation("box")
    found = flight.momentum("box")
    np.testing.assert_allclose(found.about_centre, turn.apply(J * omega), rtol=0.0, atol=1e-15)
    np.testing.assert_allclose(found.linear, 2.0 * flight.velocity("box", "center"), rtol=0.0, atol=1e-14)


def test_momentum_of_all_bodies_changes_by_their_weight(flight: lf.Result) -> None:
    whole, t = flight.momentum(), flight.times
    weight = np.array([0.0, 0.0, -9.81 * whole.mass])
    np.testing.assert_allclose(whole.linear, whole.linear[0] + t[:, None] * weight, rtol=0.0, atol=1e-6)  # of the step
    parts = [flight.momentum(name) for name in ("box", "ball", "soft")]
    np.testing.assert_allclose(whole.angular, sum(part.angular for part in parts), rtol=0.0, atol=1e-13)
    fallen = whole.centre[0] + t[:, None] * whole.linear[0] / whole.mass - np.outer(t**2, (0.0, 0.0, 0.5 * 9.81))
    np.testing.assert_allclose(whole.centre, fallen, rtol=0.0, atol=1e-6)


def test_momentum_in_the_plane() -> None:
    scene = lf.Scene(gravity=(0.0, 0.0))
    scene.add(lf.Disc(0.1, mass=2.0), "a", (1.0, 2.0), velocity=(3.0, -1.0), angular_velocity=4.0)
    beam = lf.Beam(0.5, 0.02, 0.01, 1000.0, 1e9).reduce(modes=4)
    scene.add(beam, "b", (0.3, 0.2), angle=0.4, velocity=(0.5, 0.1), angular_velocity=20.0, modal=(1e-3, 0, 0, 0))
    result = lf.simulate(scene, 0.05, lf.MoreauJean(step=1e-5), record=0.005)
    disc = result.momentum("a")
    np.testing.assert_allclose(disc.linear, np.tile([6.0, -2.0], (len(result.times), 1)), rtol=1e-12)
    spin = 2.0 * (1.0 * -1.0 - 2.0 * 3.0) + 0.5 * 2.0 * 0.1**2 * 4.0
    np.testing.assert_allclose(disc.angular, spin, rtol=1e-12)
    np.testing.assert_allclose(disc.about_centre, 0.04, rtol=1e-10)
    np.testing.assert_allclose(disc.centre[-1], (1.15, 1.95), rtol=1e-12)
    whole, bent = result.momentum(), result.momentum("b")
    np.testing.assert_allclose(whole.angular, disc.angular + bent.angular, rtol=1e-14)
    assert np.ptp(result.q[:, 6:]) > 1e-5  # it vibrates
    assert np.ptp(bent.linear, axis=0).max() < 1e-6 * np.abs(bent.linear).max()
    assert np.ptp(bent.angular) < 1e-6 * np.abs(bent.angular).max()


def test_unknown_bodies_and_systems_without_bodies_are_refused(flight: lf.Result) -> None:
    with pytest.raises(ModelError, match="body: no body 'bx'"):
        flight.momentum("bx")
    system = lf.UserSystem(q=[1.0], u=[0.0], mass=[[1.0]], force=lambda t, q, u: [-1.0])
    with pytest.raises(ModelError, match="no bodies"):
        lf.simulate(system, 0.01, lf.MoreauJean(step=1e-3)).momentum()
