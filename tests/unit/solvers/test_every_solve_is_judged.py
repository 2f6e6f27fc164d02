"""Comparisons judge every solve and tell reasons whole; a wrong point is called wrong, with what was meant."""

import itertools

import numpy as np
import pytest

from lcpflex.solvers import (
    Auto,
    BoxedLcp,
    ContactProblem,
    Lcp,
    Lemke,
    Solution,
    SpatialContactProblem,
    Status,
    UserSolver,
    cross_check,
    replay,
)

PROBLEM = Lcp([[2.0, 1.0], [1.0, 2.0]], [-1.0, -2.0])
SLIDING = ContactProblem([[1.0, 0.2], [0.2, 1.0]], [-1.0, 0.5], [0.3])
SPACE = SpatialContactProblem(np.diag([2.0, 1.0, 1.0]), [-1.0, 0.1, 0.05], [0.3])  # it sticks
SLIPPING = SpatialContactProblem(np.diag([2.0, 1.0, 1.0]), [-1.0, 3.0, 0.05], [0.3])


def exact(M, q):
    return Lemke().solve(Lcp(M, q)).z


class Alternating:
    """Answers with one function after the other, in turn."""

    tolerance = 1e-10

    def __init__(self, *answers):
        self.answers = itertools.cycle(answers)

    def refuses(self, problem):
        return ""

    def solve(self, problem, guess=None):
        return next(self.answers)(problem)


def right(problem):
    return Lemke().solve(problem)


def claimed(problem):
    z = np.zeros(problem.size)
    return Solution(z, problem.slack(z), Status.SOLVED, 0.0, 1, "claimed")


def given_up(problem):
    z = np.zeros(problem.size)
    return Solution(z, problem.slack(z), Status.ITERATION_LIMIT, 1.0, 1, "lost", "iteration limit: lost its way")


def raising(problem):
    raise ValueError("out of luck")


class TestEverySolve:
    @pytest.mark.parametrize("order", [(right, claimed), (claimed, right), (right, right, right, claimed)])
    @pytest.mark.parametrize("repeats", [3, 4, 7])
    def test_a_claim_that_is_wrong_at_times_is_wrong(self, order, repeats):
        check = cross_check(PROBLEM, {"fickle": Alternating(*order), "Lemke": Lemke()}, repeats=repeats)
        row = check.rows[0]
        count = sum(order[i % len(order)] is claimed for i in range(repeats + 1))
        assert (row.wrong, row.solved, row.status) == (True, False, "WRONG")
        assert row.remark.startswith(f"{count} of {repeats + 1} solves: claimed SOLVED, but its residual is ")
        assert check.contradictory
        assert check.verdict == "wrong claim by fickle"
        assert check.reference == "Lemke"

    @pytest.mark.parametrize("repeats", [1, 2, 5])
    def test_a_function_that_is_wrong_every_other_time(self, repeats):
        calls = itertools.count()
        fickle = UserSolver(lambda M, q: exact(M, q) if next(calls) % 2 == 0 else 0.0 * q, name="fickle")
        check = cross_check(PROBLEM, [fickle, Lemke()], repeats=repeats)
        assert (check.rows[0].solved, check.rows[0].status) == (False, "WRONG")
        assert f"{(repeats + 1) // 2} of {repeats + 1} solves: wrong: fickle returned" in check.rows[0].remark
        assert check.verdict == "only Lemke solved it"

    def test_failing_at_times_is_failing(self):
        row = cross_check(PROBLEM, {"x": Alternating(right, right, given_up)}, repeats=4).rows[0]
        assert (row.solved, row.status, row.wrong) == (False, "ITERATION_LIMIT", False)
        assert row.remark == "1 of 5 solves: iteration limit: lost its way"
        row = cross_check(PROBLEM, {"x": Alternating(right, raising)}, repeats=4).rows[0]
        assert (row.status, row.remark) == ("failed", "1 of 2 solves: ValueError: out of luck")

    def test_one_that_is_always_the_same_has_no_count(self):
        for answer, words in ((right, ""), (given_up, "iteration limit: lost its way")):
            assert cross_check(PROBLEM, {"x": Alternating(answer)}, repeats=3).rows[0].remark == words

    def test_a_loose_solve_among_tight_ones_tells_its_residual(self):
        z = exact(PROBLEM.M, PROBLEM.q)

        def loose(problem):
            return Solution(z + 1e-11, problem.slack(z + 1e-11), Status.SOLVED, 0.0, 1, "loose")

        row = cross_check(PROBLEM, {"x": Alternating(right, loose)}, repeats=3).rows[0]
        assert row.solved
        assert row.residual == PROBLEM.residual(z + 1e-11) > 1e-12
        assert row.remark == ""

    def test_sums_of_replays_hold_it(self):
        result = replay([PROBLEM, SLIDING], {"x": Alternating(claimed, right)}, repeats=2)
        assert result.rows[0].wrong == 2
        assert result.contradictory


