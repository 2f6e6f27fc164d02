"""What every solver owes: right answers, honest failures, reasons for what it refuses, the same bits every time.

The solvers are found by conftest.py; a new one is under contract by standing in the room.
"""

import dataclasses
from dataclasses import replace

import numpy as np
import pytest

import lcpflex.solvers
from lcpflex.errors import ModelError
from lcpflex.solvers import ContactProblem, Lcp, Lemke, QuadraticProgram, Status

TOLERANCE = 1e-10
DEFINITE = Lcp([[2.0, 1.0], [1.0, 2.0]], [-5.0, -6.0])
SQUEEZE = Lcp([[1.0, -1.0], [-1.0, 1.0]], [-1.0, -1.0])


def box_on_floor(contacts: int, friction: float, velocity: tuple[float, float, float]) -> ContactProblem:
    """A box of 1 kg, 1 m x 0.5 m, touching a floor at points along its lower side; velocity (vx, vy, omega)."""
    x = np.linspace(-0.5, 0.5, contacts)
    ones = np.ones(contacts)
    normal = np.column_stack([0 * x, ones, x])
    tangent = np.column_stack([ones, 0 * x, 0.25 * ones])
    rows = np.vstack([normal, tangent]) if friction else normal
    inverse_mass = np.array([1.0, 1.0, 12.0 / 1.25])
    return ContactProblem((rows * inverse_mass) @ rows.T, rows @ np.array(velocity), friction * ones)


def fathi(n: int) -> np.ndarray:
    lower = np.eye(n) + 2.0 * np.tril(np.ones((n, n)), -1)
    return lower @ lower.T


def contact_velocity(problem, z):
    """What is unique where contacts are redundant: how they move."""
    return problem.slack(z) if isinstance(problem, Lcp) else problem.velocity(np.concatenate(problem.forces(z)))


def test_every_solver_has_a_public_name_and_every_public_one_is_found(all_solvers):
    found = {type(solver).__name__ for solver in all_solvers.values()}
    public = {name: getattr(lcpflex.solvers, name) for name in lcpflex.solvers.__all__}
    assert found == {name for name, value in public.items() if hasattr(value, "solve") and hasattr(value, "refuses")}


