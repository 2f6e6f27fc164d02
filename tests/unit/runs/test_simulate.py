"""The driver: arguments, what is stored, interruption, and failures that lose nothing."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.jit.kernel import FloatArray
from lcpflex.solvers.problem import Lcp, Solution, Status
from tests.scenes import disc_on_floor, floor_of


def falling_ball(**contact: float) -> lf.Scene:
    return disc_on_floor(0.6, gravity=10.0, **contact)


@pytest.mark.parametrize(
    ("arguments", "name"),
    [
        ({"duration": 0.0}, "duration"),
        ({"duration": -1.0}, "duration"),
        ({"duration": math.nan}, "duration"),
        ({"duration": "1 s"}, "duration"),
        ({"record": -0.1}, "record"),
        ({"stepper": "moreau-jan"}, "stepper"),
        ({"stepper": lf.MoreauJean}, "stepper"),
        ({"scene": "ball"}, "scene"),
    ],
)
def test_bad_arguments_are_named(arguments: dict[str, Any], name: str) -> None:
    given = {"scene": falling_ball(), "duration": 0.1, "stepper": lf.MoreauJean(1e-3), **arguments}
    with pytest.raises(lf.ModelError, match=name):
        lf.simulate(given.pop("scene"), given.pop("duration"), given.pop("stepper"), **given)


def test_the_last_step_is_shortened_to_end_on_the_duration() -> None:
    result = lf.simulate(falling_ball(), 0.0105, lf.MoreauJean(1e-3))
    assert result.times[-1] == pytest.approx(0.0105, abs=1e-15)
    assert result.steps == 11
    assert result.u[-1, 1] == pytest.approx(-0.105, abs=1e-12)
    assert result.complete


def test_the_record_interval_is_kept_and_both_ends_are_stored() -> None:
    result = lf.simulate(falling_ball(), 0.0205, lf.MoreauJean(1e-3), record=5e-3)
    np.testing.assert_allclose(result.times, [0.0, 0.005, 0.010, 0.015, 0.020, 0.0205], rtol=0, atol=1e-12)


def test_more_contacts_than_expected_make_room_for_themselves() -> None:
    """Forty balls land at once: more contacts than the first workspace holds."""
    scene = lf.Scene(gravity=(0.0, -10.0))
    for k in range(40):
        scene.add(lf.Disc(radius=0.1, mass=1.0), name=f"ball{k}", position=(0.3 * k, 0.11))
    floor_of(scene)
    scene.contact_all(friction=0.3)
    result = lf.simulate(scene, 0.2, lf.MoreauJean(1e-3))
    assert np.abs(result.q[-1, 1::3] - 0.1).max() < 1e-3
    assert (result.state[-1] > 0).sum() == 40
    assert result.size.max() == 3  # each ball is a problem of its own
    weight = result.force[-1, :, 0].sum()
    assert weight == pytest.approx(40 * 10.0, rel=1e-9)


def test_forces_impulses_and_states_of_a_resting_ball() -> None:
    result = lf.simulate(falling_ball(), 0.6, lf.MoreauJean(1e-3))
    floor = result.contact("floor")
    assert floor.force[-1, 0] == pytest.approx(10.0, rel=1e-9)
    assert floor.impulse[-1, 0] == pytest.approx(0.6 * 10.0, rel=1e-6)  # all that gravity gave
    assert floor.state[0] == 0
    assert floor.state[-1] != 0
    touching = result.contact_points
    last = touching.record == len(result.times) - 1
    np.testing.assert_allclose(touching.place[last], [[0.0, 0.0]], atol=1e-2)
    np.testing.assert_allclose(touching.normal[last], [[0.0, 1.0]], atol=1e-12)


def test_energies_balance_over_an_inelastic_landing() -> None:
    result = lf.simulate(falling_ball(), 0.6, lf.MoreauJean(1e-4))
    energies = result.energies
    assert energies.impact[-1] == pytest.approx(10.0 * 0.5, rel=1e-3)
    assert energies.largest_remainder < 1e-6
    assert not result.warnings


class Stubborn:
    """A solver that gives up after some problems."""

    def __init__(self, patience: int) -> None:
        self.left = patience

    def solve(self, problem: Lcp, guess: Solution | None = None) -> Solution:
        solution = lf.Lemke().solve(problem, guess)
        self.left -= problem.size > 0
        if self.left >= 0:
            return solution
        nothing = np.zeros(problem.size)  # a point that solves the problem would be taken, whatever is said of it
        return Solution(nothing, problem.slack(nothing), Status.RAY, 1.0, 1, "stubborn", "gave up")


def test_a_failing_solver_loses_nothing() -> None:
    with pytest.raises(lf.StepError, match="not solved") as caught:
        lf.simulate(falling_ball(), 1.0, lf.MoreauJean(1e-3, solver=Stubborn(50)))
    error = caught.value
    assert error.contacts == ("floor",)
    assert error.time == pytest.approx(0.366, abs=2e-3)  # touch-down at sqrt(0.1) s, then 50 steps
    assert error.step == round(error.time / 1e-3)
    assert not error.result.complete
    assert error.result.times[-1] == pytest.approx(error.time, abs=1.5e-3)
    assert "incomplete" in error.result.summary().lower()


def test_a_callback_that_fails_on_the_way_loses_nothing() -> None:
    scene = falling_ball()

    def gust(t: float) -> tuple[float, float]:
        if t > 0.05:
            raise RuntimeError("no wind data")
        return (1.0, 0.0)

    scene.load(lf.Force(scene.body("disc").at(0.0, 0.0), gust))
    with pytest.raises(lf.StepError, match="no wind data") as caught:
        lf.simulate(scene, 1.0, lf.MoreauJean(1e-3))
    assert caught.value.result.times[-1] == pytest.approx(0.05, abs=2e-3)


def test_ctrl_c_returns_what_there_is() -> None:
    scene = falling_ball()

    def press(t: float) -> tuple[float, float]:
        if t > 0.03:
            raise KeyboardInterrupt
        return (0.0, 0.0)

    told = lf.Function(press, shortest=1.0)  # of what is told nothing is probed before the run
    scene.load(lf.Force(scene.body("disc").at(0.0, 0.0), told))
    result = lf.simulate(scene, 1.0, lf.MoreauJean(1e-3))
    assert not result.complete
    assert "interrupted" in result.message
    assert result.times[-1] == pytest.approx(0.03, abs=2e-3)


def test_a_step_too_long_for_a_stiff_spring_is_an_error_not_a_result() -> None:
    scene = lf.Scene(gravity=(0.0, 0.0))
    ball = scene.add(lf.Disc(radius=0.1, mass=1.0), position=(0.0, 0.0))
    scene.load(lf.Spring(ball.at(0.0, 0.0), scene.ground.at(1.0, 0.0), stiffness=1e8, length=0.9))
    with pytest.raises(lf.StepError, match="no longer finite"):
        lf.simulate(scene, 10.0, lf.MoreauJean(1e-2))


@pytest.mark.parametrize("answer", [ValueError("boom"), None], ids=["raises", "returns nothing"])
def test_a_broken_solver_loses_nothing(answer: Exception | None) -> None:
    class Broken:
        def solve(self, problem: Lcp, guess: Solution | None = None) -> Solution | None:
            if problem.size == 0:
                return lf.Lemke().solve(problem)
            if answer is not None:
                raise answer
            return None

    with pytest.raises(
        lf.StepError, match="raised ValueError: boom" if answer else "returned None instead of z"
    ) as caught:
        lf.simulate(falling_ball(), 1.0, lf.MoreauJean(1e-3, solver=Broken()), record=1e-3)  # type: ignore[arg-type]
    assert caught.value.__cause__ is answer or answer is None
    assert caught.value.result.times.size > 100
    assert not caught.value.result.complete


@pytest.mark.parametrize("stepper", [lf.MoreauJean(1e-3), lf.EventDriven()], ids=["moreau-jean", "event-driven"])
def test_a_failure_at_the_very_start_has_a_result_too(stepper: lf.MoreauJean | lf.EventDriven) -> None:
    calls = []

    def fragile(t: float, q: FloatArray, u: FloatArray) -> FloatArray:
        calls.append(t)
        if len(calls) > 1:  # the first call is the trial
            raise RuntimeError("no table")
        return np.zeros(3)

    with pytest.raises(lf.StepError, match="no table") as caught:
        lf.simulate(lf.UserSystem(q=np.zeros(3), u=np.zeros(3), mass=np.eye(3), force=fragile), 0.1, stepper)
    assert "INCOMPLETE" in caught.value.result.summary()


def test_a_quadratic_program_refuses_friction_before_time_is_spent() -> None:
    scene = lf.Scene()
    ball = scene.add(lf.Disc(0.1, mass=1.0), position=(0.0, 5.0))
    scene.contact(ball.surface(), floor_of(scene), friction=0.3)
    with pytest.raises(lf.ModelError, match=r"solver: .*friction \(up to 0.3\), expected Lemke"):
        lf.simulate(scene, 0.1, lf.MoreauJean(1e-3, solver=lf.QuadraticProgram("clarabel")))


def test_created_energy_is_said() -> None:
    """Newton's law with friction on a slender body that lands askew: the result must say that it gained energy."""
    from lcpflex import gallery

    result = lf.simulate(gallery.double_pendulum(), 0.02, lf.MoreauJean(1e-5))
    assert any("created energy" in warning for warning in result.warnings)


