"""A ball on a large thin plate of many modes, by Hertz's law, against Zener's equation (1941).

s'' + (1 + lambda d/dt) s^(3/2) = 0, s(0) = 0, s'(0) = 1: the contact ends where s = 0, its restitution is -s' there. A
single degree of freedom with that force, which may not pull, ends sooner and with more speed: it is another problem.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import lcpflex as lf
from lcpflex import gallery
from lcpflex.gallery.acceptance.plates import contact_time, restitution
from lcpflex.gallery.mechanisms.plates import BALL_TIME
from tests.rates import assert_rate, assert_rates

CASE = gallery.scenes()["sphere_on_plate"]


def zener(loss: float) -> Any:
    """Restitution and duration in units of T0."""

    def slope(t: float, y: Any) -> Any:
        root = math.sqrt(max(y[0], 0.0))
        return y[1], -(root**3) - 1.5 * loss * root * y[1]

    def parted(t: float, y: Any) -> Any:
        return y[0] if t > 0.1 else 1.0

    parted.terminal, parted.direction = True, -1.0  # type: ignore[attr-defined]
    found = solve_ivp(slope, (0.0, 20.0), (0.0, 1.0), "DOP853", rtol=1e-12, atol=1e-14, events=parted, max_step=0.01)
    return np.array([-found.y_events[0][0][1], found.t_events[0][0]])


def struck(loss: float = 0.1, side: float = 24.0, cutoff: float = 50.0) -> tuple[Any, int]:
    """The same of a plate of modes, and their number."""
    scene = gallery.sphere_on_plate(loss, side, cutoff)
    result = lf.simulate(scene, 1.1 * zener(loss)[1] * BALL_TIME, CASE.stepper, record=BALL_TIME / 200.0)
    assert not result.warnings
    assert result.energies.largest_remainder < 1e-5 * result.energies.scale
    assert result.joint_drift.max() < 1e-12
    pressed = np.flatnonzero(result.force[:, 0, 0] > 0.0)
    assert (np.diff(pressed) == 1).all()
    return np.array([restitution(result), contact_time(result) / BALL_TIME]), result.q.shape[1] - 14


def test_the_reference_of_the_gallery_is_that_of_zener() -> None:
    assert zener(0.1) == pytest.approx([CASE.reference["restitution"], CASE.reference["contact_time"] / BALL_TIME])
    assert zener(1e-12) == pytest.approx([1.0, 3.218065], rel=1e-6)


def test_a_ball_on_a_plate_comes_to_zeners_numbers_with_the_number_of_modes() -> None:
    """What modes beyond the cutoff lack is a compliance that goes with 1 / cutoff: extrapolated, 5e-5 are left."""
    runs = [struck(cutoff=cutoff) for cutoff in (10.0, 30.0, 90.0)]
    found, modes = np.array([run[0] for run in runs]), np.array([run[1] for run in runs])
    missed = zener(0.1) - found
    assert (missed > 0.0).all()
    assert_rate(modes, missed, -1.0, 0.06)
    assert missed[-1] == pytest.approx([7e-5, 1.3e-3], rel=0.15)
    assert np.abs(missed[-1] - (found[-1] - found[-2]) / 2.0).max() < 5e-5


@pytest.mark.slow
def test_the_order_goes_on_to_thousands_of_modes() -> None:
    runs = [struck(cutoff=cutoff) for cutoff in (30.0, 100.0, 300.0)]
    missed = zener(0.1) - np.array([run[0] for run in runs])
    assert_rates([run[1] for run in runs], missed, -1.0, 0.06)
    assert (missed[-1] < [2.5e-5, 4e-4]).all()


@pytest.mark.parametrize("loss", [0.02, 0.3, 1.0])
def test_the_more_the_plate_yields_the_less_comes_back(loss: float) -> None:
    """Down to .184 of the speed for 1."""
    found, _ = struck(loss, side=28.0 if loss > 0.5 else 24.0)
    assert found == pytest.approx(zener(loss), abs=2.5e-2 * loss)
    assert found[0] == pytest.approx(zener(loss)[0], abs=3e-3 * loss)


def test_waves_that_come_back_from_the_edges_are_seen() -> None:
    """A plate so small that they do so during the contact is not a large one."""
    large, small = (struck(side=side)[0] for side in (24.0, 5.0))
    assert abs(large[0] - zener(0.1)[0]) < 2e-4 < 1e-2 < abs(small[0] - zener(0.1)[0])
