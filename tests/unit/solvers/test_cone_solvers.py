"""AlartCurnier and BlockGaussSeidel on contacts in space: certified, warm-started, and the same in any units."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse

from lcpflex.errors import ModelError
from lcpflex.solvers import AlartCurnier, BlockGaussSeidel, Lcp, SpatialContactProblem, Status, TimeLimit
from lcpflex.solvers.contact.system import MOST_DENSE
from tests.cones import heap, tower

SOLVERS = [AlartCurnier(), BlockGaussSeidel()]


@pytest.fixture(params=SOLVERS, ids=lambda solver: type(solver).__name__)
def solver(request):
    return request.param


def test_a_box_that_slides_on_four_corners(solver):
    """The friction of the whole box is mu m g against its motion, whatever its corners share."""
    problem = tower(1, friction=0.3, tilt=2.0)
    found = solver.solve(problem)
    assert found.status is Status.SOLVED
    assert found.strict <= 1e-9
    forces = problem.forces(found.z)
    total = forces.sum(axis=0)  # the vertical impulse stops 1 kg at 1 m/s; rows (z, x, y)
    np.testing.assert_allclose(total, [1.0, -0.3, 0.0], atol=1e-8)
    np.testing.assert_allclose(np.hypot(forces[:, 1], forces[:, 2]), 0.3 * forces[:, 0], atol=1e-8)
    np.testing.assert_allclose(found.w.reshape(-1, 3)[:, 1], 2.0 - 0.3, atol=1e-8)
    np.testing.assert_allclose(found.w, problem.velocity(found.z), atol=1e-14)


def test_one_that_sticks(solver):
    problem = tower(2, friction=0.8, tilt=0.05)
    found = solver.solve(problem)
    assert found.solved
    np.testing.assert_allclose(found.w, 0.0, atol=1e-8)


def test_both_find_the_same_velocities():
    problem = heap(12, 8, seed=5)
    first, second = (solver.solve(problem) for solver in SOLVERS)
    assert first.solved
    assert second.solved
    np.testing.assert_allclose(first.w, second.w, atol=1e-8)


def test_units_do_not_matter(solver):
    problem = heap(10, 6, seed=2)
    plain = solver.solve(problem)
    mass, speed = 2.0**-40, 2.0**13
    other = SpatialContactProblem(problem.delassus / mass, problem.free * speed, problem.friction)
    found = solver.solve(other)
    assert (plain.solved, plain.residual, plain.iterations) == (True, found.residual, found.iterations)
    np.testing.assert_array_equal(found.z, plain.z * mass * speed)


def test_bodies_of_very_different_mass(solver):
    problem = heap(6, 6, seed=4)
    scale = np.repeat(10.0 ** np.linspace(-2.5, 2.5, 6), 3)
    found = solver.solve(SpatialContactProblem(scale[:, None] * problem.delassus * scale, problem.free * scale,
                                               problem.friction))  # fmt: skip
    assert found.solved
    velocity = found.w / scale
    np.testing.assert_allclose(velocity, solver.solve(problem).w, atol=1e-7)


def test_a_guess_is_matched_by_contact(solver):
    problem = tower(3, tilt=0.4, spin=0.2)
    n = len(problem.friction)
    cold = solver.solve(problem)
    warm = solver.solve(problem, guess=cold)
    assert warm.iterations == 0
    order = np.random.default_rng(0).permutation(n)
    rows = (3 * order[:, None] + np.arange(3)).ravel()
    shuffled = SpatialContactProblem(
        problem.delassus[np.ix_(rows, rows)], problem.free[rows], problem.friction[order], tuple(order.tolist())
    )
    warm = solver.solve(shuffled, guess=cold)
    assert warm.solved
    assert warm.iterations == 0
    np.testing.assert_allclose(warm.z, cold.z[rows], atol=1e-14)
    useless = replace(cold, z=np.full(3 * n, np.nan))
    assert solver.solve(problem, guess=useless).solved


def test_dense_sparse_and_factor_are_one_problem(solver):
    problem = tower(20, tilt=0.3) if isinstance(solver, AlartCurnier) else tower(2, tilt=0.3)
    assert (len(problem.friction) > MOST_DENSE[3]) is isinstance(solver, AlartCurnier)
    values, vectors = np.linalg.eigh(problem.delassus)
    factor = vectors[:, values > 1e-12] * np.sqrt(values[values > 1e-12])
    found = [
        solver.solve(one)
        for one in (
            problem,
            SpatialContactProblem(scipy.sparse.csr_array(problem.delassus), problem.free, problem.friction),
            SpatialContactProblem(None, problem.free, problem.friction, factor=factor),
        )
    ]
    for one in found:
        assert one.solved
        np.testing.assert_allclose(one.w, found[0].w, atol=1e-7)


def test_contacts_without_friction_and_between_held_bodies(solver):
    problem = heap(5, 5, seed=6, friction=(0.0, 0.0))
    found = solver.solve(problem)
    assert found.solved
    np.testing.assert_array_equal(problem.forces(found.z)[:, 1:], 0.0)
    W = np.zeros((18, 18))
    W[:15, :15] = problem.delassus
    held = SpatialContactProblem(W, np.concatenate([problem.free, [0.5, 0.1, 0.2]]), np.append(problem.friction, 0.4))
    again = solver.solve(held)
    assert again.solved
    np.testing.assert_allclose(again.z[:15], found.z, atol=1e-9)
    np.testing.assert_array_equal(again.z[15:], 0.0)


def test_what_has_no_solution_is_not_called_solved(solver):
    """A contact between held bodies that approach: no force changes it."""
    found = solver.solve(SpatialContactProblem(np.zeros((3, 3)), [-1.0, 0.0, 0.0], [0.5]))
    assert not found.solved
    assert found.residual > 1e-3


def test_limits_are_kept_and_told():
    problem = tower(6, tilt=0.4, seed=3)
    few = BlockGaussSeidel(sweep_limit=3).solve(problem)
    assert (few.status, few.iterations) == (Status.ITERATION_LIMIT, 3)
    one = AlartCurnier(step_limit=1).solve(problem)
    assert one.status in (Status.ITERATION_LIMIT, Status.INACCURATE)
    late = TimeLimit(AlartCurnier(), 1e-9).solve(problem)
    assert late.status in (Status.TIME_LIMIT, Status.INACCURATE)
    assert not late.solved


def test_no_contacts(solver):
    found = solver.solve(SpatialContactProblem(np.zeros((0, 0)), np.zeros(0), np.zeros(0)))
    assert found.solved
    assert found.z.shape == (0,)


def test_friction_acts_against_slip_in_every_direction(solver):
    """Isotropy: a cone has no directions of its own."""
    angles = np.linspace(0.0, 2.0 * np.pi, 37)
    turned = []
    for angle in angles:
        direction = np.array([np.cos(angle), np.sin(angle)])
        problem = SpatialContactProblem(np.diag([1.0, 2.0, 2.0]), [-1.0, *(3.0 * direction)], [0.4])
        turned.append(-solver.solve(problem).z[1:] @ direction)
    np.testing.assert_allclose(turned, 0.4, rtol=0.0, atol=1e-12)


def test_other_problems_are_refused_by_name():
    lcp = Lcp(np.eye(2), [-1.0, 1.0])
    with pytest.raises(ModelError, match="problem: Lcp was given to AlartCurnier, expected a SpatialContactProblem"):
        AlartCurnier().solve(lcp)
    assert "Lcp" in AlartCurnier().refuses(lcp)
    assert AlartCurnier().refuses(tower(1)) == ""
    assert BlockGaussSeidel().refuses(tower(1)) == ""
    with pytest.raises(ModelError, match="step_limit is 0"):
        AlartCurnier(step_limit=0)
