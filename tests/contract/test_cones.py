"""Contact in space against every solver that takes it: no wrong answer, and no missing one of the default solver."""

import itertools

import numpy as np
import pytest
import scipy.sparse

from lcpflex.solvers import (
    AlartCurnier,
    Auto,
    BlockGaussSeidel,
    ConicFixedPoint,
    FacetedCone,
    Lemke,
    SpatialContactProblem,
    Status,
    TimeLimit,
    UserSolver,
    all_solvers,
    cross_check,
    replay,
    solve_lcp,
)
from lcpflex.solvers.benchmark.gallery import SPATIAL_FAMILIES, family, spatial_examples
from lcpflex.solvers.contact.cones.alone import is_unique
from lcpflex.solvers.contact.cones.several import contact_solutions
from tests.cone_problems import left_of_map, planted, puck

# Force components a method is asked for, where its cost would make the study one of that method alone.
LARGEST = {"FacetedCone": 24, "ConicFixedPoint": 60}


def residual(problem, r):
    """The natural map in units of the contacts, relative to its terms as the library does, written anew in numpy."""
    W, n = problem.dense(), len(problem.friction)
    D = np.diag(W).reshape(n, 3).max(axis=1, initial=0.0)
    most = D.max(initial=0.0)
    d = 1.0 / np.sqrt(np.where(1e-13 * most < D, D, most if most > 0.0 else 1.0))
    every = np.repeat(d, 3)
    W, q, r = W * np.outer(every, every), problem.free * every, r / every
    u = W @ r + q
    worst = 0.0
    for k, mu in enumerate(problem.friction):
        force, velocity = r[3 * k : 3 * k + 3], u[3 * k : 3 * k + 3]
        worst = max(worst, left_of_map(force, velocity, mu))
    load = np.abs(q).max(initial=0.0)
    if worst > 1e-6 * load:
        return worst / load if load else np.inf
    return worst / (np.abs(q) + np.abs(W) @ np.abs(r)).max() if worst else 0.0


@pytest.mark.parametrize("name", SPATIAL_FAMILIES)
def test_what_is_said_of_an_example_is_true(name):
    for example in family(name, 1, (1, 3, 8)):
        problem = example.problem
        assert example.kind == "cone"
        assert problem.symmetric
        assert np.linalg.eigvalsh(problem.dense()).min() > -1e-12 * np.abs(problem.dense()).max()
        if example.z is not None:
            assert residual(problem, example.z) < 1e-13


@pytest.mark.parametrize("name", SPATIAL_FAMILIES)
def test_no_solver_gives_a_wrong_answer(cone_solver, name):
    kind = type(cone_solver).__name__
    asked = 0
    for example in family(name, 11, (1, 2, 6)):
        problem = example.problem
        if problem.size > LARGEST.get(kind, 1000):
            continue
        asked += 1
        found = cone_solver.solve(problem)
        assert found.z.shape == found.w.shape == (problem.size,)
        assert found.w == pytest.approx(
            problem.dense() @ found.z + problem.free, abs=1e-9 * (1 + np.abs(found.z).max())
        )
        if getattr(cone_solver, "model", ""):
            assert "not Coulomb's law" in found.route
            continue
        assert found.solved == (found.residual <= cone_solver.tolerance), example.name
        if found.solved:
            assert residual(problem, found.z) <= 1.001 * cone_solver.tolerance + 1e-15, example.name
            assert example.solvable, example.name
        for z in found.solutions if found.status is Status.NOT_UNIQUE else ():
            assert residual(problem, z) <= 1.001 * cone_solver.tolerance, example.name
    assert asked


@pytest.mark.parametrize("seed", [21, 22])
def test_the_default_solver_misses_nothing(seed):
    missed = []
    for example in spatial_examples(seed, (1, 3, 8, 20)):
        found = Auto().solve(example.problem)
        assert not found.solved or example.solvable, example.name
        if example.solvable and not found.solved:
            missed.append((example.name, found.message))
    assert not missed


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(30, 40))
def test_the_default_solver_misses_nothing_of_many(seed):
    missed, asked = [], 0
    for example in spatial_examples(seed, (2, 5, 12, 30)):
        asked += 1
        found = Auto().solve(example.problem)
        assert not found.solved or example.solvable, example.name
        assert not found.solved or residual(example.problem, found.z) <= 1.001e-10, example.name
        if example.solvable and not found.solved:
            missed.append((example.name, found.message))
    assert asked > 60
    assert not missed


