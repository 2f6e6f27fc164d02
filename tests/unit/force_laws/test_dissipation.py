"""Kernels of dissipative laws: their formulas, no energy out of nothing, and impacts simulated with them."""

from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import lcpflex as lf
from lcpflex.errors import ModelError
from lcpflex.force_laws.contact_law import ContactLaw
from lcpflex.force_laws.damping.dissipative import (
    Jankowski,
    KelvinVoigt,
    KuwabaraKono,
    PermanentIndentation,
    Ristow,
    Tsuji,
)
from lcpflex.force_laws.damping.hysteresis import HysteresisDamping, HysteresisFactor
from lcpflex.force_laws.damping.restitution import prescribed_restitution, restitution_of
from lcpflex.force_laws.elastic.cylinder_pair import CylinderPair
from lcpflex.force_laws.elastic.line_contact import Johnson
from lcpflex.force_laws.elastic.materials import Material
from lcpflex.force_laws.elastic.power_law import PowerLaw
from lcpflex.force_laws.layout import DAMPING
from lcpflex.force_laws.normal_kernels import contact_energy, contact_stiffness, normal_force
from lcpflex.steppers.smooth.stepper import ExplicitRungeKutta, Smooth
from tests.chance import given, settings, st
from tests.scenes import disc_on_floor

STIFFNESS, MASS, SPEED = 4e7, 0.8, 1.5
DEEP = (MASS * SPEED**2 / STIFFNESS) ** 0.4  # the scale of indentations
PAIR = CylinderPair.external(0.05, 0.08, 0.01, Material(210e9, 0.3))
LAWS = [
    HysteresisDamping(0.5),
    HysteresisDamping(0.2, HysteresisFactor.FLORES),
    Tsuji(0.4),
    KuwabaraKono(2e-5),
    Ristow(3e3),
    Jankowski(0.4),
    PermanentIndentation(0.6),
]


def name(law: Any) -> str:
    return type(law).__name__


def packed(damping: Any, exponent: float = 1.5, stiffness: float = STIFFNESS) -> tuple[Any, Any]:
    row = ContactLaw(PowerLaw(stiffness, exponent), damping).row()
    return np.array(row.kinds), np.array(row.parameters)


@pytest.mark.parametrize(
    ("damping", "n", "added"),
    [
        (HysteresisDamping(0.5), 1.5, lambda d, v: STIFFNESS * d**1.5 * 1.43275053 * v / SPEED),
        (HysteresisDamping(0.3, HysteresisFactor.YE), 1.0, lambda d, v: STIFFNESS * d * 3.5 * v / SPEED),
        (KelvinVoigt(math.exp(-math.pi)), 1.0, lambda d, v: 2.0 * math.sqrt(0.5 * STIFFNESS * MASS) * v),
        (KelvinVoigt(0.0, mass=5.0), 1.0, lambda d, v: 2.0 * math.sqrt(STIFFNESS * 5.0) * v),
        (Tsuji(0.0), 1.5, lambda d, v: math.sqrt(5.0 * STIFFNESS * MASS) * d**0.25 * v),
        (Tsuji(0.0, mass=5.0), 2.0, lambda d, v: math.sqrt(6.0 * STIFFNESS * 5.0 * d) * v),
        (KuwabaraKono(1e-4), 1.5, lambda d, v: 1.5e-4 * STIFFNESS * math.sqrt(d) * v),
        (Ristow(300.0), 1.5, lambda d, v: 300.0 * MASS * v),
        (Ristow(300.0, mass=0.1), 1.5, lambda d, v: 30.0 * v),
        (
            Jankowski(0.5),
            1.5,
            lambda d, v: max(v, 0.0) * 2.0 * (4.5 * math.sqrt(5) * 0.75 / (0.5 * (4.5 * math.pi + 8.0)))
            * math.sqrt(STIFFNESS * MASS) * d**0.25,
        ),
    ],
    ids=lambda part: type(part).__name__,
)  # fmt: skip
def test_formulas(damping: Any, n: float, added: Any) -> None:
    kinds, p = packed(damping, n)
    for depth in (1e-9, 0.1 * DEEP, DEEP):
        for rate in (SPEED, 1e-3, -1e-3, -0.5 * SPEED, -3.0 * SPEED):
            force, elastic = normal_force(kinds, p, depth, rate, SPEED, MASS, depth, True)
            assert elastic == pytest.approx(STIFFNESS * depth**n, rel=1e-12)
            assert force == pytest.approx(max(0.0, elastic + added(depth, rate)), rel=1e-8)
    assert normal_force(kinds, p, DEEP, -1e6, SPEED, MASS, DEEP, True)[0] == (
        STIFFNESS * DEEP**n if isinstance(damping, Jankowski) else 0.0
    )


