"""Problems, residuals, and the one door to a solution: what they accept, what they refuse."""

import subprocess
import sys

import numpy as np
import pytest

from lcpflex.errors import ModelError
from lcpflex.solvers import ContactProblem, Lcp, Status, accept
from lcpflex.solvers.acceptance import retold
from lcpflex.solvers.certificate import natural_residual

TOLERANCE = 1e-10


class TestResidual:
    def test_value_by_hand(self):
        # M z + q = (1, -1); d = (2, 2): min(d z, w) = (1, -1), above the guard 1e-6 |q|, so relative to |q| = 3.
        problem = Lcp([[2.0, 0.0], [0.0, 2.0]], [-1.0, -3.0])
        assert problem.residual([1.0, 1.0], scaled=False) == 1.0
        assert problem.residual([1.0, 1.0]) == pytest.approx(1.0 / 3.0, rel=1e-15)
        assert problem.residual([0.5, 1.5]) == 0.0

    @pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, 1e308])
    def test_a_point_that_is_not_finite_or_overflows_is_infinitely_wrong(self, bad):
        problem = Lcp([[1.0, 0.0], [0.0, 20.0]], [1.0, 1.0])
        assert problem.residual([0.0, bad]) == np.inf

    def test_a_point_far_out_on_a_ray_does_not_pass_as_relatively_small(self):
        # M has the null vector (1, 1); q = -1 has no solution, yet |w| = 1 is tiny beside |M||z| = 1e300.
        problem = Lcp([[1.0, -1.0], [-1.0, 1.0]], [-1.0, -1.0])
        assert problem.residual([1e300, 1e300]) >= 1.0

    def test_negative_unknown_of_a_zero_row_is_seen(self):
        assert Lcp([[0.0]], [1.0]).residual([-1.0]) == 1.0

    def test_leading_block_counts_alone(self):
        M = np.full((4, 4), np.nan)
        q, z = np.full(4, np.nan), np.full(4, np.nan)
        M[:2, :2], q[:2], z[:2] = [[2.0, 0.0], [0.0, 2.0]], [-1.0, -3.0], [0.5, 1.5]
        assert natural_residual(M, q, z, 2) == 0.0
        assert natural_residual(M, q, z, 3) == np.inf

    def test_units_do_not_matter(self):
        M, q, z = np.array([[2.0, 1.0], [0.5, 3.0]]), np.array([-1.0, -2.0]), np.array([0.3, 0.5])
        reference = Lcp(M, q).residual(z)
        assert reference > 0.01
        assert Lcp(1024 * M, 8 * q).residual(z / 128) == reference


class TestProblem:
    @pytest.mark.parametrize(
        ("M", "q", "said"),
        [
            ([[1.0, np.nan], [0.0, 1.0]], [0.0, 0.0], r"M\[0, 1\] is nan"),
            ([[1.0]], [np.inf], r"q\[0\] is inf"),
            ([[1.0, 2.0]], [1.0], "shape"),
            ([[1.0]], [1.0, 2.0], "shape"),
            ([1.0], [1.0], "dimension"),
        ],
    )
    def test_refuses_what_is_not_a_problem(self, M, q, said):
        with pytest.raises(ModelError, match=said):
            Lcp(M, q)

    def test_data_are_copied(self):
        q = np.array([-1.0])
        problem = Lcp([[1.0]], q)
        q[0] = 5.0
        assert problem.q[0] == -1.0
        with pytest.raises(ValueError, match="read-only"):
            problem.M[0, 0] = 2.0

    def test_symmetry_is_judged_to_rounding(self):
        assert Lcp([[1.0, 0.1 + 0.2], [0.3, 1.0]], [0.0, 0.0]).symmetric
        assert not Lcp([[1.0, 0.30001], [0.3, 1.0]], [0.0, 0.0]).symmetric
        assert Lcp(np.zeros((0, 0)), []).symmetric


