"""Energy created by contact impulses: an error, a warning, or accepted, by the user's choice."""

from __future__ import annotations

import numpy as np
import pytest

import lcpflex as lf
from lcpflex import gallery

STEPPERS = (lf.EventDriven(), lf.MoreauJean(step=1e-5))


@pytest.mark.parametrize("stepper", STEPPERS, ids=repr)
def test_kanes_pendulum_warns_by_default(stepper: lf.EventDriven | lf.MoreauJean) -> None:
    result = lf.simulate(gallery.double_pendulum(), 0.01, stepper)
    assert result.complete
    assert any("created energy" in warning for warning in result.warnings)


@pytest.mark.parametrize("stepper", STEPPERS, ids=repr)
def test_growth_as_an_error_keeps_what_was_recorded(stepper: lf.EventDriven | lf.MoreauJean) -> None:
    with pytest.raises(lf.StepError, match="created energy") as caught:
        lf.simulate(gallery.double_pendulum(), 0.01, stepper, energy_growth=lf.EnergyGrowth.ERROR)
    result = caught.value.result
    assert not result.complete
    assert result.times[-1] < 0.01
    assert len(result.times) > 1


@pytest.mark.parametrize("stepper", STEPPERS, ids=repr)
def test_accepted_growth_makes_no_warning_and_still_shows_in_the_energies(
    stepper: lf.EventDriven | lf.MoreauJean,
) -> None:
    result = lf.simulate(gallery.double_pendulum(), 0.01, stepper, energy_growth=lf.EnergyGrowth.ACCEPT)
    assert result.warnings == ()
    assert np.ptp(result.energies.impact + result.energies.friction) > 0.01


def test_an_error_is_no_error_where_nothing_grows() -> None:
    result = lf.simulate(gallery.double_pendulum(friction=0.0), 0.01, STEPPERS[0], energy_growth=lf.EnergyGrowth.ERROR)
    assert result.complete


def test_refuses_a_word() -> None:
    with pytest.raises(lf.ModelError, match="energy_growth"):
        lf.simulate(gallery.bouncing_ball(), 0.1, STEPPERS[0], energy_growth="error")
