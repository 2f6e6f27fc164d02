"""The error of its steps that a result states: it leaves the run as it is, and is as large as the error, about."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from lcpflex import gallery
from lcpflex.gallery.mechanisms.flexible import aluminium_strip
from lcpflex.results.stated_error import error_shares
from lcpflex.steppers import step_error
from lcpflex.steppers.fixed_steps import FixedSteps
from tests.scenes import disc_on_spring, floor_of


def bouncing_beam(**law: Any) -> lf.Scene:
    """A soft beam falls on the floor with one end, and goes on vibrating; a rod hangs on its other end."""
    scene = lf.Scene()
    beam = lf.Beam(0.5, 0.02, 0.01, density=1000.0, youngs_modulus=1e7, elements=10).reduce(modes=4)
    body = scene.add(beam, angle=0.3, position=(0.0, 0.02), angular_velocity=1.0)
    scene.contact(body.surface(), floor_of(scene), friction=0.3, **law)
    end = (0.5 * math.cos(0.3), 0.02 + 0.5 * math.sin(0.3))
    velocity = (-0.5 * math.sin(0.3), 0.5 * math.cos(0.3))
    rod = scene.add(lf.Box(0.1, 0.01, mass=0.02), position=(end[0] + 0.05, end[1]), velocity=velocity)
    scene.join(lf.Revolute(body.point("right"), rod.point("left")))
    return scene


LAW = lf.ContactLaw(lf.laws.PowerLaw(1e4, 1.0), lf.laws.HysteresisDamping(0.5))
FIXED = {
    "moreau": lf.MoreauJean(step=5e-4),
    "moreau by law": lf.MoreauJean(step=1e-4),
    "alpha": lf.GeneralizedAlpha(step=5e-4),
    "massless": lf.MasslessBoundary(step=1e-4),
    "verlet": lf.Smooth(lf.Penalty(1e4), integrator=lf.Verlet(1e-4)),
}


@pytest.mark.parametrize("name", FIXED)
def test_samples_leave_the_run_as_it_is(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """To the bit, whatever is recorded, and with samples at every other step."""

    def run(samples: int) -> lf.Result:
        monkeypatch.setattr(step_error, "SAMPLES", samples)
        scene = bouncing_beam(law=LAW) if "law" in name else bouncing_beam()
        return lf.simulate(scene, 0.06, FIXED[name], record=0.0)

    without, sampled = run(0), run(10**6)
    assert without.impulse[-1, 0, 0] > 0.0
    assert without.place_error is None
    assert sampled.place_error > 0.0
    assert sampled.steps == without.steps
    for field in ("times", "q", "u", "force", "impulse", "state", "gap", "residual", "penetration", "size"):
        np.testing.assert_array_equal(getattr(sampled, field), getattr(without, field), err_msg=field)
    np.testing.assert_array_equal(sampled.energies.remainder, without.energies.remainder)
    np.testing.assert_array_equal(sampled.contact_points.force, without.contact_points.force)


def swinging() -> lf.Scene:
    scene = lf.Scene()
    bob = scene.add(lf.Box(0.4, 0.1, mass=1.0), position=(1.0, 0.0))
    scene.join(lf.Revolute(bob.at(-1.0, 0.0), scene.ground.at(0.0, 0.0)))
    return scene


def bouncing() -> lf.Scene:
    return gallery.bouncing_ball(height=0.2, restitution=0.8)


def vibrating() -> lf.Scene:
    return disc_on_spring(400.0)


@pytest.mark.parametrize("build", [swinging, vibrating, bouncing])
@pytest.mark.parametrize("make", [lf.MoreauJean, lf.GeneralizedAlpha], ids=["moreau", "alpha"])
@pytest.mark.parametrize("step", [1e-3, 4e-3])
def test_stated_error_is_about_the_true_one(build: Any, make: Any, step: float) -> None:
    """Within a factor of three of the largest error of a place."""
    exact = lf.simulate(build(), 1.0, lf.EventDriven(rtol=1e-10, atol=1e-12), record=1e-3)
    result = lf.simulate(build(), 1.0, make(step=step), record=0.0)
    q = np.column_stack([np.interp(result.times, exact.times, exact.q[:, i]) for i in range(3)])
    assert result.compiled is not None
    assert result.place_error is not None
    error = step_error.Units(result.compiled.model, 3).of(result.q - q).max()
    assert result.place_error / 3.0 < error < 3.0 * result.place_error


def test_an_own_solver_sees_no_samples() -> None:
    """It is called once a step, as ever; what the steps cost is then not stated."""
    calls = []

    class Counting:
        def solve(self, problem: Any, guess: Any = None) -> Any:
            calls.append(problem.size)
            return lf.Lemke().solve(problem)

    result = lf.simulate(gallery.stick_slip_block(), 0.02, lf.MoreauJean(step=1e-3, solver=Counting()))
    assert len(calls) == result.steps == 20
    assert result.place_error is None
    assert "local errors" not in result.summary()


@pytest.mark.parametrize("make", [lf.MoreauJean, lf.GeneralizedAlpha], ids=["moreau", "alpha"])
def test_coarse_steps_of_a_vibration_are_told(make: Any) -> None:
    """Six steps to a period: out of phase after three of them. Sixty: within two per cent."""
    coarse = lf.simulate(vibrating(), 1.0, make(step=0.05))
    assert max(error_shares(coarse) or (0.0,)) > 0.2
    fine = lf.simulate(vibrating(), 1.0, make(step=2e-3))
    assert max(error_shares(fine) or (1.0,)) < 0.02


def test_a_sample_that_fails_leaves_the_run_as_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    """What a user's function raises at a time that the run itself does not come to is no part of the run."""
    stepper = lf.MoreauJean(step=5e-4)
    plain = lf.simulate(bouncing_beam(), 0.03, stepper)
    made = FixedSteps.half_steps

    def failing(self: Any, *arguments: Any) -> int:
        advance, calls = self._advance, []

        def once(*given: Any) -> int:
            calls.append(advance(*given))
            raise ValueError("of a function of the user")

        self._advance = once
        try:
            return int(made(self, *arguments))
        finally:
            self._advance = advance

    monkeypatch.setattr(FixedSteps, "half_steps", failing)
    result = lf.simulate(bouncing_beam(), 0.03, stepper)
    assert result.complete
    assert result.place_error is None
    assert result.steps == plain.steps
    for field in ("times", "q", "u", "force", "impulse"):
        np.testing.assert_array_equal(getattr(result, field), getattr(plain, field), err_msg=field)


