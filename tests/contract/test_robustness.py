"""The whole gallery against every solver: no wrong answer, and no missing one where theory promises it."""

import collections
import itertools

import numpy as np
import pytest

from lcpflex.errors import ModelError
from lcpflex.solvers import ContactProblem, Status
from lcpflex.solvers.auto import Auto
from lcpflex.solvers.benchmark.gallery import FAMILIES, examples, family

# Largest number of unknowns a method is asked for, where its cost would make the study one of that method alone.
LARGEST = {"Enumeration": 8, "QuadraticProgram-osqp": 60}


def takes(name, solver, example):
    """Whether the study asks this solver for this example."""
    other_model = getattr(solver, "model", "") and example.kind == "friction"
    return example.lcp.size <= LARGEST.get(name, 10_000) and not other_model and not solver.refuses(example.problem)


def promised(example):
    """Whether the default solver owes the answer: symmetric and semidefinite, frictional or P, and solvable."""
    return example.solvable and example.kind in ("symmetric", "semidefinite", "friction", "P")


class TestGallery:
    @pytest.mark.parametrize("name", FAMILIES)
    def test_what_is_said_of_an_example_is_true(self, name, faults, measure):
        for example in family(name, seed=1):
            lcp = example.lcp
            assert example.kind in ("symmetric", "semidefinite", "friction", "P", "general")
            assert example.unique in ("", "motion", "z")
            if example.kind == "symmetric":
                assert lcp.symmetric
            if example.kind in ("symmetric", "semidefinite"):
                eigenvalues = np.linalg.eigvalsh(lcp.M + lcp.M.T)
                assert eigenvalues.min(initial=0.0) >= -1e-12 * np.abs(eigenvalues).max(initial=1.0)
            if example.kind == "P" and lcp.size <= 8:
                sets = itertools.chain.from_iterable(
                    itertools.combinations(range(lcp.size), k) for k in range(1, lcp.size + 1)
                )
                assert all(np.linalg.slogdet(lcp.M[np.ix_(s, s)])[0] > 0 for s in sets)
            if example.z is not None:
                assert example.solvable
                assert (example.z >= 0.0).all()
                assert measure(lcp, example.z) <= 1e-13
            if example.outcome is Status.INFEASIBLE:
                u = example.certificate
                assert (u >= 0.0).all()
                assert lcp.q @ u < 0.0
                assert np.maximum(lcp.M.T @ u, 0.0) == pytest.approx(0.0, abs=1e-13 * np.abs(lcp.M).max(initial=1.0))

    def test_the_same_seed_gives_the_same_bits(self):
        first, second, other = (list(examples(seed, (3,))) for seed in (5, 5, 6))
        assert [e.name for e in first] == [e.name for e in second]
        assert all(a.lcp.M.tobytes() == b.lcp.M.tobytes() for a, b in zip(first, second, strict=True))
        assert any(a.lcp.M.tobytes() != b.lcp.M.tobytes() for a, b in zip(first, other, strict=True))

    def test_refuses_what_it_does_not_have(self):
        with pytest.raises(ModelError, match=r"expected one of .*murty"):
            next(family("mury"))
        with pytest.raises(ModelError, match="sizes holds 0"):
            next(family("murty", 0, (0,)))

    def test_coefficients_differ_between_contacts(self):
        differ = [len(set(e.problem.friction)) > 2 for e in examples(0, (8,)) if isinstance(e.problem, ContactProblem)]
        assert sum(differ) >= 10


@pytest.mark.parametrize("seed", [11, pytest.param(12, marks=pytest.mark.slow)])
def test_no_solver_gives_a_wrong_answer(any_solver, all_solvers, faults, seed):
    name = next(key for key, solver in all_solvers.items() if solver is any_solver)
    asked = 0
    for example in examples(seed, (2, 6, 11)):
        if takes(name, any_solver, example):
            asked += 1
            assert not faults(example, any_solver.solve(example.problem)), example.name
    assert asked >= 20


@pytest.mark.slow
def test_exhaustive_search_confirms_how_many_solutions_there_are(all_solvers):
    confirmed = collections.Counter()
    for example in examples(31, (1, 2, 4)):
        if takes("Enumeration", all_solvers["Enumeration"], example):
            status = all_solvers["Enumeration"].solve(example.problem).status
            if example.unique == "z":
                assert status is Status.SOLVED, example.name
            elif example.outcome in (Status.NOT_UNIQUE, Status.NO_SOLUTION):
                assert status is example.outcome, example.name
            elif example.outcome is Status.INFEASIBLE:
                assert status in (Status.INFEASIBLE, Status.NO_SOLUTION), example.name
            confirmed[example.outcome] += 1
    assert set(confirmed) >= {Status.SOLVED, Status.NOT_UNIQUE, Status.NO_SOLUTION, Status.INFEASIBLE}


@pytest.mark.parametrize("seed", [21, 22, 23])
def test_the_default_solver_misses_nothing_that_is_promised(seed, faults):
    missed = []
    for example in examples(seed, (1, 4, 9, 17)):
        solution = Auto().solve(example.problem)
        assert not faults(example, solution), example.name
        if promised(example) and not solution.solved:
            missed.append((example.name, solution.message))
        if example.outcome is Status.INFEASIBLE and example.kind == "symmetric":
            assert solution.status is Status.INFEASIBLE, example.name
            lcp, u = example.lcp, solution.certificate
            assert (lcp.M.T @ u <= 1e-9 * (np.abs(lcp.M).T @ u).max()).all(), example.name
            assert lcp.q @ u <= -1e-9 * (np.abs(lcp.q) @ u), example.name
    assert not missed


@pytest.mark.slow
def test_thousands_of_problems(all_solvers, faults):
    """Fresh seeds and sizes up to 60: prints how many examples of each family each solver solved."""
    auto = next(name for name, solver in all_solvers.items() if type(solver).__name__ == "Auto")
    solved = collections.defaultdict(collections.Counter)
    asked = collections.defaultdict(collections.Counter)
    wrong, missed, problems = [], [], 0
    for seed, kind in itertools.product((101, 202, 303, 404, 505), FAMILIES):
        for example in family(kind, seed, (1, 2, 3, 5, 7, 10, 14, 24, 40, 60)):
            problems += 1
            for name, solver in all_solvers.items():
                if not takes(name, solver, example):
                    continue
                solution = solver.solve(example.problem)
                asked[kind][name] += 1
                ended_well = solution.solved or solution.status in (Status.INFEASIBLE, Status.NO_SOLUTION)
                solved[kind][name] += ended_well
                wrong += [(name, example.name, fault) for fault in faults(example, solution)]
                proof_due = example.outcome is Status.INFEASIBLE and example.kind == "symmetric"
                if name == auto and not ended_well and (promised(example) or proof_due):
                    missed.append((example.name, solution.message))
    _print_table(list(all_solvers), solved, asked)
    print(f"{problems} problems, {len(wrong)} wrong, {len(missed)} missed by {auto}")
    assert problems >= 5000
    assert not wrong
    assert not missed


def _print_table(names, solved, asked):
    """Solved (or proved unsolvable) of asked, a family a row."""
    print("\n" + " " * 18 + " ".join(f"{name[:13]:>13}" for name in names))
    for kind in solved:
        cells = (f"{solved[kind][name]}/{asked[kind][name]}" if asked[kind][name] else "-" for name in names)
        print(f"{kind:18}" + " ".join(f"{cell:>13}" for cell in cells))