@pytest.mark.parametrize("damping", [law for law in LAWS if not isinstance(law, Ristow)], ids=name)
def test_no_jump_at_touch(damping: Any) -> None:
    kinds, p = packed(damping)
    forces = [normal_force(kinds, p, DEEP * 10.0**k, SPEED, SPEED, MASS, 0.0, True)[0] for k in range(-60, 1)]
    assert forces[0] < 1e-14 * forces[-1]
    assert np.all(np.diff(forces) > 0.0)


@pytest.mark.parametrize(
    ("damping", "n", "jump"),
    [(KelvinVoigt(0.0), 1.0, 2.0 * math.sqrt(STIFFNESS * MASS) * SPEED), (Ristow(300.0), 1.5, 300.0 * MASS * SPEED)],
    ids=("KelvinVoigt", "Ristow"),
)
def test_jump_at_touch(damping: Any, n: float, jump: float) -> None:
    kinds, p = packed(damping, n)
    assert normal_force(kinds, p, 1e-60, SPEED, SPEED, MASS, 0.0, True)[0] == pytest.approx(jump, rel=1e-12)


@pytest.mark.parametrize("damping", [Tsuji(0.4), Tsuji(0.4, mass=2.0), Jankowski(0.4)], ids=name)
@pytest.mark.parametrize("n", [1.0, 1.5])
def test_forces_of_the_least_indentations_are_finite(damping: Any, n: float) -> None:
    """Where what is stored is hardly a number any more, 2 m / E is none."""
    kinds, p = packed(damping, n)
    for depth in (5e-324, *np.geomspace(1e-320, 1e-100, 111)):
        for rate in (0.0, SPEED, -SPEED):
            force, _ = normal_force(kinds, p, depth, rate, SPEED, MASS, depth, True)
            assert 0.0 <= force <= 1.1 * math.sqrt(8.0 * STIFFNESS * 2.0) * SPEED


@pytest.mark.parametrize("damping", [Tsuji(0.4), Ristow(300.0), Jankowski(0.4)], ids=name)
def test_what_cannot_move_is_not_damped(damping: Any) -> None:
    """Of a contact between bodies that are both held the effective mass is infinite."""
    kinds, p = packed(damping)
    for rate in (0.0, SPEED):
        force, elastic = normal_force(kinds, p, DEEP, rate, SPEED, math.inf, DEEP, True)
        assert force == elastic == pytest.approx(STIFFNESS * DEEP**1.5, rel=1e-14)


def test_guard_of_the_impact_speed() -> None:
    kinds, p = packed(HysteresisDamping(0.5, guard_speed=0.01))
    slow, at_guard, fast = (normal_force(kinds, p, DEEP, 0.005, v, MASS, DEEP, True)[0] for v in (0.0, 0.01, 0.02))
    elastic = STIFFNESS * DEEP**1.5
    assert slow == at_guard == pytest.approx(elastic * (1.0 + 1.43275053 * 0.5))
    assert fast == pytest.approx(elastic * (1.0 + 1.43275053 * 0.25))