def test_user_functions_are_checked_before_time_is_spent() -> None:
    def system(**changes: Any) -> lf.UserSystem:
        given: dict[str, Any] = {"q": [0.0], "u": [0.0], "mass": np.eye(1), "force": lambda t, q, u: np.zeros(1)}
        return lf.UserSystem(**{**given, **changes})

    def wrong(t: float, q: FloatArray, u: FloatArray) -> FloatArray:
        return np.zeros(2)

    def broken(t: float, q: FloatArray, u: FloatArray) -> FloatArray:
        raise ValueError("no such table")

    system()
    for changes, name in (
        ({"force": wrong}, "force"),
        ({"force": broken}, "no such table"),
        ({"mass": -np.eye(1)}, "mass"),
        ({"mass": [[math.nan]]}, "mass"),
        ({"u": [0.0, 0.0]}, "u"),
        ({"gaps": lambda q: q}, "normals"),
        ({"gaps": lambda q: q, "normals": np.eye(1), "friction": -0.1}, "friction"),
        ({"gaps": lambda q: q, "normals": np.eye(1), "restitution": 1.1}, "restitution"),
        ({"gaps": lambda q: q, "normals": np.eye(1), "friction": 0.1}, "tangents"),
        ({"gaps": lambda q: q, "normals": np.eye(1), "names": ("a", "b")}, "names"),
        ({"constraints": lambda t, q: q}, "jacobian"),
    ):
        with pytest.raises(lf.ModelError, match=name):
            system(**changes)
