"""Gauss-Seidel by contacts: local laws in closed form, both forms of the data, warm starts, memory."""

import tracemalloc
from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse

from lcpflex.errors import ModelError
from lcpflex.solvers import BlockGaussSeidel, ContactProblem, Lcp, Lemke, Status
from lcpflex.solvers.contact import system as system_of_contacts
from lcpflex.solvers.contact.laws.interval import solve_contact
from lcpflex.solvers.contact.laws.states import BACK, FORTH, OPEN, STICKING
from lcpflex.solvers.contact.system import ContactSystem, sweep_and_renew
from tests.unit.solvers.test_row_gauss_seidel import definite


def row_of_blocks(n: int, seed: int = 0) -> tuple[ContactProblem, np.ndarray, np.ndarray]:
    """n blocks of 1 to 3 kg between rough walls of each other, sparse; its forces (normal, tangential) chosen first.

    Contact k holds bodies k - 1 and k together, the first one body 0 and the world; J has four entries a row at most.
    """
    rng = np.random.default_rng(seed)
    body = np.arange(n)
    root = rng.uniform(1.0, 3.0, n) ** -0.5
    angle = rng.uniform(-0.3, 0.3, n)
    rows, columns, values = [], [], []
    for first, (c, s) in ((0, (np.cos(angle), np.sin(angle))), (n, (-np.sin(angle), np.cos(angle)))):
        for coordinate, part in ((0, c), (1, s)):
            rows += [first + body, first + body[1:]]
            columns += [2 * body + coordinate, 2 * body[:-1] + coordinate]
            values += [part * root, -part[1:] * root[:-1]]
    entries = np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))
    J = scipy.sparse.csr_array(entries, shape=(2 * n, 2 * n))
    friction = rng.uniform(0.2, 0.8, n)
    kind = np.arange(n) % 4
    normal = np.where(kind != OPEN, rng.uniform(0.5, 1.5, n), 0.0)
    share = np.select([kind == STICKING, kind == FORTH, kind == BACK], [rng.uniform(-0.8, 0.8, n), -1.0, 1.0], 0.0)
    tangential = share * friction * normal
    slip = np.select([kind == FORTH, kind == BACK, kind == OPEN], [1.0, -1.0, 0.5], 0.0)
    velocity = np.concatenate([np.where(kind == OPEN, 1.0, 0.0), slip])
    free = velocity - J @ (J.T @ np.concatenate([normal, tangential]))
    return ContactProblem(None, free, friction, factor=J), normal, tangential