CONTROLLED = {
    "event-driven": lambda tolerance: lf.EventDriven(rtol=tolerance, atol=1e-2 * tolerance),
    "moreau": lambda tolerance: lf.MoreauJean(step=1e-3, adaptive=lf.AdaptiveStep(tolerance, 1e-2 * tolerance)),
    "alpha": lambda tolerance: lf.GeneralizedAlpha(step=1e-3, adaptive=lf.AdaptiveStep(tolerance, 1e-2 * tolerance)),
    "runge-kutta": lambda tolerance: lf.Smooth(
        lf.Penalty(1e4), integrator=lf.ExplicitRungeKutta(rtol=tolerance, atol=1e-2 * tolerance)
    ),
}


def off(result: lf.Result, exact: lf.Result) -> float:
    """Largest error of a place [m]."""
    q = np.column_stack([np.interp(result.times, exact.times, exact.q[:, i]) for i in range(exact.q.shape[1])])
    assert result.compiled is not None
    return float(step_error.Units(result.compiled.model, q.shape[1]).of(result.q - q).max())


@pytest.mark.parametrize("build", [swinging, vibrating])
@pytest.mark.parametrize("tolerance", [1e-3, 1e-5])
@pytest.mark.parametrize("name", CONTROLLED)
def test_error_control_states_what_it_has_accepted(name: str, tolerance: float, build: Any) -> None:
    """At most a third, or twenty times, of the true error: from tolerances and counts it was a thousand times that.

    On a joint, two half steps of Moreau-Jean end with another velocity than a whole one, which does not add up.
    """
    exact = lf.simulate(build(), 1.0, lf.EventDriven(rtol=1e-11, atol=1e-13), record=1e-4)
    result = lf.simulate(build(), 1.0, CONTROLLED[name](tolerance), record=0.0)
    assert result.place_error is not None
    true = off(result, exact)
    assert true < 3.0 * result.place_error
    if name != "moreau" or build is not swinging:
        assert true > result.place_error / 20.0


