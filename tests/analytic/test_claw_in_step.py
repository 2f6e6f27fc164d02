"""The claw of Silva et al.: its equations, and what its text says of its charts."""

from __future__ import annotations

import numpy as np
import pytest

import lcpflex as lf
from lcpflex import gallery
from tests.examples import Example

CLAW = Example("claw_in_step")
STIFFNESSES = (10.0, 50.0, 200.0)  # its own, which collecting the tests does not load
EXACT = lf.EventDriven(rtol=1e-10, atol=1e-13)


def first_touch() -> tuple[float, float, float, float]:
    """L cos phi there, the work up to it, and the angular velocity before and after.

    Energy of the free finger, J omega^2 / 2 = T phi - m g (L/2) (1 - cos phi); momentum about the hinge, e = 0.
    """
    arm = np.sqrt(1.0 - CLAW.GAP**2)
    work = CLAW.TORQUE * np.arcsin(CLAW.GAP) - 0.5 * CLAW.MASS * CLAW.GRAVITY * (1.0 - arm)
    before = np.sqrt(2.0 * work / CLAW.INERTIA)
    return arm, work, before, CLAW.INERTIA * before / (CLAW.INERTIA + CLAW.WALL * arm**2)


def run(stiffness: float, end: float = 1.5, mass: float = 1.0) -> lf.Result:
    return lf.simulate(gallery.claw_in_step(stiffness, mass), end, EXACT, record=1e-3)


@pytest.fixture(scope="module", params=STIFFNESSES)
def case(request) -> tuple[float, lf.Result]:
    return request.param, run(request.param)


def test_its_springs_are_those_of_the_example() -> None:
    assert STIFFNESSES == CLAW.STIFFNESSES


def test_impact_in_closed_form(case) -> None:
    """Work of the torque and the weight up to the touch; momentum about the hinge across it, e = 0."""
    arm, work, before, after = first_touch()
    _, result = case
    touch = result.contact("left").events[0]
    assert touch.kind == "impact"
    _, omega = CLAW.finger(result)
    i = int(np.flatnonzero(result.times == touch.time)[0])
    assert omega[i : i + 2] == pytest.approx([before, after], rel=1e-8)
    assert CLAW.wall_velocity(result)[i : i + 2] == pytest.approx([0.0, arm * after], rel=1e-8, abs=1e-12)
    kept = 0.5 * (CLAW.INERTIA + CLAW.WALL * arm**2) * after**2
    assert touch.energy_change == pytest.approx(kept - work, rel=1e-8)


def test_printed_velocity_after_the_impact_makes_energy() -> None:
    """Equation (14) as printed, J cos^2 and m_w L^2 cos: what the example says of it."""
    arm, work, before, _ = first_touch()
    inertia = CLAW.MASS / 12.0 + 0.25 * CLAW.MASS * arm**2
    after = (inertia * before + CLAW.WALL * arm) / (inertia + CLAW.WALL * arm**2)
    energy = 0.5 * CLAW.INERTIA * after**2 + 0.5 * CLAW.WALL * (arm * after) ** 2
    assert (work, energy) == pytest.approx((0.2231, 0.72), rel=0.01)


def test_force_is_the_multiplier(case) -> None:
    """Equation (9) with its units put right, at every instant of contact; never while there is a gap (figure 5)."""
    stiffness, result = case
    contact = result.contact("left")
    force = contact.force[:, 0]
    closed = force > 0.0
    state = np.transpose(CLAW.finger(result))[closed]
    expected = [CLAW.multiplier(phi, omega, stiffness) for phi, omega in state]
    assert force[closed] == pytest.approx(expected, rel=1e-8)
    gap = contact.gap[~closed]
    assert gap[0] == pytest.approx(CLAW.GAP, rel=1e-12)
    assert np.all(np.diff(gap) < 0.0)
    assert np.abs(contact.gap[closed]).max() < 1e-10
    assert len(contact.windows()) == 1


def test_fingers_move_in_step(case) -> None:
    """Figure 2: the second one is displaced in the same way."""
    _, result = case
    for mine, other in zip(CLAW.finger(result), CLAW.finger(result, "right"), strict=True):
        assert np.abs(mine - other).max() < 1e-12


def test_velocities_are_greatest_in_the_start(case) -> None:
    """Figure 3 and 4: of the finger up to the touch, of the wall when it is struck."""
    _, result = case
    touch = result.contact("left").events[0].time
    _, omega = CLAW.finger(result)
    wall = CLAW.wall_velocity(result)
    assert touch == pytest.approx(0.307, abs=1e-3)
    assert result.times[omega.argmax()] == touch
    assert np.abs(omega[result.times > touch + 1e-9]).max() < 0.3 * omega.max()
    assert np.abs(wall[result.times < touch]).max() < 1e-12
    assert result.times[wall.argmax()] == touch


def test_the_velocity_of_the_wall_depends_on_what_is_not_printed() -> None:
    """With a light finger the wall is fastest after the impact; a heavy one is not held up by the torque."""
    light = run(10.0, 0.6, mass=0.3)
    touch = light.contact("left").events[0].time
    fastest = light.times[CLAW.wall_velocity(light).argmax()]
    assert fastest - touch == pytest.approx(0.071, abs=2e-3)
    heavy = run(10.0, 3.0, mass=2.0).contact("left")
    assert [event.kind for event in heavy.events] == ["impact", "touch-down", "lift-off", "impact"]


def test_the_method_of_the_paper(case) -> None:
    """Runge-Kutta of order 4 with 0.1 ms: its touch is late by less than a step."""
    stiffness, result = case
    paper = CLAW.runge_kutta(stiffness, 0.6).T
    phi, omega = CLAW.finger(result)
    assert np.abs(np.interp(paper[0], result.times, phi) - paper[1]).max() < 3e-5
    after = paper[0] > result.contact("left").events[0].time + 1e-4
    assert np.abs(np.interp(paper[0], result.times, omega) - paper[2])[after].max() < 3e-4


def test_rest() -> None:
    """T = m g (L/2) sin phi + F L cos phi, F = k (L sin phi - gap)."""
    rest = lf.equilibrium(gallery.claw_in_step())
    for contact in rest.contacts:
        s = CLAW.GAP + contact.normal[0] / 10.0
        needed = 0.5 * CLAW.GRAVITY * CLAW.MASS * s + contact.normal[0] * np.sqrt(1.0 - s * s)
        assert needed == pytest.approx(CLAW.TORQUE, rel=1e-8)
        assert contact.normal[0] > 0.4


@pytest.mark.parametrize("gap", [-0.1, 1.1])
def test_a_gap_that_is_none(gap: float) -> None:
    """A tip behind the face of its wall would not be seen there."""
    with pytest.raises(lf.ModelError, match=f"gap: {gap} was given"):
        gallery.claw_in_step(gap=gap)


def test_a_finger_never_passes_its_wall() -> None:
    """Whatever it does above: the gap of the equations stays >= 0."""
    result = lf.simulate(gallery.claw_in_step(5.0, mass=0.1, gap=0.9), 3.0, EXACT, record=1e-2)
    wall = result.point("left wall", "center")[:, 0]
    gap = 0.9 + (wall - wall[0]) - np.sin(CLAW.finger(result)[0])
    assert CLAW.finger(result)[0].max() > 1.5
    assert gap.min() > -1e-9
