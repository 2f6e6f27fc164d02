"""Exhaustive search: every solution of problems known to have several, proofs that there is none, Farkas' vector."""

import itertools

import numpy as np
import pytest

from lcpflex.errors import ModelError
from lcpflex.solvers import BoxedLcp, ContactProblem, Enumeration, Lcp, Status
from lcpflex.solvers.lcp.enumeration import KEPT, LARGEST, enumerate_active_sets, enumeration_workspace
from lcpflex.solvers.lcp.farkas import farkas


def points(solution) -> set[tuple[float, ...]]:
    """All known solutions, to ten digits."""
    return {tuple(np.round(z, 10).tolist()) for z in solution.solutions or (solution.z,)}


def run_kernel(M, q, kept=KEPT, capacity=None, tolerance=1e-10):
    n = len(q)
    capacity = capacity or n
    A, b = np.full((capacity, capacity), np.nan), np.full(capacity, np.nan)
    A[:n, :n], b[:n] = M, q
    found, codes, singular = np.zeros((kept, capacity)), np.zeros(kept, dtype=np.int64), np.zeros(8, dtype=np.int64)
    counts = enumerate_active_sets(A, b, n, tolerance, found, codes, singular, *enumeration_workspace(capacity))
    return counts, found, codes, singular


class TestAllSolutions:
    def test_the_standard_example(self):
        # Symmetric, with positive entries, indefinite: four active sets, three solutions for q = (-1, -1).
        solution = Enumeration().solve(Lcp([[1.0, 2.0], [2.0, 1.0]], [-1.0, -1.0]))
        assert solution.status is Status.NOT_UNIQUE
        assert points(solution) == {(1.0, 0.0), (0.0, 1.0), (round(1 / 3, 10), round(1 / 3, 10))}
        assert solution.iterations == 4
        assert solution.z.tolist() == [1.0, 0.0]  # the lowest active set that solves: unknown 0 alone
        assert solution.active.tolist() == [1, 0]

    @pytest.mark.parametrize("n", [1, 2, 3, 6])
    def test_two_to_the_n_solutions(self, n):
        # Each w = 1 - z by itself: z = 0 or z = 1.
        solution = Enumeration().solve(Lcp(-np.eye(n), np.ones(n)))
        assert solution.status is Status.NOT_UNIQUE
        assert points(solution) == set(itertools.product((0.0, 1.0), repeat=n))
        assert [int(z @ 2 ** np.arange(n)) for z in solution.solutions] == list(range(2**n))

    def test_no_more_are_kept_than_there_is_room_for(self):
        counts, found, codes, _ = run_kernel(-np.eye(7), np.ones(7), kept=5)
        assert counts[0] >= 5
        assert codes.tolist() == [0, 1, 2, 3, 4]
        assert found[4].tolist() == [0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0]
        solution = Enumeration().solve(Lcp(-np.eye(7), np.ones(7)))
        assert len(solution.solutions) == KEPT

    def test_painleve(self):
        # v_N = p - 2 t + 1/2, v_T = -2 p + 5 t - 3, |t| <= p: lift off; slide back with t = p = 1/2; jam at rest.
        problem = ContactProblem([[1.0, -2.0], [-2.0, 5.0]], [0.5, -3.0], [1.0])
        solution = Enumeration().solve(problem)
        forces = sorted(tuple(float(part[0]) for part in problem.forces(z)) for z in solution.solutions)
        assert solution.status is Status.NOT_UNIQUE
        assert np.array(forces) == pytest.approx(np.array([[0.0, 0.0], [0.5, 0.5], [3.5, 2.0]]), abs=1e-13)

    def test_an_open_contact_is_not_several(self):
        # Lifted off with 1 m/s while sliding back with 3 m/s: xi_L = 3 + anything solves the LCP, the forces are 0.
        problem = ContactProblem(np.eye(2), [1.0, -3.0], [0.5])
        assert Enumeration().solve(problem.lcp()).status is Status.NOT_UNIQUE
        solution = Enumeration().solve(problem)
        assert solution.status is Status.SOLVED
        assert solution.solutions == ()
        assert solution.z.tolist() == [0.0, 0.0, 3.0]
        assert solution.keys == problem.unknown_keys

    def test_one_solution_is_said_to_be_one(self):
        solution = Enumeration().solve(Lcp([[1.0, -3.0], [3.0, 1.0]], [1.0, -4.0]))
        assert solution.status is Status.SOLVED
        assert solution.solutions == ()
        assert solution.z == pytest.approx([1.1, 0.7], rel=1e-14)

    def test_a_degenerate_solution_counts_once(self):
        # z = (2, 0) with w2 = 0 belongs to two active sets.
        solution = Enumeration().solve(Lcp([[2.0, 1.0], [1.0, 2.0]], [-4.0, -2.0]))
        assert solution.status is Status.SOLVED
        assert solution.z == pytest.approx([2.0, 0.0], abs=1e-15)

    @pytest.mark.parametrize("n", [2, 3])
    def test_a_continuum_has_at_least_its_ends(self, n):
        # One mass pressed on by n equal contacts: any share of the sum 3 / 2.
        solution = Enumeration().solve(Lcp(2.0 * np.ones((n, n)), -3.0 * np.ones(n)))
        assert solution.status is Status.NOT_UNIQUE
        assert {tuple(1.5 * row) for row in np.eye(n)} <= points(solution)
        for z in solution.solutions:
            assert z.sum() == pytest.approx(1.5, rel=1e-12)

    def test_a_continuum_without_regular_basis(self):
        # w1 = z2 - 1, w2 = 1 - z2: solved by z2 = 1 with w = 0 and any z1; the block of {2} alone needs w1 >= 0 too.
        solution = Enumeration().solve(Lcp([[0.0, 1.0], [0.0, -1.0]], [-1.0, 1.0]))
        assert solution.solved
        assert solution.z[1] == pytest.approx(1.0, rel=1e-12)

    def test_only_a_singular_block_solves(self):
        # w1 = 0 always, w2 = z1 - 1: z1 = 1 with any z2, or z1 > 1 with z2 = 0. The block of {1} is zero.
        solution = Enumeration().solve(Lcp([[0.0, 0.0], [1.0, 0.0]], [0.0, -1.0]))
        assert solution.status is Status.NOT_UNIQUE
        for z in solution.solutions:
            assert z[0] >= 1.0 - 1e-12
            assert min(z[0] - 1.0, z[1]) == pytest.approx(0.0, abs=1e-12)

    @pytest.mark.parametrize("seed", range(12))
    def test_integer_problems_by_another_search(self, seed):
        rng = np.random.default_rng(seed)
        M, q = rng.integers(-3, 4, (4, 4)).astype(float), rng.integers(-3, 4, 4).astype(float)
        problem = Lcp(M, q)
        expected = set()
        for flags in itertools.product((False, True), repeat=4):
            on = np.array(flags)
            block = M[np.ix_(on, on)]
            if on.any() and abs(np.linalg.det(block)) < 0.5:  # integers: regular means at least 1
                continue
            z = np.zeros(4)
            z[on] = np.linalg.solve(block, -q[on])
            if (z >= -1e-12).all() and (M @ z + q >= -1e-12).all():
                expected.add(tuple((np.round(z, 10) + 0.0).tolist()))
        solution = Enumeration().solve(problem)
        if expected:
            assert solution.solved
            assert expected <= points(solution)
            assert all(problem.residual(z) <= 1e-10 for z in solution.solutions)
        else:
            assert solution.solved or solution.status in (Status.NO_SOLUTION, Status.INFEASIBLE)

    def test_units_do_not_change_the_count(self):
        rows, columns = np.array([1e8, 1e-6]), np.array([1e-5, 1e9])
        M = rows[:, None] * np.array([[1.0, 2.0], [2.0, 1.0]]) * columns
        counts, found, _, _ = run_kernel(M, -rows)
        assert counts == (3, 0)
        assert found[:3] * columns == pytest.approx(np.array([[1.0, 0.0], [0.0, 1.0], [1 / 3, 1 / 3]]), rel=1e-12)

    def test_units_do_not_make_a_regular_block_singular(self):
        # z = (1, 1) / units is the only solution: to miss its set would be to claim that there is none.
        rows, columns = np.array([1e6, 1e-6]), np.array([1e-9, 1e9])
        solution = Enumeration().solve(
            Lcp(rows[:, None] * np.array([[1.0, -3.0], [3.0, 1.0]]) * columns, rows * [2, -4])
        )
        assert solution.status is Status.SOLVED
        assert solution.z * columns == pytest.approx([1.0, 1.0], rel=1e-12)

    def test_the_leading_block_counts_alone(self):
        counts, found, codes, _ = run_kernel([[1.0, 2.0], [2.0, 1.0]], [-1.0, -1.0], capacity=6)
        assert counts == (3, 0)
        assert found[:3, :2] == pytest.approx(np.array([[1.0, 0.0], [0.0, 1.0], [1 / 3, 1 / 3]]), rel=1e-14)
        assert codes[:3].tolist() == [1, 2, 3]


