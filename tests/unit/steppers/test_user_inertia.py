"""A user's mass that depends on the configuration, without a potential: what its changes do is part of the balance."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import lcpflex as lf

EXACT = (
    lf.MoreauJean(step=1e-3),
    lf.MoreauJean(step=1e-2, theta=0.8),
    lf.MoreauJean(step=2e-3, adaptive=lf.AdaptiveStep(rtol=1e-2, atol=1e-4)),
)
VERLET = lf.Smooth(integrator=lf.Verlet(1e-3))
CONTROLLED = (
    (lf.EventDriven(), 1e-6),
    (lf.GeneralizedAlpha(step=1e-3), 1e-4),
    (lf.Smooth(), 1e-6),
    (lf.Smooth(integrator=lf.Stiff()), 1e-4),
)
LENGTH, WEIGHT = 0.5, 9.81


def cart_and_pendulum(scale: float = 1.0, **more: Any) -> lf.UserSystem:
    """A cart on rails with a pendulum of the same mass [kg], all lengths times ``scale``."""
    length, weight = scale * LENGTH, scale * WEIGHT

    def mass(q: Any) -> Any:
        return np.array([[2.0, length * math.cos(q[1])], [length * math.cos(q[1]), length**2]])

    def force(t: float, q: Any, u: Any) -> Any:
        return np.array([length * math.sin(q[1]) * u[1] ** 2, -weight * length * math.sin(q[1])])

    return lf.UserSystem(q=[0.0, 1.5], u=[0.3 * scale, 0.0], mass=mass, force=force, **more)


def polar(**more: Any) -> lf.UserSystem:
    """A mass on a spring to the origin in polar coordinates."""

    def force(t: float, q: Any, u: Any) -> Any:
        return np.array([2.0 * q[0] * u[1] ** 2 - 30.0 * (q[0] - 0.8), -4.0 * q[0] * u[0] * u[1]])

    return lf.UserSystem(
        q=[1.0, 0.0], u=[0.5, 3.0], mass=lambda q: np.diag([2.0, 2.0 * q[0] ** 2]), force=force, **more
    )


def struck() -> lf.UserSystem:
    """The pendulum of the cart against a wall that goes with the cart."""
    return cart_and_pendulum(
        gaps=lambda q: np.array([0.3 + LENGTH * math.sin(q[1])]),
        normals=lambda q: np.array([[0.0], [LENGTH * math.cos(q[1])]]),
        restitution=0.6,
    )


def held() -> lf.UserSystem:
    """The cart at a wall: with a joint, which does no work."""
    rows = {"constraints": lambda t, q: np.array([q[0] - 0.1 * q[1] ** 2 + 0.225])}
    return cart_and_pendulum(**rows, jacobian=lambda t, q: np.array([[1.0, -0.2 * q[1]]]))


def on_a_circle() -> lf.UserSystem:
    """The mass on a spring, its angle told by a point of the unit circle: three numbers, two velocities."""

    def force(t: float, q: Any, u: Any) -> Any:
        return np.array([2.0 * q[0] * u[1] ** 2 - 30.0 * (q[0] - 0.8), -4.0 * q[0] * u[0] * u[1]])

    return lf.UserSystem(
        q=[1.0, 1.0, 0.0],
        u=[0.5, 3.0],
        mass=lambda q: np.diag([2.0, 2.0 * q[0] ** 2]),
        force=force,
        kinematics=lambda q: np.array([[1.0, 0.0], [0.0, -q[2]], [0.0, q[1]]]),
        normalise=lambda q: np.concatenate([q[:1], q[1:] / math.hypot(*q[1:])]),
    )


SYSTEMS = (
    cart_and_pendulum,
    polar,
    struck,
    on_a_circle,
    lambda: cart_and_pendulum(1e3),
    lambda: cart_and_pendulum(1e-3),
)
NAMES = ("cart", "polar", "struck", "circle", "kilometres", "millimetres")


def balanced(system: lf.UserSystem, stepper: Any, bound: float) -> None:
    result = lf.simulate(system, 0.2, stepper, progress=False)
    assert np.ptp(result.energies.kinetic) > 0.05 * result.energies.kinetic.max()
    assert result.energies.relative_remainder < bound
    assert not result.found_wrong
    assert "NOT to be trusted" not in result.summary()


@pytest.mark.parametrize("stepper", EXACT, ids=["half", "theta", "adaptive"])
@pytest.mark.parametrize("build", SYSTEMS, ids=NAMES)
def test_time_stepping_balances_to_rounding(build: Any, stepper: Any) -> None:
    balanced(build(), stepper, 1e-11)


@pytest.mark.parametrize("build", [SYSTEMS[0], SYSTEMS[1], *SYSTEMS[3:]], ids=[NAMES[0], NAMES[1], *NAMES[3:]])
def test_verlet_balances_to_rounding(build: Any) -> None:
    balanced(build(), VERLET, 1e-11)


@pytest.mark.parametrize(("stepper", "bound"), CONTROLLED, ids=["events", "alpha", "explicit", "stiff"])
@pytest.mark.parametrize(
    "build",
    [
        pytest.param(cart_and_pendulum, id="cart", marks=pytest.mark.slow),
        pytest.param(polar, id="polar", marks=pytest.mark.slow),
        pytest.param(on_a_circle, id="circle"),
    ],
)
def test_others_balance_to_their_error(build: Any, stepper: Any, bound: float) -> None:
    balanced(build(), stepper, bound)


@pytest.mark.parametrize(
    "stepper",
    [
        pytest.param(EXACT[0], id="moreau"),
        pytest.param(CONTROLLED[0][0], id="events", marks=pytest.mark.slow),
        pytest.param(CONTROLLED[1][0], id="alpha", marks=pytest.mark.slow),
    ],
)
def test_impacts_and_joints_are_told_apart_from_it(stepper: Any) -> None:
    """The wall takes what a wall takes; a joint at rest does no work."""
    bounced = lf.simulate(struck(), 0.5, stepper, progress=False)
    assert bounced.energies.impact[-1] > 0.05 * bounced.energies.kinetic.max()
    for result in (bounced, lf.simulate(held(), 0.5, stepper, progress=False, project=True)):
        assert result.energies.relative_remainder < 1e-2
        assert "NOT to be trusted" not in result.summary()


def test_a_force_that_lacks_its_centrifugal_part_is_no_balance_of_motion_but_of_work() -> None:
    """The balance books what is given; a known potential is what finds a force that does not fit to the masses."""

    def wrong(t: float, q: Any, u: Any) -> Any:
        return np.array([-30.0 * (q[0] - 0.8), 0.0])

    energy = {"potential": lambda q: 15.0 * (q[0] - 0.8) ** 2}
    system = lf.UserSystem([1.0, 0.0], [0.5, 3.0], lambda q: np.diag([2.0, 2.0 * q[0] ** 2]), wrong, **energy)
    assert "NOT to be trusted" in lf.simulate(system, 0.5, EXACT[0], progress=False).summary()


@pytest.mark.parametrize("stepper", [EXACT[0], CONTROLLED[0][0], CONTROLLED[1][0], VERLET])
def test_motions_are_those_of_a_system_with_a_potential(stepper: Any) -> None:
    """The balance is no part of the motion; error control looks at the work, too, and chooses other steps."""
    known = polar(potential=lambda q: 15.0 * (q[0] - 0.8) ** 2)
    one, other = (lf.simulate(system, 0.2, stepper, progress=False) for system in (polar(), known))
    assert one.q[-1] == pytest.approx(other.q[-1], rel=1e-7)
