"""Contact with friction as data: its matrices by hand, its forces and velocities, guesses brought over by name."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse

from lcpflex.errors import ModelError
from lcpflex.solvers import Auto, ContactProblem, Enumeration, Lemke, Status, accept
from lcpflex.solvers.contact.lcp_forms import (
    assemble_copositive_lcp,
    assemble_friction_lcp,
    from_copositive,
    split_friction_solution,
)
from lcpflex.solvers.contact.matrices import BLOCK
from lcpflex.solvers.contact.problem import aligned

# Rows [N0, N1, T1]: contact 0 without friction, contact 1 with mu = 0.5.
G = np.array([[2.0, 0.3, 0.1], [0.3, 3.0, 0.4], [0.1, 0.4, 5.0]])
PROBLEM = ContactProblem(G, [1.0, 2.0, 3.0], [0.0, 0.5], ("floor", "wall"))


def many(seed: int, n: int) -> ContactProblem:
    """n contacts, every third smooth, of bodies in general position; sparse factor."""
    rng = np.random.default_rng(seed)
    friction = np.where(np.arange(n) % 3 == 0, 0.0, rng.uniform(0.1, 1.0, n))
    m = n + np.count_nonzero(friction)
    J = scipy.sparse.random_array((m, 2 * n), density=3.0 / n, rng=rng, data_sampler=rng.standard_normal)
    return ContactProblem(None, rng.standard_normal(m), friction, factor=J + scipy.sparse.eye_array(m, 2 * n))


class TestData:
    def test_rows_and_names(self):
        assert PROBLEM.tangent.tolist() == [1]
        assert PROBLEM.size == 4
        assert PROBLEM.unknown_keys == (("floor", "N"), ("wall", "N"), ("wall", "R"), ("wall", "L"))
        assert ContactProblem(G, [1.0, 2.0, 3.0], [0.0, 0.5]).keys == (0, 1)

    def test_velocity_is_linear_in_the_forces(self):
        # v = G f + free with f = (1, 2, -1): 2 + 0.6 - 0.1 + 1, 0.3 + 6 - 0.4 + 2, 0.1 + 0.8 - 5 + 3.
        assert PROBLEM.velocity([1.0, 2.0, -1.0]) == pytest.approx([3.5, 7.9, -1.1], rel=1e-14)
        factor = np.linalg.cholesky(G)
        for J in (factor, scipy.sparse.csr_array(factor), scipy.sparse.coo_array(factor)):
            known_by_factor = replace(PROBLEM, delassus=None, factor=J)
            assert known_by_factor.velocity([1.0, 2.0, -1.0]) == pytest.approx([3.5, 7.9, -1.1], rel=1e-13)
            assert np.abs(known_by_factor.dense() - G).max() < 1e-14

    def test_entries_given_twice_add_up(self):
        J = scipy.sparse.coo_array(([1.0, 2.0, 1.0], ([0, 0, 1], [0, 0, 1])), shape=(2, 2))
        problem = ContactProblem(None, [0.0, 0.0], [0.5], factor=J)
        assert problem.dense().tolist() == [[9.0, 0.0], [0.0, 1.0]]

    def test_forces_by_hand(self):
        # lambda_R = lambda_T + mu lambda_N.
        normal, tangential = PROBLEM.forces([7.0, 4.0, 1.5, 9.0])
        assert normal.tolist() == [7.0, 4.0]
        assert tangential.tolist() == [-0.5]

    @pytest.mark.parametrize(("right", "tangential"), [(0.0, -2.0), (4.0, 2.0), (4.1, 2.0), (-0.1, -2.0), (2.0, 0.0)])
    def test_forces_stay_in_the_cone(self, right, tangential):
        normal, found = np.zeros(2), np.zeros(1)
        z, mu = np.array([7.0, 4.0, right, 9.0]), np.array([0.0, 0.5])
        split_friction_solution(z, mu, np.array([1]), 2, 1, normal, found)
        assert found.tolist() == [tangential]

    def test_unknowns_by_hand(self):
        # xi_L = max(-v_T, 0): v_T = -1.1 for these forces, and 8.9 for the others.
        assert PROBLEM.unknowns([1.0, 2.0], [-1.0]) == pytest.approx([1.0, 2.0, 0.0, 1.1], abs=1e-14)
        assert PROBLEM.unknowns([1.0, 2.0], [1.0]) == pytest.approx([1.0, 2.0, 2.0, 0.0], abs=1e-14)

    def test_slack_by_hand(self):
        # w = [v_N, v_T + xi_L, 2 mu lambda_N - lambda_R] for lambda_T = 0.5 - 1 = -0.5, v = G (1, 2, -0.5) + free.
        w = PROBLEM.slack([1.0, 2.0, 0.5, 9.0])
        assert w == pytest.approx([3.55, 8.1, 1.4 + 9.0, 1.5], rel=1e-14)

    @pytest.mark.parametrize("change", ["delassus", "free", "friction"])
    def test_arguments_are_copied(self, change):
        given = {"delassus": np.eye(2), "free": np.array([-1.0, 0.3]), "friction": np.array([0.5])}
        problem = ContactProblem(**given)
        before = Lemke().solve(problem).z
        given[change][:] = 7.0
        assert Lemke().solve(problem).z.tobytes() == before.tobytes()

    @pytest.mark.parametrize(
        ("change", "said"),
        [
            ({"delassus": None}, "delassus is None: expected a matrix, or else its factor"),
            ({"delassus": np.eye(3)}, r"delassus has shape \(3, 3\)"),
            ({"delassus": None, "factor": np.eye(3)}, r"factor has shape \(3, 3\)"),
            ({"delassus": None, "factor": np.full((2, 2), np.nan)}, r"factor\[0, 0\] is nan"),
            ({"delassus": None, "factor": scipy.sparse.csr_array([[np.inf, 0.0], [0.0, 1.0]])}, r"factor.data\[0\]"),
            ({"delassus": [[1.0, np.inf], [0.0, 1.0]]}, r"delassus\[0, 1\] is inf"),
            ({"free": [0.0, np.nan]}, r"free\[1\] is nan"),
            ({"friction": [0.0]}, r"expected 1 rows for 1 contacts, 0 of them with friction"),
            ({"friction": "rough"}, "friction is 'rough'"),
        ],
    )
    def test_refuses_what_does_not_fit(self, change, said):
        with pytest.raises(ModelError, match=said):
            ContactProblem(**{"delassus": np.eye(2), "free": [0.0, 0.0], "friction": [0.5], **change})

    def test_names_must_differ(self):
        with pytest.raises(ModelError, match="keys has 2 entries, 1 different"):
            replace(PROBLEM, keys=("floor", "floor"))


class TestCopositiveForm:
    def test_matrix_by_hand(self):
        # Unknowns [N0, N1, beta_+, beta_-, sigma].
        problem = PROBLEM.copositive_lcp()
        expected = [
            [2.0, 0.3, 0.1, -0.1, 0.0],
            [0.3, 3.0, 0.4, -0.4, 0.0],
            [0.1, 0.4, 5.0, -5.0, 1.0],
            [-0.1, -0.4, -5.0, 5.0, 1.0],
            [0.0, 0.5, -1.0, -1.0, 0.0],
        ]
        assert np.abs(problem.M - expected).max() < 1e-15
        assert problem.q.tolist() == [1.0, 2.0, 3.0, -3.0, 0.0]

    @pytest.mark.parametrize("seed", range(3))
    def test_is_copositive_and_the_other_is_not(self, seed):
        rng = np.random.default_rng(seed)
        steep = ContactProblem([[1.0, 0.9], [0.9, 1.0]], [-1.0, 1.0], [2.0])
        points = rng.exponential(size=(500, 4)) * (rng.random((500, 4)) < 0.6)
        M4, M3 = steep.copositive_lcp().M, steep.lcp().M
        assert min(x @ M4 @ x for x in points) >= -1e-12
        assert min(x @ M3 @ x for x in points[:, :3]) < -0.1

    @pytest.mark.parametrize("slide", [-3.0, -0.2, 0.0, 0.2, 3.0])
    def test_the_way_back(self, slide):
        # A point of 1 kg with (slide, -1) m/s, mu = 0.5: both forms have the same z, speeds included.
        problem = ContactProblem(np.eye(2), [-1.0, slide], [0.5])
        four = Lemke().solve(problem.copositive_lcp())
        M, q = problem.lcp()._data
        z = np.full(3, np.nan)
        from_copositive(four.z, M, q, problem.friction, problem.tangent, 1, 1, z)
        friction = -np.sign(slide) * min(abs(slide), 0.5)
        speed = slide + friction
        assert four.z[1] - four.z[2] == pytest.approx(friction, abs=1e-14)
        assert z == pytest.approx([1.0, friction + 0.5, max(-speed, 0.0)], abs=1e-14)

    def test_kernels_leave_larger_arrays_alone(self):
        def padded(*shape):
            return np.full(shape, np.nan)

        A, free, mu = padded(7, 7), padded(7), np.array([0.0, 0.5, np.nan])
        A[:3, :3], free[:3] = G, PROBLEM.free
        tangent = np.array([1, -9])
        M, q, M4, q4 = padded(8, 8), padded(8), padded(9, 9), padded(9)
        assert assemble_friction_lcp(A, free, mu, tangent, 2, 1, M, q) == 4
        assert assemble_copositive_lcp(M, q, mu, tangent, 2, 1, M4, q4) == 5
        assert M[:4, :4].tolist() == PROBLEM.lcp().M.tolist()
        assert M4[:5, :5].tolist() == PROBLEM.copositive_lcp().M.tolist()
        assert q[:4].tolist() == PROBLEM.lcp().q.tolist()
        assert q4[:5].tolist() == PROBLEM.copositive_lcp().q.tolist()
        for array, n in ((M, 4), (M4, 5)):
            assert np.isnan(array[n:]).all()
            assert np.isnan(array[:, n:]).all()


class TestResidual:
    def test_more_rows_than_exist_at_a_time(self):
        problem = many(0, BLOCK)
        assert len(problem.free) > BLOCK + 1
        rng = np.random.default_rng(1)
        lcp = problem.lcp()
        for point in (rng.exponential(size=problem.size), np.zeros(problem.size), -rng.random(problem.size)):
            for scaled in (True, False):
                assert problem.residual(point, scaled) == pytest.approx(lcp.residual(point, scaled), rel=1e-12)

    @pytest.mark.parametrize("n", [BLOCK - 1, BLOCK, BLOCK + 1, 3 * BLOCK // 2])
    @pytest.mark.parametrize("row", [0, BLOCK - 2, -1])
    def test_no_row_is_left_out(self, row, n):
        # Everything is at rest under forces that fit, but for one row that is pushed.
        free = np.zeros(n)
        free[row] = -1.0
        problem = ContactProblem(None, free, np.zeros(n), factor=2.0 * scipy.sparse.eye_array(n))
        assert problem.residual(np.zeros(n)) == 1.0
        assert problem.residual(-0.25 * free) == 0.0
        leaving = replace(problem, free=-10.0 * free)  # min(d z, w) = min(4 / 4, 1 + 10) for a force of 1 / 4
        assert leaving.residual(-0.25 * free, scaled=False) == 1.0

    @pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
    @pytest.mark.parametrize("place", range(4))
    def test_points_that_are_not_finite_are_infinitely_wrong(self, bad, place):
        for problem in (PROBLEM, replace(PROBLEM, delassus=None, factor=np.linalg.cholesky(G))):
            assert problem.residual(np.where(np.arange(4) == place, bad, 1.0)) == np.inf

    def test_a_force_that_moves_nothing_is_not_for_free(self):
        # G = 0: w = 1 whatever the force of 3 is; min(1 * 3, 1), with d = 1 for a row of zeros.
        for data in ({"delassus": [[0.0]]}, {"delassus": None, "factor": [[0.0]]}):
            problem = ContactProblem(free=[1.0], friction=[0.0], **data)
            assert problem.residual([3.0], scaled=False) == 1.0
            assert problem.residual([0.0]) == 0.0

    def test_points_that_overflow(self):
        for problem in (PROBLEM, replace(PROBLEM, delassus=None, factor=np.linalg.cholesky(G))):
            assert problem.residual(np.full(4, 1e308)) == np.inf

    def test_a_load_at_the_end_of_the_floats(self):
        """Of 1e-314 a float has a few digits: how far they go is told, and nothing overflows on the way there."""
        G = [[3.4, 2.9, -0.7, -1.5], [2.9, 3.7, 0.4, -0.9], [-0.7, 0.4, 6.4, -1.3], [-1.5, -0.9, -1.3, 2.7]]
        small = ContactProblem(G, np.array([3.4e-318, -1.1e-314, 4.2e-315, -2.4e-315]), friction=[0.3, 0.0, 0.0])
        found = Auto().solve(small)
        assert found.status is Status.INACCURATE
        assert 1e-10 < found.residual == small.residual(found.z) < 1e-7
        assert small.lcp().by_terms(found.z) == (pytest.approx(found.residual), "contact 1")

    def test_points_of_another_shape(self):
        for ask in (PROBLEM.residual, PROBLEM.slack, PROBLEM.forces):
            with pytest.raises(ModelError, match=r"z has shape \(3,\): expected \(4,\)"):
                ask(np.zeros(3))


class TestAligned:
    def guess(self, problem):
        solution = Lemke().solve(problem)
        return replace(solution, z=np.array([1.0, 2.0, 3.0, 4.0]), active=np.array([1, 0, 1, 1]))

    def test_by_hand(self):
        guess = self.guess(PROBLEM)
        keys = (("wall", "N"), ("new", "N"), ("floor", "N"), ("wall", "R"), ("new", "R"), ("wall", "L"), ("new", "L"))
        brought = aligned(guess, keys)
        assert brought.z.tolist() == [2.0, 0.0, 1.0, 3.0, 0.0, 4.0, 0.0]
        assert brought.active.tolist() == [0, 0, 1, 1, 0, 1, 0]
        assert brought.keys == keys
        assert guess.z.tolist() == [1.0, 2.0, 3.0, 4.0]

    def test_nothing_in_common(self):
        brought = aligned(self.guess(PROBLEM), (("other", "N"),))
        assert brought.z.tolist() == [0.0]
        assert brought.active.tolist() == [0]

    def test_from_and_to_nothing(self):
        empty = Lemke().solve(ContactProblem(np.zeros((0, 0)), [], []))
        brought = aligned(empty, PROBLEM.unknown_keys)
        assert brought.z.tolist() == [0.0] * 4
        assert aligned(self.guess(PROBLEM), ()).z.shape == (0,)

    def test_what_needs_no_change_is_left_as_it_is(self):
        guess = self.guess(PROBLEM)
        assert aligned(None, PROBLEM.unknown_keys) is None
        assert aligned(guess, PROBLEM.unknown_keys) is guess
        nameless = replace(guess, keys=None)
        assert aligned(nameless, (("other", "N"),)) is nameless

    def test_a_guess_without_basis(self):
        brought = aligned(replace(self.guess(PROBLEM), active=None), (("wall", "L"), ("floor", "N")))
        assert brought.z.tolist() == [4.0, 1.0]
        assert brought.active is None


class TestSolutionsToldApart:
    def test_open_contacts_beside_a_choice(self):
        # Contact 0 is the Painleve example with three answers, contact 1 is open and slides back: not six.
        A = np.zeros((4, 4))
        A[np.ix_([0, 2], [0, 2])] = [[1.0, -2.0], [-2.0, 5.0]]
        A[1, 1] = A[3, 3] = 1.0
        problem = ContactProblem(A, [0.5, 1.0, -3.0, -2.0], [1.0, 0.5])
        solution = Enumeration().solve(problem)
        pressed = sorted(float(problem.forces(z)[0][0]) for z in solution.solutions)
        assert solution.status is Status.NOT_UNIQUE
        assert pressed == pytest.approx([0.0, 0.5, 3.5], abs=1e-13)
        for z in solution.solutions:
            assert z[-1] == pytest.approx(2.0, abs=1e-14)  # the speed of the open contact
            assert accept(problem.lcp(), z, tolerance=1e-12).solved
