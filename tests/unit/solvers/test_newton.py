"""Newton's method on the min-map: what it solves, how fast near a solution, and how it ends when it does not."""

from dataclasses import replace

import numpy as np
import pytest

from lcpflex.solvers import ContactProblem, Lcp, MinMapNewton, Status
from lcpflex.solvers.lcp.newton import (
    _begin as begin,
    _min_map as min_map,
    _newton_point as newton_point,
    _step as step,
    min_map_newton,
    newton_workspace,
)

UNSOLVABLE = Lcp([[-1.0, 2.0], [1.0, 1.0]], [-1.0, 1.0])  # w2 > 0 makes z2 = 0, and then w1 < 0


def definite(n: int, seed: int) -> tuple[Lcp, np.ndarray]:
    """A definite problem, unsymmetric, with a solution chosen first: half of the unknowns basic."""
    rng = np.random.default_rng(seed)
    A = rng.standard_normal((n, n))
    M = A @ A.T / n + 0.1 * np.eye(n) + (A - A.T)
    basic = rng.random(n) < 0.5
    z, w = np.where(basic, rng.uniform(0.5, 2.0, n), 0.0), np.where(basic, 0.0, rng.uniform(0.5, 2.0, n))
    return Lcp(M, w - M @ z), z


def run_kernel(M, q, start=None, tolerance=1e-10, limit=100, capacity=None):
    n = len(q)
    capacity = capacity or n
    A, b, z = np.full((capacity, capacity), np.nan), np.full(capacity, np.nan), np.full(capacity, np.nan)
    A[:n, :n], b[:n] = M, q
    if start is not None:
        z[:n] = start
    vectors, table, basis = newton_workspace(capacity)
    result = min_map_newton(A, b, n, z, start is not None, tolerance, limit, vectors, table, basis)
    return result, z, basis[:n]


def guess_at(problem, z):
    return replace(MinMapNewton().solve(problem), z=np.array(z, dtype=float), active=None, keys=None)


class TestAnswers:
    @pytest.mark.parametrize("n", [1, 3, 10, 40])
    @pytest.mark.parametrize("seed", range(3))
    def test_definite_problems(self, n, seed):
        problem, z = definite(n, seed)
        solution = MinMapNewton().solve(problem)
        assert solution.status is Status.SOLVED
        assert solution.route == "min-map Newton"
        assert solution.z == pytest.approx(z, abs=1e-9)
        assert solution.active.tolist() == (z > 0.0).astype(int).tolist()

    @pytest.mark.parametrize("n", [4, 8, 30])
    def test_murty(self, n):
        M = np.tril(2.0 * np.ones((n, n)), -1) + np.eye(n)
        solution = MinMapNewton().solve(Lcp(M, -np.ones(n)))
        assert solution.solved
        assert solution.z == pytest.approx(np.eye(n)[0], abs=1e-12)

    def test_one_linear_system_takes_one_step_or_two(self):
        # All basic: from z = 0 all rows have d z = 0 > w = q, so that the first step solves M z = -q.
        solution = MinMapNewton().solve(Lcp([[2.0, 1.0], [1.0, 2.0]], [-5.0, -6.0]))
        assert solution.z == pytest.approx([4 / 3, 7 / 3], rel=1e-14)
        assert solution.iterations == 1

    def test_a_point_near_the_solution_takes_one_step(self):
        problem, z = definite(30, 1)
        rng = np.random.default_rng(0)
        near = guess_at(problem, np.maximum(z + 1e-3 * rng.standard_normal(30) * (z > 0.0), 0.0))
        warm = MinMapNewton().solve(problem, near)
        assert warm.iterations == 1
        assert warm.iterations < MinMapNewton().solve(problem).iterations
        assert warm.z == pytest.approx(z, abs=1e-10)

    def test_reaches_what_is_not_definite(self):
        # Lemke's path ends on a ray here: w1 = -2 z1 + 2 z2 - 1, w2 = 1 - 2 z2, solved by (0, 1/2).
        solution = MinMapNewton().solve(Lcp([[-2.0, 2.0], [0.0, -2.0]], [-1.0, 1.0]))
        assert solution.solved
        assert solution.z == pytest.approx([0.0, 0.5], abs=1e-14)

    def test_friction(self):
        # A point of 1 kg with (0.3, -1) m/s: sticks for mu = 0.5, slides for mu = 0.1.
        for mu, tangential in ((0.5, -0.3), (0.1, -0.1)):
            problem = ContactProblem(np.eye(2), [-1.0, 0.3], [mu])
            solution = MinMapNewton().solve(problem)
            assert solution.solved
            assert [float(f[0]) for f in problem.forces(solution.z)] == pytest.approx([1.0, tangential], rel=1e-12)

    @pytest.mark.parametrize("n", [2, 5])
    def test_a_singular_matrix(self, n):
        solution = MinMapNewton().solve(Lcp(2.0 * np.ones((n, n)), -3.0 * np.ones(n)))
        assert solution.solved
        assert solution.z.sum() == pytest.approx(1.5, rel=1e-12)

    def test_rows_of_any_size(self):
        problem, z = definite(8, 4)
        rows = 10.0 ** np.linspace(-6, 6, 8)
        # d_i is as large as the row, so that rows in other units give the same steps.
        results = [
            run_kernel(problem.M * row[:, None], problem.q * row, tolerance=1e-14, limit=200) for row in (rows, rows**0)
        ]
        for (status, _), found, _ in results:
            assert status == Status.SOLVED
            assert found == pytest.approx(z, rel=1e-6)


