"""The slider-crank of Chen, Liu & Hong 2015 as solids: what they print, and the momentum that its pins must give."""

from __future__ import annotations

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.gallery.mechanisms.solid_slider_cranks import solid_slider_crank

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def result() -> lf.Result:
    """From rest into the push, with few modes and long steps."""
    return lf.simulate(solid_slider_crank(4, 3, 1), 0.03, lf.MoreauJean(step=1e-5, theta=0.55), record=0)


def test_it_starts_at_the_printed_angle_and_meets_the_stop_where_that_was_put(result: lf.Result) -> None:
    angle = result.orientation("crank").as_euler("zyx")[:, 0]
    assert angle[0] == pytest.approx(0.29, rel=1e-12)
    begin = result.contact("stop").windows()[0].begin
    # inertia bends the coupler up while it comes down, so that the crank has a little farther to turn
    assert np.interp(begin, result.times, angle) == pytest.approx(0.1, abs=0.01)


def test_spring_gives_what_the_printed_one_does(result: lf.Result) -> None:
    """Energy of the start: 5 N m/rad by 0.29 rad, and the weights above the origin of the heights."""
    masses = result.compiled.model.bodies.mass
    heights = result.q[0, result.compiled.model.bodies.place[:-1] + 1]  # of the frames, which are at the mass centres
    weights = 9.8 * float(masses @ heights)
    assert result.energies.potential[0] == pytest.approx(0.5 * 5.0 * 0.29**2 + weights, rel=1e-9)


def test_wrist_pin_gives_the_slider_its_momentum(result: lf.Result) -> None:
    """Figure 13 is the force between B2 and B3: all momentum of the slider along its guide came through that joint."""
    reaction = result.reaction("wrist pin")
    carried = np.nansum(reaction.force[1:] * np.diff(result.times)[:, None], axis=0) + reaction.impulse[-1]
    b = result.compiled.layout.bodies.index("slider")
    first = int(result.compiled.model.bodies.dof[b])
    momentum = result.compiled.model.bodies.mass[b] * result.u[-1, first]
    assert -carried[0] == pytest.approx(momentum, rel=5e-3)
    assert abs(carried[2]) < 1e-6 * np.linalg.norm(carried)
