"""Functions of the user's own as solvers: read in many forms, judged always, harmless whatever they do."""

import csv
import io
from collections import namedtuple
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

import lcpflex as lf
from lcpflex import gallery
from lcpflex.__main__ import main
from lcpflex.errors import ModelError, StepError
from lcpflex.gallery import scenes
from lcpflex.solvers import (
    Auto,
    ContactProblem,
    ConvexFriction,
    Lcp,
    Lemke,
    MixedLcp,
    Solution,
    Status,
    TimeLimit,
    UserSolver,
    cross_check,
    replay,
    save_problems,
    solve_lcp,
)

PROBLEM = Lcp([[2.0, 1.0], [1.0, 2.0]], [-1.0, -1.0])
Z = [1 / 3, 1 / 3]
SLIDING = ContactProblem([[1.0, 0.2], [0.2, 1.0]], [-1.0, 0.5], [0.3])
Found = namedtuple("Found", "w z num_iter")


def exact(M, q):
    """z of a positive definite problem, by Lemke of this package on copies."""
    return Lemke().solve(Lcp(M, q)).z


def raises(M, q):
    raise ValueError("out of luck\nand more")


ANSWERS = {
    "array": lambda M, q: np.array(Z),
    "list": lambda M, q: Z,
    "tuple": lambda M, q: tuple(Z),
    "column": lambda M, q: np.array(Z)[:, None],
    "row": lambda M, q: np.array([Z]),
    "with more": lambda M, q: (np.array(Z), {"gap": 0.0}, 3),
    "z and w": lambda M, q: (np.array(Z), np.zeros(2)),
    "dictionary": lambda M, q: {"x": Z, "nit": 4},
    "named": lambda M, q: Found(np.zeros(2), np.array(Z), 4),
    "fractions": lambda M, q: [Fraction(1, 3), Fraction(1, 3)],
    "of a problem": lambda problem: exact(problem.M, problem.q),
    "a solution": lambda problem: Lemke().solve(problem),
    "optional": lambda M, q, d=None, *, most=3: exact(M, q),
    "any": lambda *given: exact(*given),
}


