"""Friction laws: their shapes, the facts known of bristles, and blocks that creep, hold, stick and slip."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import lcpflex as lf
from lcpflex.errors import ModelError
from lcpflex.force_laws.friction.kernels import KINDS, bristle_rates, friction_force
from lcpflex.force_laws.friction.laws import (
    Ambrosio,
    ArctangentCoulomb,
    BengisuAkay,
    Bristle,
    BrownMcPhee,
    LuGre,
    RampCoulomb,
    SmoothedCoulomb,
    Threlfall,
)
from lcpflex.force_laws.layout import FRICTION, PARAMETERS

MU, STATIC = 0.3, 0.45
SPEED = 1e-3
MEMORYLESS = [
    SmoothedCoulomb(SPEED),
    ArctangentCoulomb(SPEED),
    RampCoulomb(SPEED),
    Threlfall(SPEED),
    Ambrosio(0.2 * SPEED, SPEED),
    BengisuAkay(SPEED, 500.0, STATIC),
    BengisuAkay(SPEED),
    BrownMcPhee(SPEED, STATIC),
    BrownMcPhee(SPEED, STATIC, viscous=2.0),
]


def name(law: Any) -> str:
    return type(law).__name__


# --- laws without states


@pytest.mark.parametrize("law", MEMORYLESS, ids=name)
def test_odd_opposing_bounded_and_proportional(law: Any) -> None:
    slip = np.concatenate([np.linspace(-5.0, 5.0, 4001) * SPEED, [-1.0, 1.0]])
    force = law.force(slip, 10.0, MU)
    viscous = getattr(law, "viscous", 0.0) * np.abs(slip)
    assert (force * slip <= 0.0).all()
    assert force == pytest.approx(-law.force(-slip, 10.0, MU), rel=1e-15)
    most = (MU if getattr(law, "static_friction", None) is None else STATIC) + viscous
    assert (np.abs(force) <= 10.0 * most * (1.0 + 1e-12)).all()
    assert force == pytest.approx(10.0 * law.force(slip, 1.0, MU), rel=1e-14)
    assert law.force(0.0, 10.0, MU) == 0.0
    assert law.force(slip, 0.0, MU) == pytest.approx(np.zeros(len(slip)), abs=0.0)


@pytest.mark.parametrize("law", MEMORYLESS, ids=name)
def test_continuous(law: Any) -> None:
    """Between neighbours the force changes by no more than the steepest slope of these laws, at 0."""
    step = SPEED / 1000.0
    slip = np.arange(-4000, 4001) * step
    steepest = 4.0 * STATIC / SPEED
    assert np.abs(np.diff(law.force(slip, 1.0, MU))).max() <= steepest * step


@pytest.mark.parametrize(
    ("law", "at", "expected"),
    [
        (SmoothedCoulomb(SPEED), SPEED, MU * math.tanh(1.0)),
        (ArctangentCoulomb(SPEED), SPEED, MU / 2.0),
        (RampCoulomb(SPEED), 0.25 * SPEED, 0.25 * MU),
        (RampCoulomb(SPEED), 3.0 * SPEED, MU),
        (Threlfall(SPEED), SPEED / 3.0, MU * (1.0 - math.exp(-1.0))),
        (Threlfall(SPEED), 7.0 * SPEED, MU * 0.950212931632136),
        (Ambrosio(1e-4, 2e-4), 1e-4, 0.0),
        (Ambrosio(1e-4, 2e-4), 1.25e-4, 0.25 * MU),
        (Ambrosio(1e-4, 2e-4), 1.0, MU),
        (BengisuAkay(SPEED, 500.0, STATIC), SPEED, STATIC),
        (BengisuAkay(SPEED, 500.0, STATIC), 0.5 * SPEED, 0.75 * STATIC),
        (BengisuAkay(SPEED, 500.0, STATIC), 3.0 * SPEED, MU + (STATIC - MU) * math.exp(-1.0)),
        (BrownMcPhee(SPEED, STATIC, 2.0), SPEED, MU * math.tanh(4.0) + (STATIC - MU) + 2.0 * SPEED),
        (BrownMcPhee(SPEED), 0.5 * SPEED, MU * math.tanh(2.0)),
    ],
)
def test_values(law: Any, at: float, expected: float) -> None:
    assert law.force(at, 10.0, MU) == pytest.approx(-10.0 * expected, rel=1e-13)


def test_arrays_are_broadcast() -> None:
    force = SmoothedCoulomb(SPEED).force(np.array([[1.0], [-1.0]]), [1.0, 2.0, 3.0], MU)
    assert force == pytest.approx(np.array([[-1.0, -2.0, -3.0], [1.0, 2.0, 3.0]]) * MU)
    assert isinstance(SmoothedCoulomb(SPEED).force(1.0, 1.0, MU), float)


# --- bristles


def row(law: Any) -> tuple[Any, Any]:
    p = np.zeros(PARAMETERS)
    p[FRICTION : FRICTION + len(law.parameters)] = law.parameters
    return np.array([0, 0, KINDS.index(law.kind), 0]), p


def slide(law: Any, slip: Any, duration: float, normal: float = 10.0) -> tuple[Any, Any, Any]:
    """Times, states and forces of a contact that slides at slip(t), by the kernels and an integrator of SciPy."""
    kinds, p = row(law)

    def rates(t: float, y: Any) -> tuple[float, float]:
        return bristle_rates(kinds, p, slip(t), normal, MU, y[0], y[1])

    found = solve_ivp(rates, (0.0, duration), [0.0, 0.0], "LSODA", rtol=1e-9, atol=1e-14, max_step=duration / 200)
    forces = [
        friction_force(kinds, p, slip(t), normal, MU, *y) for t, y in zip(found.t.tolist(), found.y.T, strict=True)
    ]
    return found.t, found.y, np.array(forces)


@pytest.mark.parametrize("speed", [-0.3, 5e-4, 1e-3, 3e-3, 1.0])
def test_lugre_comes_to_the_stribeck_curve(speed: float) -> None:
    law = LuGre(1e4, 30.0, 0.05, SPEED, STATIC)
    _, states, forces = slide(law, lambda t: speed, 20.0 * STATIC / 1e4 / abs(speed))
    assert forces[-1] == pytest.approx(law.steady_force(speed, 10.0, MU), rel=1e-7)
    steady = MU + (STATIC - MU) * math.exp(-((speed / SPEED) ** 2))
    assert states[0, -1] == pytest.approx(math.copysign(steady / 1e4, speed), rel=1e-7)
    assert law.steady_force(speed, 10.0, MU) == pytest.approx(-10.0 * (math.copysign(steady, speed) + 0.05 * speed))


@pytest.mark.parametrize("slip", [-0.02, -SPEED, -4e-6, 0.0, 3e-6, 0.5 * SPEED, 2.0 * SPEED])
@pytest.mark.parametrize("bristle", [-2e-5, 0.0, 4e-5])
def test_formulas_of_bristles(slip: float, bristle: float) -> None:
    s0, s1, s2, normal = 1e4, 30.0, 0.04, 7.0
    s = math.exp(-((slip / SPEED) ** 2))
    kinds, p = row(LuGre(s0, s1, s2, SPEED, STATIC))
    rate = slip - s0 * abs(slip) * bristle / (MU + (STATIC - MU) * s)
    assert bristle_rates(kinds, p, slip, normal, MU, bristle, 0.0) == pytest.approx((rate, 0.0), rel=1e-13)
    force = friction_force(kinds, p, slip, normal, MU, bristle, 0.0)
    assert force == pytest.approx(-normal * (s0 * bristle + s1 * rate + s2 * slip), rel=1e-13)
    kinds, p = row(Bristle(s0, s1, s2, SPEED, STATIC, 0.5))
    x = max(-1.0, min(1.0, slip / (0.01 * SPEED)))
    rate = s * slip + (1.0 - s) * (MU * (1.5 * x - 0.5 * x**3) - s0 * bristle) / s1
    for dwell in (0.0, 0.7):
        lag = 0.5 if s >= dwell else s1 / s0
        rates = bristle_rates(kinds, p, slip, normal, MU, bristle, dwell)
        assert rates == pytest.approx((rate, (s - dwell) / lag), rel=1e-12)
        most = MU + (STATIC - MU) * dwell
        part = max(-most, min(most, s0 * bristle + s1 * rate))
        force = friction_force(kinds, p, slip, normal, MU, bristle, dwell)
        assert force == pytest.approx(-normal * (part + s2 * slip), rel=1e-12)


@pytest.mark.parametrize("law", [LuGre(1e4, 0.0), Bristle(1e4, 1.0)], ids=name)
def test_presliding_is_a_spring(law: Any) -> None:
    """Displaced by a hundredth of what it takes to slip: force sigma_0 lambda_N x, given back on the way back."""
    amplitude, period = 0.01 * MU / 1e4, 10.0

    def slip(t: float) -> float:
        return amplitude * 2.0 * math.pi / period * math.sin(2.0 * math.pi * t / period)

    times, _, forces = slide(law, slip, period)
    x = amplitude * (1.0 - np.cos(2.0 * math.pi * times / period))
    assert forces == pytest.approx(-10.0 * 1e4 * x, abs=0.05 * 10.0 * 1e4 * amplitude)
    top = int(np.argmax(x))
    assert forces[top] == pytest.approx(-10.0 * 1e4 * x[top], rel=0.03)


@pytest.mark.parametrize("law", [LuGre(1e4, 30.0), Bristle(1e4, 30.0, static_friction=STATIC)], ids=name)
@pytest.mark.parametrize("amplitude", [1e-5, 1e-4, 1e-2])
def test_closed_cycles_take_energy(law: Any, amplitude: float) -> None:
    """From the second cycle on bristles end as they began."""
    times, _, forces = slide(law, lambda t: amplitude * 2.0 * math.pi * math.sin(2.0 * math.pi * t), 3.0)
    power = -forces * amplitude * 2.0 * math.pi * np.sin(2.0 * math.pi * times)
    later = times >= 1.0
    assert np.trapezoid(power[later], times[later]) > 0.0


def test_bristles_stay_below_the_static_deflection() -> None:
    law = LuGre(1e4, 30.0, 0.0, SPEED, STATIC)
    _, states, _ = slide(law, lambda t: 0.1 * math.sin(7.0 * t) + 0.05 * math.sin(61.0 * t), 5.0)
    assert np.abs(states[0]).max() <= STATIC / 1e4 * (1.0 + 1e-9)


@pytest.mark.parametrize("rest", [0.01, 0.1, 0.5, 3.0])
def test_static_friction_of_bristles_grows_with_the_dwell(rest: float) -> None:
    """f = mu + (mu_s - mu) (1 - exp(-t/tau)) after a rest of t: the limit of the force as the contact is pulled."""
    law = Bristle(1e6, 1e3, stribeck_speed=SPEED, static_friction=STATIC, dwell_time=0.5)
    pull, bending = 0.01 * SPEED, 0.06  # so slow that it is rest to the law, but bends the bristles to their limit

    def slip(t: float) -> float:
        return 0.0 if t < rest else pull

    _, states, forces = slide(law, slip, rest + bending)
    limit = MU + (STATIC - MU) * states[1]
    assert states[1, -1] == pytest.approx(1.0 - math.exp(-(rest + bending) / 0.5), rel=1e-3)
    assert (np.abs(forces) <= 10.0 * limit * (1.0 + 1e-12)).all()
    assert abs(forces[-1]) == pytest.approx(10.0 * limit[-1], rel=1e-12)


# --- what is refused


@pytest.mark.parametrize(
    ("law", "argument", "value"),
    [
        (SmoothedCoulomb, "slip_speed", 0.0),
        (Threlfall, "slip_speed", math.nan),
        (Ambrosio, "slip_speed", 1e-4),
        (Ambrosio, "rest_speed", -1.0),
        (BengisuAkay, "decay", -1.0),
        (BengisuAkay, "static_friction", -0.1),
        (BrownMcPhee, "viscous", math.inf),
        (LuGre, "stiffness", 0.0),
        (LuGre, "damping", -1.0),
        (LuGre, "static_friction", "x"),
        (Bristle, "damping", 0.0),
        (Bristle, "dwell_time", 0.0),
        (Bristle, "direction_speed", 0.0),
    ],
)
def test_bad_arguments(law: Any, argument: str, value: Any) -> None:
    with pytest.raises(lf.ModelError, match=argument):
        law(**{argument: value})


def test_bad_arguments_of_the_force() -> None:
    with pytest.raises(lf.ModelError, match=r"normal: -1\.0"):
        Threlfall().force(1.0, [1.0, -1.0], MU)
    with pytest.raises(lf.ModelError, match=r"mu: -0\.1"):
        Threlfall().force(1.0, 1.0, -0.1)
    with pytest.raises(lf.ModelError, match="static_friction"):
        BrownMcPhee(static_friction=0.2).force(1.0, 1.0, 0.3)


@pytest.mark.parametrize("law", [*MEMORYLESS, LuGre()], ids=name)
@pytest.mark.parametrize("bad", [math.nan, math.inf, "fast", None])
def test_what_is_no_finite_number(law: Any, bad: Any) -> None:
    force = law.steady_force if isinstance(law, LuGre) else law.force
    for place, named in enumerate(("slip", "normal", "mu")):
        given: list[Any] = [1.0, 1.0, MU]
        given[place] = bad
        with pytest.raises(lf.ModelError, match=f"^{named}: .*was given, expected"):
            force(*given)


def test_bad_arguments_of_steady_friction() -> None:
    with pytest.raises(lf.ModelError, match=r"^normal: -3\.0"):
        LuGre().steady_force(1.0, -3.0, MU)
    with pytest.raises(lf.ModelError, match="static_friction"):
        LuGre(static_friction=0.2).steady_force(1.0, 1.0, MU)
    assert LuGre().steady_force(np.ones((0, 2)), 1.0, MU).shape == (0, 2)


def test_slope_at_rest_is_free_of_cancellation() -> None:
    slip = np.geomspace(1e-300, 1e-9, 30)
    assert BengisuAkay(SPEED, 1.0, STATIC).force(slip, 1.0, MU) == pytest.approx(
        -2.0 * STATIC / SPEED * slip * (1.0 - 0.5 * slip / SPEED), rel=1e-14
    )


@pytest.mark.parametrize(
    "force",
    [
        BrownMcPhee(viscous=0.5).force,
        BrownMcPhee(viscous=0.5, static_friction=0.4).force,
        BengisuAkay(static_friction=0.4).force,
        LuGre(viscous=0.5, static_friction=0.4).steady_force,
    ],
)
def test_a_contact_without_friction_has_none_as_in_a_run(force) -> None:
    assert force(0.7, 10.0, 0.0) == 0.0
    assert force(np.array([0.7, -0.7]), 10.0, np.array([0.0, 0.3])).tolist() == [0.0, force(-0.7, 10.0, 0.3)]
    assert force(-0.7, 10.0, 1e-12) > 0.0


def test_arrays_that_do_not_go_together_are_refused() -> None:
    for force in (BrownMcPhee().force, LuGre().steady_force):
        with pytest.raises(ModelError, match=r"^slip, normal, mu: arrays of shapes .* expected ones that go together"):
            force([1.0, 2.0], [1.0, 2.0, 3.0], 0.3)
