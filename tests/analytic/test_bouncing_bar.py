"""An elastic bar between two walls over twenty periods: what each scheme keeps of its energy, and why."""

from __future__ import annotations

import numpy as np
import pytest

import lcpflex as lf
from lcpflex import gallery
from lcpflex.gallery.mechanisms.bars import LENGTH, MODULUS, courant_step
from tests.rates import assert_rate
from tests.scenes import bar_between_walls

WAVE_SPEED = 30.0
PERIOD = 2.0 * (1.0 + 2.0 * LENGTH / WAVE_SPEED)  # [s] flight over 10 m at 10 m/s and contact, twice


def twenty_periods(elements: int, restitution: float, stepper: object) -> lf.Result:
    return lf.simulate(bar_between_walls(elements, LENGTH, MODULUS, 5.0, 10.0, restitution), 20.0 * PERIOD, stepper)


def lost(result: lf.Result) -> float:
    return 1.0 - float(result.energies.stored[-1] / result.energies.stored[0])


def test_moreau_jean_with_full_restitution_keeps_all_energy() -> None:
    result = twenty_periods(50, 1.0, lf.MoreauJean(step=courant_step(LENGTH / 50, WAVE_SPEED)))
    assert result.impulse[-1].sum() > 25 * 200.0  # with e = 1 a part of the motion goes into vibration
    assert abs(lost(result)) < 1e-12
    (said,) = result.warnings
    assert "does not set the rebound" in said


def test_moreau_jean_without_restitution_loses_what_the_node_that_strikes_holds() -> None:
    """E0 / (2 N + 1) an impact, so a tenth in forty of them at 200 elements, and half of that at each finer mesh."""
    meshes = np.array([50, 100, 200])
    losses = [lost(twenty_periods(n, 0.0, lf.MoreauJean(step=courant_step(LENGTH / n, WAVE_SPEED)))) for n in meshes]
    assert losses[-1] == pytest.approx(1.0 - (1.0 - 1.0 / 401.0) ** 40, rel=0.1)
    assert_rate(1.0 / meshes, losses, 1.0, within=0.2)


def spectral_radius(rho: float, frequency: float) -> float:
    """Of a step of generalised-alpha on xddot = -omega^2 x, at frequency = omega h."""
    alpha_m, alpha_f = (2.0 * rho - 1.0) / (rho + 1.0), rho / (rho + 1.0)
    gamma = 0.5 + alpha_f - alpha_m
    beta = 0.25 * (gamma + 0.5) ** 2
    # unknowns x, h v, h^2 a at the end and the start of a step
    after = np.array([[1.0, 0.0, -beta], [0.0, 1.0, -gamma], [(1.0 - alpha_f) * frequency**2, 0.0, 1.0 - alpha_m]])
    before = np.array([[1.0, 1.0, 0.5 - beta], [0.0, 1.0, 1.0 - gamma], [-alpha_f * frequency**2, 0.0, -alpha_m]])
    return float(np.abs(np.linalg.eigvals(np.linalg.solve(after, before))).max())


@pytest.mark.parametrize("rho", [0.3, 0.8, 1.0])
def test_generalized_alpha_damps_what_rings_after_an_impact_as_rho_inf_predicts(rho: float) -> None:
    """Modal energies shrink by the squared spectral radius a step, each mode by its own."""
    step = courant_step(LENGTH / 50, WAVE_SPEED)
    scene = gallery.elastic_bar(elements=50)
    result = lf.simulate(scene, 3.0, lf.GeneralizedAlpha(step=step, rho_inf=rho), record=0.0)
    assert result.force[result.times > 1.3, 0, 0].max() == 0.0  # it flies
    omega = np.sqrt(scene.compiled().model.bodies.stiffness)
    energy = 0.5 * (result.u[:, 3:] ** 2 + (omega * result.q[:, 3:]) ** 2)
    first = int(np.flatnonzero(result.times > 1.4)[0])
    last = len(result.times) - 200
    # averaged over many periods: within one the energy of a mode swings about its decay
    measured = energy[last : last + 150].mean(axis=0) / energy[first : first + 150].mean(axis=0)
    predicted = np.array([spectral_radius(rho, w * step) for w in omega]) ** (2 * (last - first))
    rings = (energy[first] > 1e-6 * energy[first].sum()) & (predicted > 1e-4) & (omega > 10.0)
    assert rings.sum() >= 3
    np.testing.assert_allclose(np.log(measured[rings]), np.log(predicted[rings]), rtol=0.05, atol=0.02)
