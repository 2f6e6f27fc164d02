"""INFEASIBLE and NO_SOLUTION against an exact judge: nearly singular and badly scaled problems, and planted proofs."""

import itertools
from collections import Counter

import numpy as np
import pytest

from lcpflex.basics import libs
from lcpflex.errors import ModelError
from lcpflex.solvers import (
    Auto,
    BlockGaussSeidel,
    BoxedLcp,
    ContactProblem,
    ConvexFriction,
    Enumeration,
    Lcp,
    Lemke,
    MixedLcp,
    PrincipalPivoting,
    QuadraticProgram,
    Status,
    accept,
)
from lcpflex.solvers.contact.relaxation import ConvexContactProblem
from lcpflex.solvers.lcp.exact import Dictionary, Exhausted
from lcpflex.solvers.lcp.proofs import Proof, exact_solution, infeasibility, proves
from tests.contract.rational_judge import is_feasible, is_solvable, proves_infeasible

ROWS = 6  # rows whose units are farther apart than the tolerance allows count as fulfilled
UNSOLVABLE = Lcp([[-1.0, 2.0], [1.0, 1.0]], [-1.0, 1.0])


def powers(rng, n, most=40):
    """Powers of two: scaling by them rounds nothing."""
    return 2.0 ** rng.integers(-most, most + 1, n)


def opposed(rng):
    """[[1, -1], [-1, 1 + 2^-k]] and relatives, in any units of its rows and columns."""
    k = int(rng.integers(1, 53))
    M = np.array([[1.0, -1.0], [-1.0, 1.0 + rng.choice([-1, 0, 1]) * 2.0**-k]])
    q = rng.integers(-3, 4, 2) + rng.choice([0.0, 2.0**-20, 2.0**-50], 2)
    rows = powers(rng, 2) if rng.random() < 0.5 else np.ones(2)
    columns = rows if rng.random() < 0.5 else powers(rng, 2)
    return rows[:, None] * M * columns, rows * q


def nearly_semidefinite(rng):
    """J J^T of rank 1 or 2 and a little more or less on its diagonal or anywhere."""
    n = int(rng.integers(2, 4))
    J = rng.integers(-4, 5, (n, int(rng.integers(1, n + 1)))).astype(float)
    M = J @ J.T + 2.0 ** -float(rng.integers(4, 48)) * rng.integers(-1, 2, (n, n))
    return (M + M.T) / 2 if rng.random() < 0.5 else M, rng.integers(-3, 4, n).astype(float)


def dependent(rng):
    """The last row is a sum of the others to rounding; what it asks for is too, or nearly, or not at all."""
    n = int(rng.integers(2, 4))
    M, q = rng.standard_normal((n, n)), rng.standard_normal(n)
    part = -rng.uniform(0.1, 1.0, n - 1)
    M[-1], q[-1] = part @ M[:-1], part @ q[:-1] - rng.choice([0.0, 1e-14, 1e-7, 1.0])
    return M, q


def scattered(rng):
    """Entries of any size within 2^+-40, some of them zero."""
    n = int(rng.integers(2, 4))
    M = rng.standard_normal((n, n)) * 2.0 ** rng.integers(-40, 41, (n, n)) * (rng.random((n, n)) < 0.8)
    return M, rng.standard_normal(n) * powers(rng, n)


def pushed(rng):
    """A matrix of small integers, which has singular blocks."""
    n = int(rng.integers(2, 4))
    return rng.integers(-2, 3, (n, n)).astype(float), rng.integers(-2, 3, n).astype(float)


FAMILIES = (opposed, nearly_semidefinite, dependent, scattered, pushed)


