"""Generalised-alpha stepping: drift, damping of high modes, contact laws, its drivers, and what it refuses."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import pytest

import lcpflex as lf
from lcpflex import gallery
from lcpflex.gallery.mechanisms.bars import courant_step, elastic_bar
from lcpflex.gallery.mechanisms.rigid import block_on_incline, stack
from lcpflex.gallery.mechanisms.user_systems import impacting_bar, slider_crank, woodpecker
from lcpflex.scene.user_system import UserSystem
from lcpflex.solvers.problem import Lcp, Solution, Status
from lcpflex.steppers.generalized_alpha.stepper import GeneralizedAlpha
from tests.rates import growth
from tests.scenes import floor_of, pendulum_into_stop

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class InPython:
    """Lemke behind a Python call: makes the stepper take its interpreted driver."""

    solver: lf.Lemke

    def solve(self, problem: Lcp, guess: Solution | None = None) -> Solution:
        return self.solver.solve(problem, guess)


# smooth motion


def four_bar() -> lf.Scene:
    """A flexible four-bar linkage, its crank driven: redundant in no row, stiff in its modes."""
    scene = lf.Scene()
    crank = scene.add(lf.Box(0.2, 0.02, mass=0.2), name="crank", position=(0.1, 0.0), angular_velocity=8.0)
    beam = lf.Beam(0.6, 0.03, 0.006, density=2700.0, youngs_modulus=7e10).reduce(modes=4)
    coupler = scene.add(beam, name="coupler", position=(0.2, 0.0))
    rocker = scene.add(lf.Box(0.4, 0.02, mass=0.4), name="rocker", position=(0.8, -0.2), angle=-0.5 * math.pi)
    scene.join(lf.Revolute(crank.at(-0.1, 0.0), scene.ground.at(0.0, 0.0)))
    scene.join(lf.Revolute(crank.at(0.1, 0.0), coupler.point("left")))
    scene.join(lf.Revolute(rocker.at(-0.2, 0.0), coupler.point("right")))
    scene.join(lf.Revolute(rocker.at(0.2, 0.0), scene.ground.at(0.8, -0.4)))
    return scene


def joint_errors(result: lf.Result) -> tuple[float, float]:
    """Largest violation of positions and velocities of the joints over a run."""
    from lcpflex.dynamics.start import violation

    model = result.compiled.model
    states = [violation(model, q, u, np.zeros((0, 3))) for q, u in zip(result.q, result.u, strict=True)]
    return max(np.abs(s.position).max() for s in states), max(np.abs(s.velocity).max() for s in states)


def test_joints_do_not_drift_in_position_nor_velocity() -> None:
    result = lf.simulate(four_bar(), 5.0, GeneralizedAlpha(1e-3), project=True, record=0.02)
    assert result.steps == 5000
    assert np.ptp(result.q[:, 2]) > 0.5
    position, velocity = joint_errors(result)
    assert position < 1e-12
    assert velocity < 1e-11
    assert result.joint_drift.max() < 1e-12


def oscillator(omega: float) -> UserSystem:
    return UserSystem(q=[1.0], u=[0.3], mass=[[2.0]], force=lambda t, q, u: np.zeros(1), stiffness=[[2.0 * omega**2]])


def amplification(rho: float, x: float) -> Array:
    """Of (d, h v, h^2 a) by Chung & Hulbert's generalised-alpha method for d'' = -omega^2 d, x = omega h."""
    am, af = (2.0 * rho - 1.0) / (rho + 1.0), rho / (rho + 1.0)
    gamma = 0.5 - am + af
    beta = 0.25 * (1.0 - am + af) ** 2
    left = np.array([[1.0, 0.0, -beta], [0.0, 1.0, -gamma], [(1.0 - af) * x**2, 0.0, 1.0 - am]])
    right = np.array([[1.0, 1.0, 0.5 - beta], [0.0, 1.0, 1.0 - gamma], [-af * x**2, 0.0, -am]])
    return np.linalg.solve(left, right)


