"""Contact problems that are hard: redundant contacts, mass ratios, much friction, slow and inaccurate solvers."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from lcpflex import gallery
from lcpflex.solvers import (
    ContactProblem,
    ConvexFriction,
    Enumeration,
    GaussSeidel,
    Status,
    accept,
)
from tests.scenes import floor_of

STEP = 1e-3


def redundant_table(legs: int = 6) -> lf.Scene:
    """A rigid table of 1 kg stands on ``legs`` legs in a row: two would carry it."""
    scene = lf.Scene(gravity=(0.0, -9.81))
    table = scene.add(lf.RigidBody(mass=1.0, inertia=0.1), name="table", position=(0.0, 0.5))
    floor = floor_of(scene)
    for k in range(legs):
        x = -0.5 + k / (legs - 1)
        scene.contact(table.node(x, -0.5), floor, friction=0.5, name=f"leg {k + 1}")
    return scene


def pushed_uphill(friction: float, speed: float = 2.0) -> lf.Scene:
    """A flat plate of 1 kg, so long that it does not tip over, is pushed up a slope of 30 degrees at ``speed``."""
    slope = math.radians(30.0)
    normal = (-math.sin(slope), math.cos(slope))
    scene = lf.Scene(gravity=(0.0, -9.81))
    velocity = (speed * math.cos(slope), speed * math.sin(slope))
    place = (0.01 * normal[0], 0.01 * normal[1])
    plate = scene.add(lf.Box(width=0.4, height=0.02, mass=1.0), position=place, angle=slope, velocity=velocity)
    plane = scene.ground.half_plane((0.0, 0.0), normal)
    scene.contact(plate.surface(), plane, friction=friction, name="slope")
    return scene


@dataclass(frozen=True)
class Direct:
    """All contacts taken as closed, and a linear solve: right where their number is small enough."""

    def solve(self, problem: Any, guess: Any = None) -> Any:
        return accept(problem, np.linalg.solve(problem.M, -problem.q), tolerance=1e-9)


def test_redundant_contacts(loud: Any) -> None:
    """Six legs, singular Delassus matrix: forces are not unique, the motion is."""
    said = loud(redundant_table(), 0.1, lf.MoreauJean(step=STEP, solver=Direct()))
    assert "StepError" in said
    assert "Singular" in said or "residual" in said
    problem = ContactProblem(np.ones((3, 3)), -np.ones(3), friction=np.zeros(3))
    assert Enumeration().solve(problem).status is Status.NOT_UNIQUE
    for stepper in (lf.MoreauJean(step=STEP), lf.EventDriven()):
        result = lf.simulate(redundant_table(), 1.0, stepper)
        assert np.abs(result.q[-1] - result.q[0]).max() < 1e-9
        weight = result.force[-1, :, 0].sum()
        assert weight == pytest.approx(9.81, rel=1e-9)
        assert result.residual.max() < 1e-9


@pytest.mark.parametrize("ratio", [1e6, 1e8])
def test_mass_ratios(ratio: float, loud: Any) -> None:
    """A box of ``ratio`` kg on four of one: sweeps carry its weight down to the floor too slowly.

    Rounding of 1e-8 of the weight moves the light boxes by more than a billionth of their size: a gap tolerance is set.
    """
    said = loud(
        gallery.stack(boxes=5, top_mass=ratio), 0.1, lf.MoreauJean(step=STEP, solver=GaussSeidel(sweep_limit=20))
    )
    assert "StepError" in said
    assert "iteration" in said
    stepper = lf.MoreauJean(step=STEP, gap_tolerance=1e-9)
    result = lf.simulate(gallery.stack(boxes=5, top_mass=ratio), 1.0, stepper)
    assert np.abs(result.q[-1] - result.q[0]).max() < 1e-8  # a hundredth of a micrometre in 1000 steps
    assert not result.warnings


def test_large_friction(loud: Any) -> None:
    """mu = 3: the convex relaxation lifts what slides, a quadratic program has no friction; both are refused."""
    sliding = ContactProblem(np.eye(2), np.array([-0.01, 1.0]), friction=[3.0])
    assert "lifts sliding contacts" in ConvexFriction().solve(sliding).message
    scene = pushed_uphill(friction=3.0)
    assert "another model" in loud(scene, 0.1, lf.MoreauJean(step=STEP, solver=ConvexFriction()))
    assert "friction" in loud(scene, 0.1, lf.MoreauJean(step=STEP, solver=lf.QuadraticProgram()))
    # g (sin 30 + mu cos 30) stops it; it stays on the slope and does not slide back
    deceleration = 9.81 * (0.5 + 3.0 * math.cos(math.radians(30.0)))
    for stepper in (lf.EventDriven(), lf.MoreauJean(step=1e-5)):
        result = lf.simulate(scene, 0.2, stepper)
        moved = np.hypot(*(result.q[-1, :2] - result.q[0, :2]))
        assert moved == pytest.approx(2.0 / deceleration, rel=1e-3)  # v^2 / (2 a)


def test_gauss_seidel_stalls(loud: Any) -> None:
    """Twenty boxes on each other, and few sweeps."""
    scene = gallery.stack(boxes=20, friction=0.5)
    said = loud(scene, 0.05, lf.MoreauJean(step=STEP, solver=GaussSeidel(sweep_limit=30)))
    assert "StepError" in said
    assert "residual" in said
    result = lf.simulate(scene, 0.5, lf.MoreauJean(step=STEP))
    assert np.abs(result.q[-1] - result.q[0]).max() < 1e-9


@dataclass(frozen=True)
class Loose:
    """A quadratic program as OSQP leaves it with its default tolerances."""

    def solve(self, problem: Any, guess: Any = None) -> Any:
        from qpsolvers import solve_qp
        from scipy.sparse import csc_matrix

        n = len(problem.q)
        z = solve_qp(csc_matrix(problem.M), problem.q, lb=np.zeros(n), solver="osqp", eps_abs=1e-4, eps_rel=1e-4)
        return accept(problem, np.zeros(n) if z is None else np.maximum(z, 0.0), tolerance=1e-3)


def test_quadratic_programs_that_stop_early(loud: Any) -> None:
    """A solver that stops at 1e-4 is not believed, whatever it claims."""
    scene = gallery.stack(boxes=10, friction=0.0)
    said = loud(scene, 0.05, lf.MoreauJean(step=STEP, solver=Loose()))
    assert "StepError" in said
    assert "residual" in said
    for solver in (lf.QuadraticProgram("osqp"), lf.QuadraticProgram("clarabel"), lf.Auto()):
        result = lf.simulate(scene, 0.02, lf.MoreauJean(step=STEP, solver=solver))
        assert result.residual.max() < 1e-9
        assert np.abs(result.q[-1] - result.q[0]).max() < 1e-9
