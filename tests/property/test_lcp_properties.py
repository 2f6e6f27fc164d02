"""Complementarity problems with a known solution, and what no change of units, order or description may alter."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis.extra.numpy import arrays
from scipy.optimize import linprog
from scipy.sparse import csr_array

from lcpflex.solvers import ContactProblem, Lcp, Lemke, QuadraticProgram, Status
from lcpflex.solvers.auto import Auto
from lcpflex.solvers.contact.lcp_forms import from_copositive
from lcpflex.solvers.lcp.principal_pivoting import PrincipalPivoting
from tests.chance import given, settings, st

SIZES = st.integers(1, 8)
ENTRIES = st.floats(-3.0, 3.0, allow_subnormal=False).map(lambda x: round(x, 2))
RELAXED = settings(max_examples=60)
ANY_MATRIX = [Lemke(), Auto()]
SYMMETRIC = [*ANY_MATRIX, PrincipalPivoting()]

for_any_matrix = pytest.mark.parametrize("solver", ANY_MATRIX, ids=lambda s: type(s).__name__)
for_symmetric = pytest.mark.parametrize("solver", SYMMETRIC, ids=lambda s: type(s).__name__)


@st.composite
def definite(draw, skew: bool):
    """(M, q, z): M positive definite, z the one solution by construction, some pairs with z = w = 0."""
    n = draw(SIZES)
    A = draw(arrays(float, (n, n), elements=ENTRIES))
    M = A @ A.T + 0.5 * np.eye(n) + (A - A.T if skew else 0.0)
    kind = draw(arrays(np.int64, n, elements=st.integers(0, 2)))
    size = draw(arrays(float, n, elements=st.floats(0.1, 2.0)))
    z = np.where(kind == 0, size, 0.0)
    w = np.where(kind == 1, size, 0.0)
    return M, w - M @ z, z


@st.composite
def semidefinite(draw):
    """(M, q, w): M = J J^T of rank below n, so that z is not unique but w is."""
    n = draw(st.integers(2, 8))
    J = draw(arrays(float, (n, max(1, n // 2)), elements=ENTRIES))
    M = J @ J.T
    active = draw(arrays(bool, n))
    size = draw(arrays(float, n, elements=st.floats(0.1, 2.0)))
    w = np.where(active, 0.0, size)
    return M, w - M @ np.where(active, size, 0.0), w


@st.composite
def contacts(draw, coupling: float = 0.3, largest: float = 0.4):
    """Contact of n bodies that are weakly coupled, friction moderate: one motion; coefficients all differ."""
    n = draw(st.integers(1, 5))
    rubs = draw(arrays(bool, n))
    mu = np.where(rubs, np.linspace(0.1, largest, n), 0.0)
    m = n + int(rubs.sum())
    B = draw(arrays(float, (m, m), elements=st.floats(-1.0, 1.0).map(lambda x: round(x, 2))))
    factor = np.hstack([np.eye(m), coupling * B / m])
    free = draw(arrays(float, m, elements=ENTRIES))
    return ContactProblem(factor @ factor.T, free, mu, factor=factor)


def reordered(problem: ContactProblem, chosen) -> tuple[ContactProblem, list[int]]:
    """The problem of the contacts ``chosen``, in that order and perhaps twice; and the rows that it took."""
    row_of = {int(contact): len(problem.friction) + k for k, contact in enumerate(problem.tangent)}
    rows = [*chosen, *(row_of[i] for i in chosen if i in row_of)]
    return ContactProblem(problem.delassus[np.ix_(rows, rows)], problem.free[rows], problem.friction[chosen]), rows


def motion(problem: ContactProblem, solution):
    """Contact velocities of a solution, which must be one."""
    assert solution.solved
    return problem.velocity(np.concatenate(problem.forces(solution.z)))


class TestKnownSolutions:
    @for_any_matrix
    @RELAXED
    @given(definite(skew=True))
    def test_a_planted_solution_is_found(self, solver, planted):
        M, q, z = planted
        solution = solver.solve(Lcp(M, q))
        assert solution.solved
        assert solution.z == pytest.approx(z, abs=1e-8)

    @for_symmetric
    @RELAXED
    @given(semidefinite())
    def test_redundant_contacts_have_one_velocity(self, solver, planted):
        M, q, w = planted
        solution = solver.solve(Lcp(M, q))
        assert solution.solved
        assert solution.w == pytest.approx(w, abs=1e-7)

    @settings(RELAXED, max_examples=25)
    @given(semidefinite(), st.sampled_from(["clarabel", "osqp"]))
    def test_quadratic_programs_agree_or_say_that_they_do_not(self, planted, backend):
        M, q, w = planted
        problem = Lcp(M, q)
        solution = QuadraticProgram(backend).solve(problem)
        assert solution.solved == (problem.residual(solution.z) <= 1e-10)
        assert solution.solved
        assert solution.w == pytest.approx(w, abs=1e-6)

    @for_any_matrix
    @RELAXED
    @given(data=st.data())
    def test_single_frictional_contacts_follow_coulomb(self, solver, data):
        """Independent mass points: the answer of each is known in closed form."""
        n = data.draw(st.integers(1, 5))
        mass = data.draw(arrays(float, n, elements=st.floats(0.1, 10.0)))
        mu = data.draw(arrays(float, n, elements=st.sampled_from([0.0, 0.2, 0.7, 1.5])))
        normal = data.draw(arrays(float, n, elements=st.floats(-2.0, 2.0)))
        slide = data.draw(arrays(float, n, elements=st.floats(-2.0, 2.0)))
        tangent = np.flatnonzero(mu)
        problem = ContactProblem(
            np.diag(np.concatenate([1.0 / mass, 1.0 / mass[tangent]])), np.concatenate([normal, slide[tangent]]), mu
        )
        solution = solver.solve(problem)
        assert solution.solved
        pressed, rubbed = problem.forces(solution.z)
        expected = mass * np.maximum(-normal, 0.0)
        assert pressed == pytest.approx(expected, abs=1e-8)
        limit = mu * expected
        assert rubbed == pytest.approx(np.clip(-mass * slide, -limit, limit)[tangent], abs=1e-7)


class TestInvariance:
    @for_symmetric
    @RELAXED
    @given(definite(skew=False), st.integers(-20, 20), st.integers(-20, 20), st.data())
    def test_units_scale_the_solution(self, solver, planted, power_of_matrix, power_of_load, data):
        M, q, z = planted
        D = 10.0 ** data.draw(arrays(float, len(q), elements=st.integers(-3, 3).map(float)))
        a, b = 2.0**power_of_matrix, 2.0**power_of_load
        solution = solver.solve(Lcp(a * M * np.outer(D, D), b * q * D))
        assert solution.solved
        scaled = solution.z * D * a / b
        weight = np.sqrt(np.diag(M)) * D  # a row counts in the residual by its own size
        assert np.abs((scaled - z) * weight).max() <= 1e-6 * max(1.0, np.abs(z * weight).max(), np.abs(q * D).max())

    @for_any_matrix
    @RELAXED
    @given(definite(skew=True), st.data())
    def test_scaling_of_rows_leaves_the_solution(self, solver, planted, data):
        M, q, z = planted
        rows = 2.0 ** data.draw(arrays(float, len(q), elements=st.integers(-8, 8).map(float)))
        solution = solver.solve(Lcp(rows[:, None] * M, rows * q))
        assert solution.solved
        # A row of 2^-8 may be wrong by 2^16 times more of its own size than the largest.
        assert solution.z == pytest.approx(z, abs=1e-4)

    @for_any_matrix
    @RELAXED
    @given(definite(skew=True), st.randoms(use_true_random=False))
    def test_order_of_the_unknowns_does_not_matter(self, solver, planted, random):
        M, q, z = planted
        order = list(range(len(q)))
        random.shuffle(order)
        solution = solver.solve(Lcp(M[np.ix_(order, order)], q[order]))
        assert solution.z == pytest.approx(z[order], abs=1e-8)

    @for_any_matrix
    @RELAXED
    @given(contacts(), st.randoms(use_true_random=False))
    def test_order_of_the_contacts_does_not_matter(self, solver, problem, random):
        order = list(range(len(problem.friction)))
        random.shuffle(order)
        permuted, rows = reordered(problem, order)
        here, there = motion(problem, solver.solve(problem)), motion(permuted, solver.solve(permuted))
        assert there == pytest.approx(here[rows], abs=1e-7)

    @for_any_matrix
    @RELAXED
    @given(contacts(), st.data())
    def test_a_contact_given_twice_leaves_the_motion(self, solver, problem, data):
        n = len(problem.friction)
        chosen = [*range(n), data.draw(st.integers(0, n - 1))]
        doubled, rows = reordered(problem, chosen)
        here, there = motion(problem, solver.solve(problem)), motion(doubled, solver.solve(doubled))
        assert there == pytest.approx(here[rows], abs=1e-7)

    @for_any_matrix
    @RELAXED
    @given(contacts(), st.integers(-10, 10), st.integers(-10, 10))
    def test_mass_and_speed_scale_the_forces(self, solver, problem, mass, speed):
        a, b = 2.0**mass, 2.0**speed
        scaled = ContactProblem(problem.delassus / a, b * problem.free, problem.friction)
        here, there = motion(problem, solver.solve(problem)), motion(scaled, solver.solve(scaled))
        assert there / b == pytest.approx(here, abs=1e-6)

    @for_any_matrix
    @RELAXED
    @given(contacts(), st.data())
    def test_a_guess_changes_the_way_and_not_the_answer(self, solver, problem, data):
        change = data.draw(arrays(float, len(problem.free), elements=st.floats(-0.5, 0.5)))
        after = replace(problem, free=problem.free + change)
        cold, warm = solver.solve(after), solver.solve(after, solver.solve(problem))
        assert motion(after, warm) == pytest.approx(motion(after, cold), abs=1e-7)


class TestOptimality:
    @for_symmetric
    @RELAXED
    @given(semidefinite(), st.data())
    def test_symmetric_problems_are_quadratic_programs_without_a_gap(self, solver, planted, data):
        """min 1/2 z.M z + q.z over z >= 0; its dual is max -1/2 z.M z over M z + q >= 0, the gap z.w."""
        M, q, _ = planted
        solution = solver.solve(Lcp(M, q))
        assert solution.solved
        z, w = np.maximum(solution.z, 0.0), solution.w
        primal, dual = 0.5 * z @ M @ z + q @ z, -0.5 * z @ M @ z
        size = np.abs(z) @ (np.abs(M) @ np.abs(z) + np.abs(q))
        assert w.min() >= -1e-9 * max(1.0, np.abs(q).max())
        assert primal - dual == pytest.approx(0.0, abs=1e-9 * max(1.0, size))
        other = data.draw(arrays(float, len(q), elements=st.floats(0.0, 3.0)))
        assert primal <= 0.5 * other @ M @ other + q @ other + 1e-8 * max(1.0, size)

    @for_any_matrix
    @RELAXED
    @given(contacts(coupling=2.0, largest=2.0))
    def test_friction_and_contact_only_take_energy(self, solver, problem):
        solution = solver.solve(problem)
        assert solution.solved
        impulse = np.concatenate(problem.forces(solution.z))
        after = problem.velocity(impulse)
        assert impulse @ (0.5 * (after + problem.free)) <= 1e-8 * max(1.0, np.abs(impulse) @ np.abs(problem.free))


class TestForms:
    @RELAXED
    @given(contacts())
    def test_three_and_four_unknowns_give_the_same_motion(self, problem):
        four = Lemke().solve(problem.copositive_lcp())
        assert four.solved
        z = self.back(problem, four.z)
        assert problem.residual(z) <= 1e-9
        velocity = problem.velocity(np.concatenate(problem.forces(z)))
        assert velocity == pytest.approx(motion(problem, Lemke().solve(problem)), abs=1e-7)

    @RELAXED
    @given(contacts(coupling=2.0, largest=2.0))
    def test_the_copositive_form_always_has_an_answer(self, problem):
        # G is regular here: no forces within the cones leave all velocities at zero.
        four = Lemke().solve(problem.copositive_lcp())
        assert four.solved
        assert problem.residual(self.back(problem, four.z)) <= 1e-9

    @RELAXED
    @given(contacts(coupling=2.0, largest=2.0), st.booleans(), st.booleans(), st.data())
    def test_a_contact_problem_judges_as_its_lcp_does(self, dense, sparse, factor_only, data):
        """Slack and residual without the matrix of the LCP, from G, from a factor and from a sparse one."""
        factor = csr_array(dense.factor) if sparse else dense.factor
        problem = replace(dense, delassus=None if factor_only else dense.delassus, factor=factor)
        z = data.draw(arrays(float, problem.size, elements=st.floats(-1.0, 3.0)))
        lcp = dense.lcp()
        assert problem.slack(z) == pytest.approx(lcp.slack(z), abs=1e-12)
        assert problem.residual(z) == pytest.approx(lcp.residual(z), rel=1e-10, abs=1e-14)
        assert problem.residual(z, scaled=False) == pytest.approx(lcp.residual(z, scaled=False), rel=1e-10, abs=1e-14)

    @RELAXED
    @given(contacts(coupling=2.0, largest=2.0))
    def test_forces_and_unknowns_are_one_another(self, problem):
        z = Auto().solve(problem).z
        forces = problem.forces(z)
        back = problem.unknowns(*forces)
        assert problem.residual(back) <= 1e-9
        for there, here in zip(problem.forces(back), forces, strict=True):
            assert there == pytest.approx(here, abs=1e-9)

    @staticmethod
    def back(problem, z4):
        M, q = problem.lcp()._data
        z = np.zeros(problem.size)
        tangent = problem.tangent
        from_copositive(z4, M, q, problem.friction, tangent, len(problem.friction), len(tangent), z)
        return z


class TestHonesty:
    @for_any_matrix
    @settings(RELAXED, max_examples=150)
    @given(st.data())
    def test_what_is_said_of_small_integer_problems_is_true(self, solver, data):
        """Degenerate, singular, without class: a linear program says independently whether they are feasible."""
        n = data.draw(st.integers(1, 5))
        M = data.draw(arrays(float, (n, n), elements=st.integers(-2, 2).map(float)))
        q = data.draw(arrays(float, n, elements=st.integers(-2, 2).map(float)))
        solution = solver.solve(Lcp(M, q))
        z, w = solution.z, M @ solution.z + q
        if solution.solved:
            size = max(1.0, (np.abs(M) @ np.abs(z) + np.abs(q)).max())
            assert min(z.min(), w.min()) >= -1e-9 * size
            assert np.minimum(np.abs(z), np.abs(w)).max() <= 1e-9 * size
        feasible = linprog(np.zeros(n), A_ub=-M, b_ub=q).status == 0
        if solution.status is Status.INFEASIBLE:
            assert not feasible
        if not feasible:
            assert not solution.solved

    @for_symmetric
    @RELAXED
    @given(st.data())
    def test_semidefinite_problems_are_solved_or_proved_infeasible(self, solver, data):
        n = data.draw(st.integers(1, 6))
        J = data.draw(arrays(float, (n, max(1, n // 2)), elements=st.integers(-2, 2).map(float)))
        q = data.draw(arrays(float, n, elements=st.integers(-2, 2).map(float)))
        solution = solver.solve(Lcp(J @ J.T, q))
        feasible = linprog(np.zeros(n), A_ub=-J @ J.T, b_ub=q).status == 0
        assert solution.status is (Status.SOLVED if feasible else Status.INFEASIBLE)