@pytest.mark.parametrize("rho", [0.0, 0.5, 0.8, 1.0])
@pytest.mark.parametrize("x", [0.1, 1.0, 30.0])
def test_an_oscillator_follows_the_amplification_matrix(rho: float, x: float) -> None:
    """By Cayley and Hamilton the displacements satisfy the recurrence of its characteristic polynomial."""
    step = 0.01
    result = lf.simulate(oscillator(x / step), 40 * step, GeneralizedAlpha(step, rho))
    d = result.q[:, 0]
    c = np.poly(amplification(rho, x))
    residual = d[3:] * c[0] + d[2:-1] * c[1] + d[1:-2] * c[2] + d[:-3] * c[3]
    assert np.abs(residual).max() < 1e-11 * np.abs(d).max()
    assert np.abs(d).max() > 0.5


@pytest.mark.parametrize("rho", [0.2, 0.5, 0.9])
def test_modes_far_above_the_step_shrink_by_rho(rho: float) -> None:
    """All three roots go to rho: the state shrinks by rho^n times a polynomial of degree 2 in n."""
    result = lf.simulate(oscillator(1e6), 0.6, GeneralizedAlpha(0.01, rho))
    n = np.arange(30, 61)
    size = np.abs(result.q[n, 0]) / n**2
    assert math.exp(growth(n, size)) == pytest.approx(rho, rel=0.05)
    assert abs(np.abs(np.linalg.eigvals(amplification(rho, 1e5))).max() - rho) < 1e-2


def swinging_beam() -> lf.Scene:
    """A free beam swings in its modes, so slightly that they do not feel its turning."""
    body = lf.Beam(1.0, 0.05, 0.02, density=1000.0, youngs_modulus=1e8).reduce(modes=6)
    scene = lf.Scene(gravity=(0.0, 0.0))
    scene.add(body, velocity=(0.4, -0.1), modal_velocity=np.full(6, 1e-5))
    return scene


def test_rho_one_conserves_the_energy_of_linear_elasticity() -> None:
    result = lf.simulate(swinging_beam(), 2.0, GeneralizedAlpha(5e-4, 1.0))
    vibration = result.energies.stored - result.energies.stored[0]
    modal = 0.5 * 6 * 1e-5**2
    assert result.energies.elastic.max() > 0.5 * modal
    assert np.abs(vibration).max() < 1e-4 * modal


def test_every_mode_of_a_body_shrinks_as_theory_says() -> None:
    """omega h from 0.08 to 1.5: logarithmic decrement against the spectral radius of the amplification matrix."""
    step, rho = 2e-3, 0.5
    scene = swinging_beam()
    omega = np.sqrt(scene.compiled().model.bodies.stiffness)
    result = lf.simulate(scene, 300 * step, GeneralizedAlpha(step, rho))
    size = np.sqrt(result.u[:, 3:] ** 2 + (omega * result.q[:, 3:]) ** 2)
    for k, x in enumerate(omega * step):
        n = np.arange(20, 301)
        n = n[size[n, k] > 1e-8 * size[0, k]]
        measured = -growth(n, size[n, k])
        theory = -math.log(np.abs(np.linalg.eigvals(amplification(rho, x))).max())
        assert measured == pytest.approx(theory, rel=0.02, abs=2e-6)


@pytest.mark.parametrize("rho_inf", [1.0, 0.5])
def test_the_audit_names_what_numerical_damping_takes(rho_inf: float) -> None:
    """A stiff body falls on a wall: its ringing is damped by nothing but the scheme, and nothing stays unexplained."""
    result = lf.simulate(elastic_bar(elements=50), 1.5, GeneralizedAlpha(courant_step(0.2, 30.0), rho_inf))
    damping, lost = result.energies.damping[-1], result.energies.stored[0] - result.energies.stored[-1]
    assert lost == pytest.approx(damping + result.energies.impact[-1], abs=1e-9)
    assert damping > 5.0 if rho_inf < 1.0 else abs(damping) < 1e-9
    assert result.energies.relative_remainder < 1e-12


