"""Spatial body kernels against dense linear algebra, and against the places of point masses in time."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
import pytest

from lcpflex.dynamics import mechanics as leaves
from lcpflex.dynamics.mass_matrix import elastic_matrices, mass_matrix, overbent, slowest_vibrations
from lcpflex.dynamics.spatial import mechanics as space
from lcpflex.dynamics.spatial.body_forces import momenta
from lcpflex.dynamics.spatial.inertia import factors
from lcpflex.jit.kernel import FloatArray
from lcpflex.kinematics.configuration import advance
from lcpflex.kinematics.spatial.rotations import axes_at
from tests.spatial_bodies import MassBody, Mechanics, any_state, mechanics, random_body, spatial_model

GRAVITY = (1.3, -2.0, -9.81)


def some_bodies(rng: np.random.Generator) -> list[MassBody]:
    """Rigid and flexible ones, in mean frames and in others, with all products and with some."""
    return [
        random_body(rng, 0),
        random_body(rng, 5),
        random_body(rng, 0, centred=True),
        random_body(rng, 6, centred=True),
        random_body(rng, 7, second_modes=3),
        random_body(rng, 4, second_modes=0),
    ]


class Case:
    """Bodies at some state."""

    def __init__(self, seed: int = 3, bodies: list[MassBody] | None = None) -> None:
        self.rng = np.random.default_rng(seed)
        self.bodies = some_bodies(self.rng) if bodies is None else bodies
        self.plain = spatial_model(self.bodies, GRAVITY)
        self.q, self.u = any_state(self.rng, self.plain)
        made: Mechanics = mechanics(self.plain, self.q, self.u)
        self.model: Any = made.model
        self.work: Any = made.work

    def nodes(self, b: int, q: FloatArray) -> FloatArray:
        """Places of the nodes of body b, world axes."""
        i = int(self.plain.bodies.place[b])
        body = self.bodies[b]
        s = body.places + np.einsum("k,kni->ni", q[i + 7 : i + 7 + body.n], body.shapes)
        return np.asarray(q[i : i + 3] + s @ axes_at(q, i).T)

    def moved(self, q: FloatArray, u: FloatArray, h: float) -> FloatArray:
        out = np.zeros(len(q))
        advance(self.model, q, u, h, out)
        return out

    def velocities(self, b: int, q: FloatArray, u: FloatArray) -> FloatArray:
        """Of the nodes, by differences of eighth order."""
        weights = {1: 4 / 5, 2: -1 / 5, 3: 4 / 105, 4: -1 / 280}
        h = 2e-3
        total = sum(
            w * (self.nodes(b, self.moved(q, u, j * h)) - self.nodes(b, self.moved(q, u, -j * h)))
            for j, w in weights.items()
        )
        return np.asarray(total / h)

    def full(self) -> list[int]:
        """Bodies with all products."""
        return [b for b, body in enumerate(self.bodies) if body.second_modes is None]


@pytest.fixture(scope="module")
def case() -> Case:
    return Case()


def test_mass_matrix_is_that_of_the_nodes(case: Case) -> None:
    M = mass_matrix(case.plain, case.q)  # type: ignore[arg-type]
    dof = case.plain.bodies.dof
    for b in case.full():
        units = np.eye(dof[-1])[dof[b] : dof[b + 1]]
        L = np.array([case.velocities(b, case.q, e) for e in units])
        own = np.einsum("ami,mn,bni->ab", L, case.bodies[b].mass, L)
        np.testing.assert_allclose(M[dof[b] : dof[b + 1], dof[b] : dof[b + 1]], own, rtol=0, atol=2e-11)


@pytest.mark.parametrize(("alpha_c", "alpha_k"), [(0.0, 0.0), (0.4, 0.7)])
def test_factors_invert_the_matrix(case: Case, alpha_c: float, alpha_k: float) -> None:
    M = mass_matrix(case.plain, case.q)  # type: ignore[arg-type]
    K, C = elastic_matrices(case.plain, case.q)  # type: ignore[arg-type]
    right, out = case.rng.normal(size=len(case.u)), np.zeros(len(case.u))
    leaves.factorise(case.model, case.q, alpha_c, alpha_k, case.work)
    leaves.multiply(case.model, case.q, right, case.work, out)
    np.testing.assert_allclose(out, M @ right, rtol=0, atol=1e-13)
    x = right.copy()
    leaves.solve_vector(case.model, case.work, x)
    np.testing.assert_allclose((M + alpha_c * C + alpha_k * K) @ x, right, rtol=0, atol=1e-12)


def test_rows_are_solved_and_whitened() -> None:
    bodies = [random_body(np.random.default_rng(1), n, centred) for n, centred in ((0, True), (3, False), (5, True))]
    case = Case(5, bodies)
    rows, dof = 3, case.plain.bodies.dof
    laid: Any = _Rows(case.work, rows, int(np.diff(dof).max()))
    for r in range(rows):
        laid.body[r] = (r, (r + 1) % 3) if r else (0, -1)
        for i, b in enumerate(laid.body[r]):
            if b >= 0:
                laid.J[r, i, : dof[b + 1] - dof[b]] = case.rng.normal(size=dof[b + 1] - dof[b])
    leaves.factorise(case.model, case.q, 0.2, 0.3, case.work)
    space.solve_rows.py_func(case.model, laid, 0, rows)
    space.whiten_rows.py_func(case.model, laid, 0, rows)
    flat, solved, white = (_scattered(part, laid.body, dof) for part in (laid.J, laid.solved, laid.white))
    K, C = elastic_matrices(case.plain, case.q)  # type: ignore[arg-type]
    A = mass_matrix(case.plain, case.q) + 0.2 * C + 0.3 * K  # type: ignore[arg-type]
    np.testing.assert_allclose(solved @ A, flat, rtol=0, atol=1e-12)
    np.testing.assert_allclose(white @ white.T, flat @ np.linalg.solve(A, flat.T), rtol=0, atol=1e-12)


class _Rows:
    """Rows with the factors of a workspace."""

    def __init__(self, work: Any, rows: int, width: int) -> None:
        self.arrow = work.rows.arrow
        self.body = np.full((rows, 2), -1)
        self.J, self.solved, self.white = (np.zeros((rows, 2, width)) for _ in range(3))


def _scattered(rows: FloatArray, row_body: Any, dof: Any) -> FloatArray:
    """Rows by body block as rows over all velocities."""
    flat = np.zeros((len(rows), dof[-1]))
    for r, bodies in enumerate(row_body):
        for i, b in enumerate(bodies):
            if b >= 0:
                flat[r, dof[b] : dof[b + 1]] += rows[r, i, : dof[b + 1] - dof[b]]
    return flat


def test_energies_and_momenta_are_those_of_the_nodes(case: Case) -> None:
    q, u, g = case.q, case.u, np.array(GRAVITY)
    out = np.zeros((len(case.bodies), 9))
    momenta(case.model.bodies, q, u, case.work.rows.arrow, out)
    kinetic, elastic, weight = leaves.energies(case.model, q, u, case.work)
    M = mass_matrix(case.plain, q)  # type: ignore[arg-type]
    assert kinetic == pytest.approx(0.5 * u @ M @ u, rel=1e-13)
    expected_weight = 0.0
    for b, body in enumerate(case.bodies):
        r, weights = case.nodes(b, q), body.mass.sum(axis=0)
        expected_weight -= float(g @ (weights @ r))
        np.testing.assert_allclose(out[b, 6:], weights @ r / weights.sum(), rtol=0, atol=1e-13)
    for b in case.full():
        r, v, mass = case.nodes(b, q), case.velocities(b, q, u), case.bodies[b].mass
        spin = np.einsum("mn,mni->i", mass, np.cross(r[:, None, :], v[None, :, :]))
        np.testing.assert_allclose(out[b, :3], mass.sum(axis=0) @ v, rtol=0, atol=1e-10)
        np.testing.assert_allclose(out[b, 3:6], spin, rtol=0, atol=1e-10)
    assert weight == pytest.approx(expected_weight, rel=1e-13)
    stiffness = [(body.stiffness, int(i) + 7) for body, i in zip(case.bodies, case.plain.bodies.place, strict=False)]
    assert elastic == pytest.approx(sum(0.5 * float(k @ q[i : i + len(k)] ** 2) for k, i in stiffness), rel=1e-13)


def test_products_beyond_n2_are_left_out_of_energy_and_forces_alike(case: Case) -> None:
    """Power of inertial forces = rate of the kinetic energy, whatever products count: T is one quadratic form."""
    q, u = case.q, case.u
    still = np.zeros(len(u))
    leaves.forces(case.model, 0.0, q, u, case.work)
    M = mass_matrix(case.plain, q)  # type: ignore[arg-type]
    push = case.work.rows.arrow.spin.copy()
    accelerations = np.linalg.solve(M, push)
    h = 1e-4

    def kinetic(j: int) -> float:
        moved = u + j * h * accelerations
        return float(
            leaves.energies(case.model, case.moved(q, u + 0.5 * j * h * accelerations, j * h), moved, case.work)[0]
        )

    slope = (8 * (kinetic(1) - kinetic(-1)) - (kinetic(2) - kinetic(-2))) / (12 * h)
    assert abs(slope) < 1e-7
    assert np.abs(push).max() > 0.1
    leaves.forces(case.model, 0.0, q, still, case.work)
    assert not case.work.rows.arrow.spin.any()


def test_elastic_matrices_periods_and_kinds(case: Case) -> None:
    K, C = elastic_matrices(case.plain, case.q)  # type: ignore[arg-type]
    leaves.forces(case.model, 0.0, case.q, case.u, case.work)
    place, dof = case.plain.bodies.place.tolist(), case.plain.bodies.dof.tolist()
    modal = np.concatenate([case.q[i + 7 : j] for i, j in itertools.pairwise(place)])
    where = np.concatenate([np.arange(i + 6, j) for i, j in itertools.pairwise(dof)])
    np.testing.assert_allclose(case.work.free.dissipative, -C @ case.u, rtol=0, atol=1e-14)
    push = case.work.free.conservative - case.work.rows.arrow.spin
    weight = np.zeros(len(case.u))
    for b, body in enumerate(case.bodies):
        d, i, w = case.plain.bodies.dof[b], case.plain.bodies.place[b], body.mass.sum(axis=0)
        force = axes_at(case.q, i).T @ GRAVITY
        s = body.places + np.einsum("k,kni->ni", case.q[i + 7 : i + 7 + body.n], body.shapes)
        weight[d : d + 3] = w.sum() * np.array(GRAVITY)
        weight[d + 3 : d + 6] = np.cross(w @ s, force)
        weight[d + 6 : d + 6 + body.n] = np.einsum("n,kni,i->k", w, body.shapes, force)
    expected = weight.copy()
    expected[where] -= np.diag(K)[where] * modal
    np.testing.assert_allclose(push, expected, rtol=0, atol=1e-12)
    periods = [2 * np.pi / np.sqrt(body.stiffness.min()) if body.n else 0.0 for body in case.bodies]  # type: ignore[union-attr]
    np.testing.assert_allclose(slowest_vibrations(case.plain.bodies), periods)  # type: ignore[arg-type]
    assert overbent(case.plain, case.q) == []  # type: ignore[arg-type]


def test_interpreted_kernels_are_the_compiled_ones(case: Case) -> None:
    from lcpflex.dynamics.spatial import body_forces, inertia

    other: Any = factors(case.plain.bodies)  # type: ignore[arg-type]
    same = np.zeros(len(case.u))
    inertia.deform_anew.py_func(case.plain.bodies, case.q, 1, other)
    for b in range(len(case.bodies)):
        kernel = body_forces.flexible_inertia if case.bodies[b].n else body_forces.rigid_inertia
        kernel.py_func(case.plain.bodies, case.q, case.u, b, other, same)
    leaves.forces(case.model, 0.0, case.q, case.u, case.work)
    np.testing.assert_allclose(case.work.rows.arrow.spin, same, rtol=0, atol=1e-13)