def claims_are_true(seed, count):
    """(how many of each status, how many have no solution) by solvers in turn, each claim judged."""
    rng = np.random.default_rng(seed)
    said, unsolvable, missed = Counter(), 0, 0
    others = itertools.cycle([Lemke(), Enumeration(), PrincipalPivoting(), QuadraticProgram()])
    for family in itertools.islice(itertools.cycle(FAMILIES), count):
        M, q = family(rng)
        problem, other = Lcp(M, q), next(others)
        feasible = is_feasible(M, q)
        solvable = feasible and is_solvable(M, q)
        unsolvable += not solvable
        for solver in (Auto(), other):
            if solver.refuses(problem):
                continue
            found = solver.solve(problem)
            where = f"{family.__name__}: {M.tolist()}, {q.tolist()} by {type(solver).__name__}"
            assert not (found.status is Status.INFEASIBLE and feasible), where
            assert not (found.status is Status.NO_SOLUTION and solvable), where
            assert (found.status is Status.INFEASIBLE) == bool(found.proof) == (found.certificate is not None), where
            assert not found.proof or proves_infeasible(M, q, found.proof), where
            if isinstance(solver, Auto):
                said[found.status.name] += 1
                missed += not solvable and not found.settled
    return said, unsolvable, missed


class TestClaims:
    def test_none_is_false(self):
        said, unsolvable, missed = claims_are_true(1, 200)
        assert said["INFEASIBLE"] > 20
        assert said["NO_SOLUTION"] > 2
        assert unsolvable > 50
        assert missed <= 0.05 * unsolvable

    @pytest.mark.slow
    def test_none_of_a_thousand_is_false(self):
        said, unsolvable, missed = claims_are_true(2, 1000)
        print(f"{dict(said)}; {unsolvable} have no solution, {missed} of them not proved")
        assert missed <= 0.05 * unsolvable

    @pytest.mark.campaign
    def test_none_of_ten_thousand_is_false(self):
        said, unsolvable, missed = claims_are_true(3, 10_000)
        print(f"{dict(said)}; {unsolvable} have no solution, {missed} of them not proved")
        assert missed <= 0.05 * unsolvable

    @pytest.mark.parametrize("k", [8, 20, 26, 34, 45, 52])
    @pytest.mark.parametrize("kind", ["plain", "units", "order"])
    def test_definite_though_nearly_singular(self, k, kind):
        # z = (2^(k+1) + 1, 2^(k+1)) has w = 0.
        M, q = np.array([[1.0, -1.0], [-1.0, 1.0 + 2.0**-k]]), np.array([-1.0, -1.0])
        if kind == "units":
            M, q = np.array([[2.0**30], [2.0**-20]]) * M * [2.0**30, 2.0**-20], np.array([2.0**30, 2.0**-20]) * q
        if kind == "order":
            M, q = M[::-1, ::-1], q[::-1]
        for solver in (
            Auto(),
            Lemke(),
            PrincipalPivoting(),
            Enumeration(),
            QuadraticProgram(),
            QuadraticProgram("osqp"),
        ):
            found = solver.solve(Lcp(M, q))
            assert found.status not in (Status.INFEASIBLE, Status.NO_SOLUTION), solver
        proof, z = exact_solution(Lcp(M, q))
        assert proof is None
        assert (M @ z + q == 0.0).all() or k > 50

    def test_a_solution_out_of_reach_of_floats_is_told(self):
        found = Enumeration().solve(Lcp([[1.0, -1.0], [-1.0, 1.0 + 2.0**-52]], [-1.0, -1.0]))
        assert found.status is Status.NUMERICAL_FAILURE
        assert "a solution exists" in found.message
        assert found.z == pytest.approx([2.0**53, 2.0**53], rel=1e-12)


def squeeze(rng):
    """Pairs of opposite rows that both approach, among others, in any units."""
    k = int(rng.integers(1, 9))
    half = rng.standard_normal((k, k + 1))
    A = half @ half.T
    A = np.tril(A) + np.tril(A, -1).T
    q = rng.standard_normal(k)
    units = powers(rng, 2 * k, ROWS)
    asked = np.concatenate([q, -q])
    asked[[0, k]] = [-1.0, 0.5]
    return Lcp(units[:, None] * np.block([[A, -A], [-A, A]]) * units, units * asked)


