"""Laws of friction in simulations: on an incline, and sticking and slipping on a spring."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import lcpflex as lf
from lcpflex.force_laws.contact_law import ContactLaw
from lcpflex.force_laws.elastic.power_law import PowerLaw
from lcpflex.force_laws.friction.creep import CREEP
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
from lcpflex.model.arrays import SLIP, STICK
from lcpflex.steppers.smooth.stepper import ExplicitRungeKutta, Smooth, Stiff, Verlet
from tests.scenes import floor_of

MU, STATIC = 0.3, 0.45
SPEED = 1e-3


def name(law: Any) -> str:
    return type(law).__name__


WEIGHT, STIFFNESS = 10.0, 2e7


def block(mu: float = MU, degrees: float = 0.0) -> tuple[lf.Scene, Any]:
    """A block of 1 kg that has sunk into the floor by its weight and cannot turn; gravity leans by ``degrees``."""
    lean = math.radians(degrees)
    scene = lf.Scene(gravity=(WEIGHT * math.sin(lean), -WEIGHT * math.cos(lean)))
    sunk = -WEIGHT * math.cos(lean) / STIFFNESS
    body = scene.add(lf.RigidBody(mass=1.0, inertia=1e9, points={"p": (0.0, 0.0)}), name="block", position=(0.0, sunk))
    floor = floor_of(scene)
    scene.contact(body.node(0.0, 0.0), floor, friction=mu, name="floor")
    return scene, body


def on_floor(friction: Any, integrator: Any = None) -> Smooth:
    law = ContactLaw(PowerLaw(STIFFNESS, 1.0), friction=friction)
    return Smooth(law, integrator=integrator or ExplicitRungeKutta())


SLOPE = 10.0
RATIO = math.tan(math.radians(SLOPE)) / MU  # of what must be held to what can be


@pytest.mark.parametrize(
    ("law", "creep"),
    [
        (SmoothedCoulomb(SPEED), SPEED * math.atanh(RATIO)),
        (ArctangentCoulomb(SPEED), SPEED * math.tan(0.5 * math.pi * RATIO)),
        (RampCoulomb(SPEED), SPEED * RATIO),
        (Threlfall(SPEED), -SPEED / 3.0 * math.log(1.0 - RATIO)),
        (Ambrosio(0.2 * SPEED, SPEED), SPEED * (0.2 + 0.8 * RATIO)),
        (BengisuAkay(SPEED), SPEED * (1.0 - math.sqrt(1.0 - RATIO))),
        (BrownMcPhee(SPEED), 0.25 * SPEED * math.atanh(RATIO)),
        (LuGre(1e4, 30.0, stribeck_speed=SPEED), 0.0),
        (Bristle(1e4, 30.0, stribeck_speed=SPEED), 0.0),
    ],
    ids=lambda x: name(x) if not isinstance(x, float) else "",
)
def test_on_an_incline_only_bristles_hold(law: Any, creep: float) -> None:
    """Below the friction angle: laws without states creep at the speed where they balance gravity, bristles rest."""
    scene, _ = block(degrees=SLOPE)
    result = lf.simulate(scene, 1.0, on_floor(law), record=0.1)
    assert result.u[-1, 0] == pytest.approx(creep, rel=1e-5, abs=1e-8)
    if creep == 0.0:
        assert 0.0 < result.q[-1, 0] < 2.5 * RATIO * MU / 1e4  # while it settles some of the bristles' bend is lost
        assert np.ptp(result.q[5:, 0]) < 1e-10
        assert result.force[-1, 0, 1] == pytest.approx(-WEIGHT * math.sin(math.radians(SLOPE)), rel=1e-6)
        assert (result.state[1:] == STICK).all()
        assert result.contact(result.contact_names[0]).crept == 0.0
    else:
        history = result.contact(result.contact_names[0])
        slow = creep < 0.999 * law.slip_speed
        assert (result.state[1:] == (CREEP if slow else SLIP)).all()
        assert history.crept == pytest.approx(0.95 * creep if slow else 0.0, rel=1e-3)  # from rest, as seen
        assert not slow or "creeping, by" in result.summary()
    assert not result.warnings


def lugre_rhs(t: float, y: Any, pull: float) -> list[float]:
    s0, s1, s2, vs, mus, mu = *BLOCK_LUGRE.parameters, 0.1
    x, u, z = y
    g = mu + (mus - mu) * math.exp(-((u / vs) ** 2))
    zdot = u - s0 * abs(u) * z / g
    return [u, 2.0 * (pull * t - x) - WEIGHT * (s0 * z + s1 * zdot + s2 * u), zdot]


def bristle_rhs(t: float, y: Any, pull: float) -> list[float]:
    s0, s1, s2, vs, mus, tau, v_eps = BLOCK_BRISTLE.parameters
    mu = 0.1
    x, u, z, dwell = y
    s = math.exp(-((u / vs) ** 2))
    sign = math.copysign(1.0, u) if abs(u) > v_eps else 1.5 * u / v_eps - 0.5 * (u / v_eps) ** 3
    zdot = s * u + (1.0 - s) * (mu * sign / s1 - s0 / s1 * z)
    most = mu + (mus - mu) * dwell
    f = max(-most, min(most, s0 * z + s1 * zdot)) + s2 * u
    return [u, 2.0 * (pull * t - x) - WEIGHT * f, zdot, (s - dwell) / (tau if s >= dwell else s1 / s0)]


BLOCK_LUGRE = LuGre(1e4, math.sqrt(1e5) / 10.0, 0.04, SPEED, 0.15)
BLOCK_BRISTLE = Bristle(1e4, math.sqrt(1e5) / 10.0, 0.04, 1e-2, 0.15, 0.5)


@pytest.mark.parametrize("integrator", [ExplicitRungeKutta(1e-9, 1e-11), Stiff(1e-8, 1e-11)], ids=name)
@pytest.mark.parametrize(
    ("law", "rhs"), [(BLOCK_LUGRE, lugre_rhs), (BLOCK_BRISTLE, bristle_rhs)], ids=["LuGre", "Bristle"]
)
def test_stick_slip_on_a_spring(law: Any, rhs: Any, integrator: Any) -> None:
    """The usual test of the LuGre law: 1 kg pulled at 0.1 m/s by 2 N/m, against an integration of SciPy."""
    duration, pull = 13.0, 0.1
    scene, body = block(mu=0.1)
    height = -WEIGHT / STIFFNESS
    scene.load(lf.Spring(body.point("p"), scene.ground.at(-100.0, height), stiffness=2.0, length=100.0))
    scene.load(lf.Force(body.point("p"), (lf.Table([0.0, duration], [0.0, 2.0 * pull * duration]), 0.0)))
    result = lf.simulate(scene, duration, on_floor(law, integrator), record=0.1)
    start = np.zeros(4 if law.kind == BLOCK_BRISTLE.kind else 3)
    exact = solve_ivp(
        rhs, (0.0, duration), start, "LSODA", result.times, args=(pull,), rtol=1e-10, atol=1e-13, max_step=0.05
    ).y
    assert result.q[:, 0] == pytest.approx(exact[0], rel=0.0, abs=1e-6)
    assert result.u[:, 0] == pytest.approx(exact[1], rel=0.0, abs=1e-6)
    held = result.state[:, 0] == STICK
    assert held[40]
    assert (result.state[80:90, 0] == SLIP).all()
    assert result.energies.relative_remainder < 1e-6


def test_driver_in_python_is_the_compiled_one() -> None:
    """The same block as a system of the user's own, whose loop is Python: pulled until it slips."""
    stepper = on_floor(LuGre(1e4, 30.0, 0.04, SPEED, STATIC), Verlet(2e-5))
    scene, body = block()
    scene.load(lf.Force(body.point("p"), (lf.Table([0.0, 0.02], [0.0, 10.0]), 0.0)))
    compiled = lf.simulate(scene, 0.02, stepper, record=1e-3)
    system = lf.UserSystem(
        q=compiled.q[0, :2],
        u=[0.0, 0.0],
        mass=np.eye(2),
        force=lambda t, q, u: [500.0 * t, -WEIGHT],
        gaps=lambda q: q[1:],
        normals=[[0.0], [1.0]],
        tangents=[[1.0], [0.0]],
        friction=[MU],
    )
    own = lf.simulate(system, 0.02, stepper, record=1e-3)
    assert compiled.u[-1, 0] > 0.01
    assert np.abs(compiled.q[:, :2] - own.q).max() < 1e-10


@pytest.mark.parametrize("law", [BengisuAkay(static_friction=0.2), LuGre(static_friction=0.2)], ids=name)
def test_less_static_than_kinetic_friction_is_refused_at_the_start(law: Any) -> None:
    scene, _ = block()
    with pytest.raises(
        lf.ModelError, match=r"static_friction: 0.2 was given, expected at least the friction 0.3 .*floor"
    ):
        lf.simulate(scene, 1.0, on_floor(law))
