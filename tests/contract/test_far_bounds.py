"""Bounds that are far away next to the answer: they must hide no error, and cost no accuracy."""

import numpy as np
import pytest

from lcpflex.solvers import Auto, BoxedLcp, Enumeration, GaussSeidel, Lcp, Lemke, MixedLcp, Status

INF = np.inf


def error(problem: BoxedLcp, z: np.ndarray) -> float:
    """max d |z - mid(lower, z - w / d, upper)| relative to |q|, or to what keeps z from 0."""
    w, d = problem.M @ z + problem.q, np.abs(problem.M).max(axis=1)
    rest = np.clip(0.0, problem.lower, problem.upper)
    load = max(np.abs(problem.q).max(), (d * np.abs(rest)).max())
    return float((d * np.abs(z - np.clip(z - w / d, problem.lower, problem.upper))).max() / load)


def random_matrix(rng, n, symmetric):
    A = rng.standard_normal((n, n))
    return A @ A.T / n + 0.1 * np.eye(n) + (0.0 if symmetric else A - A.T)


class TestOneUnknown:
    @pytest.mark.parametrize("far", [1e3, 1e6, 1e9, 1e12, 1e18, 1e20, 1e300])
    @pytest.mark.parametrize("size", [1e-8, 1.0, 1e8])
    def test_by_hand_whichever_bound_is_far(self, far, size):
        bounds = [(-far, far), (-far, INF), (-far, 2.0), (0.0, far), (0.5, far), (-far, 0.5), (-far, -0.5), (-INF, far)]
        for lower, upper in bounds:
            solution = Auto().solve(BoxedLcp([[size]], [-size], lower, upper))
            assert solution.status is Status.SOLVED
            assert solution.z == pytest.approx(np.clip([1.0], lower, upper), rel=1e-14)

    def test_moderate_bounds_are_far_from_a_small_load(self):
        solution = Auto().solve(BoxedLcp([[1e8]], [-1e-8], -1.0, 1.0))
        assert solution.solved
        assert solution.z == pytest.approx([1e-16], rel=1e-9, abs=0.0)

    @pytest.mark.parametrize("far", [1.0, 1e12, 1e20])
    def test_the_residual_does_not_see_bounds_that_are_not_reached(self, far):
        problem = BoxedLcp([[1.0]], [-1.0], -far, 2.0 * far)
        assert problem.residual([0.0]) == 1.0
        assert problem.residual([1.0]) == 0.0
        assert problem.residual([1.0 + 1e-4]) == pytest.approx(1e-4, rel=1e-9)

    def test_bounds_that_keep_the_unknown_from_zero_are_load(self):
        problem = BoxedLcp([[2.0]], [-1.0], 50.0, 1e20)  # d |mid| = 100
        assert problem.residual([50.0]) == 0.0
        assert problem.residual([49.0]) == pytest.approx(2.0 / 100.0, rel=1e-14)

    @pytest.mark.parametrize("load", [1e6, 1e12, 1e18, 1e100, 1e300])
    def test_narrow_boxes_beside_a_large_load(self, load):
        for side in (1.0, -1.0):
            assert Auto().solve(BoxedLcp([[1.0]], [-side * load], -1.0, 1.0)).z == pytest.approx([side], rel=1e-12)

    def test_bounds_that_are_far_and_reached(self):
        solution = Enumeration().solve(BoxedLcp([[-1.0]], [0.5], -1e14, 1e14))
        assert solution.status is Status.NOT_UNIQUE
        assert sorted(float(z[0]) for z in solution.solutions) == [-1e14, 0.5, 1e14]
        assert Auto().solve(BoxedLcp([[0.0]], [-1.0], -1e20, 1e20)).z.tolist() == [1e20]


class TestWithoutLoad:
    """q = 0: zero is a solution wherever the box holds it, and rounding is no infinite error."""

    @pytest.mark.parametrize("far", [1.0, 1e12, 1e20])
    @pytest.mark.parametrize("n", [1, 2, 7])
    def test_zero_exactly(self, far, n):
        rng = np.random.default_rng(n)
        M = random_matrix(rng, n, True)
        bound = far * rng.uniform(0.3, 1.0, n)
        for solver in (Auto(), Lemke(), GaussSeidel()):
            solution = solver.solve(BoxedLcp(M, np.zeros(n), -bound, 0.7 * bound))
            assert solution.solved
            assert np.abs(solution.z).max() == 0.0

    def test_what_moves_nothing_solves_it_too(self):
        problem = BoxedLcp([[0.1, 0.3], [0.1, 0.3]], [0.0, 0.0], -1.0, 1.0)
        assert problem.residual([0.9, -0.3]) < 1e-15
        assert problem.residual([0.9, -0.3 + 1e-12]) == INF
        assert problem.residual([0.0, 0.0]) == 0.0


