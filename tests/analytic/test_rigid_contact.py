"""Rigid bodies in frictional contact against closed solutions, with both steppers.

Event-driven stepping meets the printed digits; Moreau-Jean is of first order in its step.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from lcpflex import EventDriven, MoreauJean, Result, gallery, simulate
from lcpflex.gallery.acceptance.measures import along_slope, first_stop

REFERENCES = {name: case.reference for name, case in gallery.scenes().items()}


def event_times(result: Result, kind: str, contact: str | None = None) -> list[float]:
    return [e.time for e in result.events if e.kind == kind and contact in (None, e.contact)]


@pytest.mark.parametrize(
    ("stepper", "tolerance"),
    [(MoreauJean(step=1e-5), 2e-5), (EventDriven(), 5e-7)],
    ids=["moreau-jean", "event-driven"],
)
def test_block_on_incline_stops_and_slides_back(stepper: MoreauJean | EventDriven, tolerance: float) -> None:
    reference = REFERENCES["incline"]
    result = simulate(gallery.block_on_incline(), 0.5, stepper, record=1e-4)
    distance, speed = along_slope(result)
    stop = first_stop(result.times, speed)
    assert stop == pytest.approx(reference["stop_time"], abs=tolerance)
    assert distance.max() == pytest.approx(reference["stop_distance"], abs=tolerance)
    assert -speed[-1] / (result.times[-1] - stop) == pytest.approx(reference["slide_back"], abs=5.0 * tolerance)
    assert np.abs(result.u[:, 2]).max() < 1e-12  # it does not tip
    assert result.energies.relative_remainder < 1e-9


@pytest.mark.parametrize("speed", [0.0, 2.0])
@pytest.mark.parametrize("stepper", [MoreauJean(step=1e-4), EventDriven()], ids=["moreau-jean", "event-driven"])
def test_stick_means_stick(stepper: MoreauJean | EventDriven, speed: float) -> None:
    """mu = 0.7 > tan 30: at rest on the slope for 10 s."""
    result = simulate(gallery.block_on_incline(friction=0.7, speed=speed), 10.0, stepper, record=0.01)
    distance, rate = along_slope(result)
    stop = speed / (9.81 * (0.5 + 0.7 * math.sqrt(0.75)))
    resting = result.times > stop + 1e-3
    assert distance[resting] == pytest.approx(speed * stop / 2.0, abs=2e-4 * speed + 1e-13)
    assert np.ptp(distance[resting]) < 1e-13
    assert np.abs(rate[resting]).max() < 1e-13
    assert np.ptp(result.q[resting], axis=0).max() < 1e-12


@pytest.mark.parametrize(
    ("stepper", "tolerance"),
    [(MoreauJean(step=1e-5), 3e-5), (EventDriven(), 1e-8)],
    ids=["moreau-jean", "event-driven"],
)
def test_stick_slip_block(stepper: MoreauJean | EventDriven, tolerance: float) -> None:
    reference = REFERENCES["stick_slip"]
    result = simulate(gallery.stick_slip_block(), 1.9, stepper, record=1e-5)
    slipping = result.times[result.state[:, 0] == 2]
    starts = event_times(result, "slip") or [float(slipping[0])]
    ends = event_times(result, "stick") or [float(slipping[-1])]
    assert len(starts) == len(ends) == 1
    assert starts[0] == pytest.approx(reference["slip_time"], abs=tolerance)
    assert ends[0] == pytest.approx(reference["stick_time"], abs=tolerance)
    assert result.q[-1, 0] == pytest.approx(reference["displacement"], abs=tolerance)


@pytest.mark.parametrize(
    ("stepper", "tolerance"),
    [(MoreauJean(step=1e-6), 2e-6), (EventDriven(), 1e-8)],
    ids=["moreau-jean", "event-driven"],
)
def test_block_on_spring_turns_four_times_and_rests(stepper: MoreauJean | EventDriven, tolerance: float) -> None:
    reference = REFERENCES["spring_block"]
    result = simulate(gallery.spring_block(), 0.15, stepper, record=1e-6)
    x = result.q[:, 0]
    half = math.pi / 100.0
    for k in (1, 2, 3):
        near = np.abs(result.times - k * half) < 0.5 * half
        extreme = x[near].min() if k % 2 else x[near].max()
        assert extreme == pytest.approx(reference[f"turn_{k}"], abs=1e-8)
    assert x[-1] == pytest.approx(reference["rest"], abs=1e-8)
    ends = event_times(result, "stick") or [float(result.times[result.state[:, 0] == 2][-1])]
    assert ends[-1] == pytest.approx(reference["rest_time"], abs=tolerance)


@pytest.mark.parametrize(
    ("stepper", "first", "rest"),
    [(MoreauJean(step=1e-5), 1e-5, 1e-4), (EventDriven(), 5e-8, 3e-7)],
    ids=["moreau-jean", "event-driven"],
)
def test_bouncing_ball_comes_to_rest(stepper: MoreauJean | EventDriven, first: float, rest: float) -> None:
    """Infinitely many bounces, e = 0.5: the accumulation is passed.

    Impacts below 1e-6 m/s end the accumulation of the event-driven stepper, 2e-7 s early.
    """
    reference = REFERENCES["bouncing_ball"]
    result = simulate(gallery.bouncing_ball(), 1.6, stepper, record=1e-5)
    impulse = result.impulse[:, 0, 0]
    impacts = event_times(result, "impact") or [float(result.times[np.flatnonzero(impulse)[0] - 1])]
    assert impacts[0] == pytest.approx(reference["first_impact"], abs=first)
    ends = event_times(result, "touch-down") or [float(result.times[result.state[:, 0] == 0][-1])]
    assert ends[-1] == pytest.approx(reference["rest_time"], abs=rest)
    assert np.ptp(result.q[result.times > 1.4, 1]) < 1e-8
    assert result.energies.impact[-1] == pytest.approx(9.81, rel=1e-4)


@pytest.mark.parametrize("stepper", [MoreauJean(step=1e-3), EventDriven()], ids=["moreau-jean", "event-driven"])
def test_oblique_bounce_of_a_disc(stepper: MoreauJean | EventDriven) -> None:
    reference = REFERENCES["oblique_bounce"]
    result = simulate(gallery.oblique_bounce(), 0.1, stepper)
    impulse = [reference["normal_impulse"], reference["tangential_impulse"]]
    assert result.impulse[-1, 0] == pytest.approx(impulse, abs=1e-12)
    assert result.u[-1] == pytest.approx([reference[name] for name in ("v_x", "v_y", "omega")], abs=1e-12)


@pytest.mark.parametrize("stepper", [MoreauJean(step=1e-3), EventDriven()], ids=["moreau-jean", "event-driven"])
def test_three_balls_in_a_row(stepper: MoreauJean | EventDriven) -> None:
    """All impacts at once as one LCP: not the sequence of two collisions, which is another model."""
    reference = REFERENCES["three_balls"]
    result = simulate(gallery.three_balls(), 0.1, stepper)
    assert result.u[-1, 0::3] == pytest.approx([reference[f"v_{k}"] for k in (1, 2, 3)], abs=1e-12)
    assert result.energies.stored[-1] == pytest.approx(0.5, rel=1e-12)


def test_rocking_block_loses_its_rate_by_housners_ratio() -> None:
    case = gallery.scenes()["rocking_block"]
    result = simulate(case.build(), 2.2, case.stepper)
    impacts = event_times(result, "impact")
    assert 4.0 * impacts[0] == pytest.approx(1.388374, abs=1e-6)
    assert len(impacts) == 4
    for time in impacts:
        before, after = result.u[np.abs(result.times - time) < 1e-12, 2][[0, -1]]
        assert after / before == pytest.approx(case.reference["rate_ratio"], abs=1e-6)
    assert result.energies.relative_remainder < 1e-6


def test_rocking_block_with_time_stepping() -> None:
    result = simulate(gallery.rocking_block(), 0.4, MoreauJean(step=2e-5), record=0.0)
    rate = result.u[:, 2]
    k = int(np.argmax(np.abs(np.diff(rate))))
    assert result.times[k] == pytest.approx(REFERENCES["rocking_block"]["first_impact"], abs=5e-5)
    assert rate[k + 1] / rate[k] == pytest.approx(REFERENCES["rocking_block"]["rate_ratio"], abs=2e-4)


@pytest.mark.parametrize(
    ("stepper", "duration"), [(MoreauJean(step=1e-8), 1e-8), (EventDriven(), 1e-3)], ids=["moreau-jean", "event-driven"]
)
def test_kanes_double_pendulum_gains_energy_and_says_so(stepper: MoreauJean | EventDriven, duration: float) -> None:
    reference = REFERENCES["double_pendulum"]
    scene = gallery.double_pendulum()
    result = simulate(scene, duration, stepper)
    after = 1  # the instant after the impact at the start
    assert result.velocity("lower rod", "bottom")[0] == pytest.approx([-0.267174, -0.134202], abs=5e-7)
    assert result.energies.kinetic[0] == pytest.approx(reference["energy_before"], abs=5e-9)
    assert result.u[after, [2, 5]] == pytest.approx([reference["upper_rate"], reference["lower_rate"]], abs=1e-6)
    impulse = [reference["normal_impulse"], reference["tangential_impulse"]]
    assert result.impulse[after, 0] == pytest.approx(impulse, abs=2e-6)
    gain = result.energies.kinetic[after] / result.energies.kinetic[0] - 1.0
    assert gain == pytest.approx(reference["energy_gain"], abs=5e-5)
    assert any("created energy" in warning for warning in result.warnings)


@pytest.mark.parametrize("stepper", [MoreauJean(step=2e-6), EventDriven()], ids=["moreau-jean", "event-driven"])
def test_slider_crank_meets_its_guide(stepper: MoreauJean | EventDriven) -> None:
    """Both upper corners hit at once (Flores, Leine & Glocker 2010)."""
    reference = REFERENCES["slider_crank"]
    exact = isinstance(stepper, EventDriven)
    result = simulate(gallery.slider_crank(), 0.0028, stepper, record=2e-6)
    hit = int(np.flatnonzero(result.impulse[:, :, 0].sum(axis=1))[0])
    tolerance = 1e-6 if exact else 2e-3
    assert result.times[hit] == pytest.approx(reference["first_impact"], abs=1e-6 if exact else 4e-6)
    assert result.u[hit - 1, :2] == pytest.approx([reference["crank_before"], reference["rod_before"]], rel=tolerance)
    assert result.u[hit, :2] == pytest.approx([reference["crank_after"], reference["rod_after"]], rel=tolerance)
    assert abs(result.u[hit, 2]) < 1e-9
    assert result.impulse[hit, :2, 0].sum() == pytest.approx(reference["impulse"], rel=tolerance)
    stored = result.energies.stored
    assert stored[hit - 1] == pytest.approx(reference["energy_before"], rel=1e-8 if exact else 5e-4)
    assert stored[hit] == pytest.approx(reference["energy_after"], rel=2e-8 if exact else 5e-4)


@pytest.mark.slow
def test_slider_crank_gets_through_the_accumulation() -> None:
    """The impacts accumulate before 9.2 ms; from there on, both upper corners slide along their guide."""
    located = simulate(gallery.slider_crank(), 0.0098, EventDriven(), record=1e-5)
    stepped = simulate(gallery.slider_crank(), 0.0098, MoreauJean(step=2e-6), record=1e-5)
    settled = located.times > 0.0094
    assert (located.state[settled, :2] == 2).all()
    assert (located.force[settled, :2, 0] > 0.0).all()
    assert np.nanmin(located.gap) > -1e-9
    assert np.nanmin(stepped.gap) > -1e-6
    assert np.nanmax(np.abs(stepped.gap[stepped.times > 0.0094, :2])) < 1e-8
    assert stepped.impulse[-1, :2, 0] == pytest.approx(located.impulse[-1, :2, 0], rel=0.01)
    assert stepped.u[-1, :2] == pytest.approx(located.u[-1, :2], rel=2e-3)


@pytest.mark.parametrize("top_mass", [1.0, 100.0])
def test_stack_of_boxes_rests(top_mass: float) -> None:
    """To the tolerance that is asked for: 38 contacts are solved in the velocities of the boxes."""
    result = simulate(gallery.stack(top_mass=top_mass), 0.3, MoreauJean(step=1e-3, solver_tolerance=1e-11))
    assert np.abs(result.q - result.q[0]).max() < 1e-11
    weight = 9.81 * (9.0 + top_mass)
    floor = result.contact_names.index(
        next(name for name in result.contact_names if "ground" in name and "box 1." in name)
    )
    assert result.force[-1, floor, 0] == pytest.approx(weight, rel=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("stepper", [MoreauJean(step=2e-3), EventDriven()], ids=["moreau-jean", "event-driven"])
@pytest.mark.parametrize("top_mass", [1.0, 100.0])
def test_stack_of_boxes_stays_for_ten_seconds(top_mass: float, stepper: MoreauJean | EventDriven) -> None:
    result = simulate(gallery.stack(top_mass=top_mass), 10.0, stepper, record=0.1)
    assert np.abs(result.q - result.q[0]).max() < 1e-9
