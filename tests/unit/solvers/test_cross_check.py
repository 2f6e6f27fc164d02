"""Comparisons tell solved from refused, right from wrong, and one motion from another; replays add them up."""

import csv
import io
from dataclasses import dataclass

import numpy as np
import pytest

import lcpflex.solvers
from lcpflex.__main__ import main
from lcpflex.errors import ModelError
from lcpflex.solvers import ContactProblem, Lcp, Lemke, MixedLcp, PrincipalPivoting, Solution, Status, accept
from lcpflex.solvers.benchmark.comparison import all_solvers, cross_check
from lcpflex.solvers.benchmark.files import Recorded, save_problems
from lcpflex.solvers.benchmark.gallery import family
from lcpflex.solvers.benchmark.replays import replay
from lcpflex.solvers.contact.spatial import SpatialContactProblem

DEFINITE = Lcp([[2.0, 1.0], [1.0, 2.0]], [-1.0, -1.0])  # z = (1, 1)/3, w = 0
TWO_FEET = ContactProblem(np.ones((2, 2)), [-1.0, -1.0], [0.0, 0.0])  # the same velocities for all forces of sum 1
SLIDING = ContactProblem([[1.0, 0.2], [0.2, 1.0]], [-1.0, 0.5], [0.3])
INFEASIBLE = Lcp([[-1.0]], [-1.0])
NOT_UNIQUE = Lcp([[-1.0]], [1.0])  # z = 0 with w = 1, and z = 1 with w = 0


@dataclass(frozen=True)
class Fixed:
    """Claims a point whatever the problem."""

    z: tuple[float, ...]
    status: Status = Status.SOLVED
    residual: float = 0.0
    tolerance: float = 1e-10

    def refuses(self, problem):
        return ""

    def solve(self, problem, guess=None):
        z = np.array(self.z)
        return Solution(z, problem.slack(z), self.status, self.residual, 1, "fixed")


@dataclass(frozen=True)
class Broken:
    def refuses(self, problem):
        return ""

    def solve(self, problem, guess=None):
        raise ZeroDivisionError("first line\nsecond line")


@dataclass(frozen=True)
class OtherModel:
    model = "associated friction"

    def refuses(self, problem):
        return ""

    def solve(self, problem, guess=None):
        return Fixed((5.0, 5.0)).solve(problem)


def _rows(check):
    return {row.solver: row for row in check.rows}


class TestAllSolvers:
    def test_every_exported_solver_is_there(self, monkeypatch):
        names = set(all_solvers())
        assert {"Auto", "Lemke", "PrincipalPivoting", "Enumeration"} <= names
        assert "QuadraticProgram(clarabel)" in names
        assert not names & {"Lcp", "ContactProblem", "MixedLcp", "Solution", "Status", "solve_lcp"}
        monkeypatch.setattr(lcpflex.solvers, "__all__", [*lcpflex.solvers.__all__, "Broken"])
        monkeypatch.setattr(lcpflex.solvers, "Broken", Broken, raising=False)
        assert set(all_solvers()) == names | {"Broken"}

    def test_those_that_refuse_the_problem_are_left_out(self):
        assert "PrincipalPivoting" in all_solvers(DEFINITE)
        assert "PrincipalPivoting" not in all_solvers(SLIDING)


