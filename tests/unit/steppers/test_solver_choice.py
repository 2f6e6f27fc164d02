"""What the choice of a solver means to a run: the same motion, and a second chance where the compiled part gives up."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.dynamics.workspace import NO_LIMIT, Workspace
from lcpflex.gallery import scenes
from lcpflex.solvers import AlartCurnier, ConicFixedPoint, ContactProblem, ConvexFriction, FacetedCone, Lcp
from lcpflex.solvers.contact.compiled import AUTO, solve_contacts
from lcpflex.solvers.contact.index_sets import SLIDE_BACK, SLIDE_FORTH, SMOOTH, STICKING
from lcpflex.solvers.contact.memory import SOLUTION_KNOWN
from lcpflex.solvers.contact.posed import own_pull, posed_lcp, posed_problem
from lcpflex.solvers.contact.recollection import recall_basis, remember_basis, turn_over
from lcpflex.steppers.driver import MOST_RESCUES, Rescue
from lcpflex.steppers.status import RunStatus

# Every path of Lemke ends on a ray, although z = (0, 0, 1/2) is a solution.
HARD = Lcp([[3.0, 1.0, 2.0], [0.0, 0.0, 2.0], [1.0, 2.0, 0.0]], [-1.0, -1.0, 0.0])


def stack_memory(steps: int = 5) -> tuple[Workspace, Any]:
    """Work memory of a stack of boxes with redundant frictional contacts, after some steps."""
    case = scenes()["stack"]
    run: Any = case.stepper.start(case.build().compiled().system(), 1.0, 1.0)
    run.method.stepping.work.impulses.dense_limit = NO_LIMIT  # as one dense problem
    assert run.advance(steps) == ""
    return run.method.stepping.work, run


@pytest.mark.parametrize("name", ["stack", "pendulum"])
def test_auto_and_lemke_give_the_same_motion(name: str) -> None:
    case = scenes()[name]
    runs = [
        lf.simulate(case.build(), 0.2 * case.duration, replace(case.stepper, solver=solver))
        for solver in (lf.Auto(), lf.Lemke())
    ]
    assert runs[0].q == pytest.approx(runs[1].q, abs=1e-9)
    assert runs[0].residual.max() <= 1e-10


def test_the_last_basis_solves_the_next_problem_at_once() -> None:
    work, _ = stack_memory()
    data, memory = work.posed.problem, work.impulses.solver
    assert memory.method == AUTO
    assert work.impulses.remembered.n == data.n_contacts > 10
    recall_basis(data, memory, work.impulses.remembered)
    assert solve_contacts(data, memory) == 0
    assert memory.iterations == 1  # one linear solve
    assert solve_contacts(data, memory) == 0  # what is known counts once: this one starts cold
    assert memory.iterations > memory.size / 3


def test_a_basis_follows_its_contact_to_another_place() -> None:
    work, _ = stack_memory()
    data, memory = work.posed.problem, work.impulses.solver
    n, n_tangent = data.n_contacts, data.n_tangents
    keys = data.key[:n].copy()
    basis = np.arange(n + 2 * n_tangent) % 2
    memory.basis[: len(basis)] = basis
    remember_basis(data, memory, work.impulses.remembered)
    turn_over(work.impulses.remembered)
    data.key[: n - 1] = keys[1:]  # the first contact has opened, a new one stands last
    data.key[n - 1] = keys.max() + 1
    recall_basis(data, memory, work.impulses.remembered)
    for part in range(3):
        first = part * n  # all contacts of the stack have friction
        assert (memory.basis[first : first + n - 1] == basis[first + 1 : first + n]).all()
        assert memory.basis[first + n - 1] == 0


def pose_hard(work: Workspace) -> None:
    """HARD as a contact problem: three contacts of which the last one slides."""
    data = work.posed.problem
    data.n_contacts, data.n_tangents, data.on_sets = 3, 1, 1
    data.tangent[0], data.mode[:3] = 2, (SMOOTH, SMOOTH, SLIDE_FORTH)
    data.delassus[:4, :4] = 0.0
    data.delassus[:3, :3], data.free[:3] = HARD.M, HARD.q


def test_a_problem_that_the_compiled_part_cannot_solve_goes_down_the_chain() -> None:
    work, _ = stack_memory()
    data, memory = work.posed.problem, work.impulses.solver
    pose_hard(work)
    assert solve_contacts(data, memory) != 0
    assert Rescue(lf.Auto(), 1e-9)(work, 0.0)
    assert memory.known == SOLUTION_KNOWN
    assert solve_contacts(data, memory) == 0
    assert memory.normal[:3] == pytest.approx([0.0, 0.0, 0.5], abs=1e-12)
    memory.z[:3] = 0.0  # no answer
    assert not Rescue(lf.Lemke(), 1e-9)(work, 0.0)  # who asks for Lemke gets Lemke


def test_rescues_at_one_instant_end() -> None:
    work, _ = stack_memory()
    rescue = Rescue(lf.Auto(), 1e-9)
    made = [rescue(work, 0.5) for _ in range(MOST_RESCUES + 2)]
    assert made == [True] * (MOST_RESCUES + 1) + [False]
    assert rescue(work, 0.6)


def test_a_rescued_step_is_repeated_and_the_run_goes_on() -> None:
    case = scenes()["stack"]
    _, plain = stack_memory(20)
    run: Any = case.stepper.start(case.build().compiled().system(), 1.0, 1.0)
    assert run.advance(3) == ""
    compiled, failures = run.method._advance, []

    def fails_once(*arguments: Any) -> int:
        if not failures:
            compiled(*arguments[:-1], run.steps + 2)
            failures.append(run.steps)
            return RunStatus.SOLVER_FAILED
        return int(compiled(*arguments))

    run.method._advance = fails_once
    assert run.advance(17) == ""
    assert failures == [5]
    assert run.steps == plain.steps == 20
    assert run.method.stepping.scheme.q == pytest.approx(plain.method.stepping.scheme.q, abs=1e-12)


def test_the_posed_problem_is_the_one_in_memory() -> None:
    work, _ = stack_memory()
    data, memory = work.posed.problem, work.impulses.solver
    problem = posed_problem(data, memory)
    m = memory.size
    assert isinstance(problem, ContactProblem)
    assert problem.friction == pytest.approx(np.full(data.n_contacts, 0.5), abs=0.0)
    assert np.array_equal(problem.delassus, data.delassus[: len(problem.free), : len(problem.free)])
    assert np.array_equal(problem.lcp().M, memory.M[:m, :m])
    assert np.array_equal(problem.lcp().q, memory.q[:m])


@pytest.mark.parametrize(("mode", "sign"), [(SLIDE_FORTH, 1.0), (SLIDE_BACK, -1.0)])
def test_a_problem_on_index_sets_has_the_friction_of_sliding_contacts_in_its_matrix(mode: int, sign: float) -> None:
    work, _ = stack_memory()
    data, memory = work.posed.problem, work.impulses.solver
    G = np.array([[4.0, 0.3, 0.5, 0.1], [0.3, 3.0, 0.2, 0.4], [0.5, 0.2, 6.0, 0.6], [0.1, 0.4, 0.6, 5.0]])
    data.n_contacts, data.n_tangents, data.on_sets = 2, 2, 1  # contact 0 slides, contact 1 may stick
    data.tangent[:2], data.mode[:2], data.friction[:2] = (0, 1), (mode, STICKING), (0.4, 0.7)
    data.delassus[:4, :4], data.free[:4] = G, [1.0, 2.0, -1.0, 3.0]
    problem = posed_problem(data, memory)
    A = G[np.ix_([0, 1, 3], [0, 1, 3])].copy()
    A[:, 0] -= sign * 0.4 * G[[0, 1, 3], 2]
    assert isinstance(problem, ContactProblem)
    assert problem.delassus == pytest.approx(A, abs=1e-15)
    assert problem.friction == pytest.approx([0.0, 0.7], abs=0.0)
    assert problem.free == pytest.approx([1.0, 2.0, 3.0], abs=0.0)
    assert own_pull(data) == pytest.approx(np.diag(posed_lcp(data, memory).M)[:2], rel=1e-15)
    data.mode[0] = STICKING
    assert np.array_equal(posed_problem(data, memory).delassus, G)


@pytest.mark.parametrize("friction", [0.0, 0.4])
def test_least_normal_forces_shift_the_problem(friction: float) -> None:
    """Contact 0 would carry less than it must: it carries that, opens, and contact 1 answers."""
    work, _ = stack_memory()
    data, memory = work.posed.problem, work.impulses.solver
    n_tangent = 2 if friction else 0
    G = np.array([[2.0, -0.5, 0.1, 0.0], [-0.5, 2.0, 0.0, 0.1], [0.1, 0.0, 3.0, 0.0], [0.0, 0.1, 0.0, 3.0]])
    data.n_contacts, data.n_tangents, data.on_sets, data.shifted = 2, n_tangent, 0, 1
    data.tangent[:2], data.friction[:2], data.least[:2] = (0, 1), friction, (1.5, 0.0)
    data.delassus[:4, :4], data.free[:4] = G, [-1.0, -1.0, 0.2, -0.3]
    assert isinstance(posed_problem(data, memory), Lcp if friction else ContactProblem)
    assert solve_contacts(data, memory) == 0
    normal, tangential = memory.normal[:2].copy(), memory.tangential[:n_tangent].copy()
    v = G[: 2 + n_tangent, : 2 + n_tangent] @ [*normal, *tangential] + data.free[: 2 + n_tangent]
    assert normal[0] == 1.5
    assert v[0] > 0.0
    assert normal[1] > 0.0
    assert abs(v[1]) < 1e-14
    assert (np.abs(tangential) <= friction * normal[:n_tangent] + 1e-15).all()
    assert (v[2:] * tangential <= 1e-15).all()


def test_contacts_with_one_key_come_as_an_lcp() -> None:
    work, _ = stack_memory()
    work.posed.problem.key[1] = work.posed.problem.key[0]
    assert isinstance(posed_problem(work.posed.problem, work.impulses.solver), Lcp)


class TestRecordProblems:
    @pytest.mark.parametrize(
        ("change", "said"),
        [
            ({"every": 0}, "every: 0"),
            ({"hardest": -1}, "hardest: -1"),
            ({"every": 1, "hardest": 1}, "one of the two"),
            ({"by": "luck"}, "'luck'.*residual, iterations, condition"),
            ({"limit": True}, "limit: True"),
            ({"path": 3}, "path: 3"),
            ({"path": "/no/such/folder/x.npz"}, "no/such"),
        ],
    )
    def test_refuses_what_cannot_be(self, tmp_path: Any, change: dict[str, Any], said: str) -> None:
        with pytest.raises(lf.ModelError, match=said):
            lf.RecordProblems(**{"path": tmp_path / "x.npz", **change})

    def test_each_third_problem(self, tmp_path: Any) -> None:
        from lcpflex.solvers.benchmark.files import load_problems

        case = scenes()["stack"]
        path = tmp_path / "stack.npz"
        recorded = lf.simulate(case.build(), 0.02, case.stepper, record_problems=lf.RecordProblems(path, every=3))
        plain = lf.simulate(case.build(), 0.02, case.stepper)
        assert recorded.q == pytest.approx(plain.q, abs=1e-13)
        problems = load_problems(path)
        assert len(problems) == 7  # of 20
        assert problems[1].name.startswith("problem 3: ")
        assert (problems[0].problem.friction > 0.0).all()
        assert all("#" in key for key in problems[0].problem.keys)

    @pytest.mark.parametrize("by", ["residual", "iterations", "condition"])
    def test_the_hardest(self, tmp_path: Any, by: str) -> None:
        from lcpflex.solvers.benchmark.files import load_problems

        case = scenes()["stack"]
        path = tmp_path / "hard.npz"
        request = lf.RecordProblems(path, hardest=4, by=by)
        lf.simulate(case.build(), 0.02, case.stepper, record_problems=request)
        assert len(load_problems(path)) == 4

    def test_more_than_the_limit_are_thinned_out(self, tmp_path: Any) -> None:
        from lcpflex.solvers.benchmark.files import load_problems

        case = scenes()["stack"]
        path = tmp_path / "thin.npz"
        request = lf.RecordProblems(path, every=1, limit=6)
        lf.simulate(case.build(), 0.02, case.stepper, record_problems=request)
        numbers = [int(one.name.split(":")[0].split()[1]) for one in load_problems(path)]
        assert numbers == [0, 4, 8, 12, 16]

    def test_event_driven_runs_record_too(self, tmp_path: Any) -> None:
        from lcpflex.solvers.benchmark.files import load_problems

        case = scenes()["stack"]
        path = tmp_path / "events.npz"
        lf.simulate(case.build(), 0.02, lf.EventDriven(), record_problems=lf.RecordProblems(path))
        assert load_problems(path)


def test_a_solver_of_another_model_is_refused() -> None:
    case = scenes()["stack"]
    with pytest.raises(lf.ModelError, match="solves another model"):
        lf.simulate(case.build(), 0.1, replace(case.stepper, solver=ConvexFriction()))


def test_a_solver_of_contact_in_space_is_refused_in_the_plane() -> None:
    case = scenes()["stack"]
    alone = "takes contact in space alone"
    for solver, words in ((ConicFixedPoint(), alone), (AlartCurnier(), alone), (FacetedCone(), "another model")):
        with pytest.raises(lf.ModelError, match=words):
            lf.simulate(case.build(), 0.1, replace(case.stepper, solver=solver))