class TestRefusals:
    def test_the_cure_is_there(self):
        check = cross_check(SPACE, [Lemke(), Auto()], repeats=1)
        reason = Lemke().refuses(SPACE)
        assert check.rows[0].remark == reason
        assert reason.endswith("for the LCP of a faceted one")
        for table in (str(check), check.markdown(), check.csv()):
            assert "FacetedCone() for the LCP of a faceted one" in table

    @pytest.mark.parametrize("function", [exact, lambda problem: problem.free])
    def test_a_problem_with_cones_tells_how_it_is_taken(self, function):
        reason = cross_check(SPACE, [function], repeats=1).rows[0].remark
        assert 'UserSolver(function, takes="problem")' in reason
        assert "SpatialContactProblem" in reason
        assert "forces (3 k,), normal and two tangents" in reason
        assert not reason.endswith("...")

    def test_what_it_tells_works(self):
        def mine(p):
            return -np.linalg.solve(p.delassus, p.free)

        check = cross_check(SPACE, [UserSolver(mine, takes="problem"), Auto()], repeats=1)
        assert all(row.solved for row in check.rows)

    def test_lines_of_a_reason_are_one(self):
        class Picky(Alternating):
            def refuses(self, problem):
                return "cannot take it:\n    expected another\n"

        row = cross_check(PROBLEM, {"x": Picky(right)}, repeats=1).rows[0]
        assert (row.status, row.remark) == ("refused", "cannot take it: expected another")


class TestWrongPoints:
    @pytest.mark.parametrize("problem", [PROBLEM, SLIDING, Lcp(1e9 * PROBLEM.M, 1e-3 * PROBLEM.q)], ids=str)
    @pytest.mark.parametrize(
        ("meant", "words"),
        [
            (lambda M, q: -exact(M, q), "; -z would be right"),
            (lambda M, q: exact(M, q) / 1000.0, "; 1000 z would be right"),
            (lambda M, q: 0.01 * exact(M, q), "; 100 z would be right"),
            (lambda M, q: exact(M, q) * 3.0, "; 0.333333 z would be right"),
            (lambda M, q: -2.5 * exact(M, q), "; -0.4 z would be right"),
        ],
    )
    def test_what_was_meant(self, problem, meant, words):
        found = UserSolver(meant, name="mine").solve(problem)
        assert found.status is Status.WRONG
        assert found.message.startswith("wrong: mine returned a z of residual ")
        assert found.message.endswith(words)
        assert words in cross_check(problem, [meant], repeats=1).rows[0].remark

    @pytest.mark.parametrize("scale", [1.0, 4.0])
    def test_the_other_sign_of_q(self, scale):
        problem = Lcp(PROBLEM.M, -PROBLEM.q)  # solved by 0, which is no hint to anything
        found = UserSolver(lambda M, q: exact(M, -q) / scale).solve(problem)
        factor = "it" if scale == 1.0 else f"{scale:g} z"
        assert found.message.endswith(f"; {factor} would solve the problem with -q in place of q")

    def test_other_forms(self):
        box = BoxedLcp([[2.0, 0.0], [0.0, 1.0]], [-1.0, -1.0], [0.0, 0.0], np.inf)
        words = UserSolver(lambda p: np.array([-0.5, -1.0]), takes="problem").solve(box).message
        assert words.endswith("; -z would be right")
        for problem in (SPACE, SLIPPING):
            z = Auto().solve(problem).z
            told = UserSolver(lambda p, z=z: -z, takes="problem").solve(problem).message
            assert told.endswith("; -z would be right")
            told = UserSolver(lambda p, z=z: 1e-3 * z, takes="problem").solve(problem).message
            assert told.endswith("; 1000 z would be right")
        turned = SpatialContactProblem(SPACE.delassus, -SPACE.free, SPACE.friction)
        told = UserSolver(lambda p: Auto().solve(SPACE).z, takes="problem").solve(turned).message
        assert told.endswith("; it would solve the problem with -free in place of free")

    @pytest.mark.parametrize("z", [[0.0, 0.0], [1.0, 1.0], [5.0, -3.0], [1e300, 1e-300], [1e-320, 0.0]])
    def test_no_hint_where_none_is_known(self, z):
        found = UserSolver(lambda M, q: z).solve(PROBLEM)
        assert found.status is Status.WRONG
        assert found.message.endswith("tolerance 1.0e-10")

    def test_a_wrong_claim_has_the_hint_too(self):
        def negative(problem):
            z = -Lemke().solve(problem).z
            return Solution(z, problem.slack(z), Status.SOLVED, 0.0, 1, "")

        row = cross_check(PROBLEM, {"x": Alternating(negative)}, repeats=1).rows[0]
        assert row.wrong
        assert row.remark.endswith("; -z would be right")

    def test_what_is_nearly_right_and_what_gave_up_are_not_called_wrong(self):
        near = UserSolver(lambda M, q: exact(M, q) + 1e-9).solve(PROBLEM)
        assert near.status is Status.INACCURATE
        lost = UserSolver(lambda problem: given_up(problem)).solve(PROBLEM)
        assert (lost.status, lost.message) == (Status.ITERATION_LIMIT, "iteration limit: lost its way")
