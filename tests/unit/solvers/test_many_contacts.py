"""Contact problems of many contacts: solved by their sparse matrices, within a budget, and told as they are."""

import tracemalloc
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import scipy.sparse
import scipy.sparse.linalg

from lcpflex.basics import libs
from lcpflex.errors import ModelError
from lcpflex.solvers import Auto, ContactProblem, Lemke, Status, load_siconos_contacts, user_table
from lcpflex.solvers.auto import FACTORS
from lcpflex.solvers.contact.cone import relaxed_forces
from lcpflex.solvers.contact.user_rows import relaxed, searched
from lcpflex.solvers.user_table import NEWTON, PLANE, SMALL, Case, solve_by_table
from tests.piles import SPEED, columns, heap, moving, shuffled

STORED = Path(__file__).parent / "siconos"
PILES = {
    "tower": lambda: columns(1, 60),
    "towers": lambda: columns(4, 25),
    "heavy on light": lambda: columns(1, 60, ratio=1e3),
    "light on heavy": lambda: columns(1, 60, ratio=1e-3),
    "pushed": lambda: columns(2, 30, push=0.8),
    "heap": lambda: heap(6, 12),
    "heap, masses 1e3": lambda: heap(6, 12, ratio=1e3),
    "slippery heap": lambda: heap(6, 12, friction=0.05),
    "moving heap": lambda: moving(heap(6, 12), 0.5, 1),
    "moving heap, masses 1e3": lambda: moving(heap(6, 12, ratio=1e3), 0.5, 2),
}


@cache
def pile_of(name):
    return PILES[name]()


def by_factor(pile):
    J, free, mu = pile
    return ContactProblem(None, free, mu, factor=J)


def by_matrix(pile):
    J, free, mu = pile
    return ContactProblem(J @ J.T, free, mu)


def smooth(pile):
    J, free, mu = pile
    return J[: len(mu)], free[: len(mu)], np.zeros(len(mu))


def case_of(problem, tolerance):
    return Case(PLANE, problem, None, tolerance, FACTORS, 1)


def velocity(problem, found):
    return problem.velocity(np.concatenate(problem.forces(found.z)))


