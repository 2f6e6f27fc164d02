"""Newton's method in body velocities on problems of many contacts in space, judged by dense algebra of its own."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from lcpflex.jit.kernel import FloatArray
from lcpflex.jit.struct import allocate
from lcpflex.solvers.contact.algebra import IN_SPACE
from lcpflex.solvers.contact.large.memory import BodyContacts, large_memory
from lcpflex.solvers.contact.large.solving import ROOM, solve_large
from lcpflex.solvers.contact.operators.sparse_factor import widen
from lcpflex.solvers.contact.spatial import SpatialContactProblem
from lcpflex.solvers.status import ITERATION_LIMIT, SOLVED

WIDTH = 6


class Posed:
    """Bodies of six velocities in a grid, random contacts between neighbours and the ground, ball joints on request."""

    def __init__(
        self,
        seed: int,
        bodies: int = 30,
        joints: int = 0,
        smooth: bool = False,
        mass: float = 1.0,
        reach: tuple[int, ...] = (1, 6),
    ) -> None:
        rng = np.random.default_rng(seed)
        pairs = [(b, b - step) for b in range(bodies) for step in reach if b - step >= -1]
        self.n, self.joints, self.bodies = len(pairs), 3 * joints, bodies
        rows = self.joints + 3 * self.n
        scale = np.sqrt(1.0 / (mass * 10.0 ** rng.uniform(-1, 1, bodies)))
        white = np.zeros((rows, 2, WIDTH))
        ends = np.full((rows, 2), -1)
        for k, (i, j) in enumerate(pairs):
            frame, arm = np.linalg.qr(rng.standard_normal((3, 3)))[0], rng.uniform(-1, 1, (2, 3))
            own = (self.joints + k, *(self.joints + self.n + 2 * k + t for t in range(2)))
            self._fill(white, ends, own, (i, j), frame, arm, scale)
        for e in range(joints):
            i = int(rng.integers(1, bodies))
            self._fill(white, ends, range(3 * e, 3 * e + 3), (i, i - 1), np.eye(3), rng.uniform(-1, 1, (2, 3)), scale)
        J = np.zeros((rows, bodies * WIDTH))
        for r in range(rows):
            for side in range(2):
                if ends[r, side] >= 0:
                    J[r, WIDTH * ends[r, side] :][:WIDTH] += white[r, side]
        u = rng.standard_normal(bodies * WIDTH)
        friction = np.zeros(self.n) if smooth else rng.uniform(0.1, 0.9, self.n)
        self.J, self.free, self.friction = J, J @ u, friction
        first = self.joints + self.n
        self.problem: Any = allocate(
            BodyContacts,
            {"rows": rows, "width": WIDTH, "offsets": bodies + 1, "contacts": self.n, "joints": self.joints,
             "bodies": bodies},
            n_contacts=self.n,
            n_joints=self.joints,
            n_bodies=bodies,
            first_contact=self.joints,
            white=white,
            row_body=ends,
            dof=WIDTH * np.arange(bodies + 1),
            free=self.free.copy(),
            terms=np.abs(self.free[self.joints :]),
            normal_row=self.joints + np.arange(self.n),
            tangent_row=np.full(self.n, -1) if smooth else first + 2 * np.arange(self.n),
            friction=friction,
            joint_row=np.arange(self.joints),
            bodies=np.arange(bodies),
            slip=np.zeros(self.n),
        )  # fmt: skip

    @staticmethod
    def _fill(
        white: FloatArray, ends: Any, rows: Any, pair: tuple[int, int], frame: FloatArray, arm: FloatArray, scale: Any
    ) -> None:
        for r, axis in zip(rows, frame, strict=True):
            for side, (b, sign) in enumerate(zip(pair, (1.0, -1.0), strict=True)):
                if b >= 0:
                    ends[r, side] = b
                    white[r, side] = sign * scale[b] * np.concatenate([axis, np.cross(arm[side], axis)])

    def solve(self, **wanted: Any) -> tuple[int, Any]:
        """Status and memory, from what ``problem.p`` and ``memory`` hold."""
        memory: Any = wanted.pop("memory", None)
        if memory is None:
            memory = large_memory(self.bodies, self.n + self.joints, self.bodies, WIDTH, 3)
        memory.judged.tolerance = 1e-10
        for name, value in wanted.items():
            setattr(memory.judged if name == "tolerance" else memory.search, name, value)
        while (status := solve_large(self.problem, memory, IN_SPACE)) == ROOM:
            widen(memory.op.factor)
        return int(status), memory

    def judged(self) -> float:
        """The strict residual of the forces found, joints condensed; of rows that make the Delassus operator here."""
        G = self.J @ self.J.T
        joints = slice(0, self.joints)
        free = self.free.copy()
        if self.joints:
            back = np.linalg.pinv(G[joints, joints], rcond=1e-12, hermitian=True)
            free -= G[:, joints] @ (back @ free[joints])
            G = G - G[:, joints] @ back @ G[joints]
        k = np.arange(self.n)
        first = self.joints + self.n
        order = np.column_stack([self.joints + k, first + 2 * k, first + 2 * k + 1]).ravel()
        problem = SpatialContactProblem(G[np.ix_(order, order)], free[order], self.friction)
        return float(problem.residuals(self.problem.p[order])[1])


@pytest.mark.parametrize("smooth", [False, True])
@pytest.mark.parametrize("joints", [0, 8])
@pytest.mark.parametrize("seed", range(6))
def test_answers_solve_the_posed_problem(seed: int, joints: int, smooth: bool) -> None:
    posed = Posed(seed, joints=joints, smooth=smooth)
    status, memory = posed.solve()
    assert status == SOLVED
    assert memory.judged.residual <= 1e-10
    assert posed.judged() <= 2e-9
    velocity = posed.J[: posed.joints] @ (posed.J.T @ posed.problem.p) + posed.free[: posed.joints]
    assert np.abs(velocity).max(initial=0.0) <= 1e-8


@pytest.mark.parametrize("mass", [1e-9, 1e9])
def test_units_of_mass_change_nothing(mass: float) -> None:
    """The same problem in other units takes the same way, and forces go with the mass."""
    own, other = Posed(3), Posed(3, mass=mass)
    other.problem.free[:] = other.free[:] = own.free
    other.problem.terms[:] = own.problem.terms
    (_, first), (_, second) = own.solve(), other.solve()
    assert (second.newton.factors, second.search.sweeps) == (first.newton.factors, first.search.sweeps)
    np.testing.assert_allclose(other.problem.p, mass * own.problem.p, rtol=1e-6, atol=1e-7 * mass)


def test_its_own_answer_is_taken_at_once() -> None:
    posed = Posed(1)
    _, memory = posed.solve()
    assert memory.search.sweeps > 0
    kept = posed.problem.p.copy()
    status, memory = posed.solve(tolerance=1e-8)
    assert status == SOLVED
    assert memory.search.sweeps == 0
    np.testing.assert_allclose(posed.problem.p, kept, atol=1e-9)


def test_the_best_point_is_kept_where_the_budget_ends() -> None:
    """One factor does not do: what is told is the residual of the point that is returned."""
    posed = Posed(2, bodies=60)
    status, memory = posed.solve(factor_limit=1)
    assert status == ITERATION_LIMIT
    assert memory.newton.factors <= 1
    assert memory.judged.strict > 1e-10
    assert posed.judged() == pytest.approx(memory.judged.strict, rel=0.5)


def test_a_larger_budget_leaves_less() -> None:
    """One that is too small for Newton's method is spent on sweeps."""
    found = []
    for budget in (1, 3, 9):
        _, memory = Posed(2, bodies=60).solve(factor_limit=budget)
        assert memory.newton.factors == 0
        found.append(memory.judged.strict)
    assert found[0] > 3.0 * found[1] > 100.0 * found[2]


def test_sweeps_take_the_place_of_dear_factors() -> None:
    """Bodies tied to others far away: a factor takes as long as a hundred sweeps, and one of the budget is as many."""
    posed = Posed(4, bodies=200, reach=(1, 17, 41, 83))
    status, memory = posed.solve(factor_limit=5, tolerance=1e-9)
    assert status == SOLVED
    assert memory.op.factor.work > 5e7
    assert memory.newton.factors <= 2
    assert memory.search.sweeps > 200
    assert posed.judged() <= 2e-9