class TestAnswers:
    @pytest.mark.parametrize("name", ANSWERS)
    def test_what_is_read(self, name):
        found = UserSolver(ANSWERS[name]).solve(PROBLEM)
        assert found.status is Status.SOLVED
        assert found.z == pytest.approx(Z, abs=1e-15)
        assert found.residual == PROBLEM.residual(found.z)
        assert found.iterations == {"dictionary": 4, "named": 4, "a solution": found.iterations}.get(name, 0)

    @pytest.mark.parametrize(
        ("returned", "words"),
        [
            (None, "returned None"),
            ([1.0], r"shape \(1,\): expected \(2,\)"),
            (np.zeros((2, 2)), r"shape \(2, 2\)"),
            (0.5, r"shape \(\)"),
            ([1.0, np.nan], r"z\[1\] = nan"),
            ([np.inf, 0.0], r"z\[0\] = inf"),
            (np.array(Z, dtype=complex), "complex128"),
            (["a", "b"], "real numbers"),
            ([[1.0], [2.0, 3.0]], "raised ValueError"),
            (np.ma.masked_array(Z, [True, False]), "masked"),
            ((), r"shape \(0,\)"),
            ({}, "raised TypeError|shape"),
            (object(), "shape"),
            ([10**400, 0], "raised OverflowError"),
        ],
    )
    def test_what_is_none(self, returned, words):
        solver = UserSolver(lambda M, q: returned, name="mine")
        found = solver.solve(PROBLEM)
        assert found.status is Status.NUMERICAL_FAILURE
        assert found.message.startswith("numerical failure: mine ")
        assert found.residual == PROBLEM.residual(found.z) > 0.5
        with pytest.raises(lf.SolverError, match=words):
            solve_lcp(PROBLEM, solver=solver)

    @pytest.mark.parametrize("error", [ValueError("x" * 5000), SystemExit(3), MemoryError(), RecursionError("deep")])
    def test_no_exception_escapes(self, error):
        def breaks(M, q):
            raise error

        found = UserSolver(breaks).solve(PROBLEM)
        assert not found.solved
        assert type(error).__name__ in found.message
        assert len(found.message) < 300

    def test_a_problem_without_unknowns_needs_no_call(self):
        solution = UserSolver(raises).solve(Lcp(np.zeros((0, 0)), []))
        assert solution.solved
        assert solution.z.shape == (0,)
        fine = lf.simulate(gallery.bouncing_ball(), 0.1, lf.MoreauJean(step=1e-2, solver=raises))  # it does not touch
        assert fine.complete

    def test_an_interruption_is_not_kept(self):
        def interrupted(M, q):
            raise KeyboardInterrupt

        with pytest.raises(KeyboardInterrupt):
            UserSolver(interrupted).solve(PROBLEM)

    def test_a_failure_is_none_even_where_zero_solves(self):
        trivial = Lcp(PROBLEM.M, [1.0, 1.0])
        assert not UserSolver(raises).solve(trivial).solved

    @pytest.mark.parametrize("scale", [1e-12, 1.0, 1e12])
    def test_a_wrong_point_is_never_solved(self, scale):
        problem = Lcp(scale * PROBLEM.M, scale * PROBLEM.q)
        for z in ([0.0, 0.0], [1.0, 1.0], [-1.0, 2.0], [1 / 3 + 1e-7, 1 / 3]):
            found = UserSolver(lambda M, q, z=z: z).solve(problem)
            assert not found.solved
            claimed = Solution(np.array(z), np.zeros(2), Status.SOLVED, 0.0, 1, "claimed")
            assert not UserSolver(lambda M, q, it=claimed: it).solve(problem).solved

    @pytest.mark.parametrize("status", [Status.INFEASIBLE, Status.NO_SOLUTION, Status.NOT_UNIQUE])
    def test_proofs_need_what_proves_them(self, status):
        claimed = Solution(np.zeros(2), np.zeros(2), status, 1.0, 1, "", certificate=np.ones(2))
        expected = Status.WRONG if status is Status.NOT_UNIQUE else Status.NUMERICAL_FAILURE
        assert UserSolver(lambda M, q: claimed).solve(PROBLEM).status is expected

    def test_a_proof_that_holds_is_one(self):
        problem = Lcp([[-1.0]], [-1.0])
        claimed = Solution(np.zeros(1), np.zeros(1), Status.INFEASIBLE, 1.0, 1, "", certificate=np.ones(1))
        assert UserSolver(lambda M, q: claimed).solve(problem).status is Status.INFEASIBLE

    @pytest.mark.parametrize("takes", ["arrays", "lcp", "problem"])
    def test_what_is_lent_may_be_written_to(self, takes):
        before = PROBLEM.M.copy(), PROBLEM.q.copy()

        def spoils(*given):
            M, q = given if takes == "arrays" else (given[0].M, given[0].q)
            z = exact(M, q)
            M[:], q[:] = np.nan, 7.0
            np.seterr(all="raise")
            if takes != "arrays":
                given[0].data[0][:] = -1.0
            return z

        state = np.geterr()
        assert UserSolver(spoils, takes=takes).solve(PROBLEM).solved
        assert np.array_equal(PROBLEM.M, before[0])
        assert np.array_equal(PROBLEM.q, before[1])
        assert np.geterr() == state
        assert PROBLEM.residual(Z) < 1e-15

    def test_problems_posed_otherwise(self):
        mixed = MixedLcp([[2.0, 1.0], [1.0, 2.0]], [1.0, -1.0], free=[0])
        for problem in (mixed, SLIDING):
            assert UserSolver(exact).solve(problem).solved
        posed = []
        UserSolver(lambda p: posed.append(p) or Lemke().solve(p), takes="problem").solve(SLIDING)
        assert isinstance(posed[0], ContactProblem)

    @pytest.mark.parametrize("bad", [3, "Lemke", None, Lemke, lambda: 1, lambda a, b, c: 1, lambda M, *, q: 1])
    def test_what_is_no_solver(self, bad):
        with pytest.raises(ModelError, match="solver"):
            cross_check(PROBLEM, {"bad": bad})
        with pytest.raises(ModelError, match="solver"):
            lf.MoreauJean(step=1e-3, solver=bad)


