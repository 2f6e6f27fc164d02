"""Problems that fall into parts: each solved by itself, put together, and what is wrong with one of them is told."""

import numpy as np
import pytest
import scipy.sparse

from lcpflex.solvers import Auto, ContactProblem, Status, TimeLimit, accept, solve_lcp
from lcpflex.solvers.contact.parts import part_of, parts_of, solved_by_parts, unknowns_of
from tests.piles import columns, shuffled

BOX = columns(1, 1)


def beside(*piles):
    """Contact problems next to each other, without anything in common."""
    G = [J @ J.T if scipy.sparse.issparse(J) else scipy.sparse.csr_array(J) for J, _, _ in piles]
    counts = [len(mu) for _, _, mu in piles]
    m = [len(free) for _, free, _ in piles]
    starts = np.concatenate([[0], np.cumsum(m)])
    normals = [np.arange(starts[i], starts[i] + counts[i]) for i in range(len(piles))]
    tangents = [np.arange(starts[i] + counts[i], starts[i] + m[i]) for i in range(len(piles))]
    rows = np.concatenate([*normals, *tangents]).astype(int)
    whole = scipy.sparse.block_diag(G, format="csr")
    free, mu = (np.concatenate([pile[i] for pile in piles]) for i in (1, 2))
    return ContactProblem(whole[rows][:, rows], free[rows], mu, [f"c{i}" for i in range(len(mu))])


JAWS = (np.array([[1.0, -1.0], [-1.0, 1.0]]), np.array([-1.0, -1.0]), np.zeros(2))  # press a body from both sides
NEVER = (np.array([[-1.0, 2.0], [2.0, 1.0]]), np.array([-1.0, 1.0]), np.zeros(2))  # no complementary point
TWO_WAYS = (np.array([[1.0, 2.0], [2.0, 1.0]]), np.array([-1.0, -1.0]), np.zeros(2))  # either contact, or both


class TestParts:
    @pytest.mark.parametrize("seed", range(3))
    def test_contacts_that_share_bodies(self, seed):
        J, free, mu = shuffled(columns(4, 3), seed)
        G = J @ J.T
        everything = [(G, None), (G.toarray(), None), (None, J), (None, J.toarray())]
        found = [parts_of(ContactProblem(A, free, mu, factor=B)) for A, B in everything]
        for parts in found:
            assert [part.tolist() for part in parts] == [part.tolist() for part in found[0]]
        assert sorted(np.concatenate(found[0]).tolist()) == list(range(24))
        assert [part[0] for part in found[0]] == sorted(part[0] for part in found[0])
        assert [len(part) for part in found[0]] == [6] * 4

    def test_by_its_factor_alone(self, monkeypatch):
        from lcpflex.solvers.contact import problem as module

        J, free, mu = shuffled(columns(4, 3), 0)
        mu[::3] = 0.0
        rows = np.concatenate([np.arange(len(mu)), len(mu) + np.flatnonzero(mu)])
        problem = ContactProblem(None, free[rows], mu, factor=J[rows])
        expected = [part.tolist() for part in parts_of(problem)]
        monkeypatch.setattr(module, "MOST_BLOCKS", 1)
        problem = ContactProblem(None, free[rows], mu, factor=J[rows])
        assert [part.tolist() for part in parts_of(problem)] == expected

    def test_a_guess_of_another_problem_is_none(self):
        problem = beside(NEVER, TWO_WAYS, BOX)
        guess = solve_lcp(np.eye(3), -np.ones(3))  # without names
        found = Auto().solve(problem, guess)
        assert found.status is Auto().solve(problem).status is Status.NO_SOLUTION
        assert solved_by_parts(beside(BOX, BOX), guess, 1e-10, Auto().solve).solved

    def test_no_contacts(self):
        assert parts_of(ContactProblem(np.zeros((0, 0)), [], [])) == []

    def test_a_part_has_its_rows_and_names(self):
        problem = beside(BOX, JAWS, BOX)
        part = part_of(problem, np.array([2, 3]))
        assert part.keys == ("c2", "c3")
        assert part.dense().tolist() == JAWS[0].tolist()
        assert part.free.tolist() == JAWS[1].tolist()
        for contacts in ([0, 1], [4, 5]):
            part = part_of(problem, np.array(contacts))
            assert part.dense() == pytest.approx((BOX[0] @ BOX[0].T).toarray())