class TestCrossCheck:
    @pytest.mark.parametrize("problem", [DEFINITE, TWO_FEET, SLIDING], ids=["definite", "two feet", "sliding"])
    def test_all_solvers_agree(self, problem):
        check = cross_check(problem, repeats=1)
        solved = [row for row in check.rows if row.solved and not row.model]
        assert len(solved) >= 4
        assert all(row.same_motion for row in solved)
        assert not check.contradictory
        assert check.verdict.startswith(f"all {len(solved)} solvers that solved it agree in ")
        assert all(row.remark for row in check.rows if not row.solved)

    def test_redundant_contacts_share_the_motion_not_the_forces(self):
        check = cross_check(TWO_FEET, {"left": Fixed((1.0, 0.0)), "right": Fixed((0.0, 1.0))}, repeats=1)
        assert [row.same_motion for row in check.rows] == [True, True]
        assert [row.difference for row in check.rows] == [0.0, 1.0]
        assert "all 2 solvers" in check.verdict
        assert "contact velocities" in check.verdict

    def test_certified_solutions_that_differ_are_not_wrong(self):
        check = cross_check(NOT_UNIQUE, {"zero": Fixed((0.0,)), "one": Fixed((1.0,))}, repeats=1)
        assert [row.same_motion for row in check.rows] == [True, False]
        assert not check.contradictory
        assert check.verdict == "one: another solution than zero, both certified; w may differ"

    def test_an_inaccurate_point_of_a_unique_motion_is_named(self):
        near = Fixed((1 / 3 + 1e-4, 1 / 3), residual=1e-4, tolerance=1e-3)
        check = cross_check(DEFINITE, {"exact": Lemke(), "near": near}, repeats=1)
        assert check.verdict == "near: differs from exact in w, though unique: less accurate"

    @pytest.mark.parametrize("z", [(0.0, 0.0), (1.0, 1.0), (np.nan, 0.0)])
    def test_a_wrong_claim_is_found_and_is_no_reference(self, z):
        check = cross_check(DEFINITE, {"liar": Fixed(z), "Lemke": Lemke()}, repeats=1)
        assert check.contradictory
        assert check.verdict == "wrong claim by liar"
        assert check.reference == "Lemke"
        rows = _rows(check)
        assert (rows["liar"].wrong, rows["Lemke"].wrong) == (True, False)
        assert rows["liar"].same_motion is None

    @pytest.mark.parametrize("status", [Status.INFEASIBLE, Status.NO_SOLUTION])
    def test_a_proof_against_a_solution_is_wrong(self, status):
        prover = Fixed((0.0, 0.0), status=status, residual=1.0)
        check = cross_check(DEFINITE, {"Lemke": Lemke(), "prover": prover}, repeats=1)
        assert _rows(check)["prover"].wrong
        assert check.contradictory

    def test_proofs_alone_are_right(self):
        check = cross_check(INFEASIBLE, {"Lemke": Lemke(), "pivoting": PrincipalPivoting()}, repeats=1)
        assert not check.contradictory
        assert check.reference == ""
        assert check.verdict == "no solution exists, says Lemke, pivoting"

    def test_an_honest_failure_is_neither(self):
        check = cross_check(DEFINITE, {"lost": Fixed((9.0, 9.0), Status.ITERATION_LIMIT, 1.0)}, repeats=1)
        assert not check.contradictory
        assert check.verdict == "no solver solved it"

    def test_a_crash_is_a_row(self):
        check = cross_check(DEFINITE, {"Broken": Broken(), "Lemke": Lemke()}, repeats=1)
        row = _rows(check)["Broken"]
        assert row.status == "failed"
        assert row.remark == "ZeroDivisionError: first line"
        assert _rows(check)["Lemke"].solved

    def test_another_model_is_no_rival(self):
        check = cross_check(DEFINITE, {"convex": OtherModel(), "Lemke": Lemke()}, repeats=1)
        row = _rows(check)["convex"]
        assert not row.wrong
        assert row.same_motion is None
        assert "another model: associated friction" in str(check)
        assert check.verdict == "only Lemke solved it"

    def test_agreement_does_not_depend_on_units(self):
        for scale in (1e-30, 1.0, 1e30):
            problem = Lcp([[-scale]], [scale])
            check = cross_check(problem, {"zero": Fixed((0.0,)), "one": Fixed((1.0,))}, repeats=1)
            assert [row.same_motion for row in check.rows] == [True, False]

    def test_problems_posed_otherwise(self):
        problem = MixedLcp([[2.0, 1.0], [1.0, 2.0]], [1.0, -1.0], free=[0])
        check = cross_check(problem, {"Lemke": Lemke(), "Auto": lcpflex.solvers.Auto()}, repeats=1)
        assert check.verdict == "all 2 solvers that solved it agree in w"

    def test_empty_problem(self):
        check = cross_check(Lcp(np.zeros((0, 0)), []), repeats=1)
        assert not check.contradictory
        assert _rows(check)["Auto"].solved

    @pytest.mark.parametrize("repeats", [0, -1, 1.5, None, True])
    def test_repeats(self, repeats):
        with pytest.raises(ModelError, match="repeats is"):
            cross_check(DEFINITE, repeats=repeats)

    def test_what_no_solver_takes(self):
        with pytest.raises(ModelError, match="problem is a ndarray, which no solver takes"):
            cross_check(np.eye(3))

    def test_contact_in_space_is_refused_by_solvers_of_lcps(self):
        row = cross_check(SpatialContactProblem(np.eye(3), np.zeros(3), [0.1]), {"Lemke": Lemke()}, repeats=1).rows[0]
        assert row.status == "refused"
        assert row.remark.startswith("Lemke solves LCPs: SpatialContactProblem is no LCP")