class TestSize:
    def test_sixteen_unknowns(self):
        n = LARGEST
        assert n == 16
        M = np.tril(2.0 * np.ones((n, n)), -1) + np.eye(n)
        solution = Enumeration().solve(Lcp(M, -np.ones(n)))
        assert solution.status is Status.SOLVED
        assert solution.iterations == 65536
        assert solution.z == pytest.approx(np.eye(n)[0], abs=1e-14)

    @pytest.mark.parametrize(
        "problem",
        [
            Lcp(np.eye(17), -np.ones(17)),
            ContactProblem(np.eye(12), -np.ones(12), 0.5 * np.ones(6)),  # 18 unknowns
            BoxedLcp(np.eye(9), -np.ones(9), 0.0, 1.0),  # 9 and as many multipliers
        ],
        ids=["lcp", "contact", "boxed"],
    )
    def test_more_are_refused(self, problem):
        with pytest.raises(ModelError, match=r"unknowns, 2\^1[78] active sets.* up to 16; use Auto"):
            Enumeration().solve(problem)
        assert Enumeration().refuses(problem)
        assert not Enumeration().refuses(Lcp(np.eye(16), np.ones(16)))


class TestNoSolution:
    @pytest.mark.parametrize(
        ("M", "q"),
        [
            ([[-1.0, 2.0], [1.0, 1.0]], [-1.0, 1.0]),  # w2 > 0 makes z2 = 0, and then w1 < 0
            ([[-2.0, 2.0], [0.0, 2.0]], [-2.0, 1.0]),  # w2 >= 1 makes z2 = 0, and then w1 <= -2
            ([[0.0, 1.0], [1.0, -1.0]], [1.0, -1.0]),  # w1 >= 1 makes z1 = 0, and then w2 <= -1
            ([[0.0, 1.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 1.0]], [-1.0, 1.0, -1.0]),  # w2 = 1, so z2 = 0 and w1 = -1
        ],
    )
    def test_feasible_and_yet_without_solution(self, M, q):
        solution = Enumeration().solve(Lcp(M, q))
        assert solution.status is Status.NO_SOLUTION
        assert solution.certificate is None
        assert solution.iterations == 2 ** len(q)
        assert farkas(np.array(M), np.array(q)) is None

    def test_painleve_without_friction_impulse(self):
        # Sliding rod that keeps sliding: w = q - z < 0 for every z; sticking is left out by the one sliding direction.
        solution = Enumeration().solve(Lcp([[-0.5]], [-2.0]))
        assert solution.status is Status.INFEASIBLE
        assert solution.certificate[0] > 0.0

    def test_sets_that_contradict_themselves_leave_nothing_undecided(self):
        # Beside the first example above seven contacts that press one mass with different speeds: 480 singular sets.
        M, q = np.zeros((9, 9)), np.array([-1.0, 1.0, -1.0, -2.0, -3.0, -4.0, -5.0, -6.0, -7.0])
        M[:2, :2], M[2:, 2:] = [[-1.0, 2.0], [1.0, 1.0]], 1.0
        assert Enumeration().solve(Lcp(M[2:, 2:], q[2:])).z == pytest.approx([0.0] * 6 + [7.0], abs=1e-14)
        solution = Enumeration().solve(Lcp(M, q))
        assert solution.status is Status.NO_SOLUTION

    def test_undecided_blocks_are_owned_up_to(self):
        # Rank one: 2^10 - 11 singular sets, each contradicting or not; with w = -1 somewhere no set solves.
        n = 10
        M, q = np.ones((n, n)), np.zeros(n)
        M[0], q[0] = 0.0, -1.0
        solution = Enumeration().solve(Lcp(M, q))
        assert solution.status is Status.INFEASIBLE  # the certificate says what the sets leave open
        assert solution.certificate / solution.certificate.max() == pytest.approx(np.eye(n)[0], abs=1e-12)


