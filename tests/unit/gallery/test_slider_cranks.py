"""The slider-crank of Chen, Liu & Hong 2015: what they print of it, and the momentum that its pins must give."""

from __future__ import annotations

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.gallery.mechanisms.slider_cranks import slider_crank_with_stop
from lcpflex.jit.kernel import FloatArray

MODES = (3, 2, 1)  # of coupler, stop and slider


def test_crank_is_rigid_and_three_bodies_are_flexible() -> None:
    scene = slider_crank_with_stop(*MODES)
    compiled = scene.compile()
    modes = np.diff(compiled.model.bodies.dof) - 3
    assert {name for name, n in zip(compiled.layout.bodies, modes, strict=True) if n} == {"coupler", "slider", "stop"}
    assert "crank" in compiled.layout.bodies
    assert scene.gravity == pytest.approx((0.0, -9.8))


def test_spring_of_the_crank_is_the_printed_one() -> None:
    state = slider_crank_with_stop(*MODES).compile().at()
    assert state.h[2] == pytest.approx(-5.0 * 0.29, rel=1e-12)  # the weight of the crank acts at its frame


@pytest.fixture(scope="module")
def result() -> lf.Result:
    """From rest into the push, with few modes and long steps."""
    return lf.simulate(slider_crank_with_stop(*MODES), 0.03, lf.MoreauJean(step=5e-5), record=0)


def test_it_starts_at_the_printed_angle_and_meets_the_stop_where_that_was_put(result: lf.Result) -> None:
    angle = result.angle("crank")
    assert angle[0] == 0.29
    begin = result.contact("stop").windows()[0].begin
    # inertia bends the coupler up while it comes down, so that the crank has a little farther to turn
    assert np.interp(begin, result.times, angle) == pytest.approx(0.1, abs=0.01)
    assert not result.impulse[:, 0, 1].any()  # no friction


def carried(result: lf.Result, joint: str) -> FloatArray:
    """Impulse of a joint over the run, that of its impacts included [N s]."""
    reaction = result.reaction(joint)
    return np.nansum(reaction.force[1:] * np.diff(result.times)[:, None], axis=0) + reaction.impulse[-1]


def test_pins_give_slider_and_coupler_their_momentum(result: lf.Result) -> None:
    """Figure 13 is the force between B2 and B3: all momentum of the slider along its guide came through that joint."""
    state = result.compiled.at(result.q[-1], result.u[-1])
    momentum = state.M @ state.u  # rows of translation: integrals of rho v
    slider, coupler = (result.coordinate_names().index(f"{name}.x") for name in ("slider", "coupler"))
    wrist, crank = carried(result, "wrist pin"), carried(result, "crank pin")  # on the coupler, on the crank
    assert momentum[slider] == pytest.approx(-wrist[0], rel=1e-6)  # M is taken amid the steps
    weight = result.compiled.model.bodies.mass[1] * np.array([0.0, -9.8]) * result.times[-1]
    contact = momentum[coupler : coupler + 2] - wrist + crank - weight
    # the normal turns by a degree or two during the push: the resultant is a little less than the sum
    assert np.linalg.norm(contact) == pytest.approx(result.impulse[-1, 0, 0], rel=1e-3)
