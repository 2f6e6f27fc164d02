"""Quadratic programs: both forms by every installed backend, proofs, duality, backends that do not tell the truth."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import scipy.sparse

from lcpflex.errors import ModelError
from lcpflex.solvers import ContactProblem, Lcp, Lemke, Status
from lcpflex.solvers.lcp.proofs import infeasibility
from lcpflex.solvers.quadratic_program import QuadraticProgram, duality_gap, equilibrium, polish
from tests import libs

BACKENDS = sorted(libs.qpsolvers.available_solvers)
SQUEEZE = np.array([[1.0, 0.0], [-1.0, 0.0]])


def planted(seed: int, known_factor: bool, decades: float = 0.0) -> tuple[Lcp, np.ndarray]:
    """A problem, mostly with redundant and degenerate contacts, and its w, which is unique."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 25))
    J = rng.standard_normal((n, int(rng.integers(1, n + 4))))
    J = J * 10.0 ** rng.uniform(-0.5 * decades, 0.5 * decades, (n, 1))
    kind = rng.choice(3, n, p=[0.45, 0.45, 0.1])
    z = np.where(kind == 0, rng.uniform(0.1, 1.0, n), 0.0)
    w = np.where(kind == 1, rng.uniform(0.1, 1.0, n), 0.0)
    return Lcp(J @ J.T, w - J @ (J.T @ z), J if known_factor else None), w


@pytest.fixture
def backend_says(monkeypatch):
    """Have the backend give a prepared answer, and keep what it was asked."""

    def prepare(answer):
        asked = []

        def solve_problem(program, **settings):
            asked.append((program, settings))
            return answer(program)

        monkeypatch.setattr(libs.qpsolvers, "solve_problem", solve_problem)
        return asked

    return prepare


def says(program, x, found=True, z=None, **extras):
    """A backend's answer x, with the multipliers z."""
    n = len(program.q)
    return SimpleNamespace(x=x, z=z, z_box=None if x is None else np.full(n, np.nan), found=found, extras=extras)


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("known_factor", [False, True])
class TestAnswers:
    @pytest.mark.parametrize("seed", range(15))
    def test_motion_is_the_planted_one(self, backend, known_factor, seed):
        problem, w = planted(seed, known_factor)
        solution = QuadraticProgram(backend).solve(problem)
        assert solution.solved
        assert solution.w == pytest.approx(w, abs=1e-7 * max(1.0, np.abs(problem.q).max()))
        velocity_form = known_factor or backend == "quadprog"
        assert ("velocity form" in solution.route) == (velocity_form and (problem.q < 0.0).any())

    @pytest.mark.parametrize("seed", range(10))
    def test_contacts_of_many_magnitudes(self, backend, known_factor, seed):
        assert QuadraticProgram(backend).solve(planted(seed, known_factor, decades=8.0)[0]).solved

    def test_a_squeeze_is_proved_to_have_no_solution(self, backend, known_factor):
        for closing in (1.0, 1e-6, 1e9):
            problem = Lcp(SQUEEZE @ SQUEEZE.T, [-closing, -0.5 * closing], SQUEEZE if known_factor else None)
            solution = QuadraticProgram(backend).solve(problem)
            assert solution.status is Status.INFEASIBLE
            u = solution.certificate
            assert (u >= 0.0).all()
            assert u[0] == pytest.approx(u[1], rel=1e-8)

    @pytest.mark.parametrize("seed", range(6))
    def test_a_squeeze_among_other_contacts_is_proved(self, backend, known_factor, seed):
        rng = np.random.default_rng(seed)
        J = rng.integers(-64, 64, (6, 9)) / 32.0  # few digits, so that nothing here is rounded
        J = np.vstack([J, -0.5 * (J[0] + J[1])])
        q = np.append(rng.integers(-64, 64, 6) / 32.0, 0.0)
        q[6] = -0.5 * (q[0] + q[1]) - 0.125  # u = (1, 1, 0, ..., 2) has J^T u = 0 and q.u = -1/4
        solution = QuadraticProgram(backend).solve(Lcp(J @ J.T, q, J if known_factor else None))
        assert solution.status is Status.INFEASIBLE
        u = solution.certificate / solution.certificate.max()
        assert u == pytest.approx([0.5, 0.5, 0.0, 0.0, 0.0, 0.0, 1.0], abs=1e-6)

    def test_a_squeeze_to_rounding_is_none(self, backend, known_factor):
        # As above, but for the last digit of one number: forces of about 1e16 open all contacts.
        J = np.random.default_rng(0).integers(-64, 64, (6, 9)) / 32.0
        J = np.vstack([J, -0.5 * (J[0] + J[1])])
        M = J @ J.T
        M[6, 6] = np.nextafter(M[6, 6], np.inf)
        problem = Lcp(M, -np.ones(7), J if known_factor else None)
        solution = QuadraticProgram(backend).solve(problem)
        assert not solution.settled
        assert solution.certificate is None
        assert "nearly infeasible" in solution.message
        assert infeasibility(problem) is None

    def test_a_solution_is_a_usable_guess(self, backend, known_factor):
        problem, w = planted(3, known_factor)
        solver = QuadraticProgram(backend)
        solution = solver.solve(problem, solver.solve(problem))
        assert solution.solved
        assert solution.w == pytest.approx(w, abs=1e-7)

    def test_nothing_is_printed(self, backend, known_factor, capfd):
        for M in ([[1.0, 2.0], [2.0, 1.0]], [[-1.0, 0.0], [0.0, -1.0]], [[0.0, 1.0], [1.0, 0.0]]):
            QuadraticProgram(backend).solve(Lcp(M, [-1.0, -1.1]))
        J = SQUEEZE if known_factor else None
        QuadraticProgram(backend).solve(Lcp(SQUEEZE @ SQUEEZE.T, [-1.0, -1.0], J))
        assert capfd.readouterr() == ("", "")


