"""Contact problems in space given to other solvers, and told to those who watch: the motion is the same."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.solvers.certificate import guarded_residual
from lcpflex.solvers.contact.laws.disc import solve_cone
from lcpflex.solvers.contact.posed import posed_problem, tried_point

STEP = 1e-3


def sliding_balls() -> lf.SpatialScene:
    """Two balls that slide and spin on the ground and hit each other: their motion is unique."""
    scene = lf.SpatialScene()
    ground = scene.ground.plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    balls = [
        scene.add(
            lf.Sphere(0.1, mass=2.0), "fast", (0.0, 0.0, 0.1), velocity=(1.0, 0.3, 0.0), angular_velocity=(3, 1, 5)
        ),
        scene.add(lf.Sphere(0.1, mass=1.0), "slow", (0.21, 0.02, 0.1), angular_velocity=(-9, 2, 1)),
    ]
    for ball in balls:
        scene.contact(ball.surface(), ground, friction=0.3)
    scene.contact(balls[0].surface(), balls[1].surface(), friction=0.2)
    return scene


def stepped(solver: Any = None, watch: Any = None, steps: int = 30) -> Any:
    """The scheme after so many steps: q and u."""
    stepper = lf.MoreauJean(step=STEP) if solver is None else lf.MoreauJean(step=STEP, solver=solver)
    run: Any = stepper.start(replace(sliding_balls().compiled().system(), watch=watch), 1.0, 1.0)
    assert run.advance(steps) == ""
    return run.method.stepping.scheme


def by_sweeps(problem: Any) -> Any:
    """A function of the user's: sweeps on the matrix."""
    W, q, r = problem.dense(), problem.free, np.zeros(problem.size)
    for _ in range(400):
        for k, mu in enumerate(problem.friction):
            at = slice(3 * k, 3 * k + 3)
            own = W[at, at]
            rest = W[at] @ r + q[at] - own @ r[at]
            r[at] = solve_cone(*own[np.triu_indices(3)], *rest, mu, 0.0)[:3]
    return r


def test_other_solvers_come_to_the_same_motion() -> None:
    own, other = stepped(), stepped(lf.solvers.UserSolver(by_sweeps, takes="problem", tolerance=1e-9))
    assert other.u == pytest.approx(own.u, abs=1e-7)  # 30 steps of 1e-9
    assert other.q == pytest.approx(own.q, abs=1e-9)
    assert own.u[6] > 0.1


def test_solvers_of_lcps_are_refused() -> None:
    with pytest.raises(lf.ModelError, match=r"solver: .*cone"):
        stepped(lf.solvers.Lemke())


def test_problems_are_told() -> None:
    """Each with its Delassus operator and the answer of the step, though the step makes none."""
    told: list[tuple[int, float]] = []

    def watch(data: Any, memory: Any) -> None:
        problem = posed_problem(data, memory)
        told.append((problem.size, guarded_residual(*problem.residual_parts(tried_point(memory)))))  # as the run judges

    assert np.array_equal(stepped(watch=watch).u, stepped().u)
    assert len(told) > 30
    assert {size for size, _ in told} >= {3, 9}
    assert max(residual for _, residual in told) <= 1e-9


def test_recorded_problems_are_replayed(tmp_path: Path) -> None:
    """What a run met comes back from its file and is solved alike by all solvers of its model."""
    path = tmp_path / "met.npz"
    lf.simulate(sliding_balls(), 0.02, lf.MoreauJean(step=STEP), record_problems=lf.RecordProblems(path, every=5))
    met = lf.solvers.load_problems(path)
    assert len(met) >= 4
    assert all(isinstance(one.problem, lf.solvers.SpatialContactProblem) for one in met)
    assert all(one.problem.keys for one in met)
    solvers = {"Auto": lf.solvers.Auto(), "Newton": lf.solvers.AlartCurnier(), "facets": lf.solvers.FacetedCone()}
    replayed = lf.solvers.replay(met, solvers, repeats=1, warm=True)
    rows = {row.solver: row for row in replayed.rows}
    assert not replayed.contradictory
    assert rows["Auto"].solved == rows["Newton"].solved == len(met)
    assert rows["Newton"].other_motion == 0
    assert rows["facets"].model == "friction cone of 8 facets"
    assert np.isinf(replayed.times[2]).all()