def strict(rng):
    """M^T u < 0 for some u >= 0, by a part of its entries."""
    n = int(rng.integers(2, 41))
    M = rng.standard_normal((n, n))
    u = rng.uniform(0.1, 1.0, n) * (rng.random(n) < 0.5)
    u[0] = 1.0
    M[0] -= np.maximum(u @ M, 0.0) * (1.0 + 1e-9) + 1e-12
    q = rng.standard_normal(n)
    q[0] -= max(u @ q, 0.0) + 1e-3
    rows = powers(rng, n, ROWS)
    return Lcp(rows[:, None] * M * powers(rng, n), rows * q)


def tight(rng):
    """M^T u = 0 with integers: without rounding, and without room for any."""
    n = int(rng.integers(2, 17))
    M, q = rng.integers(-50, 51, (n, n)).astype(float), rng.integers(-50, 51, n).astype(float)
    u = rng.integers(0, 8, n)
    u[-1] = 1
    M[-1] = -(u[:-1] @ M[:-1])
    q[-1] = -(u[:-1] @ q[:-1]) - 1.0
    rows = powers(rng, n, ROWS)
    order = rng.permutation(n)
    return Lcp((rows[:, None] * M * powers(rng, n))[np.ix_(order, order)], (rows * q)[order])


def jaws(rng):
    """Bodies between contacts with friction that face each other and both approach."""
    k = int(rng.integers(1, 5))
    N, T = rng.standard_normal((k, 3 * k)), rng.standard_normal((k, 3 * k))
    G = np.vstack([N, T]) @ np.vstack([N, T]).T
    G = np.tril(G) + np.tril(G, -1).T
    side = np.concatenate([np.arange(k), np.arange(k), k + np.arange(k), k + np.arange(k)])
    sign = np.repeat([1.0, -1.0, 1.0, -1.0], k)
    free = rng.standard_normal(4 * k)
    free[:k], free[k : 2 * k] = -1.0, 0.25
    return ContactProblem(sign[:, None] * G[np.ix_(side, side)] * sign, free, rng.uniform(0.1, 1.0, 2 * k))


def held(rng):
    """A row that no force can lift, beside bilateral ones or between bounds."""
    n = int(rng.integers(2, 9))
    A = rng.standard_normal((n, n))
    M, q = A @ A.T, rng.standard_normal(n)
    M[0], q[0] = -np.abs(rng.standard_normal(n)), -1.0
    M[0, n - 1] = 0.0
    if rng.random() < 0.5:
        M[0, n - 2 :] = 0.0
        return MixedLcp(M, q, [n - 1] if n == 2 else [n - 2, n - 1])
    lower, upper = np.zeros(n), np.full(n, np.inf)
    lower[1:], upper[1:] = -(2.0 ** rng.integers(-4, 4, n - 1)), 2.0 ** rng.integers(-4, 4, n - 1)
    q[0] = -1.0 - float(M[0, 1:] @ lower[1:])
    return BoxedLcp(M, q, lower, upper)


def proved(seed, count):
    """(how many are proved infeasible, what was said of the others)."""
    rng = np.random.default_rng(seed)
    good, others = 0, []
    for family in itertools.islice(itertools.cycle((squeeze, strict, tight, jaws, held)), count):
        problem = family(rng)
        found = Auto().solve(problem)
        if found.status is Status.INFEASIBLE:
            good += 1
            assert proves(problem.exact_system(), found.proof)
            assert not isinstance(problem, Lcp) or proves_infeasible(problem.M, problem.q, found.proof)
        else:
            others.append(f"{family.__name__} {problem.size}: {found.status.name} {found.message[:150]}")
    return good, others


class TestProblemsWithoutAPoint:
    def test_are_proved(self):
        good, others = proved(1, 60)
        assert good >= 59, others

    @pytest.mark.slow
    def test_a_thousand_are_proved(self):
        good, others = proved(2, 1000)
        print(f"{good} of 1000 proved", *others, sep="\n")
        assert good >= 990, others

    @pytest.mark.parametrize("n", [60, 200])
    def test_large_ones_by_the_rows_that_matter(self, n):
        rng = np.random.default_rng(n)
        A = rng.standard_normal((n, n))
        M, q = np.zeros((n + 2, n + 2)), rng.standard_normal(n + 2)
        M[:n, :n] = A @ A.T
        M[n:, n:], q[n:] = [[1.0, -1.0], [-1.0, 1.0]], [-1.0, 0.5]
        found = Auto().solve(Lcp(M, q))
        assert found.status is Status.INFEASIBLE
        assert proves_infeasible(M, q, found.proof)