class TestAnswers:
    @pytest.mark.parametrize("name", PILES)
    def test_piles(self, name):
        pile = pile_of(name)
        answers = []
        for problem in (by_factor(pile), by_matrix(pile)):
            assert problem.size > SMALL
            found = Auto(1e-8).solve(problem)
            assert found.solved
            assert problem.residual(found.z) <= 1e-8
            assert found.residual == problem.residual(found.z)
            answers.append(velocity(problem, found))
        size = np.abs(pile[1]).max()
        if "moving" not in name and "pushed" not in name:  # at rest, whatever the forces are
            assert np.abs(answers[0]).max() < 1e-5 * size or "slippery" in name
        if name in ("tower", "heap", "slippery heap"):
            assert answers[1] == pytest.approx(answers[0], abs=1e-5 * size)

    @pytest.mark.parametrize("ratio", [1.0, 1e3])
    def test_the_floor_carries_the_weight(self, ratio):
        pile = columns(3, 20, ratio=ratio)
        problem = by_factor(pile)
        normal, _ = problem.forces(Auto().solve(problem).z)
        weight = SPEED * np.geomspace(1.0, ratio, 20).sum()
        assert normal.reshape(3, 40)[:, :2].sum(axis=1) == pytest.approx(np.full(3, weight), rel=1e-9)

    @pytest.mark.parametrize("seed", range(2))
    @pytest.mark.parametrize("name", ["towers", "heap", "pushed"])
    def test_order_does_not_matter(self, name, seed):
        pile, order = pile_of(name), np.random.default_rng(seed).permutation(len(pile_of(name)[2]))
        found, other = (Auto().solve(by_matrix(one)) for one in (pile, shuffled(pile, seed)))
        assert other.solved
        n = len(order)
        assert other.w[:n] == pytest.approx(found.w[:n][order], abs=1e-7 * np.abs(pile[1]).max())

    @pytest.mark.parametrize(("mass", "speed"), [(4.0**-17, 1.0), (4.0**10, 2.0**-30), (1e-10, 1e12)])
    @pytest.mark.parametrize("kind", [by_factor, by_matrix])
    def test_units_do_not_matter(self, mass, speed, kind):
        J, free, mu = pile_of("heap, masses 1e3")
        found = Auto(1e-8).solve(kind((J, free, mu)))
        other = Auto(1e-8).solve(kind((J / np.sqrt(mass), free * speed, mu)))
        assert other.solved
        if mass in (4.0**-17, 4.0**10):  # nothing is rounded
            assert other.route == found.route
            assert np.array_equal(other.z[: len(free)], found.z[: len(free)] * mass * speed)
        n = len(mu)
        assert other.w[:n] / speed == pytest.approx(found.w[:n], abs=1e-6 * np.abs(free).max())

    def test_without_friction(self):
        for pile in (columns(2, 40), heap(8, 16), moving(heap(8, 16), 1.0, 0)):
            problem = by_factor(smooth(pile))
            found = Auto().solve(problem)
            assert found.solved
            lcp = problem.lcp()
            exact = Auto().solve(lcp)  # unique velocities
            assert found.w == pytest.approx(exact.w, abs=1e-7 * np.abs(problem.free).max())

    def test_frictional_and_smooth_contacts_together(self):
        J, free, mu = heap(6, 12)
        mu = np.where(np.random.default_rng(0).random(len(mu)) < 0.3, 0.0, mu)
        rows = np.concatenate([np.arange(len(mu)), len(mu) + np.flatnonzero(mu)])
        for problem in (by_factor((J[rows], free[rows], mu)), by_matrix((J[rows], free[rows], mu))):
            assert Auto().solve(problem).solved

    def test_single_contacts(self):
        for free, expected in (([-1.0, 0.2], "sticking"), ([-1.0, 3.0], "sliding"), ([1.0, 3.0], "open")):
            count = 40  # that do not know of each other
            wide = np.repeat(free, count)
            for matrix in (scipy.sparse.eye_array(2 * count, format="csr"), np.eye(2 * count)):
                problem = ContactProblem(matrix, wide, np.full(count, 0.5))
                found = Auto().solve(problem)
                v = velocity(problem, found).reshape(2, count)
                assert found.solved
                assert found.route == "sweeps"
                assert (v[0] == (1.0 if expected == "open" else 0.0)).all()
                assert v[1] == pytest.approx(np.full(count, {"sticking": 0.0, "sliding": 2.5, "open": 3.0}[expected]))

    def test_a_warm_start_is_used(self):
        J, free, mu = pile_of("heap, masses 1e3")
        problem = by_factor((J, free, mu))
        cold = Auto(1e-8).solve(problem)
        warm = Auto(1e-8).solve(by_factor((J, free * (1.0 + 1e-12), mu)), cold)
        assert warm.solved
        assert warm.iterations < cold.iterations / 2

    @pytest.mark.parametrize("name", ["towers", "pushed"])
    def test_a_guess_that_is_the_solution_is_returned_with_its_basis(self, name):
        problem = by_matrix(pile_of(name))
        cold = Auto().solve(problem)
        warm = Auto().solve(problem, cold)
        assert warm.route == "sweeps"
        assert warm.iterations == 0
        z = problem.unknown_units.inward(warm.z)
        w = problem.balanced().slack(z)
        assert np.abs(z[warm.active == 0]).max() <= 1e-9 * z.max()
        assert np.abs(w[warm.active == 1]).max() <= 1e-9 * z.max()

    def test_unsymmetric_operators(self):
        rng = np.random.default_rng(4)
        n = 60
        G = scipy.sparse.eye_array(2 * n) + 0.05 * scipy.sparse.random_array((2 * n, 2 * n), density=0.05, rng=rng)
        problem = ContactProblem(G, rng.standard_normal(2 * n), np.full(n, 0.4))
        found = Auto().solve(problem)
        assert found.solved
        assert found.w == pytest.approx(Lemke().solve(problem).w, abs=1e-9)
        assert relaxed(case_of(problem, 1e-10)) is None  # the relaxation is another problem than this one

    def test_impossible_ones_are_proved(self):
        J, free, mu = columns(1, 30)
        G = scipy.sparse.block_diag([J @ J.T, [[1.0, -1.0], [-1.0, 1.0]]], format="csr")
        m, n = len(free), len(mu)
        rows = np.r_[:n, m : m + 2, n:m]
        problem = ContactProblem(G[rows][:, rows], np.r_[free, -1.0, -1.0][rows], np.r_[mu, 0.0, 0.0])
        found = Auto().solve(problem)
        assert found.status is Status.INFEASIBLE


class TestMethods:
    def test_newton_alone_solves_what_slides(self):
        found = searched(case_of(by_matrix(pile_of("pushed")), 1e-8))
        assert found.solved
        assert set(found.route.split(" > ")) <= {"sweeps", "Newton", "convex law", "path"}

    def test_the_relaxation_is_exact_where_nothing_slides(self):
        for kind in (by_factor, by_matrix):
            problem = kind(pile_of("heavy on light"))
            z = problem.unknowns(*np.split(relaxed_forces(problem), [len(problem.friction)]))
            assert problem.residual(z) <= 1e-9

    def test_a_relaxation_that_fails_is_no_start(self, monkeypatch):
        class PanicException(BaseException):
            pass

        def fails(*arguments, **settings):
            raise PanicException("index out of bounds")

        monkeypatch.setattr(libs.clarabel, "DefaultSolver", fails)
        assert relaxed_forces(by_factor(pile_of("heap"))) is None
        problem = by_factor(pile_of("heap, masses 1e3"))
        rows = user_table._rows_for(PLANE, problem.size)
        chosen = [rows[0], *(row for row in rows if row.name in ("convex program", NEWTON))]
        monkeypatch.setattr(user_table, "_rows_for", lambda kind, size: chosen)
        found = solve_by_table(case_of(problem, 1e-8))
        assert found.solved
        assert found.route.startswith("sweeps (failed) > sweeps > Newton")  # the compiled attempts begin with sweeps