class TestTables:
    check = staticmethod(lambda: cross_check(SLIDING, {"Lemke": Lemke(), "pivoting": PrincipalPivoting()}, repeats=1))

    def test_columns_are_aligned(self):
        head, lemke, pivoting, blank, verdict = str(self.check()).splitlines()
        assert blank == ""
        assert verdict == "only Lemke solved it"
        for title, cell, refused in (("status", "SOLVED", "-"), ("same motion", "yes", "-")):
            place = head.index(title)
            assert lemke[place:].startswith(cell)
            assert pivoting[place:].startswith(refused)
        assert "M is not symmetric" in pivoting

    def test_markdown_has_as_many_cells_in_each_line(self):
        lines = self.check().markdown().splitlines()
        assert len(lines) == 4
        assert len({line.replace("\\|", "").count("|") for line in lines}) == 1

    def test_csv_reads_back(self):
        check = self.check()
        lemke, pivoting = csv.DictReader(io.StringIO(check.csv()))
        assert float(lemke["residual"]) == check.rows[0].residual
        assert float(lemke["time"]) == check.rows[0].time
        assert pivoting["status"] == "refused"
        assert pivoting["remark"] == check.rows[1].remark


class TestReplay:
    def test_sums(self):
        named = {"Lemke": Lemke(), "pivoting": PrincipalPivoting(), "liar": _Liar(), "Broken": Broken()}
        result = replay([DEFINITE, Recorded("slide", SLIDING), INFEASIBLE], named, repeats=1)
        rows = _rows(result)
        counts = {n: (r.solved, r.proved, r.refused, r.failed, r.wrong) for n, r in rows.items()}
        assert counts == {
            "Lemke": (2, 1, 0, 0, 0),
            "pivoting": (1, 1, 1, 0, 0),
            "liar": (0, 0, 0, 0, 3),
            "Broken": (0, 0, 0, 3, 0),
        }
        assert result.names == ("problem 0", "slide", "problem 2")
        assert np.isfinite(result.times).tolist() == [[True] * 3, [True, False, True], [False] * 3, [False] * 3]
        assert rows["Lemke"].time == pytest.approx(result.times[0].sum())
        assert result.contradictory
        assert result.verdict.splitlines()[0] == "3 problems: wrong claims by liar"
        assert result.findings[1] == "slide: wrong claim by liar"

    @pytest.mark.slow
    def test_gallery_without_wrong_claims(self):
        problems = [p for name in ("boxes", "kkt") for p in family(name, sizes=(1, 3))]
        result = replay(problems, repeats=1)
        assert not result.contradictory
        assert not any(row.wrong for row in result.rows)
        assert _rows(result)["Auto"].failed == 0

    def test_warm_starts_from_the_last_solution_of_the_same_solver(self):
        log = []

        class Watched:
            def refuses(self, problem):
                return ""

            def solve(self, problem, guess=None):
                log.append(None if guess is None else float(guess.z[0]))
                return accept(problem, -problem.q / problem.M[0], tolerance=1e-10)

        problems = [Lcp([[1.0]], [-1.0]), Lcp([[1.0]], [-2.0]), Lcp([[1.0]], [-3.0])]
        replay(problems, {"it": Watched()}, repeats=1)
        assert log == [None] * 6
        log.clear()
        replay(problems, {"it": Watched()}, repeats=1, warm=True)
        assert log == [None, None, 1.0, 1.0, 2.0, 2.0]

    def test_warm_over_problems_of_other_sizes(self):
        problems = [DEFINITE, SLIDING, TWO_FEET, Lcp([[1.0]], [-1.0]), DEFINITE]
        result = replay(problems, repeats=1, warm=True)
        assert not result.contradictory
        assert _rows(result)["Auto"].solved == 5
        assert not any("Error" in row.remark for row in result.rows)

    def test_progress(self):
        seen = []
        replay([DEFINITE, SLIDING], {"Lemke": Lemke()}, repeats=1, progress=lambda *numbers: seen.append(numbers))
        assert seen == [(1, 2), (2, 2)]

    def test_tables_and_picture(self, tmp_path):
        result = replay([DEFINITE, SLIDING], {"Lemke": Lemke(), "pivoting": PrincipalPivoting()}, repeats=1)
        assert str(result).endswith("2 problems: no wrong claim, and all who solved a problem agree")
        assert len(result.markdown().splitlines()) == 4
        assert [row["solved"] for row in csv.DictReader(io.StringIO(result.csv()))] == ["2", "1"]
        result.plot().savefig(tmp_path / "x.png")
        assert (tmp_path / "x.png").stat().st_size > 10_000

    def test_another_model_is_not_in_the_picture(self):
        result = replay([DEFINITE], {"convex": OtherModel(), "Lemke": Lemke()}, repeats=1)
        (axes,) = result.plot().axes
        assert [text.get_text() for text in axes.get_legend().get_texts()] == ["Lemke, 100 %"]

    @pytest.mark.parametrize(("problems", "solvers"), [([], None), ([DEFINITE], {})])
    def test_nothing_to_do(self, problems, solvers):
        with pytest.raises(ModelError, match="is empty"):
            replay(problems, solvers)


