"""Generalised-alpha and Moreau-Jean stepping in space: order 2 in smooth motion, and what free flight conserves."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.jit.kernel import FloatArray
from tests.rates import assert_rate
from tests.spatial_flight import (
    OMEGA_8,
    P_8,
    VELOCITY,
    J,
    angular_momenta,
    apart,
    dzhanibekov,
    exact_flight,
    flexible_flight,
    lengths,
)

STEPPERS: dict[str, Callable[[float], Any]] = {
    "alpha": lambda h: lf.GeneralizedAlpha(h),
    "alpha, not damped": lambda h: lf.GeneralizedAlpha(h, rho_inf=1.0),
    "corrected": lambda h: lf.MoreauJean(h),
    "solved": lambda h: lf.MoreauJean(h, gyroscopic="solved"),
}


def energies(u: FloatArray) -> FloatArray:
    """(m,) of R1, by its rotation alone [J]."""
    return np.asarray(0.5 * u[:, 3:6] ** 2 @ J)


@pytest.mark.parametrize("name", STEPPERS)
def test_a_rigid_body_turns_over_with_order_two(name: str) -> None:
    """R1: omega and p at t = 8 s, whose eight printed digits are far below these errors."""
    steps = 500 * 2 ** np.arange(4)
    errors = []
    for n in steps:
        result = lf.simulate(
            dzhanibekov(), 8.0, STEPPERS[name](8.0 / n), record=8.0, energy_growth=lf.EnergyGrowth.ACCEPT
        )
        assert result.steps == n
        assert np.abs(lengths(result) - 1.0).max() < 1e-14
        assert np.abs(result.u[-1, :3] - VELOCITY).max() == 0.0
        errors.append([np.abs(result.u[-1, 3:6] - OMEGA_8).max(), apart(result.q[-1, 3:7], P_8)])
    assert_rate(1.0 / steps, errors, 2.0, within=0.15)
    assert np.max(errors[-1]) < 2e-4


def test_inertial_forces_in_a_step() -> None:
    """Half a turn-over of R1, h = 1/250: the table in the words of ``MoreauJean``."""
    exact = exact_flight(4.0)(4.0)

    def off(stepper: Any) -> tuple[float, float]:
        result = lf.simulate(dzhanibekov(), 4.0, stepper, record=4.0)
        energy = energies(result.u)
        return abs(energy[-1] / energy[0] - 1.0), 2.0 * np.arccos(min(1.0, abs(result.q[-1, 3:7] @ exact[:4])))

    corrected, angle = off(lf.MoreauJean(1 / 250))
    assert 7e-7 < corrected < 1e-6
    assert 4e-5 < angle < 7e-5
    solved, angle = off(lf.MoreauJean(1 / 250, gyroscopic="solved"))
    assert solved < 5e-14
    assert 7e-5 < angle < 1e-4
    alpha, angle = off(lf.GeneralizedAlpha(1 / 250))
    assert alpha < 2e-7
    assert angle < 2e-4


@pytest.mark.parametrize("name", ["alpha", "corrected", "solved"])
def test_flexible_flight_with_order_two(name: str) -> None:
    """Against Runge-Kutta steps to 1e-12."""
    end = 1.0
    exact = lf.simulate(flexible_flight(), end, lf.EventDriven(rtol=1e-12, atol=1e-13), record=end)
    steps = 100 * 2 ** np.arange(4)
    errors = []
    for n in steps:
        result = lf.simulate(
            flexible_flight(), end, STEPPERS[name](end / n), record=end, energy_growth=lf.EnergyGrowth.ACCEPT
        )
        assert np.abs(lengths(result) - 1.0).max() < 1e-14
        places = np.abs(np.delete(result.q[-1] - exact.q[-1], range(3, 7))).max()
        errors.append(
            [places, apart(result.q[-1, 3:7], exact.q[-1, 3:7]), np.abs(result.u[-1, 3:] - exact.u[-1, 3:]).max()]
        )
    assert_rate(1.0 / steps, errors, 2.0, within=0.15)
    assert np.max(errors[-1]) < 2e-3


@pytest.mark.parametrize("make", [lf.GeneralizedAlpha, lf.MoreauJean])
def test_error_control_in_space(make: Callable[..., Any]) -> None:
    """R1: errors fall with the tolerance, as its power 2/3 at order 2, and quaternions keep their length."""
    tolerances = 10.0 ** -np.arange(3.0, 7.0, 0.5)
    errors = []
    for rtol in tolerances:
        control = lf.AdaptiveStep(rtol=float(rtol))
        result = lf.simulate(
            dzhanibekov(), 8.0, make(1e-2, adaptive=control), record=8.0, energy_growth=lf.EnergyGrowth.ACCEPT
        )
        assert np.abs(lengths(result) - 1.0).max() < 1e-14
        errors.append(max(np.abs(result.u[-1, 3:6] - OMEGA_8).max(), apart(result.q[-1, 3:7], P_8)))
    assert_rate(tolerances, errors, 2 / 3, within=0.15)
    assert errors[-1] < 2e-3


def test_error_control_does_not_mind_by_which_numbers_a_rotation_is_told() -> None:
    """Where R1 starts from has no influence on its steps, and neither has the sign of the quaternion."""
    from scipy.spatial.transform import Rotation

    def steps(turned: Rotation | None) -> int:
        scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
        body = lf.SpatialBody(mass=1.0, inertia=np.diag(J))
        omega = np.array([0.01, 5.0, 0.01])
        scene.add(body, orientation=turned, angular_velocity=omega if turned is None else turned.apply(omega))
        control = lf.AdaptiveStep(rtol=1e-4)
        return int(lf.simulate(scene, 4.0, lf.GeneralizedAlpha(1e-2, adaptive=control)).steps)

    turns = [None, Rotation.from_rotvec([3.1, 0.0, 0.3]), Rotation.from_rotvec([0.0, -2.0, 1.0])]
    assert len({steps(turned) for turned in turns}) == 1


@pytest.mark.slow
@pytest.mark.parametrize("name", STEPPERS)
def test_a_long_free_flight(name: str) -> None:
    """R1 for 400 s, forty turn-overs, in 1e5 steps: energy and both momenta to the order.

    Energy and momentum do not drift but where inertial forces are corrected once: then by h^3 in a given time.
    """
    kept = []
    for n in (50_000, 100_000):
        result = lf.simulate(dzhanibekov(), 400.0, STEPPERS[name](400.0 / n), record=0.4)
        change, momentum = np.abs(energies(result.u) / energies(result.u[:1]) - 1.0), angular_momenta(result)
        assert np.abs(lengths(result) - 1.0).max() < 1e-14
        assert np.abs(result.u[:, :3] - VELOCITY).max() == 0.0
        straight = result.q[:, :3] - np.outer(result.times, VELOCITY)
        assert np.abs(straight).max() < 1e-8  # rounding of 1e5 sums, of 1200 m
        kept.append([change.max(), np.abs(momentum - momentum[0]).max() / 10.0])
        halves = np.array_split(change, 2)
        assert (halves[1].max() > 1.1 * halves[0].max() + 1e-11) == (name == "corrected")
    energy, turning = np.transpose(kept)
    assert np.max(kept[1]) < 1e-4
    expected = (2.5, 0.7) if name == "corrected" else (2.0, 0.2)
    assert_rate([2.0, 1.0], turning, *expected)
    if name == "solved":
        assert energy.max() < 1e-11
    else:
        assert_rate([2.0, 1.0], energy, *expected)


def test_a_body_that_turns_far_in_a_step_converges() -> None:
    """Inertial forces are no part of the iteration matrix: by .5 rad a step its passes alone take more than 15."""
    scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
    scene.add(lf.SpatialBody(mass=1.0, inertia=np.diag(J)), angular_velocity=(10.0, 100.0, 5.0))
    result = lf.simulate(scene, 0.1, lf.GeneralizedAlpha(5e-3), energy_growth=lf.EnergyGrowth.ACCEPT)
    assert not any("did not converge" in warning for warning in result.warnings)


def test_inertial_forces_that_are_not_solved_are_told() -> None:
    """A body that turns by 2.5 rad in a step."""
    scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
    body = lf.SpatialBody(mass=1.0, inertia=np.diag(J))
    scene.add(body, angular_velocity=(50.0, 160.0, 50.0))
    stepper = lf.MoreauJean(1.4e-2, gyroscopic="solved")
    result = lf.simulate(scene, 0.3, stepper, energy_growth=lf.EnergyGrowth.ACCEPT)
    assert any('gyroscopic="solved": the inertial forces of' in warning for warning in result.warnings)
    assert not lf.simulate(scene, 0.3, lf.MoreauJean(1e-3, gyroscopic="solved")).warnings


@pytest.mark.parametrize("wrong", ["explicit", 1, None, True])
def test_another_choice_for_inertial_forces_is_refused(wrong: Any) -> None:
    with pytest.raises(lf.ModelError, match=r'gyroscopic: .* was given, expected "corrected" or "solved"'):
        lf.MoreauJean(1e-3, gyroscopic=wrong)


def pressed_on_a_node(friction: float, speed: float) -> lf.SpatialScene:
    """A block that turns and is pressed on one of its nodes, which stays closed."""
    solid = lf.Solid.box(
        (0.06, 0.04, 0.03), elements=(2, 2, 1), density=7850.0, youngs_modulus=2.1e9, poissons_ratio=0.3
    )
    places = solid.finite_elements().places
    node = int(np.argmin(np.linalg.norm(places - [0.0, 0.0, -0.015], axis=1)))
    scene = lf.SpatialScene(gravity=(300.0, 0.0, -2e3))
    spin = (3.0, 5.0, 40.0) if friction < 1.0 else (0.0, 0.0, 0.0)
    body = scene.add(solid.reduce(6, contact=[node]), position=(0.0, 0.0, 0.015), velocity=(speed, 0.0, 0.0),
                     angular_velocity=spin)  # fmt: skip
    floor = scene.ground.plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    scene.contact(body.node((0.0, 0.0, -0.015)), floor, friction=friction, name="floor")
    return scene


@pytest.mark.filterwarnings("ignore:mesh. its stiffness:lcpflex.ModelWarning")
@pytest.mark.parametrize(
    ("friction", "speed", "order", "within"),
    [(0.0, 0.0, 2.0, 0.1), (3.0, 0.0, 2.0, (0.4, 0.1)), (0.1, 0.5, 1.0, 0.15)],
    ids=["without friction", "sticks", "slides in a curve"],
)
def test_order_of_the_massless_boundary(
    friction: float, speed: float, order: float, within: float | tuple[float, float]
) -> None:
    """2 while a contact stays as it is; friction is that of the slip over the step, of order 1 where that turns.

    What sticks has a little of that: the static deflection turns with its body.
    """
    steps = (4e-6, 2e-6, 1e-6, 5e-7)
    ends = []
    for step in steps:
        stepper = lf.MasslessBoundary(step=step, safety=1.0, solver_tolerance=1e-12)
        result = lf.simulate(pressed_on_a_node(friction, speed), 4e-4, stepper, record=4e-4)
        ends.append(np.concatenate([result.q[-1], 1e-4 * result.u[-1]]))
    errors = [float(np.linalg.norm(a - b)) for a, b in pairwise(ends)]
    assert_rate(steps[:-1], errors, order, within)


def test_massless_boundary_has_order_two_in_free_flight() -> None:
    steps = (4e-3, 2e-3, 1e-3)
    ends = [lf.simulate(dzhanibekov(), 2.0, lf.MasslessBoundary(step=h), record=2.0).u[-1] for h in (*steps, 1e-4)]
    errors = [float(np.linalg.norm(end - ends[-1])) for end in ends[:-1]]
    assert_rate(steps, errors, 2.0, 0.2)