class TestAnswers:
    def test_empty_problem(self, any_solver, attempt):
        for problem in (Lcp(np.zeros((0, 0)), []), ContactProblem(np.zeros((0, 0)), [], [])):
            solution = attempt(any_solver, problem)
            assert solution is None or (solution.solved and solution.z.shape == solution.w.shape == (0,))

    def test_nothing_to_do(self, any_solver, attempt):
        solution = attempt(any_solver, Lcp([[1.0, 0.0], [0.0, 1.0]], [0.0, 2.0]))
        assert solution is None or (solution.solved and (solution.z == 0.0).all())

    @pytest.mark.parametrize(
        ("q", "z", "w"),
        [
            ([-5.0, -6.0], [4 / 3, 7 / 3], [0.0, 0.0]),
            ([-4.0, -1.0], [2.0, 0.0], [0.0, 1.0]),  # 2 z1 = 4, w2 = 2 - 1
            ([-1.0, -4.0], [0.0, 2.0], [1.0, 0.0]),
            ([-4.0, -2.0], [2.0, 0.0], [0.0, 0.0]),  # z2 = 0 and w2 = 0: degenerate
            ([0.0, 0.0], [0.0, 0.0], [0.0, 0.0]),
        ],
    )
    def test_two_contacts(self, any_solver, attempt, q, z, w):
        solution = attempt(any_solver, Lcp(DEFINITE.M, q))
        if solution is not None:
            assert solution.solved
            assert solution.z == pytest.approx(z, abs=1e-8)
            assert solution.w == pytest.approx(w, abs=1e-8)

    def test_definite_and_not_symmetric(self, any_solver, attempt, guaranteed):
        solution = attempt(any_solver, Lcp([[1.0, -3.0], [3.0, 1.0]], [1.0, -4.0]))  # z = (0, 4) has w1 < 0
        if solution is not None and (solution.solved or guaranteed(any_solver)):
            assert solution.z == pytest.approx([1.1, 0.7], abs=1e-8)

    @pytest.mark.parametrize("contacts", [2, 3, 5, 8])
    def test_redundant_contacts_carry_the_right_sum(self, any_solver, attempt, guaranteed, contacts):
        # The box falls with 0.1 m/s and stops: the impulses add up to m v and have no moment, however they are shared.
        solution = attempt(any_solver, box_on_floor(contacts, 0.0, (0.3, -0.1, 0.0)).lcp())
        if solution is not None and (solution.solved or guaranteed(any_solver)):
            assert solution.solved
            assert solution.z.sum() == pytest.approx(0.1, rel=1e-8)
            assert solution.z @ np.linspace(-0.5, 0.5, contacts) == pytest.approx(0.0, abs=1e-8)

    @pytest.mark.parametrize("ratio", [1e-6, 1.0, 1e6])
    def test_heavy_on_light(self, any_solver, attempt, guaranteed, ratio):
        # Two masses in a column, both moving down with 1 m/s: floor impulse m1 + m2, upper contact m2.
        solution = attempt(any_solver, Lcp([[1.0, -1.0], [-1.0, 1.0 + 1.0 / ratio]], [-1.0, 0.0]))
        if solution is not None and guaranteed(any_solver):
            assert solution.solved
            assert solution.z == pytest.approx([1.0 + ratio, ratio], rel=1e-8)

    def test_fathi(self, any_solver, attempt, guaranteed):
        solution = attempt(any_solver, Lcp(fathi(10), -np.ones(10)))
        if solution is not None and (solution.solved or guaranteed(any_solver)):
            assert solution.z == pytest.approx([1.0] + [0.0] * 9, abs=1e-6)

    @pytest.mark.parametrize(
        ("mu", "slide", "tangential"),
        [
            (0.5, 0.2, -0.2),  # sticks: the impulse that stops it, 0.2 < 0.5
            (0.5, -0.2, 0.2),
            (0.5, 3.0, -0.5),  # slides to the right: the full friction against it
            (0.5, -3.0, 0.5),
            (2.0, 3.0, -2.0),
        ],
    )
    def test_block_that_hits_the_floor(self, any_solver, attempt, guaranteed, mu, slide, tangential):
        # A mass point of 1 kg arrives with (slide, -1) m/s: normal impulse 1.
        problem = ContactProblem(np.eye(2), [-1.0, slide], [mu])
        solution = attempt(any_solver, problem)
        if solution is None or getattr(any_solver, "model", ""):
            return
        assert solution.solved or not guaranteed(any_solver)
        if solution.solved:
            normal, tangent = problem.forces(solution.z)
            assert normal == pytest.approx([1.0], rel=1e-8)
            assert tangent == pytest.approx([tangential], rel=1e-8)

    @pytest.mark.parametrize("contacts", [2, 3, 5])
    @pytest.mark.parametrize("mu", [0.1, 0.5, 2.0])
    @pytest.mark.parametrize("velocity", [(1.0, -0.1, 0.0), (0.0, -0.1, 0.0), (0.01, -0.1, 0.3), (-0.2, -1.0, -2.0)])
    def test_coulombs_law_holds_at_every_point(self, any_solver, attempt, guaranteed, contacts, mu, velocity):
        problem = box_on_floor(contacts, mu, velocity)
        solution = attempt(any_solver, problem)
        if solution is None or getattr(any_solver, "model", ""):
            return
        assert solution.solved or not guaranteed(any_solver)
        if not solution.solved:
            return
        normal, tangent = problem.forces(solution.z)
        after = problem.velocity(np.concatenate([normal, tangent]))
        gap_rate, slip = after[:contacts], after[contacts:]
        assert (normal >= -1e-9).all()
        assert (gap_rate >= -1e-8).all()
        assert np.abs(normal * gap_rate).max() <= 1e-8
        assert (np.abs(tangent) <= mu * normal * (1 + 1e-8) + 1e-9).all()
        sliding = np.abs(slip) > 1e-7
        assert tangent[sliding] == pytest.approx(-mu * np.sign(slip[sliding]) * normal[sliding], abs=1e-8)
        # Friction and contact only take energy: work of the impulse with the mean velocity.
        assert np.concatenate([normal, tangent]) @ (0.5 * (after + problem.free)) <= 1e-9


