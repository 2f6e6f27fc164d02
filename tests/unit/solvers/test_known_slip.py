"""Contact problems in space with cones and known slip side by side: W is one matrix without symmetry."""

from __future__ import annotations

import math

import numpy as np
import pytest

from lcpflex.jit.kernel import FloatArray
from lcpflex.solvers.contact.cones.mixed import MixedMemory, judge_mixed, mixed_memory, polish_mixed, solve_mixed
from lcpflex.solvers.contact.cones.mixed_problem import MixedProblem, mixed_problem

TOLERANCE = 1e-9


def posed(seed: int, n: int = 6, bodies: int = 3, floors: bool = False) -> tuple[MixedProblem, MixedMemory]:
    """Random contacts between free bodies, some of which slide in known directions or carry something at least."""
    random = np.random.default_rng(seed)
    J = np.zeros((n, 3, 6 * bodies))
    for c in range(n):
        for b in random.permutation(bodies)[:2]:
            J[c, :, 6 * b : 6 * b + 6] = random.normal(size=(3, 6))
    rows = J.reshape(3 * n, -1)
    G, free = rows @ rows.T, rows @ random.normal(size=6 * bodies)
    p = mixed_problem(n)
    p.n, kept, columns = n, [3 * c for c in range(n)], G.copy()
    p.friction[:] = random.uniform(0.0, 0.7, n)
    for c in range(n):
        p.at[c] = -1
        if random.random() < 0.4:
            angle, mu = random.uniform(0.0, 2.0 * math.pi), p.friction[c]
            columns[:, 3 * c] -= mu * (math.cos(angle) * G[:, 3 * c + 1] + math.sin(angle) * G[:, 3 * c + 2])
        else:
            p.at[c] = len(kept)
            kept += [3 * c + 1, 3 * c + 2]
    p.m = len(kept)
    p.W[: p.m, : p.m], p.q[: p.m] = columns[np.ix_(kept, kept)], free[kept]
    p.terms[: p.m] = np.abs(p.q[: p.m])
    if floors:
        p.floor[:] = np.where(random.random(n) < 0.5, random.uniform(0.0, 0.3, n), 0.0)
    return p, mixed_memory(n)


def miss(p: MixedProblem, r: FloatArray) -> float:
    """What is left of the laws by numpy alone, of the size of q."""
    u, left = p.W[: p.m, : p.m] @ r[: p.m] + p.q[: p.m], [0.0]
    for c in range(p.n):
        left.append(abs(min(r[c] - p.floor[c], u[c])))
        if p.at[c] >= 0:
            tangents = slice(p.at[c], p.at[c] + 2)
            point, bound = r[tangents] - u[tangents], p.friction[c] * max(r[c], 0.0)
            size = float(np.linalg.norm(point))
            left.append(np.abs(r[tangents] - point * min(1.0, bound / size if size > 0.0 else 1.0)).max())
    return float(max(left) / np.abs(p.q[: p.m]).max())


@pytest.mark.parametrize("floors", [False, True], ids=["", "floors"])
def test_forces_obey_the_laws(floors: bool) -> None:
    """As numpy says, and as the residual does; to rounding, mostly."""
    exact = 0
    for seed in range(30):
        p, memory = posed(seed, floors=floors)
        residual = solve_mixed(p, memory, TOLERANCE)
        assert residual <= TOLERANCE
        assert residual == judge_mixed(p, memory, p.r)
        assert miss(p, p.r) <= 1e-7
        assert p.u[: p.m] == pytest.approx(p.W[: p.m, : p.m] @ p.r[: p.m] + p.q[: p.m], abs=1e-10)
        exact += residual <= 1e-13
    assert exact >= 27


def test_polishing_finds_the_way_back() -> None:
    """From forces beside the solution."""
    for seed in range(10):
        p, memory = posed(seed)
        assert solve_mixed(p, memory, TOLERANCE) <= TOLERANCE
        p.r[: p.n] += 1e-4
        assert judge_mixed(p, memory, p.r) > 1e-9
        assert polish_mixed(p, memory) <= TOLERANCE


def test_a_contact_alone_is_solved_by_its_law() -> None:
    """No search is made for it."""
    for seed in range(20):
        p, memory = posed(seed, n=1, bodies=1)
        assert solve_mixed(p, memory, TOLERANCE) <= 1e-14
        assert memory.newton.factors == 0
        assert p.iterations <= 2
        assert not memory.search.tried.any()


def test_loads_that_are_not_finite_are_no_solution() -> None:
    """Whatever was tried."""
    p, memory = posed(1)
    p.q[0] = np.nan
    assert not solve_mixed(p, memory, TOLERANCE) <= TOLERANCE


def wedging(mu: float) -> tuple[MixedProblem, MixedMemory]:
    """A contact whose known friction presses it: W_NN = 1 - mu, with q = -1."""
    p = mixed_problem(1)
    p.n, p.m, p.at[0] = 1, 1, -1
    p.W[0, 0], p.q[0], p.terms[0] = 1.0 - mu, -1.0, 1.0
    return p, mixed_memory(1)


def test_a_wedged_contact_has_no_solution() -> None:
    """Painleve: its own force pulls it in, and none is told."""
    p, memory = wedging(0.5)
    assert solve_mixed(p, memory, TOLERANCE) <= 1e-14
    assert p.r[0] == pytest.approx(2.0)
    p, memory = wedging(2.0)
    assert solve_mixed(p, memory, TOLERANCE) > TOLERANCE
