"""Of rows that all fail the best point is given, and why the one that could have told found nothing."""

import numpy as np
import pytest

from lcpflex.solvers import Auto, ContactProblem, Lcp, Lemke, MinMapNewton, QuadraticProgram, Status, accept, user_table
from lcpflex.solvers.user_table import LCP, PLANE, Case, Row, solve_by_table, with_solver
from tests.piles import columns


def row_of(name, z, status, tells):
    """A row that comes to a point which is no solution."""

    def run(case):
        return accept(case.problem, z, tolerance=1e-10, status=status, iterations=3, route=name)

    return Row(name, run, (PLANE,), tells=tells)


@pytest.mark.parametrize("shares", [(0.0, 1.0), (1.0, 0.0)])
def test_the_point_is_the_best_and_the_reason_that_of_who_can_tell(monkeypatch, shares):
    J, free, mu = columns(1, 6, ratio=1e6, push=0.8)
    problem = ContactProblem(None, free, mu, factor=J)
    nothing, pushed = (np.full(problem.size, share) for share in (0.0, 1.0))
    assert problem.residual(nothing) < problem.residual(pushed)
    first, second = (np.full(problem.size, share) for share in shares)
    rows = (row_of("swept", first, Status.ITERATION_LIMIT, False), row_of("ray", second, Status.RAY, True))
    monkeypatch.setattr(user_table, "_rows_for", lambda kind, size: rows)
    found = solve_by_table(Case(PLANE, problem, None, 1e-10, 600, 1))
    assert np.array_equal(found.z, nothing)
    assert found.status is Status.RAY
    assert found.message == "ray: nothing of swept > ray found a solution or proved that none is"
    assert found.route == "swept (failed) > ray (failed)"
    assert found.iterations == 6


def test_a_point_near_the_tolerance_is_said_to_be_that(monkeypatch):
    J, free, mu = columns(1, 6)
    problem = ContactProblem(None, free, mu, factor=J)
    near = Case(PLANE, problem, None, 1e-10, 600, 1)
    z = solve_by_table(near).z * (1.0 + 1e-8)
    rows = (row_of("swept", z, Status.ITERATION_LIMIT, False), row_of("ray", 0.0 * z, Status.RAY, True))
    monkeypatch.setattr(user_table, "_rows_for", lambda kind, size: rows)
    found = solve_by_table(Case(PLANE, problem, None, 1e-10, 600, 1))
    assert np.array_equal(found.z, z)
    assert found.status is Status.INACCURATE
    assert found.message.startswith("inaccurate: residual ")


@pytest.mark.parametrize("backend", ["osqp", "clarabel"])
def test_any_solver_is_a_row(monkeypatch, backend):
    """Of qpsolvers, too: where it takes the problem, and no later than another one is needed."""
    rows = (
        Row(backend, with_solver(lambda tolerance: QuadraticProgram(backend, tolerance)), (LCP,)),
        Row("min-map Newton", with_solver(MinMapNewton), (LCP,)),
    )
    monkeypatch.setattr(user_table, "_rows_for", lambda kind, size: rows)
    found = Auto().solve(Lcp([[2.0, 1.0], [1.0, 2.0]], [-5.0, -6.0]))
    assert found.z == pytest.approx([4 / 3, 7 / 3], rel=1e-12)
    assert found.route.startswith(backend)
    unsymmetric = Auto().solve(Lcp([[1.0, 0.0], [2.0, 1.0]], [-1.0, -1.0]))
    assert unsymmetric.route == "min-map Newton"
    assert unsymmetric.z == pytest.approx([1.0, 0.0], abs=1e-13)


def test_what_a_row_raises_is_told_and_the_next_one_tried(monkeypatch):
    def breaks(case):
        raise RuntimeError("the solver broke")

    rows = (Row("breaks", breaks, (LCP,)), Row("pivoting", with_solver(Lemke), (LCP,)))
    monkeypatch.setattr(user_table, "_rows_for", lambda kind, size: rows)
    assert Auto().solve(Lcp([[2.0]], [-4.0])).route == "breaks (failed) > lemke"
    none = Auto().solve(Lcp([[-1.0, 2.0], [1.0, 1.0]], [-1.0, 1.0]))  # w2 > 0 makes z2 = 0, and then w1 < 0
    assert not none.solved
    assert "breaks ended with RuntimeError: the solver broke" in none.message
