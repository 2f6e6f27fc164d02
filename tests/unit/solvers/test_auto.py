"""The default solver: who solves what, proofs checked by hand, warm starts by contact, many contacts."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse

from lcpflex.errors import ModelError, SolverError
from lcpflex.solvers import Auto, BoxedLcp, ContactProblem, Lcp, Lemke, SpatialContactProblem, Status, solve_lcp
from lcpflex.solvers.auto import auto, auto_workspace
from lcpflex.solvers.contact import spatial
from lcpflex.solvers.user_table import MANY, SMALL
from tests.property.random_contacts import draw, miss

UP_TO_THE_LAST = "lemke (failed) > min-map Newton (failed) > linear program of Farkas (failed)"
INFEASIBLE = Lcp([[0.0, 1.0], [0.0, 0.0]], [-1.0, -1.0])  # w2 = -1 whatever z is
UNSOLVABLE = Lcp([[-1.0, 2.0], [1.0, 1.0]], [-1.0, 1.0])  # w2 > 0 makes z2 = 0, and then w1 < 0


def padded(n, weight=1.0):
    """UNSOLVABLE among n - 2 unknowns that have nothing to do with it."""
    M, q = np.eye(n), -np.ones(n)
    M[:2, :2], q[:2] = weight * UNSOLVABLE.M, weight * UNSOLVABLE.q
    return Lcp(M, q)


def masses(friction, slide, keys=(), order=None) -> ContactProblem:
    """Mass points of 1 kg, one contact each, that arrive at the floor with 1 m/s and slide with ``slide`` m/s."""
    friction, slide = np.array(friction, dtype=float), np.array(slide, dtype=float)
    if order is not None:
        friction, slide = friction[order], slide[order]
    rough = friction > 0.0
    return ContactProblem(
        np.eye(len(friction) + rough.sum()), np.concatenate([-np.ones(len(friction)), slide[rough]]), friction, keys
    )


class Coupled:
    """Contacts a to j of bodies in general position, with a solution that is known because it was chosen first.

    Contacts a, b, c stick, d, e slide forth, f back, the others are open.
    """

    names = "abcdefghij"

    def __init__(self) -> None:
        n = len(self.names)
        rng = np.random.default_rng(5)
        rows = rng.standard_normal((2 * n, 3 * n))
        self.G = rows @ rows.T
        self.friction = rng.uniform(0.2, 0.8, n)
        self.normal = np.where(np.arange(n) < 6, rng.uniform(1.0, 2.0, n), 0.0)
        share = np.array([0.3, -0.5, 0.7, -1.0, -1.0, 1.0, 0.0, 0.0, 0.0, 0.0])
        self.tangential = share * self.friction * self.normal
        gap_rate = np.where(self.normal > 0.0, 0.0, rng.uniform(1.0, 2.0, n))
        slip = np.array([0.0, 0.0, 0.0, 1.5, 1.0, -2.0, 1.0, -1.0, 2.0, -2.0])
        forces = np.concatenate([self.normal, self.tangential])
        self.free = np.concatenate([gap_rate, slip]) - self.G @ forces

    def problem(self, names: str) -> ContactProblem:
        """The problem of some of the contacts, in this order; the same forces solve it if only open ones are left out.

        The free velocity is that with the others absent: the Delassus matrix couples contacts by forces only.
        """
        chosen = np.array([self.names.index(name) for name in names])
        rows = np.concatenate([chosen, len(self.names) + chosen])
        return ContactProblem(self.G[np.ix_(rows, rows)], self.free[rows], self.friction[chosen], tuple(names))

    def expected(self, names: str) -> tuple[np.ndarray, np.ndarray]:
        chosen = [self.names.index(name) for name in names]
        return self.normal[chosen], self.tangential[chosen]


class TestWhoSolvesWhat:
    def test_symmetric_matrices_go_to_principal_pivoting(self):
        solution = Auto().solve(Lcp([[2.0, 1.0], [1.0, 2.0]], [-5.0, -6.0]))
        assert solution.route == "principal pivoting"
        assert solution.z == pytest.approx([4 / 3, 7 / 3], rel=1e-14)

    def test_a_semidefinite_matrix_of_rank_one(self):
        # The mass 1 / 2 kg hit by three equal contacts at once: only the sum is determined.
        solution = Auto().solve(Lcp(2.0 * np.ones((3, 3)), -3.0 * np.ones(3)))
        assert solution.solved
        assert solution.route == "principal pivoting"
        assert solution.z.sum() == pytest.approx(1.5, rel=1e-13)

    @pytest.mark.parametrize("n", [4, 30])
    def test_p_matrices_go_to_lemke(self, n):
        M = np.tril(2.0 * np.ones((n, n)), -1) + np.eye(n)
        solution = Auto().solve(Lcp(M, -np.ones(n)))
        assert solution.route == "lemke"
        assert solution.z == pytest.approx(np.eye(n)[0], abs=1e-13)

    def test_friction_in_a_wedge_goes_to_the_copositive_form(self):
        # One body, wedged between five contacts of high friction.
        J = [[-3, -4, 3], [3, 4, -1], [-1, -2, 3], [3, -1, -2], [-2, -1, 3]]
        J += [[4, -3, -1], [3, -2, 3], [-3, 0, 2], [-2, -4, 2], [4, -2, 4]]
        W = np.array(J, dtype=float)
        free = [-2.0, 2.0, -2.0, -8.0, 2.0, -14.0, -10.0, 6.0, -4.0, -12.0]
        problem = ContactProblem(W @ W.T, free, np.full(5, 5.0))
        assert Lemke().solve(problem).status is Status.RAY
        solution = Auto().solve(problem)
        assert solution.solved
        assert solution.route == "lemke (failed) > lemke on the copositive form"
        assert solution.keys == problem.unknown_keys

    def test_one_contact_wedged(self):
        # One body of one degree of freedom: v_N = 2 v_T, so t = 1 - 2 p sticks for every p >= 1/4.
        problem = ContactProblem([[8.0, 4.0], [4.0, 2.0]], [-4.0, -2.0], [2.0])
        solution = Auto().solve(problem)
        (normal,), (tangential,) = problem.forces(solution.z)
        assert solution.solved
        assert normal >= 0.25 - 1e-12
        assert tangential == pytest.approx(1.0 - 2.0 * normal, abs=1e-12)

    @pytest.mark.parametrize(
        ("M", "q", "z", "route"),
        [
            ([[-2.0, 2.0], [0.0, -2.0]], [-1.0, 1.0], [0.0, 0.5], "lemke (failed) > min-map Newton"),
            ([[-2.0, 2.0], [1.0, -1.0]], [-2.0, 2.0], [0.0, 2.0], f"{UP_TO_THE_LAST} > enumeration"),
        ],
    )
    def test_what_lemke_leaves_on_a_ray(self, M, q, z, route):
        solution = Auto().solve(Lcp(M, q))
        assert solution.status is Status.SOLVED
        assert solution.route == route
        assert solution.z == pytest.approx(z, abs=1e-13)

    def test_what_enumeration_finds_for_contacts_is_told_apart_by_forces(self):
        # Only one contact presses, p = 5/2 and t = 2 at rest; the other lifts off with a speed split in many ways.
        G = [[2.0, 2.0, -4.0, 1.0], [2.0, -4.0, 3.0, 3.0], [-4.0, 3.0, 6.0, -1.0], [1.0, 3.0, -1.0, -4.0]]
        problem = ContactProblem(G, [3.0, -1.0, -2.0, -1.0], [1.0, 1.0])
        solution = Auto().solve(problem)
        assert solution.status is Status.SOLVED
        assert solution.route.endswith("enumeration")
        assert np.concatenate(problem.forces(solution.z)) == pytest.approx([2.5, 0.0, 2.0, 0.0], abs=1e-13)
        # v = G (5/2, 0, 2, 0) + free
        assert problem.velocity([2.5, 0.0, 2.0, 0.0]) == pytest.approx([0.0, 10.0, 0.0, -0.5], abs=1e-13)

    def test_the_kernel_takes_the_way_of_the_class(self):
        # One call for both kinds of matrix: from nothing, and from the basis of the last call.
        for M in (np.array([[2.0, 1.0], [1.0, 2.0]]), np.array([[2.0, 1.0], [-1.0, 2.0]])):
            z, q = np.zeros(2), np.array([-5.0, -6.0])
            table, basis = auto_workspace(2)
            symmetric = M[0, 1] == M[1, 0]
            cold = auto(M, q, 2, z, table, basis, symmetric, False)
            assert cold[0] == Status.SOLVED
            assert z == pytest.approx(np.linalg.solve(M, -q), rel=1e-14)
            assert basis[:2].tolist() == [1, 1]
            z[:] = np.nan
            assert auto(M, q, 2, z, table, basis, symmetric, True) == (Status.SOLVED, 1)
            assert z == pytest.approx(np.linalg.solve(M, -q), rel=1e-14)


class TestWithoutSolution:
    @pytest.mark.parametrize(
        ("problem", "certificate"),
        [
            (INFEASIBLE, [0.0, 1.0]),
            (Lcp([[-1.0]], [-1.0]), [1.0]),
            (Lcp([[1.0, -1.0], [-1.0, 1.0]], [-1.0, -1.0]), [1.0, 1.0]),
            (Lcp([[-1.0, 2.0], [0.0, 0.0]], [-1.0, -2.0]), [0.0, 1.0]),
        ],
    )
    def test_farkas_by_hand(self, problem, certificate):
        solution = Auto().solve(problem)
        u = solution.certificate
        assert solution.status is Status.INFEASIBLE
        assert u / u.max() == pytest.approx(certificate, abs=1e-12)
        # The same three lines on paper: u >= 0, M^T u <= 0, q.u < 0, hence 0 <= u.w = q.u + z.(M^T u) < 0.
        assert (u >= 0.0).all()
        assert (problem.M.T @ u <= 1e-14 * u.max()).all()
        assert problem.q @ u < 0.0

    def test_farkas_in_units_far_apart(self):
        # Rows in kN and mN, columns in um and km: the same squeeze.
        rows, columns = np.array([1e3, 1e-3]), np.array([1e-6, 1e3])
        M = rows[:, None] * np.array([[1.0, -1.0], [-1.0, 1.0]]) * columns
        solution = Auto().solve(Lcp(M, -rows))
        assert solution.status is Status.INFEASIBLE
        assert solution.certificate * rows == pytest.approx(np.full(2, solution.certificate[0] * rows[0]), rel=1e-9)

    def test_friction_between_closing_jaws(self):
        rows = np.array([[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, 1.0]])
        problem = ContactProblem(rows @ rows.T, [-1.0, -1.0, 0.2, 0.2], [0.3, 0.3])
        solution = Auto().solve(problem)
        lcp, u = problem.lcp(), solution.certificate
        assert solution.status is Status.INFEASIBLE
        assert (u >= 0.0).all()
        assert (lcp.M.T @ u).max() <= 1e-12 * u.max()
        assert lcp.q @ u < 0.0

    def test_enumeration_proves_what_no_certificate_can(self):
        solution = Auto().solve(UNSOLVABLE)
        assert solution.status is Status.NO_SOLUTION
        assert solution.certificate is None  # w >= 0 has points: z = (0, 1)
        assert solution.route == f"{UP_TO_THE_LAST} > enumeration"

    def test_beyond_enumeration_the_search_may_prove_it_too(self):
        solution = Auto().solve(padded(20))
        assert solution.status is Status.NO_SOLUTION
        assert solution.route == f"{UP_TO_THE_LAST} > search in whole numbers"

    def test_too_large_for_the_search_is_left_open(self):
        problem = padded(50)
        solution = Auto().solve(problem)
        assert solution.status is Status.RAY  # what stopped the first method
        assert solution.certificate is None
        assert solution.route == UP_TO_THE_LAST
        assert UP_TO_THE_LAST.replace(" (failed)", "") in solution.message
        assert solution.residual == problem.residual(solution.z)

    def test_the_error_carries_the_best_point_and_the_reason(self):
        problem = padded(50, 0.1)
        M, q = problem.M, problem.q
        with pytest.raises(
            SolverError, match=r"^ray: .*nothing of lemke > min-map Newton > linear program of Farkas found"
        ) as caught:
            solve_lcp(M, q)
        best = caught.value.solution
        assert best.residual <= Lemke().solve(Lcp(M, q)).residual
        assert best.residual <= Lcp(M, q).residual(np.zeros(50))
        assert best.w == pytest.approx(M @ best.z + q, abs=1e-14)

    @pytest.mark.parametrize(
        ("problem", "status", "words"),
        [(INFEASIBLE, Status.INFEASIBLE, "infeasible"), (UNSOLVABLE, Status.NO_SOLUTION, "no solution")],
    )
    def test_the_error_says_once_what_is_wrong(self, problem, status, words):
        with pytest.raises(SolverError, match=f"^{words}: ") as caught:
            solve_lcp(problem)
        assert str(caught.value).count(words) == 1
        assert caught.value.solution.status is status
        assert (caught.value.solution.certificate is not None) == (status is Status.INFEASIBLE)


class TestSolveLcp:
    def test_takes_numbers_and_every_kind_of_problem(self):
        friction = masses([0.5], [0.2])
        assert solve_lcp([[2.0]], [-4.0]).z == pytest.approx([2.0], rel=1e-15)
        assert solve_lcp(Lcp([[2.0]], [-4.0])).z == pytest.approx([2.0], rel=1e-15)
        assert solve_lcp(BoxedLcp([[2.0]], [-4.0], 0.0, 1.5)).z == pytest.approx([1.5], rel=1e-15)
        assert friction.forces(solve_lcp(friction).z)[1] == pytest.approx([-0.2], rel=1e-14)
        assert solve_lcp([[2.0]], [-4.0], solver=Lemke()).route == "lemke"

    @pytest.mark.parametrize("wrong", [[[1.0]], None, 3.0])
    def test_a_matrix_alone_is_no_problem(self, wrong):
        with pytest.raises(ModelError, match="q is None: expected a vector"):
            solve_lcp(wrong)


class TestFrictionCoefficients:
    friction, slide = (0.1, 0.0, 0.7, 0.3), (0.5, 9.0, 0.5, -0.5)
    tangential = (-0.1, 0.0, -0.5, 0.3)  # 0.1 and 0.3 are not enough to stop 0.5 m/s, 0.7 is; the second has none

    @pytest.mark.parametrize("order", [[0, 1, 2, 3], [3, 2, 1, 0], [1, 3, 0, 2], [2, 0, 3, 1]])
    def test_each_contact_has_its_own(self, order):
        problem = masses(self.friction, self.slide, order=order)
        normal, tangential = problem.forces(Auto().solve(problem).z)
        assert normal == pytest.approx(np.ones(4), rel=1e-13)
        assert tangential == pytest.approx([self.tangential[i] for i in order if i != 1], rel=1e-13)

    def test_coupled_contacts_keep_theirs_in_any_order(self):
        case, names = Coupled(), "hdajcebfgi"
        problem = case.problem(names)
        solution = Auto().solve(problem)
        assert solution.solved
        for found, expected in zip(problem.forces(solution.z), case.expected(names), strict=True):
            assert found == pytest.approx(expected, abs=1e-11)


class TestWarmStart:
    @pytest.mark.parametrize(
        "names",
        [
            "abcdefghij",  # the same contacts
            "jihgfedcba",  # in another order
            "abcdefgj",  # two vanished
            "jfbdace",
            "abcdef",
        ],
    )
    def test_contacts_are_matched_by_name(self, names):
        case = Coupled()
        before = Auto().solve(case.problem("abcdefghij"))
        problem = case.problem(names)
        cold, warm = Auto().solve(problem), Auto().solve(problem, before)
        assert (warm.route, warm.iterations) == ("basis of the guess", 1)
        assert cold.iterations > 5
        for found, expected in zip(problem.forces(warm.z), case.expected(names), strict=True):
            assert found == pytest.approx(expected, abs=1e-11)

    @pytest.mark.parametrize(("old", "new"), [("abcdef", "gabhcdefij"), ("fcbaed", "abcdefj")])
    def test_new_contacts_start_open(self, old, new):
        case = Coupled()
        before, problem = Auto().solve(case.problem(old)), case.problem(new)
        cold, warm = Auto().solve(problem), Auto().solve(problem, before)
        assert warm.solved
        assert warm.iterations < cold.iterations
        assert warm.z == pytest.approx(cold.z, abs=1e-10)
        for found, expected in zip(problem.forces(warm.z), case.expected(new), strict=True):
            assert found == pytest.approx(expected, abs=1e-11)

    def test_without_names_the_order_would_mislead(self):
        case = Coupled()
        before, problem = Auto().solve(case.problem("abcdefghij")), case.problem("jihgfedcba")
        misled = Auto().solve(problem, replace(before, keys=None))
        named = Auto().solve(problem, before)
        assert misled.solved
        assert misled.iterations > named.iterations
        assert misled.z == pytest.approx(named.z, abs=1e-10)

    def test_other_loads_on_the_same_contacts(self):
        case = Coupled()
        problem = case.problem("abcdefghij")
        before = Auto().solve(problem)
        after = replace(problem, free=1.001 * problem.free)
        warm = Auto().solve(after, before)
        assert warm.iterations == 1
        assert warm.z == pytest.approx(1.001 * before.z, rel=1e-11)  # forces are proportional to the velocities

    @pytest.mark.parametrize("size", [0, 1, 3, 40])
    def test_a_guess_of_another_size_is_left_aside(self, size):
        problem = Coupled().problem("abcdefghij").lcp()
        guess = Auto().solve(Lcp(np.eye(size), -np.ones(size)))
        cold, warm = Auto().solve(problem), Auto().solve(problem, guess)
        assert warm.z.tobytes() == cold.z.tobytes()
        assert warm.iterations == cold.iterations

    def test_a_guess_without_basis(self):
        problem = Coupled().problem("abcdefghij")
        cold = Auto().solve(problem)
        warm = Auto().solve(problem, replace(cold, active=None))
        assert warm.solved
        assert warm.z == pytest.approx(cold.z, abs=1e-11)

    def test_a_guess_cannot_make_a_proof_wrong(self):
        for problem in (INFEASIBLE, UNSOLVABLE):
            guess = replace(Auto().solve(Lcp(np.eye(2), [-1.0, -1.0])), active=np.ones(2, dtype=np.int64))
            assert Auto().solve(problem, guess).status is Auto().solve(problem).status


class TestManyContacts:
    def test_known_by_their_factor_only(self):
        # Mass points of 1, 2 and 4 kg in turn, each on its own floor: J = diag(m^-1/2), impulses m and m mu or m v.
        n = MANY
        mass, friction = np.resize([1.0, 2.0, 4.0], n), np.resize([0.1, 0.4, 0.6, 0.2], n)
        slide = np.resize([0.3, -0.3], n)
        factor = scipy.sparse.diags_array(np.tile(mass**-0.5, 2))
        problem = ContactProblem(None, np.concatenate([-np.ones(n), slide]), friction, factor=factor)
        assert problem.size > MANY
        solution = Auto().solve(problem)
        normal, tangential = problem.forces(solution.z)
        assert solution.solved
        assert solution.route.startswith("sweeps")
        assert normal == pytest.approx(mass, rel=1e-12)
        assert tangential == pytest.approx(-np.sign(slide) * mass * np.minimum(friction, 0.3), rel=1e-12)

    @pytest.mark.parametrize(("unknowns", "first"), [(SMALL, "lemke"), (SMALL + 3, "sweeps")])
    def test_where_many_begin(self, unknowns, first):
        n = unknowns // 3
        problem = masses(np.full(n, 0.4), np.resize([0.3, -0.5], n))
        solution = Auto().solve(problem)
        assert problem.size == unknowns
        assert solution.route.startswith(first)
        assert problem.forces(solution.z)[1] == pytest.approx(np.resize([-0.3, 0.4], n), rel=1e-12)

    def test_few_with_a_factor_are_the_same_as_with_a_matrix(self):
        case = Coupled()
        dense = case.problem("abcdefghij")
        sparse = replace(dense, delassus=None, factor=np.linalg.cholesky(dense.delassus))
        solution = Auto().solve(sparse)
        assert solution.solved
        assert solution.route.startswith("sweeps")
        for found, expected in zip(sparse.forces(solution.z), case.expected("abcdefghij"), strict=True):
            assert found == pytest.approx(expected, abs=1e-9)

    def test_a_squeeze_among_many_is_never_solved(self):
        n = 1600
        factor = scipy.sparse.lil_array((2 * n, 2 * n))
        factor.setdiag(1.0)
        factor[1] = -factor[0]  # the second contact presses the body of the first from the other side
        problem = ContactProblem(None, np.concatenate([-np.ones(n), 0.1 * np.ones(n)]), 0.3 * np.ones(n), factor=factor)
        solution = Auto().solve(problem)
        assert not solution.solved
        assert solution.residual > 1e-6
        assert solution.message

    def test_a_factor_too_dense_to_be_multiplied_out(self, monkeypatch):
        """In space Newton's method needs the product; without it more sweeps go on, and nothing is raised."""
        monkeypatch.setattr(spatial, "MOST_ENTRIES", 0)
        drawn = draw(3, 27)
        factor, free = drawn.condensed
        solution = Auto().solve(SpatialContactProblem(None, free, drawn.friction, factor=factor))
        assert solution.solved
        assert solution.route == "sweeps (failed) > sweeps"
        assert miss(drawn, solution.z) < 1e-10
        never = Auto().solve(SpatialContactProblem(None, [-1.0, 0.0, 0.0], [0.5], factor=np.zeros((3, 1))))
        assert never.status is Status.ITERATION_LIMIT
