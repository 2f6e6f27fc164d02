"""Large contact problems in body velocities: against dense solvers, in other orders and units, and where none is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse

from lcpflex.solvers import Auto
from lcpflex.solvers.contact.algebra import PLANAR
from lcpflex.solvers.contact.judging import judge
from lcpflex.solvers.contact.large.least import least_impulses
from lcpflex.solvers.contact.large.memory import LargeMemory, grown, large_memory
from lcpflex.solvers.contact.large.solving import ROOM, solve_large
from lcpflex.solvers.contact.operators.sparse_factor import widen
from lcpflex.solvers.contact.strategy import NONE, route_names
from lcpflex.solvers.contact.tracing import trace
from lcpflex.solvers.status import ITERATION_LIMIT, SOLVED
from tests import libs
from tests.islands import Heap, Island, brick_wall, permuted, random_island


def route_of(memory: LargeMemory) -> str:
    """What was tried, in words."""
    return route_names(memory.search, memory.attempts)


def velocity(island: Island) -> np.ndarray:
    return island.free + island.jacobian @ (island.jacobian.T @ island.p)


def load_of(island: Island) -> float:
    return float(np.abs(island.free).max())


def assert_solved(island: Island, strict: float = 1e-8) -> None:
    status, memory = island.solve()
    assert status == SOLVED
    assert memory.judged.residual <= 1e-8
    assert island.residual() == pytest.approx(memory.judged.strict, rel=0.1, abs=1e-12)
    assert memory.judged.strict <= strict
    assert memory.search.route != NONE


@pytest.mark.parametrize("friction", [0.0, 0.1, 0.5, 1.0])
@pytest.mark.parametrize(("bodies", "contacts", "joints"), [(1, 1, 0), (6, 8, 0), (12, 20, 3), (40, 60, 0)])
def test_random_islands(bodies, contacts, joints, friction):
    assert_solved(random_island(5, bodies, contacts, joints, friction))


@pytest.mark.parametrize("joints", [0, 2])
@pytest.mark.parametrize("seed", range(4))
def test_velocities_are_those_of_the_dense_solver(seed, joints):
    """Of little friction there is one answer: in soft directions, a residual of 1e-8 allows for more than that."""
    island = random_island(seed, 10, 14, joints, 0.1, (3, 7))
    assert_solved(island)
    dense = island.contact_problem()
    solution = Auto().solve(dense.lcp())
    forces = np.concatenate(dense.forces(solution.z))
    v = velocity(island)
    np.testing.assert_allclose(
        dense.velocity(forces), np.concatenate([v[:28:2], v[1:28:2]]), rtol=0, atol=1e-6 * load_of(island)
    )


@pytest.mark.parametrize("motion", [0.0, 0.01])
@pytest.mark.parametrize(("rows", "columns"), [(8, 1), (40, 1), (6, 6)])
def test_towers_and_walls_are_solved_to_the_last_digits(rows, columns, motion):
    assert_solved(brick_wall(rows, columns, 0.5, 3, motion))


def test_a_wall_at_rest_stays_so_and_carries_its_weight():
    wall = brick_wall(6, 6)
    assert_solved(wall)
    assert np.abs(velocity(wall)).max() <= 1e-7 * load_of(wall)
    ground = (wall.row_body[::2, 1] < 0).nonzero()[0]
    assert wall.p[2 * ground].sum() == pytest.approx(36 * 20.0 * 9.81e-3, rel=1e-6)


@pytest.mark.parametrize("ratio", [1.0, 1e3])
def test_a_heap_that_settles_is_solved_in_every_step(ratio):
    heap = Heap(30, 0.6, 1, ratio=ratio)
    assert [heap.step() for _ in range(200)] == 200 * [SOLVED]
    assert len(heap.island.friction) >= 25


def test_a_step_at_rest_needs_no_factor():
    wall = brick_wall(6, 6)
    _, memory = wall.solve()
    status, memory = wall.solve(memory)
    assert (status, memory.newton.factors, route_of(memory)) == (SOLVED, 0, "as it was")


@pytest.mark.parametrize("steps", [60, 90, 200])
def test_the_order_of_contacts_and_bodies_does_not_matter(steps):
    heap = Heap(30, 0.6, 2)
    for _ in range(steps):
        heap.step()
    island = replace(heap.island, p=np.zeros(len(heap.island.p)))
    assert_solved(island)
    other, rows = permuted(island, steps)
    assert_solved(other)
    np.testing.assert_allclose(velocity(other), velocity(island)[rows], rtol=0, atol=1e-5 * load_of(island))


@pytest.mark.parametrize(("mass", "length"), [(1e-3, 1.0), (1.0, 1e3), (1e-10, 1e3), (1e12, 1e-6)])
def test_units_change_nothing(mass, length):
    """Rows of contacts in other units of mass and length: v by length, p by mass x length, J by 1 / sqrt(mass)."""
    wall = brick_wall(5, 4, 0.4, 1, 0.02)
    root = np.sqrt(mass)
    other = replace(
        wall, white=wall.white / root, free=wall.free * length, terms=wall.terms * length, p=np.zeros(len(wall.p))
    )
    status, memory = wall.solve()
    again, told = other.solve()
    assert (again, route_of(told), told.newton.factors) == (status, route_of(memory), memory.newton.factors)
    assert told.judged.residual == pytest.approx(memory.judged.residual, rel=1e-2, abs=1e-13)
    np.testing.assert_allclose(other.p / (mass * length), wall.p, rtol=0, atol=1e-6 * np.abs(wall.p).max())


def test_a_contact_that_is_there_twice_shares_its_load():
    wall = brick_wall(4, 3, 0.5, 2, 0.02)
    twice = replace(
        wall,
        white=np.concatenate([wall.white, wall.white]),
        row_body=np.concatenate([wall.row_body, wall.row_body]),
        free=np.tile(wall.free, 2),
        terms=np.tile(wall.terms, 2),
        friction=np.tile(wall.friction, 2),
        p=np.zeros(2 * len(wall.p)),
    )
    assert_solved(wall)
    assert_solved(twice)
    np.testing.assert_allclose(velocity(twice)[: len(wall.p)], velocity(wall), rtol=0, atol=1e-6 * load_of(wall))


def test_redundant_joints():
    island = random_island(3, 8, 10, 4, 0.2)
    rows = np.arange(20, 28)
    twice = replace(
        island,
        white=np.concatenate([island.white, island.white[rows]]),
        row_body=np.concatenate([island.row_body, island.row_body[rows]]),
        free=np.concatenate([island.free, island.free[rows]]),
        terms=np.concatenate([island.terms, island.terms[rows]]),
        p=np.zeros(36),
    )
    assert_solved(island)
    assert_solved(twice)
    np.testing.assert_allclose(velocity(twice)[:28], velocity(island), rtol=0, atol=1e-6 * load_of(island))


def test_nothing_to_solve():
    island = random_island(0, 3, 0)
    status, memory = island.solve()
    assert (status, memory.judged.residual, memory.judged.strict) == (SOLVED, 0.0, 0.0)


def test_bodies_without_contacts_and_contacts_of_bodies_elsewhere():
    """Bodies that are not of the island count as held: they are neither read nor moved."""
    island = random_island(2, 6, 9)
    only = ((island.row_body == 2) | (island.row_body < 0)).all(axis=1)  # nothing could stop such a contact
    island.free[only] = np.abs(island.free[only])
    alone = replace(island, row_body=np.where(island.row_body == 2, -1, island.row_body), p=np.zeros(18))
    problem, held = island.problem(), alone.problem()
    kept = np.array([0, 1, 3, 4, 5])
    problem.bodies[:5] = kept
    problem.n_bodies = 5
    for given in (problem, held):
        memory = large_memory(6, 9, 6, 3, 2)
        assert solve_large(given, memory, PLANAR) in (SOLVED, ROOM)
        if memory.op.factor.room_values:
            assert solve_large(given, grown(memory, {}), PLANAR) == SOLVED
    np.testing.assert_allclose(island.p, alone.p, rtol=0, atol=1e-6)


@pytest.mark.parametrize("friction", [0.5, 2.0])
def test_a_rod_that_cannot_slide_on_is_not_called_solved(friction):
    """Painleve: at mu = 2 the tip is driven into the floor the more it is pushed; no impulse ends the approach."""
    angle = np.radians(70.0)
    x, y = 0.5 * np.cos(angle), 0.5 * np.sin(angle)
    turn = np.sqrt(12.0)  # of a rod of 1 kg and 1 m, per root of its inertia
    white = np.array([[[0.0, 1.0, -x * turn], [0.0, 0.0, 0.0]], [[1.0, 0.0, y * turn], [0.0, 0.0, 0.0]]])
    slides = np.array([-0.1, 3.0])
    rod = Island(white, np.array([[0, -1], [0, -1]]), np.array([3]), slides, np.array([friction]), np.abs(slides))
    status, memory = rod.solve()
    problem = rod.contact_problem()
    assert memory.judged.strict == pytest.approx(rod.residual(), abs=1e-12)
    if status == SOLVED:
        z = problem.unknowns(rod.p[:1], rod.p[1:])
        assert problem.residual(z) <= 1e-8
    else:
        assert memory.judged.strict > 1e-8


def test_no_answer_is_told_with_its_residual():
    """Two joints that ask for different velocities of one body."""
    island = random_island(1, 1, 0, 1)
    island = Island(
        np.repeat(island.white[:1], 2, axis=0),
        np.repeat(island.row_body[:1], 2, axis=0),
        island.size,
        np.array([1.0, -1.0]),
        island.friction,
        np.ones(2),
    )
    status, memory = island.solve()
    assert status == ITERATION_LIMIT
    assert memory.judged.strict == pytest.approx(1.0, rel=0.5)
    assert np.isfinite(island.p).all()


def test_the_budget_ends_it_in_the_best_point():
    wall = brick_wall(10, 8, 0.5, 3, 0.05)
    status, memory = wall.solve(factor_limit=3)
    assert status == ITERATION_LIMIT
    assert memory.newton.factors <= 3
    assert 1e-8 < memory.judged.strict < 1.0
    assert wall.residual() == pytest.approx(memory.judged.strict, rel=1e-3)


@pytest.mark.parametrize("place", ["free", "white"])
@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_what_is_not_finite_is_not_solved(value, place):
    """Nor is the answer to the problem before, which the memory holds, given for one."""
    wall = brick_wall(3, 3)
    _, memory = wall.solve()
    assert wall.p.any()
    getattr(wall, place).flat[0] = value
    wall.p[:] = 0.0
    status, memory = wall.solve(memory)
    assert status == ITERATION_LIMIT
    assert not memory.judged.strict <= 1e-8
    assert memory.judged.residual == np.inf
    assert not wall.p.any()


def test_a_residual_that_rounding_hides_solves_nothing():
    """A row far beyond the others: what is lost in the sum of its terms is more than the free velocities."""
    wall = brick_wall(4, 3, 0.5, 2, 0.02)
    wall.white[0, 0, 0] = -1e160
    status, memory = wall.solve()
    assert memory.judged.residual == np.inf
    assert status == ITERATION_LIMIT


def test_two_runs_give_the_same_bits():
    first, second = (brick_wall(10, 5, 0.4, 7, 0.05) for _ in range(2))
    first.solve()
    second.solve()
    assert first.p.tobytes() == second.p.tobytes()


def shortened(problem, memory):
    """The status of least_impulses, given the room that it asks for."""
    while (status := least_impulses(problem, memory)) == ROOM:
        widen(memory.apart)
    return status


@pytest.mark.parametrize("motion", [0.0, 0.002])
@pytest.mark.parametrize(("rows", "columns"), [(2, 1), (4, 3), (6, 6)])
def test_least_impulses_are_those_of_a_quadratic_program(rows, columns, motion):
    wall = brick_wall(rows, columns, 0.5, 1, motion)
    status, memory = wall.solve()
    assert status == SOLVED
    problem, found, J = wall.problem(), wall.p.copy(), wall.jacobian
    v = velocity(wall)
    assert shortened(problem, memory) == SOLVED
    np.testing.assert_allclose(velocity(wall), v, rtol=0, atol=3e-8 * load_of(wall))
    assert wall.residual() <= 3e-8
    n = len(wall.friction)
    slides = np.where(np.abs(v[1::2]) > 1e-6 * load_of(wall), -np.sign(v[1::2]), 0.0)
    cone = np.zeros((3 * n, 2 * n))
    k = np.arange(n)
    cone[k, 2 * k] = -1.0
    for row, sign in ((n + k, 1.0), (2 * n + k, -1.0)):
        cone[row, 2 * k], cone[row, 2 * k + 1] = -0.5, sign
    edge = np.zeros((n, 2 * n))
    edge[k, 2 * k], edge[k, 2 * k + 1] = -0.5 * slides, 1.0
    equal = np.vstack([J.T, edge[slides != 0.0]])
    right = np.concatenate([J.T @ found, np.zeros((slides != 0.0).sum())])
    least = libs.qpsolvers.solve_qp(
        scipy.sparse.csc_matrix(np.eye(2 * n)),
        np.zeros(2 * n),
        scipy.sparse.csc_matrix(cone),
        np.zeros(3 * n),
        scipy.sparse.csc_matrix(equal),
        right,
        solver="clarabel",
    )
    np.testing.assert_allclose(wall.p, least, rtol=0, atol=1e-4 * np.abs(least).max())


def test_the_path_finds_what_newton_does_not():
    """From a point with a residual of 1e-3: contacts change their states one by one until it solves the problem."""
    wall = brick_wall(6, 5, 0.5, 3, 0.05)
    status, memory = wall.solve()
    assert status == SOLVED
    rng = np.random.default_rng(0)
    op, group, judged, best = memory.op, memory.group, memory.judged, memory.best
    group.p[: group.n] = best.p[: group.n] * (1.0 + 1e-2 * rng.normal(size=(group.n, 1)))
    before = judge(op, group, judged, group.p, PLANAR)
    best.worst = before
    for eps in (1e-3, 1e-4, 1e-5, 1e-6):
        assert trace(op, group, judged, best, memory.newton, eps, 400, PLANAR)
    assert judge(op, group, judged, group.p, PLANAR) <= 1e-5 * before
    assert best.worst <= 1e-6 * judged.load


def test_friction_that_wedges_more_with_every_sweep_is_begun_afresh():
    """Impulses of the last step that are a thousand times too large are let go."""
    heap = Heap(30, 0.6, 3, friction=1.0)
    for _ in range(120):
        assert heap.step() == SOLVED
    heap.island.p[:] *= 1e6
    assert_solved(heap.island)


@pytest.mark.parametrize(("rows", "columns"), [(300, 1), (12, 12)])
def test_where_all_stick_the_convex_law_is_a_start_from_nothing(rows, columns):
    wall = brick_wall(rows, columns)
    status, memory = wall.solve()
    assert (status, route_of(memory)) == (SOLVED, "sweeps > Newton > convex law > Newton")
    assert memory.newton.factors <= 100
    assert memory.judged.strict <= 1e-8


@pytest.mark.parametrize("size", [1e10, 1e200, np.inf, np.nan])
def test_a_start_that_leads_nowhere_is_not_taken(size):
    wall = brick_wall(6, 5, 0.5, 3, 0.02)
    wall.p[:] = size * np.random.default_rng(0).normal(size=len(wall.p))
    assert_solved(wall)