class TestDuality:
    @pytest.mark.parametrize("seed", range(10))
    def test_optima_of_both_forms_add_up_to_zero(self, seed):
        problem, _ = planted(seed, True)
        solution = QuadraticProgram().solve(problem)
        z, J = solution.z, problem.factor
        v = J.T @ z
        box, velocity = 0.5 * z @ problem.M @ z + problem.q @ z, 0.5 * v @ v
        assert box + velocity == pytest.approx(0.0, abs=1e-10 * max(velocity, 1e-300))
        assert (J @ v + problem.q >= -1e-9 * np.abs(problem.q).max()).all()
        assert duality_gap(problem, z) <= 1e-12
        if problem.q.min() < 0.0:
            assert solution.message == f"duality gap {duality_gap(problem, z):.1e}"

    def test_is_not_zero_elsewhere(self):
        problem = Lcp([[2.0, 1.0], [1.0, 2.0]], [-5.0, -6.0])
        assert duality_gap(problem, [1.0, 0.0]) == pytest.approx(3.0 / 7.0)  # z.w = 2 - 5 and |z|.(|M z| + |q|) = 2 + 5
        assert duality_gap(problem, [0.0, 0.0]) == 0.0
        for wrong in (np.nan, np.inf, 1e200):
            assert duality_gap(problem, [wrong, 1.0]) == np.inf
        with pytest.raises(ModelError, match="z has shape"):
            duality_gap(problem, [1.0])


class TestWhatBackendsAreAsked:
    factor = np.array([[2.0, 0.0], [1.0, 1.0], [0.0, 3.0]])
    q = np.array([-1.0, -1.0, 2.0])

    @pytest.mark.parametrize("backend", ["clarabel", "osqp"])
    def test_velocity_form_where_the_factor_is_known(self, backend, backend_says):
        asked = backend_says(lambda program: says(program, np.zeros(2), z=np.zeros(3)))
        QuadraticProgram(backend).solve(Lcp(self.factor @ self.factor.T, self.q, self.factor))
        program, settings = asked[0]
        assert settings["solver"] == backend
        assert scipy.sparse.issparse(program.P)
        assert scipy.sparse.issparse(program.G)
        assert program.P.format == program.G.format == "csc"
        assert (program.P.toarray() == np.eye(2)).all()
        rows = self.factor / np.linalg.norm(self.factor, axis=1)[:, None]
        assert -program.G.toarray() == pytest.approx(rows)
        assert (program.q == 0.0).all()
        slack = self.q / np.linalg.norm(self.factor, axis=1)
        assert program.h == pytest.approx(slack / np.abs(slack).max())
        assert program.lb is None

    def test_box_form_else(self, backend_says):
        asked = backend_says(lambda program: says(program, np.zeros(3)))
        M = self.factor @ self.factor.T
        QuadraticProgram().solve(Lcp(M, self.q))
        program, settings = asked[0]
        length = np.sqrt(np.diag(M))
        assert program.P.toarray() == pytest.approx(M / np.outer(length, length))
        assert (program.lb == 0.0).all()
        assert program.G is None
        assert settings["initvals"] is None

    def test_guesses_that_are_numbers_of_a_sensible_size(self, backend_says):
        asked = backend_says(lambda program: says(program, np.zeros(len(program.q)), z=np.zeros(3)))
        problem = Lcp(self.factor @ self.factor.T, self.q, self.factor)
        known = Lemke().solve(problem)
        QuadraticProgram("osqp").solve(problem, known)
        start = asked[0][1]["initvals"]
        load = np.abs(self.q / np.linalg.norm(self.factor, axis=1)).max()
        assert start == pytest.approx(self.factor.T @ known.z / load)
        for wrong in (np.nan, np.inf, 1e200):
            asked.clear()
            QuadraticProgram("osqp").solve(problem, replace(known, z=np.full(3, wrong)))
            assert asked[0][1]["initvals"] is None
        asked.clear()
        QuadraticProgram("osqp").solve(problem, replace(known, z=np.zeros(7)))
        assert asked[0][1]["initvals"] is None

    def test_a_factor_that_is_nearly_one_of_M_does_no_harm(self):
        J = np.random.default_rng(1).standard_normal((6, 6))
        problem = Lcp(J @ J.T, -np.ones(6), J * (1.0 + 1e-9))
        assert QuadraticProgram().solve(problem).solved

    @pytest.mark.parametrize("backend", ["clarabel", "osqp"])
    @pytest.mark.parametrize("known_factor", [False, True])
    def test_the_proof_is_read_off_the_first_answer(self, backend, known_factor, backend_says):
        solve_problem = libs.qpsolvers.solve_problem
        asked = backend_says(lambda program: solve_problem(program, solver=backend))
        solution = QuadraticProgram(backend).solve(
            Lcp(SQUEEZE @ SQUEEZE.T, [-1.0, -0.5], SQUEEZE if known_factor else None)
        )
        assert solution.status is Status.INFEASIBLE
        assert len(asked) == 1

    def test_box_form_where_the_velocity_form_fails(self, backend_says):
        solve_problem = libs.qpsolvers.solve_problem

        def answer(program):
            if program.G is not None:
                return says(program, None, found=False)
            return solve_problem(program, solver="osqp")

        asked = backend_says(answer)
        solution = QuadraticProgram("osqp").solve(Lcp(self.factor @ self.factor.T, self.q, self.factor))
        assert solution.solved
        assert solution.route == "osqp, active set"
        assert [program.G is None for program, _ in asked][-1]


