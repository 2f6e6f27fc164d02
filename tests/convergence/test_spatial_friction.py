"""Orders of friction in space: of steps while bodies slide on curves, and of discs that roll on their rims."""

from __future__ import annotations

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.gallery.acceptance.check import Check
from lcpflex.gallery.acceptance.space_contact import checks
from lcpflex.runs.simulate import Stepper
from tests.rates import assert_rate

CHECKS = {check.label: check for check in checks()}
STEPS = np.array([4e-3, 2e-3, 1e-3, 5e-4])


def errors(check: Check, steppers: list[Stepper]) -> np.ndarray:
    """(steppers, quantities)."""
    results = [check.run(stepper) for stepper in steppers]
    return np.array([[quantity.error(result) for quantity in check.quantities] for result in results])


def test_moreau_jean_has_order_one_on_a_path_that_friction_bends() -> None:
    found = errors(CHECKS["sliding_puck"], [lf.MoreauJean(step=step) for step in STEPS])
    assert_rate(STEPS, found, 1.0, 0.1)
    assert found[2].max() < 1.2e-3  # 4e-4 across and 1e-3 down, with steps of 1 ms


def scheme_on_a_slope(h: float, steps: int) -> tuple[float, float]:
    """(across, down) of a point that starts across a slope at 1 m/s, mu = tan(slope) = tan(25 degrees).

    v+ = w - h mu g cos(slope) w/|w|, w = v + h g sin(slope) down: the impulse of friction, h mu N long, is against v+.
    """
    pull = 9.81 * np.sin(np.radians(25.0))  # = mu g cos(slope)
    across, down = 1.0, 0.0
    for _ in range(steps):
        down += h * pull
        left = 1.0 - h * pull / np.hypot(across, down)
        across, down = left * across, left * down
    return across, down


def test_what_moreau_jean_misses_there_is_the_error_of_the_scheme() -> None:
    """Its recursion, by hand, is 4.2e-4 off across and 1.07e-3 down, at 1 ms: so is the library, to rounding."""
    result = CHECKS["sliding_puck"].run(lf.MoreauJean(step=1e-3))
    across, down = scheme_on_a_slope(1e-3, result.steps)
    assert result.u[-1, 0] == pytest.approx(across, abs=1e-12)
    assert -result.u[-1, 1] == pytest.approx(down, abs=1e-12)
    assert across - 0.13577602 == pytest.approx(4.16e-4, rel=2e-3)
    assert down - 0.49078244 == pytest.approx(-1.072e-3, rel=2e-3)


def test_generalised_alpha_has_order_two_there() -> None:
    found = errors(CHECKS["sliding_puck"], [lf.GeneralizedAlpha(step=step) for step in STEPS])
    assert_rate(STEPS, found, 2.0, 0.2)


@pytest.mark.parametrize("stepper", [lf.MoreauJean, lf.GeneralizedAlpha])
def test_a_disc_that_rolls_about_its_centre_keeps_its_lean_to_order_two(stepper: type) -> None:
    """The point of contact sticks: the path is smooth."""
    steps = np.array([1e-3, 5e-4, 2.5e-4])
    found = errors(CHECKS["euler_disc"], [stepper(step=step) for step in steps])
    assert_rate(steps, found, 2.0, 0.25)


@pytest.mark.parametrize("stepper", [lf.MoreauJean, lf.GeneralizedAlpha])
def test_a_disc_that_rolls_too_slowly_falls_over_at_the_rate_of_small_leans(stepper: type) -> None:
    """sinh(k t) / k with k^2 = 4 g / (5 R) - 12 v^2 / (5 R^2) for v = .5 m/s, and a lean of .421 degrees at 1.5 s."""
    rate = np.sqrt(0.8 * 9.81 / 0.1 - 2.4 * 25.0)
    expected = 1e-4 * np.sinh(1.5 * rate) / rate
    leans = []
    for step in (5e-4, 2.5e-4):
        result = lf.simulate(lf.gallery.rolling_disc(speed=0.5), 1.5, stepper(step=step), record=0.5)
        leans.append(-np.arcsin(result.orientation("disc").apply([0.0, 0.0, 1.0])[-1, 2]))
    assert abs(leans[1] / expected - 1.0) < 0.015
    assert abs(leans[1] - expected) < abs(leans[0] - expected) + 1e-3 * expected


@pytest.mark.parametrize("stepper", [lf.MoreauJean, lf.GeneralizedAlpha])
def test_a_ball_that_slides_on_a_parabola_has_order_two(stepper: type) -> None:
    """The slip keeps its direction; against x = v_0 t - mu g t^2 gamma_0 / (2 |gamma_0|), still sliding at .4 s."""
    slip = np.array([2.0 + 30.0 * 0.028575, 15.0 * 0.028575])
    expected = np.array([2.0, 0.0]) * 0.4 - 0.5 * 0.2 * 9.81 * 0.4**2 * slip / np.hypot(*slip)
    found = []
    for step in STEPS:
        result = lf.simulate(lf.gallery.billiard_ball(), 0.4, stepper(step=step), record=0.4)
        found.append(np.hypot(*(result.q[-1, :2] - expected)))
    assert_rate(STEPS, np.array(found)[:, None], 2.0, 0.15)


@pytest.mark.parametrize("stepper", [lf.MoreauJean, lf.GeneralizedAlpha])
def test_a_disc_that_sways_as_it_rolls_has_order_two(stepper: type) -> None:
    """Its gyroscopic moments need the velocity at the end of a step, which the forces of the contact change."""
    steps = STEPS[1:]
    found = errors(CHECKS["rolling_disc"], [stepper(step=step) for step in steps])
    assert_rate(steps, found, 2.0, 0.15)
    assert found[1].max() < 6e-4


@pytest.mark.parametrize(("stepper", "order"), [(lf.MoreauJean, 1.0), (lf.GeneralizedAlpha, 2.0)])
def test_orders_of_a_tippe_top(stepper: type, order: float) -> None:
    """How far it has turned over has the order of friction that changes its direction, Jellett's number order two."""
    steps = STEPS[:3] / 16.0
    found = errors(CHECKS["tippe_top"], [stepper(step=step) for step in steps])
    assert_rate(steps, found[:, :1], order, 0.12)
    assert_rate(steps, found[:, 1:], 2.0, 0.12)


def test_jellett_number_of_a_tippe_top_at_a_millisecond() -> None:
    """What the equations of motion keep changes by 4e-4 in the first second."""
    assert errors(CHECKS["tippe_top"], [lf.MoreauJean(step=1e-3)])[0, 1] < 5e-4


def test_moreau_jean_has_order_one_on_a_puck_that_spins_and_stops() -> None:
    """At 1 ms: 4e-5 and 5e-5 m, and 9e-4 rad."""
    found = errors(CHECKS["puck"], [lf.MoreauJean(step=step) for step in STEPS])
    assert_rate(STEPS, found, 1.0, 0.1)
    assert (found[2] * [0.322, 0.322, 1.0] < [5e-5, 6e-5, 1e-3]).all()


def test_event_driven_steps_follow_their_tolerance() -> None:
    for label in CHECKS:
        loose, tight = errors(CHECKS[label], [lf.EventDriven(rtol=1e-5), lf.EventDriven(rtol=1e-8)])
        assert tight.max() < 5e-5
        assert tight.max() <= max(1e-2 * loose.max(), 5e-5)
