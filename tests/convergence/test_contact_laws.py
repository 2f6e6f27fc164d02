"""Rates of restitution under laws with memory: of the tolerance of adaptive steps, of the length of fixed ones."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.force_laws.contact_law import ContactLaw
from lcpflex.force_laws.damping.hysteresis import HysteresisDamping
from lcpflex.force_laws.elastic.power_law import PowerLaw
from tests.rates import assert_rate
from tests.scenes import disc_on_floor

GAPS = (0.01, 0.0107, 0.0123, 0.0151)  # where a touch falls within a step is of chance: mean over some


STIFFNESS = {1.0: 1e5, 1.5: 1e6, 3.0: 1e10}  # by exponent: impacts of a few ms


def mean_error(integrator: Any, exponent: float) -> float:
    """Of the rebound of balls of 1 kg and 1 m/s, all in scenes of their own, root mean square."""
    law = ContactLaw(PowerLaw(STIFFNESS[exponent], exponent), HysteresisDamping(0.5))
    errors = []
    for gap in GAPS:
        scene = disc_on_floor(0.1 + gap, (0.0, -1.0), gravity=0.0)
        result = lf.simulate(scene, 0.08, lf.Smooth(law, integrator=integrator), record=0.08)
        errors.append(result.u[-1, 1] - 0.5)
    return float(np.sqrt(np.mean(np.square(errors))))


@pytest.mark.parametrize(("exponent", "expected"), [(1.0, 0.82), (1.5, 0.98), (3.0, 1.40)])
def test_restitution_follows_the_tolerance(exponent: float, expected: float) -> None:
    """Steps end where contacts begin: the error is proportional to the tolerance, about, as without any contact.

    Where forces begin with more derivatives it falls faster.
    """
    tolerances = np.geomspace(1e-5, 1e-10, 6)
    errors = [mean_error(lf.ExplicitRungeKutta(rtol=r, atol=1e-2 * r), exponent) for r in tolerances]
    assert_rate(tolerances, errors, expected, within=0.1)
    assert errors[-1] < 2e-9


@pytest.mark.parametrize(("exponent", "expected"), [(1.0, 2.1), (1.5, 2.7), (3.0, 3.7)])
def test_restitution_of_fixed_steps(exponent: float, expected: float) -> None:
    """Verlet's steps note the speed where they end, behind the touch, by the energy stored till there.

    The rate is higher, the smoother forces begin.
    """
    steps = np.geomspace(4e-4, 2.5e-5, 5)
    errors = [mean_error(lf.Verlet(h), exponent) for h in steps]
    assert_rate(steps, errors, expected, within=0.2)
    assert errors[-1] < 3e-6
