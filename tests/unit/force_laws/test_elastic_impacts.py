"""Elastic laws in a simulation: a disc thrown at a wall under each of them returns as its energy says."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

import lcpflex as lf
from lcpflex.force_laws.contact_law import ContactLaw
from lcpflex.force_laws.elastic.cylinder_pair import CylinderPair
from lcpflex.force_laws.elastic.explicit_line_laws import LankaraniNikraveshCylinder, Liu, Pereira, Persson
from lcpflex.force_laws.elastic.hertz import Hertz
from lcpflex.force_laws.elastic.line_contact import DubowskyFreudenstein, Esdu78035, Goldsmith, Johnson, Radzimovsky
from lcpflex.force_laws.elastic.materials import Material
from lcpflex.force_laws.elastic.power_law import PowerLaw
from lcpflex.steppers.smooth.stepper import ExplicitRungeKutta, Smooth
from tests.scenes import disc_on_floor

RADIUS, MASS, SPEED = 0.0079, 0.015, 0.3
RTOL = 1e-11  # of a step
STEPS = 1000  # more than an impact takes: their errors add up
STEEL = Material(207e9, 0.3)
PAIR = CylinderPair.internal(0.008, RADIUS, 0.01, STEEL)
LAWS = [PowerLaw(1e9, 1.2), Hertz.sphere_on_plane(RADIUS, STEEL), Johnson(PAIR), Radzimovsky(PAIR), Goldsmith(PAIR)]
LAWS += [DubowskyFreudenstein(PAIR), Esdu78035(PAIR), Esdu78035(PAIR, "review"), LankaraniNikraveshCylinder(PAIR)]
LAWS += [Pereira(PAIR), Liu(PAIR), Persson(PAIR)]


def thrown(gap: float, speed: float = SPEED) -> lf.Scene:
    return disc_on_floor(RADIUS + gap, (0.0, -speed), radius=RADIUS, mass=MASS, gravity=0.0, name="wall")


@pytest.mark.parametrize("law", LAWS, ids=lambda law: type(law).__name__)
def test_impact_on_a_wall(law):
    """v^2 = v0^2 - 2 U(delta) / m: depth, force and duration from the energy, speed given back whole."""
    energy = 0.5 * MASS * SPEED**2
    deepest = brentq(lambda x: law.energy(x) - energy, 1e-12, min(law.limit, 1e-3), xtol=1e-20, rtol=1e-14)

    def slowness(s: float) -> float:  # at the indentation deepest (1 - s^2)
        return 2.0 * deepest * s / math.sqrt(SPEED**2 - 2.0 * law.energy(deepest * (1.0 - s * s)) / MASS)

    duration = 2.0 * quad(slowness, 0.0, 1.0, epsabs=0.0, epsrel=1e-10)[0]
    gap, flight = 1e-5, 1e-5 / SPEED
    stepper = Smooth(ContactLaw(law), integrator=ExplicitRungeKutta(rtol=RTOL, atol=1e-14))
    result = lf.simulate(thrown(gap), flight + 1.5 * duration, stepper, record=duration / 500.0)
    height = result.q[:, 1]
    assert RADIUS - height.min() == pytest.approx(deepest, rel=2e-5)  # of the records, near the greatest depth
    assert result.force[:, 0, 0].max() == pytest.approx(law.force(deepest), rel=3e-5)
    assert result.u[-1, 1] == pytest.approx(SPEED, rel=STEPS * RTOL)
    parting = result.times[-1] - (height[-1] - RADIUS) / result.u[-1, 1]
    assert parting - flight == pytest.approx(duration, rel=1e-7)
    inside = height < RADIUS
    assert inside.sum() > 400
    assert result.force[inside, 0, 0] == pytest.approx(law.force(RADIUS - height[inside]), rel=1e-9)
    assert not result.force[~inside, 0, 0].any()
    assert np.abs(result.u[:, 1]).max() <= SPEED * (1.0 + STEPS * RTOL)


def test_a_run_stops_where_a_law_is_not_valid():
    with pytest.raises(lf.StepError, match="wall"):
        lf.simulate(thrown(1e-5, speed=30.0), 1e-3, Smooth(ContactLaw(Johnson(PAIR))), record=1e-6)