class TestAccept:
    problem = Lcp([[2.0, 1.0], [1.0, 2.0]], [-5.0, -6.0])
    exact = np.array([4.0, 7.0]) / 3.0

    def test_only_the_residual_makes_a_solution(self):
        assert accept(self.problem, self.exact, tolerance=TOLERANCE, status=Status.RAY).status is Status.SOLVED
        assert accept(self.problem, [0.0, 0.0], tolerance=TOLERANCE).status is Status.NUMERICAL_FAILURE
        assert accept(self.problem, [0.0, 0.0], tolerance=TOLERANCE, status=Status.RAY).status is Status.RAY
        assert accept(self.problem, self.exact + 3e-9, tolerance=TOLERANCE).status is Status.INACCURATE
        assert accept(self.problem, [np.nan, 0.0], tolerance=TOLERANCE).status is Status.NUMERICAL_FAILURE

    def test_why_the_algorithm_ended_stays_beside_how_near_its_point_is(self):
        near = accept(self.problem, self.exact + 3e-9, tolerance=TOLERANCE, status=Status.ITERATION_LIMIT)
        assert (near.status, near.ended) == (Status.INACCURATE, Status.ITERATION_LIMIT)
        again = retold(self.problem, near.z, near, TOLERANCE)
        assert (again.status, again.ended) == (Status.INACCURATE, Status.ITERATION_LIMIT)
        far = retold(self.problem, [0.0, 0.0], near, TOLERANCE)
        assert (far.status, far.ended) == (Status.ITERATION_LIMIT, None)
        assert retold(self.problem, self.exact, near, TOLERANCE).ended is None

    def test_infeasible_needs_a_certificate_that_holds(self):
        squeezed = Lcp([[1.0, -1.0], [-1.0, 1.0]], [-1.0, -1.0])
        good = accept(squeezed, [0.0, 0.0], tolerance=TOLERANCE, status=Status.RAY, certificate=np.array([1.0, 1.0]))
        bad = accept(squeezed, [0.0, 0.0], tolerance=TOLERANCE, status=Status.RAY, certificate=np.array([1.0, 0.0]))
        assert good.status is Status.INFEASIBLE
        assert bad.status is Status.RAY
        assert bad.certificate is None


class TestFriction:
    def test_matrix_by_hand(self):
        # Contact 0 without friction, contact 1 with mu = 0.5: unknowns [N0, N1, R1, L1].
        G = np.array([[2.0, 0.3, 0.1], [0.3, 3.0, 0.4], [0.1, 0.4, 5.0]])
        problem = ContactProblem(G, [1.0, 2.0, 3.0], [0.0, 0.5]).lcp()
        expected = [
            [2.0, 0.3 - 0.05, 0.1, 0.0],
            [0.3, 3.0 - 0.2, 0.4, 0.0],
            [0.1, 0.4 - 2.5, 5.0, 1.0],
            [0.0, 1.0, -1.0, 0.0],
        ]
        assert pytest.approx(np.array(expected), abs=1e-15) == problem.M
        assert problem.q == pytest.approx([1.0, 2.0, 3.0, 0.0])

    @pytest.mark.parametrize(
        ("change", "said"),
        [
            ({"friction": [-0.1]}, "coefficients >= 0"),
            ({"friction": [np.nan]}, r"friction\[0\] is nan"),
            ({"free": [1.0]}, r"free \(1,\): expected 2 rows"),
            ({"keys": ("a", "b")}, "keys"),
        ],
    )
    def test_refuses_what_does_not_fit(self, change, said):
        with pytest.raises(ModelError, match=said):
            ContactProblem(**{"delassus": np.eye(2), "free": [0.0, 0.0], "friction": [0.5], **change})


def test_importing_the_room_costs_nothing_and_has_one_name():
    code = "import sys, lcpflex.solvers; print(any(m in sys.modules for m in ('numba', 'qpsolvers', 'scipy')))"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout.strip() == "False"
