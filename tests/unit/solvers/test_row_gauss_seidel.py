"""Gauss-Seidel by rows of an LCP: steps on paper, relaxation, what it converges on, warm starts."""

import numpy as np
import pytest

from lcpflex.errors import ModelError
from lcpflex.solvers import GaussSeidel, Lcp, Status
from lcpflex.solvers.lcp.gauss_seidel import _sweep as sweep_rows


def definite(n: int, seed: int) -> tuple[Lcp, np.ndarray]:
    """A symmetric definite problem with a solution chosen first: half of the unknowns basic."""
    rng = np.random.default_rng(seed)
    A = rng.standard_normal((n, n))
    M = A @ A.T / n + np.eye(n)
    basic = rng.random(n) < 0.5
    z, w = np.where(basic, rng.uniform(0.5, 2.0, n), 0.0), np.where(basic, 0.0, rng.uniform(0.5, 2.0, n))
    return Lcp(M, w - M @ z), z


def chain(n: int) -> Lcp:
    """A column of n equal masses on a floor, all with 1 m/s downwards: slow for any iteration."""
    J = np.eye(n) - np.eye(n, k=-1)
    return Lcp(J @ J.T, -(J @ np.ones(n)))


class TestRows:
    @pytest.mark.parametrize("n", [1, 2, 7, 30])
    @pytest.mark.parametrize("relaxation", [0.5, 1.0, 1.5])
    def test_definite_problems(self, n, relaxation):
        problem, z = definite(n, n)
        solution = GaussSeidel(relaxation=relaxation).solve(problem)
        assert solution.status is Status.SOLVED
        assert solution.z == pytest.approx(z, abs=1e-9)
        assert solution.route.startswith("Gauss-Seidel")

    def test_one_sweep_by_hand(self):
        # z1 = 5 / 2; w2 = 1 * 5 / 2 - 6 = -7 / 2 and z2 = 7 / 4.
        M, q, z = np.array([[2.0, 1.0], [1.0, 2.0]]), np.array([-5.0, -6.0]), np.zeros(2)
        assert sweep_rows(M, q, 2, 1.0, z) == 2.5
        assert z.tolist() == [2.5, 1.75]

    @pytest.mark.parametrize(("omega", "z1", "z2"), [(0.5, 1.25, 1.1875), (1.5, 3.75, 1.6875)])
    def test_relaxed_sweep_by_hand(self, omega, z1, z2):
        # z1 = omega 5 / 2, then z2 = omega (6 - z1) / 2.
        M, q, z = np.array([[2.0, 1.0], [1.0, 2.0]]), np.array([-5.0, -6.0]), np.zeros(2)
        sweep_rows(M, q, 2, omega, z)
        assert z.tolist() == [z1, z2]

    def test_a_sweep_projects(self):
        M, q, z = np.array([[2.0, 1.0], [1.0, 2.0]]), np.array([-5.0, 1.0]), np.array([0.0, 9.0])
        assert sweep_rows(M, q, 2, 1.0, z) == 0.0
        assert z.tolist() == [0.0, 0.0]

    def test_a_zero_diagonal_is_divided_by_the_largest_entry_of_its_row(self):
        # Row 1: z1 = 0 - (4 * 0 - 8) / 4 = 2. A row of zeros is left alone.
        M, q = np.array([[0.0, 4.0, 0.0], [-4.0, 1.0, 0.0], [0.0, 0.0, 0.0]]), np.array([-8.0, 3.0, 5.0])
        z = np.zeros(3)
        assert sweep_rows(M, q, 3, 1.0, z) == 5.0
        assert z.tolist() == [2.0, 5.0, 0.0]

    def test_a_skew_matrix_without_any_diagonal(self):
        # 0 <= z1 _|_ z2 - 1 >= 0, 0 <= z2 _|_ 2 - z1 >= 0: z = (2, 1).
        solution = GaussSeidel().solve(Lcp([[0.0, 1.0], [-1.0, 0.0]], [-1.0, 2.0]))
        assert solution.solved
        assert solution.z == pytest.approx([2.0, 1.0], rel=1e-12)

    def test_a_row_of_zeros(self):
        assert GaussSeidel().solve(Lcp([[0.0, 0.0], [0.0, 2.0]], [1.0, -2.0])).z.tolist() == [0.0, 1.0]
        assert not GaussSeidel().solve(Lcp([[0.0, 0.0], [0.0, 2.0]], [-1.0, -2.0])).solved

    def test_over_relaxation_pays_in_a_column_of_masses(self):
        # Errors fall by cos^2(pi / 25) = 0.984 a sweep, with the best omega = 2 / (1 + sin(pi / 25)) by omega - 1.
        problem, n = chain(12), 12
        errors = []
        for omega in (1.0, 2.0 / (1.0 + np.sin(np.pi / 25.0))):
            z = np.zeros(n)
            for _ in range(100):
                sweep_rows(*problem._data, n, omega, z)
            errors.append(np.abs(z - np.arange(n, 0, -1.0)).max())
        assert errors[0] > 0.1 * 0.984**100 * n
        assert errors[1] < 1e-6 * errors[0]

    def test_block_pivoting_ends_the_crawl(self):
        solution = GaussSeidel().solve(chain(60))
        assert solution.route == "Gauss-Seidel, finished by block pivoting"
        assert solution.z == pytest.approx(np.arange(60, 0, -1.0), rel=1e-10)
        assert solution.active.tolist() == [1] * 60

    def test_a_warm_start_takes_fewer_sweeps(self):
        problem, z = definite(40, 3)
        far, near = (self.sweeps_until(problem, z, start) for start in (np.zeros(40), z + 1e-6))
        assert near < 0.75 * far

    @staticmethod
    def sweeps_until(problem, z, point):
        for count in range(1, 1000):
            sweep_rows(*problem._data, len(z), 1.0, point)
            if np.abs(point - z).max() < 1e-9:
                return count
        raise AssertionError("no convergence")

    def test_the_limit_is_reported(self):
        # A body between closing jaws: each sweep presses it harder from both sides, and nothing is ever solved.
        problem = Lcp([[1.0, -1.0], [-1.0, 1.0]], [-1.0, -1.0])
        for limit in (1, 3, 50):
            solution = GaussSeidel(sweep_limit=limit).solve(problem)
            assert solution.status is Status.ITERATION_LIMIT
            assert solution.iterations == limit
            assert solution.residual == problem.residual(solution.z)
            assert solution.active is None

    def test_divergence_is_a_failure_and_no_overflow(self):
        solution = GaussSeidel().solve(Lcp([[1.0, -4.0], [-4.0, 1.0]], [-1.0, -1.0]))  # z = -1/3 only: none >= 0
        assert solution.status is Status.NUMERICAL_FAILURE
        assert solution.z.tolist() == [0.0, 0.0]  # nothing better was seen than where it began
        assert solution.residual == 1.0

    def test_a_solution_needs_no_sweep(self):
        problem, z = definite(10, 2)
        solution = GaussSeidel().solve(problem)
        again = GaussSeidel().solve(problem, solution)
        assert again.iterations == 0
        assert again.z.tobytes() == solution.z.tobytes()
        assert again.active.tolist() == (z > 0.0).astype(int).tolist()

    @pytest.mark.parametrize("relaxation", [0.0, 2.0, -1.0, np.nan, 3.0])
    def test_refuses_a_relaxation_that_cannot_converge(self, relaxation):
        with pytest.raises(ModelError, match="relaxation"):
            GaussSeidel(relaxation=relaxation)
