"""One Newton's method over any operator and any law, and the table of attempts around it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from lcpflex.jit.kernel import FloatArray
from lcpflex.jit.struct import allocate
from lcpflex.solvers.contact.alart_curnier import alart_curnier
from lcpflex.solvers.contact.best import Best
from lcpflex.solvers.contact.judging import Judged, measure_loads
from lcpflex.solvers.contact.laws import BILATERAL, COULOMB, HALF_LINE
from lcpflex.solvers.contact.operators import (
    add_effect,
    defect,
    factorise,
    factorise_moving,
    moves_centre,
    prepare,
    solve,
    unknowns,
)
from lcpflex.solvers.contact.operators.sparse_factor import widen
from lcpflex.solvers.contact.proximal_newton import LEAST_EPS, NewtonWork, answers_at, linearise, proximal_newton
from lcpflex.solvers.contact.strategy import Attempt, attempts_for, find, route_names, search_for
from tests.unit.solvers.test_block_iteration import LIKE, Problem

LAWS = [(COULOMB,), (COULOMB, HALF_LINE), (BILATERAL, COULOMB)]


class Posed:
    """A problem with the memory of a search."""

    def __init__(self, problem: Problem, storage: str) -> None:
        self.problem, self.group, self.op = problem, problem.group, problem.operator(storage)
        self.like = LIKE[problem.rows]
        count = unknowns(self.op, self.group)
        sizes = {"units": problem.n, "rows": problem.rows, "block": problem.rows**2, "unknowns": count}
        self.judged, self.best, self.work = Judged(), allocate(Best, sizes), allocate(NewtonWork, sizes)
        self.judged.tolerance, self.best.worst, self.work.floor = 1e-11, 1e300, LEAST_EPS
        measure_loads(self.group, self.judged)
        while not prepare(self.op, self.group):
            widen(self.op.factor)

    @property
    def search(self) -> tuple[Any, ...]:
        """What kernels of a search take first."""
        return self.op, self.group, self.judged, self.best, self.work


@pytest.mark.parametrize("storage", ["bodies", "dense"])
@pytest.mark.parametrize("rows", [2, 3])
@pytest.mark.parametrize("laws", LAWS, ids=str)
def test_newton_alone_solves_from_nothing(rows: int, storage: str, laws: tuple[int, ...]) -> None:
    """Forces obey the laws, as numpy says."""
    for seed in range(6):
        posed = Posed(Problem(rows, 9, seed, laws), storage)
        assert proximal_newton(*posed.search, 1e-2, 200, posed.like)
        assert posed.problem.miss(posed.best.p) <= 1e-10 * posed.judged.load


@pytest.mark.parametrize("storage", ["bodies", "dense"])
@pytest.mark.parametrize("rows", [2, 3])
def test_steps_are_those_of_newton(rows: int, storage: str) -> None:
    """J dx = -F by differences of F, in a state that the step does not leave."""
    posed = Posed(Problem(rows, 6, 1, (COULOMB, BILATERAL)), storage)
    op, group, work, like = posed.op, posed.group, posed.work, posed.like
    n, eps = unknowns(op, group), 0.3
    work.base[:] = group.free
    x = 0.1 * np.random.default_rng(4).normal(size=n)

    def rest(x: FloatArray) -> FloatArray:
        answers_at(op, group, work, x, eps, like)
        return work.rest[:n].copy()

    start = rest(x)
    states = work.state.copy()
    linearise(group, work, eps, like)
    assert factorise(op, group, work.C, like)
    step = -start
    solve(op, group, step)
    h = 1e-6 / np.abs(step).max()
    slope = (rest(x + h * step) - rest(x - h * step)) / (2.0 * h)
    assert (work.state == states).all()
    assert slope == pytest.approx(-start, abs=1e-5 * np.abs(start).max())


@pytest.mark.parametrize("rows", [2, 3])
def test_forces_and_bodies_measure_the_same(rows: int) -> None:
    """Effects of one set of forces by both operators, and the size of F: sqrt(F.W F) = |J^T F|."""
    problem, forces = Problem(rows, 7, 2), np.random.default_rng(0).normal(size=(7, rows))
    sizes = []
    effects = []
    for storage in ("bodies", "dense"):
        posed = Posed(problem, storage)
        x = problem.factor.T @ forces.ravel() if storage == "bodies" else forces.ravel()
        y, rest = np.zeros((7, rows)), np.zeros(len(x))
        add_effect(posed.op, posed.group, x, problem.free, y, posed.like)
        sizes.append(defect(posed.op, posed.group, x, 0.5 * forces, rest, posed.like))
        effects.append(y)
    assert sizes[0] == pytest.approx(sizes[1], rel=1e-12)
    assert effects[0] == pytest.approx(effects[1], abs=1e-12)


def test_the_table_is_read_until_something_solves() -> None:
    """What was tried is told; rows for other problems are not there; nothing lost where nothing solves."""
    table = (Attempt(0, 10, patient=False, when=0), Attempt(1, 200, eps=1e-2), Attempt(3, 10, eps=0.1, rows=2))
    for rows in (2, 3):
        posed = Posed(Problem(rows, 8, 3), "dense")
        attempts = attempts_for(rows, table)
        assert attempts.n == (3 if rows == 2 else 2)
        search = search_for(attempts)
        assert find(*posed.search, search, attempts, posed.like)
        assert posed.problem.miss(posed.best.p) <= 1e-10 * posed.judged.load
        assert route_names(search, attempts) in ("sweeps", "sweeps > Newton")
        search.factor_limit = 0
        posed.group.p[:] = 0.0
        worst = posed.best.worst
        posed.judged.tolerance = 0.0
        assert find(*posed.search, search, attempts, posed.like)
        assert route_names(search, attempts).endswith("best point of all")
        assert posed.best.worst <= max(worst, posed.problem.miss(np.zeros((8, rows))))


@pytest.mark.parametrize("rows", [2, 3])
@pytest.mark.parametrize("laws", LAWS, ids=str)
def test_alart_curnier_comes_to_rounding(rows: int, laws: tuple[int, ...]) -> None:
    """From forces that are nearly right; velocities of bodies are no unknowns for it."""
    for seed in range(4):
        posed = Posed(Problem(rows, 9, seed, laws), "dense")
        assert proximal_newton(*posed.search, 1e-2, 200, posed.like)
        p = posed.group.p
        p[:] = posed.best.p * (1.0 + 1e-5 * np.random.default_rng(seed).normal(size=p.shape))
        posed.best.worst = 1e300
        assert alart_curnier(*posed.search, 40, posed.like)
        assert posed.problem.miss(posed.best.p) <= 1e-13 * max(1.0, np.abs(posed.best.p).max())
    bodies = Posed(Problem(rows, 9, 0, laws), "bodies")
    assert not moves_centre(bodies.op)
    assert not factorise_moving(bodies.op, bodies.group, bodies.work.C, bodies.like)