class TestComparison:
    def test_residuals_are_judged_here(self):
        claimed = Solution(np.array([0.3, 0.3]), np.zeros(2), Status.SOLVED, 1e-14, 1, "")
        check = cross_check(PROBLEM, {"liar": lambda M, q: claimed, "exact": exact}, repeats=1)
        liar, right = check.rows
        assert liar.residual == PROBLEM.residual([0.3, 0.3]) > 0.05
        assert (liar.status, liar.solved, liar.wrong, liar.claim) == ("WRONG", False, True, "SOLVED")
        assert right.solved
        assert check.verdict == "wrong claim by liar"

    def test_a_solver_without_a_tolerance_needs_that_of_all(self):
        """It once passed with a residual of 1e-3."""
        near = [1 / 3 + 1e-3, 1 / 3]
        assert not cross_check(PROBLEM, [lambda M, q: near], repeats=1).rows[0].solved
        loose = cross_check(PROBLEM, [lambda M, q: near], repeats=1, tolerance=5e-3).rows[0]
        assert (loose.solved, loose.tolerance) == (True, 5e-3)

    def test_a_tolerance_holds_for_all(self):
        class Near:
            tolerance = 1e-3

            def solve(self, problem):
                return np.array([1 / 3 + 1e-5, 1 / 3])

        assert cross_check(PROBLEM, [Near()], repeats=1).rows[0].solved
        strict = cross_check(PROBLEM, [Near(), Lemke()], repeats=1, tolerance=1e-9)
        assert [row.solved for row in strict.rows] == [False, True]
        assert not strict.contradictory

    @pytest.mark.parametrize("tolerance", [0.0, -1.0, 1.0, np.nan, "small"])
    def test_tolerances_that_are_none(self, tolerance):
        with pytest.raises(ModelError, match="tolerance"):
            cross_check(PROBLEM, repeats=1, tolerance=tolerance)

    def test_the_relaxation_is_judged_by_the_law_it_relaxes(self):
        check = cross_check(SLIDING, {"convex": ConvexFriction(), "Lemke": Lemke()}, repeats=1)
        found = ConvexFriction().solve(SLIDING)
        assert check.rows[0].residual == SLIDING.residual(SLIDING.unknowns(*np.split(found.z, [1]))) > 0.01

    def test_failures_are_rows(self):
        check = cross_check(PROBLEM, {"bad": raises, "nan": lambda M, q: q * np.nan, "Lemke": Lemke()}, repeats=2)
        assert [(row.status, row.remark) for row in check.rows[:2]] == [
            ("failed", "ValueError: out of luck"),
            ("failed", "returned z[0] = nan: expected finite numbers"),
        ]
        assert check.verdict == "only Lemke solved it"

    def test_names_of_a_sequence(self):
        check = cross_check(PROBLEM, [exact, exact, Lemke(), lambda M, q: Z], repeats=1)
        assert [row.solver for row in check.rows] == ["exact", "exact 2", "Lemke", "own solver"]
        assert [row.solver for row in cross_check(PROBLEM, exact, repeats=1).rows] == ["exact"]

    def test_csv_tells_the_problem_the_machine_and_the_versions(self):
        result = replay([PROBLEM, SLIDING], {"mine": exact, "Lemke": Lemke(), "bad": raises}, repeats=1)
        lines = list(csv.DictReader(io.StringIO(result.problems_csv())))
        assert [(x["problem"], x["kind"], x["size"], x["solver"]) for x in lines[:4]] == [
            ("problem 0", "Lcp", "2", "mine"),
            ("problem 0", "Lcp", "2", "Lemke"),
            ("problem 0", "Lcp", "2", "bad"),
            ("problem 1", "ContactProblem", "3", "mine"),
        ]
        assert float(lines[1]["residual"]) == result.checks[0].rows[1].residual
        assert lines[1]["solver_version"] == f"lcpflex {lf.__version__}"
        assert lines[1]["route"] == "lemke"
        for line in lines:
            assert line["numpy"] == np.__version__
            assert all(line[name] for name in ("machine", "processor", "cores", "python", "numba", "lcpflex"))

    def test_command(self, tmp_path, capsys):
        (tmp_path / "mine.py").write_text(
            "import numpy as np\nfrom lcpflex.solvers import Lcp, Lemke\n"
            "def good(M, q):\n    return Lemke().solve(Lcp(M, q)).z\n"
            "def bad(M, q):\n    raise ValueError('no')\n"
            "class Kept:\n    def solve(self, problem):\n        return Lemke().solve(problem)\n"
        )
        path = save_problems(tmp_path / "x.npz", [PROBLEM, SLIDING])
        named = [f"{tmp_path / 'mine.py'}:{name}" for name in ("good", "bad", "Kept")]
        request = ["cross-check", str(path), "--repeats", "1", *(x for name in named for x in ("--solver", name))]
        assert main([*request, "--csv", str(tmp_path / "x.csv"), "--tolerance", "1e-9", "--time-limit", "60"]) == 0
        assert "ValueError: no" in capsys.readouterr().out
        lines = list(csv.DictReader(io.StringIO((tmp_path / "x.csv").read_text())))
        assert [x["status"] for x in lines] == ["SOLVED", "failed", "SOLVED"] * 2
        assert main(["cross-check", str(path), "--solver", "lcpflex.solvers:Lemke", "--index", "0"]) == 0
        for wrong in (
            "no.such.module:f",
            "lcpflex.solvers:None_",
            f"{tmp_path / 'mine.py'}:none",
            "none.py:f",
            "os:sep",
        ):
            assert main(["cross-check", str(path), "--solver", wrong]) == 2
            assert "solver" in capsys.readouterr().err


