"""Friction by a law under Moreau-Jean: branches, joints, several contacts, stick-slip where friction falls."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.dynamics import contact_forces_friction
from lcpflex.dynamics.contact_forces_friction import balanced_friction
from lcpflex.force_laws.friction.kernels import KINDS, friction_force
from lcpflex.force_laws.friction.laws import BengisuAkay, BrownMcPhee, SmoothedCoulomb
from lcpflex.force_laws.layout import FRICTION, PARAMETERS
from lcpflex.jit.kernel import interpreted
from tests.chance import given, st
from tests.scenes import floor_of

MASS, SPRING, PULL, WEIGHT, MU, STATIC = 0.25, 5e3, 0.02, 20.0, 0.3, 0.5
DROP = (STATIC - MU) * WEIGHT


class OneLaw:
    """The part of a ContactMemory that friction reads."""

    def __init__(self, law: Any) -> None:
        p = np.zeros(PARAMETERS)
        p[FRICTION : FRICTION + len(law.parameters)] = law.parameters
        self.kinds, self.parameters = np.array([[0, 0, KINDS.index(law.kind), 0]]), p[None]


LAWS = [
    BrownMcPhee(1e-3, static_friction=0.5), BrownMcPhee(1e-2, static_friction=0.9, viscous=2.0),
    BengisuAkay(1e-3, decay=400.0, static_friction=0.6), BengisuAkay(1e-4, decay=2e4, static_friction=0.5),
    BrownMcPhee(1e-3), SmoothedCoulomb(1e-3),
]  # fmt: skip


@given(
    law=st.sampled_from(LAWS),
    before=st.floats(-0.05, 0.05),
    free=st.floats(-0.05, 0.05),
    power=st.floats(-8.0, -2.0),
    normal=st.floats(0.1, 100.0),
)
def test_the_first_balance_on_the_way(law: Any, before: float, free: float, power: float, normal: float) -> None:
    """The slip in the end balances, and on the way to it from the slip before there is no other that does."""
    memory, share = OneLaw(law), 10.0**power
    plain = {name: getattr(contact_forces_friction, name).py_func for name in ("excess", "fold", "turn", "rise")}
    plain |= {"friction_force": friction_force.py_func}
    plain = {name: interpreted(kernel, **plain) for name, kernel in plain.items()}
    for kernel in plain.values():
        kernel.__globals__.update(plain)
    solve = interpreted(balanced_friction, **plain)
    force = solve(memory, 0, 0.3, normal, before, free, share)

    def excess(slip: float) -> float:
        return free + share * law.force(slip, normal, 0.3) - slip

    slip = free + share * force
    steepest = share * normal * 4.0 / law.slip_speed
    assert abs(excess(slip)) <= 1e-11 * (1.0 + steepest)
    between = before + (slip - before) * np.linspace(0.0, 1.0, 4001)[1:-40]
    left = free + share * law.force(between, normal, 0.3) - between
    assert (left * math.copysign(1.0, slip - before) > -1e-9 * (1.0 + steepest)).all()


def pulled(
    law: Any, joints: bool = False, contacts: int = 1, length: float = 1.0, mass: float = 1.0
) -> tuple[lf.Scene, str]:
    """A block pressed on the ground is pulled by a spring at constant speed; in units of ``length`` m and ``mass`` kg.

    With ``joints`` it is of two halves welded together, and only one of them touches.
    """
    force = mass * length
    each = lf.ContactLaw(
        lf.laws.PowerLaw(1e6 / contacts * mass, exponent=1.0), lf.laws.KelvinVoigt(restitution=0.2), friction=law
    )
    scene = lf.Scene(gravity=(0.0, 0.0))
    part = 0.5 if joints else 1.0
    box = scene.add(lf.Box(0.2 * length, 0.1 * length, mass=part * MASS * mass), "block", position=(0.0, 0.15 * length))
    floor = floor_of(scene)
    for x in np.linspace(-0.1, 0.1, contacts) if contacts > 1 else [0.0]:
        scene.contact(box.node(x * length, -0.15 * length), floor, friction=MU, law=each)
    top = box
    if joints:
        top = scene.add(
            lf.Box(0.2 * length, 0.1 * length, mass=0.5 * MASS * mass), "top", position=(0.0, 0.25 * length)
        )
        scene.join(lf.Weld(box.at(0.0, 0.1 * length), top.point("center")))
    height = 0.25 * length if joints else 0.15 * length
    scene.join(lf.DrivenAngle(top.point("center"), scene.ground.at(0.0, height), 0.0))
    speed = PULL * length
    hook = scene.add(lf.Disc(0.01 * length, mass=mass), "hook", position=(length, height), velocity=(speed, 0.0))
    motion = lf.Table([0.0, 100.0], [0.0, 100.0 * speed])
    scene.join(lf.DrivenDisplacement(hook.point("center"), scene.ground.at(length, height), motion, (1.0, 0.0)))
    scene.load(lf.Force(top.point("center"), (0.0, -WEIGHT * force)))
    spring = lf.Spring(top.point("center"), hook.point("center"), SPRING * mass, length=length)
    scene.load(spring)
    return scene, top.name


def period(result: lf.Result, body: str) -> float:
    """Mean time between largest stretches of the spring, from the second of them on."""
    stretch = result.point("hook", "center")[:, 0] - result.point(body, "center")[:, 0]
    high = stretch > 0.5 * (stretch.max() + stretch.min())
    rising = np.flatnonzero(high[1:] & ~high[:-1])[1:]
    return float(np.diff(result.times[rising]).mean())


def classical(mu_drop: float = DROP) -> float:
    """Period of a block that sticks at the static and slides at the kinetic friction: Coulomb's two levels."""
    omega = math.sqrt(SPRING / MASS)
    return 2.0 * mu_drop / (SPRING * PULL) + 2.0 / omega * (math.pi - math.atan(mu_drop * omega / (SPRING * PULL)))