class TestOneContact:
    """v_N = a p + b t + r_N, v_T = c p + d t + r_T, with the answers on paper."""

    @pytest.mark.parametrize(
        ("arguments", "p", "t", "state"),
        [
            ((1.0, 0.0, 0.0, 1.0, 2.0, 5.0, 0.5), 0.0, 0.0, OPEN),
            ((1.0, 0.0, 0.0, 1.0, 0.0, -5.0, 0.5), 0.0, 0.0, OPEN),  # grazing
            ((1.0, 0.0, 0.0, 1.0, -2.0, 0.5, 0.5), 2.0, -0.5, STICKING),
            ((1.0, 0.0, 0.0, 1.0, -2.0, 1.0, 0.5), 2.0, -1.0, STICKING),  # on the edge of the cone
            ((1.0, 0.0, 0.0, 1.0, -2.0, 3.0, 0.5), 2.0, -1.0, FORTH),
            ((1.0, 0.0, 0.0, 1.0, -2.0, -3.0, 0.5), 2.0, 1.0, BACK),
            ((2.0, 0.0, 0.0, 8.0, -4.0, 2.0, 0.5), 2.0, -0.25, STICKING),  # t = -r_T / d
            ((2.0, 1.0, 1.0, 3.0, -5.0, -5.0, 10.0), 2.0, 1.0, STICKING),  # the solution of [2 1; 1 3] x = (5, 5)
            ((2.0, 1.0, 1.0, 3.0, -5.0, 20.0, 0.5), 10 / 3, -5 / 3, FORTH),  # p = 5 / (2 - 1 / 2)
            ((2.0, 1.0, 1.0, 3.0, -5.0, -20.0, 0.5), 2.0, 1.0, BACK),  # p = 5 / (2 + 1 / 2)
            ((2.0, 1.0, 1.0, 3.0, -5.0, 20.0, 0.0), 2.5, 0.0, FORTH),
        ],
    )
    def test_by_hand(self, arguments, p, t, state):
        found = solve_contact(*arguments)
        assert found[:2] == pytest.approx((p, t), rel=1e-14, abs=1e-15)
        assert found[2] == state

    @pytest.mark.parametrize("mu", [0.1, 0.5, 1.0])
    def test_coulombs_law(self, mu):
        rng = np.random.default_rng(3)
        seen = set()
        for _ in range(300):
            a, d = rng.uniform(0.5, 2.0, 2)
            b = rng.uniform(-0.4, 0.4) * min(a, d)  # a - mu |b| > 0: one solution
            r_n, r_t = rng.uniform(-2.0, 1.0), rng.uniform(-3.0, 3.0)
            p, t, state = solve_contact(a, b, b, d, r_n, r_t, mu)
            v_n, v_t = a * p + b * t + r_n, b * p + d * t + r_t
            assert p >= 0.0
            assert min(p, v_n) == pytest.approx(0.0, abs=1e-13)
            assert abs(t) <= mu * p * (1 + 1e-14)
            if state == STICKING:
                assert v_t == pytest.approx(0.0, abs=1e-13)
            elif state != OPEN:
                assert t == pytest.approx(-mu * p * np.sign(v_t), abs=1e-14)
                assert (v_t > 0.0) == (state == FORTH)
            seen.add(state)
        assert seen == {OPEN, STICKING, FORTH, BACK}

    def test_normal_and_tangent_that_move_together(self):
        # v_T = v_N: p + t = 1 with |t| <= mu p; one such point is as good as another.
        p, t, _ = solve_contact(1.0, 1.0, 1.0, 1.0, -1.0, -1.0, 0.5)
        assert p + t == pytest.approx(1.0, rel=1e-14)
        assert abs(t) <= 0.5 * p * (1 + 1e-14)

    def test_painleve_without_any_state_stops_the_approach(self):
        # a - mu |b| < 0 and stuck forces out of the cone: no state fits. Finite and never pulling.
        p, t, _ = solve_contact(1.0, 3.0, 3.0, 10.0, -1.0, 30.0, 0.5)
        assert np.isfinite([p, t]).all()
        assert p >= 0.0
        assert abs(t) <= 0.5 * p + 1e-15

    def test_massless_direction(self):
        assert solve_contact(0.0, 0.0, 0.0, 0.0, -1.0, 1.0, 0.5)[:2] == (0.0, 0.0)


