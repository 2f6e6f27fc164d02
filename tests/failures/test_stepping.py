"""Steps that are too long for stiff contacts and stiff modes, and rules that contact makes unstable."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from lcpflex import gallery
from lcpflex.studies import Outcome
from tests.examples import example
from tests.scenes import disc_on_floor

STIFFNESS = 1e6  # [N/m]
CRITICAL = 2.0 / math.sqrt(STIFFNESS)  # [s] step 2/omega of 1 kg on such a spring


def falling_disc() -> lf.Scene:
    """A disc of 1 kg meets the floor at 1 m/s, without gravity."""
    return disc_on_floor(0.1005, (0.0, -1.0), gravity=0.0)


def test_penalty_springs_beyond_the_limit_of_the_step(loud: Any) -> None:
    """One and a half times 2/omega: the disc comes off the floor with energy out of nothing, and the result says so."""
    said = loud(falling_disc(), 0.1, lf.Smooth(lf.Penalty(STIFFNESS), integrator=lf.Verlet(1.5 * CRITICAL)))
    assert "the stiffest contact has sqrt(k G_nn) step = 3 > 2" in said
    assert "energy was gained without explanation" in said
    sound = lf.simulate(falling_disc(), 0.1, lf.Smooth(lf.Penalty(STIFFNESS), integrator=lf.Verlet(0.9 * CRITICAL)))
    assert not any("unstable" in warning for warning in sound.warnings)
    for integrator in (lf.Verlet(0.005 * CRITICAL), lf.ExplicitRungeKutta(), lf.Stiff()):
        result = lf.simulate(falling_disc(), 0.1, lf.Smooth(lf.Penalty(STIFFNESS), integrator=integrator))
        assert result.u[-1, 1] == pytest.approx(1.0, abs=1e-3)
        assert not result.warnings
    hard = lf.simulate(falling_disc(), 0.1, lf.MoreauJean(step=1.5 * CRITICAL))
    assert hard.u[-1, 1] == pytest.approx(0.0, abs=1e-12)  # no spring, so no rebound and no limit


def test_stiff_modes_with_explicit_steps(loud: Any) -> None:
    """A bar on a wall by steps of twice 2/omega of its highest mode: explicit ones explode, implicit ones do not."""
    scene = gallery.elastic_bar(elements=30)
    highest = math.sqrt(scene.compiled().model.bodies.stiffness.max())
    step = 2.0 * 2.0 / highest
    said = loud(scene, 1.5, lf.Smooth(lf.Penalty(1e4), integrator=lf.Verlet(step)))
    assert "energy" in said or "finite" in said
    refused = loud(scene, 1.5, lf.MasslessBoundary(step=20.0 * step, dynamic_modes=29, substeps=False))
    assert "StepError" in refused
    assert "admits" in refused
    for stepper in (
        lf.MoreauJean(step=step),
        lf.GeneralizedAlpha(step=step),
        lf.MasslessBoundary(step=step, dynamic_modes=15),
    ):
        result = lf.simulate(scene, 1.5, stepper)
        assert result.u[-1, 0] == pytest.approx(10.0, rel=0.05)  # of 30 elements the last mode keeps a part
        assert result.impulse[-1, 0, 0] == pytest.approx(200.0, rel=0.02)


@pytest.mark.parametrize("elements", [20, 40, 80])
def test_newmarks_rule_with_contact(elements: int) -> None:
    """Trapezoidal rule, contact on positions: gains energy at a short step; ours keep it at steps 100 times longer."""
    verdict = example("where_methods_fail").newmark(step=1e-4, elements=elements)
    assert verdict.outcome in (Outcome.GAINING, Outcome.DIVERGED)
    assert "energy grew" in verdict.message
    for stepper in (lf.GeneralizedAlpha(step=1e-2), lf.MoreauJean(step=1e-2)):
        result = lf.simulate(gallery.elastic_bar(elements=elements), 1.5, stepper)
        stored = result.energies.stored
        assert stored.max() < stored[0] * (1.0 + 1e-9)
        assert result.u[-1, 0] == pytest.approx(10.0, rel=0.05)
        assert not any("energy" in warning for warning in result.warnings)


def test_massless_contact_keeps_its_limit() -> None:
    """Every mode but one kept: the limit of the modes alone would be 6e3 times too much energy; ours is divided."""
    scene = gallery.elastic_bar(elements=101)
    highest = math.sqrt(np.sort(scene.compiled().model.bodies.stiffness)[-2])
    result = lf.simulate(scene, 1.5, lf.MasslessBoundary(step=1.8 / highest, dynamic_modes=100))
    stored = result.energies.stored
    assert np.abs(stored / stored[0] - 1.0).max() < 0.01
    assert any("divided" in warning for warning in result.warnings)