SHARP = BengisuAkay(slip_speed=5e-5, decay=1e5, static_friction=STATIC)


@pytest.mark.parametrize("step", [2e-4, 1e-4, pytest.param(2e-5, marks=pytest.mark.slow)])
@pytest.mark.parametrize(
    "given", [{}, {"joints": True}, {"contacts": 2}, {"contacts": 3, "joints": True}, {"length": 1e3, "mass": 1e-3}],
    ids=["one body", "welded", "two contacts", "three, welded", "millimetres and tonnes"],
)  # fmt: skip
def test_stick_slip_has_the_period_of_the_two_levels(given: dict[str, Any], step: float) -> None:
    """A fall of friction far steeper than a step resolves: h |dF/dv| / m is between 32 and 320."""
    units = given.get("length", 1.0)
    law = BengisuAkay(SHARP.slip_speed * units, SHARP.decay / units, STATIC)
    scene, body = pulled(law, **given)
    result = lf.simulate(scene, 0.8, lf.MoreauJean(step), record=4e-4)
    assert period(result, body) == pytest.approx(classical(), rel=0.01)
    assert not [text for text in result.warnings if "friction" in text]


@pytest.mark.parametrize("joints", [False, pytest.param(True, marks=pytest.mark.slow)], ids=["one body", "welded"])
def test_a_smooth_fall_converges_to_event_driven(joints: bool) -> None:
    law = BrownMcPhee(1e-3, static_friction=STATIC)
    scene, body = pulled(law, joints)
    exact = period(lf.simulate(scene, 0.5, lf.EventDriven(), record=2e-4), body)
    for step, within in ((4e-4, 0.04), (1e-4, 0.02), (2e-5, 0.01)):
        result = lf.simulate(scene, 0.5, lf.MoreauJean(step), record=2e-4)
        assert period(result, body) == pytest.approx(exact, rel=within)


def test_adaptive_steps_keep_the_branch() -> None:
    scene, body = pulled(SHARP, joints=True)
    result = lf.simulate(scene, 0.8, lf.MoreauJean(1e-5, adaptive=lf.AdaptiveStep(rtol=1e-3, atol=1e-5)), record=4e-4)
    assert period(result, body) == pytest.approx(classical(), rel=0.03)
