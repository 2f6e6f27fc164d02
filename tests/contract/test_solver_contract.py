"""What every solver of complementarity problems owes: right answers, honest failures, the same bits every time."""

import itertools
import subprocess
import sys

import numpy as np
import pytest

from lcpflex.errors import ModelError
from lcpflex.solvers import ContactProblem, Lcp, Lemke, QuadraticProgram, Status, accept
from lcpflex.solvers.certificate import certifies_infeasibility, natural_residual
from lcpflex.solvers.lemke import lemke, lemke_workspace

TOLERANCE = 1e-10
SYMMETRIC_SOLVERS = [Lemke(), QuadraticProgram("clarabel"), QuadraticProgram("osqp")]


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

    def test_infeasible_needs_a_certificate_that_holds(self):
        squeezed = Lcp([[1.0, -1.0], [-1.0, 1.0]], [-1.0, -1.0])
        good = accept(squeezed, [0.0, 0.0], tolerance=TOLERANCE, status=Status.RAY, certificate=np.array([1.0, 1.0]))
        bad = accept(squeezed, [0.0, 0.0], tolerance=TOLERANCE, status=Status.RAY, certificate=np.array([1.0, 0.0]))
        assert good.status is Status.INFEASIBLE
        assert bad.status is Status.RAY
        assert bad.certificate is None
        assert not certifies_infeasibility(self.problem.M, self.problem.q, [1.0, 1.0])


@pytest.mark.parametrize("solver", SYMMETRIC_SOLVERS, ids=str)
class TestEverySolver:
    def test_empty_problem(self, solver):
        solution = solver.solve(Lcp(np.zeros((0, 0)), []))
        assert solution.solved
        assert solution.z.shape == solution.w.shape == (0,)

    def test_nothing_to_do(self, solver):
        solution = solver.solve(Lcp([[1.0, 0.0], [0.0, 1.0]], [0.0, 2.0]))
        assert solution.solved
        assert (solution.z == 0.0).all()

    def test_both_contacts_closed(self, solver):
        solution = solver.solve(TestAccept.problem)
        assert solution.solved
        assert solution.residual <= TOLERANCE
        assert solution.z == pytest.approx([4 / 3, 7 / 3], rel=1e-10)

    def test_one_contact_opens(self, solver):
        solution = solver.solve(Lcp([[2.0, 1.0], [1.0, 2.0]], [-4.0, -1.0]))  # 2 z1 = 4, w2 = 2 - 1
        assert solution.z == pytest.approx([2.0, 0.0], abs=1e-10)
        assert solution.w == pytest.approx([0.0, 1.0], abs=1e-9)

    def test_degenerate(self, solver):
        solution = solver.solve(Lcp([[2.0, 1.0], [1.0, 2.0]], [-4.0, -2.0]))  # z2 = 0 and w2 = 0
        assert solution.solved
        assert solution.z == pytest.approx([2.0, 0.0], abs=1e-8)

    @pytest.mark.parametrize("contacts", [2, 3, 5, 8])
    def test_redundant_contacts_carry_the_right_sum(self, solver, contacts):
        # The box falls with 0.1 m/s and stops: the impulses add up to m v and have no moment, however they are shared.
        solution = solver.solve(box_on_floor(contacts, 0.0, (0.3, -0.1, 0.0)).lcp())
        assert solution.solved
        assert solution.z.sum() == pytest.approx(0.1, rel=1e-9)
        assert solution.z @ np.linspace(-0.5, 0.5, contacts) == pytest.approx(0.0, abs=1e-9)

    @pytest.mark.parametrize("ratio", [1e-6, 1.0, 1e6])
    def test_heavy_on_light(self, solver, ratio):
        # Two masses in a column, both moving down with 1 m/s: floor impulse m1 + m2, upper contact m2.
        delassus = [[1.0, -1.0], [-1.0, 1.0 + 1.0 / ratio]]
        solution = solver.solve(Lcp(delassus, [-1.0, 0.0]))
        assert solution.solved
        assert solution.z == pytest.approx([1.0 + ratio, ratio], rel=1e-8)

    def test_a_squeeze_without_solution_is_certified(self, solver):
        problem = Lcp([[1.0, -1.0], [-1.0, 1.0]], [-1.0, -1.0])
        solution = solver.solve(problem)
        assert solution.status is Status.INFEASIBLE
        u = solution.certificate
        assert (u >= 0).all()
        assert problem.q @ u < 0
        assert problem.M.T @ u == pytest.approx([0.0, 0.0], abs=1e-9 * u.max())

    def test_zero_matrix(self, solver):
        assert not solver.solve(Lcp(np.zeros((2, 2)), [-1.0, 1.0])).solved

    def test_fathi(self, solver):
        lower = murty(10)
        solution = solver.solve(Lcp(lower @ lower.T, -np.ones(10)))
        assert solution.solved
        assert solution.z == pytest.approx([1.0] + [0.0] * 9, abs=1e-9)

    def test_same_bits_for_the_same_input(self, solver):
        problem = box_on_floor(4, 0.0, (0.0, -1.0, 0.7)).lcp()
        first, second = solver.solve(problem), solver.solve(problem)
        assert first.z.tobytes() == second.z.tobytes()
        assert first.w.tobytes() == second.w.tobytes()

    def test_tolerance_must_make_sense(self, solver):
        for tolerance in (0.0, -1.0, np.nan, 1.0):
            with pytest.raises(ModelError, match="tolerance"):
                type(solver)(tolerance=tolerance)


