"""Nearly singular problems whose solutions are floats: solved, and judged in fractions, however large the terms."""

from fractions import Fraction

import numpy as np
import pytest

from lcpflex.solvers import Auto, Enumeration, Lcp, MinMapNewton, PrincipalPivoting, Status, accept
from tests.contract.rational_judge import left_of_load

FLOATS = 2**53


def opposed(k):
    """z = (2^(k+1) + 1, 2^(k+1)) has w = 0."""
    return np.array([[1.0, -1.0], [-1.0, 1.0 + 2.0**-k]]), np.array([-1.0, -1.0])


def planted(rng, n, k):
    """M, q, z in which M is definite with a pivot of 2^-k, and z holds whole numbers near 2^k; some w are positive.

    None where M or z does not fit into floats, or nothing is asked for.
    """
    active = int(rng.integers(2, n + 1))
    L = np.tril(rng.integers(-1, 2, (active, active)), -1) + np.eye(active, dtype=int)
    D = [Fraction(1)] * active
    D[int(rng.integers(active))] = Fraction(1, 2**k)
    exact = [
        [sum(int(L[i, p]) * D[p] * int(L[j, p]) for p in range(active)) for j in range(active)] for i in range(active)
    ]
    load = rng.integers(-3, 4, active).tolist()
    z = [Fraction(b) for b in load]
    for i in range(active):
        z[i] -= sum(int(L[i, p]) * z[p] for p in range(i))
    z = [value / d for value, d in zip(z, D, strict=True)]
    for i in reversed(range(active)):
        z[i] -= sum(int(L[p, i]) * z[p] for p in range(i + 1, active))
    if not any(load) or max(map(abs, z)) >= FLOATS:
        return None
    if any(Fraction(float(value)) != value for row in exact for value in row):
        return None
    sign = np.array([-1.0 if value < 0 else 1.0 for value in z])
    M, q, point = np.zeros((n, n)), np.ones(n), np.zeros(n)
    block = np.array([[float(value) for value in row] for row in exact])
    M[:active, :active] = sign[:, None] * block * sign
    q[:active] = -sign * np.array(load, dtype=float)
    point[:active] = [float(abs(value)) for value in z]
    for i in range(active, n):  # w_i = 1 + the same as of a row whose w is zero
        like = int(rng.integers(active))
        M[i, :active], M[i, i], q[i] = M[like, :active], 2.0, q[like] + 1.0
    order = rng.permutation(n)
    return M[np.ix_(order, order)], q[order], point[order]


def claims_are_true(seed, count, sizes):
    """(planted problems solved, all): each SOLVED judged in fractions."""
    rng = np.random.default_rng(seed)
    solved = total = 0
    while total < count:
        n, k = int(rng.integers(*sizes)), int(rng.integers(20, 51))
        made = planted(rng, n, k)
        if made is None:
            continue
        M, q, z = made
        assert left_of_load(M, q, z) == 0.0
        scale = 2.0 ** rng.integers(-20, 21, n) if rng.random() < 0.5 else np.ones(n)
        M, q, z = scale[:, None] * M * scale, scale * q, z / scale
        total += 1
        for solver in (Auto(), PrincipalPivoting(), MinMapNewton()):
            problem = Lcp(M, q)
            if solver.refuses(problem):
                continue
            found = solver.solve(problem)
            if found.solved:
                # floats see no more than 1e-6 of the load; sums and units lose a little more, or fractions decide
                _, units = problem.balanced()
                d = None if units is None else units.d
                assert left_of_load(M, q, found.z, d) <= 5e-6, (M, q)
            assert found.status not in (Status.INFEASIBLE, Status.NO_SOLUTION), (M, q)
            if isinstance(solver, Auto):
                solved += found.solved
    return solved, total


@pytest.mark.parametrize("k", [20, 26, 30, 34, 40, 45, 48])
@pytest.mark.parametrize("load", [1.0, 5.0, 2.0**-40])
@pytest.mark.parametrize("units", [(1.0, 1.0), (2.0**30, 2.0**-20)])
@pytest.mark.parametrize("order", [[0, 1], [1, 0]])
def test_a_solution_in_whole_numbers_is_one(k, load, units, order):
    M, q = opposed(k)
    d = np.array(units)
    found = Auto().solve(Lcp((d[:, None] * M * d)[np.ix_(order, order)], (d * load * q)[order]))
    assert found.status is Status.SOLVED
    assert found.message == ""
    z = found.z[order] * d
    assert z == pytest.approx(np.full(2, load * 2.0 ** (k + 1)), rel=1e-5)
    # floats forgive 1e-6 of the load as long as they can tell that it is no more; fractions forgive nothing
    assert left_of_load(M, load * q, z) <= (1e-9 if k > 32 else 1e-6)


@pytest.mark.parametrize("k", [34, 40, 45])
def test_each_digit_counts(k):
    """A neighbour of the solution leaves more than the tolerance: accept sees it."""
    M, q = opposed(k)
    z = np.array([2.0 ** (k + 1) + 1.0, 2.0 ** (k + 1)])
    right = accept(Lcp(M, q), z, tolerance=1e-10)
    assert right.solved
    assert right.residual == right.strict == 0.0
    assert (right.w == 0.0).all()
    one = np.array([1.0, 0.0])
    for wrong in (z + one, z + one[::-1], z - one, np.nextafter(z, [np.inf, 0.0])):
        judged = accept(Lcp(M, q), wrong, tolerance=1e-10)
        assert not judged.solved
        assert judged.strict == pytest.approx(left_of_load(M, q, wrong), rel=1e-9)


def test_a_ray_is_none():
    """Far along a ray all terms are large: what is left of q tells that no point of it is a solution."""
    M, q = np.array([[1.0, -1.0], [-1.0, 1.0]]), np.array([-1.0, -1.0])
    for far in (1e12, 1e15, 2.0**60, 1e200):
        found = accept(Lcp(M, q), [far, far], tolerance=1e-10)
        assert not found.solved
        assert found.residual >= 0.5
    assert Auto().solve(Lcp(M, q)).status is Status.INFEASIBLE


def test_beyond_enumeration():
    rng = np.random.default_rng(4)
    solved = 0
    for _ in range(4):
        made = None
        while made is None:
            made = planted(rng, 20, 36)
        found = Auto().solve(Lcp(*made[:2]))
        solved += found.solved
        assert not found.solved or left_of_load(*made[:2], found.z) <= 1e-6
    assert solved == 4


def test_solutions_in_whole_numbers_are_found():
    solved, total = claims_are_true(1, 40, (2, 7))
    assert solved >= 0.95 * total


@pytest.mark.slow
def test_more_solutions_in_whole_numbers_are_found():
    solved, total = claims_are_true(2, 300, (2, 24))
    print(f"{solved} of {total} solved")
    assert solved >= 0.9 * total


@pytest.mark.campaign
def test_none_of_many_claims_is_false():
    solved, total = claims_are_true(3, 5000, (2, 14))
    print(f"{solved} of {total} solved")
    assert solved >= 0.9 * total


def test_a_long_search_ends():
    """Thirty unknowns and a solution that floats cannot hold: the search gives up in good time."""
    rng = np.random.default_rng(5)
    M, q = opposed(52)
    coupled = np.kron(np.eye(15), M) + 2.0**-30 * rng.integers(0, 2, (30, 30))
    problem = Lcp(coupled, np.tile(q, 15))
    assert Enumeration().refuses(problem)
    found = Auto().solve(problem)
    assert "search in whole numbers" in found.route or found.solved
