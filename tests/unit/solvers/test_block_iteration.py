"""One iteration over any operator and any law, in the plane and in space."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from lcpflex.jit.kernel import FloatArray
from lcpflex.jit.struct import allocate
from lcpflex.solvers.contact.algebra import IN_SPACE, PLANAR, Vector
from lcpflex.solvers.contact.group import Group
from lcpflex.solvers.contact.judging import Judged, is_good, judge, measure_loads, weigh
from lcpflex.solvers.contact.laws import BILATERAL, COULOMB, HALF_LINE
from lcpflex.solvers.contact.operators import begin
from lcpflex.solvers.contact.operators.blocks import Blocks
from lcpflex.solvers.contact.operators.bodies import Bodies
from lcpflex.solvers.contact.operators.dense import Dense
from lcpflex.solvers.contact.operators.factor import Factor
from lcpflex.solvers.contact.operators.scene import scene_rows
from lcpflex.solvers.contact.operators.sparse_factor import sparse_factor
from lcpflex.solvers.contact.sweeping import sweep

LIKE: dict[int, Vector] = {2: PLANAR, 3: IN_SPACE}
WIDTH = {2: 3, 3: 6}  # velocities of a body
STORAGES = ("bodies", "dense", "blocks", "factor")
STORED = [(rows, storage) for rows in (2, 3) for storage in STORAGES] + [(3, "scene")]  # of which there is none in 2


class Problem:
    """Random units between some bodies: rows of J by body, scaled to a largest diagonal entry of 1."""

    def __init__(self, rows: int, n: int, seed: int, laws: tuple[int, ...] = (COULOMB,)) -> None:
        random = np.random.default_rng(seed)
        bodies, width = max(2, n), WIDTH[rows]
        self.n, self.rows, self.bodies = n, rows, bodies
        self.body = np.full((n, 2), -1)
        self.J = np.zeros((n, 2, rows, width))
        for k in range(n):
            self.body[k] = random.permutation(bodies + 1)[:2] - 1
            self.J[k] = random.normal(size=(2, rows, width)) * (self.body[k] >= 0)[:, None, None]
        full = np.zeros((n, rows, bodies, width))
        for k in range(n):
            for side in range(2):
                if self.body[k, side] >= 0:
                    full[k, :, self.body[k, side]] += self.J[k, side]
        scale = np.einsum("krbw,krbw->kr", full, full).max(axis=1) ** -0.5
        self.J *= scale[:, None, None, None]
        self.factor = (full * scale[:, None, None, None]).reshape(n * rows, -1)
        self.W = self.factor @ self.factor.T
        self.free = (self.factor @ random.normal(size=self.factor.shape[1])).reshape(
            n, rows
        )  # of a motion of the bodies
        self.mu = random.uniform(0.0, 1.0, n)
        self.law = np.array(laws)[np.arange(n) % len(laws)]

    @property
    def group(self) -> Group:
        """Its units, without forces."""
        n, rows = self.n, self.rows
        group = allocate(Group, {"units": n, "rows": rows, "block": rows * rows})
        group.n = n
        group.law[:], group.mu[:], group.unit[:], group.free[:] = self.law, self.mu, 1.0, self.free
        group.load[:] = np.abs(self.free).max(axis=1)
        for k in range(n):
            own = slice(rows * k, rows * (k + 1))
            group.own[k] = self.W[own, own].ravel()
        return group

    def operator(self, storage: str) -> Any:
        """W as it is stored."""
        n, rows = self.n, self.rows
        row = np.arange(n * rows).reshape(n, rows)
        if storage == "bodies":
            width = WIDTH[rows]
            sizes = {"offsets": self.bodies + 1, "unknowns": self.bodies * width}
            factor = sparse_factor({"bodies": self.bodies, "units": n, "unknowns": self.bodies * width})
            op = allocate(Bodies, sizes, body=self.body, J=self.J, factor=factor)
            op.n_bodies, op.n_unknowns = self.bodies, self.bodies * width
            op.pos[:] = width * np.arange(self.bodies + 1)
            return op
        if storage == "scene":
            order = np.concatenate([np.arange(n), *(n + 2 * np.arange(n)[:, None] + [0, 1])])
            laid = np.zeros((n * rows, 2, WIDTH[rows]))
            laid[order] = np.concatenate([self.J[:, :, 0], *self.J[:, :, 1:].swapaxes(1, 2)])
            row_body = np.concatenate([self.body, np.repeat(self.body, 2, axis=0)])
            scene = scene_rows(n, laid, laid.copy(), row_body, WIDTH[rows] * np.arange(self.bodies + 1))
            scene.normal[:], scene.tangent[:] = np.arange(n), n + 2 * np.arange(n)
            return scene
        if storage == "dense":
            sizes = {"matrix": n * rows, "unknowns": n * rows}
            dense = allocate(Dense, sizes, symmetric=1, columns=self.W.T.copy(), row=row, free=self.free.ravel())
            dense.m = n * rows
            return dense
        if storage == "blocks":
            block = self.W.reshape(n, rows, n, rows).transpose(0, 2, 1, 3).reshape(n * n, rows * rows).copy()
            first, other = n * np.arange(n + 1), np.tile(np.arange(n), n)
            return allocate(Blocks, {"units": n, "rows": rows}, symmetric=1, first=first, other=other, block=block)
        m, columns = self.factor.shape
        place, value = np.tile(np.arange(columns), m), self.factor.ravel().copy()
        first = columns * np.arange(m + 1)
        return allocate(Factor, {"columns": columns}, row=row, first=first, place=place, value=value)

    def miss(self, p: FloatArray) -> float:
        """What is left of the laws, by numpy alone."""
        v = (self.W @ p.ravel()).reshape(p.shape) + self.free
        left = []
        for k in range(self.n):
            tangents = slice(1, None)
            if self.law[k] == BILATERAL:
                left.append(np.abs(v[k]).max())
                continue
            left.append(abs(min(p[k, 0], v[k, 0])))
            radius = self.mu[k] * max(p[k, 0], 0.0) if self.law[k] == COULOMB else 0.0
            point = p[k, tangents] - v[k, tangents]
            size = np.linalg.norm(point)
            nearest = point * min(1.0, radius / size) if size > 0.0 else point
            left.append(np.abs(p[k, tangents] - nearest).max())
        return float(max(left))


def swept(problem: Problem, storage: str, count: int = 3000) -> tuple[Group, Any, int]:
    """The group after sweeps from nothing, the operator, and how many there were."""
    group, op, like = problem.group, problem.operator(storage), LIKE[problem.rows]
    begin(op, group, group.p, like)
    made, _ = sweep(op, group, like, count, 1e-13)
    return group, op, made


@pytest.mark.parametrize("rows", [2, 3])
@pytest.mark.parametrize("laws", [(COULOMB,), (COULOMB, HALF_LINE), (BILATERAL, COULOMB)], ids=str)
def test_all_operators_come_to_the_same_forces(rows: int, laws: tuple[int, ...]) -> None:
    """Which obey the laws, whoever asks."""
    problem = Problem(rows, 8, seed=3, laws=laws)
    found = {storage: swept(problem, storage) for of, storage in STORED if of == rows}
    first = found["bodies"][0].p
    assert problem.miss(first) <= 1e-11
    for group, _, made in found.values():
        assert made < 3000
        assert group.p == pytest.approx(first, abs=1e-11)


@pytest.mark.parametrize(("rows", "storage"), STORED)
def test_what_is_left_is_judged_as_numpy_does(rows: int, storage: str) -> None:
    """Of forces in the midst of an iteration: the largest miss, the velocities, and the share of each contact."""
    problem = Problem(rows, 7, seed=8)
    group, op, _ = swept(problem, storage, count=1)
    judged = Judged()
    judged.tolerance = 1e-9
    measure_loads(group, judged)
    worst = judge(op, group, judged, group.p, LIKE[rows])
    assert group.y == pytest.approx((problem.W @ group.p.ravel()).reshape(7, rows) + problem.free, abs=1e-13)
    if rows == 2:  # in space the certificate is the natural map of the cone, which is another number
        assert worst == pytest.approx(problem.miss(group.p), rel=1e-9)
    weigh(op, group, judged, group.p, LIKE[rows])
    assert judged.strict == pytest.approx(worst / judged.load)
    assert 0.0 < judged.residual <= judged.strict
    assert judged.missed >= judged.strict * 0.1
    assert not is_good(judged)


@pytest.mark.parametrize(("rows", "storage"), STORED)
def test_solved_forces_are_good(rows: int, storage: str) -> None:
    """And so they are for a contact that is not loaded itself."""
    problem = Problem(rows, 7, seed=6)
    problem.free[3] = 0.0
    group, op, _ = swept(problem, storage)
    judged = Judged()
    judged.tolerance = 1e-9
    measure_loads(group, judged)
    weigh(op, group, judged, group.p, LIKE[rows])
    assert is_good(judged)
    assert judged.residual <= 1e-12


def test_a_force_that_is_not_finite_is_loud() -> None:
    """NaN in one force of one contact."""
    for rows in (2, 3):
        problem = Problem(rows, 5, seed=7)
        group, op, _ = swept(problem, "bodies")
        group.p[2, 1] = np.nan
        judged = Judged()
        measure_loads(group, judged)
        weigh(op, group, judged, group.p, LIKE[rows])
        assert judged.residual == judged.strict == judged.missed == np.inf