class TestSweeps:
    @pytest.mark.parametrize("smooth", [False, True], ids=["rough", "every third smooth"])
    def test_factor_and_blocks_do_what_the_matrix_does(self, smooth):
        rng = np.random.default_rng(7)
        n = 6
        friction = np.where(np.arange(n) % 3 == 2, 0.0, 0.5) if smooth else np.full(n, 0.5)
        m = n + np.count_nonzero(friction)
        J = np.where(rng.random((m, 14)) < 0.5, rng.standard_normal((m, 14)), 0.0)
        J[np.arange(m), np.arange(m)] += 1.0
        free = rng.standard_normal(m) - 0.5
        problem = ContactProblem(J @ J.T, free, friction, factor=scipy.sparse.csr_array(J)).balanced()
        for sweeps in (1, 3, 10):
            systems = [ContactSystem(problem, storage) for storage in (problem.dense(), problem.coupling, None)]
            told = [system.sweep(sweeps, 0.0) for system in systems if not system.take(np.zeros(m))]
            for system, (made, change) in zip(systems, told, strict=True):
                assert made == sweeps
                assert change == pytest.approx(told[0][1], rel=1e-8, abs=1e-13)
                assert system.forces == pytest.approx(systems[0].forces, abs=1e-12)
                assert system.group.state.tolist() == systems[0].group.state.tolist()
            assert systems[0].forces.any()
            dense, _, factor = systems
            assert dense.op.y == pytest.approx(problem.velocity(dense.forces), abs=1e-12)  # kept up to date
            assert factor.op.x == pytest.approx(problem.factor.T @ factor.forces, abs=1e-12)

    @pytest.mark.parametrize("smooth", [False, True], ids=["rough", "every third smooth"])
    def test_unsymmetric_matrices(self, smooth):
        """By columns, which are not the rows then: velocities are those of the problem, in all storages."""
        rng, n = np.random.default_rng(8), 6
        friction = np.where(np.arange(n) % 3 == 2, 0.0, 0.5) if smooth else np.full(n, 0.5)
        m = n + np.count_nonzero(friction)
        problem = ContactProblem(
            np.eye(m) + 0.1 * rng.standard_normal((m, m)), rng.standard_normal(m) - 0.5, friction
        ).balanced()
        for storage in (problem.dense(), problem.coupling):
            system = ContactSystem(problem, storage)
            system.take(np.zeros(m))
            assert system.sweep(200, 1e-15)[0] < 200
            assert system.forces.any()
            z, active = system.point()
            assert problem.residual(z) <= 1e-13
            assert np.array_equal(z > 1e-13, active == 1)

    def test_long_sweeps_are_made_in_pieces(self, monkeypatch):
        """Between which Python hears Ctrl-C: to rounding the same, and no sweep more."""
        problem = row_of_blocks(40)[0].balanced()
        found, calls = [], []

        def counted(*arguments):
            calls.append(1)
            return sweep_and_renew(*arguments)

        monkeypatch.setattr(system_of_contacts, "sweep_and_renew", counted)
        for at_once in (10**6, 400):
            monkeypatch.setattr(system_of_contacts, "AT_ONCE", at_once)
            system = ContactSystem(problem, None)
            system.take(np.zeros(80))
            assert system.sweep(35, 0.0)[0] == 35
            found.append(system.forces)
        assert len(calls) == 1 + 4
        assert found[1] == pytest.approx(found[0], abs=1e-13)

    def test_small_problems_that_follow_share_their_memory_and_nothing_else(self):
        """Also with other contacts without friction, and unsymmetric: what is found is what it is without memory."""
        rng = np.random.default_rng(9)
        for step in range(12):
            friction = np.where(np.arange(4) == step % 4, 0.0, 0.5)
            matrix = np.eye(7) + 0.1 * rng.standard_normal((7, 7))
            problem = ContactProblem(matrix, rng.standard_normal(7) - 0.5, friction)
            found = BlockGaussSeidel().solve(problem)
            system_of_contacts._kept.systems.clear()
            again = BlockGaussSeidel().solve(problem)
            assert found.solved
            assert found.z.tobytes() == again.z.tobytes()
            assert found.active.tolist() == again.active.tolist()

    def test_uncoupled_contacts_take_one_sweep(self):
        free = np.array([-1.0, -1.0, 2.0, 0.2, 3.0, 0.0])
        system = ContactSystem(ContactProblem(np.eye(6), free, np.full(3, 0.5)), np.eye(6))
        system.take(np.zeros(6))
        assert system.sweep(1, 0.0) == (1, 1.0)
        assert system.forces.tolist() == [1.0, 1.0, 0.0, -0.2, -0.5, 0.0]
        assert system.group.state.tolist() == [STICKING, FORTH, OPEN]
        assert system.sweep(9, 0.0) == (1, 0.0)


