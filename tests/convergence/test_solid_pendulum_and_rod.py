"""A solid pendulum strikes a solid rod: times, forces, impulse, what penalties converge to, and how fine a mesh."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.gallery.mechanisms.solid_strikers import FINE, REACH, solid_pendulum, solid_pendulum_and_rod, solid_rod
from tests.beam_and_rod import Collision, beam_strikes_rod
from tests.rates import assert_rate

pytestmark = pytest.mark.slow
PUSH = 4.6e-4  # [s], of 404 us in contact
FREE = (40, 60)  # modes of pendulum and rod: up to 27 kHz each
CONVERGED = Collision(404e-6, 2470.0, 0.4306)  # of elements of 0.14 mm in another program, by 20 symmetric modes a body


class Bodies(NamedTuple):
    pendulum: lf.SpatialBody
    rod: lf.SpatialBody


@pytest.fixture(scope="module")
def rod() -> lf.SpatialBody:
    return solid_rod().reduce(FREE[1], contact="contact", rows="normal")


def with_residual_modes(fine: float) -> lf.SpatialBody:
    hinge = lf.Interface("hinge", contact=False)
    return solid_pendulum(fine).reduce(FREE[0], contact="contact", rows="normal", interfaces=[hinge])


@pytest.fixture(scope="module")
def nodes_kept() -> Bodies:
    """By Craig and Bampton: the normal displacements of all nodes of the contact region."""
    solids = solid_pendulum(), solid_rod()
    return Bodies(*(s.reduce(n, boundary="contact", rows="normal") for s, n in zip(solids, FREE, strict=True)))


def strike(bodies: Bodies, stepper: object, law: object | None = None) -> lf.Result:
    return lf.simulate(solid_pendulum_and_rod(*bodies, law=law), PUSH, stepper, record=1e-6)


def collision(result: lf.Result) -> Collision:
    hit = result.contact("strike")
    end = float(result.times[np.flatnonzero(hit.normal_force)[-1]])
    return Collision(end, float(hit.normal_force.max()), float(hit.impulse[-1, 0]))


@pytest.fixture(scope="module")
def massless(rod: lf.SpatialBody) -> lf.Result:
    return strike(Bodies(with_residual_modes(FINE), rod), lf.MasslessBoundary(step=1e-6))


def test_beam_and_rod_are_converged() -> None:
    assert beam_strikes_rod() == pytest.approx(beam_strikes_rod(beam=60, rod=150, step=1e-7), rel=2e-3)


def test_collision_is_that_of_converged_solids_and_of_a_beam_and_a_rod(massless: lf.Result) -> None:
    found = collision(massless)
    assert found == pytest.approx(CONVERGED, rel=0.01)
    assert found == pytest.approx(beam_strikes_rod(), rel=0.03)
    assert massless.contact("strike").pairs.max() == 21
    assert abs(massless.energies.stored[-1] / massless.energies.stored[0] - 1.0) < 5e-5


def test_nodes_kept_with_modes_of_the_rest_give_the_same(massless: lf.Result, nodes_kept: Bodies) -> None:
    """Kept nodes have mass, which strikes: forces are means over 10 us, and what single nodes do in parting is left."""
    kept = strike(nodes_kept, lf.MoreauJean(step=4e-7))
    assert collision(kept).impulse == pytest.approx(collision(massless).impulse, rel=2e-3)
    peaks = []
    for result in (kept, massless):
        begin = np.arange(0.0, PUSH - 1e-5, 1e-6)
        impulse = result.contact("strike").impulse[:, 0]
        after, before = (np.interp(at, result.times, impulse) for at in (begin + 1e-5, begin))
        peaks.append(float((after - before).max()) / 1e-5)
    assert peaks[0] == pytest.approx(peaks[1], rel=0.01)


def test_penalty_impulses_converge_as_springs_stiffen(nodes_kept: Bodies) -> None:
    """The springs' compliance 1/k is what is wrong."""
    exact = collision(strike(nodes_kept, lf.MoreauJean(step=1e-7))).impulse
    nodes = (2 * round(REACH / FINE)) ** 2  # of the area of one inside
    stiffness = [3e6, 1e7, 3e7]  # [N/m] a node
    steps = [5e-8, 2.5e-8, 1.4e-8]  # explicit in the law: omega h < 2 of the mass of a node
    off = [
        collision(strike(nodes_kept, lf.MoreauJean(step=step), lf.Penalty(k * nodes))).impulse / exact - 1.0
        for k, step in zip(stiffness, steps, strict=True)
    ]
    assert off[-1] < 0.01 < 0.04 < off[0]
    assert_rate(stiffness, off, -1.0, within=(0.2, 0.2))


def test_nine_closed_nodes_are_few(massless: lf.Result, rod: lf.SpatialBody) -> None:
    """Chen, Liu & Hong 2015: 0.6 mm are too coarse, "at least 9 contact pairs are needed"."""
    few = strike(Bodies(with_residual_modes(6e-4), rod), lf.MasslessBoundary(step=1e-6))
    assert few.contact("strike").pairs.max() == 9
    far, near = (np.abs(np.divide(collision(one), CONVERGED) - 1.0) for one in (few, massless))
    assert far[0] > 0.01
    assert (far > 3.0 * near).all()
