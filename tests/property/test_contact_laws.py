"""Impacts under laws with memory, whatever the numbers: the exact factor returns its restitution."""

from __future__ import annotations

import pytest

import lcpflex as lf
from lcpflex.force_laws.contact_law import ContactLaw
from lcpflex.force_laws.damping.hysteresis import HysteresisDamping
from lcpflex.force_laws.elastic.power_law import PowerLaw
from tests.chance import given, settings, st
from tests.scenes import floor_of


def logarithmic(low: float, high: float) -> st.SearchStrategy[float]:
    """Powers of ten."""
    return st.floats(low, high).map(lambda exponent: 10.0**exponent)


@settings(max_examples=60)
@given(
    mass=logarithmic(-3.0, 3.0),
    stiffness=logarithmic(3.0, 10.0),
    exponent=st.floats(1.0, 3.0),
    speed=logarithmic(-2.0, 2.0),
    e=st.floats(0.05, 1.0),
)
def test_exact_factor_for_any_impact(mass: float, stiffness: float, exponent: float, speed: float, e: float) -> None:
    """One ball and a wall, an elastic time of compression [s] and an indentation [m] of any size."""
    deepest = (0.5 * (exponent + 1.0) * mass * speed**2 / stiffness) ** (1.0 / (exponent + 1.0))
    time = deepest / speed
    radius = 10.0 * deepest
    scene = lf.Scene(gravity=(0.0, 0.0))
    position = (0.0, radius + 0.5 * deepest)
    body = scene.add(lf.Disc(radius=radius, mass=mass), position=position, velocity=(0.0, -speed))
    scene.contact(body.surface(), floor_of(scene), name="wall")
    law = ContactLaw(PowerLaw(stiffness, exponent), HysteresisDamping(e, guard_speed=1e-6))
    integrator = lf.ExplicitRungeKutta(rtol=1e-8, atol=1e-10 * min(deepest, speed))
    duration = (6.0 + 10.0 / e) * time
    result = lf.simulate(scene, duration, lf.Smooth(law, integrator=integrator), record=0.01 * duration)
    assert result.q[-1, 1] > radius
    assert result.u[-1, 1] / speed == pytest.approx(e, rel=2e-5)
    assert result.energies.relative_remainder < 1e-5
    assert result.energies.impact.min() >= -1e-6 * result.energies.scale  # between steps: by dense output