class TestMany:
    @pytest.mark.parametrize("symmetric", [True, False], ids=["symmetric", "unsymmetric"])
    @pytest.mark.parametrize("decades", [0.0, 8.0], ids=["one unit", "units apart"])
    def test_far_bounds_are_as_good_as_none(self, symmetric, decades):
        for seed in range(40):
            rng = np.random.default_rng(seed)
            n = int(rng.integers(1, 31))
            M, q = random_matrix(rng, n, symmetric), rng.standard_normal(n)
            lower = rng.uniform(-2.0, 0.5, n)
            upper = lower + rng.uniform(0.1, 2.0, n)
            kind = rng.integers(0, 5, n)
            lower[kind < 2], upper[(kind == 0) | (kind == 2)] = -INF, INF
            plain = Auto().solve(BoxedLcp(M, q, lower, upper))
            stiffness, load = 10.0 ** rng.uniform(-8.0, 8.0, 2)
            units = 10.0 ** rng.uniform(-0.5 * decades, 0.5 * decades, n)
            far, size = 10.0 ** rng.uniform(6.0, 18.0), units * load / stiffness
            low, high = size * np.maximum(lower, -far), size * np.minimum(upper, far)
            solution = Auto().solve(BoxedLcp(stiffness * M / np.outer(units, units), load * q / units, low, high))
            assert plain.solved
            assert solution.solved
            assert solution.z / size == pytest.approx(plain.z, abs=1e-9)
            assert solution.w * units / load == pytest.approx(plain.w, abs=1e-9)

    @pytest.mark.slow
    @pytest.mark.parametrize("matrix", ["definite", "semidefinite", "any"])
    def test_right_or_not_called_solved(self, matrix):
        solved = 0
        for seed in range(60):
            rng = np.random.default_rng(seed)
            n = int(rng.integers(1, 16))
            A = rng.standard_normal((n, n if matrix != "semidefinite" else max(1, n - 2)))
            M = A if matrix == "any" else A @ A.T + (matrix == "definite") * 0.1 * np.eye(n)
            M, q = M * 10.0 ** rng.uniform(-8.0, 8.0), rng.standard_normal(n) * 10.0 ** rng.uniform(-8.0, 8.0)
            if seed % 2:
                q = M @ rng.standard_normal(n)
            lower, upper = -(10.0 ** rng.uniform(-2.0, 18.0, n)), 10.0 ** rng.uniform(-2.0, 18.0, n)
            lower[rng.random(n) < 0.2], upper[rng.random(n) < 0.2] = 0.0, INF
            problem = BoxedLcp(M, q, lower, upper)
            solution = Auto().solve(problem)
            if solution.solved:
                solved += 1
                assert error(problem, solution.z) <= 1.01e-9
        assert solved >= (60 if matrix == "definite" else 42)

    def test_units_change_neither_residual_nor_answer(self):
        rng = np.random.default_rng(3)
        n = 6
        M, q = random_matrix(rng, n, True), rng.standard_normal(n)
        lower, upper = np.array([-1e9, 0.0, -0.3, -1e15, -INF, 0.2]), np.array([1e7, 1e12, 0.3, 0.1, 0.5, 1e9])
        plain, z = BoxedLcp(M, q, lower, upper), rng.standard_normal(n)
        units = 10.0 ** np.array([-6.0, 4.0, 0.0, 3.0, -3.0, 6.0])
        scaled = BoxedLcp(M / np.outer(units, units), q / units, lower * units, upper * units)
        diagonal = 1.0 / np.sqrt(np.diag(M))
        alike = BoxedLcp(M * np.outer(diagonal, diagonal), q * diagonal, lower / diagonal, upper / diagonal)
        assert scaled.residual(z * units) == pytest.approx(alike.residual(z / diagonal), rel=1e-9)
        assert Auto().solve(scaled).z / units == pytest.approx(Auto().solve(plain).z, rel=1e-10, abs=1e-13)

    def test_the_residual_is_that_of_the_lcp_in_any_units(self):
        rng = np.random.default_rng(4)
        units = 10.0 ** rng.uniform(-4.0, 4.0, 5)
        for symmetric in (True, False):
            M, q = random_matrix(rng, 5, symmetric) * np.outer(units, units), units * rng.standard_normal(5)
            z = np.abs(rng.standard_normal(5)) / units
            expected = Lcp(M, q).residual(z)
            assert BoxedLcp(M, q, 0.0, INF).residual(z) == pytest.approx(expected, rel=1e-12)
            assert MixedLcp(M, q, []).residual(z) == pytest.approx(expected, rel=1e-12)
