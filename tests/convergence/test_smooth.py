"""Rates of continuous contact forces: of the steps in smooth motion, of the tolerance, and of the stiffness."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
import pytest

import lcpflex as lf
from lcpflex.force_laws.penalty import Penalty
from lcpflex.steppers.smooth.stepper import ExplicitRungeKutta, Smooth, Stiff, Verlet
from tests.rates import assert_rate
from tests.scenes import box_on_floor, disc_on_floor, floor_of

Vector = npt.NDArray[np.float64]


def rolling_disc() -> lf.Scene:
    """A disc meets a rough floor obliquely; a heavy rod hinged to it swings."""
    scene = lf.Scene(gravity=(0.0, -9.81))
    disc = scene.add(lf.Disc(radius=0.5, mass=1.0), name="disc", position=(0.0, 0.5), velocity=(1.0, -1.0))
    rod = scene.add(
        lf.RigidBody(mass=0.5, inertia=0.05, points={"top": (0.0, 0.4)}),
        name="rod",
        position=(0.0, 0.1),
        velocity=(1.0, -1.0),
    )
    scene.join(lf.Revolute(rod.point("top"), disc.point("center")))
    floor = floor_of(scene)
    scene.contact(disc.surface(), floor, friction=0.3, name="floor")
    return scene


# The cube is smooth at the moment of touching, too; with less stiffness 200 steps would leave rounding only.
SMOOTH_LAW = Penalty(2e5, exponent=3.0, damping=0.1, slip_speed=0.3)
IN_CONTACT = 0.1


def final_state(stepper: Smooth) -> tuple[Vector, lf.Result]:
    result = lf.simulate(rolling_disc(), IN_CONTACT, stepper, record=0.5 * IN_CONTACT)
    assert result.force[1, 0, 0] > 0.0
    assert result.force[2, 0, 0] > 0.0  # all the time
    return np.concatenate([result.q[-1], result.u[-1]]), result


def test_order_of_runge_kutta_in_contact() -> None:
    """Order 5 with friction, damping and a joint, at steps that error control does not change."""

    def end(steps: int) -> tuple[Vector, float]:
        h = IN_CONTACT / steps
        fixed = ExplicitRungeKutta(rtol=1e9, atol=1e9, first_step=h, max_step=h)
        state, result = final_state(Smooth(SMOOTH_LAW, integrator=fixed))
        assert result.steps == steps
        return state, result.energies.largest_remainder

    exact, _ = end(1600)
    counts = np.array([25, 50, 100, 200])
    ends = [end(int(n)) for n in counts]
    assert_rate(1.0 / counts, [np.abs(state - exact).max() for state, _ in ends], 5.0, within=(0.3, 0.6))
    assert_rate(1.0 / counts, [remainder for _, remainder in ends], 5.0, within=(0.3, 1.7))


def test_order_of_verlet_in_contact() -> None:
    """Order 2 without forces that depend on velocities, 1 with them."""

    def assert_order(order: float, law: Penalty, friction: float) -> None:
        def end(steps: int) -> Vector:
            scene = disc_on_floor(0.5, (1.0, -1.0), radius=0.5, friction=friction)
            result = lf.simulate(scene, IN_CONTACT, Smooth(law, integrator=Verlet(IN_CONTACT / steps)))
            assert result.steps == steps
            return np.concatenate([result.q[-1], result.u[-1]])

        exact = end(200_000)
        counts = np.array([100, 200, 400, 800])
        assert_rate(1.0 / counts, [np.abs(end(int(n)) - exact).max() for n in counts], order, within=0.05)

    assert_order(2.0, Penalty(2e4, exponent=3.0), 0.0)
    assert_order(1.0, Penalty(2e4, exponent=3.0, damping=0.1, slip_speed=0.5), 0.3)


@pytest.mark.slow
@pytest.mark.parametrize("implicit", [False, True], ids=["explicit", "stiff"])
def test_error_and_remainder_follow_the_tolerance(implicit: bool) -> None:
    """Impact on a linear spring, kinks included: each decade of tolerance brings at least two thirds of one.

    Where a step falls upon a kink is chance, so that errors scatter: the rate is that of many tolerances.
    """

    def run(rtol: float) -> tuple[Vector, float]:
        integrator = Stiff(rtol, 1e-2 * rtol) if implicit else ExplicitRungeKutta(rtol, 1e-2 * rtol)
        scene = disc_on_floor(0.15, (1.0, -1.0), friction=0.2)
        stepper = Smooth(Penalty(1e5, damping=0.2, slip_speed=0.1), integrator=integrator)
        result = lf.simulate(scene, 0.2, stepper, record=0.02)
        return np.concatenate([result.q[-1], result.u[-1]]), result.energies.relative_remainder

    exact, _ = run(1e-12)
    tolerances = tuple(np.geomspace(1e-5, 1e-10, 16))
    runs = [run(rtol) for rtol in tolerances]
    assert_rate(tolerances, [np.abs(state - exact).max() for state, _ in runs], 1.0, within=0.34)
    assert_rate(tolerances, [remainder for _, remainder in runs], 1.0, within=0.34)
    assert runs[-1][1] < 1e-6


@pytest.mark.parametrize(("exponent", "expected"), [(1.0, 0.5), (1.5, 0.4)], ids=["linear", "hertz"])
def test_bounce_approaches_rigid_impact(exponent: float, expected: float) -> None:
    """A ball dropped from 1 m against the complementarity solution with e = 1.

    It is late by the duration of contact, which goes with K^(-1/(n+1)).
    """
    scene = disc_on_floor(1.1, restitution=1.0)
    rigid = lf.simulate(scene, 0.7, lf.EventDriven(), record=0.7)
    landing = math.sqrt(2.0 / 9.81)
    assert rigid.u[-1, 1] == pytest.approx(9.81 * (2.0 * landing - 0.7), rel=1e-7)
    stiffnesses = (1e6, 1e7, 1e8, 1e9, 1e10)
    errors = []
    for stiffness in stiffnesses:
        soft = lf.simulate(scene, 0.7, Smooth(Penalty(stiffness, exponent)), record=0.7)
        errors.append(abs(float(soft.q[-1, 1] - rigid.q[-1, 1])))
    assert_rate(stiffnesses, errors, -expected, within=0.02)
    assert errors[-1] < 1e-3


def test_sliding_approaches_coulomb_friction() -> None:
    """A block brakes on a rough floor: its path against that of complementarity.

    With dv/dt = -mu g tanh(v/v_s) the way to rest is longer by the integral of v (coth(v/v_s) - 1) dv / (mu g):
    by pi^2 v_s^2 / (12 mu g). The stiffness is so large that the start, when the block sinks in, plays no part.
    """

    rigid = lf.simulate(box_on_floor((1.0, 0.0), friction=0.4), 0.4, lf.EventDriven(), record=0.4)
    assert rigid.q[-1, 0] == pytest.approx(1.0 / (2.0 * 0.4 * 9.81), rel=1e-6)
    speeds = (4e-2, 2e-2, 1e-2, 5e-3)
    errors = []
    for slip_speed in speeds:
        law = Penalty(1e8, damping=1000.0, slip_speed=slip_speed)
        soft = lf.simulate(box_on_floor((1.0, 0.0), friction=0.4), 0.4, Smooth(law), record=0.4)
        errors.append(float(soft.q[-1, 0] - rigid.q[-1, 0]))
        assert errors[-1] == pytest.approx(math.pi**2 * slip_speed**2 / (12.0 * 0.4 * 9.81), rel=0.01)
    assert_rate(speeds, errors, 2.0, within=0.02)