class TestHonesty:
    def test_a_squeeze_is_never_solved(self, any_solver, attempt, guaranteed):
        solution = attempt(any_solver, SQUEEZE)
        if solution is None:
            return
        assert not solution.solved
        assert solution.status is Status.INFEASIBLE or not guaranteed(any_solver)
        if solution.status is Status.INFEASIBLE:
            u = solution.certificate
            assert (u >= 0).all()
            assert SQUEEZE.q @ u < 0
            assert SQUEEZE.M.T @ u == pytest.approx([0.0, 0.0], abs=1e-9 * u.max())

    @pytest.mark.parametrize("mu", [0.0, 0.3])
    def test_a_body_between_closing_jaws(self, any_solver, attempt, mu):
        rows = np.array([[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, 1.0]])[: 4 if mu else 2]
        problem = ContactProblem(rows @ rows.T, [-1.0, -1.0, 0.2, 0.2][: len(rows)], [mu, mu])
        solution = attempt(any_solver, problem)
        assert solution is None or not solution.solved

    @pytest.mark.parametrize(
        ("M", "q"),
        [
            (np.zeros((2, 2)), [-1.0, 1.0]),
            ([[-1.0]], [-1.0]),  # w = -z - 1 < 0 for every z
            ([[-1.0, 2.0], [1.0, 1.0]], [-1.0, 1.0]),  # feasible, but w2 > 0 makes z2 = 0, and then w1 < 0
            ([[0.0, 1.0], [0.0, 0.0]], [-1.0, 1.0]),
        ],
    )
    def test_no_solution(self, any_solver, attempt, M, q):
        solution = attempt(any_solver, Lcp(M, q))
        assert solution is None or not solution.solved

    @pytest.mark.parametrize("q", [[-1e300, -1e300], [-1e-300, 1e-300], [-1e300, 1e-300]])
    @pytest.mark.parametrize("size", [1e-200, 1.0, 1e200, 1e308])
    def test_numbers_that_overflow_raise_nothing_and_pass_for_nothing(self, any_solver, attempt, size, q):
        attempt(any_solver, Lcp([[size, 0.5 * size], [0.5 * size, size]], q))

    def test_an_indefinite_matrix_is_never_solved_wrongly(self, any_solver, attempt):
        for q in ([-1.0, -1.1], [1.0, 1.1], [-1.0, 1.0]):
            attempt(any_solver, Lcp([[1.0, 2.0], [2.0, 1.0]], q))

    def test_a_refused_problem_has_a_reason_that_tells_what_to_do(self, any_solver):
        for problem in (DEFINITE, Lcp([[1.0, 2.0], [0.0, 1.0]], [0.0, 0.0]), box_on_floor(2, 0.3, (0.0, -1.0, 0.0))):
            reason = any_solver.refuses(problem)
            assert isinstance(reason, str)
            assert not reason or len(reason) > 30


