"""Lemke's algorithm: worst cases, cycles, rays, limits, its kernel, and the start from a basis."""

import itertools

import numpy as np
import pytest

from lcpflex.errors import ModelError
from lcpflex.solvers import ContactProblem, Lcp, Lemke, Status
from lcpflex.solvers.lcp.lemke import lemke, lemke_workspace
from tests.piles import heap, moving


def box_on_floor(contacts: int, friction: float, velocity: tuple[float, float, float]) -> ContactProblem:
    """A box of 1 kg, 1 m x 0.5 m, touching a floor at points along its lower side; velocity (vx, vy, omega)."""
    x = np.linspace(-0.5, 0.5, contacts)
    ones = np.ones(contacts)
    normal = np.column_stack([0 * x, ones, x])
    tangent = np.column_stack([ones, 0 * x, 0.25 * ones])
    rows = np.vstack([normal, tangent]) if friction else normal
    inverse_mass = np.array([1.0, 1.0, 12.0 / 1.25])
    return ContactProblem((rows * inverse_mass) @ rows.T, rows @ np.array(velocity), friction * ones)


def murty(n: int) -> np.ndarray:
    return np.tril(2.0 * np.ones((n, n)), -1) + np.eye(n)


def enumerate_solutions(problem: Lcp) -> list[np.ndarray]:
    """Every complementary solution with a nonsingular basis, by trying all 2^n active sets."""
    found = []
    for flags in itertools.product((False, True), repeat=problem.size):
        active = np.flatnonzero(flags)
        z = np.zeros(problem.size)
        block = problem.M[np.ix_(active, active)]
        if active.size:
            if abs(np.linalg.det(block)) < 1e-12:
                continue
            z[active] = np.linalg.solve(block, -problem.q[active])
        if (z >= -1e-12).all() and (problem.slack(z) >= -1e-12).all():
            found.append(z)
    return found


@pytest.mark.parametrize("n", [3, 8, 16, 40])
def test_murty(n):
    # z = e_1 for q = -1; the textbook path takes 2^n pivots.
    solution = Lemke(pivot_limit=1000).solve(Lcp(murty(n), -np.ones(n)))
    assert solution.solved
    assert solution.z == pytest.approx([1.0] + [0.0] * (n - 1), abs=1e-12)


@pytest.mark.parametrize("n", [3, 5, 9, 21])
def test_cyclic_matrix(n):
    M = np.eye(n) + 2.0 * np.roll(np.eye(n), 1, axis=1)  # pivoting rules without protection run in circles here
    solution = Lemke().solve(Lcp(M, -np.ones(n)))
    assert solution.solved
    assert solution.z == pytest.approx(np.full(n, 1 / 3), rel=1e-12)


def test_honest_ray():
    solution = Lemke().solve(Lcp([[-1.0]], [-1.0]))  # w = -z - 1 < 0 for every z
    assert solution.status is Status.INFEASIBLE  # the ray proves it
    assert solution.residual == pytest.approx(1.0)
    # The Painleve pattern: M < 0 with q > 0 has the solution 0 (and another).
    assert Lemke().solve(Lcp([[-1.0]], [1.0])).solved


def skew_problem() -> Lcp:
    """z^T M z = 0 for every z: nothing but a whole path leads to the solution, no repair of its end."""
    rng = np.random.default_rng(0)
    A = rng.standard_normal((30, 30))
    M = A - A.T
    return Lcp(M, np.abs(A[2]) * (A[1] <= 0.0) - M @ (np.abs(A[0]) * (A[1] > 0.0)))


@pytest.mark.parametrize("limit", [1, 2, 5])
@pytest.mark.parametrize("problem", [box_on_floor(4, 3.0, (1.0, -0.1, 0.2)).lcp(), skew_problem()], ids=["box", "skew"])
def test_pivot_limit_is_reported(problem, limit):
    needed = Lemke().solve(problem)
    assert needed.solved
    assert needed.iterations > 2 * limit
    assert Lemke(pivot_limit=needed.iterations).solve(problem).iterations == needed.iterations
    few = Lemke(pivot_limit=limit).solve(problem)
    assert few.status is Status.ITERATION_LIMIT
    assert few.iterations == 11 * limit  # of each of its eleven paths
    assert few.residual == problem.residual(few.z)
    assert few.residual > 1e-3


def test_pivot_limit_must_be_positive():
    with pytest.raises(ModelError, match="pivot_limit"):
        Lemke(pivot_limit=0)


@pytest.mark.parametrize("seed", range(20))
def test_answer_is_one_of_all(seed):
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 7))
    A = rng.standard_normal((n, n))
    problem = Lcp(A @ A.T + 0.1 * np.eye(n) + (A - A.T), rng.standard_normal(n))
    every = enumerate_solutions(problem)
    solution = Lemke().solve(problem)
    assert len(every) == 1  # the matrix is positive definite
    assert solution.solved
    assert solution.z == pytest.approx(every[0], abs=1e-8)


def test_work_larger_than_the_problem_changes_nothing():
    problem, _ = box_on_floor(3, 0.4, (1.0, -0.1, 0.2)).lcp().balanced()  # what the kernel is given
    n = problem.size
    reference = Lemke().solve(problem)
    M, q, z = np.full((n + 5, n + 5), np.nan), np.full(n + 5, np.nan), np.full(n + 5, np.nan)
    M[:n, :n], q[:n] = problem.M, problem.q
    status, pivots = lemke(M, q, n, z, *lemke_workspace(n + 5), 1000)
    assert (status, pivots) == (Status.SOLVED, reference.iterations)
    assert z[:n].tobytes() == reference.z.tobytes()
    assert np.isnan(z[n:]).all()


def test_a_kernel_given_nan_ends_unsolved():
    z = np.zeros(2)
    table, basis = lemke_workspace(2)
    assert lemke(np.array([[1.0, 0.0], [0.0, 1.0]]), np.array([np.nan, -1.0]), 2, z, table, basis, 100)[0] != 0
    assert lemke(np.array([[np.nan, 0.0], [0.0, 1.0]]), np.array([-1.0, -1.0]), 2, z, table, basis, 100)[0] != 0


def test_basis_of_a_similar_problem_saves_the_pivots():
    before = Lemke().solve(box_on_floor(2, 0.5, (1.0, -0.1, 0.0)).lcp())
    after = box_on_floor(2, 0.5, (1.01, -0.1, 0.01)).lcp()
    warm, cold = Lemke().solve(after, before), Lemke().solve(after)
    assert warm.route == "basis of the guess"
    assert warm.iterations < cold.iterations
    assert warm.z == pytest.approx(cold.z, abs=1e-10)


@pytest.mark.parametrize("seed", [1, 2])
def test_the_basis_is_that_of_the_point(seed):
    """Where a last repair makes a point worse that is good enough, the basis of the repair is not told as its own."""
    J, free, mu = moving(heap(2, 3, friction=1e4, ratio=1e3, seed=seed), 0.5, seed)
    found = Lemke().solve(ContactProblem((J @ J.T).toarray(), free, mu))
    assert found.solved
    assert found.residual > 1e-12
    assert not found.z[found.active == 0].any()
    assert found.z[found.active == 1].any()