class TestUniqueness:
    def test_all_three_solutions_are_told(self):
        for example in family("three solutions", 3, (1, 2)):
            found = Auto().solve(example.problem)
            assert found.status is Status.NOT_UNIQUE
            assert len(found.solutions) == 3 * len(example.problem.friction)
            assert "solutions are known" in found.message
            for a, b in itertools.combinations(found.solutions[:3], 2):
                assert np.abs(a - b).max() > 1e-2 * np.abs(a).max()

    def test_contacts_known_to_have_one_solution_have_no_other(self):
        """Of random contacts the criterion by which the search is spared never hides a second solution."""
        rng, spared, several = np.random.default_rng(12), 0, 0
        for _ in range(400):
            A = rng.standard_normal((3, 3))
            mu = 10.0 ** rng.uniform(-1.5, 0.7)
            problem = SpatialContactProblem(A @ A.T, rng.standard_normal(3), [mu])
            count = len(contact_solutions(problem.delassus, problem.free, mu))
            several += count > 1
            if is_unique(problem):
                spared += 1
                assert count <= 1
            tiny = SpatialContactProblem(1e-210 * problem.delassus, problem.free, [mu])
            assert is_unique(tiny) == is_unique(problem)
        assert spared > 100
        assert several > 0

    def test_one_solution_is_not_called_several(self):
        for example in family("planted cones", 3, (1, 2)):
            assert Auto().solve(example.problem).status is Status.SOLVED


class TestDefaultSolver:
    def test_route_and_keys(self):
        problem = puck([1.0, 0.5, -0.1, 0.0, 0.0, 2.0])
        found = Auto().solve(problem)
        assert found.solved
        assert found.keys == problem.unknown_keys
        assert found.route.startswith("sweeps")
        assert solve_lcp(problem).z == pytest.approx(found.z, abs=1e-12)
        assert problem.solve_by(Auto()).z == pytest.approx(found.z, abs=1e-12)

    def test_starts_from_the_contacts_that_are_known(self):
        """The solution of a problem with one contact more, in another order, starts that of the others by name."""
        rng = np.random.default_rng(4)
        problem, r = planted(rng, 6, columns=40, largest=0.5)
        order = np.array([4, 1, 5, 0, 2])
        rows = (3 * order[:, None] + np.arange(3)).ravel()
        others = np.setdiff1d(np.arange(18), rows)
        W = problem.dense()
        free = problem.free[rows] + W[np.ix_(rows, others)] @ r[others]  # as if the force of the last one were given
        fewer = SpatialContactProblem(W[np.ix_(rows, rows)], free, problem.friction[order], tuple(order.tolist()))
        found = Auto().solve(fewer, Auto().solve(problem))
        assert found.solved
        assert found.route == "forces of the guess"
        assert found.z == pytest.approx(r[rows], abs=1e-8)

    def test_parts_are_solved_by_themselves(self):
        """A hard part beside easy ones: the route counts them, and the whole is judged."""
        blocks = [example.problem for example in family("cone piles", 5, (6, 9))]
        W = scipy.sparse.block_diag([p.dense() for p in blocks], format="csr")
        free, mu = np.concatenate([p.free for p in blocks]), np.concatenate([p.friction for p in blocks])
        for delassus in (W, W.toarray()):
            found = Auto().solve(SpatialContactProblem(delassus, free, mu))
            assert found.solved
        factor = scipy.sparse.block_diag([p.factor for p in blocks], format="csr")
        assert Auto().solve(SpatialContactProblem(None, free, mu, factor=factor)).solved

    def test_part_without_a_solution_is_named(self):
        jaws = next(family("cone jaws", 1, (2,))).problem
        free = puck([1.0, 0.0, -0.1, 0.0, 0.0, 0.0])
        W = scipy.sparse.block_diag([free.dense(), jaws.dense()]).toarray()
        both = SpatialContactProblem(
            W, np.concatenate([free.free, jaws.free]), np.concatenate([free.friction, jaws.friction]),
            ("a", "b", "c", "d", "left jaw", "right jaw"),
        )  # fmt: skip
        found = Auto().solve(both)
        assert not found.solved
        assert "left jaw" in found.message
        assert "(failed)" in found.route

    def test_the_best_point_where_nothing_certifies(self):
        """An answer within a thousand times the tolerance is INACCURATE, with its residual; never solved."""
        problem = next(family("cone piles", 5, (9,))).problem
        found = Auto(tolerance=1e-17).solve(problem)
        assert not found.solved
        assert found.residual <= 1e-12
        assert found.status is Status.INACCURATE or found.residual > 1e-14

    def test_time_limit(self):
        problem = next(iter(family("cone jaws", 1, (40,)))).problem
        for solver in (Auto(budget=1e-6), TimeLimit(Auto(), 1e-6)):
            found = solver.solve(problem)
            assert found.status is Status.TIME_LIMIT
            assert "time limit" in found.message

    def test_unsymmetric_operators(self):
        rng = np.random.default_rng(6)
        problem, r = planted(rng, 8, columns=40, largest=0.5)
        W = problem.dense() + 0.01 * rng.standard_normal((24, 24))
        other = SpatialContactProblem(W, problem.slack(r) - W @ r, problem.friction)
        found = Auto().solve(other)
        assert found.solved
        assert found.z == pytest.approx(r, abs=1e-7)

    @pytest.mark.parametrize("solver", [Auto(), BlockGaussSeidel(), AlartCurnier()], ids=lambda s: type(s).__name__)
    def test_units_do_not_matter(self, solver):
        """Contacts in units of their own, powers of two: the same answer to the bit, but for those units."""
        problem, _ = planted(np.random.default_rng(9), 7, columns=30)
        plain = SpatialContactProblem(problem.delassus, problem.free, problem.friction)
        d = np.repeat(4.0 ** np.array([-3, 4, 0, 2, -1, 5, -4]), 3)
        other = SpatialContactProblem(problem.delassus * np.outer(d, d), problem.free * d, problem.friction)
        first, second = solver.solve(plain), solver.solve(other)
        assert first.solved
        assert (second.z * d).tobytes() == first.z.tobytes()

    def test_isotropy(self):
        """The friction of a puck on four feet against its direction: the same to 1e-8."""
        for solver in (Auto(), BlockGaussSeidel(), AlartCurnier()):
            size = []
            for angle in np.linspace(0.0, np.pi, 25):
                problem = puck([np.cos(angle), np.sin(angle), -1.0, 0.0, 0.0, 0.0], mu=0.2)
                size.append(np.hypot(*problem.forces(solver.solve(problem).z)[:, 1:].sum(axis=0)))
            assert np.ptp(size) < 1e-8 * max(size)