class TestConduct:
    problems = (
        Lcp(fathi(6), -np.ones(6)),
        box_on_floor(4, 0.0, (0.0, -1.0, 0.7)).lcp(),
        box_on_floor(3, 0.4, (1.0, -0.1, 0.2)),
    )

    def test_same_bits_for_the_same_input(self, any_solver, attempt):
        for problem in self.problems:
            first, second = attempt(any_solver, problem), attempt(any_solver, problem)
            if first is not None:
                assert first.z.tobytes() == second.z.tobytes()
                assert first.w.tobytes() == second.w.tobytes()
                assert (first.status, first.iterations, first.route) == (second.status, second.iterations, second.route)

    def test_the_problem_is_left_as_it_was(self, any_solver, attempt):
        for problem in self.problems:
            arrays = problem.data if isinstance(problem, Lcp) else (problem.delassus, problem.free, problem.friction)
            before = [a.tobytes() for a in arrays]
            attempt(any_solver, problem)
            assert [a.tobytes() for a in arrays] == before

    def test_kernels_give_the_same_bits_as_plain_python(self, any_solver, attempt, as_plain_python):
        problems = [DEFINITE, *self.problems]
        compiled = [attempt(any_solver, problem) for problem in problems]
        assert as_plain_python(any_solver)
        for problem, expected in zip(problems, compiled, strict=True):
            with np.errstate(all="ignore"):
                again = attempt(any_solver, problem)
            assert (expected is None) == (again is None)
            if expected is not None:
                assert again.z.tobytes() == expected.z.tobytes()
                assert (again.status, again.iterations) == (expected.status, expected.iterations)

    @pytest.mark.parametrize("wrong", ["size", "nan", "inf", "huge", "basis", "negative"])
    def test_a_wrong_guess_does_no_harm(self, any_solver, attempt, wrong):
        for problem in self.problems:
            cold = attempt(any_solver, problem)
            if cold is None:
                continue
            n = problem.size
            base = replace(cold, active=np.ones(n, dtype=np.int64))
            guess = {
                "size": Lemke().solve(DEFINITE),
                "nan": replace(base, z=np.full(n, np.nan)),
                "inf": replace(base, z=np.full(n, np.inf)),
                "huge": replace(base, z=np.full(n, 1e200)),
                "basis": replace(base, active=np.array([7, -3] * n, dtype=np.int64)[:n]),
                "negative": replace(base, z=-1.0 - cold.z, active=None),
            }[wrong]
            warm = attempt(any_solver, problem, guess)
            assert warm.solved or not cold.solved
            if warm.solved and not getattr(any_solver, "model", ""):
                motions = [contact_velocity(problem, solution.z) for solution in (warm, cold)]
                assert motions[0] == pytest.approx(motions[1], abs=1e-6)

    def test_a_solution_is_a_good_guess(self, any_solver, attempt):
        for problem in self.problems:
            cold = attempt(any_solver, problem)
            if cold is not None and cold.solved:
                assert attempt(any_solver, problem, cold).solved

    def test_settings_must_make_sense(self, any_solver):
        names = [f.name for f in dataclasses.fields(any_solver)]
        changes = [("tolerance", v) for v in (0.0, -1.0, np.nan, 1.0, "small") if "tolerance" in names]
        times = [name for name in names if name in ("seconds", "time_limit")]
        changes += [(name, value) for name in times for value in (0, -5, np.inf, True, "1")]
        counts = [name for name in names if name.endswith("limit") and name not in times]
        changes += [(name, value) for name in counts for value in (0, -5, 1.5, True)]
        assert changes
        for name, value in changes:
            with pytest.raises(ModelError, match=name):
                replace(any_solver, **{name: value})

    def test_settings_cannot_be_changed_afterwards(self, any_solver):
        name = dataclasses.fields(any_solver)[0].name
        with pytest.raises(dataclasses.FrozenInstanceError):
            setattr(any_solver, name, getattr(any_solver, name))
        assert replace(any_solver) == any_solver
        assert hash(replace(any_solver)) == hash(any_solver)


class TestQuadraticProgram:
    def test_refuses_friction_and_says_what_to_use(self):
        with pytest.raises(ModelError, match=r"not symmetric.*Lemke"):
            QuadraticProgram().solve(box_on_floor(2, 0.3, (1.0, -0.1, 0.0)).lcp())

    def test_unknown_backend_names_the_installed_ones(self):
        with pytest.raises(ModelError, match=r"'clarabelle'.*clarabel, .*osqp"):
            QuadraticProgram("clarabelle")
