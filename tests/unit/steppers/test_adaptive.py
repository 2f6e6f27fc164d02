"""Step control of Moreau-Jean: errors follow the tolerance, impacts shorten the step, smooth motion lengthens it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from lcpflex import gallery
from lcpflex.solvers.problem import Lcp, Solution
from lcpflex.steppers.adaptive import AdaptiveStep
from tests.rates import assert_rate
from tests.scenes import floor_of


@dataclass(frozen=True)
class InPython:
    """Lemke behind a Python call: makes the stepper take its interpreted driver."""

    def solve(self, problem: Lcp, guess: Solution | None = None) -> Solution:
        return lf.Lemke().solve(problem, guess)


def controlled(tolerance: float, **options: object) -> lf.MoreauJean:
    return lf.MoreauJean(step=1e-4, adaptive=AdaptiveStep(rtol=tolerance, atol=1e-2 * tolerance), **options)


def test_error_falls_with_the_tolerance_and_steps_grow_as_its_root() -> None:
    """Local errors of order 3 between events: steps go with tolerance^(-1/3), the final error with tolerance^(2/3)."""
    tolerances = np.geomspace(1e-6, 10**-9.5, 8)
    runs = [lf.simulate(gallery.stick_slip_block(), 1.9, controlled(tolerance)) for tolerance in tolerances]
    errors = [abs(run.q[-1, 0] - 0.332714308) for run in runs]
    assert_rate(tolerances, errors, 2.0 / 3.0, within=0.06)
    assert_rate(tolerances, [run.steps for run in runs], -1.0 / 3.0, within=0.05)
    assert errors[-1] < 1e-8


def test_the_step_is_short_at_impacts_and_long_in_flight() -> None:
    result = lf.simulate(gallery.bouncing_ball(), 1.0, controlled(1e-6), record=0.0)
    lengths = np.diff(result.times)
    jumps = np.diff(result.u[:, 1]) > 1.0
    assert jumps.sum() == 2  # impacts at .45 and .90 s
    assert lengths[jumps].max() < 1e-5
    assert lengths.max() > 100.0 * lengths[jumps].max()
    first = result.times[1:][jumps][0]
    assert first == pytest.approx(math.sqrt(2.0 / 9.81), abs=1e-5)


def test_step_control_beats_a_fixed_step_at_the_same_error() -> None:
    scene = gallery.bouncing_ball
    exact = lf.simulate(scene(), 1.0, lf.EventDriven())
    adaptive = lf.simulate(scene(), 1.0, controlled(1e-6))
    fixed = lf.simulate(scene(), 1.0, lf.MoreauJean(step=1.0 / (10 * adaptive.steps)))
    error = abs(adaptive.q[-1, 1] - exact.q[-1, 1])
    assert error < 1e-5
    assert error < 0.5 * abs(fixed.q[-1, 1] - exact.q[-1, 1])


def test_flexible_bodies_with_joints_and_friction() -> None:
    scene = gallery.pendulum(modes=4)
    result = lf.simulate(scene, 0.45, controlled(1e-5))
    reference = lf.simulate(scene, 0.45, lf.MoreauJean(step=2e-6))
    assert result.complete
    assert result.joint_drift.max() < 1e-11
    assert result.impulse[-1, 0, 0] == pytest.approx(reference.impulse[-1, 0, 0], rel=2e-2)
    assert result.energies.relative_remainder < 1e-3


def test_both_drivers_agree() -> None:
    scene = gallery.stick_slip_block()
    compiled = lf.simulate(scene, 0.6, controlled(1e-5, solver=lf.Lemke()))
    python = lf.simulate(scene, 0.6, controlled(1e-5, solver=InPython()))
    assert python.steps == compiled.steps
    np.testing.assert_allclose(python.q, compiled.q, rtol=0.0, atol=1e-13)


@pytest.mark.slow
def test_a_system_of_the_users_own() -> None:
    result = lf.simulate(gallery.woodpecker(), 0.1, controlled(1e-6), record=0.0)
    beak = np.argmax(np.abs(np.diff(result.u[:, 2])) > 5.0)
    assert result.times[beak] == pytest.approx(0.08102, abs=1e-4)


def test_ends_on_its_duration_and_stores_the_end() -> None:
    result = lf.simulate(gallery.stick_slip_block(), 0.7371, controlled(1e-5), record=0.1)
    assert result.complete
    assert result.times[-1] == 0.7371
    assert (np.diff(result.times)[:-1] >= 0.1).all()


@pytest.mark.parametrize("stepper", [lf.MoreauJean, lf.GeneralizedAlpha])
@pytest.mark.parametrize("record", [0.0, 1e-18])
def test_an_instant_is_stored_once_though_steps_from_it_are_rejected(stepper: Any, record: float) -> None:
    control = AdaptiveStep(rtol=1e-4, atol=1e-6)
    result = lf.simulate(gallery.bouncing_ball(), 0.6, stepper(step=1e-3, adaptive=control), record=record)
    assert np.diff(result.times).min() > 0.0
    assert len(result.times) <= result.steps + 1


def test_steps_that_are_as_short_as_allowed_are_reported() -> None:
    stepper = lf.MoreauJean(step=1e-2, adaptive=AdaptiveStep(rtol=1e-14, atol=1e-16, shortest=1e-2, longest=1e-2))
    result = lf.simulate(gallery.stick_slip_block(), 1.0, stepper)
    assert result.steps == 100
    assert any("as short as allowed" in warning for warning in result.warnings)


@pytest.mark.parametrize(("name", "value"), [("rtol", -1.0), ("atol", 0.0), ("shortest", math.nan), ("longest", 0.0)])
def test_refuses_numbers_out_of_range(name: str, value: float) -> None:
    with pytest.raises(lf.ModelError, match=name):
        AdaptiveStep(**{name: value})


def test_refuses_a_longest_step_below_the_shortest() -> None:
    with pytest.raises(lf.ModelError, match="longest"):
        AdaptiveStep(shortest=1e-9, longest=1e-12)


def test_refuses_another_object() -> None:
    with pytest.raises(lf.ModelError, match="adaptive"):
        lf.MoreauJean(step=1e-3, adaptive=1e-6)


def controlled_alpha(tolerance: float, **options: object) -> lf.GeneralizedAlpha:
    return lf.GeneralizedAlpha(step=1e-4, adaptive=AdaptiveStep(rtol=tolerance, atol=1e-2 * tolerance), **options)


def swinging_mass() -> lf.Scene:
    scene = lf.Scene(gravity=(0.0, -9.81))
    bob = scene.add(lf.RigidBody(mass=1.0, inertia=0.1), position=(1.0, 0.0))
    scene.join(lf.Distance(bob.point("center"), scene.ground.at(0.0, 0.0)))
    return scene


def test_generalised_alpha_keeps_its_order_while_its_step_changes() -> None:
    """Local errors of order 3 under control: steps go with tolerance^(-1/3), the final error with tolerance^(2/3)."""
    exact = lf.simulate(swinging_mass(), 3.0, lf.EventDriven(rtol=1e-11, atol=1e-12)).q[-1]
    tolerances = np.array([1e-4, 1e-5, 1e-6, 1e-7])
    runs = [lf.simulate(swinging_mass(), 3.0, controlled_alpha(tolerance)) for tolerance in tolerances]
    errors = [np.abs(run.q[-1] - exact).max() for run in runs]
    assert_rate(tolerances, errors, 2.0 / 3.0, within=0.1)
    assert_rate(tolerances, [run.steps for run in runs], -1.0 / 3.0, within=0.05)


def test_generalised_alpha_shortens_its_step_at_impacts() -> None:
    result = lf.simulate(gallery.bouncing_ball(), 1.0, controlled_alpha(1e-6), record=0.0)
    lengths = np.diff(result.times)
    jumps = np.diff(result.u[:, 1]) > 1.0
    assert jumps.sum() == 2
    assert lengths[jumps].max() < 1e-5
    assert lengths.max() > 100.0 * lengths[jumps].max()
    assert result.times[1:][jumps][0] == pytest.approx(math.sqrt(2.0 / 9.81), abs=1e-5)


@pytest.mark.parametrize("restitution", [0.0, 0.7])
def test_generalised_alpha_sees_impacts_in_any_part_of_a_step(restitution: float) -> None:
    """A disc that flies free but for one oblique impact: x and angle grow linearly before and after it."""
    for height in np.linspace(0.3, 0.4, 9):
        scene = lf.Scene(gravity=(0.0, 0.0))
        disc = scene.add(lf.RigidBody(mass=1.0, inertia=0.4), position=(0.0, 1.0 + height), velocity=(3.0, -2.0))
        floor = floor_of(scene)
        scene.contact(disc.circle((0.0, 0.0), 1.0), floor, friction=0.2, restitution=restitution)
        stepper = lf.GeneralizedAlpha(step=1e-4, adaptive=AdaptiveStep(rtol=1e-6, atol=1e-8))
        result = lf.simulate(scene, 1.0, stepper)
        impact, normal = 0.5 * height, 2.0 * (1.0 + restitution)
        after = 1.0 - impact
        exact = (3.0 - 0.2 * normal * after, 1.0 + 2.0 * restitution * after, -0.2 * normal / 0.4 * after)
        np.testing.assert_allclose(result.q[-1], exact, rtol=0, atol=1e-5)
        assert result.steps < 1000


def test_generalised_alpha_with_friction_by_both_drivers() -> None:
    scene = gallery.stick_slip_block()
    compiled = lf.simulate(scene, 1.9, controlled_alpha(1e-6, solver=lf.Lemke()))
    python = lf.simulate(scene, 1.9, controlled_alpha(1e-6, solver=InPython()))
    assert compiled.q[-1, 0] == pytest.approx(0.332714308, abs=1e-4)
    assert python.steps == compiled.steps
    np.testing.assert_allclose(python.q, compiled.q, rtol=0.0, atol=1e-13)


def test_generalised_alpha_makes_room_for_more_contacts() -> None:
    """Twenty-five boxes touch at a hundred places: the tables of a run begin smaller."""
    result = lf.simulate(gallery.stack(boxes=25), 0.05, controlled_alpha(1e-4))
    assert result.complete
    assert np.abs(result.q[-1] - result.q[0]).max() < 1e-8


@pytest.mark.parametrize("space", [False, True])
def test_slip_that_ends_within_a_step_is_seen_by_generalised_alpha(space: bool) -> None:
    """Where it ends in the second half of a step, the step and its halves agree, and both have slid on."""
    longest, tolerance, friction, gravity = 5e-3, 1e-6, 0.6, 9.81
    control = AdaptiveStep(rtol=tolerance, atol=1e-2 * tolerance, longest=longest)
    for speed in np.linspace(0.4, 0.4 + friction * gravity * longest, 5):  # ends all over a step
        scene: Any
        if space:
            scene = lf.SpatialScene(gravity=(0.0, 0.0, -gravity))
            box = scene.add(lf.Cuboid(0.3, 0.2, 0.1, mass=1.0), "box", (0.0, 0.0, 0.05), velocity=(speed, 0.0, 0.0))
            floor = scene.ground.plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0))
        else:
            scene = lf.Scene(gravity=(0.0, -gravity))
            box = scene.add(lf.Box(0.3, 0.1, mass=1.0), "box", position=(0.0, 0.05), velocity=(speed, 0.0))
            floor = scene.ground.half_plane((0.0, 0.0), (0.0, 1.0))
        scene.contact(box.surface(), floor, friction=friction)
        result = lf.simulate(scene, 0.12, lf.GeneralizedAlpha(step=longest, adaptive=control))
        way = 0.5 * speed**2 / (friction * gravity)
        assert abs(result.q[-1, 0] - way) < 4.0 * tolerance  # of coordinates up to 1: some steps may be off by it