def test_permanent_indentation() -> None:
    """F_m ((d - d_p)/(d_m - d_p))^n on the way out and in again, d_p = (1 - e^2) d_m; nothing below, K d^n beyond."""
    e, n = 0.6, 1.5
    kinds, p = packed(PermanentIndentation(e), n)
    left = (1.0 - e**2) * DEEP
    top = STIFFNESS * DEEP**n
    assert normal_force(kinds, p, DEEP, 1.0, SPEED, MASS, 0.0, True)[0] == pytest.approx(top)
    for share in (0.1, 0.5, 0.999):
        depth = left + share * (DEEP - left)
        for rate in (-1.0, 1.0):
            force, stored = normal_force(kinds, p, depth, rate, SPEED, MASS, DEEP, False)
            assert force == stored == pytest.approx(top * share**n)
    assert normal_force(kinds, p, 0.999 * left, -1.0, SPEED, MASS, DEEP, False) == (0.0, 0.0)
    assert contact_energy(kinds, p, 0.999 * left, DEEP, False) == 0.0
    assert contact_stiffness(kinds, p, 0.999 * left, DEEP, False) == 0.0
    assert normal_force(kinds, p, 1.1 * DEEP, 1.0, SPEED, MASS, DEEP, False)[0] == pytest.approx(top * 1.1**n)
    assert left == pytest.approx((n + 1.0) * (top * DEEP / (n + 1.0) * 2.0) * (1.0 - e**2) / (2.0 * top))


@pytest.mark.parametrize("damping", LAWS, ids=name)
def test_what_is_stored_is_what_the_force_stores(damping: Any) -> None:
    kinds, p = packed(damping)
    for deepest, loading in ((0.0, True), (DEEP, False)):
        for depth in (0.7 * DEEP, 0.9 * DEEP, 1.3 * DEEP):
            step = 1e-5 * DEEP
            ends = [contact_energy(kinds, p, depth + sign * step, deepest, loading) for sign in (-1.0, 1.0)]
            forces = [
                normal_force(kinds, p, depth + sign * step, 0.0, SPEED, MASS, deepest, loading) for sign in (-1.0, 1.0)
            ]
            stored = normal_force(kinds, p, depth, 0.0, SPEED, MASS, deepest, loading)[1]
            assert (ends[1] - ends[0]) / (2.0 * step) == pytest.approx(stored, rel=1e-7)
            slope = (forces[1][0] - forces[0][0]) / (2.0 * step)
            assert slope == pytest.approx(contact_stiffness(kinds, p, depth, deepest, loading), rel=1e-7)


NODES, WEIGHTS = np.polynomial.legendre.leggauss(16)


def work_of(kinds: Any, p: Any, start: float, end: float, rate: float, deepest: float) -> float:
    """Work done on a contact that is indented from start to end at a constant rate."""
    loading = end > start and start >= deepest
    corners = [deepest, (1.0 - p[DAMPING] ** 2) * deepest]  # of a permanent indentation
    inside = sorted(c for c in corners if min(start, end) < c < max(start, end))
    marks = [start, *(inside if end > start else inside[::-1]), end]
    total = 0.0
    for a, b in itertools.pairwise(marks):
        for node, weight in zip(NODES.tolist(), WEIGHTS.tolist(), strict=True):
            depth = 0.5 * (a + b) + 0.5 * (b - a) * node
            force = normal_force(kinds, p, depth, rate, SPEED, MASS, deepest, loading)[0] if depth > 0.0 else 0.0
            total += 0.5 * (b - a) * weight * force
    return total


@pytest.mark.parametrize("damping", LAWS, ids=name)
@settings(max_examples=20)
@given(
    depths=st.lists(st.floats(0.0, 2.0), min_size=1, max_size=6),
    rates=st.lists(st.floats(1e-4, 10.0), min_size=7, max_size=7),
    exponent=st.floats(1.0, 3.0),
)
def test_no_energy_out_of_a_closed_loop(damping: Any, depths: list[float], rates: list[float], exponent: float) -> None:
    kinds, p = packed(damping, exponent)
    work = deepest = start = 0.0
    scale = STIFFNESS * (2.0 * DEEP) ** (exponent + 1.0)
    for end, rate in zip([*(DEEP * d for d in depths), 0.0], rates, strict=False):
        direction = math.copysign(rate * SPEED, end - start)
        before = contact_energy(kinds, p, start, deepest, start >= deepest)
        done = work_of(kinds, p, start, end, direction, deepest)
        deepest = max(deepest, end)
        after = contact_energy(kinds, p, end, deepest, end >= deepest)
        assert done >= after - before - 1e-6 * scale  # a kink where the force is clipped costs the quadrature digits
        work += done
        start = end
    assert work >= -1e-6 * scale


