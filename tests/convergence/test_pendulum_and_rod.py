"""A pendulum strikes a rod, both meshes: what penalty forces converge to, and how many modes a strike needs."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.bodies.reduction.component_modes import craig_bampton
from lcpflex.bodies.reduction.damping import Rayleigh
from lcpflex.gallery.mechanisms.strikers import FINE, pendulum_and_rod, pendulum_with_hammer, rod_with_crown
from tests.examples import example
from tests.rates import assert_rate

DURATION = 1.8e-4  # [s]


@pytest.fixture(scope="module")
def scene() -> Callable[[int, float], lf.Scene]:
    """Builder of the scene with that many Craig-Bampton modes a body, and elements that fine in the contact region."""

    def build(modes: int, fine: float) -> lf.Scene:
        return pendulum_and_rod(
            rod_with_crown(fine),
            pendulum_with_hammer(fine),
            lambda mesh, kept: craig_bampton(mesh, kept, modes=modes, damping=Rayleigh(0.0, 1e-9)),
        )

    return build


def impulse(scene: lf.Scene, stepper: object) -> np.ndarray:
    result = lf.simulate(scene, DURATION, stepper, record=1e-6)
    assert result.energies.relative_remainder < 1e-4
    return result.contact("strike").impulse[:, 0]


@pytest.mark.slow
def test_penalty_forces_converge_to_the_lagrangian_ones(scene: Callable[[int, float], lf.Scene]) -> None:
    built = scene(40, 6e-4)
    exact = impulse(built, lf.EventDriven(rtol=1e-5, atol=1e-8))[-1]
    stiffness = [1e8, 1e9, 1e10]
    off = [abs(impulse(built, lf.Smooth(lf.Penalty(k), integrator=lf.Verlet(1e-8)))[-1] / exact - 1) for k in stiffness]
    assert off[-1] < 1e-3
    assert_rate(stiffness, off, -1.0, within=(0.2, 0.3))  # error ~ compliance 1/K, from a few pairs to many
    massless = impulse(built, lf.MasslessBoundary(step=1e-7, dynamic_modes=40))[-1]
    assert massless == pytest.approx(exact, rel=5e-3)


@pytest.mark.slow
def test_impulse_converges_as_modes_are_added(scene: Callable[[int, float], lf.Scene]) -> None:
    history = {
        modes: impulse(scene(modes, 6e-4), lf.MasslessBoundary(step=2.5e-8, dynamic_modes=modes))
        for modes in (10, 20, 40, 80, 240)
    }
    rich = history.pop(240)
    off = {modes: float(np.abs(found - rich).max() / rich[-1]) for modes, found in history.items()}
    assert off[80] < 3e-3
    assert_rate(list(off), list(off.values()), -2.0, within=(1.0, 0.5))


@pytest.mark.slow
def test_nine_pairs_carry_the_peak(scene: Callable[[int, float], lf.Scene]) -> None:
    for stepper in (lf.EventDriven(rtol=1e-4, atol=1e-7), lf.MasslessBoundary(step=1e-7, dynamic_modes=40)):
        result = lf.simulate(scene(40, FINE), 3e-5, stepper, record=2e-7)
        history = result.contact("strike")
        assert history.pairs[history.force[:, 0].argmax()] >= 9


@pytest.mark.slow
def test_velocity_behind_the_contact_converges_as_modes_are_added() -> None:
    """Figure 5 of Chen, Liu & Hong 2015: few coordinates do, here 40 modes, not 20; they have 20, in space."""
    study = example("velocity_behind_contact")
    results = {modes: study.strike(modes, 1.2e-4, mesh=(6e-4, 3.5e-3, None)) for modes in (10, 20, 40, 80)}
    rich = results.pop(80)
    off = {modes: study.apart(result, rich, 1.1e-4) for modes, result in results.items()}
    assert off[40] < 0.015 < 0.05 < off[20] < off[10]
