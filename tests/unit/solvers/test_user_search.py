"""The search of steppers on contacts of a user: its sparse factors, and what it comes to in every storage."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import scipy.sparse

from lcpflex.solvers import ContactProblem, SpatialContactProblem
from lcpflex.solvers.clock import within
from lcpflex.solvers.contact.coupling import ConeBlocks
from lcpflex.solvers.contact.strategy import ALART_CURNIER, Attempt, attempts_for
from lcpflex.solvers.contact.system import ContactSystem
from lcpflex.solvers.contact.user_search import UserSearch, _SparseFactors, split_ranks
from tests.cones import heap, tower

STORAGES = ("dense", "blocks", "factor")
SWEEPS, NEWTON = 0, 1


def problem_of(rows: int, n: int = 9, seed: int = 0) -> Any:
    """Contacts of some bodies in units of their own, every fourth one without friction."""
    random = np.random.default_rng(seed)
    friction = np.where(np.arange(n) % 4 == 3, 0.0, random.uniform(0.1, 0.9, n))
    m = 3 * n if rows == 3 else n + np.count_nonzero(friction)
    J = random.standard_normal((m, 2 * n)) * (random.random((m, 2 * n)) < 0.5) + np.eye(m, 2 * n)
    J = np.hstack([J, 0.3 * np.eye(m)])
    make = ContactProblem if rows == 2 else SpatialContactProblem
    return make(J @ J.T, random.standard_normal(m) - 0.3, friction, factor=scipy.sparse.csr_array(J)).balanced()


def system_of(problem: Any, storage: str) -> ContactSystem:
    """The contacts, as they are stored."""
    if storage == "factor":
        return ContactSystem(problem, None)
    if storage == "dense":
        return ContactSystem(problem, problem.dense())
    return ContactSystem(
        problem, problem.coupling if isinstance(problem, ContactProblem) else ConeBlocks(problem.dense())
    )


def residual_of(problem: Any, forces: Any) -> float:
    """Of forces (m,)."""
    planar = isinstance(problem, ContactProblem)
    z = problem.unknowns(*np.split(forces, [len(problem.friction)])) if planar else forces
    return float(problem.residual(z))


@pytest.mark.parametrize("rows", [2, 3])
def test_blocks_are_sums_over_their_ranks(rows: int) -> None:
    """Of rank 0 to S, as far as rounding tells."""
    random, n = np.random.default_rng(1), 40
    C = np.zeros((n, rows, rows))
    for k in range(n):
        for _ in range(k % (rows + 1)):
            C[k] += 10.0 ** random.uniform(-3, 3) * np.outer(*random.standard_normal((2, rows)))
    left, right, rest = np.empty((n * rows, rows + 1)), np.empty((n * rows, rows)), np.empty(rows * rows)
    count = split_ranks(C.reshape(n, -1), (0.0,) * rows, rest, left, right)
    assert np.bincount(left[:count, rows].astype(int), minlength=n).tolist() == [k % (rows + 1) for k in range(n)]
    again = np.zeros_like(C)
    for r in range(count):
        again[int(left[r, rows])] += np.outer(left[r, :rows], right[r])
    assert np.abs(again - C).max(axis=(1, 2)) == pytest.approx(np.zeros(n), abs=1e-11 * np.abs(C).max())


@pytest.mark.parametrize("rows", [2, 3])
@pytest.mark.parametrize("storage", ["blocks", "factor"])
def test_sparse_factors_solve_newtons_equations(rows: int, storage: str) -> None:
    """(I + C W) x = r, or (I + J^T C J) x = r, with numpy's matrices; open and sliding units among them."""
    problem, random = problem_of(rows), np.random.default_rng(2)
    system = system_of(problem, storage)
    n, op, group = system.group.n, system.op, system.group
    C = random.uniform(0.1, 1.0, (n, rows, rows)) * np.eye(rows)
    C[1] = 0.0
    C[2, 1:, 1:] = 0.0
    C[2, 1:, 0] = 0.4 * C[2, 0, 0]
    J = np.where(system.row.reshape(-1, 1) >= 0, problem.factor.toarray()[system.row.ravel()], 0.0)
    D = scipy.sparse.block_diag(C).toarray()
    matrix = np.eye(len(D)) + D @ (J @ J.T) if storage == "blocks" else np.eye(J.shape[1]) + J.T @ D @ J
    factors, right = _SparseFactors(system), random.standard_normal(len(matrix))
    assert factors.factorise(op, group, C.reshape(n, -1), system.like)
    x = right.copy()
    factors.solve(op, group, x)
    assert matrix @ x == pytest.approx(right, abs=1e-12)
    assert storage == "factor" or op.symmetric == 1