@settings(max_examples=25)
@given(
    e=st.floats(0.02, 1.0),
    exponent=st.floats(1.0, 3.5),
    mass=st.floats(1e-6, 1e6),
    stiffness=st.floats(1.0, 1e12),
    speed=st.floats(1e-3, 100.0),
)
def test_exact_law_gives_what_is_prescribed(
    e: float, exponent: float, mass: float, stiffness: float, speed: float
) -> None:
    kinds, p = packed(HysteresisDamping(e), exponent, stiffness)
    depth = (mass * speed**2 / stiffness) ** (1.0 / (exponent + 1.0))

    def slope(_: float, y: Any) -> tuple[float, float]:
        if y[0] <= 0.0:
            return float(y[1]), 0.0
        force = normal_force(kinds, p, depth * float(y[0]), speed * float(y[1]), speed, mass, 0.0, True)[0]
        return float(y[1]), -force * depth / (mass * speed**2)

    def parted(t: float, y: Any) -> float:
        return float(y[0]) if y[1] < 0.0 else 1.0

    parted.terminal = True  # type: ignore[attr-defined]
    path = solve_ivp(slope, (0.0, 1e3), (0.0, 1.0), "DOP853", rtol=1e-10, atol=1e-12, events=parted)
    assert -path.y[1, -1] == pytest.approx(e, abs=1e-7)


def wall(mass: float, speed: float) -> lf.Scene:
    """A ball flies towards a wall, without weight."""
    return disc_on_floor(0.101, (0.0, -speed), mass=mass, gravity=0.0, name="wall")


def rebound(law: ContactLaw, integrator: Any = None, mass: float = MASS, speed: float = SPEED) -> lf.Result:
    """A run until the ball is off the wall again."""
    integrator = ExplicitRungeKutta(atol=1e-10) if integrator is None else integrator
    return lf.simulate(wall(mass, speed), 0.02 / speed, Smooth(law, integrator=integrator), record=1e-4 / speed)


def out_of(result: lf.Result) -> float:
    assert result.q[-1, 1] > 0.1
    return float(result.u[-1, 1] / -result.u[0, 1])


@pytest.mark.parametrize(
    ("damping", "n", "e"),
    [
        (HysteresisDamping(0.5), 1.5, 0.5),
        (HysteresisDamping(0.15), 2.5, 0.15),
        (HysteresisDamping(0.5, HysteresisFactor.LANKARANI_NIKRAVESH), 1.5, 0.7252),
        (KelvinVoigt(0.5), 1.0, restitution_of(KelvinVoigt, 0.5)),
        (KelvinVoigt(prescribed_restitution(KelvinVoigt, 0.5)), 1.0, 0.5),
        (Tsuji(prescribed_restitution(Tsuji, 0.3)), 1.5, 0.3),
        (KuwabaraKono(2e-5), 1.5, restitution_of(KuwabaraKono, 2e-5 * (STIFFNESS / MASS) ** 0.4 * SPEED**0.2)),
        (Ristow(800.0), 1.5, restitution_of(Ristow, 800.0 * (MASS / STIFFNESS) ** 0.4 * SPEED**-0.2)),
        (Jankowski(0.5), 1.5, restitution_of(Jankowski, 0.5)),
        (PermanentIndentation(0.5), 1.5, 0.5),
    ],
    ids=lambda part: type(part).__name__ if not isinstance(part, float) else "",
)
def test_impacts_on_a_wall(damping: Any, n: float, e: float) -> None:
    result = rebound(ContactLaw(PowerLaw(STIFFNESS * DEEP ** (1.5 - n), n), damping))
    assert out_of(result) == pytest.approx(e, abs=5e-5)
    assert np.abs(result.energies.remainder).max() < 1e-5 * 0.5 * MASS * SPEED**2
    assert result.force[:, 0, 0].min() >= 0.0


@pytest.mark.parametrize("bad", [-0.1, 1.5, math.nan, "half", None])
@pytest.mark.parametrize("law", [HysteresisDamping, KelvinVoigt, Tsuji, Jankowski, PermanentIndentation])
def test_restitution_out_of_range(law: Any, bad: Any) -> None:
    with pytest.raises(ModelError, match="restitution"):
        law(bad)