class TestLemke:
    @pytest.mark.parametrize("n", [3, 8, 16, 40])
    def test_murty(self, n):
        # z = e_1 for q = -1; the textbook path takes 2^n pivots.
        solution = Lemke(pivot_limit=1000).solve(Lcp(murty(n), -np.ones(n)))
        assert solution.solved
        assert solution.z == pytest.approx([1.0] + [0.0] * (n - 1), abs=1e-12)

    @pytest.mark.parametrize("n", [3, 5, 9, 21])
    def test_cyclic_matrix(self, n):
        M = np.eye(n) + 2.0 * np.roll(np.eye(n), 1, axis=1)  # pivoting rules without protection run in circles here
        solution = Lemke().solve(Lcp(M, -np.ones(n)))
        assert solution.solved
        assert solution.z == pytest.approx(np.full(n, 1 / 3), rel=1e-12)

    def test_honest_ray(self):
        solution = Lemke().solve(Lcp([[-1.0]], [-1.0]))  # w = -z - 1 < 0 for every z
        assert solution.status in (Status.RAY, Status.INFEASIBLE)
        # The Painleve pattern: M < 0 with q > 0 has the solution 0 (and another).
        assert Lemke().solve(Lcp([[-1.0]], [1.0])).solved

    def test_pivot_limit_is_reported(self):
        rng = np.random.default_rng(3)
        A = rng.standard_normal((12, 12))
        skew = A - A.T + 0.01 * np.eye(12)
        problem = Lcp(skew, -(skew @ np.abs(A[0])))
        assert Lemke().solve(problem).solved
        few = Lemke(pivot_limit=1).solve(problem)
        assert few.solved or few.status is Status.ITERATION_LIMIT
        assert few.residual == problem.residual(few.z)

    def test_pivot_limit_must_be_positive(self):
        with pytest.raises(ModelError, match="pivot_limit"):
            Lemke(pivot_limit=0)

    @pytest.mark.parametrize("seed", range(20))
    def test_answer_is_one_of_all(self, seed):
        rng = np.random.default_rng(seed)
        n = int(rng.integers(1, 7))
        A = rng.standard_normal((n, n))
        problem = Lcp(A @ A.T + 0.1 * np.eye(n) + (A - A.T), rng.standard_normal(n))
        every = enumerate_solutions(problem)
        solution = Lemke().solve(problem)
        assert len(every) >= 1
        assert solution.z == pytest.approx(every[0], abs=1e-8)

    def test_work_larger_than_the_problem_changes_nothing(self):
        problem = box_on_floor(3, 0.4, (1.0, -0.1, 0.2)).lcp()
        n = problem.size
        reference = Lemke().solve(problem)
        M, q, z = np.full((n + 5, n + 5), np.nan), np.full(n + 5, np.nan), np.full(n + 5, np.nan)
        M[:n, :n], q[:n] = problem.M, problem.q
        status, pivots = lemke(M, q, n, z, *lemke_workspace(n + 5), 1000)
        assert (status, pivots) == (Status.SOLVED, reference.iterations)
        assert z[:n].tobytes() == reference.z.tobytes()
        assert np.isnan(z[n:]).all()

    def test_a_kernel_given_nan_ends_unsolved(self):
        z = np.zeros(2)
        table, basis = lemke_workspace(2)
        assert lemke(np.array([[1.0, 0.0], [0.0, 1.0]]), np.array([np.nan, -1.0]), 2, z, table, basis, 100)[0] != 0
        assert lemke(np.array([[np.nan, 0.0], [0.0, 1.0]]), np.array([-1.0, -1.0]), 2, z, table, basis, 100)[0] != 0

    def test_basis_of_a_similar_problem_saves_the_pivots(self):
        before = Lemke().solve(box_on_floor(2, 0.5, (1.0, -0.1, 0.0)).lcp())
        after = box_on_floor(2, 0.5, (1.01, -0.1, 0.01)).lcp()
        warm, cold = Lemke().solve(after, before), Lemke().solve(after)
        assert warm.route == "basis of the guess"
        assert warm.iterations < cold.iterations
        assert warm.z == pytest.approx(cold.z, abs=1e-10)