class TestContacts:
    @pytest.mark.parametrize("n", [1, 5, 40])
    def test_forces_that_were_chosen_first(self, n):
        sparse, normal, tangential = row_of_blocks(n)
        dense = replace(sparse, delassus=sparse.dense(), factor=None)
        for problem in (sparse, dense):
            solution = BlockGaussSeidel().solve(problem)
            found = problem.forces(solution.z)
            assert solution.status is Status.SOLVED
            assert found[0] == pytest.approx(normal, abs=1e-8)
            assert found[1] == pytest.approx(tangential, abs=1e-8)

    def test_the_basis_found_is_one_for_others(self):
        sparse, *_ = row_of_blocks(30)
        problem = replace(sparse, delassus=sparse.dense(), factor=None)
        solution = BlockGaussSeidel().solve(problem)
        assert solution.active is not None
        warm = Lemke().solve(problem, solution)
        assert warm.route == "basis of the guess"
        assert warm.iterations == 1

    @pytest.mark.parametrize("form", ["dense", "factor"])
    def test_a_warm_start_takes_fewer_sweeps(self, form):
        before, *_ = row_of_blocks(1000)
        if form == "dense":
            before, *_ = row_of_blocks(60)
            before = replace(before, delassus=before.dense(), factor=None)
        first = BlockGaussSeidel().solve(before)
        after = replace(before, free=before.free * (1.0 + 1e-9))
        cold, warm = BlockGaussSeidel().solve(after), BlockGaussSeidel().solve(after, first)
        assert cold.solved
        assert warm.solved
        assert warm.iterations <= cold.iterations
        assert BlockGaussSeidel().solve(before, first).iterations < cold.iterations
        assert warm.z == pytest.approx(cold.z, abs=1e-7)

    def test_a_warm_start_is_matched_by_contact(self):
        problem, normal, tangential = row_of_blocks(200)
        first = BlockGaussSeidel().solve(problem)
        order = np.random.default_rng(1).permutation(200)
        J = scipy.sparse.csr_array(problem.factor)[np.concatenate([order, 200 + order])]
        free = problem.free[np.concatenate([order, 200 + order])]
        shuffled = ContactProblem(None, free, problem.friction[order], tuple(order.tolist()), J)
        cold, warm = BlockGaussSeidel().solve(shuffled), BlockGaussSeidel().solve(shuffled, first)
        assert warm.iterations < cold.iterations
        assert shuffled.forces(warm.z)[0] == pytest.approx(normal[order], abs=1e-8)
        assert shuffled.forces(warm.z)[1] == pytest.approx(tangential[order], abs=1e-8)

    @pytest.mark.parametrize("size", [1e3, 1e9, 1e200])
    @pytest.mark.parametrize("form", ["dense", "factor"])
    def test_a_guess_far_away_does_no_harm(self, form, size):
        problem, normal, _ = row_of_blocks(20)
        if form == "dense":
            problem = replace(problem, delassus=problem.dense(), factor=None)
        cold = BlockGaussSeidel().solve(problem)
        warm = BlockGaussSeidel().solve(problem, replace(cold, z=np.full(problem.size, size)))
        assert warm.solved
        assert problem.forces(warm.z)[0] == pytest.approx(normal, abs=1e-8)

    def test_a_symmetric_lcp_is_contact_without_friction(self):
        problem, z = definite(20, 5)
        solution = BlockGaussSeidel().solve(problem)
        assert solution.solved
        assert solution.z == pytest.approx(z, abs=1e-9)
        with pytest.raises(ModelError, match="unsymmetric"):
            BlockGaussSeidel().solve(Lcp([[1.0, 2.0], [0.0, 1.0]], [-1.0, -1.0]))

    def test_the_limit_is_reported(self):
        problem, *_ = row_of_blocks(1000)
        solution = BlockGaussSeidel(sweep_limit=1).solve(problem)
        assert solution.iterations == 1
        assert solution.status is Status.ITERATION_LIMIT
        assert solution.residual == problem.residual(solution.z)
        assert 0.0 < solution.residual < problem.residual(np.zeros(problem.size))


class TestThousandContacts:
    def test_memory_is_linear_in_the_contacts(self):
        def peak(n):
            problem, normal, _ = row_of_blocks(n)
            BlockGaussSeidel(sweep_limit=8).solve(problem)  # compiles, and fills caches
            tracemalloc.start()
            try:
                solution = BlockGaussSeidel().solve(problem)
                largest = tracemalloc.get_traced_memory()[1]
            finally:
                tracemalloc.stop()
            assert solution.solved
            assert problem.forces(solution.z)[0] == pytest.approx(normal, abs=1e-7)
            return largest

        small, large = peak(500), peak(1000)
        assert large / small < 2.5
        assert large < 2000**2 * 8 / 4  # a quarter of the Delassus matrix that is never formed


def test_forces_that_overflow_are_a_failure_and_no_warning():
    # Forces of 1e400 are beyond the largest number: the sweeps run away, and the correction starts from there.
    M = [[15.1, 11.9, -11.1, 0.7], [11.9, 45.8, -8.0, -15.8], [-11.1, -8.0, 14.9, 10.9], [0.7, -15.8, 10.9, 34.9]]
    problem = Lcp(1e-201 * np.array(M), 1e199 * np.array([4.4, -1.5, 1.3, -6.8]))
    with np.errstate(all="raise"):
        found = BlockGaussSeidel().solve(problem)
    assert not found.solved
