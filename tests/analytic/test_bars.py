"""Elastic bars: waves, contact without restitution, friction at a foot, against exact solutions."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
import pytest

from lcpflex import EventDriven, MoreauJean, Result, gallery, simulate
from lcpflex.gallery.acceptance.bars import prestressed_error
from lcpflex.gallery.mechanisms.bars import LENGTH, courant_step
from tests.rates import assert_rate

WAVE_SPEED = 30.0
CONTACT_TIME = 2.0 * LENGTH / WAVE_SPEED


def touching(result: Result) -> npt.NDArray[np.float64]:
    """Instants at the ends of the steps with a contact force."""
    return np.asarray(result.times[result.force[:, 0, 0] > 0.0])


@pytest.fixture(scope="module")
def rebound() -> Result:
    """A bar at 10 m/s: constant force for the time of a wave there and back, then rigid motion at -10 m/s."""
    case = gallery.scenes()["elastic_bar"]
    return simulate(case.build(), case.duration, case.stepper, record=0.0)


def test_wall_force_is_constant(rebound: Result) -> None:
    force = rebound.force[:, 0, 0]
    plateau = force[force > 0.0]
    assert plateau[:-1].mean() == pytest.approx(300.0, rel=0.01)  # the last step is a part of one
    middle = plateau[len(plateau) // 4 : 3 * len(plateau) // 4]
    assert np.abs(middle - 300.0).max() < 3.0
    assert rebound.impulse[-1, 0, 0] == pytest.approx(200.0, rel=0.01)


def test_wall_contact_lasts_as_long_as_a_wave_there_and_back(rebound: Result) -> None:
    transit = LENGTH / 400 / WAVE_SPEED
    closed = touching(rebound)
    assert closed[0] == pytest.approx(0.5, abs=2.0 * transit)
    assert closed[-1] == pytest.approx(0.5 + CONTACT_TIME, abs=transit)


def test_bar_rebounds_from_wall_as_a_whole(rebound: Result) -> None:
    assert rebound.u[-1, 0] == pytest.approx(10.0, rel=0.01)
    stored = rebound.energies.stored
    assert stored[-1] == pytest.approx(stored[0], rel=0.005)
    assert rebound.energies.elastic[-1] < 0.005 * stored[0]
    assert np.abs(rebound.u[:, 1:3]).max() < 1e-12  # it neither rises nor turns


@pytest.mark.parametrize("modes", [1, 2, 3])
@pytest.mark.parametrize(
    "stepper", [MoreauJean(step=1e-4 * CONTACT_TIME), EventDriven()], ids=["moreau-jean", "event-driven"]
)
def test_few_modes_lose_energy_by_the_law_of_modal_bars(stepper: MoreauJean | EventDriven, modes: int) -> None:
    result = simulate(gallery.elastic_bar(elements=200, modes=modes), 1.3, stepper, record=1e-4 * CONTACT_TIME)
    stored = result.energies.stored
    closed = touching(result)
    closing = int(np.searchsorted(result.times, closed[0] + 5e-4))  # it may take a few impacts at once
    assert 1.0 - stored[closing] / stored[0] == pytest.approx(1.0 / (2 * modes + 1), abs=1e-3)
    assert stored[-1] == pytest.approx(stored[closing], rel=1e-3)  # at closing and nowhere else
    assert result.energies.impact[-1] == pytest.approx(stored[0] - stored[-1], rel=1e-3)
    assert result.u[-1, 0] / 10.0 == pytest.approx(2 * modes / (2 * modes + 1), abs=1e-3)
    expected = {1: 0.8660, 2: 0.9160, 3: 0.9390}[modes]
    assert (closed[-1] - 0.5) / CONTACT_TIME == pytest.approx(expected, abs=1e-3)


def test_full_restitution_keeps_the_energy_but_not_the_rebound() -> None:
    """A warning example: with e_N = 1 the rebound of a bar of one mode is far from 1."""
    scene = gallery.elastic_bar(elements=200, modes=1, restitution=1.0)
    result = simulate(scene, 1.5, MoreauJean(step=2e-5))
    assert result.energies.stored[-1] == pytest.approx(result.energies.stored[0], rel=1e-3)
    assert result.u[-1, 0] / 10.0 == pytest.approx(0.5873, abs=5e-3)


def test_two_equal_bars_exchange_their_velocities() -> None:
    case = gallery.scenes()["two_bars"]
    result = simulate(case.build(), case.duration, case.stepper, record=0.0)
    struck = 3 + 200  # offset of the second bar in u
    transit = LENGTH / 200 / WAVE_SPEED
    closed = touching(result)
    force = result.force[:, 0, 0]
    assert force[force > 0.0].mean() == pytest.approx(150.0, rel=0.01)
    assert closed[0] == pytest.approx(0.1, abs=2.0 * transit)
    assert closed[-1] - 0.1 == pytest.approx(CONTACT_TIME, abs=2.0 * transit)
    speed = result.velocity("struck", "left")[force > 0.0, 0]
    assert speed.mean() == pytest.approx(5.0, rel=0.01)
    assert result.u[-1, struck] == pytest.approx(10.0, rel=0.01)
    assert result.u[-1, 0] == pytest.approx(0.0, abs=0.1)
    assert result.energies.elastic[-1] < 0.005 * result.energies.stored[0]


def prestressed_run(elements: int) -> tuple[Result, float]:
    """Four periods, and the root of the mean square of the displacement error over places and times."""
    step = courant_step(1.0 / elements, 1.0)
    stepper = MoreauJean(step=step)
    result = simulate(gallery.prestressed_bar(elements=elements), 12.0, stepper, record=0.02)
    return result, prestressed_error(result)


def test_prestressed_bar_has_period_three() -> None:
    meshes = np.array([25, 50, 100, 200])
    runs = [prestressed_run(elements) for elements in meshes]
    errors = [error for _, error in runs]
    for elements, error in zip(meshes, errors, strict=True):
        assert error < 0.4 / elements
    assert_rate(1.0 / meshes, errors, 1.0, within=0.2)
    finest = runs[-1][0]
    assert finest.energies.stored[0] == pytest.approx(0.125, rel=1e-12)
    assert finest.energies.stored[-1] == pytest.approx(0.125, rel=0.005)
    assert finest.energies.relative_remainder < 1e-10
    force = finest.force[:, 0, 0]
    resting = (finest.times % 3.0 > 1.1) & (finest.times % 3.0 < 1.9)
    assert force[resting].mean() == pytest.approx(0.5, rel=0.01)
    assert finest.joint_drift.max() < 1e-12


def test_pulled_bar_runs_slow_and_fast_in_turn() -> None:
    case = gallery.scenes()["bar_with_foot"]
    result = simulate(case.build(), 3.0, case.stepper, record=0.0)
    arrivals = (2.0 * np.arange(5) + 1.0) * LENGTH / WAVE_SPEED
    foot = np.interp(arrivals, result.times, result.point("bar", "left")[:, 0])
    assert abs(foot[0]) < 1e-9  # nothing moves before the first wave arrives
    speeds = np.diff(foot) / CONTACT_TIME
    assert speeds[0::2] == pytest.approx(0.5, abs=0.01)
    assert speeds[1::2] == pytest.approx(1.5, abs=0.01)
    pulled = result.point("bar", "right")[:, 0]
    assert pulled == pytest.approx(LENGTH + result.times, abs=1e-9)
    assert result.force[result.state[:, 0] > 0, 0, 0] == pytest.approx(1.5 * math.sqrt(900.0), rel=1e-9)
