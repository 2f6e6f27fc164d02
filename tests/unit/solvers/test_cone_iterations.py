"""The kernels that solve many spatial contacts: sweeps, Newton's method, proximal points; dense and by blocks."""

import numpy as np
import pytest
import scipy.sparse

from lcpflex.solvers.contact.cones.alart_curnier import contact_miss, mixed_rows
from lcpflex.solvers.contact.cones.blocks import ConeBlocks, newton_on_blocks
from lcpflex.solvers.contact.cones.linear import solve_general
from lcpflex.solvers.contact.cones.newton import cone_work, newton, proximal
from lcpflex.solvers.contact.spatial import SpatialContactProblem
from lcpflex.solvers.contact.system import ContactSystem
from tests.cones import heap, tower


def swept(problem, storage, sweeps, target=0.0):
    """The contacts after so many sweeps from no forces; how many there were, and the last change."""
    system = ContactSystem(problem, storage)
    system.take(np.zeros(problem.size))
    return system, *system.sweep(sweeps, target)


@pytest.mark.parametrize("n", [1, 2, 7, 40])
def test_linear_systems_are_solved(n):
    rng = np.random.default_rng(n)
    A, b = rng.normal(size=(n + 2, n + 2)), rng.normal(size=n + 2)
    A[0, 0] = 0.0 if n > 1 else 1.0
    x = b.copy()
    largest = solve_general(A.copy(), x, n, np.zeros(n, dtype=np.int64))
    expected = np.linalg.solve(A[:n, :n], b[:n])
    np.testing.assert_allclose(x[:n], expected, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(largest, np.abs(expected).max(), rtol=1e-9)
    np.testing.assert_array_equal(x[n:], b[n:])


def test_singular_systems_are_told():
    A = np.outer([1.0, 2.0, 4.0], [1.0, 0.5, 0.25])
    assert solve_general(A, np.ones(3), 3, np.zeros(3, dtype=np.int64)) == np.inf


def test_the_jacobian_is_that_of_the_function():
    """Against differences, in all three states: keep + take W of F at r with u = W r + q."""
    W, step = np.array([[1.0, 0.2, -0.1], [0.2, 0.8, 0.3], [-0.1, 0.3, 0.9]]), 1e-6
    seen, rng = set(), np.random.default_rng(7)
    for q in rng.normal(size=(60, 3)):
        r = np.abs(rng.normal(size=3))

        def miss(r, q=q):
            return np.array(contact_miss(*r, *(W @ r + q), 0.6, 1.1, 0.7))

        keep, take = np.zeros(9), np.zeros(9)
        mixed_rows(*r, *(W @ r + q), 0.6, 1.1, 0.7, keep, take)
        expected = np.column_stack([(miss(r + d) - miss(r - d)) / (2.0 * step) for d in step * np.eye(3)])
        np.testing.assert_allclose(keep.reshape(3, 3) + take.reshape(3, 3) @ W, expected, atol=1e-8)
        seen.add((take[0] > 0.0, take[3] != 0.0))
    assert seen == {(False, False), (True, False), (True, True)}  # open, sticking, sliding


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
def test_newton_and_proximal_points_dense_and_by_blocks(make):
    problem = make()
    alike, n = problem.balanced(), len(problem.friction)
    W, free, friction, _ = alike._data
    start = swept(alike, alike.dense(), 10)[0].forces
    found = []
    for operator, steps in ((W, newton), (ConeBlocks(W), newton_on_blocks)):
        work, forces = cone_work(n), start.copy()
        left, solved = steps(operator, free, friction, n, 0.0, forces, 1e-13, 60, work)
        assert solved <= 60
        if left > 1e-10:
            proximal(W, free, friction, n, forces, 1e-12, 500, work)
        assert alike.residual(forces) <= 1e-12
        found.append(forces)
    far = np.zeros(3 * n)  # from nothing, by proximal points alone
    residual, _ = proximal(W, free, friction, n, far, 1e-11, 1000, cone_work(n))
    assert residual <= 1e-11
    assert alike.residuals(far)[1] <= 1e-11
    velocities = [alike.velocity(forces) for forces in found]
    np.testing.assert_allclose(*velocities, atol=1e-8)


def test_newton_tells_what_it_reached():
    problem = heap(30, 12, seed=3).balanced()
    n = len(problem.friction)
    forces = np.zeros(3 * n)
    left, solved = newton(*problem._data[:3], n, 0.0, forces, 1e-13, 2, cone_work(n))
    assert solved == 2
    assert left > 1e-6


def test_proximal_points_are_put_ahead_on_the_line_of_their_drift():
    """Forty contacts of six bodies with friction 0.9 to 1: each centre at the last point took 412 linear systems."""
    problem = heap(40, 6, seed=2, friction=(0.9, 1.0)).balanced()
    forces = np.zeros(120)
    residual, solved = proximal(*problem._data[:3], 40, forces, 1e-11, 1500, cone_work(40))
    assert residual <= 1e-11
    assert problem.residuals(forces)[1] <= 1e-11
    assert solved <= 340
