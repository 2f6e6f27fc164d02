"""What solves many spatial contacts: sweeps by matrix, blocks and factor, linear systems, the table of attempts."""

import numpy as np
import pytest
import scipy.sparse

from lcpflex.solvers.contact.coupling import ConeBlocks
from lcpflex.solvers.contact.spatial import SpatialContactProblem
from lcpflex.solvers.contact.system import ContactSystem
from lcpflex.solvers.contact.user_search import UserSearch
from lcpflex.solvers.dense_factor import factorise_rows, solve_rows
from tests.cones import heap, tower


def swept(problem, storage, sweeps, target=0.0):
    """The contacts after so many sweeps from no forces; how many there were, and the last change."""
    system = ContactSystem(problem, storage)
    system.take(np.zeros(problem.size))
    return system, *system.sweep(sweeps, target)


@pytest.mark.parametrize("n", [1, 2, 7, 40])
def test_linear_systems_are_solved(n):
    """Rows exchanged: a zero where elimination would begin does no harm; what is behind the block stays."""
    rng = np.random.default_rng(n)
    A, b = rng.normal(size=(n + 2, n + 2)), rng.normal(size=n + 2)
    A[0, 0] = 0.0 if n > 1 else 1.0
    table, x, pivots = A.copy(), b.copy(), np.zeros(n, dtype=np.int64)
    assert factorise_rows(table, n, pivots)
    solve_rows(table, n, pivots, x, np.zeros(n))
    np.testing.assert_allclose(x[:n], np.linalg.solve(A[:n, :n], b[:n]), rtol=1e-9, atol=1e-12)
    np.testing.assert_array_equal(x[n:], b[n:])


def test_singular_systems_are_told():
    A = np.outer([1.0, 2.0, 4.0], [1.0, 0.5, 0.25])
    assert not factorise_rows(A, 3, np.zeros(3, dtype=np.int64))


def test_sweeps_are_the_same_on_matrix_blocks_and_factor():
    problem = tower(3, tilt=0.4, spin=0.3).balanced()
    values, vectors = np.linalg.eigh(problem.delassus)
    J = scipy.sparse.csr_array(vectors * np.sqrt(np.maximum(values, 0.0)))
    by_factor = SpatialContactProblem(None, problem.free, problem.friction, factor=J)
    first, _, _ = swept(problem, problem.dense(), 20)
    for one, storage, off in ((problem, ConeBlocks(problem.delassus), 1e-12), (by_factor, None, 1e-10)):
        system, made, change = swept(one, storage, 20)
        assert made == 20
        assert change > 0.0
        np.testing.assert_allclose(system.forces, first.forces, atol=off)
        np.testing.assert_allclose(system.group.slip, first.group.slip, atol=1e-9)
    np.testing.assert_allclose(system.op.x, J.T @ system.forces, atol=1e-12)


def test_sweeps_end_at_the_change_asked_for():
    problem = heap(6, 6).balanced()
    system, made, change = swept(problem, problem.dense(), 5000, 1e-13)
    assert made < 5000
    assert change <= 1e-13
    assert problem.residual(system.forces) <= 1e-12


def test_unsymmetric_blocks_are_swept_to_their_own_solution():
    problem = heap(8, 8, seed=1)
    W = problem.delassus * (1.0 + 0.01 * np.random.default_rng(7).normal(size=problem.delassus.shape))
    other = type(problem)(W, problem.free, problem.friction)
    for storage in (other.dense(), ConeBlocks(other.delassus)):
        system, _, _ = swept(other, storage, 3000, 1e-14)
        assert other.residual(system.forces) <= 1e-12
        assert problem.residual(system.forces) > 1e-6


def test_slips_of_known_forces_are_taken():
    """|u_T| / |r_T| of the contacts that rub, as the sweeps that led there know them."""
    problem = tower(2, tilt=0.4).balanced()
    first, _, _ = swept(problem, problem.dense(), 3000, 1e-15)
    system = ContactSystem(problem, problem.dense())
    system.take(first.forces)
    assert system.group.slip.any()
    np.testing.assert_allclose(system.group.slip, first.group.slip, atol=1e-9)


@pytest.mark.parametrize(
    "make",
    [lambda: tower(2, tilt=0.4), lambda: tower(5), lambda: heap(30, 12, seed=3)],
    ids=["slides", "falls", "heap"],
)
def test_the_table_solves_from_nothing(make):
    """In a fraction of the factors that it may make."""
    problem, found = make().balanced(), []
    search = UserSearch(ContactSystem(problem, problem.dense()), 1e-11)
    search.run(np.zeros(problem.size), 200, 1000, lambda forces: not found.append(forces))
    assert problem.residual(found[0]) <= 1e-11
    assert search.factors <= 100


def test_many_contacts_of_few_bodies_that_drift_are_solved():
    """Forty contacts of six bodies with friction 0.9 to 1: proximal points have far to go along a line."""
    problem, found = heap(40, 6, seed=2, friction=(0.9, 1.0)).balanced(), []
    search = UserSearch(ContactSystem(problem, problem.dense()), 1e-11)
    search.run(np.zeros(problem.size), 600, 5000, lambda forces: not found.append(forces))
    assert problem.residuals(found[0])[1] <= 1e-11
    assert search.factors <= 340
