"""Mixed and boxed problems against all partitions of their unknowns, against scipy, and by hand."""

import itertools
from dataclasses import replace

import numpy as np
import pytest
import scipy.optimize

from lcpflex.errors import ModelError
from lcpflex.solvers import (
    Auto,
    BoxedLcp,
    ContactProblem,
    Enumeration,
    GaussSeidel,
    Lcp,
    Lemke,
    MixedLcp,
    PrincipalPivoting,
    Status,
)

INF = np.inf


def all_solutions(problem: BoxedLcp) -> list[np.ndarray]:
    """Every solution with a regular set of inner unknowns, by trying each unknown below, within and above."""
    n, found = problem.size, []
    for places in itertools.product((-1, 0, 1), repeat=n):
        place = np.array(places)
        z = np.where(place < 0, problem.lower, problem.upper)
        inner = place == 0
        z[inner] = 0.0
        if not np.isfinite(z).all():
            continue
        block = problem.M[np.ix_(inner, inner)]
        if inner.any():
            if np.linalg.matrix_rank(block) < inner.sum():
                continue
            z[inner] = np.linalg.solve(block, -(problem.M @ z + problem.q)[inner])
        w = problem.M @ z + problem.q
        within = (problem.lower - 1e-9 <= z).all() and (z <= problem.upper + 1e-9).all()
        signs = (w[place < 0] >= -1e-9).all() and (w[place > 0] <= 1e-9).all()
        if within and signs and not any(np.allclose(z, other, atol=1e-7) for other in found):
            found.append(z)
    return found


def random_bounds(rng, n):
    """Bounds of every kind: none, one, two, and two that coincide."""
    lower = rng.uniform(-2.0, 0.5, n)
    upper = lower + rng.uniform(0.1, 2.0, n)
    kind = rng.integers(0, 5, n)
    lower[(kind == 0) | (kind == 1)] = -INF
    upper[(kind == 0) | (kind == 2)] = INF
    upper[kind == 4] = lower[kind == 4]
    return lower, upper