class TestMerit:
    """1/2 |min(d z, w) / d|^2 must fall in each damped step, by the part promised."""

    @staticmethod
    def iterate(problem, start, full, count):
        """Merits after each step, and the lengths that were reached, from kernels called one by one."""
        M, q = problem._data
        n = len(q)
        vectors, table, basis = newton_workspace(n)
        d, w, target, shifted, trial, z = vectors
        begin(M, q, n, 0, d, z)
        z[:] = start
        merits = [min_map(M, q, n, z, d, w)]
        for _ in range(count):
            newton_point(M, q, n, z, d, w, 0.0, target, shifted, table, basis)
            before, goal = z.copy(), target.copy()
            reached = step(M, q, n, z, d, merits[-1], full, target, trial, w)
            if reached < 0.0:
                assert z.tolist() == before.tolist()  # a refused step leaves the point where it was
                break
            length = np.linalg.norm(z - before) / max(np.linalg.norm(goal - before), 1e-300)
            merits.append(reached)
            yield merits[-2], merits[-1], length, z.copy()
            if reached < 1e-24:
                break

    @pytest.mark.parametrize("seed", range(6))
    def test_falls_in_every_damped_step(self, seed):
        rng = np.random.default_rng(seed)
        problem, _ = definite(12, seed)
        steps = list(self.iterate(problem, 5.0 * rng.standard_normal(12), False, 60))
        assert steps
        for before, after, length, z in steps:
            assert after <= (1.0 - 1e-4 * min(length, 1.0)) * before * (1.0 + 1e-12)
            assert after == pytest.approx(self.merit(problem, z), rel=1e-10, abs=1e-28)

    @staticmethod
    def merit(problem, z):
        d = np.abs(problem.M).max(axis=1)
        return 0.5 * (np.minimum(z, (problem.M @ z + problem.q) / d) ** 2).sum()

    def test_by_hand(self):
        # M = diag(2, 4), q = (-2, 4), z = (3, 1): d = (2, 4), w = (4, 8), min(d z, w) / d = (2, 1).
        M, q, z = np.diag([2.0, 4.0]), np.array([-2.0, 4.0]), np.array([3.0, 1.0])
        d, w = np.zeros(2), np.zeros(2)
        begin(M, q, 2, 0, d, np.zeros(2))
        assert min_map(M, q, 2, z, d, w) == 2.5
        assert d.tolist() == [2.0, 4.0]
        assert w.tolist() == [4.0, 8.0]

    def test_a_step_that_is_cut(self):
        # Towards (-8, 0) from (1, 0) with M = 1, q = 0: the merit 1/2 z^2 is 32 there, falls first at length 1/8.
        M, q, d = np.eye(1), np.zeros(1), np.ones(1)
        z, w, trial = np.array([1.0]), np.zeros(1), np.zeros(1)
        merit = step(M, q, 1, z, d, 0.5, False, np.array([-8.0]), trial, w)
        assert z.tolist() == [1.0 - 9.0 / 8.0]
        assert merit == 0.5 * 0.125**2
        z[:] = 1.0
        assert step(M, q, 1, z, d, 0.5, True, np.array([-8.0]), trial, w) == 32.0  # a full step is allowed to
        assert z.tolist() == [-8.0]

    def test_no_length_helps(self):
        z, w, trial = np.array([1.0]), np.zeros(1), np.zeros(1)
        assert step(np.eye(1), np.zeros(1), 1, z, np.ones(1), 0.5, False, np.array([2.0]), trial, w) == -1.0
        assert z.tolist() == [1.0]

    def test_the_proximal_point(self):
        # (M + r D) z + q - r D z_k = 0: (2 + 3 * 2) z - 6 - 3 * 2 * 5 = 0.
        M, q, z, d = np.array([[2.0]]), np.array([-6.0]), np.array([5.0]), np.array([2.0])
        w, target, shifted = np.array([4.0]), np.zeros(1), np.zeros(1)
        _, table, basis = newton_workspace(1)
        newton_point(M, q, 1, z, d, w, 3.0, target, shifted, table, basis)
        assert target.tolist() == [4.5]