class TestAnswers:
    @pytest.mark.parametrize("seed", range(3))
    def test_the_same_as_one_by_one(self, seed):
        pile = columns(6, 5, push=0.8)
        expected = Auto().solve(ContactProblem(pile[0] @ pile[0].T, *pile[1:]))
        J, free, mu = shuffled(pile, seed)
        problem = ContactProblem(J @ J.T, free, mu)
        found = Auto().solve(problem)
        assert found.solved
        assert found.residual <= 1e-10
        order = np.random.default_rng(seed).permutation(len(mu))
        assert found.w[: len(mu)] == pytest.approx(expected.w[: len(mu)][order], abs=1e-12)
        again = Auto().solve(problem, found)
        assert again.solved
        assert again.z == pytest.approx(found.z, abs=1e-12)

    def test_many_ways_are_told_in_one_route(self):
        found = Auto().solve(beside(*[columns(1, h) for h in (1, 2, 3)], columns(2, 20)))
        assert found.solved
        assert found.route.startswith("sweeps (failed) > 5 parts: ")
        assert len(found.route) < 500


class TestPartsThatFail:
    @pytest.mark.parametrize("others", [[BOX], [columns(1, 30), columns(1, 40)]], ids=["small", "large"])
    def test_one_that_is_impossible_is_proved_for_the_whole(self, others):
        problem = beside(*others, JAWS, BOX)
        found = Auto().solve(problem)
        assert found.status is Status.INFEASIBLE
        u = found.certificate
        first = sum(len(pile[2]) for pile in others)
        assert np.flatnonzero(u).tolist() == [first, first + 1]
        M, q = problem.lcp()._data
        assert (u >= 0.0).all()
        assert (M.T @ u <= 0.0).all()
        assert q @ u < 0.0
        assert len(found.proof) == problem.size

    @pytest.mark.parametrize("others", [[BOX], [columns(1, 30), columns(1, 40)]], ids=["small", "large"])
    def test_one_with_several_solutions(self, others):
        found = Auto().solve(beside(*others, TWO_WAYS))
        assert found.solved
        for z in found.solutions:
            assert beside(*others, TWO_WAYS).residual(z) <= 1e-10

    @pytest.mark.parametrize("others", [[BOX], [columns(1, 30), columns(1, 40)]], ids=["small", "large"])
    def test_one_without_complementary_point_settles_the_whole(self, others):
        problem = beside(*others, NEVER)
        found = Auto().solve(problem)
        assert found.status is Status.NO_SOLUTION
        first = sum(len(pile[2]) for pile in others)
        place = np.r_[:first, first + 2 : 2 * first + 2, 2 * first + 2 : problem.size]
        assert part_of(problem, np.arange(first)).residual(found.z[place]) <= 1e-10  # the others are solved

    def test_one_that_is_not_solved_is_named(self):
        def solve(part, guess):
            if "c2" not in part.keys:
                return Auto().solve(part)
            return accept(part, np.zeros(part.size), tolerance=1e-10, status=Status.RAY, route="a ray")

        problem = beside(BOX, columns(1, 3), BOX)
        found = solved_by_parts(problem, None, 1e-10, solve)
        assert not found.solved
        assert found.message.startswith("ray: 1 of 3 parts not solved; that of contact 'c2' (6 contacts")
        assert found.route == "3 parts: lemke (2 x), a ray (failed)"
        assert len(found.message) < 500
        for contacts in ([0, 1], [8, 9]):
            place = unknowns_of(problem, np.array(contacts))
            assert part_of(problem, np.array(contacts)).residual(found.z[place]) <= 1e-10

    def test_one_on_which_next_to_nothing_acts(self):
        """It has no solution, and neither has the whole, however little is missed: that is proved."""
        G, q, mu = NEVER
        problem = beside(BOX, (G, 1e-14 * q, mu))
        found = Auto().solve(problem)
        assert not found.solved
        assert found.residual == problem.residual(found.z) > 0.1
        assert found.status is Status.NO_SOLUTION

    def test_no_time_for_all(self):
        found = TimeLimit(Auto(), 1e-6).solve(beside(columns(2, 30), columns(2, 40)))
        assert found.status is Status.TIME_LIMIT
        assert "not begun" in found.route
