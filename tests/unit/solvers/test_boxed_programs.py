"""Boxed and mixed problems as quadratic programs with bounds: every backend, every kind of bound, proofs, refusals."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from lcpflex.errors import ModelError
from lcpflex.solvers import Auto, BoxedLcp, Lcp, MixedLcp, Status, cross_check
from lcpflex.solvers.lcp.polishing import polish, shortest
from lcpflex.solvers.lcp.proofs import proves
from lcpflex.solvers.quadratic_program import QuadraticProgram, duality_gap
from tests import libs

INF = np.inf
BACKENDS = sorted(libs.qpsolvers.available_solvers)
INDEFINITE = np.array([[1.0, 2.0], [2.0, 1.0]])


def random_box(seed: int, stiffness: float = 1.0, load: float = 1.0, decades: float = 0.0) -> BoxedLcp:
    """A semidefinite problem of 1 to 30 unknowns with bounds of every kind, and a solution."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 31))
    J = rng.standard_normal((n, int(rng.integers(1, n + 4))))
    unit = 10.0 ** rng.uniform(-0.5 * decades, 0.5 * decades, n)
    M = stiffness * (J @ J.T) / np.outer(unit, unit)
    lower = rng.uniform(-2.0, 0.5, n)
    upper = lower + rng.uniform(0.1, 2.0, n)
    kind = rng.integers(0, 6, n)
    lower[(kind == 0) | (kind == 1)] = -INF
    upper[(kind == 0) | (kind == 2)] = INF
    upper[kind == 4] = lower[kind == 4]
    size = unit * load / stiffness
    return BoxedLcp(M, -M @ (2.0 * size * rng.standard_normal(n)), lower * size, upper * size)


def fulfils(problem: BoxedLcp, z: np.ndarray) -> bool:
    """The conditions, one unknown after the other, to 1e-9 of the terms that cancel in its w."""
    for i in range(problem.size):
        w = float(problem.M[i] @ z + problem.q[i])
        terms = float(np.abs(problem.M[i]) @ np.abs(z) + abs(problem.q[i]))
        if not problem.lower[i] <= z[i] <= problem.upper[i]:
            return False
        if w > 1e-9 * terms and z[i] > problem.lower[i]:
            return False
        if w < -1e-9 * terms and z[i] < problem.upper[i]:
            return False
    return True