class TestNothingIsBelieved:
    problem = Lcp([[2.0, 1.0], [1.0, 2.0]], [-5.0, -6.0])
    far = Lcp([[1.0, 0.5, 0.0], [0.5, 1.0, 0.5], [0.0, 0.5, 1.0]], [-1.0, -2.0, 3.0])

    def test_a_rough_point_is_made_exact(self, backend_says):
        backend_says(lambda program: says(program, np.array([4 / 3, 7 / 3]) / 6.0 * np.sqrt(2.0) * 1.003))
        solution = QuadraticProgram().solve(self.problem)
        assert solution.solved
        assert solution.z == pytest.approx([4 / 3, 7 / 3], rel=1e-14)
        assert solution.route == "clarabel, active set"

    def test_the_set_may_show_in_one_of_the_two_answers_only(self, backend_says, monkeypatch):
        # z = (1, 0) and w = (0, 0.4): the multipliers are useless, the velocities are good.
        monkeypatch.setattr("lcpflex.solvers.lcp.polishing.POLISHING", 1)
        M = np.array([[1.0, 0.9], [0.9, 1.0]])
        J = np.linalg.cholesky(M)
        backend_says(lambda program: says(program, J[0], z=np.array([0.1, 0.2])))
        solution = QuadraticProgram().solve(Lcp(M, [-1.0, -0.5], J))
        assert solution.solved
        assert solution.z == pytest.approx([1.0, 0.0])
        assert solution.route == "clarabel (velocity form), active set"

    @pytest.mark.parametrize("shift", [1e-3, 0.0])
    def test_a_wrong_point_is_not_solved_because_it_was_found(self, backend_says, monkeypatch, shift):
        monkeypatch.setattr("lcpflex.solvers.lcp.polishing.POLISHING", 0)
        exact = np.array([4 / 3, 7 / 3]) / 6.0 * 2.0  # in units of sqrt(2) both ways
        backend_says(lambda program: says(program, exact + shift))
        solution = QuadraticProgram().solve(self.problem)
        assert solution.solved == (shift == 0.0)
        assert solution.status in (Status.SOLVED, Status.NUMERICAL_FAILURE)

    @pytest.mark.parametrize("number", [np.nan, np.inf, -np.inf])
    def test_no_point(self, backend_says, number):
        backend_says(lambda program: says(program, np.full(2, number), found=False, status="lost"))
        solution = QuadraticProgram().solve(self.problem)
        assert solution.status is Status.NUMERICAL_FAILURE
        assert "clarabel: lost" in solution.message
        assert (solution.z == 0.0).all()

    def test_no_answer(self, backend_says):
        backend_says(lambda program: says(program, None, found=False))
        assert "no solution found" in QuadraticProgram().solve(self.problem).message

    def test_an_exception(self, backend_says):
        def fail(program):
            raise ArithmeticError("all is lost")

        backend_says(fail)
        solution = QuadraticProgram().solve(self.problem)
        assert solution.status is Status.NUMERICAL_FAILURE
        assert solution.message == "clarabel: ArithmeticError: all is lost"

    def test_a_false_proof_is_none(self, backend_says):
        ray = np.array([1.0, 1.0])
        backend_says(lambda program: says(program, np.full(2, np.nan), found=False, dual_inf_cert=ray))
        solution = QuadraticProgram().solve(self.problem)
        assert solution.status is Status.NUMERICAL_FAILURE
        assert solution.certificate is None

    def test_indefinite_and_overflowing_problems_are_not_even_asked(self, backend_says):
        asked = backend_says(lambda program: says(program, np.zeros(2)))
        for M, reason in (([[1.0, 2.0], [2.0, 1.0]], "indefinite"), ([[1e-300, 1e300], [1e300, 1e-300]], "overflow")):
            solution = QuadraticProgram().solve(Lcp(M, [-1.0, -1.0]))
            assert solution.status is Status.NUMERICAL_FAILURE
            assert reason in solution.message
        assert not asked

    @pytest.mark.filterwarnings("error")
    @pytest.mark.parametrize("size", [1e-308, 1e200, 1e308])
    @pytest.mark.parametrize("load", [1e-300, 1e300])
    def test_numbers_at_the_edge_give_no_warnings(self, size, load):
        for backend in ("clarabel", "osqp"):
            problem = Lcp([[size, 0.5 * size], [0.5 * size, size]], [-load, load])
            solution = QuadraticProgram(backend).solve(problem)
            assert solution.solved == (problem.residual(solution.z) <= 1e-10)