class TestBoxed:
    @pytest.mark.parametrize("symmetric", [True, False], ids=["symmetric", "unsymmetric"])
    @pytest.mark.parametrize("seed", range(8))
    def test_the_one_solution_of_a_definite_problem(self, seed, symmetric):
        rng = np.random.default_rng(seed)
        n = int(rng.integers(1, 6))
        A = rng.standard_normal((n, n))
        M = A @ A.T + 0.3 * np.eye(n) + (0.0 if symmetric else A - A.T)
        problem = BoxedLcp(M, 2.0 * rng.standard_normal(n), *random_bounds(rng, n))
        (expected,) = all_solutions(problem)
        for solver in (Auto(), Lemke()):
            solution = solver.solve(problem)
            assert solution.status is Status.SOLVED
            assert solution.z == pytest.approx(expected, abs=1e-10)
            assert solution.w == pytest.approx(M @ expected + problem.q, abs=1e-9)

    @pytest.mark.parametrize("seed", range(4))
    def test_least_squares_between_bounds_as_scipy_has_it(self, seed):
        rng = np.random.default_rng(seed)
        A, b = rng.standard_normal((30, 12)), 3.0 * rng.standard_normal(30)
        lower, upper = random_bounds(rng, 12)
        upper = np.where(upper == lower, upper + 0.1, upper)  # scipy wants lower < upper
        reference = scipy.optimize.lsq_linear(A, b, (lower, upper), method="bvls", tol=1e-14)
        solution = Auto().solve(BoxedLcp(A.T @ A, -A.T @ b, lower, upper))
        assert solution.solved
        assert solution.z == pytest.approx(reference.x, abs=1e-9)

    @pytest.mark.parametrize(("q", "z", "w"), [(-5.0, 1.5, -2.0), (1.0, -0.5, 0.0), (6.0, -1.0, 4.0), (-3.0, 1.5, 0.0)])
    def test_one_unknown_by_hand(self, q, z, w):
        # w = 2 z + q, -1 <= z <= 1.5: pushed against the upper bound, free, against the lower, just at the upper.
        solution = Auto().solve(BoxedLcp([[2.0]], [q], -1.0, 1.5))
        assert solution.z == pytest.approx([z], abs=1e-14)
        assert solution.w == pytest.approx([w], abs=1e-14)

    @pytest.mark.parametrize(
        ("lower", "upper", "z"),
        [
            (-INF, INF, 3.0),
            (0.0, INF, 3.0),
            (-INF, 4.0, 3.0),
            (-INF, 1.0, 1.0),
            (5.0, INF, 5.0),
            (-2.0, -2.0, -2.0),
            (7.0, 7.0, 7.0),
            (3.0, 3.0, 3.0),
        ],
    )
    def test_bounds_of_every_kind(self, lower, upper, z):
        solution = Auto().solve(BoxedLcp([[2.0]], [-6.0], lower, upper))
        assert solution.solved
        assert solution.z == pytest.approx([z], abs=1e-14)

    def test_equal_bounds_fix_the_unknown(self):
        # z1 = 2 whatever its w; then 3 z2 + 1 * 2 - 8 = 0.
        solution = Auto().solve(BoxedLcp([[4.0, 1.0], [1.0, 3.0]], [-100.0, -8.0], [2.0, 0.0], [2.0, INF]))
        assert solution.z == pytest.approx([2.0, 2.0], rel=1e-13)
        assert solution.w == pytest.approx([-90.0, 0.0], abs=1e-11)

    def test_zero_and_infinity_are_an_lcp(self):
        M, q = np.array([[1.0, -3.0], [3.0, 1.0]]), np.array([1.0, -4.0])
        boxed, plain = BoxedLcp(M, q, 0.0, INF), Lcp(M, q)
        assert boxed.lcp().M.tolist() == M.tolist()
        assert boxed.lcp().q.tolist() == q.tolist()
        for z in ([1.5, 0.5], [0.0, 4.0], [-1.0, 2.0], [0.3, 0.0]):
            for scaled in (True, False):
                assert boxed.residual(z, scaled) == pytest.approx(plain.residual(z, scaled), rel=1e-14, abs=1e-16)

    def test_residual_by_hand(self):
        # d = 2; z - w / d = 1 - (2 - 5) / 2 = 2.5, cut to 1.5: 2 |1 - 1.5| = 1 in the units of q, and 1 / |q| = 0.2.
        problem = BoxedLcp([[2.0]], [-5.0], -1.0, 1.5)
        assert problem.residual([1.0], scaled=False) == pytest.approx(1.0, rel=1e-15)
        assert problem.residual([1.0]) == pytest.approx(0.2, rel=1e-15)
        assert problem.residual([1.5]) == 0.0
        assert problem.residual([1.7], scaled=False) == pytest.approx(0.4, rel=1e-14)  # outside by 0.2, d = 2
        assert problem.residual([np.nan]) == problem.residual([INF]) == INF

    def test_tresca_friction_does_not_depend_on_the_pressure(self):
        # A point of 2 kg with (0.3, -1) m/s, friction impulse within +-0.4 N s: G = I / 2.
        problem = BoxedLcp(0.5 * np.eye(2), [-1.0, 0.3], [0.0, -0.4], [INF, 0.4])
        solution = Auto().solve(problem)
        assert solution.z == pytest.approx([2.0, -0.4], rel=1e-14)
        assert solution.w == pytest.approx([0.0, 0.1], abs=1e-15)

    def test_all_solutions_come_back_in_the_unknowns_of_the_problem(self):
        # w = -(z - 1/2) on [0, 1]: both ends and the middle.
        solution = Enumeration().solve(BoxedLcp([[-1.0]], [0.5], 0.0, 1.0))
        assert solution.status is Status.NOT_UNIQUE
        assert sorted(float(z[0]) for z in solution.solutions) == pytest.approx([0.0, 0.5, 1.0], abs=1e-14)

    def test_an_upper_bound_only_is_mirrored(self):
        shifted = Enumeration().solve(BoxedLcp([[-1.0]], [0.5], -INF, 1.0))  # z = 1 with w < 0, or z = 1/2
        assert sorted(float(z[0]) for z in shifted.solutions) == pytest.approx([0.5, 1.0], abs=1e-14)

    def test_a_guess_of_the_same_kind_saves_the_pivots(self):
        rng = np.random.default_rng(2)
        A = rng.standard_normal((10, 10))
        M, q = A @ A.T + np.eye(10), 3.0 * rng.standard_normal(10)
        before = BoxedLcp(M, q, -0.5, 0.5)
        first = Lemke().solve(before)
        after = BoxedLcp(M, 1.001 * q, -0.5, 0.5)
        cold, warm = Lemke().solve(after), Lemke().solve(after, first)
        assert warm.iterations < cold.iterations
        assert warm.z == pytest.approx(cold.z, abs=1e-12)
        assert 0 < np.count_nonzero(np.abs(np.abs(cold.z) - 0.5) < 1e-12) < 10  # some at their bounds, some not

    @pytest.mark.parametrize("free", [False, True], ids=["bounded", "some free"])
    def test_a_solution_is_a_guess_without_error(self, free):
        # Brought to the unknowns of the LCP, multipliers of upper bounds included: no sweep is needed.
        rng = np.random.default_rng(6)
        A = rng.standard_normal((8, 8))
        lower, upper = np.full(8, -0.5), np.where(np.arange(8) % 2, INF, 0.5)
        lower[3], upper[3] = (-INF, INF) if free else (-INF, 0.2)
        problem = BoxedLcp(A @ A.T + np.eye(8), 5.0 * rng.standard_normal(8), lower, upper)
        solution = Auto().solve(problem)
        assert (solution.w < -0.1).any()
        assert (solution.w > 0.1).any()
        again = GaussSeidel().solve(problem, solution)
        assert again.solved
        assert again.iterations == 0
        assert again.z == pytest.approx(solution.z, abs=1e-13)

    @pytest.mark.parametrize("bad", [np.full(2, np.nan), np.full(2, INF), np.zeros(3)])
    def test_a_bad_guess_does_no_harm(self, bad):
        problem = BoxedLcp([[2.0, 1.0], [1.0, 2.0]], [-5.0, -6.0], 0.0, 1.0)
        guess = replace(Auto().solve(problem), z=bad, w=bad, active=None)
        assert Auto().solve(problem, guess).z == pytest.approx([1.0, 1.0], abs=1e-14)

    @pytest.mark.parametrize(
        ("lower", "upper", "said"),
        [
            ([1.0, 0.0], [0.0, 1.0], r"lower\[0\] is 1.0, upper\[0\] is 0.0"),
            ([np.nan, 0.0], 1.0, "lower is"),
            (0.0, [1.0, np.nan], "upper is"),
            ([0.0, 0.0, 0.0], 1.0, r"lower has shape \(3,\)"),
            (0.0, [[1.0]], r"upper has shape \(1, 1\)"),
            ([INF, 0.0], INF, r"lower\[0\] is inf"),
            (-INF, [0.0, -INF], r"upper\[1\] is -inf"),
        ],
    )
    def test_refuses_bounds_that_are_none(self, lower, upper, said):
        with pytest.raises(ModelError, match=said):
            BoxedLcp(np.eye(2), np.zeros(2), lower, upper)

    def test_refuses_points_and_sizes_that_do_not_fit(self):
        with pytest.raises(ModelError, match=r"z has shape \(3,\)"):
            BoxedLcp(np.eye(2), np.zeros(2), 0.0, 1.0).residual(np.zeros(3))
        with pytest.raises(ModelError, match=r"M has shape \(2, 2\)"):
            BoxedLcp(np.eye(2), np.zeros(3), 0.0, 1.0)

    def test_arguments_are_copied(self):
        M, lower = np.eye(2), np.zeros(2)
        problem = BoxedLcp(M, -np.ones(2), lower, 5.0)
        M[:], lower[:] = 9.0, 9.0
        assert Auto().solve(problem).z == pytest.approx([1.0, 1.0], rel=1e-14)

    def test_nothing_to_solve(self):
        solution = Auto().solve(BoxedLcp(np.zeros((0, 0)), [], [], []))
        assert solution.solved
        assert solution.z.shape == (0,)