class TestTheDoor:
    def test_nobody_is_believed_without_a_proof(self):
        for status in (Status.INFEASIBLE, Status.NO_SOLUTION):
            assert accept(UNSOLVABLE, [0.0, 0.0], tolerance=1e-10, status=status).status is Status.NUMERICAL_FAILURE
        other = Proof(Lcp([[-1.0]], [-1.0]), (1,))
        assert accept(UNSOLVABLE, [0.0, 0.0], tolerance=1e-10, proof=other).status is Status.NUMERICAL_FAILURE
        assert accept(UNSOLVABLE, [0.0, 0.0], tolerance=1e-10, proof=Proof(UNSOLVABLE)).status is Status.NO_SOLUTION

    def test_a_solution_outweighs_a_proof(self):
        problem = Lcp([[1.0]], [-1.0])
        found = accept(problem, [1.0], tolerance=1e-10, proof=Proof(problem, (1,)))
        assert (found.status, found.certificate, found.proof) == (Status.SOLVED, None, ())

    def test_the_vector_is_checked_on_all_rows_and_columns(self):
        system = Lcp([[1.0, -1.0], [-1.0, 1.0]], [-1.0, -0.5]).exact_system()
        assert proves(system, (1, 1))
        assert not any(proves(system, u) for u in ((1, 0), (2, 1), (-1, -1), (0, 0), (1,), (1, 1, 0)))
        squeezed = [[1.0, -1.0], [-1.0, 1.0]]
        assert not proves(Lcp(squeezed, [-1.0, 1.0]).exact_system(), (1, 1))  # q.u = 0

    def test_free_unknowns_need_equations(self):
        # z2 free: w1 = z2 - 1 >= 0 and w2 = -z2 - 1 = 0 contradict each other, u = (1, 1); any sign for bilateral rows.
        problem = MixedLcp([[0.0, 1.0], [0.0, -1.0]], [-1.0, -1.0], [1])
        proof = infeasibility(problem)
        assert proof.vector[0] == proof.vector[1] > 0
        assert not proves(problem.exact_system(), (1, 0))
        turned = MixedLcp([[0.0, 1.0], [0.0, 1.0]], [-1.0, 1.0], [1])
        proof = infeasibility(turned)
        assert proof.vector[0] == -proof.vector[1] > 0
        assert Auto().solve(problem).status is Status.INFEASIBLE

    def test_rounding_that_makes_the_lcp_proves_nothing_of_the_contact(self):
        # G_NN = mu G_NT to rounding only: whether p lifts the contact is decided by the last digit.
        mu = 0.1
        for digit in (-1, 0, 1):
            G = np.array([[0.3, 3.0], [3.0, 40.0]])
            G[0, 0] = np.nextafter(G[0, 0], digit * np.inf) if digit else G[0, 0]
            problem = ContactProblem(G, [-1.0, 1.0], [mu])
            found = Auto().solve(problem)
            if found.status in (Status.INFEASIBLE, Status.NO_SOLUTION):
                assert exact_solution(problem)[1] is None

    def test_the_relaxation_is_called_unbounded_with_a_proof_only(self):
        open_jaws = ContactProblem([[1.0, -1.0], [-1.0, 1.0]], [-1.0, -1.0], [0.0, 0.0])
        assert "without bound" in ConvexFriction().solve(open_jaws).message
        assert infeasibility(ConvexContactProblem(open_jaws)).vector == (1, 1)
        nearly = ContactProblem([[1.0, -1.0], [-1.0, 1.0 + 2.0**-45]], [-1.0, -1.0], [0.0, 0.0])
        assert "without bound" not in ConvexFriction().solve(nearly).message

    def test_the_search_gives_up_when_told_to(self):
        with pytest.raises(Exhausted):
            Dictionary([[1, -1], [2, -3]], [False], 1.0).solution()