class TestPolish:
    def test_redundant_contacts_keep_their_shares(self):
        M, q = np.ones((3, 3)), -np.ones(3)
        z = polish(M, q, np.array([0.5, 0.3, 0.1]))
        assert z == pytest.approx(np.array([0.5, 0.3, 0.1]) + 0.1 / 3.0, abs=1e-15)

    def test_equilibrium_changes_active_unknowns_only(self):
        M = np.array([[2.0, 1.0, 0.0], [1.0, 2.0, 1.0], [0.0, 1.0, 2.0]])
        z = equilibrium(M, np.array([-2.0, 5.0, -4.0]), np.array([9.0, 9.0, 9.0]), np.array([0, 2]))
        assert z == pytest.approx([1.0, 0.0, 2.0])
        assert (equilibrium(M, np.zeros(3), np.ones(3), np.array([], dtype=np.int64)) == 0.0).all()

    @pytest.mark.parametrize("seed", range(20))
    def test_corrects_the_active_set(self, seed):
        rng = np.random.default_rng(seed)
        problem, w = planted(seed, False)
        length = np.sqrt(np.diag(problem.M))
        M, q = problem.M / np.outer(length, length), problem.q / length
        rough = np.maximum(length * Lemke().solve(problem).z + 1e-4 * rng.standard_normal(len(q)), 0.0)
        z = polish(M, q, rough)
        assert (z >= 0.0).all()
        assert length * (M @ z + q) == pytest.approx(w, abs=1e-9)

    def test_reads_the_set_off_the_multipliers(self, monkeypatch):
        monkeypatch.setattr("lcpflex.solvers.lcp.polishing.POLISHING", 1)
        M, q = np.array([[1.0, 0.5], [0.5, 1.0]]), np.array([-1.0, 0.2])
        rough = np.array([0.9, 0.4])  # M z + q = (0.1, 1.05)
        assert polish(M, q, rough, np.array([0.0, 0.5])) == pytest.approx([1.0, 0.0], abs=1e-15)

    def test_never_makes_a_point_worse(self):
        rng = np.random.default_rng(0)
        for _ in range(50):
            B = rng.standard_normal((5, 3))
            M, q, z = B @ B.T, rng.standard_normal(5), rng.random(5)
            before, after = (np.abs(np.minimum(x, M @ x + q)).max() for x in (z, polish(M, q, z)))
            assert after <= before


def test_frictionless_contacts_are_taken_as_they_are():
    J = np.array([[1.0, -0.5], [1.0, 0.5]])
    for problem in (
        ContactProblem(J @ J.T, [-1.0, -1.0], [0.0, 0.0]),
        ContactProblem(None, [-1.0, -1.0], [0.0, 0.0], factor=J),
    ):
        solution = QuadraticProgram().solve(problem)
        assert solution.solved
        assert solution.z == pytest.approx([0.5, 0.5])
        assert solution.keys == ((0, "N"), (1, "N"))
        assert ("velocity form" in solution.route) == (problem.factor is not None)
