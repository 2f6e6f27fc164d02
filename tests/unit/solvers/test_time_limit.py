"""Limits of the time of a solve: of the solvers of the library, and of those that run in a process of their own."""

import os
from dataclasses import replace

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.errors import ModelError
from lcpflex.gallery import scenes
from lcpflex.solvers import (
    Auto,
    BlockGaussSeidel,
    GaussSeidel,
    Lcp,
    Lemke,
    MinMapNewton,
    PrincipalPivoting,
    SpatialContactProblem,
    Status,
    TimeLimit,
    UserSolver,
    clock,
    cross_check,
)
from lcpflex.solvers.clock import grown, within
from lcpflex.solvers.contact import user_rows
from lcpflex.solvers.lcp import gauss_seidel
from lcpflex.solvers.lcp.gauss_seidel import projected_gauss_seidel

PROBLEM = Lcp([[2.0, 1.0], [1.0, 2.0]], [-1.0, -1.0])


def exact(M, q):
    """z of a positive definite problem, by Lemke of this package on copies."""
    return Lemke().solve(Lcp(M, q)).z


def _hard(n):
    """The problem on which Lemke's path has 2^n pivots (Murty 1978)."""
    return Lcp(np.eye(n) + 2.0 * np.tril(np.ones((n, n)), -1), -np.ones(n))


class TestTimeLimit:
    def test_ours_stop_with_the_best_point(self, monkeypatch):
        """A sweep takes 1/1024 s by this clock, and none is the last: two of the rows have no solution."""
        M, q, now = np.eye(100), np.full(100, -100.0), [5.0]
        M[:2, :2], q[:2] = [[1.0, -1.0], [-1.0, 1.0]], -1.0
        problem = Lcp(M, q)

        def timed(*given):
            found = projected_gauss_seidel(*given)
            now[0] += found[1] / 1024
            return found

        monkeypatch.setattr(clock, "perf_counter", lambda: now[0])
        monkeypatch.setattr(gauss_seidel, "projected_gauss_seidel", timed)
        slow = GaussSeidel(tolerance=1e-16, sweep_limit=10_000)
        found = TimeLimit(slow, 0.3).solve(problem)
        assert 0.1 < now[0] - 5.0 <= 0.3
        assert found.status is Status.TIME_LIMIT
        assert found.residual == problem.residual(found.z) < 0.1 * problem.residual(np.zeros(100))
        assert "time limit" in found.message
        assert slow.solve(problem).status is Status.ITERATION_LIMIT

    def test_what_ends_in_time_is_the_same_to_the_bit(self):
        rng = np.random.default_rng(2)
        for n in (2, 20, 120):
            A = rng.normal(size=(n, n))
            problem = Lcp(A @ A.T + 0.1 * np.eye(n), rng.normal(size=n))
            for solver in (Auto(), Lemke(), PrincipalPivoting(), MinMapNewton(), GaussSeidel(), BlockGaussSeidel()):
                assert np.array_equal(TimeLimit(solver, 3600.0).solve(problem).z, solver.solve(problem).z)
        assert np.array_equal(TimeLimit(Lemke(), 3600.0).solve(_hard(12)).z, Lemke().solve(_hard(12)).z)

    def test_limits_grow_until_the_time_is_up(self, monkeypatch):
        now, asked = [5.0], []
        monkeypatch.setattr(clock, "perf_counter", lambda: now[0])

        def solve(most):
            asked.append(most)
            now[0] += 2e-4 * most
            return most

        assert grown(asked.append, 7, 10**6, lambda found: True) == (None, False)  # without a limit at once
        assert asked == [7]
        asked.clear()
        with within(0.2):
            assert grown(solve, 10**6, 10**6, lambda found: True) == (640, True)
        assert asked == [10, 40, 160, 640]  # 2560 would take 0.5 s
        assert grown(solve, 10**6, 10**6, lambda found: found == 10**6) == (10**6, False)

    def test_parts_in_space_are_not_looked_for_when_it_is_up(self, monkeypatch):
        looked = []
        monkeypatch.setattr(user_rows, "solved_by_parts", lambda problem, *rest: looked.append(problem))
        J = np.random.default_rng(3).standard_normal((60, 12))
        problem = SpatialContactProblem(J @ J.T, J @ np.ones(12), np.full(20, 3.0))
        assert TimeLimit(Auto(), 1e-9).solve(problem).status is Status.TIME_LIMIT
        assert not looked

    def test_the_chain_of_auto_ends(self):
        problem = Lcp([[-1.0, 0.5], [0.3, -2.0]], [-1.0, -1.0])
        with within(1e-9):
            found = Auto().solve(problem)
        assert found.status in (Status.TIME_LIMIT, Status.INFEASIBLE, Status.RAY)
        assert not found.solved

    @pytest.mark.parametrize("seconds", [0.0, -1.0, np.nan, np.inf, "1", True, None])
    def test_times_that_are_none(self, seconds):
        with pytest.raises(ModelError, match="seconds"):
            TimeLimit(Lemke(), seconds)
        if seconds is not None:
            with pytest.raises(ModelError, match="time_limit"):
                cross_check(PROBLEM, repeats=1, time_limit=seconds)


@pytest.mark.skipif(not hasattr(os, "fork"), reason="processes are made by fork")
class TestProcess:
    def test_one_that_does_not_end_is_killed(self):
        def hangs(M, q):
            for _ in range(10**9):  # half a minute, so that the test fails where nobody kills it
                pass
            return exact(M, q)

        check = cross_check(PROBLEM, {"hangs": hangs, "Lemke": Lemke()}, repeats=1, time_limit=0.2)
        row = check.rows[0]
        assert row.status == "TIME_LIMIT"
        assert "killed in its process after 0.2 s" in row.remark
        assert not row.wrong
        assert check.rows[1].solved

    @pytest.mark.parametrize(("way", "words"), [("exit", "exit code 3"), ("kill", "SIGKILL"), ("raise", "ValueError")])
    def test_one_that_ends_its_process(self, way, words):
        def ends(M, q):
            if way == "exit":
                os._exit(3)
            if way == "kill":
                os.kill(os.getpid(), 9)
            raise ValueError("no")

        solver = UserSolver(ends, time_limit=60.0)
        for _ in range(2):
            found = solver.solve(PROBLEM)
            assert found.status is Status.NUMERICAL_FAILURE
            assert words in found.message

    def test_one_process_for_many_calls(self):
        solver = UserSolver(lambda M, q: {"z": exact(M, q), "iterations": os.getpid()}, time_limit=60.0)
        numbers = {solver.solve(PROBLEM).iterations for _ in range(5)}
        assert len(numbers) == 1
        assert numbers != {os.getpid()}
        (worker,) = solver._workers
        process = worker._process
        assert process.is_alive()
        del worker, solver
        process.join(60.0)
        assert not process.is_alive()

    def test_a_run_goes_on_as_without(self):
        case = scenes()["stack"]
        runs = [
            lf.simulate(case.build(), 0.003, replace(case.stepper, solver=solver), progress=False)
            for solver in (exact, TimeLimit(exact, 60.0))
        ]
        assert np.array_equal(runs[0].q, runs[1].q)
