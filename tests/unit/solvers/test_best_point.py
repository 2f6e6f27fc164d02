"""Of two methods that both fail the better point is given, and why the last one failed."""

from dataclasses import replace

import numpy as np
import pytest

from lcpflex.solvers import Auto, BlockGaussSeidel, ContactProblem, Status, accept, auto
from tests.piles import columns


@pytest.fixture
def swept(monkeypatch):
    """A problem by its factor, sweeps that end before its solution, and nothing better behind them."""
    J, free, mu = columns(1, 6, ratio=1e6, push=0.8)
    short = BlockGaussSeidel(1e-13, sweep_limit=1)
    monkeypatch.setattr(auto, "_swept", lambda problem, guess, tolerance: short.solve(problem, guess))

    def fails(self, problem, *others):
        return accept(problem, np.zeros(problem.size), tolerance=1e-10, status=Status.RAY, route="nothing")

    monkeypatch.setattr(Auto, "_first", fails)
    monkeypatch.setattr(Auto, "_dense", lambda self, problem, first, trials: first)
    return ContactProblem(None, free, mu, factor=J), short


def test_of_few_contacts(swept):
    problem, short = swept
    expected, found = short.solve(problem), Auto().solve(problem)
    assert 0.0 < expected.residual < problem.residual(np.zeros(problem.size))
    assert np.array_equal(found.z, expected.z)
    assert found.status is Status.RAY
    assert found.message.startswith("ray: ")
    assert found.route == "block Gauss-Seidel (failed) > nothing (failed)"


@pytest.mark.parametrize("status", [Status.ITERATION_LIMIT, Status.INACCURATE])
def test_of_many_contacts(swept, status):
    problem, short = swept
    words = status.name.lower().replace("_", " ")
    near = replace(short.solve(problem), status=status, message=f"{words}: as it was")
    worse = accept(problem.lcp(), np.zeros(problem.size), tolerance=1e-10, status=Status.RAY, route="nothing")
    found = Auto()._last_word(problem, near, worse, 1)
    assert np.array_equal(found.z, near.z)
    assert found.status is (Status.INACCURATE if status is Status.INACCURATE else Status.RAY)
    assert found.message.startswith(found.status.name.lower())
    assert found.iterations == near.iterations + worse.iterations
