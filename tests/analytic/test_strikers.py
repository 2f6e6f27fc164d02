"""A pendulum strikes a rod, both meshes: balances that hold however coarse they are, and what a fine one must meet."""

from __future__ import annotations

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.bodies.body import Body
from lcpflex.bodies.continuum import Continuum
from lcpflex.bodies.reduction.component_modes import craig_bampton
from lcpflex.bodies.reduction.damping import Rayleigh
from lcpflex.gallery.mechanisms.strikers import pendulum_and_rod, pendulum_with_hammer, rod_with_crown

STEPPERS = {
    "massless boundary": lf.MasslessBoundary(step=1e-7, dynamic_modes=20),
    "event-driven": lf.EventDriven(rtol=1e-4, atol=1e-7),
    "penalty": lf.Smooth(lf.Penalty(1e9), integrator=lf.Verlet(2e-8)),
}


def scene(fine: float, modes: int) -> lf.Scene:
    def reduce(mesh: Continuum, kept: list[str]) -> Body:
        return craig_bampton(mesh, kept, modes=modes, damping=Rayleigh(0.0, 1e-9))

    return pendulum_and_rod(rod_with_crown(fine), pendulum_with_hammer(fine), reduce)


@pytest.mark.parametrize("stepper", STEPPERS.values(), ids=STEPPERS)
def test_rod_takes_up_the_impulse_and_energy_is_accounted_for(stepper: object) -> None:
    built = scene(2.4e-3, 20)
    result = lf.simulate(built, 1e-4, stepper, record=1e-6)
    rod, pendulum = built.body("rod").source, built.body("pendulum").source
    first = 3 + pendulum.modes
    impulse = result.impulse[:, 0, 0]
    momentum = rod.mass * result.u[:, first] * np.cos(result.q[:, first + 2])  # <Phi> = 0: the frame moves with it
    assert impulse[-1] > 0.1
    np.testing.assert_allclose(momentum, impulse, atol=1e-3 * impulse[-1])
    assert result.energies.relative_remainder < 1e-3


def test_coarse_patch_is_reported() -> None:
    result = lf.simulate(scene(2.4e-3, 20), 2e-4, STEPPERS["massless boundary"], record=1e-6)
    assert any("1 pair of touching points" in warning for warning in result.warnings)