class _Liar:
    def refuses(self, problem):
        return ""

    def solve(self, problem, guess=None):
        return Fixed((9.0,) * problem.size).solve(problem)


class TestCommand:
    """``lcpflex cross-check``."""

    def _file(self, folder):
        return str(save_problems(folder / "x.npz", [DEFINITE, SLIDING], ["definite", "slide"]))

    def test_many_problems(self, tmp_path, capsys):
        picture = tmp_path / "profile.png"
        assert main(["cross-check", self._file(tmp_path), "--repeats", "1", "--plot", str(picture)]) == 0
        told = capsys.readouterr().out
        assert "2 problems: no wrong claim" in told
        assert str(picture) in told
        assert picture.stat().st_size > 10_000

    def test_one_of_them_by_some_solvers(self, tmp_path, capsys):
        request = ["cross-check", self._file(tmp_path), "--index", "1", "--repeats", "1"]
        assert main([*request, "--solver", "Lemke", "--solver", "QuadraticProgram"]) == 0
        told = capsys.readouterr().out
        assert told.startswith("slide\n")
        assert "only Lemke solved it" in told
        assert "QuadraticProgram(clarabel)" in told
        assert "Enumeration" not in told

    def test_text(self, tmp_path, capsys):
        (tmp_path / "x.dat").write_text("1\n2\n-1\n")
        assert main(["cross-check", str(tmp_path / "x.dat"), "--solver", "Lemke", "--repeats", "1"]) == 0
        assert "only Lemke solved it" in capsys.readouterr().out

    def test_a_wrong_claim_is_an_error(self, tmp_path, monkeypatch):
        monkeypatch.setattr("lcpflex.cli.later.all_solvers", lambda: {"liar": _Liar(), "Lemke": Lemke()})
        assert main(["cross-check", self._file(tmp_path)]) == 1
        assert main(["cross-check", self._file(tmp_path), "--index", "0"]) == 1
        assert main(["cross-check", self._file(tmp_path), "--solver", "Lemke"]) == 0

    @pytest.mark.parametrize(
        ("more", "words"),
        [
            (["--index", "2"], "holds 2 problems"),
            (["--index", "-1"], "holds 2 problems"),
            (["--solver", "Simplex"], "no solver 'Simplex'; expected one of AlartCurnier, Auto"),
            (["--repeats", "0"], "repeats is 0"),
            (["--plot", "/no/such/folder/x.png"], "folder"),
        ],
    )
    def test_bad_requests(self, tmp_path, capsys, more, words):
        assert main(["cross-check", self._file(tmp_path), *more]) == 2
        assert words in capsys.readouterr().err

    @pytest.mark.parametrize("name", ["none.npz", "none.dat", "none.zip", "none"])
    def test_bad_files(self, tmp_path, capsys, name):
        assert main(["cross-check", str(tmp_path / name)]) == 2
        assert name in capsys.readouterr().err

    def test_file_without_problems(self, tmp_path, capsys):
        assert main(["cross-check", str(save_problems(tmp_path / "x.npz", []))]) == 2
        assert "holds no problem" in capsys.readouterr().err
