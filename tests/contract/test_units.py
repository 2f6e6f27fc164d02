"""The same problem in other units: residual, status and answer stay, however light or heavy the bodies."""

import numpy as np
import pytest

from lcpflex.solvers import Auto, BlockGaussSeidel, ContactProblem, Lcp, Lemke, MinMapNewton, PrincipalPivoting, Status

POWERS = (-15, -10, -3, 3, 10, 13, 15)


def contacts(seed, n, mass=0.0, speed=0.0, factor=False):
    """n contacts of bodies of 10^mass kg, whose velocities are 10^speed times as large."""
    rng = np.random.default_rng(seed)
    J = rng.standard_normal((2 * n, n + 2))
    free, mu = J @ rng.standard_normal(n + 2), rng.uniform(0.1, 1.0, n)
    if factor:
        return ContactProblem(None, free * 10.0**speed, mu, factor=J * 10.0 ** (-mass / 2))
    return ContactProblem(J @ J.T * 10.0**-mass, free * 10.0**speed, mu)


def forces(problem, z, mass=0.0, speed=0.0):
    return np.concatenate(problem.forces(z)) * 10.0 ** (-mass - speed)


@pytest.mark.parametrize("speed", [0, 3, -7])
@pytest.mark.parametrize("mass", POWERS)
@pytest.mark.parametrize("solver", [Auto(), Lemke(), BlockGaussSeidel()], ids=lambda s: type(s).__name__)
def test_contacts_in_other_units(solver, mass, speed):
    for seed, n in ((1, 2), (2, 3), (3, 6), (4, 10)):
        known = contacts(seed, n)
        reference, problem = solver.solve(known), contacts(seed, n, mass, speed)
        found = solver.solve(problem)
        assert found.status is reference.status
        if found.solved:
            told = forces(problem, found.z, mass, speed)
            expected = forces(known, reference.z)
            assert np.abs(told - expected).max() <= 1e-9 * np.abs(expected).max()
            assert known.residual(known.unknowns(*np.split(told, [n]))) <= 1e-10


@pytest.mark.parametrize("mass", POWERS)
@pytest.mark.parametrize("factor", [False, True])
def test_a_wrong_answer_is_as_wrong_in_other_units(mass, factor):
    known, problem = contacts(5, 4), contacts(5, 4, mass, 2.0, factor)
    z = Auto().solve(known).z
    for row in range(4, 8):  # friction alone is off: with light bodies its impulses are small beside velocities
        wrong = z.copy()
        wrong[row] += 1e-3 * np.abs(z).max()
        other = wrong * np.where(np.arange(12) < 8, 10.0 ** (mass + 2.0), 10.0**2.0)
        assert problem.residual(other) == pytest.approx(known.residual(wrong), rel=1e-9)
        assert problem.residual(other) > 1e-5
        assert problem.residuals(other)[1] == pytest.approx(known.residuals(wrong)[1], rel=1e-9)
        assert not problem.lcp().residual(other) <= 1e-6


@pytest.mark.parametrize(
    "solver", [Auto(), Lemke(), PrincipalPivoting(), MinMapNewton()], ids=lambda s: type(s).__name__
)
def test_an_lcp_whose_unknowns_have_units_of_their_own(solver):
    rng = np.random.default_rng(8)
    for n in (2, 5, 12):
        A = rng.standard_normal((n, n + 1))
        M, q = A @ A.T, rng.standard_normal(n)
        z = solver.solve(Lcp(M, q)).z
        d = 10.0 ** rng.uniform(-12, 12, n)
        found = solver.solve(Lcp(M * d * d[:, None], q * d))
        assert found.solved
        assert np.abs(found.z * d - z).max() <= 1e-9 * np.abs(z).max()
        wrong = z + 1e-3 * np.abs(z).max() * (np.arange(n) == n - 1)
        told = Lcp(M * d * d[:, None], q * d).residual(wrong / d)
        assert 0.2 < told / Lcp(M, q).residual(wrong) < 5.0


def test_two_sizes_of_a_residual():
    """Forces of 1e8 that balance each other hide 1e-2 of the free velocity in rounding of 1e-10 of the terms."""
    G = np.array([[1.0, -1.0], [-1.0, 1.0]])
    problem = ContactProblem(G, [1e-8, 1e-8], [0.0, 0.0])
    told = problem.residuals([1.0, 1.0])
    assert told == pytest.approx((1.0, 1.0))  # 1e-8 of the terms, but all of the free velocity: judged against that
    assert ContactProblem(G, [0.0, 0.0], [0.0, 0.0]).residuals([1.0, 1.0]) == (0.0, 0.0)
    solution = Auto().solve(contacts(1, 3))
    assert solution.residual <= solution.strict <= 1e-9
    assert Auto().solve(Lcp(np.eye(2), [-1.0, -2.0])).strict == 0.0


def test_contacts_between_bodies_that_are_held():
    """A row of zeros, or of what rounding leaves of one, has no scale of its own and spoils that of no other."""
    for left in (0.0, 1e-18, 1e-25):
        G = np.array([[2.0, 0, 0.5, 0], [0, left, 0, 0], [0.5, 0, 2.0, 0], [0, 0, 0, left]])
        problem = ContactProblem(G, [-1.0, 0.3, 0.2, 0.1], [0.5, 0.5])
        found = Auto().solve(problem)
        assert found.solved
        assert found.z[0] == pytest.approx(
            ContactProblem(G[::2, ::2], [-1.0, 0.2], [0.5]).forces(
                Auto().solve(ContactProblem(G[::2, ::2], [-1.0, 0.2], [0.5])).z
            )[0][0],
            rel=1e-12,
        )
        found.z.flags.writeable = True
        wrong = found.z.copy()
        wrong[0] *= 1.001
        assert problem.residual(wrong) > 1e-5


@pytest.mark.parametrize("n", [3, pytest.param(30, marks=pytest.mark.slow)])
def test_numbers_below_the_normal_range_end_at_once(n):
    """They cost a hundred times the others in every operation: no ladder of attempts on them."""
    rng = np.random.default_rng(3)
    J = rng.standard_normal((2 * n, n + 2))
    for size, speed in ((1e-310, 1e-310), (1e-310, 1.0), (5e-324, 1.0), (1.0, 1e-310)):
        problem = ContactProblem(J @ J.T * size, J @ rng.standard_normal(n + 2) * speed, np.full(n, 0.5))
        found = Auto().solve(problem)
        assert not found.solved or problem.residual(found.z) <= 1e-10
        assert found.iterations < 100_000
    light = ContactProblem(J @ J.T * 1e-300, J @ rng.standard_normal(n + 2) * 1e-10, np.full(n, 0.5))
    assert Auto().solve(light).status is Status.SOLVED
