"""Principal pivoting: its factor, warm starts, semidefinite matrices, proofs that no solution exists, limits."""

import numpy as np
import pytest

from lcpflex.errors import ModelError
from lcpflex.solvers import Lcp, Status
from lcpflex.solvers.lcp.active_factor import factorise, join, leave, new_column
from lcpflex.solvers.lcp.principal_pivoting import (
    PrincipalPivoting,
    principal_pivoting,
    principal_pivoting_workspace,
)


def definite(n: int, seed: int) -> np.ndarray:
    rows = np.random.default_rng(seed).standard_normal((n, n + 2))
    return rows @ rows.T


def planted(M: np.ndarray, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """(q, w) such that w is that of a solution with a few active, a few degenerate and a few inactive indices."""
    kind = rng.integers(0, 3, len(M))
    z = np.where(kind == 0, rng.uniform(0.1, 1.0, len(M)), 0.0)
    w = np.where(kind == 1, rng.uniform(0.1, 1.0, len(M)), 0.0)
    return w - M @ z, w


def upper(R: np.ndarray, m: int) -> np.ndarray:
    return np.triu(R[:m, :m])


@pytest.mark.parametrize("n", [1, 2, 7, 30])
def test_updated_factor_is_that_of_a_new_factorisation(n):
    M, rng = definite(n, 1), np.random.default_rng(2)
    R, basis = principal_pivoting_workspace(n)
    basis[:n] = rng.random(n) < 0.5
    m = factorise(M, n, R, basis)
    for _ in range(60):
        r = int(rng.integers(n))
        if basis[r]:
            leave(n, R, basis, m, list(basis[n : n + m]).index(r), R[n + 3])
            m -= 1
        else:
            join(n, R, basis, m, r, R[n + 3], new_column(M, n, R, basis, m, r, R[n + 3]))
            m += 1
        order = basis[n : n + m].copy()
        assert sorted(order) == list(np.flatnonzero(basis[:n]))
        assert np.abs(upper(R, m).T @ upper(R, m) - M[np.ix_(order, order)]).max(initial=0.0) < 1e-12 * M.max()
    other, flags = principal_pivoting_workspace(n)
    flags[:n] = basis[:n]
    assert factorise(M, n, other, flags) == m
    assert (flags[:n] == basis[:n]).all()


def test_factor_leaves_out_what_depends_on_the_rest():
    M = definite(6, 3)
    copies = np.array([0, 1, 1, 2, 0, 3, 4, 5, 5])
    M = np.ascontiguousarray(M[np.ix_(copies, copies)])
    R, basis = principal_pivoting_workspace(len(M))
    basis[: len(M)] = 1
    assert factorise(M, len(M), R, basis) == 6
    assert sorted(copies[basis[: len(M)] == 1]) == [0, 1, 2, 3, 4, 5]


@pytest.mark.parametrize("n", [1, 4, 25, 80])
def test_right_basis_takes_one_factorisation(n):
    M = definite(n, 4)
    q = -np.random.default_rng(5).standard_normal(n)
    q[0] = -1.0
    cold = PrincipalPivoting().solve(Lcp(M, q))
    warm = PrincipalPivoting().solve(Lcp(M, 1.0001 * q), cold)
    assert cold.solved
    assert warm.solved
    assert warm.iterations == 1
    assert (warm.active == cold.active).all()


@pytest.mark.parametrize("guess", [0, 1])
def test_wrong_basis_is_put_right(guess):
    M, rng = definite(40, 6), np.random.default_rng(7)
    q, w = planted(M, rng)
    problem = Lcp(M, q)
    solution = PrincipalPivoting().solve(problem)
    wrong = PrincipalPivoting().solve(Lcp(M, -np.ones(40) if guess else np.ones(40)))
    again = PrincipalPivoting().solve(problem, wrong)
    assert solution.w == pytest.approx(w, abs=1e-10)
    assert again.w == pytest.approx(w, abs=1e-10)


@pytest.mark.parametrize("seed", range(8))
def test_redundant_contacts(seed):
    rng = np.random.default_rng(seed)
    n, rank = 30, int(rng.integers(1, 12))
    J = rng.standard_normal((n, rank)) * 10.0 ** rng.uniform(-4, 4, (1, rank))
    M = J @ J.T
    q, w = planted(M, rng)
    solution = PrincipalPivoting().solve(Lcp(M, q, J))
    assert solution.solved
    assert np.abs(solution.w - w).max() < 1e-7 * np.abs(M).max()


@pytest.mark.parametrize("n", [1, 3, 12, 40])
def test_squeeze_is_proved_to_have_no_solution(n):
    # Each row is there with both signs, and both sides are asked for a velocity of +1.
    J = np.random.default_rng(n).standard_normal((n, n + 1))
    J = np.vstack([J, -J])
    q = J @ np.arange(1.0, n + 2.0) - 1.0
    solution = PrincipalPivoting().solve(Lcp(J @ J.T, q, J))
    assert solution.status is Status.INFEASIBLE
    u = solution.certificate
    assert (u >= 0.0).all()
    assert q @ u < 0.0
    assert np.abs(J.T @ u).max() < 1e-10 * u.max() * np.abs(J).max()


def test_single_exchanges_where_blocks_run_in_circles():
    # Both phases end in the answer of a scan over all active sets.
    rng = np.random.default_rng(11)
    for _ in range(200):
        n = int(rng.integers(2, 7))
        L = np.tril(rng.integers(-4, 5, (n, n)), -1) + np.eye(n)
        problem = Lcp(L @ L.T, rng.integers(-3, 2, n).astype(float))
        bits = (np.arange(2**n)[:, None] >> np.arange(n)) & 1
        residuals = []
        for active in bits.astype(bool):
            z = np.zeros(n)
            z[active] = np.linalg.solve(problem.M[np.ix_(active, active)], -problem.q[active])
            residuals.append((problem.residual(z), *z))
        solution = PrincipalPivoting().solve(problem)
        assert solution.solved
        assert solution.z == pytest.approx(np.array(min(residuals)[1:]), rel=1e-8, abs=1e-8)


def test_indefinite_matrix_gets_an_honest_status():
    rng = np.random.default_rng(12)
    seen = set()
    for _ in range(300):
        n = int(rng.integers(1, 9))
        A = rng.standard_normal((n, n)).round(1)
        problem = Lcp(A + A.T, rng.standard_normal(n).round(1))
        solution = PrincipalPivoting().solve(problem)
        seen.add(solution.status)
        assert solution.solved == (problem.residual(solution.z) <= 1e-10)
    assert Status.SOLVED in seen
    assert Status.RAY in seen


def test_unsymmetric_matrix_is_refused():
    problem = Lcp([[1.0, 1.0], [0.0, 1.0]], [-1.0, -1.0])
    assert "Lemke" in PrincipalPivoting().refuses(problem)
    with pytest.raises(ModelError, match="not symmetric"):
        PrincipalPivoting().solve(problem)


def test_pivot_limit():
    M = definite(30, 13)
    problem = Lcp(M, np.random.default_rng(14).standard_normal(30))
    full = PrincipalPivoting().solve(problem)
    assert full.iterations > 1
    few = PrincipalPivoting(pivot_limit=1).solve(problem)
    assert few.status is Status.ITERATION_LIMIT
    assert few.iterations == 1
    with pytest.raises(ModelError, match="pivot_limit"):
        PrincipalPivoting(pivot_limit=0)


def test_overflow_is_a_failure():
    solution = PrincipalPivoting().solve(Lcp(np.array([[2.0, 1.0], [1.0, 2.0]]) * 1e-300, [-1.0, -1e200]))
    assert not solution.solved


def test_kernel_leaves_the_problem_alone_and_runs_on_a_leading_block():
    n, capacity = 6, 9
    M, q = np.full((capacity, capacity), np.nan), np.full(capacity, np.nan)
    M[:n, :n] = definite(n, 15)
    q[:n] = np.random.default_rng(16).standard_normal(n)
    before = M.copy(), q.copy()
    factor, basis = principal_pivoting_workspace(capacity)
    z = np.full(capacity, 7.0)
    status, _ = principal_pivoting(M, q, n, z, factor, basis, False, 1e-10, 100)
    assert status == Status.SOLVED
    assert Lcp(M[:n, :n], q[:n]).residual(z[:n]) < 1e-14
    assert (z[n:] == 7.0).all()
    np.testing.assert_array_equal(before[0], M)
    np.testing.assert_array_equal(before[1], q)


def test_a_ray_with_the_dust_of_rounding_is_a_proof():
    """Four ulps in a row of the ray where exact numbers have none, and two of the matrix's columns see nothing else."""
    J = np.array([[0.0, -1.0], [-1.0, -1.0], [1.0, 0.0], [2.0, -2.0], [1.0, 1.0]])
    found = PrincipalPivoting().solve(Lcp(J @ J.T, [0.0, 0.0, -1.0, -1.0, -1.0]))
    assert found.status is Status.INFEASIBLE
    assert found.certificate / found.certificate.max() == pytest.approx([0.0, 1.0, 0.0, 0.0, 1.0])