@pytest.mark.parametrize(
    ("law", "arguments", "named"),
    [
        (HysteresisDamping, {"restitution": 0.0}, "restitution"),
        (HysteresisDamping, {"restitution": 0.5, "factor": "exact"}, "factor"),
        (HysteresisDamping, {"restitution": 0.5, "guard_speed": 0.0}, "guard_speed"),
        (Jankowski, {"restitution": 0.0}, "restitution"),
        (PermanentIndentation, {"restitution": 0.0}, "restitution"),
        (KelvinVoigt, {"restitution": 0.5, "mass": 0.0}, "mass"),
        (Tsuji, {"restitution": 0.5, "mass": -1.0}, "mass"),
        (Ristow, {"rate": -1.0}, "rate"),
        (Ristow, {"rate": 1.0, "mass": math.inf}, "mass"),
        (Jankowski, {"restitution": 0.5, "mass": math.nan}, "mass"),
        (KuwabaraKono, {"relaxation": -1e-6}, "relaxation"),
    ],
)
def test_what_is_refused(law: Any, arguments: dict[str, Any], named: str) -> None:
    with pytest.raises(ModelError, match=rf"^{named}: .* was given, expected"):
        law(**arguments)


@pytest.mark.parametrize("factor", [HysteresisFactor.HUNT_CROSSLEY, HysteresisFactor.LANKARANI_NIKRAVESH])
def test_no_restitution_at_all_where_the_factor_is_finite(factor: HysteresisFactor) -> None:
    assert HysteresisDamping(0.0, factor).eta == factor.eta(0.0) > 0.0


@pytest.mark.parametrize(
    "damping",
    [KelvinVoigt(0.5), HysteresisDamping(0.5, HysteresisFactor.YE), HysteresisDamping(0.5, HysteresisFactor.PANT)],
    ids=("KelvinVoigt", "Ye", "Pant"),
)
def test_laws_of_linear_springs(damping: Any) -> None:
    ContactLaw(PowerLaw(STIFFNESS, 1.0), damping)
    for elastic in (PowerLaw(STIFFNESS, 1.5), Johnson(PAIR)):
        with pytest.raises(ModelError, match="expected a linear spring"):
            ContactLaw(elastic, damping)


@pytest.mark.parametrize(
    "damping", [HysteresisDamping(0.5), Tsuji(0.2), Jankowski(0.4), PermanentIndentation(0.5)], ids=name
)
def test_restitution_is_that_of_any_elastic_law(damping: Any) -> None:
    """In the plane of (2 E)^(1/2) and v these do not know the elastic law: here a logarithmic one."""
    row = ContactLaw(Johnson(PAIR), damping).row()
    kinds, p = np.array(row.kinds), np.array(row.parameters)
    mass, speed, depth, deepest = 2.0, 0.4, 2e-5, [0.0, True]

    def slope(_: float, y: Any) -> tuple[float, float]:
        d = depth * float(y[0])
        if d <= 0.0:
            return float(y[1]), 0.0
        force = normal_force(kinds, p, d, speed * float(y[1]), speed, mass, *deepest)[0]
        return float(y[1]), -force * depth / (mass * speed**2)

    def turn(_: float, y: Any) -> float:
        return float(y[1])

    def parted(_: float, y: Any) -> float:
        return float(y[0])

    turn.terminal = parted.terminal = True  # type: ignore[attr-defined]
    parted.direction = -1.0  # type: ignore[attr-defined]
    way_in = solve_ivp(slope, (0.0, 1e3), (0.0, 1.0), "DOP853", rtol=1e-11, atol=1e-14, events=turn)
    deepest[:] = depth * float(way_in.y[0, -1]), False
    way_out = solve_ivp(slope, (0.0, 1e3), way_in.y[:, -1], "DOP853", rtol=1e-11, atol=1e-14, events=parted)
    law = damping.factor if isinstance(damping, HysteresisDamping) else type(damping)
    assert -way_out.y[1, -1] == pytest.approx(restitution_of(law, damping.restitution), rel=1e-6)