@pytest.mark.parametrize("backend", BACKENDS)
class TestAnswers:
    @pytest.mark.parametrize("seed", range(12))
    def test_bounds_of_every_kind_as_auto_has_them(self, backend, seed):
        problem = random_box(seed)
        solution, other = QuadraticProgram(backend).solve(problem), Auto().solve(problem)
        assert solution.status is other.status is Status.SOLVED
        assert fulfils(problem, solution.z)
        assert solution.residual <= 1e-12
        assert solution.w == pytest.approx(other.w, abs=1e-9 * np.abs(problem.q).max())
        assert duality_gap(problem, solution.z) <= 1e-10

    @pytest.mark.parametrize("stiffness", [1e-8, 1e8])
    @pytest.mark.parametrize("load", [1e-8, 1e8])
    @pytest.mark.parametrize("seed", [20, 21, 22])
    def test_other_scales(self, backend, seed, stiffness, load):
        problem = random_box(seed, stiffness, load)
        solution = QuadraticProgram(backend).solve(problem)
        assert solution.solved
        assert fulfils(problem, solution.z)
        plain = QuadraticProgram(backend).solve(random_box(seed))
        assert solution.w / load == pytest.approx(plain.w, abs=1e-9 * np.abs(problem.q).max() / load)

    @pytest.mark.parametrize("seed", [30, 31, 32])
    def test_unknowns_of_many_magnitudes(self, backend, seed):
        problem = random_box(seed, decades=8.0)
        solution = QuadraticProgram(backend).solve(problem)
        assert solution.solved
        assert fulfils(problem, solution.z)

    @pytest.mark.parametrize("wide", [1e8, 1e12, 1e20, 1e300])
    def test_bounds_far_away_take_nothing_from_the_accuracy(self, backend, wide):
        solution = QuadraticProgram(backend).solve(BoxedLcp([[2.0, 1.0], [1.0, 2.0]], [-5.0, -6.0], -wide, wide))
        assert solution.solved
        assert solution.z == pytest.approx([4 / 3, 7 / 3], rel=1e-13)

    @pytest.mark.parametrize("wide", [1e9, 1e15])
    def test_far_bounds_are_as_good_as_none(self, backend, wide):
        for seed in (2, 33, 52, 71):
            plain = random_box(seed)
            lower, upper = np.maximum(plain.lower, -wide), np.minimum(plain.upper, wide)
            found = QuadraticProgram(backend).solve(BoxedLcp(plain.M, plain.q, lower, upper))
            assert found.solved
            known = QuadraticProgram(backend).solve(plain)
            assert found.w == pytest.approx(known.w, abs=1e-9 * np.abs(plain.q).max())

    def test_far_bounds_that_are_reached(self, backend):
        solution = QuadraticProgram(backend).solve(BoxedLcp([[1.0, 1.0], [1.0, 1.0]], [-1.0, 2.0], -1e9, 1e9))
        assert solution.solved
        assert solution.z[0] == 1e9 or solution.z[1] == -1e9

    @pytest.mark.parametrize(
        ("lower", "upper", "z"),
        [
            (-INF, INF, 3.0),
            (0.0, INF, 3.0),
            (-INF, 4.0, 3.0),
            (-INF, 1.0, 1.0),
            (5.0, INF, 5.0),
            (-2.0, -2.0, -2.0),
            (3.0, 3.0, 3.0),
            (0.1, 0.3, 0.3),
            (-5.0, -0.1, -0.1),
        ],
    )
    def test_one_unknown_by_hand(self, backend, lower, upper, z):
        solution = QuadraticProgram(backend).solve(BoxedLcp([[2.0]], [-6.0], lower, upper))
        assert solution.solved
        assert solution.z == pytest.approx([z], rel=1e-15)
        assert solution.w == pytest.approx([2.0 * z - 6.0], abs=1e-14)

    def test_redundant_bilateral_rows_have_the_shortest_forces(self, backend):
        rows = np.array([[1.0, 0.0], [1.0, 0.0], [1.0, 0.0], [1.0, 1.0]])
        solution = QuadraticProgram(backend).solve(MixedLcp(rows @ rows.T, rows @ [0.6, -2.0], [0, 1, 2]))
        assert solution.solved
        assert solution.z == pytest.approx([-2.6 / 3, -2.6 / 3, -2.6 / 3, 2.0], rel=1e-12)

    def test_all_free_is_a_linear_system(self, backend):
        M, q = np.array([[4.0, 1.0], [1.0, 3.0]]), np.array([1.0, -2.0])
        assert QuadraticProgram(backend).solve(MixedLcp(M, q, [0, 1])).z == pytest.approx(np.linalg.solve(M, -q))

    def test_a_saddle_point_is_still_taken_by_its_lcp(self, backend):
        # Unsymmetric as it stands, but free x eliminated leave multipliers with the matrix A A^T.
        rng = np.random.default_rng(8)
        A, b, c = rng.standard_normal((6, 4)), rng.uniform(0.1, 0.5, 6), 3.0 * rng.standard_normal(4)
        M = np.block([[np.eye(4), A.T], [-A, np.zeros((6, 6))]])
        problem = MixedLcp(M, np.concatenate([-c, b]), np.arange(4))
        solver = QuadraticProgram(backend)
        assert not solver.refuses(problem)
        assert solver.solve(problem).z[:4] == pytest.approx(Auto().solve(problem).z[:4], abs=1e-11)

    def test_a_guess_does_no_harm(self, backend):
        problem = random_box(3)
        solver = QuadraticProgram(backend)
        solution = solver.solve(problem)
        for z in (solution.z, np.full(problem.size, np.nan), np.full(problem.size, 1e200), np.zeros(40)):
            again = solver.solve(problem, replace(solution, z=z))
            assert again.w == pytest.approx(solution.w, abs=1e-9 * np.abs(problem.q).max())

    @pytest.mark.parametrize("size", [1e-8, 1.0, 1e8])
    def test_what_has_no_solution_is_proved_so(self, backend, size):
        # u = (1, 1) in the first two moves nothing and falls for ever; the others do not matter, bounded as they are.
        M = size * np.array(
            [[1.0, -1.0, 0.5, 0.0], [-1.0, 1.0, -0.5, 0.0], [0.5, -0.5, 2.0, 1.0], [0.0, 0.0, 1.0, 4.0]]
        )
        lower, upper = np.array([0.0, 0.0, -1.0, -INF]), np.array([INF, INF, 2.0, INF])
        q = size * np.array([-1.0, 0.5, 3.0, 1.0])
        problem = BoxedLcp(M, q, lower, upper)
        solution = QuadraticProgram(backend).solve(problem)
        assert solution.status is Status.INFEASIBLE
        assert proves(problem.exact_system(), solution.proof)
        mirrored = BoxedLcp(M, -q, -upper, -lower)
        solution = QuadraticProgram(backend).solve(mirrored)
        assert solution.status is Status.INFEASIBLE
        assert proves(mirrored.exact_system(), solution.proof)
        for bound in ([5.0, INF, 2.0, INF], [INF, 7.0, 2.0, INF]):  # one bound stops the fall
            stopped = BoxedLcp(M, q, lower, bound)
            solution = QuadraticProgram(backend).solve(stopped)
            assert solution.solved
            assert fulfils(stopped, solution.z)

    def test_bilateral_rows_that_contradict_each_other(self, backend):
        problem = MixedLcp(np.ones((2, 2)), [1.0, -1.0], [0, 1])
        solution = QuadraticProgram(backend).solve(problem)
        assert solution.status is Status.INFEASIBLE
        assert proves(problem.exact_system(), solution.proof)

    def test_numbers_at_the_edge_are_judged(self, backend):
        for size in (1e-308, 1e200, 1e308):
            for load in (1e-300, 1e300):
                problem = BoxedLcp([[size, 0.5 * size], [0.5 * size, size]], [-load, load], [-1.0, -INF], [1.0, load])
                solver = QuadraticProgram(backend)
                if not solver.refuses(problem):
                    solution = solver.solve(problem)
                    assert solution.solved == (problem.residual(solution.z) <= 1e-10)

    def test_nothing_is_printed(self, backend, capfd):
        QuadraticProgram(backend).solve(random_box(1))
        QuadraticProgram(backend).solve(BoxedLcp(np.zeros((2, 2)), [-1.0, 1.0], 0.0, [INF, 1.0]))
        assert capfd.readouterr() == ("", "")