class TestMixed:
    @pytest.mark.parametrize("seed", range(8))
    def test_the_one_solution_of_a_definite_problem(self, seed):
        rng = np.random.default_rng(50 + seed)
        n = int(rng.integers(2, 8))
        A = rng.standard_normal((n, n))
        M, q = A @ A.T + 0.3 * np.eye(n) + (seed % 2) * (A - A.T), 2.0 * rng.standard_normal(n)
        free = rng.random(n) < 0.5
        (expected,) = all_solutions(BoxedLcp(M, q, np.where(free, -INF, 0.0), INF))
        for mask in (free, np.flatnonzero(free)):
            solution = Auto().solve(MixedLcp(M, q, mask))
            assert solution.status is Status.SOLVED
            assert solution.z == pytest.approx(expected, abs=1e-10)
            assert solution.w[free] == pytest.approx(np.zeros(free.sum()), abs=1e-10)

    def test_all_free_is_a_linear_system_and_none_free_an_lcp(self):
        M, q = np.array([[4.0, 1.0], [2.0, 3.0]]), np.array([1.0, -2.0])
        assert Auto().solve(MixedLcp(M, q, [0, 1])).z == pytest.approx(np.linalg.solve(M, -q), rel=1e-14)
        assert Auto().solve(MixedLcp(M, q, [])).z == pytest.approx([0.0, 2 / 3], rel=1e-14)

    @pytest.mark.parametrize("push", [-3.0, 0.5])
    def test_saddle_point_of_a_quadratic_program(self, push):
        # min 1/2 (x - a)^2 + 1/2 (y - b)^2 with x + y = 1, x, y >= 0: the projection of (a, b) on a segment.
        a, b = push, 1.0
        M = np.array([[1.0, 0.0, 1.0], [0.0, 1.0, 1.0], [-1.0, -1.0, 0.0]])
        solution = Auto().solve(MixedLcp(M, [-a, -b, 1.0], [2]))
        x = min(max(0.5 * (1.0 + a - b), 0.0), 1.0)
        assert solution.solved
        assert solution.z[:2] == pytest.approx([x, 1.0 - x], abs=1e-13)
        assert solution.z[2] == pytest.approx(b - (1.0 - x), abs=1e-13)

    def test_saddle_point_with_all_primal_unknowns_free(self):
        # min 1/2 |x - c|^2 with A x <= b: free x, multipliers >= 0. Against the dual solved by scipy's nnls.
        rng = np.random.default_rng(8)
        A, b, c = rng.standard_normal((6, 4)), rng.uniform(0.1, 0.5, 6), 3.0 * rng.standard_normal(4)
        M = np.block([[np.eye(4), A.T], [-A, np.zeros((6, 6))]])
        solution = Auto().solve(MixedLcp(M, np.concatenate([-c, b]), np.arange(4)))
        # min |x - c| with A x <= b as the least-distance problem of Lawson & Hanson.
        E = np.vstack([-A.T, (A @ c - b)[None]])
        u, _ = scipy.optimize.nnls(E, np.concatenate([np.zeros(4), [1.0]]))
        r = E @ u - np.concatenate([np.zeros(4), [1.0]])
        assert solution.solved
        assert solution.z[:4] == pytest.approx(c - r[:4] / r[4], abs=1e-9)

    def test_elimination_keeps_symmetry(self):
        # A bilateral joint and contacts: the Schur complement goes to principal pivoting, not to Lemke.
        rng = np.random.default_rng(3)
        rows = rng.standard_normal((7, 9))
        problem = MixedLcp(rows @ rows.T, rng.standard_normal(7) - 1.0, [0, 1, 2])
        assert problem.lcp().size == 4
        assert problem.lcp().symmetric
        G = problem.M
        complement = G[3:, 3:] - G[3:, :3] @ np.linalg.solve(G[:3, :3], G[:3, 3:])
        assert np.abs(problem.lcp().M - complement).max() < 1e-11
        assert Auto().solve(problem).route == "principal pivoting"
        assert PrincipalPivoting().solve(problem).solved

    @pytest.mark.parametrize("copies", [2, 5])
    def test_redundant_bilateral_rows_share_the_force(self, copies):
        # The same joint row written several times: the shortest multipliers are equal shares.
        row, contact, velocity = np.array([1.0, 0.0]), np.array([1.0, 1.0]), np.array([0.6, -2.0])
        rows = np.vstack([np.tile(row, (copies, 1)), contact])
        solution = Auto().solve(MixedLcp(rows @ rows.T, rows @ velocity, np.arange(copies)))
        # Joint: vx = 0. Contact: vx + vy >= 0 with vy = -2: p = 2, and the joint takes 0.6 + 2.
        assert solution.solved
        assert solution.z == pytest.approx([-2.6 / copies] * copies + [2.0], rel=1e-12)
        assert solution.w == pytest.approx(np.zeros(copies + 1), abs=1e-12)

    @pytest.mark.parametrize("seed", range(6))
    def test_contacts_of_a_body_that_joints_hold(self, seed):
        # Nothing moves, whatever presses: no rounding of the elimination may pass for a push that nothing resists.
        rng = np.random.default_rng(seed)
        joints = np.array([[2.0, 0.0, -2.0], [-2.0, -1.0, 1.0], [-1.0, 0.0, 0.0]])
        rows = np.vstack([joints, rng.integers(-2, 3, (4, 3))])
        velocity = rng.integers(-2, 3, 3).astype(float)
        problem = MixedLcp(rows @ rows.T, rows @ velocity, [0, 1, 2])
        solution = Auto().solve(problem)
        assert not problem.lcp().M.any()
        assert not problem.lcp().q.any()
        assert solution.status is Status.SOLVED
        assert solution.z[3:].tolist() == [0.0] * 4
        assert velocity + rows.T @ solution.z == pytest.approx(np.zeros(3), abs=1e-12)

    def test_rows_that_contradict_each_other(self):
        solution = Auto().solve(MixedLcp(np.ones((2, 2)), [1.0, -1.0], [0, 1]))
        assert not solution.solved
        assert "contradict" in solution.message
        assert solution.residual > 0.1

    def test_a_singular_block_that_constrains_the_others(self):
        # min z1^2 / 2 - z1 with z1 = 3 by a multiplier: M_FF = 0 cannot be eliminated.
        problem = MixedLcp([[1.0, 1.0], [-1.0, 0.0]], [-1.0, 3.0], [1])
        solution = Auto().solve(problem)
        assert solution.solved
        assert solution.z == pytest.approx([3.0, -2.0], abs=1e-13)

    def test_a_proof_passes_through(self):
        # The free z2 does not help: w1 = -z1 - 1 < 0.
        solution = Auto().solve(MixedLcp([[-1.0, 0.0], [0.0, 1.0]], [-1.0, 5.0], [1]))
        assert solution.status is Status.INFEASIBLE
        lcp = MixedLcp([[-1.0, 0.0], [0.0, 1.0]], [-1.0, 5.0], [1]).lcp()
        u = solution.certificate
        assert (u >= 0.0).all()
        assert (lcp.M.T @ u <= 0.0).all()
        assert lcp.q @ u < 0.0

    def test_units_do_not_matter(self):
        rng = np.random.default_rng(4)
        A = rng.standard_normal((6, 6))
        M, q = A @ A.T + 0.1 * np.eye(6), rng.standard_normal(6)
        units = 10.0 ** np.array([-6, 4, 0, 3, -3, 6])  # of the unknowns; power is invariant
        plain = Auto().solve(MixedLcp(M, q, [0, 1, 4]))
        scaled = Auto().solve(MixedLcp(M / np.outer(units, units), q / units, [0, 1, 4]))
        assert plain.solved
        assert scaled.z / units == pytest.approx(plain.z, rel=1e-7, abs=1e-12)

    @pytest.mark.parametrize(
        "free", [[True, False], [0, 3], [-1], [0.5], [[0]]], ids=["mask", "large", "negative", "fraction", "nested"]
    )
    def test_refuses_what_names_no_unknowns(self, free):
        with pytest.raises(ModelError, match="free"):
            MixedLcp(np.eye(3), np.zeros(3), free)

    def test_a_bilateral_joint_and_rough_contact_agree_with_contact_alone(self):
        # A contact that surely stays closed may be posed as bilateral: same force as the unilateral problem.
        G, velocity = np.array([[2.0, 0.5], [0.5, 1.0]]), np.array([-1.0, -1.0])
        unilateral = ContactProblem(G, velocity, np.zeros(2))
        closed = Auto().solve(unilateral)
        assert (closed.z > 0.0).all()
        assert Auto().solve(MixedLcp(G, velocity, [0])).z == pytest.approx(closed.z, rel=1e-13)