class TestComparisons:
    problem = puck([0.5, 0.2, -0.1, 0.0, 0.0, 2.0], mu=0.3, feet=3)

    def test_everybody_agrees_and_other_models_are_told_apart(self):
        check = cross_check(self.problem, repeats=1, name="puck")
        rows = {row.solver: row for row in check.rows}
        assert check.kind == "SpatialContactProblem"
        for name in ("Auto", "BlockGaussSeidel", "AlartCurnier", "ConicFixedPoint"):
            assert rows[name].solved
            assert rows[name].same_motion
        for name, model in (("FacetedCone", "friction cone of 8 facets"), ("ConvexFriction", "convex relaxation")):
            assert rows[name].model == model
            assert rows[name].same_motion is None
            assert rows[name].difference is None
            assert rows[name].residual > 1e-4
            assert f"another model: {model}" in check.table()
            assert name != check.reference
        assert rows["Lemke"].status == "refused"
        assert check.verdict == "all 4 solvers that solved it agree in the contact velocities"

    def test_who_takes_it(self):
        assert set(all_solvers(self.problem)) == {
            "AlartCurnier", "Auto", "BlockGaussSeidel", "ConicFixedPoint", "ConvexFriction", "FacetedCone",
        }  # fmt: skip

    def test_wrong_claims_are_found(self):
        class Liar:
            def refuses(self, problem):
                return ""

            def solve(self, problem, guess=None):
                return FacetedCone(4).solve(problem)

        check = cross_check(self.problem, {"Liar": UserSolver(Liar()), "Auto": Auto()}, repeats=1)
        assert check.contradictory
        assert check.rows[0].wrong

    def test_replay_keeps_models_out_of_the_profile(self):
        problems = [example.problem for example in family("pucks", 2, (3, 5))]
        solvers = {"Auto": Auto(), "facets": FacetedCone(), "Lemke": Lemke(), "programs": ConicFixedPoint()}
        found = replay(problems, solvers, repeats=1, warm=True)
        rows = {row.solver: row for row in found.rows}
        assert not found.contradictory
        assert rows["Auto"].solved == rows["programs"].solved == len(problems)
        assert rows["Lemke"].refused == len(problems)
        assert np.isinf(found.times[1]).all()
        names = [text.get_text() for text in found.plot().axes[0].get_legend().get_texts()]
        assert not any("facets" in name for name in names)