class TestRuns:
    case = staticmethod(lambda: scenes()["stack"])

    def _run(self, solver):
        case = self.case()
        return lf.simulate(case.build(), 0.01, replace(case.stepper, solver=solver), progress=False)

    def test_the_same_motion(self):
        def spoils(M, q):
            z = exact(M, q)
            M[:], q[:] = np.nan, 0.0
            return z.tolist()

        expected = self._run(Lemke())
        for solver in (spoils, lambda problem: Lemke().solve(problem), TimeLimit(Auto(), 60.0)):
            found = self._run(solver)
            assert found.q == pytest.approx(expected.q, abs=1e-12)
            assert found.residual.max() <= 1e-9

    @pytest.mark.parametrize(
        ("solver", "words"),
        [
            (raises, "raises raised ValueError: out of luck"),
            (lambda M, q: np.ones_like(q), "not solved: wrong, natural-map residual"),
            (lambda M, q: -exact(M, q), "own solver returned a z of residual"),
            (lambda M, q: -exact(M, q), "-z would be right"),
            (lambda M, q: q * np.nan, "own solver returned z"),
        ],
    )
    def test_a_failure_stops_the_run_as_one_of_ours_does(self, solver, words):
        with pytest.raises(StepError, match="the contact problem of size 114 was not solved") as stopped:
            self._run(solver)
        assert words in str(stopped.value)
        assert stopped.value.result is not None

    def test_a_class_derived_from_a_compiled_one_is_asked_itself(self):
        asked = []

        class Mine(Lemke):
            def solve(self, problem, guess=None):
                asked.append(problem.size)
                return Lemke().solve(problem, guess)

        self._run(Mine())
        assert asked
