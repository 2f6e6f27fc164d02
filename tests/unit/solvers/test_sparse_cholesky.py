"""The sparse factor against the dense one: orders, fill, paths, dependent rows."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import numpy.typing as npt
import pytest

from lcpflex.solvers.elimination import Pattern, sparse_pattern
from lcpflex.solvers.semidefinite import cholesky, cholesky_solve
from lcpflex.solvers.sparse_cholesky import (
    SparseFactor,
    add_path,
    factorise_sparse,
    forget_path,
    solve_on_path,
    solve_sparse,
    sparse_factor,
)

N = 60
SHUFFLED = np.random.default_rng(0).permutation(N).tolist()
GRAPHS: dict[str, list[tuple[int, int]]] = {
    "none": [],
    "chain": [(i, i + 1) for i in range(N - 1)],
    "ring": [(i, (i + 1) % N) for i in range(N)],
    "tree": [(i, (i - 1) // 2) for i in range(1, N)],
    "shuffled tree": [(SHUFFLED[i], SHUFFLED[(i - 1) // 2]) for i in range(1, N)],
    "shuffled chains": [(SHUFFLED[i], SHUFFLED[i + 1]) for i in range(N - 1) if i % 20],
    "star": [(0, i) for i in range(1, N)],
    "lattice": [(i, i + 1) for i in range(N - 1) if (i + 1) % 6] + [(i, i + 6) for i in range(N - 6)],
    "full": [(i, j) for i in range(12) for j in range(i)],
}
NATURAL = ("none", "chain", "full")  # nothing has less fill


def laid(edges: Iterable[tuple[int, int]], seed: int = 0) -> tuple[Pattern, npt.NDArray[np.float64]]:
    """The pattern of N blocks of one to three unknowns, and a positive definite matrix that has it."""
    generator = np.random.default_rng(seed)
    sizes = generator.integers(1, 4, N)
    first = [0, *np.cumsum(sizes).tolist()]
    neighbours: list[set[int]] = [set() for _ in range(N)]
    for a, b in edges:
        neighbours[a].add(b)
        neighbours[b].add(a)
    block = np.repeat(np.arange(N), sizes)
    linked = np.eye(N, dtype=bool)
    for a, others in enumerate(neighbours):
        linked[a, list(others)] = True
    G = np.where(linked[np.ix_(block, block)], generator.standard_normal((first[-1], first[-1])), 0.0)
    G = np.tril(G) + np.tril(G, -1).T
    return sparse_pattern(neighbours, first), G + np.diag(1.0 + 2.0 * np.abs(G).sum(axis=1))


def filled(pattern: Pattern, G: npt.NDArray[np.float64]) -> SparseFactor:
    """The factor of G."""
    factor = sparse_factor(pattern)
    row = np.repeat(np.arange(len(pattern.order)), np.diff(pattern.start))
    factor.value[:] = G[pattern.order[row], pattern.order[pattern.column]]
    factorise_sparse(factor)
    return factor


def solved(factor: SparseFactor, b: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    x = b[factor.order]
    solve_sparse(factor, x)
    answer = np.empty_like(x)
    answer[factor.order] = x
    return answer


def dense(G: npt.NDArray[np.float64], b: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    lower, x = np.zeros_like(G), b.copy()
    cholesky(G, len(G), lower)
    cholesky_solve(lower, len(G), x)
    return x


@pytest.mark.parametrize("graph", GRAPHS)
@pytest.mark.parametrize("unit", [1.0, 1e-9, 1e7])
def test_the_answer(graph: str, unit: float) -> None:
    pattern, G = laid(GRAPHS[graph])
    b = np.random.default_rng(1).standard_normal(len(G))
    factor = filled(pattern, unit * G)
    x = solved(factor, b)
    assert unit * G @ x == pytest.approx(b, abs=1e-12)
    assert factor.dependent == 0
    assert not factor.row.any()


@pytest.mark.parametrize("graph", GRAPHS)
def test_the_natural_order_has_the_bits_of_the_dense_factor(graph: str) -> None:
    pattern, G = laid(GRAPHS[graph])
    assert sorted(pattern.order.tolist()) == list(range(len(G)))
    natural = (pattern.order == np.arange(len(G))).all()
    assert natural or graph not in NATURAL
    if natural:
        b = np.random.default_rng(2).standard_normal(len(G))
        assert np.array_equal(solved(filled(pattern, G), b), dense(G, b))


@pytest.mark.parametrize("graph", ["tree", "shuffled tree", "shuffled chains", "star"])
def test_what_has_no_loops_has_no_fill(graph: str) -> None:
    pattern, G = laid(GRAPHS[graph])
    assert len(pattern.column) == np.count_nonzero(np.tril(G))


def test_a_lattice_has_less_fill_than_in_natural_order() -> None:
    pattern, G = laid(GRAPHS["lattice"])
    lower = np.zeros_like(G)
    cholesky(G, len(G), lower)
    assert len(pattern.column) < 0.8 * np.count_nonzero(lower)


def test_parts_without_connection_follow_each_other() -> None:
    pattern, _ = laid(GRAPHS["shuffled chains"])
    root = np.arange(len(pattern.parent))
    for i in reversed(range(len(root))):
        if pattern.parent[i] >= 0:
            root[i] = root[pattern.parent[i]]
    assert len(np.unique(root)) == 1 + np.count_nonzero(np.diff(root)) == 4


@pytest.mark.parametrize("graph", GRAPHS)
def test_the_answer_on_a_path(graph: str) -> None:
    """To a load on two rows, where that begins and on all that follows from it, and nowhere else."""
    pattern, G = laid(GRAPHS[graph])
    factor, n = filled(pattern, G), len(G)
    generator = np.random.default_rng(3)
    for _ in range(5):
        loaded = generator.integers(0, n, 2)
        forget_path(factor)
        for i in loaded:
            add_path(factor, int(i))
        path = factor.path[n - factor.n_path :]
        later = np.empty(n, dtype=int)
        later[path] = np.arange(len(path))
        assert all(later[i] < later[pattern.parent[i]] for i in path if pattern.parent[i] >= 0)
        x = np.zeros(n)
        x[loaded] = generator.standard_normal(2)
        b = np.zeros(n)
        b[pattern.order] = x
        solve_on_path(factor, x)
        assert x[path] == pytest.approx(dense(G, b)[pattern.order[path]], abs=1e-13)
        assert not np.delete(x, path).any()
    forget_path(factor)
    assert not factor.on_path.any()


@pytest.mark.parametrize("unit", [1.0, 1e-8, 1e9])
@pytest.mark.parametrize("graph", ["chain", "shuffled tree", "lattice", "full"])
def test_dependent_rows(graph: str, unit: float) -> None:
    """Of a singular matrix the answer is a basic solution: exact where there is one, and 0 for the dependent rows."""
    pattern, G = laid(GRAPHS[graph])
    same = np.arange(len(G))
    twins = 1 + np.flatnonzero(~np.diff(G != 0.0, axis=0).any(axis=1))  # of a block with the one before
    twice = twins[::3]
    same[twice] = twice - 1
    singular = unit * G[np.ix_(same, same)]
    factor = filled(pattern, singular)
    b = singular @ np.random.default_rng(4).standard_normal(len(G))
    x = solved(factor, b)
    assert factor.dependent == len(twice) > 2
    assert np.count_nonzero(x == 0.0) == len(twice)
    assert singular @ x == pytest.approx(b, abs=1e-11 * unit)


def test_nothing_at_all() -> None:
    pattern = sparse_pattern([], [0])
    factor = sparse_factor(pattern)
    factorise_sparse(factor)
    solve_sparse(factor, np.zeros(0))
    forget_path(factor)
    assert (len(pattern.order), factor.dependent) == (0, 0)


def test_a_row_of_zeros_is_dependent() -> None:
    pattern = sparse_pattern([{1}, {0, 2}, {1}], [0, 1, 2, 3])
    factor = filled(pattern, np.diag([4.0, 0.0, 9.0]))
    assert solved(factor, np.array([4.0, 5.0, 9.0])).tolist() == [1.0, 0.0, 1.0]