class TestQuadraticProgram:
    def test_refuses_friction_and_says_what_to_use(self):
        with pytest.raises(ModelError, match=r"not symmetric.*Lemke"):
            QuadraticProgram().solve(box_on_floor(2, 0.3, (1.0, -0.1, 0.0)).lcp())

    def test_unknown_backend_names_the_installed_ones(self):
        with pytest.raises(ModelError, match=r"'clarabelle'.*clarabel, .*osqp"):
            QuadraticProgram("clarabelle")

    @pytest.mark.parametrize("backend", ["clarabel", "osqp"])
    def test_an_indefinite_matrix_is_never_solved_wrongly(self, backend):
        problem = Lcp([[1.0, 2.0], [2.0, 1.0]], [-1.0, -1.1])
        solution = QuadraticProgram(backend).solve(problem)
        assert solution.solved == (problem.residual(solution.z) <= TOLERANCE)


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
        ("mu", "slide", "tangential"),
        [
            (0.5, 0.2, -0.2),  # sticks: the impulse that stops it, 0.2 < 0.5
            (0.5, -0.2, 0.2),
            (0.5, 3.0, -0.5),  # slides to the right: the full friction against it
            (0.5, -3.0, 0.5),
            (2.0, 3.0, -2.0),
        ],
    )
    def test_block_that_hits_the_floor(self, mu, slide, tangential):
        # A mass point of 1 kg arrives with (slide, -1) m/s: normal impulse 1.
        problem = ContactProblem(np.eye(2), [-1.0, slide], [mu])
        normal, tangent = problem.forces(Lemke().solve(problem.lcp()).z)
        assert normal == pytest.approx([1.0], rel=1e-12)
        assert tangent == pytest.approx([tangential], rel=1e-12)

    @pytest.mark.parametrize("contacts", [2, 3, 8])
    @pytest.mark.parametrize("mu", [0.1, 0.5, 1.0, 2.0])
    @pytest.mark.parametrize("velocity", [(1.0, -0.1, 0.0), (0.0, -0.1, 0.0), (0.01, -0.1, 0.3), (-0.2, -1.0, -2.0)])
    def test_coulombs_law_holds_at_every_point(self, contacts, mu, velocity):
        problem = box_on_floor(contacts, mu, velocity)
        solution = Lemke().solve(problem.lcp())
        assert solution.solved
        normal, tangent = problem.forces(solution.z)
        after = problem.delassus @ np.concatenate([normal, tangent]) + problem.free
        gap_rate, slip = after[:contacts], after[contacts:]
        assert (normal >= 0).all()
        assert (gap_rate >= -1e-9).all()
        assert np.abs(normal * gap_rate).max() <= 1e-9
        assert (np.abs(tangent) <= mu * normal * (1 + 1e-12)).all()
        sliding = np.abs(slip) > 1e-8
        assert tangent[sliding] == pytest.approx(-mu * np.sign(slip[sliding]) * normal[sliding], abs=1e-9)
        # Friction and contact only take energy: work of the impulse with the mean velocity.
        impulse = np.concatenate([normal, tangent])
        assert impulse @ (0.5 * (after + problem.free)) <= 1e-12

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
