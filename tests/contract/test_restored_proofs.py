"""What is found of a problem in balanced units is true of the problem as it was posed, or is not said of it."""

from collections import Counter

import numpy as np
import pytest

from lcpflex.solvers import Auto, Enumeration, Lcp, Lemke, PrincipalPivoting, Solution, Status, cross_check
from lcpflex.solvers.acceptance import accept
from lcpflex.solvers.lcp.proofs import Proof, infeasibility
from lcpflex.solvers.problem import PROVED
from tests.contract.rational_judge import is_feasible, is_solvable, proves_infeasible

SQUEEZE = np.array([[1.0, -1.0], [-1.0, 1.0]]), np.array([-1.0, 0.5])  # no z >= 0 has w >= 0
REFUTED = np.array([[-1.0, 2.0], [1.0, 1.0]]), np.array([-1.0, 1.0])  # such z exist, none of them complementary
# d of z / d, d M d, d q.
UNITS = ([2.0**-30, 2.0**20], [1e-9, 3e7], [7e11, 1e-3], [1.1e100, 1e-100])


def scaled(problem, d):
    """The problem in other, worse units."""
    (M, q), d = problem, np.array(d)
    return Lcp(M * d * d[:, None], q * d)


def exact(d):
    """The powers of two next to the units: scaling by them rounds nothing."""
    return 2.0 ** np.round(np.log2(d))


class Claims:
    """Says of every problem that it has no solution, with a proof that ``accept`` believes; keeps the problems."""

    tolerance = 1e-10

    def __init__(self, vector=()):
        self.vector, self.asked = vector, []

    def refuses(self, problem):
        return ""

    def solve(self, problem, guess=None) -> Solution:
        self.asked.append(problem)
        return accept(problem, np.zeros(problem.size), tolerance=1e-10, proof=Proof(problem, self.vector))


@pytest.mark.parametrize("d", UNITS, ids=str)
class TestClaimsOfBalancedProblems:
    def test_no_solution_stays_where_it_is_true(self, d):
        problem = scaled(REFUTED, d)
        assert not is_solvable(problem.M, problem.q)
        for solver in (Claims(), Enumeration(), Auto()):
            found = problem.solve_by(solver)
            assert found.status is Status.NO_SOLUTION
            assert found.proof == ()

    @pytest.mark.parametrize("vector", [(), (1, 1)], ids=["NO_SOLUTION", "INFEASIBLE"])
    @pytest.mark.parametrize("push", [-1.0, 1.0])
    def test_neither_claim_outlives_a_solution(self, d, vector, push):
        problem = scaled((np.array([[2.0, 1.0], [1.0, 2.0]]), np.array([push, -3.0])), d)
        claims = Claims(vector)
        found = problem.solve_by(claims)
        (balanced,) = claims.asked
        assert balanced is not problem
        assert Claims(vector).solve(balanced).status in PROVED
        assert found.status is Status.NUMERICAL_FAILURE
        assert found.certificate is None
        assert found.proof == ()
        assert "its rounding may be the reason" in found.message
        assert not cross_check(problem).contradictory

    def test_no_solution_is_called_infeasible_where_that_is_the_reason(self, d):
        problem = scaled(SQUEEZE, exact(d))
        found = problem.solve_by(Claims())
        assert found.status is Status.INFEASIBLE
        assert proves_infeasible(problem.M, problem.q, found.proof)

    @pytest.mark.parametrize("solver", [Auto(), Lemke(), PrincipalPivoting()], ids=lambda s: type(s).__name__)
    def test_infeasible_is_proved_by_the_numbers_given(self, d, solver):
        for units in (d, exact(d)):
            problem = scaled(SQUEEZE, units)
            found = problem.solve_by(solver)
            if found.status is Status.INFEASIBLE:
                assert proves_infeasible(problem.M, problem.q, found.proof)
                assert found.certificate.max() == 1.0
        assert found.status is Status.INFEASIBLE  # where nothing was rounded


def test_squeezes_that_the_last_digit_decides():
    """M_11 M_22 - M_12^2 is of either sign, in the units given and, by other rounding, in balanced ones."""
    seen = Counter()
    for seed in range(120):
        rng = np.random.default_rng(seed)
        a, b = 10.0 ** rng.uniform(-9, 9, 2)
        c = -np.sqrt(a) * np.sqrt(b)
        c = c if seed % 3 == 0 else np.nextafter(c, -np.inf if seed % 2 else 0.0)
        problem = Lcp([[a, c], [c, b]], [-np.sqrt(a), 0.5 * np.sqrt(b)])
        balanced, units = problem.balanced()
        if units is None:
            continue
        found, feasible = problem.solve_by(PrincipalPivoting()), is_feasible(problem.M, problem.q)
        seen[feasible, infeasibility(balanced) is not None] += 1
        if found.status is Status.INFEASIBLE:
            assert not feasible
            assert proves_infeasible(problem.M, problem.q, found.proof)
        elif infeasibility(balanced) is not None:  # then it was found, and is not true of the problem
            assert feasible
            assert found.status is Status.NUMERICAL_FAILURE
            assert "its rounding may be the reason" in found.message
    assert all(seen[case] for case in ((True, True), (True, False), (False, True))), seen