# contact


@pytest.mark.parametrize("rho_inf", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("adaptive", [None, lf.AdaptiveStep(rtol=1e-4, atol=1e-6)])
def test_impulses_are_the_change_of_momentum(rho_inf: float, adaptive: lf.AdaptiveStep | None) -> None:
    """A mass bounces on a spring on a block, which rests, sheds the floor and slides on."""
    scene = lf.Scene()
    block = scene.add(lf.Box(width=0.4, height=0.2, mass=1.0), position=(0.0, 0.1), velocity=(1.0, 0.0))
    mass = scene.add(lf.Disc(radius=0.05, mass=5.0), position=(0.0, 0.6), velocity=(1.0, -0.5))
    scene.join(lf.PointOnLine(mass.point("center"), block.point("center"), axis=(0.0, 1.0)))
    scene.load(lf.Spring(mass.point("center"), block.point("center"), stiffness=2e4, length=0.5))
    scene.contact(block.surface(), floor_of(scene), friction=0.3, name="floor")
    result = lf.simulate(scene, 0.5003, GeneralizedAlpha(step=1e-3, rho_inf=rho_inf, adaptive=adaptive))
    momentum = result.u[:, [0, 1]] + 5.0 * result.u[:, [3, 4]]
    given = result.impulse[:, 0, ::-1] - np.outer(result.times, (0.0, 6.0 * 9.81))
    np.testing.assert_allclose(momentum - momentum[0], given, rtol=0, atol=1e-11)
    assert result.impulse[-1, 0, 0] > 20.0


def test_a_bouncing_ball_keeps_newtons_restitution() -> None:
    scene = lf.Scene(gravity=(0.0, 0.0))
    ball = scene.add(lf.Disc(radius=0.1, mass=1.0), position=(0.0, 0.15), velocity=(0.3, -2.0))
    scene.contact(ball.surface(), floor_of(scene), restitution=0.6)
    result = lf.simulate(scene, 0.1, GeneralizedAlpha(1e-3))
    np.testing.assert_allclose(result.u[-1], (0.3, 1.2, 0.0), rtol=0, atol=1e-14)
    np.testing.assert_allclose(result.impulse[-1, 0], (3.2, 0.0), rtol=0, atol=1e-14)
    assert result.energies.impact[-1] == pytest.approx(0.5 * (4.0 - 1.44), abs=1e-13)
    assert result.force[:, 0, 0].max() == pytest.approx(3.2 / 1e-3)


def test_bounces_end_and_the_ball_rests() -> None:
    scene = lf.Scene()
    ball = scene.add(lf.Disc(radius=0.1, mass=2.0), position=(0.0, 0.3))
    scene.contact(ball.surface(), floor_of(scene), restitution=0.5)
    result = lf.simulate(scene, 2.0, GeneralizedAlpha(1e-3))
    assert result.penetration.max() < 1e-12
    np.testing.assert_allclose(result.force[-100:, 0, 0], 2.0 * 9.81, rtol=1e-12)
    np.testing.assert_allclose(result.u[-1], 0.0, rtol=0, atol=1e-14)
    assert result.impulse[-1, 0, 0] == pytest.approx(2.0 * 9.81 * 2.0, rel=1e-12)  # all that gravity gave
    assert result.energies.relative_remainder < 1e-12


def test_a_block_goes_up_a_slope_stops_and_slides_back() -> None:
    """mu = 0.4 < tan 30: distance from two constant accelerations."""
    result = lf.simulate(block_on_incline(), 1.5, GeneralizedAlpha(1e-3))
    slope = math.radians(30.0)
    up = 9.81 * (math.sin(slope) + 0.4 * math.cos(slope))
    down = 9.81 * (math.sin(slope) - 0.4 * math.cos(slope))
    stop = 2.0 / up
    distance = 2.0 / up - 0.5 * down * (1.5 - stop) ** 2
    moved = (result.q[-1] - result.q[0])[:2] @ (math.cos(slope), math.sin(slope))
    assert moved == pytest.approx(distance, abs=1e-3)  # order 1: the slip turns about within a step
    np.testing.assert_allclose(result.force[-1].sum(axis=0)[0], 9.81 * math.cos(slope), rtol=1e-10)
    assert abs(abs(result.force[-1].sum(axis=0)[1]) / result.force[-1].sum(axis=0)[0] - 0.4) < 1e-10
    assert result.energies.relative_remainder < 1e-10


def test_stick_means_stick() -> None:
    """30 degrees, mu = 0.7 > tan 30, 10 s."""
    scene = lf.Scene()
    slope = math.radians(30.0)
    block = scene.add(
        lf.Box(0.2, 0.1, mass=1.0), angle=-slope, position=(0.05 * math.sin(slope), 0.05 * math.cos(slope))
    )
    plane = scene.ground.half_plane((0.0, 0.0), (math.sin(slope), math.cos(slope)))
    scene.contact(block.surface(), plane, friction=0.7)
    result = lf.simulate(scene, 10.0, GeneralizedAlpha(1e-3))
    assert np.abs(result.q - result.q[0]).max() < 1e-12


def test_a_stack_of_more_contacts_than_the_tables_first_hold_rests() -> None:
    result = lf.simulate(stack(), 0.5, GeneralizedAlpha(1e-3))
    assert result.size.max() > 3 * 16
    assert np.abs(result.u[-1]).max() < 1e-10
    assert np.abs(result.q - result.q[0]).max() < 1e-6
    assert result.penetration.max() < 1e-12


@pytest.mark.parametrize(("rho_inf", "error"), [(1.0, 0.003), (0.8, 0.005)])
def test_an_elastic_bar_bounces_off_a_wall(rho_inf: float, error: float) -> None:
    """Wave equation: force 300 N for 2/3 s, rebound at full speed, less what damping takes out of the wave front."""
    result = lf.simulate(elastic_bar(elements=200), 1.5, GeneralizedAlpha(courant_step(0.05, 30.0), rho_inf))
    assert result.impulse[-1, 0, 0] == pytest.approx(200.0, rel=error)
    pushed = (result.times > 0.52) & (result.times < 1.15)
    assert np.mean(result.force[pushed, 0, 0]) == pytest.approx(300.0, rel=0.01)
    assert not result.force[result.times > 1.25].any()
    assert result.u[-1, 0] == pytest.approx(10.0, rel=error)
    assert result.penetration.max() < 1e-12
    assert result.energies.stored[-1] / result.energies.stored[0] == pytest.approx(1.0, abs=error)


# drivers


def test_compiled_and_interpreted_drivers_agree() -> None:
    compiled = lf.simulate(pendulum_into_stop(), 0.12, GeneralizedAlpha(1e-4))
    interpreted = lf.simulate(pendulum_into_stop(), 0.12, GeneralizedAlpha(1e-4, solver=InPython(lf.Lemke())))
    assert compiled.impulse[-1, 0, 0] > 0.01
    for name in ("q", "u", "impulse"):
        np.testing.assert_allclose(getattr(interpreted, name), getattr(compiled, name), rtol=0, atol=1e-12)
    np.testing.assert_allclose(interpreted.force, compiled.force, rtol=0, atol=1e-12 * compiled.force.max())


def test_same_input_gives_the_same_bits() -> None:
    first, second = (lf.simulate(pendulum_into_stop(), 0.15, GeneralizedAlpha(1e-4)) for _ in range(2))
    for name in ("times", "q", "u", "force", "impulse", "gap"):
        np.testing.assert_array_equal(getattr(first, name), getattr(second, name))


def test_a_users_bar_moves_as_that_of_the_library() -> None:
    """Nodal coordinates behind Python functions against a floating frame with modes, compiled."""
    nodes, element = 20, 1.0 / 20
    scene = lf.Scene(gravity=(0.0, 0.0))
    material = lf.Bar((nodes - 1) * element, area=3.14e-4, density=7800.0, youngs_modulus=210e9, elements=nodes - 1)
    bar = scene.add(material.reduce(modes=None), position=(5e-5, 0.0), velocity=(-0.1, 0.0))
    scene.contact(bar.node(0.0, 0.0), scene.ground.half_plane((0.0, 0.0), (1.0, 0.0)))
    stepper = GeneralizedAlpha(4e-6, 0.9)
    ours, users = lf.simulate(scene, 1e-3, stepper), lf.simulate(impacting_bar(nodes), 1e-3, stepper)
    assert users.impulse[-1, 0, 0] > 0.3
    np.testing.assert_allclose(users.impulse, ours.impulse, rtol=0, atol=1e-9)
    np.testing.assert_allclose(users.gap, ours.gap, rtol=0, atol=1e-12)
    np.testing.assert_allclose(users.energies.stored, ours.energies.stored, rtol=0, atol=1e-10)


def test_slider_crank_with_clearance() -> None:
    """Reference: a converged event-driven integration to the end of the first impact."""
    result = lf.simulate(slider_crank(), 0.003, GeneralizedAlpha(5e-6))
    after = np.flatnonzero(result.impulse.any(axis=(1, 2)))[0]
    assert result.times[after] == pytest.approx(0.002692503, abs=1e-5)
    assert result.u[after, 0] == pytest.approx(108.724580, rel=5e-4)
    assert result.u[after, 1] == pytest.approx(-52.842290, rel=1e-3)
    assert result.energies.stored[after] == pytest.approx(7.4581385, rel=2e-4)


@pytest.mark.slow
def test_woodpecker_pecks() -> None:
    """At five times the published step: errors of the times of the order of that step."""
    reference = gallery.scenes()["woodpecker"].reference
    result = lf.simulate(woodpecker(), 0.25, GeneralizedAlpha(1e-4))
    beak = result.contact("beak")
    pecks = beak.times[1:][np.diff(beak.impulse[:, 0]) > 0.0]
    assert pecks[0] == pytest.approx(reference["first_peck"], abs=5e-4)
    assert pecks[pecks > 0.15][0] == pytest.approx(reference["second_peck"], abs=1e-3)


# what happens where it cannot go on as usual


def painleve_rod() -> lf.Scene:
    """A rod slides on its tip with so much friction that no acceleration fulfils Coulomb's law."""
    scene = lf.Scene()
    angle = math.radians(125.0)
    rod = scene.add(
        lf.RigidBody(mass=1.0, inertia=1.0 / 3.0),
        position=(math.cos(angle), math.sin(angle)),
        angle=angle + math.pi,
        velocity=(5.0, 0.0),
    )
    scene.contact(rod.node(1.0, 0.0), floor_of(scene), friction=2.5)
    return scene


def test_accelerations_without_solution_are_left_to_impulses() -> None:
    result = lf.simulate(painleve_rod(), 0.3, GeneralizedAlpha(1e-3))
    assert result.complete
    first = np.flatnonzero(result.force[:, 0, 0])[0]
    assert first == 1
    assert result.u[first, 2] < -1.0  # the tip is stopped at once, and the rod tips over
    assert result.energies.stored[-1] < result.energies.stored[0]


@dataclass(frozen=True)
class Never:
    """A solver that gives up."""

    def solve(self, problem: Lcp, guess: Solution | None = None) -> Solution:
        return Solution(np.zeros(len(problem.q)), problem.q, Status.ITERATION_LIMIT, 1.0, 0, "none")


def test_an_unsolved_impact_ends_the_run_by_name() -> None:
    scene = lf.Scene()
    ball = scene.add(lf.Disc(radius=0.1, mass=1.0), position=(0.0, 0.1))
    scene.contact(ball.surface(), floor_of(scene))
    with pytest.raises(lf.StepError, match="iteration limit"):
        lf.simulate(scene, 0.1, GeneralizedAlpha(1e-3, solver=Never()))


def test_forces_too_stiff_for_the_step_are_told() -> None:
    """A force that jumps has no acceleration that it agrees with at the end of some steps."""
    jumping = UserSystem(q=[1.0], u=[0.0], mass=[[1.0]], force=lambda t, q, u: -1e3 * np.sign(q))
    result = lf.simulate(jumping, 0.5, GeneralizedAlpha(0.1))
    assert any("did not converge" in warning for warning in result.warnings)
    fine = lf.simulate(jumping, 0.04, GeneralizedAlpha(0.005))
    assert not any("did not converge" in warning for warning in fine.warnings)


def test_stiff_springs_of_a_user_converge() -> None:
    """A spring within ``force`` is no part of the iteration matrix: h^2 k beta / m = 6."""
    spring = UserSystem(q=[1.0], u=[0.0], mass=[[1.0]], force=lambda t, q, u: -100.0 * np.tanh(q) - 1e3 * q)
    results = [lf.simulate(spring, 0.5, GeneralizedAlpha(h)) for h in (0.1, 0.005)]
    assert not any("did not converge" in warning for result in results for warning in result.warnings)


@pytest.mark.parametrize("share", [0.5, 1.0, 1.5, 5.0, 20.0])
def test_dampers_of_any_size_converge(share: float) -> None:
    """Dampers between bodies are no part of the iteration matrix: c h / m of .5 to 20, and three of them at once."""
    h = 1e-2
    scene = lf.Scene()
    for k in range(3):
        body = scene.add(lf.Box(0.1, 0.1, mass=1.0), position=(0.5 * k, 0.0), velocity=(0.0, 1.0))
        foot = scene.ground.at(0.5 * k, -0.5)
        scene.load(lf.Spring(body.at(0.0, 0.0), foot, stiffness=100.0, damping=share / h * (1.0 + 0.3 * k)))
    exact = lf.simulate(scene, 0.5, lf.EventDriven(rtol=1e-10, atol=1e-12))
    result = lf.simulate(scene, 0.5, GeneralizedAlpha(h))
    assert not any("did not converge" in warning for warning in result.warnings)
    assert np.abs(result.q[-1] - exact.q[-1]).max() < 1e-4 * share


def test_a_last_shorter_step_ends_on_the_duration() -> None:
    """And knows that the recursive acceleration belongs to a step of another length."""
    result = lf.simulate(oscillator(10.0), 0.10003, GeneralizedAlpha(1e-4, 0.3))
    exact = math.cos(1.0003) + 0.03 * math.sin(1.0003), -10.0 * math.sin(1.0003) + 0.3 * math.cos(1.0003)
    whole = lf.simulate(oscillator(10.0), 0.1, GeneralizedAlpha(1e-4, 0.3))
    before = math.cos(1.0) + 0.03 * math.sin(1.0), -10.0 * math.sin(1.0) + 0.3 * math.cos(1.0)
    assert result.times[-1] == pytest.approx(0.10003, abs=1e-15)
    assert result.steps == 1001
    for end, start in (
        (result.q[-1, 0] - exact[0], whole.q[-1, 0] - before[0]),
        (result.u[-1, 0] - exact[1], whole.u[-1, 0] - before[1]),
    ):
        assert abs(end - start) < 0.01 * abs(start)


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("step", 0.0),
        ("step", -1e-3),
        ("step", float("nan")),
        ("rho_inf", -0.1),
        ("rho_inf", 1.1),
        ("gap_tolerance", 0.0),
        ("velocity_threshold", 0.0),
        ("solver_tolerance", 0.0),
        ("solver", None),
    ],
)
def test_bad_numbers_are_refused_by_name(field: str, value: float) -> None:
    arguments = {"step": 1e-3, field: value}
    with pytest.raises(lf.ModelError, match=field):
        GeneralizedAlpha(**arguments)  # type: ignore[arg-type]