class TestRefusals:
    def test_unsymmetric(self):
        problem = BoxedLcp([[1.0, 0.5], [-0.5, 1.0]], [-1.0, -1.0], -1.0, 1.0)
        assert "not symmetric" in QuadraticProgram().refuses(problem)
        with pytest.raises(ModelError, match="not symmetric"):
            QuadraticProgram().solve(problem)

    def test_unsymmetric_in_unknowns_that_large_numbers_hide(self):
        M = np.diag([1e13, 1.0, 1.0])
        M[1, 2], M[2, 1] = 0.5, -0.5
        assert "not symmetric" in QuadraticProgram().refuses(BoxedLcp(M, -np.ones(3), -1.0, 1.0))

    def test_indefinite_between_two_bounds(self):
        for size in (1e-8, 1.0, 1e8):
            problem = BoxedLcp(size * INDEFINITE, [-1.0, -1.0], -1.0, 1.0)
            assert "indefinite" in QuadraticProgram().refuses(problem)
            with pytest.raises(ModelError, match="indefinite"):
                QuadraticProgram().solve(problem)

    @pytest.mark.parametrize("backend", BACKENDS)
    @pytest.mark.parametrize("seed", range(4))
    def test_indefinite_ones_are_never_called_solved_wrongly(self, backend, seed):
        rng = np.random.default_rng(seed)
        A = rng.standard_normal((6, 6))
        lower = np.where(np.arange(6) < seed, -INF, -1.0)
        problem, solver = BoxedLcp(A + A.T, rng.standard_normal(6), lower, INF), QuadraticProgram(backend)
        if seed == 0:
            assert "indefinite" in solver.refuses(problem)
            return
        solution = solver.solve(problem)
        assert not solution.solved or fulfils(problem, solution.z)

    def test_definite_once_the_free_unknown_is_eliminated(self):
        problem = MixedLcp([[-1.0, 1.0], [1.0, 1.0]], [1.0, -3.0], [0])  # z1 = 1 + z2, then 2 z2 - 2 = 0
        assert QuadraticProgram().solve(problem).z == pytest.approx([2.0, 1.0], rel=1e-14)

    def test_nothing_to_solve(self):
        assert QuadraticProgram().solve(BoxedLcp(np.zeros((0, 0)), [], [], [])).solved


