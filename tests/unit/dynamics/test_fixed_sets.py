"""The linear solve with fixed index sets: the shortest of all solutions where contacts are redundant."""

from __future__ import annotations

import numpy as np
import pytest

from lcpflex.dynamics.acceleration import contact_sets, solve_consistent


@pytest.mark.parametrize(("m", "rank", "symmetric"), [(6, 6, True), (8, 5, True), (10, 3, False), (4, 1, True)])
def test_shortest_solution(m: int, rank: int, symmetric: bool) -> None:
    """Against the pseudo-inverse of the matrix scaled to a unit diagonal; the right-hand side is consistent."""
    generator = np.random.default_rng(m)
    left = generator.normal(size=(m, rank))
    matrix = left @ (left.T if symmetric else generator.normal(size=(rank, m)))
    right = matrix @ generator.normal(size=m)
    sets = contact_sets(m)
    sets.reduced[:m, :m] = matrix
    sets.right[:m] = right
    solve_consistent(sets, m)
    scale = np.diag(1.0 / np.sqrt(np.abs(np.diag(matrix))))
    shortest = -scale @ np.linalg.pinv(scale @ matrix @ scale, rcond=1e-10) @ scale @ right
    assert sets.solution[:m] == pytest.approx(shortest, abs=1e-11)
    assert matrix @ sets.solution[:m] == pytest.approx(-right, abs=1e-11)