class TestBudget:
    HARD = moving(heap(8, 16, ratio=1e3, friction=0.3), 0.3, 5)

    def test_few_factors(self):
        problem = by_matrix(self.HARD)
        found = Auto(1e-13, factors=1).solve(problem)
        assert not found.solved
        assert found.residual == problem.residual(found.z)
        assert found.residual < problem.residual(np.zeros(problem.size))
        assert "(failed)" in found.route
        assert "convex" not in found.route.partition("(failed)")[0]

    @pytest.mark.parametrize("seconds", [1e-9, 1e-3, 0.05])
    def test_little_time(self, seconds):
        problem = by_matrix(self.HARD)
        found = Auto(1e-13, budget=seconds).solve(problem)
        assert found.solved or found.status in (Status.TIME_LIMIT, Status.INACCURATE)
        assert np.isfinite(found.z).all()
        assert found.residual == problem.residual(found.z)

    def test_small_problems_know_it_too(self):
        found = Auto(budget=10.0).solve(by_factor(columns(1, 2)))
        assert found.solved
        assert found.z.tobytes() == Auto().solve(by_factor(columns(1, 2))).z.tobytes()

    @pytest.mark.parametrize(
        ("settings", "words"),
        [
            ({"budget": 0.0}, r"budget: 0\.0 was given"),
            ({"budget": -1.0}, r"budget: -1\.0 was given"),
            ({"budget": "long"}, "budget: 'long' was given"),
            ({"budget": True}, "budget is True"),
            ({"factors": 0}, "factors is 0"),
            ({"factors": None}, "factors is None"),
            ({"factors": 1.5}, "factors is 1.5"),
        ],
    )
    def test_what_is_none(self, settings, words):
        with pytest.raises(ModelError, match=words):
            Auto(**settings)

    @pytest.mark.parametrize("kind", [RuntimeError, MemoryError, ValueError])
    def test_what_scipy_raises_ends_a_step_and_not_the_solve(self, kind, monkeypatch):
        def fails(*arguments, **settings):
            raise kind("no factor today")

        monkeypatch.setattr(scipy.sparse.linalg, "splu", fails)
        problem = by_matrix(moving(heap(9, 18), 1.0, 3))
        found = Auto(1e-13, factors=60).solve(problem)
        assert np.isfinite(found.z).all()
        if not found.solved and kind is not RuntimeError:  # which says that a matrix is singular: sweeps go on
            assert f"{kind.__name__}: no factor today" in found.message
        assert len(found.message) < 500


class TestSize:
    def test_memory_is_linear(self):
        peaks = []
        for count in (10, 40):
            problem = by_factor(columns(count, 30))
            tracemalloc.start()
            assert Auto(1e-8).solve(problem).solved
            peaks.append(tracemalloc.get_traced_memory()[1] / len(problem.friction))
            tracemalloc.stop()
        assert peaks[1] < 1.3 * peaks[0]
        assert max(peaks) < 20_000  # bytes a contact

    @pytest.mark.slow
    @pytest.mark.parametrize("kind", [by_factor, by_matrix])
    @pytest.mark.parametrize("ratio", [1.0, 1e3, 1e-3])
    def test_ten_thousand_contacts(self, kind, ratio):
        for pile in (columns(1, 5000, ratio=ratio), columns(20, 250, ratio=ratio), heap(41, 83, ratio=ratio)):
            problem = kind(pile)
            assert len(problem.friction) > 9_900
            tracemalloc.start()
            found = Auto(1e-8).solve(problem)
            peak = tracemalloc.get_traced_memory()[1]
            tracemalloc.stop()
            assert found.solved
            assert peak < 20_000 * len(problem.friction)


class TestSiconos:
    @pytest.mark.parametrize("name", sorted(path.stem for path in STORED.glob("*.dat")))
    def test_its_planar_problems(self, name):
        problem = load_siconos_contacts(STORED / f"{name}.dat")
        found = Auto().solve(problem)
        assert found.solved
        assert found.residual <= 1e-10
        sparse = ContactProblem(scipy.sparse.csr_array(problem.dense()), problem.free, problem.friction)
        assert Auto().solve(sparse).w[: len(problem.friction)] == pytest.approx(
            found.w[: len(problem.friction)], abs=1e-8 * np.abs(problem.free).max()
        )