class TestFarkas:
    @pytest.mark.parametrize(
        ("M", "q", "u"),
        [
            ([[-1.0]], [-1.0], [1.0]),
            ([[1.0, -1.0], [-1.0, 1.0]], [-1.0, -1.0], [1.0, 1.0]),
            ([[1.0, -1.0], [-1.0, 1.0]], [-3.0, 2.0], [1.0, 1.0]),
            ([[0.0, 1.0], [0.0, 0.0]], [5.0, -1.0], [0.0, 1.0]),
            (np.zeros((2, 2)), [1.0, -1.0], [0.0, 1.0]),
            ([[2.0, 0.0, -1.0], [0.0, 3.0, -1.0], [-1.0, -1.0, 0.0]], [-1.0, -1.0, 0.5], [0.5, 1 / 3, 1.0]),
        ],
    )
    def test_by_hand(self, M, q, u):
        M, q = np.array(M, dtype=float), np.array(q, dtype=float)
        found = farkas(M, q)
        assert found / found.max() == pytest.approx(u, abs=1e-9)
        assert (found >= 0.0).all()
        assert (M.T @ found).max() <= 1e-12 * found.max()
        assert q @ found < 0.0

    @pytest.mark.parametrize(
        ("M", "q"),
        [
            ([[2.0, 1.0], [1.0, 2.0]], [-5.0, -6.0]),
            ([[1.0, -1.0], [-1.0, 1.0]], [-1.0, 1.0]),  # z = (1, 0): just feasible
            ([[-1.0, 2.0], [1.0, 1.0]], [-1.0, 1.0]),  # feasible, without solution
            ([[1.0]], [0.0]),
            (np.zeros((0, 0)), []),
        ],
    )
    def test_none_where_points_exist(self, M, q):
        assert farkas(np.array(M, dtype=float), np.array(q, dtype=float)) is None

    @pytest.mark.parametrize("seed", range(10))
    def test_squeezes_with_a_proof_chosen_first(self, seed):
        # M with columns orthogonal to a u > 0, and q.u = -1/2: u itself would prove it.
        rng = np.random.default_rng(seed)
        n = int(rng.integers(2, 12))
        u = rng.uniform(0.5, 2.0, n)
        M = rng.standard_normal((n, n))
        M -= np.outer(u, (u @ M) / (u @ u))
        q = rng.standard_normal(n)
        q -= u * (q @ u + 0.5) / (u @ u)
        found = farkas(M, q)
        assert found is not None
        assert (found >= 0.0).all()
        assert (M.T @ found).max() <= 1e-12 * found.max()
        assert q @ found < -1e-8 * found.max()

    def test_units_do_not_matter(self):
        rows, columns = np.array([2.0**30, 2.0**-30]), np.array([2.0**-23, 2.0**17])
        found = farkas(rows[:, None] * np.array([[1.0, -1.0], [-1.0, 1.0]]) * columns, -rows)
        assert found * rows / (found * rows).max() == pytest.approx([1.0, 1.0], rel=1e-15)