class TestNothingIsBelieved:
    problem = BoxedLcp([[2.0, 1.0], [1.0, 2.0]], [-5.0, -6.0], [-1.0, 0.0], [1.0, INF])

    @pytest.fixture
    def asked(self, monkeypatch):
        """What the backend is asked; it answers ``asked.answer``."""
        told = SimpleNamespace(programs=[], answer=None)

        def solve_problem(program, **settings):
            told.programs.append(program)
            x, extras = told.answer
            return SimpleNamespace(x=x, z=None, z_box=np.full(len(program.q), np.nan), found=False, extras=extras)

        monkeypatch.setattr(libs.qpsolvers, "solve_problem", solve_problem)
        return told

    def test_bounds_are_posed_as_they_are(self, asked):
        asked.answer = np.array([0.2, 0.5]), {}
        solution = QuadraticProgram().solve(self.problem)
        program = asked.programs[0]
        assert program.P.shape == (2, 2)  # no multipliers of upper bounds as in the LCP
        assert program.G is None
        assert program.ub[0] == -program.lb[0] > 0.0
        assert program.lb[1] == 0.0
        assert program.ub[1] == INF
        assert solution.solved  # a rough point is made exact
        assert solution.z == pytest.approx([1.0, 2.5], rel=1e-15)

    def test_fixed_unknowns_are_none(self, asked):
        asked.answer = np.array([0.5]), {}
        solution = QuadraticProgram().solve(BoxedLcp(self.problem.M, self.problem.q, [0.7, 0.0], [0.7, 9.0]))
        assert len(asked.programs[0].q) == 1
        assert solution.z == pytest.approx([0.7, 2.65], rel=1e-15)

    @pytest.mark.parametrize("number", [np.nan, INF])
    def test_no_point(self, asked, number):
        asked.answer = np.full(2, number), {"status": "lost"}
        solution = QuadraticProgram().solve(self.problem)
        assert solution.status is Status.NUMERICAL_FAILURE
        assert "clarabel: lost" in solution.message

    def test_a_false_proof_is_none(self, asked):
        asked.answer = np.full(2, np.nan), {"dual_inf_cert": np.array([0.0, 1.0])}
        solution = QuadraticProgram().solve(self.problem)
        assert solution.status is Status.NUMERICAL_FAILURE
        assert solution.certificate is None
        assert not solution.proof


class TestPolish:
    def test_bounds_are_reached_and_left(self):
        # From a point on the wrong side of both: z1 is at 1 and must come down, z2 is inside and must go up to 2.
        M, q = np.array([[1.0, 0.5], [0.5, 1.0]]), np.array([-0.5, -4.0])
        z = polish(M, q, np.array([1.0, 0.1]), None, [-1.0, -1.0], [1.0, 2.0])
        assert z == pytest.approx([-0.5, 2.0], abs=1e-15)

    def test_a_contradiction_goes_on_to_the_nearest_bound(self):
        M, q = np.ones((2, 2)), np.array([-1.0, -1.2])  # w cannot vanish in both: z1 down or z2 up
        z = polish(M, q, np.array([0.5, 0.5]), None, [-8.0, -8.0], [8.0, 3.0])
        assert z == pytest.approx([-2.0, 3.0], abs=1e-14)

    def test_shortest_keeps_w(self):
        rng = np.random.default_rng(5)
        J = rng.standard_normal((6, 3))
        M, z, free = J @ J.T, rng.standard_normal(6), np.array([True] * 5 + [False])
        short = shortest(M, z, free)
        assert M @ short == pytest.approx(M @ z, abs=1e-12)
        assert short[5] == z[5]
        least = np.linalg.lstsq(J[:5].T, J[:5].T @ z[:5], rcond=None)[0]
        assert short[:5] == pytest.approx(least, abs=1e-12)


def test_cross_check_asks_quadratic_programs_about_boxes():
    report = cross_check(random_box(2))
    rows = {row.solver: row for row in report.rows}
    for backend in BACKENDS:
        assert rows[f"QuadraticProgram({backend})"].solved
        assert rows[f"QuadraticProgram({backend})"].same_motion
    assert "agree" in report.verdict


def test_gap_of_a_box_by_hand():
    # w = 2 z - 5 = -3 pushes z = 1 against 1.5: |z - b| |w| = 1.5 of (1 + 1.5) (2 + 5).
    problem = BoxedLcp([[2.0]], [-5.0], -1.0, 1.5)
    assert duality_gap(problem, [1.0]) == pytest.approx(1.5 / 17.5)
    assert duality_gap(problem, [1.5]) == 0.0
    assert duality_gap(BoxedLcp([[2.0]], [-5.0], 0.0, INF), [1.0]) == duality_gap(Lcp([[2.0]], [-5.0]), [1.0])