@pytest.mark.parametrize("rows", [2, 3])
@pytest.mark.parametrize("storage", STORAGES)
@pytest.mark.parametrize("eps", [1.0, 0.1, 1e-3])
def test_newton_alone_solves_from_nothing(rows: int, storage: str, eps: float) -> None:
    """Within its factors, whatever W is stored as."""
    table = attempts_for(rows, (Attempt(NEWTON, 200, eps=eps),))
    for seed in range(3):
        problem, found = problem_of(rows, seed=seed), []
        search = UserSearch(system_of(problem, storage), 1e-10, table)
        search.run(np.zeros(len(problem.free)), 200, 0, lambda forces, found=found: not found.append(forces))
        assert residual_of(problem, found[0]) <= 1e-10
        assert 0 < search.factors <= 200
        assert search.sweeps == 0
        assert search.route == "Newton"


def by_alart_curnier(system: ContactSystem, start: Any, count: int) -> tuple[Any, int]:
    """The best forces of that method alone, from a start, and how many factors it made."""
    table = attempts_for(len(system.like), (Attempt(ALART_CURNIER, count),))
    search, found = UserSearch(system, 1e-10, table), []
    search.run(start, 100, 0, lambda forces: not found.append(forces))
    return found[0], search.factors


@pytest.mark.parametrize("rows", [2, 3])
@pytest.mark.parametrize("storage", ["dense", "blocks"])
def test_alart_curnier_without_a_centre(rows: int, storage: str) -> None:
    """From what sweeps come to, in a few factors to its goal."""
    for seed in range(4):
        problem = problem_of(rows, seed=seed)
        system = system_of(problem, storage)
        system.take(np.zeros(len(problem.free)))
        system.sweep(5, 0.0)
        start = system.forces
        forces, factors = by_alart_curnier(system, start, 20)
        assert residual_of(problem, forces) <= 1e-12
        assert residual_of(problem, start) > 1e-10
        assert 0 < factors <= 10


@pytest.mark.parametrize("make", [lambda: tower(2, tilt=0.4), lambda: heap(30, 12, seed=3)], ids=["slides", "heap"])
def test_alart_curnier_where_w_has_half_its_rank(make: Callable[[], SpatialContactProblem]) -> None:
    """Many contacts of few bodies: dense and by blocks the same velocities."""
    problem, velocities = make().balanced(), []
    for storage in ("dense", "blocks"):
        system = system_of(problem, storage)
        system.take(np.zeros(problem.size))
        system.sweep(30, 0.0)
        forces, _ = by_alart_curnier(system, system.forces, 60)
        assert problem.residual(forces) <= 1e-12
        velocities.append(problem.velocity(forces))
    np.testing.assert_allclose(*velocities, atol=1e-8)


def test_alart_curnier_tells_what_it_reached() -> None:
    """Of two factors where more are needed: the best point, no worse than where it began."""
    problem = heap(30, 12, seed=3).balanced()
    forces, factors = by_alart_curnier(system_of(problem, "dense"), np.zeros(problem.size), 2)
    assert factors == 2
    assert 1e-8 < problem.residual(forces) < problem.residual(np.zeros(problem.size))


@pytest.mark.parametrize("storage", ["dense", "blocks"])
@pytest.mark.parametrize("rows", [2, 3])
def test_unsymmetric_matrices(rows: int, storage: str) -> None:
    """Which are measured without F.W F, and are solved to their own solution."""
    problem = problem_of(rows)
    W = problem.dense() + 0.02 * np.random.default_rng(3).standard_normal(problem.dense().shape)
    other = type(problem)(W, problem.free, problem.friction).balanced()
    system, found = system_of(other, storage), []
    search = UserSearch(system, 1e-10)
    assert system.op.symmetric == 0
    search.run(np.zeros(len(other.free)), 600, 2000, lambda forces: not found.append(forces))
    assert residual_of(other, found[0]) <= 1e-10
    assert residual_of(problem, found[0]) > 1e-6


def test_where_the_certificate_asks_for_more_it_goes_on_to_rounding() -> None:
    """Contacts of light bodies beside heavy ones lag behind; what the first search came to was judged as well."""
    problem, kept = problem_of(3), []

    def never(forces: Any) -> bool:
        kept.append(residual_of(problem, forces))
        return False

    UserSearch(system_of(problem, "dense"), 1e-6).run(np.zeros(len(problem.free)), 600, 2000, never)
    assert len(kept) == 2
    assert kept[1] < 1e-3 * kept[0] <= 1e-9


def test_time_that_is_up_ends_it_with_the_best_point() -> None:
    """Which is looked for before each factor."""
    problem, kept = problem_of(2), []
    table = attempts_for(2, (Attempt(SWEEPS, 10, when=0), Attempt(NEWTON, 200, eps=0.1)))
    search = UserSearch(system_of(problem, "blocks"), 1e-14, table)
    with within(1e-9):
        search.run(np.zeros(len(problem.free)), 200, 10, lambda forces: bool(kept.append(forces)))
    assert search.sweeps == 10
    assert kept[0].any()
    assert residual_of(problem, kept[0]) < residual_of(problem, np.zeros(len(problem.free)))