def colliding() -> lf.Scene:
    """Two discs meet off their centres: the normal, and so the way they part, depends on where they have got to."""
    scene = lf.Scene(gravity=(0.0, 0.0))
    first = scene.add(lf.Disc(0.02, mass=0.01), position=(0.0, 0.02), velocity=(1.5, 0.0))
    other = scene.add(lf.Disc(0.02, mass=0.03), position=(0.1003, 0.0), velocity=(-1.0, 0.0))
    scene.contact(first.surface(), other.surface(), restitution=0.5)
    return scene


def landing() -> lf.Scene:
    """A box that turns lands on a corner."""
    scene = lf.Scene()
    box = scene.add(lf.Box(0.1, 0.06, mass=1.0), position=(0.0, 0.1503), angle=0.5, angular_velocity=5.0)
    scene.contact(box.surface(), floor_of(scene), friction=0.2, restitution=0.5)
    return scene


@pytest.mark.parametrize(("build", "duration"), [(colliding, 0.3), (landing, 0.25)])
@pytest.mark.parametrize("make", [lf.MoreauJean, lf.GeneralizedAlpha], ids=["moreau", "alpha"])
@pytest.mark.parametrize("step", [1e-3, 1e-4])
def test_an_impact_magnifies_what_is_wrong_before_it(build: Any, duration: float, make: Any, step: float) -> None:
    exact = lf.simulate(build(), duration, lf.EventDriven(rtol=1e-10, atol=1e-12), record=1e-4)
    result = lf.simulate(build(), duration, make(step=step), record=0.0)
    assert result.place_error is not None
    assert result.place_error / 20.0 < off(result, exact) < 3.0 * result.place_error


def test_the_pendulum_on_its_stop_states_its_error() -> None:
    """A long swing, then a bar that rattles on its stop: what is wrong by then was all that the impacts magnified."""
    free = aluminium_strip(0.7, 0.028, 0.005).reduce(8)
    exact = lf.simulate(gallery.pendulum().with_bodies({"pendulum": free}), 0.6, lf.MoreauJean(step=1e-6))
    result = lf.simulate(gallery.pendulum().with_bodies({"pendulum": free}), 0.6, lf.MoreauJean(step=1e-5))
    assert result.place_error is not None
    assert result.place_error / 5.0 < off(result, exact) < 3.0 * result.place_error


@pytest.mark.parametrize("name", ["incline_sticks", "rocking_block", "bouncing_ball", "stick_slip"])
def test_what_comes_to_rest_or_rocks_states_next_to_nothing(name: str) -> None:
    case = gallery.scenes()[name]
    result = lf.simulate(case.build(), case.duration, case.stepper)
    assert max(error_shares(result) or (1.0,)) < 1e-3


@pytest.mark.parametrize("stepper", [lf.MoreauJean(step=4e-3), lf.GeneralizedAlpha(step=4e-3)], ids=["moreau", "alpha"])
def test_steps_that_may_have_passed_something_are_sampled(stepper: Any) -> None:
    """A thin plate beside the path: each step is looked at by the run, and its halves are steps like all."""
    scene = lf.Scene()
    bob = scene.add(lf.Box(0.4, 0.1, mass=1.0), position=(1.0, 0.0), velocity=(0.0, 12.0), angular_velocity=12.0)
    scene.join(lf.Revolute(bob.at(-1.0, 0.0), scene.ground.at(0.0, 0.0)))
    plate = scene.ground.chain([(1.25, -3.0), (1.26, -3.0), (1.26, 3.0), (1.25, 3.0)], closed=True)
    scene.contact(bob.surface(), plate)
    result = lf.simulate(scene, 0.5, stepper)
    assert result.place_error is not None
    assert result.place_error > 1e-6
