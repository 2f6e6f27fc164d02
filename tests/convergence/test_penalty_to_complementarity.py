"""Continuous contact forces approach the complementarity solution as their stiffness grows: at which rate, and why."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.optimize import brentq

import lcpflex as lf
from lcpflex import gallery
from lcpflex.force_laws.contact_law import ContactLaw
from lcpflex.force_laws.damping.hysteresis import HysteresisDamping, HysteresisFactor
from lcpflex.force_laws.elastic.power_law import PowerLaw
from lcpflex.gallery.mechanisms.flexible import aluminium_strip
from tests.rates import assert_rate

FINE = lf.ExplicitRungeKutta(rtol=1e-10, atol=1e-13)
EXACT = lf.EventDriven(rtol=1e-10, atol=1e-13)


def test_elastic_bar() -> None:
    """The exact solution on a spring: force and penetration approach their limits within tau = Z/k.

    Until the wave is back, at T, the force is F = Z v (1 - exp(-t/tau)); from then on, with s = t - T,
    F = Z v (2 (1 + s/tau) exp(-s/tau) - 1), up to s = x tau. So the contact is longer by x tau, and the impulse is
    short by Z v tau (x - 2 + 2 exp(-x)): rate 1, as of everything else. The force converges, too; on a mesh it ripples
    before its end, where the shortest waves are back.
    """
    impedance, speed, stay, end = 30.0, 10.0, 2.0 / 3.0, 1.4
    x = float(brentq(lambda x: 2.0 * (1.0 + x) * math.exp(-x) - 1.0, 1.0, 3.0))
    stiffnesses = [500.0 * 1.5**k for k in range(5)]  # softer than an element, 36 kN/m
    late, short, off = [], [], []
    for k in stiffnesses:
        stepper = lf.Smooth(lf.Penalty(k), integrator=lf.Verlet(2.8e-4))
        result = lf.simulate(gallery.elastic_bar(400), end, stepper, record=5e-4)
        last = int(np.flatnonzero(result.force[:, 0, 0] > 0.0)[-1])
        (before, after), times = result.gap[last : last + 2, 0], result.times[last : last + 2]
        late.append(times[0] - before * (times[1] - times[0]) / (after - before) - 0.5 - stay)
        short.append(impedance * speed * stay - result.impulse[-1, 0, 0])
        off.append(speed * (end - 0.5 - stay) - result.q[-1, 0])  # its frame goes with its centre of mass
        assert late[-1] == pytest.approx(x * impedance / k, rel=0.01)
        force = np.interp(0.8, result.times, result.force[:, 0, 0])
        assert force == pytest.approx(impedance * speed * (1.0 - math.exp(-0.3 * k / impedance)), rel=0.01)
    assert short[0] == pytest.approx(impedance**2 * speed / stiffnesses[0] * (x - 2.0 + 2.0 * math.exp(-x)), rel=0.01)
    assert_rate(stiffnesses, late, -1.0, within=0.01)
    assert_rate(stiffnesses, short, -1.0, within=0.05)
    assert_rate(stiffnesses, off, -1.0, within=0.05)


@pytest.mark.parametrize("modes", [0, 1], ids=["rigid", "one mode"])
def test_pendulum(modes: int) -> None:
    """A spring without losses approaches impacts with e = 1. Contact takes half a period, pi sqrt(m/k).

    A rigid pendulum is late by that ever after: it is off by its speed times that. A flexible one strikes twice here.
    """
    end = 0.45
    strip = aluminium_strip(0.7, 0.028, 0.005).reduce(modes)

    def pendulum(**law: float) -> lf.Scene:
        return gallery.pendulum(friction=0.0, **law).with_bodies({"pendulum": strip})

    rigid = lf.simulate(pendulum(restitution=1.0), end, EXACT, record=end)
    assert len(rigid.events) == modes + 1
    stiffnesses = 10.0 ** np.arange(6.0, 10.5, 0.75)
    off, impulse = [], []
    for k in stiffnesses:
        scene = pendulum()
        soft = lf.simulate(scene, end, lf.Smooth(lf.Penalty(k), integrator=FINE), record=end)
        off.append(math.dist(soft.point("pendulum", "right")[-1], rigid.point("pendulum", "right")[-1]))
        impulse.append(abs(soft.impulse[-1, 0, 0] - rigid.impulse[-1, 0, 0]))
    assert_rate(stiffnesses, off, -0.5, within=0.01)
    assert_rate(stiffnesses[1:], impulse[1:], -0.5, within=0.03)
    if modes == 0:
        inertia = 0.7 * 0.028 * 0.005 * 2700.0 * 0.7**2 / 3.0
        late = math.pi * math.sqrt(inertia / 0.69**2 / stiffnesses[-1])  # the stop is 0.69 m below the hinge
        speed = math.hypot(*rigid.velocity("pendulum", "right")[-1])
        assert off[-1] == pytest.approx(speed * late, rel=0.01)


def test_peak_force_of_rigid_bodies_has_no_limit() -> None:
    """It is v sqrt(m k): an impact has an impulse, and no force."""
    stiffnesses = [1e5, 3e5, 1e6, 3e6, 1e7]
    peaks = []
    for k in stiffnesses:
        stepper = lf.Smooth(lf.Penalty(k), integrator=FINE)
        result = lf.simulate(gallery.pendulum(0, friction=0.0), 0.408, stepper, record=1e-5)
        peaks.append(result.contact("stop").peak_force)
    assert_rate(stiffnesses, peaks, 0.5, within=0.01)


@pytest.mark.parametrize(
    ("exponent", "factor"),
    [(1.5, HysteresisFactor.EXACT), (1.0, HysteresisFactor.EXACT), (1.5, HysteresisFactor.HUNT_CROSSLEY)],
    ids=["exact", "exact, linear", "Hunt & Crossley"],
)
def test_claw_approaches_newtons_law(exponent: float, factor: HysteresisFactor) -> None:
    """The exact factor for e = 0.5 approaches Newton's impact with e = 0.5; another one that of what it gives.

    All are late by the duration of contact, which goes with K^(-1/(n+1)) whatever the damping.
    """
    end = 0.45  # one impact
    restitution = 0.5 if factor is HysteresisFactor.EXACT else float(factor.rebound(0.5))
    rigid = lf.simulate(gallery.claw(50.0, restitution), end, EXACT, record=end)
    assert [event.kind for event in rigid.events] == ["impact"]
    stiffnesses = 10.0 ** np.arange(6.0, 11.0)
    off, speed = [], []
    for stiffness in stiffnesses:
        law = ContactLaw(PowerLaw(stiffness, exponent), HysteresisDamping(0.5, factor))
        soft = lf.simulate(gallery.claw(50.0), end, lf.Smooth(law, integrator=FINE), record=end)
        off.append(float(np.abs(soft.q[-1] - rigid.q[-1]).max()))
        speed.append(float(np.abs(soft.u[-1] - rigid.u[-1]).max()))
    expected = -1.0 / (exponent + 1.0)
    assert_rate(stiffnesses, off, expected, within=0.02)
    assert_rate(stiffnesses, speed, expected, within=0.02)
    assert off[-1] < 2e-4