class TestForeignExceptions:
    factor = np.array([[0.0, 0, 0], [1, 0, 0], [0, 0, 0], [0, 1, 0.3]])  # contact 0 joins two fixed bodies

    @pytest.mark.parametrize("approach", [-1.0, 0.0, 1.0])
    @pytest.mark.parametrize("unit", [1e-9, 1.0, 1e9])
    def test_a_factor_with_a_zero_row(self, approach, unit):
        problem = ContactProblem(None, unit * np.array([approach, -1.0, 0, 0.2]), [0.5, 0.5], factor=self.factor)
        found = Auto().solve(problem)
        assert found.status is (Status.INFEASIBLE if approach < 0.0 else Status.SOLVED)

    @pytest.mark.parametrize("kind", [RuntimeError, np.linalg.LinAlgError, MemoryError, ValueError])
    def test_what_scipy_raises_becomes_a_message(self, kind, monkeypatch):
        def fails(*arguments, **settings):
            raise kind("Factor is exactly singular" + 900 * "!")

        monkeypatch.setattr(libs, "splu", fails)
        problem = ContactProblem(None, [-1.0, -1.0, 0.0, 0.2], [0.5, 0.5], factor=self.factor)
        found = BlockGaussSeidel().solve(problem)
        assert not found.solved
        if kind is not RuntimeError:  # which says that there is nothing to be had but by sweeping on
            assert f"{kind.__name__}: Factor is exactly singular" in found.message
        assert len(found.message) < 500
        assert Auto().solve(problem).route.startswith("sweeps (failed) > ")

    def test_the_linear_program_fails_and_the_search_goes_on(self, monkeypatch):
        def fails(*arguments, **settings):
            raise ValueError("the solver broke")

        monkeypatch.setattr(libs, "linprog", fails)
        found = Auto().solve(UNSOLVABLE)
        assert found.status is Status.NO_SOLUTION
        assert "linear program of Farkas (failed)" in found.route
        large = Lcp(np.kron(np.eye(25), UNSOLVABLE.M), np.tile(UNSOLVABLE.q, 25))
        assert "ValueError: the solver broke" in Auto().solve(large).message

    def test_a_panic_is_no_exception_and_is_caught(self, monkeypatch):
        class PanicException(BaseException):
            pass

        def fails(*arguments, **settings):
            raise PanicException("index out of bounds")

        monkeypatch.setattr("qpsolvers.solve_problem", fails)
        found = QuadraticProgram().solve(Lcp([[2.0]], [-1.0]))
        assert found.status is Status.NUMERICAL_FAILURE
        assert "PanicException: index out of bounds" in found.message

    def test_errors_of_this_package_pass(self):
        with pytest.raises(ModelError, match="not symmetric"):
            QuadraticProgram().solve(UNSOLVABLE)


class TestRoutes:
    def test_failed_sweeps_are_told(self):
        # A squeeze known by its factor: the sweeps run first, and fail.
        J = np.array([[1.0], [-1.0]])
        found = Auto().solve(ContactProblem(None, [-1.0, 0.5], [0.0, 0.0], factor=J))
        assert found.status is Status.INFEASIBLE
        assert found.route == "sweeps (failed) > principal pivoting"

    def test_a_guess_that_was_no_help_is_told(self):
        problem = Lcp([[1.0, 3.0], [-3.0, 1.0]], [-1.0, -1.0])
        guess = Lemke().solve(Lcp([[1.0, 3.0], [-3.0, 1.0]], [1.0, 1.0]))
        found = Lemke().solve(problem, guess)
        assert found.solved
        assert found.route in ("basis of the guess", "basis of the guess (failed) > lemke")

    def test_all_parts_of_a_failure_are_marked(self):
        large = Lcp(np.kron(np.eye(25), UNSOLVABLE.M), np.tile(UNSOLVABLE.q, 25))
        found = Auto().solve(large)
        assert all(part.endswith(" (failed)") for part in found.route.split(" > "))
        assert found.route.count(">") >= 2
        assert "(failed)" not in found.message
