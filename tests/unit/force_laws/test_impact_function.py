"""The IMPACT function: its values, its energy against a closed form, its limit without a transition."""

from __future__ import annotations

import math
import pickle

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.force_laws.damping.rebound import rebound_of_ratio
from lcpflex.force_laws.set_in_damper import impact_function
from tests.rates import assert_rate
from tests.scenes import disc_on_floor

K, SPEED = 1e6, 0.5  # [N/m], [m/s]; 1 kg
DEEP = SPEED / math.sqrt(K)  # without damping [m]
FINE = lf.ExplicitRungeKutta(rtol=1e-11, atol=1e-14)


def impact(damping: float, depth: float, exponent: float = 1.0) -> lf.Result:
    """A free disc of 1 kg strikes the floor once."""
    scene = disc_on_floor(0.1, (0.0, -SPEED), gravity=0.0)
    law = lf.ContactLaw(impact_function(K, exponent, damping, depth))
    return lf.simulate(scene, 8e-3 if exponent == 1.0 else 0.1, lf.Smooth(law, integrator=FINE), progress=False)


def rebound(result: lf.Result) -> float:
    assert result.contact("floor").gap[-1] > 0.0 or math.isnan(result.contact("floor").gap[-1])
    return float(result.u[-1, 1]) / SPEED


def test_values() -> None:
    """The cubic STEP of the sources at a quarter, half, all and twice of the depth; no jump at touch, no pull."""
    law = impact_function(2e6, 1.5, 300.0, 1e-3)
    depth = np.array([0.25e-3, 0.5e-3, 1e-3, 2e-3])
    damper = 300.0 * np.array([0.15625, 0.5, 1.0, 1.0])
    assert law.force(depth, rate=0.7) == pytest.approx(2e6 * depth**1.5 + 0.7 * damper, rel=1e-13)
    assert law.force(1e-9, rate=1.0) < 1e-6
    assert law.force(1e-3, rate=-1e3) == 0.0
    assert law.is_compiled
    assert pickle.loads(pickle.dumps(law)).force(1e-3, rate=1.0) == law.force(1e-3, rate=1.0)


@pytest.mark.parametrize("sigma", [0.2, 0.6, 1.0])
def test_energy_lost_within_the_transition(sigma: float) -> None:
    """2 c sqrt(K/m) delta_m^2 (3 pi/16 sigma^2 - 4/15 sigma^3), to first order in c."""
    off = []
    dampings = 2.0 * math.sqrt(K) * np.array([1e-3, 2e-3, 4e-3])
    for damping in dampings:
        result = impact(damping, DEEP / sigma)
        lost = 0.5 * SPEED**2 * (1.0 - rebound(result) ** 2)
        expected = 2.0 * damping * math.sqrt(K) * DEEP**2 * (3.0 * math.pi / 16.0 * sigma**2 - 4.0 / 15.0 * sigma**3)
        off.append(abs(lost / expected - 1.0))
        assert not result.warnings
    assert off[0] < 5e-3
    assert_rate(dampings, off, 1.0, within=0.03)


def test_tends_to_spring_and_dashpot() -> None:
    """A damper that sets in at once is Kelvin and Voigt's, with its closed rebound."""
    zeta = 0.2
    exact = rebound_of_ratio(zeta)
    depths = DEEP * 0.5 ** np.arange(5, 10)
    off = [abs(rebound(impact(2.0 * zeta * math.sqrt(K), depth)) - exact) for depth in depths]
    assert off[-1] < 2e-3
    assert_rate(depths, off, 1.0, within=0.1)


def test_public_name_is_the_function() -> None:
    """No module of the package may have it: once imported, it would stand in its place."""
    assert lf.laws.impact_function is impact_function


def test_depth_of_nothing() -> None:
    """The least depth that floats know, of which no quotient has a number."""
    assert impact_function(1e6, 1.0, 1.0, 5e-324).force(1e-6, rate=2.0) == pytest.approx(3.0, rel=1e-12)


def test_without_damping_nothing_is_lost() -> None:
    assert rebound(impact(0.0, 1e-4, exponent=1.5)) == pytest.approx(1.0, abs=1e-9)


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        ((0.0, 1.0, 1.0, 1e-3), "stiffness: 0.0"),
        ((1e6, 0.5, 1.0, 1e-3), "exponent: 0.5"),
        ((1e6, 1.0, -1.0, 1e-3), "damping: -1.0"),
        ((1e6, 1.0, 1.0, 0.0), "depth: 0.0"),
        ((1e6, 1.0, math.inf, 1e-3), "damping: inf"),
        (("a", 1.0, 1.0, 1e-3), "stiffness: 'a'"),
    ],
)
def test_refused(arguments, named: str) -> None:
    with pytest.raises(lf.ModelError, match=named):
        impact_function(*arguments)
