"""Contact problems in space: their data, how points are judged, and who refuses them."""

import copy
import pickle

import numpy as np
import pytest
import scipy.sparse

from lcpflex import solvers
from lcpflex.errors import ModelError
from lcpflex.solvers import ContactProblem, SpatialContactProblem, Status, UserSolver, accept
from tests.cone_problems import left_of_map, planted

STICKING = SpatialContactProblem(np.diag([2.0, 1.0, 1.0]), [-1.0, 0.1, 0.05], [0.3], ["foot"])
PLANAR = [
    "Enumeration",
    "GaussSeidel",
    "Lemke",
    "MinMapNewton",
    "PrincipalPivoting",
    "QuadraticProgram",
]


def by_definition(problem, r):
    """What is left of the natural map in units of the contacts, contact by contact, in numpy."""
    u = (problem.dense() @ r + problem.free).reshape(-1, 3)
    worst = 0.0
    for k, mu in enumerate(problem.friction):
        block = problem.dense()[3 * k : 3 * k + 3, 3 * k : 3 * k + 3]
        root = np.sqrt(np.diag(block).max())
        force, velocity = root * r[3 * k : 3 * k + 3], u[k] / root
        worst = max(worst, left_of_map(force, velocity, mu))
    return worst


class TestJudging:
    def test_planted_solutions_and_points_beside_them(self):
        rng = np.random.default_rng(1)
        for n in (1, 2, 7, 30):
            problem, r = planted(rng, n)
            assert problem.residual(r) < 1e-14
            assert problem.residuals(r)[1] < 1e-12
            for size in (1e-6, 1e-2, 1.0):
                point = r + size * rng.standard_normal(3 * n)
                left = problem.residual(point, scaled=False)
                assert left == pytest.approx(by_definition(problem, point), rel=1e-9)
                assert left > 1e-3 * size

    def test_dense_sparse_and_factor_agree(self):
        rng = np.random.default_rng(2)
        dense, r = planted(rng, 12)
        point = r + 0.01 * rng.standard_normal(36)
        others = (
            SpatialContactProblem(scipy.sparse.csr_array(dense.delassus), dense.free, dense.friction),
            SpatialContactProblem(None, dense.free, dense.friction, factor=dense.factor),
            SpatialContactProblem(None, dense.free, dense.friction, factor=scipy.sparse.csr_array(dense.factor)),
        )
        for other in others:
            assert other.residuals(point) == pytest.approx(dense.residuals(point), rel=1e-9)
            np.testing.assert_allclose(other.slack(point), dense.slack(point), rtol=1e-11, atol=1e-12)
            np.testing.assert_allclose(other.dense(), dense.delassus, rtol=1e-12, atol=1e-13)
            assert other.units == pytest.approx(dense.units, rel=1e-14)

    def test_units_do_not_matter(self):
        """Kilograms or tonnes, metres or millimetres, and each contact in a unit of its own: the same two numbers."""
        rng = np.random.default_rng(3)
        problem, r = planted(rng, 9)
        point = r + 1e-4 * rng.standard_normal(27)
        d = np.repeat(10.0 ** rng.uniform(-3.0, 3.0, 9), 3)
        scaled = SpatialContactProblem(problem.delassus * np.outer(d, d), problem.free * d, problem.friction)
        assert scaled.residuals(point / d) == pytest.approx(problem.residuals(point), rel=1e-9)
        faster = SpatialContactProblem(problem.delassus, 1e6 * problem.free, problem.friction)
        assert faster.residuals(1e6 * point) == pytest.approx(problem.residuals(point), rel=1e-9)
        heavier = SpatialContactProblem(1e-12 * problem.delassus, problem.free, problem.friction)
        assert heavier.residuals(1e12 * point) == pytest.approx(problem.residuals(point), rel=1e-9)

    def test_a_light_body_beside_a_heavy_one_is_judged_by_itself(self):
        """The wrong force of a body of 1e-10 kg beside one of 1 kg would vanish in any common unit."""
        W = np.diag([1.0, 1.0, 1.0, 1e10, 1e10, 1e10])
        problem = SpatialContactProblem(W, [-1.0, 0.0, 0.0, -1e5, 0.0, 0.0], [0.3, 0.3])
        assert problem.residual([1.0, 0.0, 0.0, 1e-5, 0.0, 0.0]) < 1e-15
        assert problem.residual([1.0, 0.0, 0.0, 0.9e-5, 0.0, 0.0]) > 0.01

    def test_both_sizes(self):
        """Wedged forces make the terms large: the first size forgives their rounding, the strict one does not."""
        J = np.array([[1.0], [0.0], [0.0], [-1.0], [0.0], [0.0]])
        problem = SpatialContactProblem(J @ J.T, [-1e-3, 0.0, 0.0, 1e-3, 0.0, 0.0], [0.0, 0.0])
        residual, strict = problem.residuals([1e3 + 1e-3 + 1e-10, 0.0, 0.0, 1e3, 0.0, 0.0])
        assert residual < 1e-9 < strict

    @pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, 1e308])
    def test_what_is_not_finite_solves_nothing(self, bad):
        point = np.array([0.5, -0.1, -0.05])
        for place in range(3):
            spoilt = point.copy()
            spoilt[place] = bad
            assert STICKING.residual(spoilt) == np.inf or STICKING.residual(spoilt) > 0.9
            assert not accept(STICKING, spoilt, tolerance=1e-10).solved

    def test_contacts_between_held_bodies(self):
        """Nothing moves them: open they need no force; approaching they have no solution, and no force is accepted."""
        W = np.zeros((6, 6))
        W[:3, :3] = np.eye(3)
        open_one = SpatialContactProblem(W, [-1.0, 0.0, 0.0, 0.5, 1.0, 0.0], [0.3, 0.3])
        assert open_one.residual([1.0, 0.0, 0.0, 0.0, 0.0, 0.0]) == 0.0
        held = SpatialContactProblem(W, [-1.0, 0.0, 0.0, -0.5, 0.0, 0.0], [0.3, 0.3])
        for force in (0.0, 1.0, 1e6):
            assert held.residual([1.0, 0.0, 0.0, force, 0.0, 0.0]) > 0.1

    def test_unsymmetric_operators_are_judged_as_they_are(self):
        W = np.array([[2.0, 0.3, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
        problem = SpatialContactProblem(W, [-1.0, 0.1, 0.0], [0.5])
        assert not problem.symmetric
        assert problem.residual([0.515, -0.1, 0.0]) < 1e-15
        assert problem.residual([0.5, -0.1, 0.0]) > 0.01
        assert STICKING.symmetric

    def test_no_contact_at_all(self):
        empty = SpatialContactProblem([], [], [])
        assert (empty.size, empty.residual([])) == (0, 0.0)
        assert accept(empty, [], tolerance=1e-10).status is Status.SOLVED

    def test_another_shape_is_refused(self):
        with pytest.raises(ModelError, match=r"z.*\(3,\)"):
            STICKING.residual([1.0, 0.0])
        with pytest.raises(ModelError, match=r"forces.*\(3,\)"):
            STICKING.velocity([1.0, 0.0])


class TestData:
    def test_names_of_the_unknowns(self):
        assert STICKING.unknown_keys == (("foot", "N"), ("foot", "1"), ("foot", "2"))
        np.testing.assert_array_equal(STICKING.forces([1.0, 2.0, 3.0]), [[1.0, 2.0, 3.0]])

    @pytest.mark.parametrize("copied", [copy.deepcopy, lambda p: pickle.loads(pickle.dumps(p))], ids=["copy", "pickle"])
    def test_copies_have_the_same_numbers_and_solve_alike(self, copied):
        sparse = SpatialContactProblem(scipy.sparse.csr_array(np.eye(6)), np.ones(6), [0.3, 0.2], factor=np.eye(6))
        for problem in (STICKING, sparse, SpatialContactProblem(None, np.ones(3), [0.1], factor=np.eye(3))):
            again = copied(problem)
            for one, other in zip(again.data, problem.data, strict=True):
                dense = [a.toarray() if scipy.sparse.issparse(a) else a for a in (one, other)]
                assert np.array_equal(*dense)
            assert again.keys == problem.keys
            assert again.residuals(np.ones(problem.size)) == problem.residuals(np.ones(problem.size))

    def test_arrays_are_copied_and_read_only(self):
        W = np.eye(3)
        problem = SpatialContactProblem(W, np.ones(3), [0.3])
        W[0, 0] = 7.0
        assert problem.delassus[0, 0] == 1.0
        with pytest.raises(ValueError, match="read-only"):
            problem.free[0] = 2.0

    @pytest.mark.parametrize(
        ("change", "words"),
        [
            ({"delassus": np.eye(2)}, r"delassus has shape \(2, 2\) .*expected 3 rows"),
            ({"delassus": None}, "delassus is None: expected a matrix, or else its factor"),
            ({"delassus": None, "factor": np.eye(4)}, r"factor has shape \(4, 4\).*expected 3 rows"),
            ({"delassus": np.full((3, 3), np.nan)}, r"delassus\[0, 0\] is nan"),
            ({"free": [1.0, 2.0]}, r"free \(2,\): expected 3 rows"),
            ({"free": [1.0, 2.0, np.inf]}, r"free\[2\] is inf"),
            ({"friction": [-0.1]}, "friction is .*expected coefficients >= 0"),
            ({"friction": 0.1}, "friction has shape"),
            ({"keys": ["a", "b"]}, "keys has 2 entries"),
            ({"factor": "J"}, "factor is 'J'"),
        ],
    )
    def test_bad_input_is_named(self, change, words):
        given = {"delassus": np.eye(3), "free": np.ones(3), "friction": [0.1]}
        with pytest.raises(ModelError, match=words):
            SpatialContactProblem(**(given | change))


class TestWhoRefuses:
    @pytest.mark.parametrize("name", PLANAR)
    def test_solvers_of_lcps_refuse_by_name(self, name):
        solver = getattr(solvers, name)()
        for told in (solver.refuses(STICKING),):
            assert told.startswith(f"{name} solves LCPs: SpatialContactProblem is no LCP")
        with pytest.raises(ModelError, match=f"{name} solves LCPs"):
            solver.solve(STICKING)
        with pytest.raises(ModelError, match=f"{name} solves LCPs"):
            STICKING.solve_by(solver)

    def test_no_lcp_is_made_of_one(self):
        with pytest.raises(ModelError, match="no LCP, as friction in space obeys a cone"):
            STICKING.lcp()

    def test_functions_of_matrices_refuse_too(self):
        with pytest.raises(
            ModelError,
            match='takes is "arrays"; with UserSolver',
        ):
            UserSolver(lambda M, q: q).solve(STICKING)

    def test_functions_of_problems_are_judged(self):
        good = UserSolver(lambda problem: [0.5, -0.1, -0.05], takes="problem")
        assert good.refuses(STICKING) == ""
        assert good.solve(STICKING).solved
        assert STICKING.solve_by(good).solved
        bad = UserSolver(lambda problem: [0.5, 0.0, 0.0], takes="problem")
        assert bad.solve(STICKING).status is Status.WRONG

    def test_their_solutions_do_not_start_planar_ones(self):
        """Names of unknowns differ: nothing of a guess in space is taken for a force in the plane."""
        found = accept(STICKING, [0.5, -0.1, -0.05], tolerance=1e-10)
        flat = ContactProblem(np.eye(2), [-1.0, 0.1], [0.3], ["foot"])
        told = solvers.Auto().solve(flat, found)
        assert told.solved
        assert told.z == pytest.approx(solvers.Auto().solve(flat).z, abs=1e-14)