class TestHonesty:
    @pytest.mark.parametrize("limit", [1, 2, 5])
    def test_the_limit_is_reported(self, limit):
        solution = MinMapNewton(iteration_limit=limit).solve(UNSOLVABLE)
        assert solution.status is Status.ITERATION_LIMIT
        assert solution.iterations == limit
        assert solution.residual == UNSOLVABLE.residual(solution.z)
        assert solution.active is None
        assert "iteration limit" in solution.message

    def test_more_iterations_help(self):
        problem, z = definite(40, 2)
        needed = MinMapNewton().solve(problem).iterations
        assert needed > 1
        few = MinMapNewton(iteration_limit=needed - 1).solve(problem)
        assert few.status is Status.ITERATION_LIMIT
        enough = MinMapNewton(iteration_limit=needed).solve(problem)
        assert enough.solved
        assert enough.z == pytest.approx(z, abs=1e-9)

    def test_the_limit_by_default_grows_with_the_problem(self):
        # Many copies of what has no solution: 200 + n iterations at most.
        n = 30
        M, q = np.kron(np.eye(n // 2), UNSOLVABLE.M), np.tile(UNSOLVABLE.q, n // 2)
        solution = MinMapNewton().solve(Lcp(M, q))
        assert not solution.solved
        assert solution.iterations <= 200 + n

    @pytest.mark.parametrize("problem", [UNSOLVABLE, Lcp([[-1.0]], [-1.0]), Lcp(np.zeros((2, 2)), [-1.0, 1.0])])
    def test_never_solved_and_never_worse_than_zero(self, problem):
        solution = MinMapNewton().solve(problem)
        assert not solution.solved
        assert np.isfinite(solution.z).all()
        assert (solution.z >= 0.0).all()
        assert solution.residual <= problem.residual(np.zeros(problem.size))

    @pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
    def test_a_guess_that_is_not_finite_is_left_aside(self, bad):
        problem, z = definite(6, 3)
        cold = MinMapNewton().solve(problem)
        warm = MinMapNewton().solve(problem, guess_at(problem, np.where(np.arange(6) == 2, bad, z)))
        assert warm.z.tobytes() == cold.z.tobytes()
        assert warm.iterations == cold.iterations

    def test_a_guess_of_another_size_is_left_aside(self):
        problem, _ = definite(6, 3)
        cold, other = MinMapNewton().solve(problem), MinMapNewton().solve(definite(5, 0)[0])
        assert MinMapNewton().solve(problem, other).z.tobytes() == cold.z.tobytes()

    @pytest.mark.parametrize("size", [1e160, 1e300])
    def test_a_guess_that_overflows_falls_back_to_the_other_starts(self, size):
        problem, z = definite(6, 3)
        warm = MinMapNewton().solve(problem, guess_at(problem, np.full(6, size)))
        assert warm.solved
        assert warm.z == pytest.approx(z, abs=1e-9)

    @pytest.mark.parametrize("place", ["M", "q", "z"])
    @pytest.mark.parametrize("bad", [np.nan, np.inf])
    def test_a_kernel_given_nan_ends_unsolved(self, place, bad):
        M, q, start = np.eye(3), -np.ones(3), np.full(3, 0.5)
        if place == "M":
            M[1, 2] = bad
        elif place == "q":
            q[1] = bad
        else:
            start[1] = bad
        (status, count), z, _ = run_kernel(M, q, start)
        assert count <= 100
        if place == "z":  # another start solves the problem
            assert status == Status.SOLVED
            assert z == pytest.approx(np.ones(3), rel=1e-14)
        else:
            assert status != Status.SOLVED

    def test_the_leading_block_counts_alone(self):
        problem, z = definite(5, 1)
        small, padded = run_kernel(problem.M, problem.q), run_kernel(problem.M, problem.q, capacity=9)
        assert small[0] == padded[0]
        assert small[1].tobytes() == padded[1][:5].tobytes()
        assert padded[1][:5] == pytest.approx(z, abs=1e-9)
        assert np.isnan(padded[1][5:]).all()

    def test_the_problem_is_left_as_it_was(self):
        M, q = np.array([[2.0, 1.0], [1.0, 2.0]]), np.array([-5.0, -6.0])
        before = M.tobytes(), q.tobytes()
        z = np.zeros(2)
        min_map_newton(M, q, 2, z, False, 1e-10, 50, *newton_workspace(2))
        assert (M.tobytes(), q.tobytes()) == before
