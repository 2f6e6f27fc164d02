"""Solved contacts are taken to the last digits of their velocities, which may be small beside what cancels in them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import scipy.sparse

from lcpflex.solvers import Auto, ContactProblem, Solution, SpatialContactProblem, Status, accept, user_table
from lcpflex.solvers.clock import within
from lcpflex.solvers.contact.user_search import UserSearch
from lcpflex.solvers.user_table import PLANE, SPACE, Case, Row, solve_by_table
from tests.property.random_contacts import draw
from tests.property.solver_campaign import answered


def leaning(rows: int) -> ContactProblem | SpatialContactProblem:
    """Two mass points on a floor and on each other, mu = .5: 100 kg at rest below, 1 kg at -1 m/s above."""
    normal = np.array([[0.0, 0.1], [1.0, -0.1]])
    if rows == 2:
        J = np.zeros((4, 4))
        J[:2, :2] = J[2:, 2:] = normal
        return ContactProblem(J @ J.T, [0.0, -1.0, 0.0, 0.2], [0.5, 0.5])
    J = np.zeros((6, 6))
    for a in range(3):
        J[a::3, 2 * a : 2 * a + 2] = normal
    return SpatialContactProblem(J @ J.T, [0.0, 0.0, 0.0, -1.0, 0.2, 0.0], [0.5, 0.5])


def digits(problem: ContactProblem | SpatialContactProblem, found: Solution, tolerance: float) -> Solution:
    """What the table makes of a point that one row has come to."""
    case = Case(PLANE if isinstance(problem, ContactProblem) else SPACE, problem, None, tolerance, 600, 1)
    by_hand = Row("by hand", lambda case: found, (PLANE, SPACE))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(user_table, "_rows_for", lambda kind, size: (by_hand,))
        return solve_by_table(case)


@pytest.mark.parametrize("rows", [2, 3])
def test_a_point_beside_the_solution_is_taken_to_it(rows: int) -> None:
    """By as many sweeps as there were; the point itself is one by a tolerance that is not the velocities'."""
    problem = leaning(rows)
    right = Auto().solve(problem)
    near = accept(problem, right.z * (1.0 + 1e-7), tolerance=1e-3, iterations=300, route="by hand")
    assert near.solved
    found = digits(problem, near, 1e-8)
    assert found.strict <= 1e-8 < near.strict
    assert found.z == pytest.approx(right.z, abs=1e-7)
    assert found.route == "by hand > more sweeps"
    assert found.iterations > near.iterations


@pytest.mark.parametrize("rows", [2, 3])
def test_what_is_solved_when_time_is_up_stays(rows: int) -> None:
    problem = leaning(rows)
    right = Auto().solve(problem)
    near = accept(problem, right.z * (1.0 + 1e-7), tolerance=1e-3, iterations=300, route="by hand")
    with within(1e-9):
        found = digits(problem, near, 1e-8)
    assert found.solved
    assert found.route == "by hand"
    assert np.array_equal(found.z, near.z)


@pytest.mark.parametrize("rows", [2, 3])
def test_what_is_right_or_one_of_several_stays(rows: int) -> None:
    problem = leaning(rows)
    right = Auto().solve(problem)
    assert digits(problem, right, 1e-10) is right
    several = accept(problem, right.z, tolerance=2.0, solutions=(right.z, 0.0 * right.z), route="by hand")
    assert several.status is Status.NOT_UNIQUE
    assert digits(problem, several, 1e-30).route == "by hand"


@pytest.mark.parametrize("way", ["delassus", "factor"])
@pytest.mark.parametrize(("dimension", "seed"), [(2, 112), (2, 280), (3, 9), (3, 209)])
def test_relative_to_the_load(dimension: int, seed: int, way: str) -> None:
    """Sweeps ended at 2e-10 to 9e-10 of the free velocities: the judge knows no terms."""
    one = answered(draw(dimension, seed), way)
    assert one.solved
    assert one.within


def test_many_contacts_take_few_factors(monkeypatch: pytest.MonkeyPatch) -> None:
    """By friction that is a thousand times the normal force, digits are lost to rounding that no factor brings back."""
    searches: list[UserSearch] = []
    run = UserSearch.run

    def counted(self: UserSearch, *settings: Any) -> None:
        searches.append(self)
        run(self, *settings)

    monkeypatch.setattr(UserSearch, "run", counted)
    rng, n = np.random.default_rng(3), 100
    J = scipy.sparse.block_diag(rng.standard_normal((n, 3, 4)), format="csr")
    problem = SpatialContactProblem(J @ J.T, rng.standard_normal(3 * n), np.full(n, 1e3))
    found = Auto(1e-12).solve(problem)
    assert found.solved
    assert found.strict > 1e-12
    assert len(searches) == 1
    assert searches[0].factors <= 20
