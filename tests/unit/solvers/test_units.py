"""Units under any laws by their matrix."""

from __future__ import annotations

import numpy as np
import pytest

from lcpflex.errors import ModelError
from lcpflex.solvers import ContactProblem, solve_lcp
from lcpflex.solvers.contact.laws import bilateral, coulomb, half_line
from lcpflex.solvers.contact.units import solve_units


def matrix(n: int, rows: int, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """W and free velocities of random units."""
    random = np.random.default_rng(seed)
    J = random.normal(size=(n * rows, 3 * n))
    return J @ J.T, (J @ random.normal(size=3 * n)).reshape(n, rows)


def test_frictional_contacts_as_an_lcp() -> None:
    """The same forces as by Lemke's method."""
    W, free = matrix(5, 2)
    found = solve_units(W, free, [coulomb] * 5, mu=0.4)
    assert found.solved
    order = np.r_[0:10:2, 1:10:2]
    problem = ContactProblem(W[np.ix_(order, order)], free.T.ravel(), np.full(5, 0.4))
    normal, tangential = problem.forces(solve_lcp(problem).z)
    assert found.p == pytest.approx(np.column_stack([normal, tangential]), abs=1e-9)
    assert found.v == pytest.approx((W @ found.p.ravel()).reshape(5, 2) + free, abs=1e-11)


@pytest.mark.parametrize("rows", [2, 3])
@pytest.mark.parametrize("size", [1e-9, 1.0, 1e9])
def test_laws_side_by_side_in_any_units(rows: int, size: float) -> None:
    """A joint stands still, a floor is kept, a contact rubs no more than it may."""
    W, free = matrix(6, rows, seed=2)
    laws = [coulomb, bilateral, half_line, coulomb, half_line, coulomb]
    found = solve_units(W * size, free, laws, mu=0.3, floor=np.array([0, 0, 0.5, 0, 0, 0]) / size)
    p, v = found.p * size, found.v
    assert found.solved
    assert found.residual <= 1e-10
    assert np.abs(v[1]).max() <= 1e-8
    assert p[2, 0] >= 0.5 - 1e-9
    assert abs(min(p[2, 0] - 0.5, v[2, 0])) <= 1e-8
    for k in (0, 3, 5):
        assert np.linalg.norm(p[k, 1:]) <= 0.3 * p[k, 0] + 1e-9
    assert v[[0, 2, 3, 4, 5], 0].min() >= -1e-8


def test_what_does_not_fit_is_named() -> None:
    """Shapes, and a law that nobody knows."""
    W, free = matrix(2, 2)
    with pytest.raises(ModelError, match="there are 1 laws: expected"):
        solve_units(W, free, [coulomb])
    with pytest.raises(ModelError, match=r"laws\[1\] is <module 'numpy'"):
        solve_units(W, free, [coulomb, np])
